// `run` itself: a coordinator in this process, workers beside it, and the dataset growing in the
// folder, until the study has ended or somebody or something stops it.
//
// Every step is repeatable: killed at any moment, the same run again goes on from what is durable.
#pragma once

#include <cstdint>
#include <memory>
#include <set>
#include <string>

#include "common/base/status.h"
#include "coordinator/client/app.h"
#include "coordinator/client/archive_sync.h"
#include "coordinator/client/connection.h"
#include "coordinator/client/embedded_coordinator.h"
#include "coordinator/client/follow.h"
#include "coordinator/client/interrupt.h"
#include "coordinator/client/out_dir.h"
#include "coordinator/client/run_report.h"
#include "coordinator/client/study_results.h"
#include "coordinator/client/worker_pool.h"
#include "parallax/v1/study.pb.h"

namespace parallax::client {

struct EmbeddedRunOptions {
  v1::StudySpec study;
  int workers = 1;
  // As the worker's options of these names; see worker --help.
  std::string allow_trainers, trainers_dir, benchmarks_dir;
  std::string page;   // "HOST:PORT" where the page is shown while it runs; empty: nowhere.
  bool json = false;  // Progress as lines of text all the same; they go to standard error.
};

class EmbeddedRun {
 public:
  // Opens everything and finds or submits the study, before any worker starts. `out_dir` and
  // `environment` outlive the run. Errors: as the parts'.
  static absl::StatusOr<std::unique_ptr<EmbeddedRun>> Open(const EmbeddedRunOptions& options,
                                                           const OutDir& out_dir,
                                                           Environment& environment);

  // Until the study has ended; its state is in the report. Errors: kCancelled when interrupted
  // (drained, with what is done in the message); kResourceExhausted or kPermissionDenied when the
  // disk refuses; kInternal for crash loops.
  absl::StatusOr<RunReport> Work();

  // The page's address with its one-time code; empty without one.
  const std::string& page_link() const { return page_link_; }

 private:
  EmbeddedRun(const EmbeddedRunOptions& options, const OutDir& out_dir, Environment& environment);

  absl::Status EnterStudy();
  absl::Status StandAlone();  // Pauses other studies of this folder.
  absl::Status StartWorkers();
  std::vector<std::string> ArgumentsOf(int worker) const;
  absl::Status Loop();
  absl::Status Step(double now_s);
  // Notes on jobs that failed; an error for those that make going on senseless.
  absl::Status ShowProblems();
  void Note(const std::string& variant, uint32_t scene, const std::string& error);
  void Drain(bool hurry);
  absl::Status CatchUp(double now_s, bool last);
  // What a stopped run tells: how far it came and how to go on.
  std::string Progress() const;

  const EmbeddedRunOptions options_;
  const OutDir& out_dir_;
  Environment& environment_;
  std::unique_ptr<ArchiveSync> archive_;
  std::unique_ptr<StudyResults> results_;
  std::unique_ptr<EmbeddedCoordinator> coordinator_;
  std::unique_ptr<Connection> connection_;
  std::unique_ptr<WorkerPool> pool_;
  InterruptScope interrupts_;
  ProgressDisplay display_;
  ProgressView view_;
  std::string page_link_;
  int64_t study_id_ = 0;
  int64_t fresh_before_ = 0;  // Pairs rendered for this study by earlier runs.
  double indexed_s_ = 0;      // When index and card were last written.
  std::set<std::string> shown_problems_;
};

// Whether a job's error is one that no retry and no other worker mends. Errors: kResourceExhausted
// when the disk is full or may not be written.
absl::Status CheckDiskError(const std::string& error);

}  // namespace parallax::client
