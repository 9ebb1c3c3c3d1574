#include "coordinator/client/runs/worker_pool.h"

#include <fcntl.h>
#include <fmt/core.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <thread>

#include "common/base/system/child_process.h"

namespace parallax::client {
namespace {

namespace fs = std::filesystem;

constexpr int kExecFailed = 127;
constexpr int kUsageError = 2;
// Time for a worker to end after its second SIGTERM.
constexpr double kHandBack_s = 6;
constexpr uintmax_t kLargestLog = 16 << 20;

double SecondsOf(const timeval& time) {
  return static_cast<double>(time.tv_sec) + static_cast<double>(time.tv_usec) * 1e-6;
}

// After the n-th crash in a row of one child.
double PauseAfter(int crashes) {
  return std::min(5.0, 0.25 * static_cast<double>(1 << std::min(crashes, 8)));
}

std::vector<std::string> TailOf(const std::string& path, size_t lines) {
  std::ifstream file(path, std::ios::binary);
  file.seekg(0, std::ios::end);
  const auto size = static_cast<std::streamoff>(file.tellg());
  file.seekg(std::max<std::streamoff>(0, size - 16384));
  std::vector<std::string> tail;
  for (std::string line; std::getline(file, line);) {
    if (!line.empty()) tail.push_back(line);
  }
  if (tail.size() > lines) tail.erase(tail.begin(), tail.end() - static_cast<ptrdiff_t>(lines));
  return tail;
}

// Only async-signal-safe calls between fork and exec: locks of other threads may stay locked.
[[noreturn]] void RunChild(const char* binary, char* const* arguments, int log, pid_t parent) {
  // A group of its own: Ctrl-C at the terminal is for the parent, which drains its children.
  setpgid(0, 0);
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != parent) _exit(kExecFailed);
  const int null = open("/dev/null", O_RDONLY);
  dup2(null, STDIN_FILENO);
  dup2(log, STDOUT_FILENO);
  dup2(log, STDERR_FILENO);
  closefrom(3);
  signal(SIGPIPE, SIG_DFL);
  sigset_t none;
  sigemptyset(&none);
  sigprocmask(SIG_SETMASK, &none, nullptr);
  execv(binary, arguments);
  constexpr char kMessage[] = "can't start the worker program\n";
  [[maybe_unused]] const ssize_t written = write(STDERR_FILENO, kMessage, sizeof kMessage - 1);
  _exit(kExecFailed);
}

}  // namespace

WorkerPool::WorkerPool(WorkerPoolOptions options)
    : options_(std::move(options)), children_(static_cast<size_t>(options_.workers)) {}

WorkerPool::~WorkerPool() {
  while (running() > 0) {
    SignalAll(SIGKILL);
    ReapEnded();
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
}

double WorkerPool::Now() const {
  return std::chrono::duration<double>(options_.clock->Steady().time_since_epoch()).count();
}

std::string WorkerPool::LogPath(int index) const {
  return fmt::format("{}/worker-{}.log", options_.log_dir, index);
}

absl::Status WorkerPool::Start() {
  if (access(options_.binary.c_str(), X_OK) != 0) {
    return ErrnoError(errno, "the worker program " + options_.binary);
  }
  std::error_code error;
  fs::create_directories(options_.log_dir, error);
  if (error) return ErrnoError(error.value(), options_.log_dir);
  for (int i = 0; i < options_.workers; ++i) {
    // One older generation of a long log is kept.
    if (fs::exists(LogPath(i), error) && fs::file_size(LogPath(i), error) > kLargestLog) {
      fs::rename(LogPath(i), LogPath(i) + ".1", error);
    }
    RETURN_IF_ERROR(Spawn(i));
  }
  return absl::OkStatus();
}

absl::Status WorkerPool::Spawn(int index) {
  const std::string path = LogPath(index);
  const int log = open(path.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644);
  if (log < 0) return ErrnoError(errno, "can't write " + path);
  std::vector<std::string> words = options_.arguments(index);
  words.insert(words.begin(), options_.binary);
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  const pid_t parent = getpid();
  const pid_t pid = fork();
  if (pid == 0) RunChild(options_.binary.c_str(), arguments.data(), log, parent);
  const int cause = errno;
  close(log);
  if (pid < 0) return ErrnoError(cause, "can't start a worker");
  children_[static_cast<size_t>(index)].pid = pid;
  return absl::OkStatus();
}

absl::Status WorkerPool::OnExit(int index, int wait_status) {
  Child& child = children_[static_cast<size_t>(index)];
  child.pid = 0;
  ++child.crashes_in_row;
  ++crashes_;
  ++crashes_in_row_;
  crashed_last_ = index;
  child.start_at_s = Now() + PauseAfter(child.crashes_in_row);
  const int status = WIFEXITED(wait_status) ? WEXITSTATUS(wait_status) : 0;
  const bool hopeless = status == kExecFailed || status == kUsageError;
  if (!hopeless && crashes_in_row_ < options_.most_crashes) return absl::OkStatus();
  std::string message =
      hopeless ? "the worker can't start: " + DescribeExit(wait_status)
               : fmt::format("workers keep crashing ({} times without a result), the last time: {}",
                             crashes_in_row_, DescribeExit(wait_status));
  message += "; its log is " + LogPath(index);
  for (const std::string& line : LogTail(10)) message += "\n  | " + line;
  return Internal("{}", message);
}

absl::Status WorkerPool::Poll(int64_t results) {
  if (results > results_) {
    results_ = results;
    crashes_in_row_ = 0;
    for (Child& child : children_) child.crashes_in_row = 0;
  }
  for (int i = 0; i < options_.workers; ++i) {
    Child& child = children_[static_cast<size_t>(i)];
    if (child.pid > 0) {
      int wait_status = 0;
      rusage usage{};
      if (wait4(child.pid, &wait_status, WNOHANG, &usage) != child.pid) continue;
      cpu_seconds_ += SecondsOf(usage.ru_utime) + SecondsOf(usage.ru_stime);
      RETURN_IF_ERROR(OnExit(i, wait_status));
    } else if (Now() >= child.start_at_s) {
      RETURN_IF_ERROR(Spawn(i));
    }
  }
  return absl::OkStatus();
}

void WorkerPool::SignalAll(int signal) {
  for (const Child& child : children_) {
    if (child.pid > 0) kill(child.pid, signal);
  }
}

void WorkerPool::ReapEnded() {
  for (Child& child : children_) {
    if (child.pid == 0) continue;
    int wait_status = 0;
    rusage usage{};
    const pid_t ended = wait4(child.pid, &wait_status, WNOHANG, &usage);
    if (ended == 0 || (ended < 0 && errno == EINTR)) continue;
    cpu_seconds_ += SecondsOf(usage.ru_utime) + SecondsOf(usage.ru_stime);
    child.pid = 0;
  }
}

void WorkerPool::Drain(double grace_s, const std::function<bool()>& hurry) {
  SignalAll(SIGTERM);
  double next_step_s = Now() + grace_s;
  bool handing_back = false;
  while (true) {
    ReapEnded();
    if (running() == 0) return;
    if (!handing_back && (Now() >= next_step_s || hurry())) {
      SignalAll(SIGTERM);
      handing_back = true;
      next_step_s = Now() + kHandBack_s;
    } else if (handing_back && Now() >= next_step_s) {
      SignalAll(SIGKILL);
      next_step_s = Now() + kHandBack_s;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
}

int WorkerPool::running() const {
  return static_cast<int>(std::count_if(children_.begin(), children_.end(),
                                        [](const Child& child) { return child.pid > 0; }));
}

std::vector<pid_t> WorkerPool::pids() const {
  std::vector<pid_t> pids;
  for (const Child& child : children_) {
    if (child.pid > 0) pids.push_back(child.pid);
  }
  return pids;
}

std::vector<std::string> WorkerPool::LogTail(size_t lines) const {
  return TailOf(LogPath(crashed_last_), lines);
}

}  // namespace parallax::client
