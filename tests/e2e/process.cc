#include "tests/e2e/process.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <thread>

namespace parallax {
namespace {

std::vector<char*> Pointers(std::vector<std::string>& words) {
  std::vector<char*> pointers;
  for (std::string& word : words) pointers.push_back(word.data());
  pointers.push_back(nullptr);
  return pointers;
}

std::string ReadAll(int fd) {
  std::string text;
  char bytes[4096];
  for (ssize_t count;
       (count = pread(fd, bytes, sizeof bytes, static_cast<off_t>(text.size()))) > 0;) {
    text.append(bytes, static_cast<size_t>(count));
  }
  return text;
}

}  // namespace

std::string ReadText(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

Process::Process(const std::vector<std::string>& command,
                 const std::vector<std::string>& environment)
    : out_(memfd_create("stdout", MFD_CLOEXEC)), err_(memfd_create("stderr", MFD_CLOEXEC)) {
  if (out_ < 0 || err_ < 0) std::abort();
  std::vector<std::string> words = command;
  std::vector<std::string> variables = environment;
  for (char** variable = environ; *variable != nullptr; ++variable) variables.push_back(*variable);
  const std::vector<char*> argv = Pointers(words);
  const std::vector<char*> envp = Pointers(variables);
  pid_ = fork();
  if (pid_ == 0) {
    const int null = open("/dev/null", O_RDONLY);
    dup2(null, STDIN_FILENO);
    dup2(out_, STDOUT_FILENO);
    dup2(err_, STDERR_FILENO);
    execve(argv[0], argv.data(), envp.data());
    _exit(127);
  }
}

Process::~Process() {
  if (Running()) {
    Signal(SIGKILL);
    Wait();
  }
  close(out_);
  close(err_);
}

bool Process::Running() {
  if (ended_) return false;
  int status = 0;
  if (waitpid(pid_, &status, WNOHANG) != pid_) return true;
  ended_ = true;
  status_ = status;
  return false;
}

void Process::Signal(int signal) {
  if (Running()) kill(pid_, signal);
}

int Process::Wait(Seconds limit) {
  if (!ended_) {
    const int fd = static_cast<int>(syscall(SYS_pidfd_open, pid_, 0));
    pollfd end{fd, POLLIN, 0};
    // Waits in slices, so that time in which the machine was suspended counts as one slice.
    constexpr int kSliceMs = 100;
    int ready = 0;
    for (double left_ms = kPatience * limit.count() * 1000; ready == 0 && left_ms > 0;
         left_ms -= kSliceMs) {
      ready = poll(&end, 1, static_cast<int>(std::min<double>(kSliceMs, left_ms)));
    }
    close(fd);
    if (ready <= 0) return -1;
    waitpid(pid_, &status_, 0);
    ended_ = true;
  }
  return WIFSIGNALED(status_) ? 128 + WTERMSIG(status_) : WEXITSTATUS(status_);
}

bool Process::ReadLine(std::string* line, Seconds limit) {
  const auto deadline = std::chrono::steady_clock::now() + kPatience * limit;
  while (true) {
    const bool running = Running();
    const std::string text = Out();
    if (const size_t end = text.find('\n', read_); end != std::string::npos) {
      *line = text.substr(read_, end - read_);
      read_ = end + 1;
      return true;
    }
    if (!running || std::chrono::steady_clock::now() >= deadline) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
}

std::string Process::Out() const { return ReadAll(out_); }
std::string Process::Err() const { return ReadAll(err_); }

std::vector<pid_t> Process::Children() const {
  // Children belong to threads; all of them are asked for.
  std::vector<pid_t> children;
  const std::string pid = std::to_string(pid_);
  std::istringstream list(ReadText("/proc/" + pid + "/task/" + pid + "/children"));
  for (pid_t child; list >> child;) children.push_back(child);
  return children;
}

bool WaitUntil(Process& process, const std::function<bool()>& condition) {
  while (!condition()) {
    if (!process.Running()) return condition();
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  return true;
}

bool IsAlive(pid_t pid) {
  const std::string status = ReadText("/proc/" + std::to_string(pid) + "/stat");
  const size_t end = status.rfind(')');
  return end != std::string::npos && end + 2 < status.size() && status[end + 2] != 'Z';
}

}  // namespace parallax
