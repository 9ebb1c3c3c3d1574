// Inner part of common/config: reads scalars and the entries of maps in the YAML tree of one file,
// and collects the errors of values that are not of the wanted type. An error names the file, the
// line, and the path of fields that lead to the value.
#pragma once

#include <yaml-cpp/yaml.h>

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "common/config/check/config_errors.h"
#include "parallax/v1/config.pb.h"

namespace parallax::config_internal {

// Describes a node for a message: its text, or its kind.
std::string Seen(const YAML::Node& node);
// Returns the number that a node without quotes holds; nothing if it holds none.
std::optional<double> PlainNumber(const YAML::Node& node);

// Reads the values of one file. `path` names the fields that lead to `node`. Errors go to `errors`,
// which must outlive the reader. Not thread-safe.
class YamlValues {
 public:
  YamlValues(std::string file, ConfigErrors* errors) : file_(std::move(file)), errors_(*errors) {}

  // Returns key and value of each entry of a map. Duplicate keys, keys that are not texts, and
  // nodes that are not maps go to `errors`.
  std::vector<std::pair<std::string, YAML::Node>> Entries(const YAML::Node& node,
                                                          const std::string& path);

  // Read a scalar. Return nothing for a wrong one, which is then in `errors`. Ranges are inclusive.
  // ReadNumber takes any number; `rule` only words what is allowed.
  std::optional<int64_t> ReadInt(const YAML::Node& node, const std::string& path, int64_t min,
                                 int64_t max, std::string_view unit = "");
  std::optional<uint64_t> ReadUint64(const YAML::Node& node, const std::string& path);
  std::optional<double> ReadNumber(const YAML::Node& node, const std::string& path,
                                   const v1::FieldRule& rule);
  std::optional<std::string> ReadText(const YAML::Node& node, const std::string& path);
  std::optional<bool> ReadBool(const YAML::Node& node, const std::string& path);

  // Returns the place of `node`.
  Origin OriginOf(const YAML::Node& node, std::string_view path) const;
  // Adds an error at `node`. UnknownField also suggests the most similar of the `known` names.
  void Error(const YAML::Node& node, std::string_view path, std::string_view what);
  void UnknownField(const YAML::Node& node, const std::string& path, const std::string& name,
                    const std::vector<std::string>& known);

  const std::string& file() const { return file_; }
  ConfigErrors& errors() { return errors_; }

 private:
  const std::string file_;
  ConfigErrors& errors_;
  // Places of the keys of empty values, by what yaml-cpp gives as their own: that of what follows.
  std::map<int, YAML::Mark> keys_;
};

}  // namespace parallax::config_internal
