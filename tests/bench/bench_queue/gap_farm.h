// The time between two jobs of one slot, with the real agents: stream, credit, outbox and reports;
// only the jobs are short waits.
#pragma once

#include <string>

#include "common/base/status.h"

namespace parallax {

struct GapOptions {
  std::string address;
  std::string outbox_root;
  int workers = 200;
  double job_s = 1;     // Mean time of a job, spread by half of it to both sides.
  double seconds = 15;  // Gaps that end in this are counted.
};
struct GapFigures {
  int64_t gaps = 0;
  double p50_ms = 0;
  double p99_ms = 0;
};
absl::StatusOr<GapFigures> MeasureGaps(const GapOptions& options);

}  // namespace parallax
