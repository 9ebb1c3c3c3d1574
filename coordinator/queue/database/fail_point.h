// Fail points: tests can make each step of each command fail or end the process, to prove that
// neither leaves anything half done. They are off by default and then cost nothing. A point is
// named "<command>:<step>", where steps are counted from 1 within one execution of the command:
// "complete:3" is before the third SQL write of a Complete, "commit:1" is before COMMIT, "commit:2"
// is after it and before any caller is answered.
//
// The environment variable PARALLAX_FAIL_POINT=<command>:<step>[:<hit>] ends the process by SIGKILL
// when it reaches that point for the <hit>-th time (default: the first). Tests use the object.
#pragma once

#include <array>
#include <functional>
#include <string>

#include "common/base/status.h"

namespace parallax {

// All commands that have steps. While armed, Begin() refuses any other, so fault tests, which go
// through this list, can't miss one.
inline constexpr std::array kFailPointCommands = {
    "submit", "cancel",     "pause",         "resume",      "retry",  "lease",    "complete",
    "fail",   "hand_back",  "adopt",         "worker_lost", "tick",   "expand",   "settle",
    "commit", "checkpoint", "forget_litter", "drain",       "forget", "limit",    "history",
    "repair", "scrub",      "stream",        "comment",     "notice", "priority", "search"};

// The fail points of one queue. Used only by its writing thread; must be armed before the queue
// opens.
class FailPoint {
 public:
  // Called at each point. If it returns an error, the step fails. It may also end the process.
  using Hook = std::function<absl::Status(const std::string& command, int step)>;
  explicit FailPoint(Hook hook);  // Null: as the environment variable says.

  bool armed() const { return static_cast<bool>(hook_); }
  void Begin(const char* command);  // One of kFailPointCommands. Restarts the count of steps.
  // Passes the next point. Errors: the hook's.
  absl::Status Step();

 private:
  Hook hook_;
  std::string command_;
  int step_ = 0;
};

}  // namespace parallax
