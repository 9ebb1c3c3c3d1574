// YAML files as the text form of the config messages (proto/parallax/v1/config.proto and
// study.proto), both ways.
//
// Field names are the keys; enums are their names in lower case without the prefix; a Distribution
// is a number or {uniform: [lo, hi]}, {uniform_int: [lo, hi]}, {choice: [...]}, {clip_gaussian:
// [mean, std, lo, hi]}, {bernoulli: p}. Absent fields take the FieldRule's default, so a loaded
// message always has every field set.
//
// Errors of all loaders: kInvalidArgument with up to 20 lines "file:line: field.path: what was
// seen, what is allowed"; the line is that of the offending value, in whichever file it stands.
// kNotFound when the file itself is missing.
//
// All functions are pure but for reading files, and thread-safe.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/status.h"
#include "parallax/v1/config.pb.h"
#include "parallax/v1/study.pb.h"

namespace parallax {

// `path` is a file, or the name of a built-in scene config ("indoor") when no such file exists.
absl::StatusOr<v1::SceneConfig> LoadSceneConfig(const std::string& path);
// `file_name` is only for messages.
absl::StatusOr<v1::SceneConfig> ParseSceneConfig(std::string_view yaml, std::string_view file_name);

// `path` is a file, or the name of a built-in study ("quickstart", "baseline") when no such file
// exists. `base` is looked for relative to the study's folder and then among the built-in scene
// configs. A study.lock.yaml loads alike.
absl::StatusOr<v1::StudySpec> LoadStudy(const std::string& path);
// `file_name` is for messages and as the place from which a relative `base` is looked for.
absl::StatusOr<v1::StudySpec> ParseStudy(std::string_view yaml, const std::string& file_name);

// Checks a study that came as a message rather than as a file: the same rules, the same words, with
// the field's path in place of file and line ("variants[0].config.rigs.width_px: -5 is out of
// range, allowed 16 to 8192 px"). Fields of a config that are not set stand for their default.
// Errors: kInvalidArgument.
absl::Status ValidateStudy(const v1::StudySpec& study);

// The lock file: every default written out. Loading it gives an equal StudySpec but for
// source_yaml.
std::string StudyToYaml(const v1::StudySpec& study);
// Any message as block YAML in field order: fields with presence only when set, doubles so that
// they read back exactly.
std::string MessageToYaml(const google::protobuf::Message& message);

// Every field at its default.
v1::SceneConfig DefaultSceneConfig();

// The distribution's value at `u` in [0, 1): the inverse of its distribution function, so that
// draws with the same u stay comparable when a range changes. Requires a valid distribution (as the
// loaders check); no kind set gives 0.
double Draw(const v1::Distribution& distribution, double u);

// The smallest and largest value it can give.
struct Support {
  double low = 0;
  double high = 0;
};
Support SupportOf(const v1::Distribution& distribution);

// Names that LoadStudy and LoadSceneConfig know without files, sorted.
std::vector<std::string> BuiltinStudies();
std::vector<std::string> BuiltinSceneConfigs();
// Text of "studies/quickstart.yaml" and so on. Errors: kNotFound.
absl::StatusOr<std::string> BuiltinConfigText(std::string_view name);

}  // namespace parallax
