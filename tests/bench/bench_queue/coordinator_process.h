// The program `coordinator` as a child process, on a loopback port of its own choice.
#pragma once

#include <memory>
#include <string>

#include "common/base/status.h"

namespace parallax {

class CoordinatorProcess {
 public:
  struct Options {
    std::string program;
    std::string db;
    std::string store;
    std::string log;  // Its stderr.
    double lease_s = 60;
    std::string limits;  // File of limits; empty: none.
  };
  // Returns when it listens. Errors: kUnavailable when it ended or didn't get ready.
  static absl::StatusOr<std::unique_ptr<CoordinatorProcess>> Start(const Options& options);
  ~CoordinatorProcess();  // Kill().

  const std::string& address() const { return address_; }            // "127.0.0.1:41234"
  const std::string& http_address() const { return http_address_; }  // "127.0.0.1:41235"
  int pid() const { return pid_; }

  absl::Status Terminate();  // SIGTERM, and waits for a clean end.
  void Kill();               // SIGKILL, and waits. Idempotent.

 private:
  explicit CoordinatorProcess(int pid) : pid_(pid) {}
  int pid_;
  std::string address_, http_address_;
};

// Seconds that GET http://ADDRESS/ takes, its body read; an error unless it answers 200.
absl::StatusOr<double> TimeGet(const std::string& address, const std::string& path);

}  // namespace parallax
