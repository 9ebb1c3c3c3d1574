// Questions about the attempts that run in the agent's slots, as pure functions.
#pragma once

#include <optional>
#include <utility>
#include <vector>

#include "parallax/v1/service.pb.h"
#include "worker/agent/attempts/job_slots.h"

namespace parallax {

// Lists the attempts that this worker still holds, for a heartbeat: those that run and were not
// told to stop, and the finished ones whose reports are `unanswered`.
std::vector<v1::Progress> ProgressOf(const std::vector<RunningAttempt>& running,
                                     const std::vector<v1::AttemptId>& unanswered);

// Returns whether at least one attempt was not told to stop.
bool HasWorkUnderLease(const std::vector<RunningAttempt>& running);
// Counts the attempts that likely end within `seconds`.
int CountEndingSoon(const std::vector<RunningAttempt>& running, double seconds);
// Returns the seconds until the first attempt has made no progress for `hang_s` seconds, unless it
// makes some before; nothing if there is no attempt that was not told to stop.
std::optional<double> SecondsToHang(const std::vector<RunningAttempt>& running, double hang_s);
// Counts the attempts that were given up as hung.
int CountHung(const std::vector<RunningAttempt>& running);

}  // namespace parallax
