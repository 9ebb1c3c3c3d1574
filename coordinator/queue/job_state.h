// The words of the machine, as the database spells them.
#pragma once

#include <array>
#include <cstddef>
#include <string_view>

namespace parallax {

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

enum class WorkKind { kSolve, kRender };
inline constexpr size_t kWorkKinds = 2;
inline constexpr std::array<const char*, kWorkKinds> kWorkKindNames = {"solve", "render"};

constexpr const char* NameOf(JobState state) { return kJobStateNames[static_cast<size_t>(state)]; }
constexpr const char* NameOf(WorkKind kind) { return kWorkKindNames[static_cast<size_t>(kind)]; }
constexpr bool IsTerminal(JobState state) { return state >= JobState::kSucceeded; }
// Ended without giving its pairs.
constexpr bool IsLost(JobState state) { return state > JobState::kSucceeded; }

// For text that the database's CHECKs have let in.
constexpr JobState JobStateOf(std::string_view name) {
  for (size_t i = 0; i < kJobStates; ++i) {
    if (name == kJobStateNames[i]) return static_cast<JobState>(i);
  }
  return JobState::kCancelled;
}
constexpr WorkKind WorkKindOf(std::string_view name) {
  return name == kWorkKindNames[0] ? WorkKind::kSolve : WorkKind::kRender;
}

}  // namespace parallax
