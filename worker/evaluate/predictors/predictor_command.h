// Runs a shell command as a child process with a time limit.
#pragma once

#include <functional>
#include <string>

#include "common/base/cancel.h"
#include "common/base/status.h"
#include "common/base/system/clock.h"

namespace parallax {

// A command, its log and its limits.
struct CommandOptions {
  std::string command;    // For /bin/sh -c.
  std::string name;       // For messages; the command if empty.
  std::string directory;  // Where it runs; empty: in our own working folder.
  std::string log;        // Standard output and error are written here.
  double limit_s = 60;    // Time after which it and its children are killed.
  CancelToken cancel;
  Clock* clock = &Clock::System();
  std::function<void()> poll = [] {};  // Called a few times a second while it runs.
};

// Runs the command and waits for its end. All of its child processes are killed when it ends, and
// also when this process dies; see ChildProcess. Errors: kInternal for an exit status other than 0,
// kAborted when a signal killed it (including the kernel's out-of-memory killer),
// kDeadlineExceeded, kCancelled; each with the log's last lines. Also those of ChildProcess::Start.
absl::Status RunCommand(const CommandOptions& options);

// Returns the last `lines` lines of a file, for messages; "" when it can't be read.
std::string TailOfFile(const std::string& path, size_t lines);

}  // namespace parallax
