#include "worker/train/contract/contract_reader.h"

#include <fmt/core.h>

#include <algorithm>
#include <regex>

namespace parallax {

std::string Listed(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return text;
}

std::vector<std::string> PlaceholdersIn(const std::string& text) {
  static const std::regex kName(R"(\{([a-z_]+)\})");
  std::vector<std::string> names;
  for (std::sregex_iterator it(text.begin(), text.end(), kName), end; it != end; ++it)
    names.push_back((*it)[1]);
  return names;
}

void ContractReader::Error(const YAML::Node& node, const std::string& what) {
  const int line = node && node.Mark().line >= 0 ? node.Mark().line + 1 : 0;
  errors_ += (errors_.empty() ? "" : "\n") + file_ + (line > 0 ? fmt::format(":{}", line) : "") +
             ": " + what;
}

void ContractReader::CheckKeys(const YAML::Node& map, const std::string& where,
                               const std::vector<std::string>& known) {
  if (!map.IsMap()) return Error(map, where + " must be a map");
  for (const auto& entry : map) {
    const std::string key = entry.first.Scalar();
    if (std::find(known.begin(), known.end(), key) == known.end()) {
      Error(entry.first,
            "unknown field \"" + key + "\" in " + where + " (there are " + Listed(known) + ")");
    }
  }
}

std::string ContractReader::Text(const YAML::Node& map, const char* key, bool needed) {
  const YAML::Node node = map[key];
  if (!node) {
    if (needed) Error(map, std::string("\"") + key + "\" is missing");
    return "";
  }
  if (!node.IsScalar()) Error(node, std::string("\"") + key + "\" must be a text");
  return node.IsScalar() ? node.Scalar() : "";
}

std::vector<std::string> ContractReader::Texts(const YAML::Node& map, const char* key,
                                               bool needed) {
  std::vector<std::string> texts;
  const YAML::Node node = map[key];
  if (!node && needed) Error(map, std::string("\"") + key + "\" is missing");
  if (!node) return texts;
  const bool list =
      node.IsSequence() &&
      std::all_of(node.begin(), node.end(), [](const YAML::Node& n) { return n.IsScalar(); });
  if (!list) Error(node, std::string("\"") + key + "\" must be a list of arguments");
  if (list)
    for (const YAML::Node& item : node) texts.push_back(item.Scalar());
  return texts;
}

int64_t ContractReader::Count(const YAML::Node& map, const char* key) {
  const YAML::Node node = map[key];
  if (!node) return 0;
  int64_t value = -1;
  if (!node.IsScalar() || !YAML::convert<int64_t>::decode(node, value) || value < 0) {
    Error(node, std::string("\"") + key + "\" must be a whole number, 0 or more");
    return 0;
  }
  return value;
}

double ContractReader::Number(const YAML::Node& map, const char* key) {
  const YAML::Node node = map[key];
  double value = 0;
  if (!node) return 0;
  if (node.IsScalar() && YAML::convert<double>::decode(node, value) && value >= 0) return value;
  Error(node, std::string("\"") + key + "\" must be a number, 0 or more");
  return 0;
}

void ContractReader::CheckPlaceholders(const YAML::Node& node,
                                       const std::vector<std::string>& command,
                                       const std::set<std::string>& known) {
  for (const std::string& argument : command) {
    for (const std::string& name : PlaceholdersIn(argument)) {
      if (known.contains(name)) continue;
      Error(node, "unknown placeholder {" + name + "} (there are " +
                      Listed({known.begin(), known.end()}) + ")");
    }
  }
}

}  // namespace parallax
