// Structured logging to stderr or a file: a message for people plus key=value fields, as text or as
// one JSON object a line. While a ScopedLogContext names a job, study, variant, scene, attempt or
// worker, every line has it as a field.
//
// Thread-safe. Before InitLogging is called, lines from level info upwards are written as text.
#pragma once

#include <concepts>
#include <cstdint>
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>

#include "common/base/status.h"

namespace parallax {

enum class LogLevel { kDebug, kInfo, kWarning, kError };

// Settings of the process's log.
struct LogOptions {
  bool json = false;
  LogLevel level = LogLevel::kInfo;  // Lines below it are dropped.
  std::string program;               // Name in every line: "worker".
  std::string file;                  // Appended to; empty or not writable: stderr.
};

// Sets up the process's log; a later call replaces the settings.
void InitLogging(const LogOptions& options);

// Parses "debug", "info", "warning" or "error". Errors: kInvalidArgument that lists these names.
absl::StatusOr<LogLevel> ParseLogLevel(std::string_view name);

// One key and its value. Numbers and booleans keep their type in JSON.
class LogField {
 public:
  LogField(std::string_view key, std::string_view value) : key_(key), text_(value) {}
  LogField(std::string_view key, const char* value) : LogField(key, std::string_view(value)) {}
  LogField(std::string_view key, const std::string& value)
      : LogField(key, std::string_view(value)) {}
  LogField(std::string_view key, const absl::Status& status)
      : LogField(key, std::string_view(status.ToString())) {}
  LogField(std::string_view key, bool value)
      : key_(key), text_(value ? "true" : "false"), quoted_(false) {}
  LogField(std::string_view key, double value);
  template <std::integral Integer>
  requires(!std::same_as<Integer, bool>) LogField(std::string_view key, Integer value)
      : key_(key), text_(std::to_string(value)), quoted_(false) {}

  const std::string& key() const { return key_; }
  const std::string& text() const { return text_; }
  bool quoted() const { return quoted_; }  // Text rather than a number or boolean.

 private:
  std::string key_;
  std::string text_;
  bool quoted_ = true;
};

// Writes one line if `level` is enabled. Control characters in `message` and in the fields are
// escaped, so a line never breaks in two:
//   LogInfo("study submitted", {{"study", name}, {"pairs", pairs}});
void Log(LogLevel level, std::string_view message, std::initializer_list<LogField> fields = {});

inline void LogDebug(std::string_view message, std::initializer_list<LogField> fields = {}) {
  Log(LogLevel::kDebug, message, fields);
}
inline void LogInfo(std::string_view message, std::initializer_list<LogField> fields = {}) {
  Log(LogLevel::kInfo, message, fields);
}
inline void LogWarning(std::string_view message, std::initializer_list<LogField> fields = {}) {
  Log(LogLevel::kWarning, message, fields);
}
inline void LogError(std::string_view message, std::initializer_list<LogField> fields = {}) {
  Log(LogLevel::kError, message, fields);
}

// Names the work that log lines belong to. Parts that are absent or empty are left out of the line.
struct LogContext {
  std::optional<int64_t> job;
  std::optional<uint64_t> attempt;  // The fence.
  std::string study;
  std::string variant;
  std::optional<uint32_t> scene;
  std::string worker;
};

// Returns the calling thread's context, to be passed to a thread that works for it.
LogContext CurrentLogContext();

// While it lives, lines of the calling thread carry `context`. Parts that are absent keep the value
// of the enclosing context. Must be destroyed on the thread that made it, innermost first.
class ScopedLogContext {
 public:
  explicit ScopedLogContext(const LogContext& context);
  ~ScopedLogContext();
  ScopedLogContext(const ScopedLogContext&) = delete;
  ScopedLogContext& operator=(const ScopedLogContext&) = delete;

 private:
  LogContext outer_;
};

}  // namespace parallax
