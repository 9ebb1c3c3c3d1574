// Runs a program as a child process, together with everything that it starts, in a process group of
// its own.
//
// The group ends when the child ends, when the ChildProcess is destroyed, and when this process
// dies for any reason. A small supervisor, itself our child and the group's leader, waits for the
// program; the kernel signals it when we die. Linux ties that signal to the thread that called
// Start(), so that thread must live as long as the child.
#pragma once

#include <sys/types.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/base/status.h"

namespace parallax {

struct ChildOptions {
  std::vector<std::string> command;      // Program and arguments; sought on $PATH if it has no '/'.
  std::string directory;                 // Working folder; empty: ours.
  std::string log;                       // File that stdout and stderr replace.
  std::vector<std::string> environment;  // "NAME=value"; added to ours, or replaces ours.
};

// Not thread-safe.
class ChildProcess {
 public:
  // Starts the program and returns at once. A program that can't be run is not an error here: it
  // ends with status 127 and says why in the log. Errors: those of open(2) for the log, and of
  // fork(2).
  static absl::StatusOr<std::unique_ptr<ChildProcess>> Start(const ChildOptions& options);
  ~ChildProcess();  // Kills what still runs.
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  // Returns nothing while the program runs; then its wait(2) status, after the rest of its group
  // has been killed. Never blocks while it runs.
  std::optional<int> Poll();
  void Terminate();  // Sends SIGTERM to the whole group.
  void Kill();       // Ends the whole group and waits for it.
  // Returns the CPU time (user + system) of the child and of the children that it waited for; 0
  // until it ended.
  double cpu_seconds() const { return cpu_seconds_; }

 private:
  explicit ChildProcess(pid_t pid) : pid_(pid) {}
  void Reap();

  const pid_t pid_;  // The supervisor's.
  std::optional<int> wait_status_;
  double cpu_seconds_ = 0;
};

// Describes a wait(2) status for people: "exit status 3", "killed by signal 9 (Killed)".
std::string DescribeExit(int wait_status);

}  // namespace parallax
