// The steps of stage `dress`, in the order in which they are taken. Each draws from addresses of
// its own below "dress", so that a step's settings change nothing in the others. Private to
// worker/scene.
#pragma once

#include <vector>

#include "common/base/cancel.h"
#include "common/base/ids.h"
#include "common/base/status.h"
#include "parallax/v1/config.pb.h"
#include "parallax/v1/scene.pb.h"
#include "worker/geometry/ray_scene.h"
#include "worker/layout/asset_pool.h"

namespace parallax {

// A scene while it is being dressed: the recipe so far and its solid twin. Body i of `solid` is
// object i of the recipe.
struct SceneInProgress {
  v1::Scene recipe;
  RayScene solid;
  AssetPool pool;
  SceneSeed seed;
};

// Adds the recipe's objects from `first` on to the solid twin.
absl::Status AddSolids(SceneInProgress& scene, int first);

// Floating objects at random poses, clear of everything unless the config allows intersections.
// Object i draws from its own address, so a larger count only adds. An object that finds no place
// in its tries is left out. Errors: kInvalidArgument for an unknown class.
absl::Status AddFloating(const v1::SceneConfig& config, SceneInProgress& scene);

// Binds a material to every slot of every object.
// Errors: kInvalidArgument for an unknown material.
absl::Status ChooseMaterials(const v1::MaterialConfig& config, SceneInProgress& scene);

// Sky and lamps; in augmented mode also point lights, a missing ceiling, dimmed lamps. Needs a
// committed solid twin.
void ChooseLighting(const v1::LightingConfig& config, SceneInProgress& scene);

// Stereo rigs with the largest spread of depth among random candidates. Needs a committed solid
// twin. Returns how many were found; at most config.count.
int ChooseRigs(const v1::RigConfig& config, SceneInProgress& scene);

}  // namespace parallax
