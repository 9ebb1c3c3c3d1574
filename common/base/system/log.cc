#include "common/base/system/log.h"

#include <spdlog/pattern_formatter.h>
#include <spdlog/sinks/basic_file_sink.h>
#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <atomic>
#include <charconv>
#include <cmath>
#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <utility>

#include "common/base/names.h"
#include "common/base/system/log_capture.h"

namespace parallax {

class LogCapture::Lines {
 public:
  void Add(std::string line) {
    constexpr size_t kMostLines = 200;
    const std::lock_guard lock(mu_);
    lines_.push_back(std::move(line));
    if (lines_.size() > kMostLines) lines_.pop_front();
  }
  std::string Text() const {
    const std::lock_guard lock(mu_);
    std::string text;
    for (const std::string& line : lines_) text += line + "\n";
    return text;
  }

 private:
  mutable std::mutex mu_;
  std::deque<std::string> lines_;  // Guarded by mu_.
};

namespace {

struct Logger {
  bool json = false;
  std::string program;
  std::shared_ptr<spdlog::logger> out;
};

constexpr char kTextPattern[] = "%Y-%m-%dT%H:%M:%S.%eZ %L %v";

spdlog::sink_ptr MakeSink(const std::string& file) {
  if (!file.empty()) {
    try {
      return std::make_shared<spdlog::sinks::basic_file_sink_mt>(file);
    } catch (const spdlog::spdlog_ex&) {
      // Lines on stderr are better than none.
    }
  }
  return std::make_shared<spdlog::sinks::stderr_sink_mt>();
}

std::shared_ptr<const Logger> MakeLogger(const LogOptions& options) {
  auto logger = std::make_shared<Logger>();
  logger->json = options.json;
  logger->program = options.program;
  logger->out = std::make_shared<spdlog::logger>("", MakeSink(options.file));
  constexpr spdlog::level::level_enum kLevels[] = {spdlog::level::debug, spdlog::level::info,
                                                   spdlog::level::warn, spdlog::level::err};
  logger->out->set_level(kLevels[static_cast<int>(options.level)]);
  logger->out->flush_on(spdlog::level::debug);
  logger->out->set_pattern(
      options.json ? "{\"time\":\"%Y-%m-%dT%H:%M:%S.%eZ\",\"level\":\"%l\",%v}" : kTextPattern,
      spdlog::pattern_time_type::utc);
  return logger;
}

// Captures by attempt.
struct Captures {
  std::mutex mu;
  std::map<uint64_t, std::shared_ptr<LogCapture::Lines>> by_fence;  // Guarded by mu.
};
Captures& TheCaptures() {
  static auto* captures = new Captures;  // As CurrentLogger.
  return *captures;
}

std::shared_ptr<LogCapture::Lines> CaptureOf(const LogContext& context) {
  if (!context.attempt) return nullptr;
  Captures& captures = TheCaptures();
  const std::lock_guard lock(captures.mu);
  const auto found = captures.by_fence.find(*context.attempt);
  return found == captures.by_fence.end() ? nullptr : found->second;
}

std::atomic<std::shared_ptr<const Logger>>& CurrentLogger() {
  // Never destroyed: threads may still log while the program ends.
  static auto* logger = new std::atomic<std::shared_ptr<const Logger>>(MakeLogger({}));
  return *logger;
}

LogContext& ThreadContext() {
  thread_local LogContext context;
  return context;
}

// Appends a text as JSON writes it between quotation marks.
void AppendEscaped(std::string& out, std::string_view text) {
  const std::string quoted =
      nlohmann::json(text).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  out.append(quoted, 1, quoted.size() - 2);
}

// Spells out characters that no line may hold: direction marks, C1 controls and bytes that are no
// UTF-8. Leaves the controls below 0x20 to AppendEscaped.
std::string Shown(std::string_view text) {
  if (IsPlainText(text)) return std::string(text);
  std::string shown;
  for (size_t begin = 0; begin < text.size();) {
    size_t end = begin;
    while (end < text.size() && static_cast<unsigned char>(text[end]) >= 0x20) ++end;
    shown += Printable(text.substr(begin, end - begin));
    if (end < text.size()) shown += text[end++];
    begin = end;
  }
  return shown;
}

bool NeedsQuotes(std::string_view text) {
  return text.empty() || !IsPlainText(text) ||
         text.find_first_of(" \t\n\r\"=\\") != std::string_view::npos;
}

void AppendField(std::string& line, bool json, const LogField& field) {
  line += json ? ",\"" : " ";
  line += field.key();
  line += json ? "\":" : "=";
  const bool quote = field.quoted() && (json || NeedsQuotes(field.text()));
  if (!quote) {
    line += field.text();
    return;
  }
  line += '"';
  AppendEscaped(line, Shown(field.text()));
  line += '"';
}

void AppendContext(std::string& line, bool json, const LogContext& context) {
  if (context.job) AppendField(line, json, {"job", *context.job});
  if (context.attempt) AppendField(line, json, {"attempt", *context.attempt});
  if (!context.study.empty()) AppendField(line, json, {"study", context.study});
  if (!context.variant.empty()) AppendField(line, json, {"variant", context.variant});
  if (context.scene) AppendField(line, json, {"scene", *context.scene});
  if (!context.worker.empty()) AppendField(line, json, {"worker", context.worker});
}

std::string TextOf(std::string_view message) {
  std::string text(message);
  std::replace(text.begin(), text.end(), '\n', ' ');  // One record, one line.
  return Printable(text);
}

void Capture(LogCapture::Lines& lines, spdlog::level::level_enum level, std::string_view message,
             std::initializer_list<LogField> fields) {
  std::string text = TextOf(message);
  for (const LogField& field : fields) AppendField(text, /*json=*/false, field);
  spdlog::pattern_formatter formatter(kTextPattern, spdlog::pattern_time_type::utc, "");
  spdlog::memory_buf_t line;
  formatter.format(
      spdlog::details::log_msg("", level, spdlog::string_view_t(text.data(), text.size())), line);
  lines.Add(std::string(line.data(), line.size()));
}

}  // namespace

LogCapture::LogCapture(uint64_t fence) : fence_(fence), lines_(std::make_shared<Lines>()) {
  Captures& captures = TheCaptures();
  const std::lock_guard lock(captures.mu);
  captures.by_fence[fence_] = lines_;
}

LogCapture::~LogCapture() {
  Captures& captures = TheCaptures();
  const std::lock_guard lock(captures.mu);
  captures.by_fence.erase(fence_);
}

std::string LogCapture::Text() const { return lines_->Text(); }

LogField::LogField(std::string_view key, double value) : key_(key), quoted_(false) {
  if (!std::isfinite(value)) {  // JSON has no such number.
    text_ = std::isnan(value) ? "nan" : value > 0 ? "inf" : "-inf";
    quoted_ = true;
    return;
  }
  char buffer[32];
  const auto end =
      std::to_chars(buffer, buffer + sizeof(buffer), value, std::chars_format::general, 6);
  text_.assign(buffer, end.ptr);
}

void InitLogging(const LogOptions& options) { CurrentLogger().store(MakeLogger(options)); }

absl::StatusOr<LogLevel> ParseLogLevel(std::string_view name) {
  if (name == "debug") return LogLevel::kDebug;
  if (name == "info") return LogLevel::kInfo;
  if (name == "warning") return LogLevel::kWarning;
  if (name == "error") return LogLevel::kError;
  return InvalidArgument("log level '{}': allowed debug, info, warning, error", name);
}

void Log(LogLevel level, std::string_view message, std::initializer_list<LogField> fields) {
  const std::shared_ptr<const Logger> logger = CurrentLogger().load();
  constexpr spdlog::level::level_enum kLevels[] = {spdlog::level::debug, spdlog::level::info,
                                                   spdlog::level::warn, spdlog::level::err};
  const spdlog::level::level_enum spdlog_level = kLevels[static_cast<int>(level)];
  const std::shared_ptr<LogCapture::Lines> capture =
      level == LogLevel::kDebug ? nullptr : CaptureOf(ThreadContext());
  if (capture != nullptr) Capture(*capture, spdlog_level, message, fields);
  if (!logger->out->should_log(spdlog_level)) return;

  std::string line;
  if (logger->json) {
    line += "\"program\":\"";
    AppendEscaped(line, logger->program);
    line += "\",\"message\":\"";
    AppendEscaped(line, Shown(message));
    line += '"';
  } else {
    if (!logger->program.empty()) line += logger->program + ": ";
    line += TextOf(message);
  }
  AppendContext(line, logger->json, ThreadContext());
  for (const LogField& field : fields) AppendField(line, logger->json, field);
  logger->out->log(spdlog_level, spdlog::string_view_t(line.data(), line.size()));
}

LogContext CurrentLogContext() { return ThreadContext(); }

ScopedLogContext::ScopedLogContext(const LogContext& context) : outer_(ThreadContext()) {
  LogContext& current = ThreadContext();
  if (context.job) current.job = context.job;
  if (context.attempt) current.attempt = context.attempt;
  if (!context.study.empty()) current.study = context.study;
  if (!context.variant.empty()) current.variant = context.variant;
  if (context.scene) current.scene = context.scene;
  if (!context.worker.empty()) current.worker = context.worker;
}

ScopedLogContext::~ScopedLogContext() { ThreadContext() = std::move(outer_); }

}  // namespace parallax
