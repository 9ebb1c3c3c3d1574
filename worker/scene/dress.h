// The steps with which scene types dress their scenes. Each draws from random addresses of its own
// below "dress", so that a step's settings change nothing in the others. Private to worker/scene
// and worker/catalogue.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "common/base/ids.h"
#include "common/base/rng.h"
#include "common/base/status.h"
#include "common/math/types.h"
#include "parallax/v1/config.pb.h"
#include "parallax/v1/scene.pb.h"
#include "worker/geometry/ray_scene.h"
#include "worker/geometry/surroundings.h"
#include "worker/layout/anneal/asset_pool.h"
#include "worker/scene/own_content.h"

namespace parallax {

// A thing of a scene that moves.
struct Mover {
  v1::SceneObject object;  // Its place and motion.
  Box3f bounds;            // Object frame.
};

// A scene while it is being made: the recipe so far and, for types that make one, its solid twin
// for ray queries. Body i of `solid` is object i of the recipe.
struct SceneInProgress {
  v1::Scene recipe;
  Surroundings surroundings;
  RayScene solid;
  AssetPool pool;
  SceneSeed seed;
  OwnContent own;
  std::vector<Mover> movers;  // `solid` has them at time 0.
  // Depth as which probes that leave the place count where rigs are chosen; 0: they see sky.
  double view_out_m = 0;
  std::string why_no_rigs;  // The reason for fewer rigs than wanted, if the type knows it.
};

// Removes objects for which `goes` is true, and the lights that they emit. The others keep their
// indices, so that objects compare across variants. The solid twin stays as it is.
void RemoveObjects(const std::function<bool(const v1::SceneObject&)>& goes, v1::Scene& recipe);

// Adds floating objects at random poses within the surroundings' bounds, clear of everything unless
// the config allows intersections, and out of the rigs' way (view_guard.h). Object i draws from its
// own address and gets the index `first_index` + i, so a larger count only adds. An object that
// finds no place in its tries is left out. Requires a committed solid twin and bounds. Errors:
// kInvalidArgument for an unknown class.
absl::Status AddFloating(const v1::SceneConfig& config, uint32_t first_index,
                         SceneInProgress& scene);

// Draws the sky: strength, colour, sun. Uses addresses below `root`.
void ChooseSky(const v1::LightingConfig& config, const Rng& root, v1::Sky& sky);

// Returns a linear RGB colour of mean 1; `saturation` in [0, 1], 0 = white.
Vec3d TintOf(double hue_rad, double saturation);
// Returns such a colour, of any hue and a saturation from 0.2 to 0.8.
Vec3d RandomTint(Rng rng);

// A point light's place and look, without its power.
struct LightPlace {
  Vec3d position = Vec3d::Zero();  // World.
  double radius_m = 0;
  double whiteness = 1;  // [0, 1]: warm to white.
};
// Adds as many point lights as the config draws. Light i's place is `place(rng, ball_m)` with a
// stream of its own below `root`; a light without a place is left out. With `ball_m` above 0 the
// light is a ball of that radius, or a smaller one that touches nothing. Their total power is drawn
// independently of their number; each has a random share of it, or draws its own from 0 to the
// equal share (LightingConfig.point_split).
void AddPointLights(const v1::LightingConfig& config, const Rng& root,
                    const std::function<std::optional<LightPlace>(Rng& rng, double ball_m)>& place,
                    google::protobuf::RepeatedPtrField<v1::Light>& lights);

}  // namespace parallax
