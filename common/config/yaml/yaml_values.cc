#include "common/config/yaml/yaml_values.h"

#include <algorithm>
#include <charconv>
#include <limits>
#include <set>

#include "common/base/edit_distance.h"
#include "common/base/names.h"
#include "common/config/check/field_rules.h"

namespace parallax::config_internal {
namespace {

constexpr size_t kMostShown = 60;  // Bytes of a value.

// Only plain scalars are numbers and booleans: "5" in quotes is text.
bool IsPlain(const YAML::Node& node) { return node.IsScalar() && node.Tag() == "?"; }

// A number that fills the whole text; nothing if it is none of its type.
template <typename Number>
std::optional<Number> ParseWhole(std::string_view text) {
  if (!text.empty() && text.front() == '+') text.remove_prefix(1);
  Number value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

}  // namespace

std::string Seen(const YAML::Node& node) {
  if (node.IsMap()) return "a map";
  if (node.IsSequence()) return "a list";
  if (node.IsScalar()) {
    return IsPlain(node) && IsPlainText(node.Scalar()) && node.Scalar().size() <= kMostShown
               ? node.Scalar()
               : Quoted(node.Scalar());
  }
  return "nothing";
}

std::optional<double> PlainNumber(const YAML::Node& node) {
  return IsPlain(node) ? ParseWhole<double>(node.Scalar()) : std::nullopt;
}

Origin YamlValues::OriginOf(const YAML::Node& node, std::string_view path) const {
  YAML::Mark mark = node.Mark();
  if (node.IsNull()) {
    if (const auto key = keys_.find(mark.pos); key != keys_.end()) mark = key->second;
  }
  return {file_, mark.is_null() ? 0 : mark.line + 1, std::string(path)};
}

void YamlValues::Error(const YAML::Node& node, std::string_view path, std::string_view what) {
  errors_.Add(OriginOf(node, path), what);
}

std::vector<std::pair<std::string, YAML::Node>> YamlValues::Entries(const YAML::Node& node,
                                                                    const std::string& path) {
  std::vector<std::pair<std::string, YAML::Node>> entries;
  if (!node.IsMap()) {
    Error(node, path, Seen(node) + ", allowed is a map of fields");
    return entries;
  }
  std::set<std::string> names;
  for (const auto& entry : node) {
    if (!entry.first.IsScalar()) {
      Error(entry.first, path, Seen(entry.first) + " as a key, allowed is a field name");
      continue;
    }
    const std::string name = entry.first.Scalar();
    if (!names.insert(name).second) {
      Error(entry.first, Dotted(path, name), "given twice, allowed once");
    }
    if (entry.second.IsNull()) keys_[entry.second.Mark().pos] = entry.first.Mark();
    entries.emplace_back(name, entry.second);
  }
  return entries;
}

void YamlValues::UnknownField(const YAML::Node& node, const std::string& path,
                              const std::string& name, const std::vector<std::string>& known) {
  Error(node, Dotted(path, name),
        "no such field" + NearestHint(name, known) + " (allowed: " + JoinNames(known) + ")");
}

std::optional<int64_t> YamlValues::ReadInt(const YAML::Node& node, const std::string& path,
                                           int64_t min, int64_t max, std::string_view unit) {
  v1::FieldRule rule;
  rule.set_integer(true);
  if (min != std::numeric_limits<int64_t>::min()) rule.set_min(static_cast<double>(min));
  if (max != std::numeric_limits<int64_t>::max()) rule.set_max(static_cast<double>(max));
  rule.set_unit(std::string(unit));
  const std::optional<int64_t> value =
      IsPlain(node) ? ParseWhole<int64_t>(node.Scalar()) : std::nullopt;
  if (!value) {
    Error(node, path, Seen(node) + " is not a whole number, allowed " + AllowedRange(rule));
    return std::nullopt;
  }
  if (*value < min || *value > max) {
    Error(node, path, Seen(node) + " is out of range, allowed " + AllowedRange(rule));
    return std::nullopt;
  }
  return value;
}

std::optional<uint64_t> YamlValues::ReadUint64(const YAML::Node& node, const std::string& path) {
  const std::optional<uint64_t> value =
      IsPlain(node) ? ParseWhole<uint64_t>(node.Scalar()) : std::nullopt;
  if (!value) Error(node, path, Seen(node) + ", allowed is a whole number from 0 to 2^64 - 1");
  return value;
}

std::optional<std::string> YamlValues::ReadText(const YAML::Node& node, const std::string& path) {
  if (node.IsScalar()) return node.Scalar();
  Error(node, path, Seen(node) + ", allowed is a text");
  return std::nullopt;
}

std::optional<double> YamlValues::ReadNumber(const YAML::Node& node, const std::string& path,
                                             const v1::FieldRule& rule) {
  const std::optional<double> value = PlainNumber(node);
  if (!value) Error(node, path, Seen(node) + " is not a number, allowed " + AllowedRange(rule));
  return value;
}

std::optional<bool> YamlValues::ReadBool(const YAML::Node& node, const std::string& path) {
  if (IsPlain(node) && node.Scalar() == "true") return true;
  if (IsPlain(node) && node.Scalar() == "false") return false;
  Error(node, path, Seen(node) + ", allowed is true or false");
  return std::nullopt;
}

}  // namespace parallax::config_internal
