#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "common/base/rng.h"
#include "common/config/config.h"
#include "common/math/proto.h"
#include "worker/layout/room_shell.h"
#include "worker/scene/dress.h"

namespace parallax {
namespace {

constexpr int kTries = 40;
constexpr double kWallGap_m = 0.02;

// Uniform over all orientations.   Source: Shoemake, "Uniform random rotations", Graphics Gems III.
Eigen::Quaterniond RandomRotation(Rng& rng) {
  const double u = rng.Uniform(), a = 2 * std::numbers::pi * rng.Uniform(),
               b = 2 * std::numbers::pi * rng.Uniform();
  const double p = std::sqrt(1 - u), q = std::sqrt(u);
  return Eigen::Quaterniond(q * std::cos(b), p * std::sin(a), p * std::cos(a), q * std::sin(b));
}

absl::StatusOr<std::vector<std::string>> FloatingClasses(const v1::SceneConfig& config) {
  std::vector<std::string> names;
  for (const std::string& name : config.floating().classes()) {
    if (FindAssetClass(name) == nullptr) {
      return MakeError(absl::StatusCode::kInvalidArgument,
                       "floating.classes: there is no class \"" + name + "\"");
    }
    names.push_back(name);
  }
  if (!names.empty()) return names;
  const auto& exclude = config.assets().exclude();
  for (const AssetClass& entry : AssetCatalogue()) {
    const bool excluded = std::find(exclude.begin(), exclude.end(), entry.name) != exclude.end();
    if (entry.on_by_default && !excluded) {
      names.push_back(entry.name);
    }
  }
  if (names.empty()) return absl::InvalidArgumentError("assets.exclude leaves no class to float");
  return names;
}

// A pose at which the bounds' middle is at a random place of the room; nothing when the bounds
// stick out.
bool DrawPose(Rng& rng, const v1::Room& room, const Box3f& bounds, double scale, Pose& pose) {
  pose.scale = scale;
  pose.rotation = RandomRotation(rng);
  const Vec3d at(rng.Uniform(0, room.width_m()), rng.Uniform(0, room.depth_m()),
                 rng.Uniform(0, room.height_m()));
  pose.translation = at - scale * (pose.rotation * bounds.center().cast<double>());
  const Vec3d half =
      0.5 * scale *
      (pose.rotation.toRotationMatrix().cwiseAbs() * bounds.diagonal().cast<double>());
  const Vec3d size(room.width_m(), room.depth_m(), room.height_m());
  return ((at - half).array() > kWallGap_m).all() &&
         ((at + half).array() < size.array() - kWallGap_m).all();
}

}  // namespace

absl::Status AddSolids(SceneInProgress& scene, int first) {
  for (int i = first; i < scene.recipe.objects_size(); ++i) {
    const v1::SceneObject& object = scene.recipe.objects(i);
    const Eigen::Affine3f place = FromProto(object.world_from_object()).Affine();
    if (!object.room_part().empty()) {
      auto mesh = MakeRoomPart(scene.recipe.room(), object.room_part());
      if (!mesh.ok()) return WithContext(mesh.status(), "object " + object.name());
      scene.solid.Add(*mesh, place);
    } else {
      auto asset = scene.pool.Get(object.asset_class(), object.seed());
      if (!asset.ok()) return WithContext(asset.status(), "object " + object.name());
      scene.solid.Add((*asset)->Tree(), place);
    }
  }
  return absl::OkStatus();
}

absl::Status AddFloating(const v1::SceneConfig& config, SceneInProgress& scene) {
  const v1::FloatingConfig& floating = config.floating();
  const Rng root(scene.seed, "dress/floating");
  ASSIGN_OR_RETURN(const std::vector<std::string> classes, FloatingClasses(config));
  const long count = std::lround(Draw(floating.count(), root.Child("count").Uniform()));
  uint32_t next_index = 1;
  for (const auto& object : scene.recipe.objects())
    next_index = std::max(next_index, object.index() + 1);
  for (long i = 0; i < count; ++i) {
    const Rng stream = root.Child("object", static_cast<uint64_t>(i));
    const std::string& name = stream.Child("class").Pick(classes);
    const uint64_t seed = stream.Child("asset").Seed();
    ASSIGN_OR_RETURN(const PooledAsset* asset, scene.pool.Get(name, seed));
    const double size = Draw(floating.size_m(), stream.Child("size").Uniform());
    const double scale = size / static_cast<double>(asset->bounds.diagonal().maxCoeff());
    Rng poses = stream.Child("pose");
    for (int k = 0; k < kTries; ++k) {
      Pose pose;
      if (!DrawPose(poses, scene.recipe.room(), asset->bounds, scale, pose)) continue;
      if (!floating.allow_intersections() && scene.solid.Overlaps(*asset->Tree(), pose.Affine())) {
        continue;
      }
      v1::SceneObject& object = *scene.recipe.add_objects();
      object.set_index(next_index++);
      object.set_name(name + "_floating_" + std::to_string(i));
      object.set_asset_class(name);
      object.set_seed(seed);
      object.set_role(v1::OBJECT_ROLE_FLOATING);
      object.set_relation("floating");
      *object.mutable_world_from_object() = ToProto(pose);
      scene.solid.Add(asset->Tree(), pose.Affine());
      break;
    }
  }
  return absl::OkStatus();
}

}  // namespace parallax
