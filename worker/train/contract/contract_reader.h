// Reads the fields of a trainer's YAML file and keeps the errors of all of them.
#pragma once

#include <yaml-cpp/yaml.h>

#include <cstdint>
#include <set>
#include <string>
#include <vector>

namespace parallax {

// "a, b, c".
std::string Listed(const std::vector<std::string>& names);

// Returns the names of placeholders in `text`, in order, without braces.
std::vector<std::string> PlaceholdersIn(const std::string& text);

class ContractReader {
 public:
  explicit ContractReader(std::string file) : file_(std::move(file)) {}

  // Adds "FILE:LINE: what"; the line is that of `node`.
  void Error(const YAML::Node& node, const std::string& what);

  // Tells of keys that are not in `known`, and of a node that is no map.
  void CheckKeys(const YAML::Node& map, const std::string& where,
                 const std::vector<std::string>& known);

  // Return the field `key`; an empty or zero value, with an error, where it is of another kind, and
  // without one where it is absent and not `needed`.
  std::string Text(const YAML::Node& map, const char* key, bool needed);
  std::vector<std::string> Texts(const YAML::Node& map, const char* key, bool needed);
  int64_t Count(const YAML::Node& map, const char* key);  // >= 0
  double Number(const YAML::Node& map, const char* key);  // >= 0

  // Tells of placeholders of `command` that are not in `known`.
  void CheckPlaceholders(const YAML::Node& node, const std::vector<std::string>& command,
                         const std::set<std::string>& known);

  // All errors, one a line; empty: none.
  const std::string& errors() const { return errors_; }

 private:
  std::string file_, errors_;
};

}  // namespace parallax
