// Fail points: each step of each command may be made to fail or to end the process, to prove that
// neither leaves anything half done. Off by default and then free. A point is named
// "<command>:<step>", steps counted from 1 within one execution of the command: "complete:3" is
// before the third SQL write of a Complete, "commit:1" before COMMIT, "commit:2" after it and
// before anybody is told.
//
// The environment variable PARALLAX_FAIL_POINT=<command>:<step>[:<hit>] ends the process (SIGKILL)
// at that point the <hit>-th time (default the first); tests use the object.
#pragma once

#include <array>
#include <functional>
#include <string>

#include "common/base/status.h"

namespace parallax {

// Every command that has steps. Begin() refuses others while armed, so that fault tests, which go
// through this list, can't forget one.
inline constexpr std::array kFailPointCommands = {
    "submit", "cancel",     "pause",         "resume",      "retry",  "lease",  "complete",
    "fail",   "hand_back",  "adopt",         "worker_lost", "tick",   "expand", "settle",
    "commit", "checkpoint", "forget_litter", "drain",       "forget", "limit",  "history"};

// One queue's points. Used by its writing thread only; arm before the queue opens.
class FailPoint {
 public:
  // Called at each point; an error makes that step fail. May end the process.
  using Hook = std::function<absl::Status(const std::string& command, int step)>;
  explicit FailPoint(Hook hook);  // Null: the environment's, if set.

  bool armed() const { return static_cast<bool>(hook_); }
  void Begin(const char* command);  // One of kFailPointCommands. Steps count from 1 again.
  absl::Status Step();

 private:
  Hook hook_;
  std::string command_;
  int step_ = 0;
};

}  // namespace parallax
