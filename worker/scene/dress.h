// The steps of stage `dress`, in the order in which they are taken. Each draws from addresses of
// its own below "dress", so that a step's settings change nothing in the others. Private to
// worker/scene.
#pragma once

#include <vector>

#include "common/base/cancel.h"
#include "common/base/ids.h"
#include "common/base/rng.h"
#include "common/base/status.h"
#include "common/math/types.h"
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

// Floating objects at random poses, clear of everything unless the config allows intersections, and
// out of the way of the rigs (view_guard.h). Object i draws from its own address and gets the index
// `first_index` + i, so a larger count only adds. An object that finds no place in its tries is
// left out. Needs a committed solid twin. Errors: kInvalidArgument for an unknown class.
absl::Status AddFloating(const v1::SceneConfig& config, uint32_t first_index,
                         SceneInProgress& scene);

// Binds a material to every slot of every object.
// Errors: kInvalidArgument for an unknown material.
absl::Status ChooseMaterials(const v1::MaterialConfig& config, SceneInProgress& scene);

// The sky: strength, colour, sun. Draws from addresses below `root`.
void ChooseSky(const v1::LightingConfig& config, const Rng& root, v1::Sky& sky);

// A lamp's light: white to warm by `whiteness` in [0, 1], of `power_w` in all.
Vec3d LampColor(double whiteness, double power_w);

// Sky and lamps; in augmented mode also point lights, a missing ceiling, dimmed lamps. Needs a
// committed solid twin.
void ChooseLighting(const v1::LightingConfig& config, SceneInProgress& scene);

// Stereo rigs with the largest spread of depth among random candidates. Needs a committed solid
// twin. Returns how many were found; at most config.count.
int ChooseRigs(const v1::RigConfig& config, SceneInProgress& scene);

}  // namespace parallax
