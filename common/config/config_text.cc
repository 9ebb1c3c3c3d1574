#include "common/config/config_text.h"

#include <fmt/core.h>

#include <algorithm>
#include <filesystem>

#include "common/base/edit_distance.h"
#include "common/base/system/file.h"
#include "common/base/system/sought_files.h"
#include "common/config/check/field_rules.h"
#include "common/config/check/limits.h"

namespace parallax::config_internal {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kBuiltinPrefix = "builtin:";
constexpr size_t kMostNeighbours = 1000;

bool IsFile(const std::string& path) {
  std::error_code error;
  return fs::is_regular_file(path, error);
}

std::vector<std::string> ConfigsIn(const fs::path& dir) {
  std::vector<std::string> names;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(dir.empty() ? "." : dir, error)) {
    const std::string ending = entry.path().extension();
    if (ending == ".yaml" || ending == ".yml" || ending == ".json") {
      names.push_back(entry.path().filename());
    }
    if (names.size() == kMostNeighbours) break;
  }
  std::sort(names.begin(), names.end());
  return names;
}

// Returns the file beside `path`, or the built-in name, that was probably meant; "" for none.
std::string Meant(const std::string& path, const std::vector<std::string>& built_in) {
  const fs::path at(path);
  const std::string file = NearestName(at.filename().string(), ConfigsIn(at.parent_path()));
  if (!file.empty()) return at.parent_path() / file;
  return NearestName(at.stem().string(), built_in);
}

absl::StatusOr<ConfigText> ReadBuiltin(const std::string& name) {
  const BuiltinFile* builtin = FindBuiltin(name);
  if (builtin == nullptr) return NotFound("no built-in config {}", name);
  return ConfigText{std::string(kBuiltinPrefix) + std::string(builtin->name),
                    std::string(builtin->text)};
}

// The file at `path`, or the built-in `folder`/`name`.yaml if none exists.
absl::StatusOr<ConfigText> ReadFileOrBuiltin(const std::string& path, const std::string& folder,
                                             const std::string& name) {
  NoteSought(path);  // A missing one may come.
  if (IsFile(path)) {
    ASSIGN_OR_RETURN(std::string text, ReadFile(path, kMaxStudyFileBytes));
    return ConfigText{path, std::move(text)};
  }
  absl::StatusOr<ConfigText> builtin = ReadBuiltin(folder + "/" + name + ".yaml");
  if (builtin.ok()) return builtin;
  std::error_code error;
  const bool exists = fs::exists(path, error);
  const std::vector<std::string> names = BuiltinNames(folder + "/");
  const std::string meant = exists ? "" : Meant(path, names);
  return NotFound("{}: {}, {}llowed is a path or a built-in name: {}", path,
                  exists ? "not a file" : "no such file",
                  meant.empty() ? "a" : "did you mean " + meant + "? A", JoinNames(names));
}

}  // namespace

const BuiltinFile* FindBuiltin(std::string_view name) {
  for (const BuiltinFile& file : BuiltinFiles()) {
    if (file.name == name) return &file;
  }
  return nullptr;
}

std::vector<std::string> BuiltinNames(std::string_view folder) {
  std::vector<std::string> names;
  for (const BuiltinFile& file : BuiltinFiles()) {
    if (file.name.substr(0, folder.size()) != folder) continue;
    names.push_back(fs::path(std::string(file.name)).stem());
  }
  std::sort(names.begin(), names.end());
  return names;
}

absl::StatusOr<ConfigText> ReadConfigText(const std::string& path, const std::string& folder) {
  return ReadFileOrBuiltin(path, folder, path);
}

absl::StatusOr<ConfigText> ReadNamedText(const std::string& named, const std::string& from,
                                         const std::string& folder) {
  const fs::path path(named);
  if (from.starts_with(kBuiltinPrefix)) {
    return ReadBuiltin(folder + "/" + path.stem().string() + ".yaml");
  }
  const bool as_in_configs = path.parent_path().filename() == folder && path.extension() == ".yaml";
  return ReadFileOrBuiltin((fs::path(from).parent_path() / path).lexically_normal(), folder,
                           as_in_configs ? path.stem().string() : named);
}

std::string OwnPathOf(const std::string& named, const std::string& from) {
  if (named.empty() || named.starts_with("store:") || from.starts_with(kBuiltinPrefix)) {
    return named;
  }
  std::error_code error;
  const fs::path given(named);
  // An absolute path stays what it is.
  const fs::path here = (fs::absolute(from, error).parent_path() / given).lexically_normal();
  const bool plain = given.is_relative() &&
                     std::none_of(given.begin(), given.end(),
                                  [](const fs::path& part) { return part == "." || part == ".."; });
  if (plain && !fs::exists(here, error)) return named;
  std::string below_root = here.relative_path();
  while (below_root.ends_with('/')) below_root.pop_back();
  return below_root.empty() ? named : below_root;
}

}  // namespace parallax::config_internal
