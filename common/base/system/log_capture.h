// Keeps the last log lines of one attempt, to be sent along when it fails.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

namespace parallax {

// While it lives, keeps the newest lines that any thread logs in the context of attempt `fence`
// (ScopedLogContext) at level info or above, even if the log's own level drops them. At most one
// capture an attempt. Thread-safe.
class LogCapture {
 public:
  explicit LogCapture(uint64_t fence);
  ~LogCapture();
  LogCapture(const LogCapture&) = delete;
  LogCapture& operator=(const LogCapture&) = delete;

  // Returns at most 200 lines, the oldest first, in the log's text form without the context.
  std::string Text() const;

  class Lines;

 private:
  const uint64_t fence_;
  const std::shared_ptr<Lines> lines_;
};

}  // namespace parallax
