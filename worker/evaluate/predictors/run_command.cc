#include "worker/evaluate/predictors/run_command.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <deque>
#include <fstream>
#include <limits>
#include <thread>

namespace parallax {
namespace {

constexpr size_t kTailLines = 20;
constexpr std::chrono::milliseconds kPoll(20);

// Between fork and exec only async-signal-safe calls: other threads' locks may be held for ever.
[[noreturn]] void RunChild(const char* command, int log, pid_t parent) {
  setpgid(0, 0);
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != parent) _exit(127);
  const int null = open("/dev/null", O_RDONLY);
  dup2(null, STDIN_FILENO);
  dup2(log, STDOUT_FILENO);
  dup2(log, STDERR_FILENO);
  close_range(3, std::numeric_limits<unsigned>::max(), 0);
  signal(SIGPIPE, SIG_DFL);
  sigset_t none;
  sigemptyset(&none);
  sigprocmask(SIG_SETMASK, &none, nullptr);
  execl("/bin/sh", "sh", "-c", command, static_cast<char*>(nullptr));
  _exit(127);
}

// Ends the child and all of its group, and takes its exit status.
void KillGroup(pid_t pid) {
  kill(-pid, SIGKILL);
  while (waitpid(pid, nullptr, 0) < 0 && errno == EINTR) {
  }
}

// `what`, then the end of what the command said.
absl::Status Failed(absl::StatusCode code, const CommandOptions& options, const std::string& what) {
  const std::string tail = TailOfFile(options.log, kTailLines);
  return MakeError(code, "`" + options.command + "` " + what +
                             (tail.empty() ? "; it said nothing"
                                           : "; the end of " + options.log + ":\n" + tail));
}

absl::Status StatusOf(int wait_status, const CommandOptions& options) {
  if (WIFSIGNALED(wait_status)) {
    const int number = WTERMSIG(wait_status);
    return Failed(absl::StatusCode::kAborted, options,
                  "was killed by signal " + std::to_string(number) + " (" + strsignal(number) +
                      (number == SIGKILL ? ": out of memory?)" : ")"));
  }
  if (WEXITSTATUS(wait_status) == 0) return absl::OkStatus();
  return Failed(absl::StatusCode::kInternal, options,
                "ended with exit status " + std::to_string(WEXITSTATUS(wait_status)));
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
  const int log = open(options.log.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
  if (log < 0) return ErrnoError(errno, "open " + options.log);
  const pid_t parent = getpid();
  const pid_t pid = fork();
  if (pid == 0) RunChild(options.command.c_str(), log, parent);
  const int cause = errno;
  close(log);
  if (pid < 0) return ErrnoError(cause, "start `" + options.command + "`");
  setpgid(pid, pid);  // Here as well: whoever comes first.
  const SteadyTime start = options.clock->Steady();
  while (true) {
    int wait_status = 0;
    const pid_t ended = waitpid(pid, &wait_status, WNOHANG);
    if (ended == pid) {
      kill(-pid, SIGKILL);  // Children that it left.
      return StatusOf(wait_status, options);
    }
    if (options.cancel.cancelled()) {
      KillGroup(pid);
      return Failed(absl::StatusCode::kCancelled, options, "was stopped");
    }
    const double elapsed_s = std::chrono::duration<double>(options.clock->Steady() - start).count();
    if (elapsed_s > options.limit_s) {
      KillGroup(pid);
      char limit[32];
      std::snprintf(limit, sizeof limit, "%g s", options.limit_s);
      return Failed(absl::StatusCode::kDeadlineExceeded, options,
                    "had not ended after " + std::string(limit));
    }
    options.poll();
    std::this_thread::sleep_for(kPoll);
  }
}

}  // namespace parallax
