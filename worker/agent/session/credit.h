// How many more jobs a worker asks for, as a pure function.
#pragma once

#include <optional>

#include "parallax/v1/service.pb.h"

namespace parallax {

// The worker's load.
struct WorkLoad {
  int slots = 1;
  int taken = 0;            // Jobs that run or wait here, and those asked for already.
  int ending_soon = 0;      // Running jobs that end soon: their slots may have the next jobs now.
  int pending_reports = 0;  // Reports without an answer.
  int max_pending_reports = 0;
};

// Returns the message that asks for as many jobs as the worker can take now; nothing if it can take
// none.
std::optional<v1::Credit> CreditFor(const WorkLoad& load);

}  // namespace parallax
