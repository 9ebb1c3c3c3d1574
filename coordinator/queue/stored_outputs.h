// Records of the files in the store: which it must have, which were found damaged, and
// how far the search for damage has come.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/base/hash.h"
#include "coordinator/queue/job_kind.h"

namespace parallax {

// A committed result with files.
struct StoredOutput {
  Sha256Digest key{};
  std::string folder;  // The folder in the store that all files are in; see CommonFolder.
  std::vector<JobKind::OutputFile> files;
};

// A result whose files are not what they were.
struct DamagedResult {
  Sha256Digest key{};
  std::string folder;  // As in StoredOutput: a result that was made anew has another one.
  std::string why;     // For people: "ab/.../left.png: has 7 bytes, not 9".
};
// The outcome of JobQueue::TakeBack.
struct TakenBack {
  int64_t results = 0;  // That were taken back.
  int64_t pairs = 0;    // Pairs of studies that are no longer published.
  int64_t jobs = 0;     // Jobs that make them again.
};

// A pass over all results in the order of their keys, which looks for damage.
struct ScrubState {
  std::string position;  // The last key that was looked at; empty: none.
  double began_unix_s = 0;
  std::optional<double> ended_unix_s;  // Absent while the pass is under way.
  int64_t files = 0;
  int64_t bytes = 0;
  int64_t damaged = 0;  // Results.
};

// The store as the database knows it, told before anything of it is used.
struct KnownStore {
  std::string id;           // The id in its marker; empty: the database has none yet.
  std::string database_id;  // The database's own id.
  // Files of the newest results, which must be in the right store; empty: there are no results.
  std::vector<JobKind::OutputFile> sample;
};

}  // namespace parallax
