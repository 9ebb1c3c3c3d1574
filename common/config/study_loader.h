// Inner part of common/config: reads a study, from its own file and those that it extends.
//
// The files are read in order, the one that extends none first; each later file wins. A scene
// config is merged in this order: defaults, `base`, then of each file `set` and the variant's own
// `set`. So a file overrides all of those that it extends.
#pragma once

#include <string>
#include <string_view>

#include "common/base/status.h"
#include "parallax/v1/study.pb.h"

namespace parallax::config_internal {

// Reads the study in `yaml`, the text of `file`, and checks it. Errors: those of the loaders in
// config.h.
absl::StatusOr<v1::StudySpec> ReadStudy(std::string_view yaml, const std::string& file);

// Returns whether a config's text is that of a study: one of its fields is one that only studies
// have. Texts that are empty, no map or no YAML count as studies.
bool IsStudyText(std::string_view yaml);

// Returns "file:line" of the place at which the study in `yaml`, the text of `file`, or the last of
// the files that it extends gives the field `path`, such as "train.trainer". Returns `file` if none
// gives it.
std::string PlaceOf(std::string_view yaml, const std::string& file, std::string_view path);

}  // namespace parallax::config_internal
