// Structured log lines on stderr: a message for people plus key=value fields, as text or as one
// JSON object a line. Job, study, variant, scene, attempt and worker stand in every line written
// while a ScopedLogContext names them.
//
// Thread-safe. Before InitLogging lines are written as text from level info.
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

struct LogOptions {
  bool json = false;
  LogLevel level = LogLevel::kInfo;  // Lines below it are dropped.
  std::string program;               // Stands in every line: "worker".
  std::string file;                  // Lines are appended here; empty, or not writable: stderr.
};

// Sets up the process's log; a later call replaces the settings.
void InitLogging(const LogOptions& options);

// "debug", "info", "warning" or "error". Errors: kInvalidArgument listing them.
absl::StatusOr<LogLevel> ParseLogLevel(std::string_view name);

// One key and its value. Numbers and booleans stay such in JSON.
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

// What the work at hand belongs to. Absent parts don't stand in the line.
struct LogContext {
  std::optional<int64_t> job;
  std::optional<uint64_t> attempt;  // The fence.
  std::string study;
  std::string variant;
  std::optional<uint32_t> scene;
  std::string worker;
};

// The calling thread's context, to hand on to a thread that works for it.
LogContext CurrentLogContext();

// While it lives, the calling thread's lines carry `context`; parts that are absent keep the value
// of the context around it. Must end on the thread that made it, innermost first.
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
