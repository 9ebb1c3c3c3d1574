#include "common/config/check/limit_rules.h"

#include <fmt/core.h>

#include <algorithm>

#include "common/base/names.h"
#include "common/base/system/file.h"
#include "common/config/check/limits.h"
#include "common/config/yaml/yaml_document.h"
#include "common/config/yaml/yaml_values.h"

namespace parallax {
namespace {

using config_internal::ConfigErrors;
using config_internal::ParseYaml;
using config_internal::YamlValues;

constexpr int64_t kMostLimit = int64_t{1} << 50;
constexpr size_t kMostLimitsBytes = 1 << 20;
constexpr char kEverybody[] = "*";

struct LimitField {
  const char* name;
  int64_t UserLimits::*value;
  int64_t least = 0;
  int64_t most = kMostLimit;
};
constexpr LimitField kLimitFields[] = {
    {"max_running", &UserLimits::max_running},
    {"max_studies", &UserLimits::max_studies},
    {"max_waiting_pairs", &UserLimits::max_waiting_pairs},
    {"priority", &UserLimits::priority, -kMaxPriority, kMaxPriority}};

// "ROLE NAME", "ROLE *", "*" or "local".
bool IsUserPattern(const std::string& text) {
  if (text == kEverybody || text == kLocalUser) return true;
  const size_t space = text.find(' ');
  if (space == std::string::npos) return false;
  const std::string role = text.substr(0, space), name = text.substr(space + 1);
  const std::vector<std::string> roles = {"submitter", "operator"};
  return std::count(roles.begin(), roles.end(), role) > 0 && (name == kEverybody || IsName(name));
}

void ReadLimits(YamlValues& reader, const YAML::Node& node, const std::string& path,
                UserLimits& limits) {
  for (const auto& [name, value] : reader.Entries(node, path)) {
    const auto field =
        std::find_if(std::begin(kLimitFields), std::end(kLimitFields),
                     [name = name](const LimitField& known) { return name == known.name; });
    if (field == std::end(kLimitFields)) {
      std::vector<std::string> known;
      for (const LimitField& one : kLimitFields) known.push_back(one.name);
      reader.UnknownField(value, path, name, known);
      continue;
    }
    const auto number = reader.ReadInt(value, path + "." + name, field->least, field->most);
    if (number) limits.*(field->value) = *number;
  }
}

std::string TextOf(const UserLimits& limits) {
  std::string text;
  for (const LimitField& field : kLimitFields) {
    if (limits.*(field.value) == 0) continue;
    text += fmt::format("{}{} {}", text.empty() ? "" : ", ", field.name, limits.*(field.value));
  }
  return text.empty() ? "no limit" : text;
}

}  // namespace

absl::StatusOr<LimitRules> LimitRules::Parse(std::string_view yaml, const std::string& file) {
  LimitRules limits;
  ConfigErrors errors;
  YamlValues reader(file, &errors);
  const std::optional<YAML::Node> root = ParseYaml(yaml, file, errors);
  std::optional<YAML::Node> users;
  if (root && !root->IsNull()) {
    for (const auto& [name, node] : reader.Entries(*root, "")) {
      if (name == "default") {
        ReadLimits(reader, node, name, limits.default_);
      } else if (name == "users") {
        users = node;
      } else {
        reader.UnknownField(node, "", name, {"default", "users"});
      }
    }
  }
  if (users) {
    for (const auto& [user, node] : reader.Entries(*users, "users")) {
      const std::string path = "users." + user;
      if (!IsUserPattern(user)) {
        reader.Error(
            node, path,
            "not a user, allowed are `submitter NAME`, `operator NAME`, `*` as the name or "
            "alone, and `local`");
      }
      UserLimits row = limits.default_;
      row.rule = user;
      ReadLimits(reader, node, path, row);
      limits.rows_[user] = row;
    }
  }
  if (!errors.empty()) return errors.ToStatus();
  return limits;
}

absl::StatusOr<LimitRules> LimitRules::Load(const std::string& path) {
  ASSIGN_OR_RETURN(const std::string yaml, ReadFile(path, kMostLimitsBytes));
  return Parse(yaml, path);
}

UserLimits LimitRules::Of(const std::string& user) const {
  const std::string of_role = user.substr(0, user.find(' ')) + " *";
  for (const std::string& key : {user, of_role, std::string(kEverybody)}) {
    if (const auto row = rows_.find(key); row != rows_.end()) return row->second;
  }
  return default_;
}

std::vector<std::string> LimitRules::NamedUsers() const {
  std::vector<std::string> users;
  for (const auto& [user, limits] : rows_) {
    if (user.find('*') == std::string::npos) users.push_back(user);
  }
  return users;
}

std::string LimitRules::Describe() const {
  std::string text;
  if (TextOf(default_) != TextOf({})) text = "default: " + TextOf(default_);
  for (const auto& [user, limits] : rows_) {
    text += (text.empty() ? "" : "; ") + user + ": " + TextOf(limits);
  }
  return text.empty() ? "none" : text;
}

std::string UserOfActor(std::string_view actor) {
  const size_t role_end = actor.find(' ');
  if (role_end == std::string_view::npos) return kLocalUser;
  const size_t name_end = actor.find(' ', role_end + 1);
  return name_end == std::string_view::npos ? kLocalUser : std::string(actor.substr(0, name_end));
}

}  // namespace parallax
