#include "worker/evaluate/predictors/predictor_command.h"

#include <fmt/core.h>
#include <signal.h>
#include <sys/wait.h>

#include <algorithm>
#include <chrono>
#include <deque>
#include <fstream>
#include <thread>

#include "common/base/seconds.h"
#include "common/base/system/child_process.h"

namespace parallax {
namespace {

constexpr size_t kTailLines = 20;
constexpr std::chrono::milliseconds kPoll(20);

// `what`, then the end of what the command said.
absl::Status Failed(absl::StatusCode code, const CommandOptions& options, const std::string& what) {
  const std::string tail = TailOfFile(options.log, kTailLines);
  return MakeError(
      code, fmt::format(
                "`{}` {}{}", options.name.empty() ? options.command : options.name, what,
                tail.empty() ? "; it said nothing" : "; the end of " + options.log + ":\n" + tail));
}

absl::Status StatusOf(int wait_status, const CommandOptions& options) {
  if (WIFSIGNALED(wait_status)) {
    return Failed(absl::StatusCode::kAborted, options,
                  "was " + DescribeExit(wait_status) +
                      (WTERMSIG(wait_status) == SIGKILL ? ": out of memory?" : ""));
  }
  if (WEXITSTATUS(wait_status) == 0) return absl::OkStatus();
  return Failed(absl::StatusCode::kInternal, options, "ended with " + DescribeExit(wait_status));
}

}  // namespace

std::string TailOfFile(const std::string& path, size_t lines) {
  std::ifstream file(path, std::ios::binary);
  file.seekg(0, std::ios::end);
  const std::streamoff size = file.tellg();
  if (size <= 0) return "";
  file.seekg(std::max<std::streamoff>(0, size - 16384));
  std::deque<std::string> tail;
  for (std::string line; std::getline(file, line);) {
    if (!line.empty()) tail.push_back(line);
    if (tail.size() > lines) tail.pop_front();
  }
  std::string text;
  for (const std::string& line : tail) text += line + "\n";
  return text;
}

absl::Status RunCommand(const CommandOptions& options) {
  ASSIGN_OR_RETURN(const auto child,
                   ChildProcess::Start({.command = {"/bin/sh", "-c", options.command},
                                        .directory = options.directory,
                                        .log = options.log}));
  const SteadyTime start = options.clock->Steady();
  while (true) {
    if (const std::optional<int> ended = child->Poll()) return StatusOf(*ended, options);
    if (options.cancel.cancelled()) {
      child->Kill();
      return Failed(absl::StatusCode::kCancelled, options, "was stopped");
    }
    const double elapsed_s = SecondsBetween(start, options.clock->Steady());
    if (elapsed_s > options.limit_s) {
      child->Kill();
      return Failed(absl::StatusCode::kDeadlineExceeded, options,
                    fmt::format("had not ended after {:g} s", options.limit_s));
    }
    options.poll();
    std::this_thread::sleep_for(kPoll);
  }
}

}  // namespace parallax
