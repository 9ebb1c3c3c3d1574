#include "worker/scene/types/indoor/landscape.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/base/rng.h"
#include "common/math/proto.h"
#include "common/math/stereo.h"
#include "worker/layout/plan/wall_frame.h"
#include "worker/scene/types/nature/ground/land_materials.h"
#include "worker/scene/types/nature/rules/house_land.h"

namespace parallax {
namespace {

constexpr double kPlinth_m[] = {0.15, 0.6};  // Floors lie this far above the ground.
constexpr double kAround_m = 0.6;            // The plot's margin beyond the outer walls.
constexpr double kHalfView_rad = 75 * std::numbers::pi / 180;
constexpr double kHalfHeight_rad = 25 * std::numbers::pi / 180;
constexpr double kFocal_px = 1000;  // For scenes without rigs.

Eigen::AlignedBox2d OutlineOf(const v1::House& house) {
  Eigen::AlignedBox2d outline;
  for (const v1::Room& room : house.rooms()) {
    const Vec2d origin(room.origin_x_m(), room.origin_y_m());
    const Vec2d rim = Vec2d::Constant(kAround_m);
    outline.extend(origin - rim);
    outline.extend(origin + Vec2d(room.width_m(), room.depth_m()) + rim);
  }
  return outline;
}

v1::Rig ViewOut(const v1::Room& room, const v1::Opening& opening, double focal_px) {
  const WallFrame wall = FrameOfWall(room, opening.wall());
  const Vec2d at = wall.At(wall.LocalOf(opening.center_m()), 0);
  const Vec2d out = -wall.inward;
  RigSpec spec;
  spec.position = Vec3d(room.origin_x_m() + at.x(), room.origin_y_m() + at.y(),
                        room.floor_z_m() + opening.sill_m() + 0.5 * opening.height_m());
  spec.axes = CameraAxes(std::atan2(out.y(), out.x()), std::numbers::pi / 2);
  spec.width_px = static_cast<int>(std::lround(2 * focal_px * std::tan(kHalfView_rad)));
  spec.height_px = static_cast<int>(std::lround(2 * focal_px * std::tan(kHalfHeight_rad)));
  spec.k = {focal_px, focal_px, spec.width_px / 2.0, spec.height_px / 2.0};
  return MakeRig(spec);
}

void ChooseWeather(const Rng& root, v1::Scene& recipe) {
  v1::Sky& sky = *recipe.mutable_sky();
  sky.set_turbidity(root.Child("turbidity").Uniform(1.9, 3));
  sky.set_cloud_cover(root.Child("cloud cover").Uniform(0, 0.6));
  sky.set_cloud_seed(root.Child("clouds").Seed());
  v1::Air& air = *recipe.mutable_air();
  air.set_haze_per_m(root.Child("haze").Uniform(0, 0.0008));
  air.set_scale_height_m(root.Child("haze height").Uniform(120, 900));
  air.set_forward(0.5);
  *air.mutable_tint() = ToProto(Vec3d(0.97, 0.99, 1.04));
}

}  // namespace

bool StandsInLandscape(const v1::RoomConfig& config, SceneSeed seed) {
  return Rng(seed, "dress/landscape").Bernoulli(config.landscape_p());
}

google::protobuf::RepeatedPtrField<v1::Rig> ViewsOut(const v1::Scene& scene) {
  double focal_px = 0;
  for (const v1::Rig& rig : scene.rigs()) focal_px = std::max(focal_px, rig.fx_px());
  if (!(focal_px > 0)) focal_px = kFocal_px;
  google::protobuf::RepeatedPtrField<v1::Rig> views;
  const v1::House& house = scene.place().house();
  for (const v1::Room& room : house.rooms()) {
    for (const v1::Opening& opening : room.openings()) {
      if (opening.leads_to() == 0) *views.Add() = ViewOut(room, opening, focal_px);
    }
  }
  // Nothing but an open ceiling shows it.
  if (views.empty()) *views.Add() = ViewOut(house.rooms(0), v1::Opening(), focal_px);
  return views;
}

absl::Status AddLandscape(uint32_t first_index, SceneInProgress& scene) {
  const Rng root(scene.seed, "dress/landscape");
  v1::Scene& recipe = scene.recipe;
  v1::House& house = *recipe.mutable_place()->mutable_house();
  const double plinth = root.Child("plinth").Uniform(kPlinth_m[0], kPlinth_m[1]);
  ASSIGN_OR_RETURN(*house.mutable_landscape(), DrawHouseLand(root, OutlineOf(house), -plinth));
  v1::Terrain& land = *house.mutable_landscape();
  land.set_ground_object_index(first_index);
  v1::SceneObject& ground = *recipe.add_objects();
  ground.set_index(first_index);
  ground.set_name("Landscape");
  ground.set_asset_class("Terrain");
  ground.set_part(kLandscapePart);
  ground.set_role(v1::OBJECT_ROLE_TERRAIN);
  *ground.mutable_world_from_object() = ToProto(Pose{});
  ChooseWeather(root, recipe);
  RETURN_IF_ERROR(ChooseLandMaterials(v1::NatureConfig(), root, recipe, land));
  return CountLand(recipe, ViewsOut(recipe), land);
}

}  // namespace parallax
