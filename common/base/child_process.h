// A program run as a child, with all that it starts in a process group of its own.
//
// The group ends with the child, with this object and with this process, however that dies: a small
// supervisor, itself a child of ours and the group's leader, waits for the program and is told by
// the kernel when we are gone. Linux ties that to the thread that called Start(), so this thread
// must live as long as the child.
#pragma once

#include <sys/types.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/base/status.h"

namespace parallax {

struct ChildOptions {
  std::vector<std::string> command;      // The program is sought on $PATH if its name has no '/'.
  std::string directory;                 // Its working folder; empty: ours.
  std::string log;                       // A file that its output and errors replace.
  std::vector<std::string> environment;  // "NAME=value", instead of ours or beside it.
};

// Not thread-safe.
class ChildProcess {
 public:
  // A program that can't be run is no error here: it ends with status 127 and says so in the log.
  // Errors: as open(2) of the log and fork(2).
  static absl::StatusOr<std::unique_ptr<ChildProcess>> Start(const ChildOptions& options);
  ~ChildProcess();  // Kills what still runs.
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  // Nothing while it runs; then its status as wait(2) gives it, with the rest of its group gone.
  std::optional<int> Poll();
  void Terminate();  // Sends SIGTERM to the whole group.
  void Kill();       // Ends the whole group and waits for it.
  // CPU time (user + system) of the child and of the children that it waited for, once it ended.
  double cpu_seconds() const { return cpu_seconds_; }

 private:
  explicit ChildProcess(pid_t pid) : pid_(pid) {}
  void Reap();

  const pid_t pid_;  // The supervisor's.
  std::optional<int> wait_status_;
  double cpu_seconds_ = 0;
};

// "exit status 3", "killed by signal 9 (Killed)".
std::string DescribeExit(int wait_status);

}  // namespace parallax
