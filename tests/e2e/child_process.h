// A program run by a test: started, read from, signalled and reaped by its process id. Killed when
// it goes out of scope.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <string>
#include <vector>

namespace parallax {

// Not thread-safe.
class ChildProcess {
 public:
  using Seconds = std::chrono::duration<double>;

  // `environment`: "NAME=value" added to ours. stdout and stderr are kept apart.
  explicit ChildProcess(const std::vector<std::string>& command,
                        const std::vector<std::string>& environment = {});
  ~ChildProcess();
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  pid_t pid() const { return pid_; }
  void Signal(int signal) const;
  // The next line of stdout, without its end. False at end of file or after the limit.
  bool ReadLine(std::string* line, Seconds limit = Seconds(20));
  // Waits for the end. The exit status, 128 + signal, or -1 after the limit.
  int Wait(Seconds limit = Seconds(20));
  // All of stderr so far; complete after Wait().
  std::string TakeErrors();

 private:
  pid_t pid_ = -1;
  int out_ = -1;
  int errors_ = -1;
  std::string buffer_;
  bool reaped_ = false;
};

}  // namespace parallax
