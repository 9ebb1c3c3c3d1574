// Which stage of the pipeline reads which field of a config, as FieldRule.stage in config.proto
// says it. Pure functions; thread-safe.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "parallax/v1/config.pb.h"

namespace parallax {

// A copy with only the fields whose stage is `wanted`. Groups of fields of which none is left are
// absent. A field without a stage is in every copy, so that a key errs towards making things again.
v1::SceneConfig FieldsOf(const v1::SceneConfig& config,
                         const std::function<bool(v1::FieldRule::Stage)>& wanted);

// Only the fields that `stage` is the first to read.
v1::SceneConfig FieldsOf(const v1::SceneConfig& config, v1::FieldRule::Stage stage);

// A field that holds a value rather than a group of fields: its path, and the stage that reads it.
struct ConfigField {
  std::string path;  // "rigs.baseline_m"
  v1::FieldRule::Stage stage = v1::FieldRule::STAGE_UNSPECIFIED;
};
// Every field of SceneConfig, in the order of config.proto.
std::vector<ConfigField> ConfigFields();

}  // namespace parallax
