// The states of a job, as the database spells them.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string_view>

namespace parallax {

// BLOCKED waits for another job; READY can be leased; LEASED is with a worker; RETRY_WAIT is
// between attempts. All others are terminal: they never change. README.md has the diagram of moves.
enum class JobState {
  kBlocked,
  kReady,
  kLeased,
  kRetryWait,
  kSucceeded,
  kRejected,
  kFailed,
  kQuarantined,
  kCancelled
};
inline constexpr size_t kJobStates = 9;
inline constexpr std::array<const char*, kJobStates> kJobStateNames = {
    "BLOCKED",  "READY",  "LEASED",      "RETRY_WAIT", "SUCCEEDED",
    "REJECTED", "FAILED", "QUARANTINED", "CANCELLED"};

// Returns the state's name in the database and in messages: "READY".
constexpr const char* NameOf(JobState state) { return kJobStateNames[static_cast<size_t>(state)]; }
// Returns whether a job in this state never changes again.
constexpr bool IsTerminal(JobState state) { return state >= JobState::kSucceeded; }
// Whether a job in this state has ended without giving its pairs.
constexpr bool IsLost(JobState state) { return state > JobState::kSucceeded; }

// Returns the state of that name; nothing for an unknown name.
constexpr std::optional<JobState> JobStateOf(std::string_view name) {
  for (size_t i = 0; i < kJobStates; ++i) {
    if (name == kJobStateNames[i]) return static_cast<JobState>(i);
  }
  return std::nullopt;
}

}  // namespace parallax
