#include "coordinator/queue/commands/report_check.h"

#include <fmt/core.h>

#include <algorithm>

#include "common/base/names.h"
#include "coordinator/queue/database/stored_size.h"

namespace parallax {

bool IsSha256Hex(std::string_view text) {
  return text.size() == 64 && std::all_of(text.begin(), text.end(), [](char c) {
           return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f');
         });
}

bool IsConfinedPath(std::string_view path) {
  if (path.empty() || path.size() > 4096) return false;
  for (size_t begin = 0; begin <= path.size();) {
    const size_t end = std::min(path.find('/', begin), path.size());
    const std::string_view part = path.substr(begin, end - begin);
    if (part.empty() || part == "." || part == "..") return false;
    begin = end + 1;
  }
  return std::none_of(path.begin(), path.end(),
                      [](char c) { return c == '\\' || static_cast<unsigned char>(c) < 0x20; });
}

std::string OneLine(std::string_view text) {
  constexpr size_t kMostBytes = 1000;
  std::string line = CutText(text, kMostBytes);
  std::replace_if(
      line.begin(), line.end(), [](char c) { return static_cast<unsigned char>(c) < 0x20; }, ' ');
  return CutText(Printable(line), kMostBytes);
}

std::string LogTail(std::string_view text) {
  constexpr size_t kMostRead = 4 * kMaxLogTail;
  if (text.size() > kMostRead) text.remove_prefix(text.size() - kMostRead);
  std::string tail;
  while (!text.empty()) {
    if (text.back() == '\n') text.remove_suffix(1);
    const size_t end = text.rfind('\n');
    const size_t begin = end == std::string_view::npos ? 0 : end + 1;
    const std::string line = CutText(Printable(text.substr(begin)), kMaxLogTail - 1) + "\n";
    if (tail.size() + line.size() > kMaxLogTail) break;
    tail.insert(0, line);
    text = text.substr(0, begin);
  }
  return tail;
}

CheckedReport CheckReport(const v1::CompleteRequest& request, const KindRegistry& kinds) {
  CheckedReport report;
  report.attempt = request.attempt();
  report.worker = request.worker();
  const absl::StatusOr<KindId> kind = kinds.IdOf(request.kind());
  if (!kind.ok()) {
    report.invalid = std::string(kind.status().message());
    return report;
  }
  report.kind = *kind;
  if (request.result().size() > kMaxStoredBytes) {
    report.invalid = fmt::format("a result of {} bytes, wanted at most {}", request.result().size(),
                                 kMaxStoredBytes);
    return report;
  }
  report.result = kinds[*kind].CheckResult(request.result());
  report.invalid = report.result->invalid;
  return report;
}

}  // namespace parallax
