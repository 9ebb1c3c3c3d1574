// Stage `scene` of a house. Private to this folder.
#pragma once

#include "common/base/cancel.h"
#include "common/base/status.h"
#include "parallax/v1/config.pb.h"
#include "worker/scene/dress.h"

namespace parallax {

// SceneType::rigs: places rigs in the furnished house, all ceilings on, where depth spreads most.
// Errors: kCancelled; kNotFound for unknown classes.
absl::Status PlaceHouseRigs(const v1::SceneConfig& config, const CancelToken& cancel,
                            SceneInProgress& scene);

// SceneType::dress, after PlaceHouseRigs. Errors: kCancelled; kInvalidArgument for unknown classes
// or materials.
absl::Status DressHouse(const v1::SceneConfig& config, const CancelToken& cancel,
                        SceneInProgress& scene);

// Adds sky and lamps; in augmented mode also point lights, missing ceilings and dimmed lamps.
// Requires a committed solid twin.
void ChooseHouseLighting(const v1::LightingConfig& config, SceneInProgress& scene);

}  // namespace parallax
