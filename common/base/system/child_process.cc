#include "common/base/system/child_process.h"

#include <fcntl.h>
#include <fmt/core.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace parallax {
namespace {

constexpr int kCannotRun = 127;
constexpr int kParentDied = SIGUSR2;  // The kernel sends it to the supervisor.

// All that the children need, made before the fork.
struct Prepared {
  std::vector<std::string> environment;
  std::vector<char*> arguments, variables;
  const char* directory;
  int log;
  pid_t parent;
};

std::vector<char*> Pointers(std::vector<std::string>& texts) {
  std::vector<char*> pointers;
  for (std::string& text : texts) pointers.push_back(text.data());
  pointers.push_back(nullptr);
  return pointers;
}

// Returns our environment with the variables of `more` added or replaced.
std::vector<std::string> EnvironmentWith(const std::vector<std::string>& more) {
  const auto sets = [&](const std::string& entry) {
    const std::string name = entry.substr(0, entry.find('=') + 1);
    for (const std::string& other : more) {
      if (other.compare(0, name.size(), name) == 0) return true;
    }
    return false;
  };
  std::vector<std::string> all;
  for (char** entry = environ; *entry != nullptr; ++entry) {
    if (!sets(*entry)) all.push_back(*entry);
  }
  all.insert(all.end(), more.begin(), more.end());
  return all;
}

// ---- Between fork and exec only async-signal-safe calls: other threads' locks may be held for
// ever.

void SetSignal(int number, void (*handler)(int)) {
  struct sigaction action {};
  action.sa_handler = handler;
  sigaction(number, &action, nullptr);
}

void KillGroup(int) { kill(0, SIGKILL); }

[[noreturn]] void RunProgram(const Prepared& prepared) {
  for (const int number : {SIGTERM, SIGINT, SIGHUP, SIGPIPE, kParentDied}) {
    SetSignal(number, SIG_DFL);
  }
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  const bool moved = *prepared.directory == '\0' || chdir(prepared.directory) == 0;
  if (moved) execvpe(prepared.arguments[0], prepared.arguments.data(), prepared.variables.data());
  constexpr char kMessage[] = "can't run the program ";
  [[maybe_unused]] ssize_t written = write(STDERR_FILENO, kMessage, sizeof kMessage - 1);
  const char* const name = moved ? prepared.arguments[0] : prepared.directory;
  written = write(STDERR_FILENO, name, strlen(name));
  written = write(STDERR_FILENO, "\n", 1);
  _exit(kCannotRun);
}

[[noreturn]] void Supervise(const Prepared& prepared) {
  setpgid(0, 0);
  sigset_t none;
  sigemptyset(&none);
  sigprocmask(SIG_SETMASK, &none, nullptr);
  // Signals for the group are the program's affair.
  for (const int number : {SIGTERM, SIGINT, SIGHUP}) SetSignal(number, SIG_IGN);
  SetSignal(kParentDied, &KillGroup);
  prctl(PR_SET_PDEATHSIG, kParentDied);
  if (getppid() != prepared.parent) _exit(kCannotRun);
  dup2(open("/dev/null", O_RDONLY), STDIN_FILENO);
  dup2(prepared.log, STDOUT_FILENO);
  dup2(prepared.log, STDERR_FILENO);
  closefrom(3);
  const pid_t program = _Fork();
  if (program == 0) RunProgram(prepared);
  if (program < 0) _exit(kCannotRun);
  int status = 0;
  while (waitpid(program, &status, 0) < 0 && errno == EINTR) {
  }
  if (WIFSIGNALED(status)) {  // Ends as its program did.
    prctl(PR_SET_DUMPABLE, 0);
    SetSignal(WTERMSIG(status), SIG_DFL);
    kill(getpid(), WTERMSIG(status));
  }
  _exit(WIFEXITED(status) ? WEXITSTATUS(status) : kCannotRun);
}

double SecondsOf(const timeval& time) {
  return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
}

}  // namespace

absl::StatusOr<std::unique_ptr<ChildProcess>> ChildProcess::Start(const ChildOptions& options) {
  if (options.command.empty()) return InvalidArgument("no program to run");
  std::vector<std::string> words = options.command;
  Prepared prepared;
  prepared.environment = EnvironmentWith(options.environment);
  prepared.arguments = Pointers(words);
  prepared.variables = Pointers(prepared.environment);
  prepared.directory = options.directory.c_str();
  prepared.parent = getpid();
  prepared.log =
      open(options.log.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_APPEND | O_CLOEXEC, 0644);
  if (prepared.log < 0) return ErrnoError(errno, "open " + options.log);
  const pid_t pid = fork();
  if (pid == 0) Supervise(prepared);
  const int cause = errno;
  close(prepared.log);
  if (pid < 0) return ErrnoError(cause, "start " + options.command[0]);
  setpgid(pid, pid);  // The parent does it too; the first one counts.
  return std::unique_ptr<ChildProcess>(new ChildProcess(pid));
}

ChildProcess::~ChildProcess() { Kill(); }

std::optional<int> ChildProcess::Poll() {
  if (wait_status_) return wait_status_;
  siginfo_t ended{};
  if (waitid(P_PID, static_cast<id_t>(pid_), &ended, WEXITED | WNOHANG | WNOWAIT) == 0 &&
      ended.si_pid == pid_) {
    Reap();
  }
  return wait_status_;
}

// The supervisor has ended or must end. Until it is reaped, its group's number stays ours.
void ChildProcess::Reap() {
  kill(-pid_, SIGKILL);
  int status = 0;
  rusage usage{};
  while (wait4(pid_, &status, 0, &usage) < 0 && errno == EINTR) {
  }
  wait_status_ = status;
  cpu_seconds_ = SecondsOf(usage.ru_utime) + SecondsOf(usage.ru_stime);
}

void ChildProcess::Terminate() {
  if (!wait_status_) kill(-pid_, SIGTERM);
}

void ChildProcess::Kill() {
  if (!wait_status_) Reap();
}

std::string DescribeExit(int wait_status) {
  if (WIFSIGNALED(wait_status)) {
    const int number = WTERMSIG(wait_status);
    return fmt::format("killed by signal {} ({})", number, strsignal(number));
  }
  return fmt::format("exit status {}", WEXITSTATUS(wait_status));
}

}  // namespace parallax
