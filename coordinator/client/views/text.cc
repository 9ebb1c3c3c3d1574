#include "coordinator/client/views/text.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <ctime>

namespace parallax::client {
namespace {

// Numbers from here on, and below the least, are written with an exponent.
constexpr double kMostWhole = 1e15;
constexpr double kLeastPlain = 1e-6;

}  // namespace

namespace {

std::vector<std::string> LinesOf(std::string_view text) {
  std::vector<std::string> lines;
  while (!text.empty()) {
    const size_t end = std::min(text.find('\n'), text.size());
    lines.emplace_back(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return lines;
}

// Whether `old` are the lines of `now` from `at` on. Either's first line may lack its begin, the
// last of `old` its end.
bool IsAt(std::span<const std::string> old, const std::vector<std::string>& now, size_t at) {
  if (at + old.size() > now.size()) return false;
  for (size_t i = 0; i < old.size(); ++i) {
    const std::string &a = old[i], &b = now[at + i];
    const bool same = a == b || (i + 1 == old.size() && !a.empty() && b.starts_with(a)) ||
                      (i == 0 && !a.empty() && !b.empty() && (a.ends_with(b) || b.ends_with(a)));
    if (!same) return false;
  }
  return true;
}

}  // namespace

std::vector<std::string> NewLines(std::string_view before, std::string_view now) {
  const std::vector<std::string> old = LinesOf(before);
  std::vector<std::string> lines = LinesOf(now);
  const auto rest_from = [&](size_t at) {
    // The last line that both have comes again if there is more of it now. The first one may only
    // have more of its begin.
    const bool is_longer = !old.empty() && lines[at - 1].size() > old.back().size();
    if (is_longer && (at > 1 || lines[0].starts_with(old.back()))) --at;
    return std::vector<std::string>(lines.begin() + static_cast<std::ptrdiff_t>(at), lines.end());
  };
  if (old.empty()) return lines;
  for (size_t at = 0; at + old.size() <= lines.size(); ++at) {
    if (IsAt(old, lines, at)) return rest_from(at + old.size());
  }
  for (size_t from = 1; from < old.size(); ++from) {
    const std::span<const std::string> end = std::span(old).subspan(from);
    if (IsAt(end, lines, 0)) return rest_from(end.size());
  }
  lines.insert(lines.begin(), "...");
  return lines;
}

std::string FormatDuration(double seconds) {
  if (!std::isfinite(seconds) || seconds < 0) return "-";
  if (seconds >= kMostWhole) return fmt::format("{:.3g} s", seconds);
  if (seconds < 9.95) return fmt::format("{:.1f} s", seconds);
  const auto whole = std::llround(seconds);
  if (whole < 60) return fmt::format("{} s", whole);
  if (whole < 3600) return fmt::format("{}:{:02}", whole / 60, whole % 60);
  if (whole < 48 * 3600) {
    return fmt::format("{}:{:02}:{:02}", whole / 3600, whole / 60 % 60, whole % 60);
  }
  return fmt::format("{} d {} h", whole / 86400, whole / 3600 % 24);
}

std::string FormatAbout(double seconds) {
  if (!std::isfinite(seconds) || seconds < 0) return "-";
  struct Scale {
    double below_s;  // Longer ones have the next scale.
    double step_s;   // Is rounded to.
    double unit_s;
    const char* unit;
  };
  static constexpr Scale kScales[] = {{57.5, 5, 1, "s"},         {570, 60, 60, "min"},
                                      {3450, 300, 60, "min"},    {34200, 1800, 3600, "h"},
                                      {171000, 3600, 3600, "h"}, {1e300, 86400, 86400, "d"}};
  for (const Scale& scale : kScales) {
    if (seconds >= scale.below_s) continue;
    const double rounded = std::max(1.0, std::round(seconds / scale.step_s)) * scale.step_s;
    return fmt::format("about {:g} {}", rounded / scale.unit_s, scale.unit);
  }
  return "-";
}

std::string FormatBytes(double bytes) {
  static constexpr std::array<const char*, 5> kUnits = {"B", "kB", "MB", "GB", "TB"};
  size_t unit = 0;
  while (bytes >= 999.5 && unit + 1 < kUnits.size()) {
    bytes /= 1000;
    ++unit;
  }
  return fmt::format("{:.{}f} {}", bytes, unit > 0 && bytes < 9.95 ? 1 : 0, kUnits[unit]);
}

std::string FormatCount(int64_t count) {
  // Negated as unsigned: the least number has no positive counterpart.
  const auto magnitude = static_cast<uint64_t>(count);
  std::string digits = std::to_string(count < 0 ? -magnitude : magnitude);
  for (int at = static_cast<int>(digits.size()) - 3; at > 0; at -= 3) {
    digits.insert(static_cast<size_t>(at), ",");
  }
  return count < 0 ? "-" + digits : digits;
}

std::string FormatNumber(double value) {
  if (!std::isfinite(value)) return "-";
  const double size = std::abs(value);
  if (size == 0) return "0";
  if (size >= kMostWhole || size < kLeastPlain) return fmt::format("{:.3g}", value);
  if (size >= 999.5) return FormatCount(std::llround(value));
  const int decimals = std::clamp(2 - static_cast<int>(std::floor(std::log10(size))), 0, 6);
  return fmt::format("{:.{}f}", value, decimals);
}

std::string Plural(int64_t count, std::string_view singular, std::string_view plural) {
  std::string text = FormatCount(count) + " ";
  if (count == 1) return text.append(singular);
  return plural.empty() ? text.append(singular).append("s") : text.append(plural);
}

std::string FormatUnixTime(double unix_s) {
  if (unix_s <= 0) return "-";
  const auto seconds = static_cast<time_t>(unix_s);
  tm local{};
  localtime_r(&seconds, &local);
  char buffer[64];
  std::strftime(buffer, sizeof buffer, "%Y-%m-%d %H:%M:%S", &local);
  return buffer;
}

std::string Sparkline(std::span<const double> values, int columns, bool unicode) {
  static constexpr std::array<const char*, 8> kBlocks = {"▁", "▂", "▃", "▄", "▅", "▆", "▇", "█"};
  static constexpr std::array<const char*, 8> kAscii = {"_", ".", ",", "-", "~", "=", "+", "#"};
  if (values.empty() || columns < 1) return "";
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  const double range = *high - *low;
  const size_t count = std::min(values.size(), static_cast<size_t>(columns));
  std::string line;
  for (size_t i = 0; i < count; ++i) {
    const size_t at = count == 1 ? 0 : i * (values.size() - 1) / (count - 1);
    const double height = range > 0 ? (values[at] - *low) / range : 0;
    const auto level = static_cast<size_t>(std::clamp(height * 7.999, 0.0, 7.0));
    line += unicode ? kBlocks[level] : kAscii[level];
  }
  return line;
}

std::string FirstLine(std::string_view text) {
  text = text.substr(0, text.find('\n'));
  while (!text.empty() && (text.back() == ' ' || text.back() == '\r')) text.remove_suffix(1);
  return std::string(text);
}

std::string WhyNotSeed(const std::string& text) {
  uint64_t seed = 0;
  const char* const end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, seed);
  if (error == std::errc() && stop == end) return "";
  return text + ", allowed is a whole number from 0 to 2^64 - 1";
}

std::string LowerName(std::string_view name, std::string_view prefix) {
  if (name.substr(0, prefix.size()) == prefix) name.remove_prefix(prefix.size());
  std::string lower(name);
  for (char& c : lower) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return lower;
}

}  // namespace parallax::client
