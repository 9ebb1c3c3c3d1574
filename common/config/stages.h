// The stage of the pipeline that reads each field of a config, from FieldRule.stage in
// config.proto. Pure functions; thread-safe.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "parallax/v1/config.pb.h"

namespace parallax {

// Returns a copy with only the fields whose stage is `wanted`. Groups without a remaining field are
// absent. A field without a stage is in every copy: keys made of it then change too often rather
// than too rarely.
v1::SceneConfig FieldsOf(const v1::SceneConfig& config,
                         const std::function<bool(v1::FieldRule::Stage)>& wanted);

// Returns a copy with only the fields that `stage` is the first to read.
v1::SceneConfig FieldsOf(const v1::SceneConfig& config, v1::FieldRule::Stage stage);

// A field that holds a value rather than a group of fields, and the stage that reads it.
struct ConfigField {
  std::string path;  // "rigs.baseline_m"
  v1::FieldRule::Stage stage = v1::FieldRule::STAGE_UNSPECIFIED;
};
// Returns every such field of SceneConfig, in the order of config.proto.
std::vector<ConfigField> ConfigFields();

}  // namespace parallax
