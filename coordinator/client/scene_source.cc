#include "coordinator/client/scene_source.h"

#include <fmt/core.h>

#include <algorithm>
#include <charconv>
#include <filesystem>

#include "common/base/system/file.h"
#include "parallax/v1/service.pb.h"
#include "worker/scene/upgrade.h"

namespace parallax::client {
namespace {

namespace fs = std::filesystem;

absl::StatusOr<uint32_t> ParseNumber(const std::string& text) {
  uint32_t number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error == std::errc() && end == text.data() + text.size()) return number;
  return InvalidArgument("'{}' is not a scene's number; they count from 0", text);
}

std::string Joined(std::vector<std::string> names) {
  std::sort(names.begin(), names.end());
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return text;
}

std::vector<std::string> VariantsIn(const std::string& dir) {
  std::vector<std::string> names;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(dir, error)) {
    if (fs::is_directory(entry.path() / "scenes", error)) names.push_back(entry.path().filename());
  }
  return names;
}

absl::StatusOr<v1::Scene> ReadSceneFile(const std::string& path) {
  std::error_code error;
  if (fs::is_directory(path, error)) {
    const std::vector<std::string> variants = VariantsIn(path);
    return InvalidArgument(
        "{}: a folder, wanted a recipe's file or, of a dataset, {} VARIANT "
        "SCENE{}",
        path, path, variants.empty() ? "" : " with a variant of " + Joined(variants));
  }
  if (!fs::is_regular_file(path, error)) return NotFound("{}: no such file", path);
  ASSIGN_OR_RETURN(const std::string bytes, ReadFile(path, 256 << 20));
  return ParseScene(bytes, path);
}

absl::StatusOr<v1::Scene> ReadArchivedScene(const std::string& dir, const std::string& variant,
                                            uint32_t number) {
  std::error_code error;
  const std::vector<std::string> variants = VariantsIn(dir);
  if (variants.empty()) return NotFound("{}: no dataset (no recipes in it)", dir);
  if (std::find(variants.begin(), variants.end(), variant) == variants.end()) {
    return NotFound("{} has no variant '{}'; it has {}", dir, variant, Joined(variants));
  }
  const std::string name = fmt::format("{:06}.pb", number);
  const fs::path scenes = fs::path(dir) / variant / "scenes";
  if (fs::exists(scenes / name, error)) return ReadSceneFile(scenes / name);
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(scenes, error)) {
    if (entry.path().extension() == ".pb") names.push_back(entry.path().stem());
  }
  std::sort(names.begin(), names.end());
  return NotFound("{}: variant '{}' has no scene {}; it has {}{}", dir, variant, number,
                  names.size(),
                  names.empty() ? "" : ", from " + names.front() + " to " + names.back());
}

// Checked here because the coordinator's error does not list the known names.
absl::Status CheckVariant(const v1::StudyStatus& study, const std::string& variant) {
  std::vector<std::string> known;
  for (const v1::VariantStatus& status : study.variants()) {
    if (status.name() == variant) return absl::OkStatus();
    known.push_back(status.name());
  }
  return NotFound("study {} ({}) has no variant '{}'; it has {}", study.study_id(), study.name(),
                  variant, Joined(known));
}

}  // namespace

absl::StatusOr<v1::Scene> LoadScene(const std::vector<std::string>& source,
                                    const Session& session) {
  if (source.size() == 1) return ReadSceneFile(source[0]);
  if (source.size() != 3) {
    return InvalidArgument(
        "a recipe is named by a file, by DIR VARIANT SCENE of a dataset or by STUDY VARIANT SCENE "
        "of a coordinator");
  }
  ASSIGN_OR_RETURN(const uint32_t number, ParseNumber(source[2]));
  std::error_code error;
  if (fs::is_directory(source[0], error)) return ReadArchivedScene(source[0], source[1], number);
  ASSIGN_OR_RETURN(const auto connection, session.ConnectInPlaceOf(source[0]));
  const absl::StatusOr<v1::StudyStatus> found = connection->FindStudy(source[0]);
  if (!found.ok()) {
    return MakeError(found.status().code(), source[0] + ": no such folder here, and " +
                                                std::string(ToStd(found.status().message())));
  }
  const v1::StudyStatus& study = *found;
  RETURN_IF_ERROR(CheckVariant(study, source[1]));
  ASSIGN_OR_RETURN(v1::GetSceneReply reply,
                   connection->GetScene(study.study_id(), source[1], number));
  RETURN_IF_ERROR(UpgradeScene(*reply.mutable_scene()));
  return std::move(*reply.mutable_scene());
}

}  // namespace parallax::client
