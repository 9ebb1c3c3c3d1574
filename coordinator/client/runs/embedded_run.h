// The work of `run`: a coordinator in this process, workers as its children, and the dataset, which
// grows in the folder until the study has ended or the run is stopped.
//
// Every step can be repeated: if the run is killed at any moment, starting it again continues from
// what is durable.
#pragma once

#include <cstdint>
#include <memory>
#include <set>
#include <string>

#include "common/base/status.h"
#include "coordinator/client/app.h"
#include "coordinator/client/connection.h"
#include "coordinator/client/content/machine_check.h"
#include "coordinator/client/interrupt.h"
#include "coordinator/client/runs/archive_sync.h"
#include "coordinator/client/runs/embedded_coordinator.h"
#include "coordinator/client/runs/follow.h"
#include "coordinator/client/runs/out_dir.h"
#include "coordinator/client/runs/study_results.h"
#include "coordinator/client/runs/worker_pool.h"
#include "coordinator/client/views/run_report.h"
#include "parallax/v1/study.pb.h"

namespace parallax::client {

struct EmbeddedRunOptions {
  v1::StudySpec study;
  int workers = 1;
  MachineOptions machine;  // Passed to the workers.
  std::string store_dir;   // Folder of database and store (ChooseStore); empty: the dataset's own.
  std::string page;        // "HOST:PORT" of the web page while it runs; empty: no page.
  bool json = false;       // Standard output is for JSON; progress goes to stderr.
};

class EmbeddedRun {
 public:
  // Opens all parts, and finds or submits the study; starts no worker yet. `out_dir` and
  // `environment` must outlive the run. Errors: those of the parts.
  static absl::StatusOr<std::unique_ptr<EmbeddedRun>> Open(const EmbeddedRunOptions& options,
                                                           const OutDir& out_dir,
                                                           Environment& environment);

  // Works until the study has ended; its final state is in the report. Errors: kCancelled after an
  // interrupt, once workers are drained, with the progress in the message; kResourceExhausted or
  // kPermissionDenied if the disk refuses; kInternal for workers that keep crashing.
  absl::StatusOr<RunReport> Work();

  // Returns what was put aside because the study has changed, a text each.
  const std::vector<std::string>& set_aside() const { return archive_->writer().set_aside(); }
  // Returns the page's address with its one-time code; empty without a page.
  const std::string& page_link() const { return page_link_; }

 private:
  EmbeddedRun(const EmbeddedRunOptions& options, const OutDir& out_dir, Environment& environment);

  // Finds the study among those of this folder, or submits it. Errors: the connection's.
  absl::StatusOr<v1::StudyStatus> SubmitStudy();
  absl::Status EnterStudy();
  absl::Status StandAlone();  // Pauses other studies of this store.
  absl::Status StartWorkers();
  absl::Status Loop();
  absl::Status Step(double now_s);
  // Prints notes on failed jobs. Returns an error for one that makes it pointless to go on.
  absl::Status ShowProblems();
  void Note(const std::string& place, const std::string& error);
  void Drain(bool hurry);
  absl::Status CatchUp(double now_s, bool last);
  // Describes how far a stopped run came and how to continue it.
  std::string Progress() const;

  const EmbeddedRunOptions options_;
  const OutDir& out_dir_;
  const std::string store_dir_;
  Environment& environment_;
  std::unique_ptr<ArchiveSync> archive_;
  std::unique_ptr<StudyResults> results_;
  std::unique_ptr<EmbeddedCoordinator> coordinator_;
  std::unique_ptr<Connection> connection_;
  std::unique_ptr<WorkerPool> pool_;
  InterruptScope interrupts_;
  ProgressDisplay display_;
  ProgressView view_{/*workers_come_s=*/10};
  std::string page_link_;
  int64_t study_id_ = 0;
  int64_t fresh_before_ = 0;  // Pairs rendered for this study by earlier runs.
  double indexed_s_ = 0;      // When index and card were last written.
  std::set<std::string> shown_problems_;
};

// Checks a job's error for causes that neither a retry nor another worker can mend. Errors:
// kResourceExhausted if the disk is full or cannot be written.
absl::Status CheckDiskError(const std::string& error);

// Checks the error of a job of a run after `attempts` attempts for a limit of address space, in
// bytes (0: none): all workers of a run have the same, so no other worker and, from the second
// attempt on, no waiting helps. Errors: kAborted if the job ran out of memory.
absl::Status CheckMemoryError(const std::string& error, int attempts, int64_t address_space);

}  // namespace parallax::client
