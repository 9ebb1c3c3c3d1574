// Counts the bytes of results in the store, and chooses the ended studies to forget for the bounds
// of `coordinator serve --keep-days` and `--keep-gb`: the oldest first, never an unfinished one.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/base/status.h"
#include "coordinator/queue/job_queue.h"

namespace parallax {

struct RetentionRules {
  double keep_s = 0;       // Seconds after its end that a study is kept; 0: for ever.
  int64_t keep_bytes = 0;  // Bytes of results, all studies together; 0: as many as there are.
};

// A study that a rule wants to be forgotten, and why, for the audit.
struct ForgetDue {
  StudyId study;
  std::string reason;
};

// Counts the files of published pairs and networks by their folders, each once however many studies
// have it. Not thread-safe. Memory: 16 bytes for a pair of a study.
class StoreUse {
 public:
  // Reads what studies have published since the last call, and drops those that are forgotten.
  // Pairs that were taken back count until Restart. Errors: the queue's.
  absl::Status Follow(JobQueue& queue);
  // Lets the next Follow read everything anew.
  void Restart() { studies_.clear(); }

  // Returns the bytes of all results. Litter, the users' content and what running attempts write
  // are not in it.
  int64_t Bytes() const;
  // Returns the ended studies that `rules` don't keep at `now_unix_s`, the oldest first. What a
  // study that stays uses as well counts for that one: forgetting the oldest frees no byte of it.
  std::vector<ForgetDue> Due(const RetentionRules& rules, double now_unix_s) const;

 private:
  struct Study {
    double ended_unix_s = 0;  // 0: unfinished.
    int64_t frame_cursor = 0, result_cursor = 0;
    std::vector<std::pair<uint64_t, int64_t>> folders;  // Hash of the path, bytes.
  };
  static absl::Status FollowStudy(JobQueue& queue, int64_t id, Study& study);

  std::map<int64_t, Study> studies_;  // By id.
};

}  // namespace parallax
