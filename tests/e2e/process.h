// A program run by a test: started, read from, signalled and reaped by its process id. Killed when
// it goes out of scope.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <functional>
#include <string>
#include <vector>

namespace parallax {

// Limits of time are for a plain build; sanitizers make a program several times slower.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr double kPatience = 5;
#else
constexpr double kPatience = 1;
#endif

// Not thread-safe. Limits are multiplied by kPatience.
class Process {
 public:
  using Seconds = std::chrono::duration<double>;

  // Starts `command[0]`. `environment`: "NAME=value", before ours. What it writes is kept in
  // memory, stdout and stderr apart: a child never waits for somebody to read.
  explicit Process(const std::vector<std::string>& command,
                   const std::vector<std::string>& environment = {});
  ~Process();
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;

  pid_t pid() const { return pid_; }
  bool Running();
  void Signal(int signal);
  // Waits for the end. The exit status, 128 + signal, or -1 after the limit.
  int Wait(Seconds limit = Seconds(250));
  // The next line of stdout, without its end. False when it ended without one or after the limit.
  bool ReadLine(std::string* line, Seconds limit = Seconds(20));
  // All so far; complete after Wait().
  std::string Out() const;
  std::string Err() const;
  // Processes whose parent this is.
  std::vector<pid_t> Children() const;

 private:
  pid_t pid_ = -1;
  int out_ = -1;
  int err_ = -1;
  size_t read_ = 0;  // Bytes of stdout that ReadLine gave.
  int status_ = -1;
  bool ended_ = false;
};

std::string ReadText(const std::string& path);
// True as soon as `condition` is; false when `process` ends first.
bool WaitUntil(Process& process, const std::function<bool()>& condition);
// Alive, and not just waiting to be reaped.
bool IsAlive(pid_t pid);

}  // namespace parallax
