// Threads that lease and complete no-op jobs of a queue in this process.
#pragma once

#include <cstdint>
#include <string>

#include "common/base/status.h"

namespace parallax {

struct LibraryLoad {
  std::string db_path;
  int64_t jobs = 0;  // To end, of whatever is READY.
  int threads = 64;
  int per_lease = 4;
};
struct LibraryFigures {
  int64_t transitions = 0;
  double seconds = 0;
  double cpu_s = 0;
  double lease_p99_ms = 0;
  double commands_per_commit = 0;
  double commit_ms = 0;  // Mean.
  double checkpoints = 0;
  double checkpoint_ms = 0;  // Mean.
  double checkpoint_max_ms = 0;
};
absl::StatusOr<LibraryFigures> RunLibraryLoad(const LibraryLoad& load);

}  // namespace parallax
