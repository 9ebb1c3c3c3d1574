// Reads the queue's database for the web page, where no RPC has the data: newest pairs, one job
// with its attempts, causes of problems, scores of networks. It has its own connections, so that
// users of the page and the calls of workers and clients never wait for each other. Every call
// reads one short snapshot with a deadline, and its cost does not grow with the number of jobs.
// Thread-safe.
//
// Errors: kNotFound for an unknown study, pair or job; kDeadlineExceeded for a read that takes too
// long; those of the database.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "common/base/status.h"
#include "coordinator/queue/job_kind.h"
#include "parallax/v1/service.pb.h"

namespace parallax {

class Readers;

// A published pair. Its number is unique over all studies and grows in the order of publication.
struct PublishedPair {
  int64_t number = 0;
  int64_t study_id = 0;
  std::string study;
  std::string variant;
  uint32_t scene = 0;
  bool reused = false;
  v1::FrameResult frame;
};

struct PairQuery {
  int64_t study_id = 0;
  std::string variant;  // Empty: all.
  int64_t before = 0;   // Only pairs with smaller numbers; 0: from the newest.
  int limit = 48;       // At most 200.
};

// The jobs of a study that failed, or wait for a retry, with the same cause.
struct ProblemCause {
  std::string fingerprint;  // Equal for equal causes; empty if no worker reported it.
  std::string error;        // Error of the newest of these jobs.
  std::string kind;
  int64_t jobs = 0;
  std::map<std::string, int64_t> states;
  std::vector<int64_t> examples;  // Ids of at most five jobs, the newest first.
  double newest_unix_s = 0;
};

// An attempt that ended without a result.
struct LostAttempt {
  uint64_t fence = 0;
  std::string ledger;  // "app": it failed; "lost": its worker was lost; "returned": handed back.
  std::string worker, fingerprint, error, log_tail;
  double unix_s = 0;
};

struct JobDetail {
  v1::JobStatus status;  // Without progress, which is not in the database.
  int64_t study_id = 0;
  std::string study;
  uint64_t fence = 0;  // Fence of the newest attempt; 0: none yet.
  int generation = 1;
  int app_failures = 0, infra_losses = 0;
  bool reused = false;  // It succeeded by another job's result.
  int64_t awaits_job = 0;
  double ready_unix_s = 0, finished_unix_s = 0, not_before_unix_s = 0;  // 0: not set.
  std::vector<LostAttempt> attempts;  // The oldest first, at most 100.
  std::vector<PublishedPair> pairs;   // Its pairs that are published.
  // Folder of its result in the store, and the files in it; empty without such a folder.
  std::string result_path;
  std::vector<v1::FileEntry> result_files;
};

// A figure of a network, or of a baseline, on a benchmark.
struct StudyScore {
  int64_t job_id = 0;
  JobKind::Score score;
};

class PageReader {
 public:
  // Opens connections to a database that a JobQueue has open. `kinds` must outlive the reader.
  // Errors: those of the database.
  static absl::StatusOr<std::unique_ptr<PageReader>> Open(const std::string& db_path,
                                                          const KindRegistry& kinds);
  ~PageReader();

  // Returns pairs, the newest first; with a variant in the query, by scene, the highest first.
  absl::StatusOr<std::vector<PublishedPair>> NewestPairs(const PairQuery& query);
  absl::StatusOr<PublishedPair> Pair(int64_t number);
  // Numbers of the pairs of the same study that were published just before and after; 0: none.
  struct Neighbours {
    int64_t older = 0, newer = 0;
  };
  absl::StatusOr<Neighbours> NeighboursOf(const PublishedPair& pair);
  // Returns the causes of a study's problems; the cause of the most jobs comes first. Looks at the
  // newest 2,000 such jobs only.
  absl::StatusOr<std::vector<ProblemCause>> Problems(int64_t study_id);
  absl::StatusOr<JobDetail> Job(int64_t job_id);
  absl::StatusOr<std::vector<StudyScore>> Scores(int64_t study_id);

 private:
  PageReader(std::unique_ptr<Readers> readers, const KindRegistry& kinds);

  const std::unique_ptr<Readers> readers_;
  const KindRegistry& kinds_;
};

}  // namespace parallax
