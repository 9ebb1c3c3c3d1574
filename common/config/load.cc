#include <optional>

#include "common/base/status.h"
#include "common/base/system/file.h"
#include "common/config/camera_settings.h"
#include "common/config/check/checks.h"
#include "common/config/check/idle_fields.h"
#include "common/config/config.h"
#include "common/config/config_text.h"
#include "common/config/defaults.h"
#include "common/config/study_loader.h"
#include "common/config/yaml/yaml_document.h"
#include "common/config/yaml/yaml_reader.h"

namespace parallax {

using config_internal::BuiltinFile;
using config_internal::BuiltinNames;
using config_internal::ConfigErrors;
using config_internal::ConfigText;
using config_internal::FindBuiltin;
using config_internal::Findings;
using config_internal::Origins;
using config_internal::ReadConfigText;
using config_internal::YamlReader;

namespace {

v1::SceneConfig Defaults() {
  v1::SceneConfig config;
  config_internal::ApplyDefaults(&config);
  return config;
}

}  // namespace

v1::SceneConfig DefaultSceneConfig() {
  static const v1::SceneConfig* config = new v1::SceneConfig(Defaults());
  return *config;
}

absl::StatusOr<v1::SceneConfig> ParseSceneConfig(std::string_view yaml,
                                                 std::string_view file_name) {
  ConfigErrors errors;
  YamlReader reader(std::string(file_name), &errors);
  v1::SceneConfig config = DefaultSceneConfig();
  const std::optional<YAML::Node> root = config_internal::ParseYaml(yaml, reader.file(), errors);
  Origins origins;
  if (root && !root->IsNull())
    config_internal::MergeSceneConfig(reader, *root, &config, "", &origins);
  Findings findings;
  config_internal::CheckConfig(config, "", &findings);
  errors.AddFindings(findings, origins, reader.file());
  if (errors.empty() && root) config_internal::CheckIdleFields(reader, *root, "", config);
  if (!errors.empty()) return errors.ToStatus();
  return config;
}

absl::StatusOr<v1::SceneConfig> LoadSceneConfig(const std::string& path) {
  ASSIGN_OR_RETURN(const ConfigText text, ReadConfigText(path, "scenes"));
  return ParseSceneConfig(text.text, text.file);
}

absl::StatusOr<v1::StudySpec> ParseStudy(std::string_view yaml, const std::string& file_name) {
  return config_internal::ReadStudy(yaml, file_name);
}

absl::StatusOr<v1::StudySpec> LoadStudy(const std::string& path) {
  ASSIGN_OR_RETURN(const ConfigText text, ReadConfigText(path, "studies"));
  return ParseStudy(text.text, text.file);
}

absl::Status ValidateStudy(const v1::StudySpec& study) {
  return config_internal::ToStatus(config_internal::CheckStudy(study));
}

absl::StatusOr<bool> IsStudy(const std::string& path) {
  const absl::StatusOr<ConfigText> scene = ReadConfigText(path, "scenes");
  const absl::StatusOr<ConfigText> study = ReadConfigText(path, "studies");
  if (study.ok()) return config_internal::IsStudyText(study->text);
  if (scene.ok()) return false;
  // Both say that there is no such file; the one that knows a name like it is of more use.
  const bool meant = std::string_view(ToStd(scene.status().message())).find("did you mean") !=
                     std::string_view::npos;
  return meant ? scene.status() : study.status();
}

std::string PlaceOfField(const std::string& study, std::string_view field) {
  const absl::StatusOr<ConfigText> text = ReadConfigText(study, "studies");
  return text.ok() ? config_internal::PlaceOf(text->text, text->file, field) : study;
}

std::vector<std::string> BuiltinStudies() { return BuiltinNames("studies/"); }
std::vector<std::string> BuiltinSceneConfigs() { return BuiltinNames("scenes/"); }
std::vector<std::string> BuiltinTrainers() { return BuiltinNames("trainers/"); }

absl::StatusOr<std::string> BuiltinConfigText(std::string_view name) {
  const BuiltinFile* file = FindBuiltin(name);
  if (file == nullptr) {
    return NotFound("no built-in config {}", name);
  }
  return std::string(file->text);
}

}  // namespace parallax
