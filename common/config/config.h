// Reads and writes the config messages (proto/parallax/v1/config.proto and study.proto) as YAML.
//
// Keys are field names; enum values are their names in lower case without the prefix; a
// Distribution is a number or {uniform: [lo, hi]}, {uniform_int: [lo, hi]}, {choice: [...]},
// {clip_gaussian: [mean, std, lo, hi]} or {bernoulli: p}. Absent fields get the default of their
// FieldRule, so every field of a loaded message is set.
//
// Errors of all loaders: kInvalidArgument with up to 20 lines "file:line: field.path: what was
// seen, what is allowed", where file and line are those of the offending value; kNotFound if the
// file itself is missing.
//
// All functions are thread-safe, and pure except that they read files.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/status.h"
#include "parallax/v1/config.pb.h"
#include "parallax/v1/study.pb.h"

namespace parallax {

// Loads a scene config. `path` is a file or, if there is no such file, the name of a built-in scene
// config ("indoor").
absl::StatusOr<v1::SceneConfig> LoadSceneConfig(const std::string& path);
// Parses the text of a scene config. `file_name` is only for messages.
absl::StatusOr<v1::SceneConfig> ParseSceneConfig(std::string_view yaml, std::string_view file_name);

// Loads a study. `path` is a file or, if there is no such file, the name of a built-in study
// ("quickstart", "baseline"). What the study names (`extends`, `base`, calibrations, own content)
// is sought relative to the file that names it; `extends` and `base` then among the built-in
// configs. A study.lock.yaml loads in the same way.
absl::StatusOr<v1::StudySpec> LoadStudy(const std::string& path);
// Parses the text of a study. `file_name` is for messages, and a relative `base` is sought from its
// folder.
absl::StatusOr<v1::StudySpec> ParseStudy(std::string_view yaml, const std::string& file_name);

// Returns whether `path` is a study rather than a scene config, by the fields of the document: a
// file in any style of YAML, JSON too, or a built-in name. Errors: kNotFound.
absl::StatusOr<bool> IsStudy(const std::string& path);

// Returns "file:line" of the place at which the study `study`, a file or a built-in name, or a file
// that it extends gives the field `field`, such as "train.trainer". Returns the file alone if none
// gives it.
std::string PlaceOfField(const std::string& study, std::string_view field);

// Checks a study that came as a message rather than as a file. Rules and words are the same, with
// the field's path in place of file and line: "variants[0].config.rigs.width_px: -5 is out of
// range, allowed 16 to 8192 px". Config fields that are not set mean their default. Errors:
// kInvalidArgument with up to 20 such lines.
absl::Status ValidateStudy(const v1::StudySpec& study);

// Returns the text of the lock file, with every default written out. Loading it gives a StudySpec
// that is equal except for source_yaml.
std::string StudyToYaml(const v1::StudySpec& study);
// Returns any message as block YAML in field order. Fields with presence are written only if set;
// doubles read back exactly.
std::string MessageToYaml(const google::protobuf::Message& message);

// Returns a scene config with every field at its default.
v1::SceneConfig DefaultSceneConfig();

// Returns the distribution's value at `u` in [0, 1) by its inverse distribution function, so that
// draws with the same u stay comparable when a range changes. Requires a valid distribution, as the
// loaders check; one without a kind gives 0.
double Draw(const v1::Distribution& distribution, double u);

// The smallest and the largest value that a distribution can give.
struct Support {
  double low = 0;
  double high = 0;
};
Support SupportOf(const v1::Distribution& distribution);

// Return the names that LoadStudy and LoadSceneConfig know without files, sorted.
std::vector<std::string> BuiltinStudies();
std::vector<std::string> BuiltinSceneConfigs();
// Returns the names of the trainers whose files come with Parallax, sorted.
std::vector<std::string> BuiltinTrainers();
// Returns the text of a built-in file, for example "studies/quickstart.yaml". Errors: kNotFound.
absl::StatusOr<std::string> BuiltinConfigText(std::string_view name);

}  // namespace parallax
