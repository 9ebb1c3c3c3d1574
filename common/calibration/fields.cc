#include "common/calibration/fields.h"

#include <fmt/core.h>

#include <charconv>
#include <cmath>

#include "common/base/names.h"

namespace parallax::calibration_internal {
namespace {

constexpr std::string_view kBlanks = " \t\r\n";
constexpr std::string_view kSeparators = " \t\r\n,;[]";

std::string_view Trimmed(std::string_view text) {
  const size_t first = text.find_first_not_of(kBlanks);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kBlanks) - first + 1);
}

std::optional<double> NumberOf(std::string_view text) {
  if (!text.empty() && text.front() == '+') text.remove_prefix(1);
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  // OpenCV writes whole doubles as "1.".
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) {
    return std::nullopt;
  }
  return value;
}

bool IsPixels(double value) { return value == std::floor(value) && value >= 1 && value <= 16384; }

}  // namespace

void Fields::Add(const std::string& name, std::string text, int line) {
  by_name_.insert({name, {std::move(text), line}});
}

std::string Fields::FirstOf(const std::vector<std::string>& names) const {
  for (const std::string& name : names) {
    if (Has(name)) return name;
  }
  return "";
}

std::vector<std::string> Fields::Names() const {
  std::vector<std::string> names;
  for (const auto& [name, value] : by_name_) names.push_back(name);
  return names;
}

int Fields::LineOf(const std::string& name) const {
  const auto found = by_name_.find(name);
  return found == by_name_.end() ? 0 : found->second.line;
}

std::string Fields::Text(const std::string& name) const {
  const auto found = by_name_.find(name);
  return found == by_name_.end() ? "" : std::string(Trimmed(found->second.text));
}

absl::StatusOr<std::vector<double>> Fields::Numbers(const std::string& name, size_t count) const {
  const auto found = by_name_.find(name);
  const std::string allowed = count == 0   ? "numbers"
                              : count == 1 ? "a number"
                                           : fmt::format("{} numbers", count);
  if (found == by_name_.end()) return Error(name, "missing, allowed is " + allowed);
  std::vector<double> numbers;
  const std::string_view text = found->second.text;
  for (size_t begin = text.find_first_not_of(kSeparators); begin != std::string_view::npos;) {
    const size_t end = std::min(text.find_first_of(kSeparators, begin), text.size());
    const std::string_view word = text.substr(begin, end - begin);
    const std::optional<double> number = NumberOf(word);
    if (!number) return Error(name, Quoted(word) + " is not a number, allowed is " + allowed);
    numbers.push_back(*number);
    begin = text.find_first_not_of(kSeparators, end);
  }
  if (count != 0 && numbers.size() != count) {
    return Error(name, fmt::format("{} numbers, allowed is {}", numbers.size(), allowed));
  }
  return numbers;
}

absl::StatusOr<double> Fields::Number(const std::string& name) const {
  ASSIGN_OR_RETURN(const std::vector<double> numbers, Numbers(name, 1));
  return numbers[0];
}

absl::StatusOr<double> Fields::NumberOr(const std::string& name, double otherwise) const {
  if (!Has(name)) return otherwise;
  return Number(name);
}

absl::StatusOr<int> Fields::Pixels(const std::string& name) const {
  ASSIGN_OR_RETURN(const double value, Number(name));
  if (!IsPixels(value)) {
    return Error(name, Quoted(Text(name)) + ", allowed is a whole number from 1 to 16384");
  }
  return static_cast<int>(value);
}

absl::StatusOr<std::pair<int, int>> Fields::Size(const std::string& name) const {
  ASSIGN_OR_RETURN(const std::vector<double> size, Numbers(name, 2));
  if (!IsPixels(size[0]) || !IsPixels(size[1])) {
    return Error(name, Quoted(Text(name)) + ", allowed are whole numbers from 1 to 16384");
  }
  return std::pair(static_cast<int>(size[0]), static_cast<int>(size[1]));
}

absl::Status Fields::Error(const std::string& name, std::string_view what) const {
  const auto found = by_name_.find(name);
  const std::string line = found == by_name_.end() || found->second.line == 0
                               ? ""
                               : fmt::format("{}:", found->second.line);
  return InvalidArgument("{}:{} {}: {}", file_, line, Printable(name), what);
}

Fields ReadLines(std::string_view text, const std::string& file, char separator) {
  Fields fields(file);
  std::string section;
  int number = 0;
  for (size_t begin = 0; begin < text.size();) {
    const size_t end = std::min(text.find('\n', begin), text.size());
    const std::string_view line = Trimmed(text.substr(begin, end - begin));
    ++number;
    begin = end + 1;
    if (line.size() > 2 && line.front() == '[' && line.back() == ']') {
      section = std::string(line.substr(1, line.size() - 2)) + ".";
      continue;
    }
    const size_t at = line.find(separator);
    if (at == std::string_view::npos || at == 0) continue;
    fields.Add(section + std::string(Trimmed(line.substr(0, at))),
               std::string(Trimmed(line.substr(at + 1))), number);
  }
  return fields;
}

}  // namespace parallax::calibration_internal
