// Inner part of common/config: the field rigs.camera. While a study is read, a preset or
// calibration file becomes numbers, so that readers of the resolved config need neither.
#pragma once

#include <string>

#include "common/config/checks.h"
#include "common/config/yaml_reader.h"

namespace parallax::config_internal {

// Merges the scene config `node` into `config` as YamlReader::Merge does, and applies rigs.camera:
// - A preset or calibration replaces the camera, size and baseline of `config`; fields beside it in
//   `node` win. The calibration's path is relative to the reader's file. If calibration_sha256 and
//   fx_px stand beside it, it is resolved already and no file is read.
// - A focal length replaces rigs.horizontal_fov_deg, which is cleared unless `node` has it too
//   (then CheckCamera reports both).
// - The size for which the numbers are given is noted.
// Errors go to the reader.
void MergeSceneConfig(YamlReader& reader, const YAML::Node& node, v1::SceneConfig* config,
                      const std::string& path, Origins* origins);

// Checks the fields of rigs.camera against each other and against the fields of rigs.
void CheckCamera(const v1::SceneConfig& config, const std::string& path, Findings* findings);

}  // namespace parallax::config_internal
