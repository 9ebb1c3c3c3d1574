// A program started by a test: its output in files, its end by its own pid.
#pragma once

#include <sys/types.h>

#include <functional>
#include <string>
#include <vector>

namespace parallax::e2e {

class Process {
 public:
  // Starts `arguments[0]`; stdout and stderr go to <dir>/<name>.out and .err. Extra environment as
  // "NAME=value".
  Process(const std::vector<std::string>& arguments, const std::string& dir,
          const std::string& name, const std::vector<std::string>& environment = {});
  ~Process();  // Kills it if it still runs.
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;

  pid_t pid() const { return pid_; }
  bool Running();
  void Signal(int signal);
  // Exit status, or 128 + signal.
  int Wait();
  std::string Out() const;
  std::string Err() const;
  // Processes whose parent this is.
  std::vector<pid_t> Children() const;

 private:
  pid_t pid_ = -1;
  int status_ = -1;
  bool ended_ = false;
  std::string out_path_;
  std::string err_path_;
};

std::string ReadText(const std::string& path);
// True as soon as `condition` is; false when `process` ends first.
bool WaitUntil(Process& process, const std::function<bool()>& condition);
// Alive, and not just waiting to be reaped.
bool IsAlive(pid_t pid);

}  // namespace parallax::e2e
