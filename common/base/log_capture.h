// The last log lines of one attempt, for whoever asks why it failed.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

namespace parallax {

// While it lives, keeps the newest lines that are logged in the context of attempt `fence`
// (ScopedLogContext), by whatever thread, at level info and above whatever the log itself holds.
// One capture an attempt. Thread-safe.
class LogCapture {
 public:
  explicit LogCapture(uint64_t fence);
  ~LogCapture();
  LogCapture(const LogCapture&) = delete;
  LogCapture& operator=(const LogCapture&) = delete;

  // At most 200 lines, the oldest first, as the log has them in its form for people, but without
  // the context.
  std::string Text() const;

  class Lines;

 private:
  const uint64_t fence_;
  const std::shared_ptr<Lines> lines_;
};

}  // namespace parallax
