// Inner part of common/config: the field rigs.camera. While a study is read, a preset or
// calibration file becomes numbers, so that readers of the resolved config need neither.
#pragma once

#include <string>

#include "common/config/check/checks.h"
#include "common/config/yaml/yaml_reader.h"

namespace parallax::config_internal {

// As YamlReader::Merge of a scene config, which `node` is, with what rigs.camera says:
// - A preset or calibration replaces the camera, size and baseline that `config` has, and a preset
//   with a projector that, too; what is beside it in `node` wins. The calibration is looked for
//   relative to the reader's file. One that has calibration_sha256 and fx_px beside it is resolved
//   already: nothing is read.
// - A focal length takes the place of rigs.horizontal_fov_deg, which is cleared unless `node` has
//   it, too (CheckCamera tells then).
// - The size that the numbers are given for is noted.
void MergeSceneConfig(YamlReader& reader, const YAML::Node& node, v1::SceneConfig* config,
                      const std::string& path, Origins* origins);

// Checks the fields of rigs.camera against each other and against the fields of rigs.
void CheckCamera(const v1::SceneConfig& config, const std::string& path, Findings* findings);

}  // namespace parallax::config_internal
