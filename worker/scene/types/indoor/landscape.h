// The landscape around a house. Private to this folder.
#pragma once

#include "common/base/status.h"
#include "parallax/v1/config.pb.h"
#include "parallax/v1/scene.pb.h"
#include "worker/scene/dress.h"

namespace parallax {

// SceneObject.part of its ground.
inline constexpr char kLandscapePart[] = "landscape";

// Returns whether this scene's house stands in a landscape.
bool StandsInLandscape(const v1::RoomConfig& config, SceneSeed seed);

// Gives a dressed house its landscape: ground, rules, materials, weather, hash. Objects get indices
// from `first_index` on.
// Errors: as DrawHouseLand, ChooseLandMaterials and CountLand.
absl::Status AddLandscape(uint32_t first_index, SceneInProgress& scene);

// Returns the views that the landscape is expanded for: one out of each opening that leads
// outdoors, with the longest focal length of the scene's rigs. At least one.
google::protobuf::RepeatedPtrField<v1::Rig> ViewsOut(const v1::Scene& scene);

}  // namespace parallax
