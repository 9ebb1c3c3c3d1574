// What the agent concludes from the attempts that run in its slots.
#pragma once

#include <utility>
#include <vector>

#include "parallax/v1/service.pb.h"
#include "worker/agent/job_slots.h"

namespace parallax {

// What is ours, for the coordinator: attempts that run and were not told to stop, and finished ones
// whose reports are `unanswered`.
std::vector<v1::Progress> ProgressOf(const std::vector<RunningAttempt>& running,
                                     const std::vector<v1::AttemptId>& unanswered);

// Whether one was not told to stop.
bool HasWorkUnderLease(const std::vector<RunningAttempt>& running);
// How many likely end within `seconds`.
int CountEndingSoon(const std::vector<RunningAttempt>& running, double seconds);
// How many were given up as hung: they won't come to their end.
int CountHung(const std::vector<RunningAttempt>& running);

}  // namespace parallax
