#include <algorithm>
#include <cmath>
#include <optional>
#include <string>

#include "common/base/rng.h"
#include "common/config/config.h"
#include "common/math/proto.h"
#include "worker/scene/dress.h"
#include "worker/scene/floating/floating_choice.h"
#include "worker/scene/floating/floating_motion.h"
#include "worker/scene/floating/place_floating.h"
#include "worker/scene/floating/view_guard.h"
#include "worker/scene/floating/warp.h"

namespace parallax {
namespace {

// Most tries fail at the cheap comparison of boxes.
constexpr int kFloatTries = 600;
constexpr double kWallGap_m = 0.02;

// Limits of the objects' middles: the config's box, or all of `bounds`.
Eigen::AlignedBox3d BoxOf(const v1::FloatingBox& box, const Eigen::AlignedBox3d& bounds) {
  const Vec3d low(box.min_x_m(), box.min_y_m(), box.min_z_m());
  const Vec3d high(box.max_x_m(), box.max_y_m(), box.max_z_m());
  if ((low.array() < high.array()).all()) return {low, high};
  return bounds;
}

// A floating object before it has a place.
struct Floater {
  std::string class_name;
  uint64_t seed = 0, warp_seed = 0;
  FloatingSize size;
  double warp = 0;
  Box3f bounds;
  std::shared_ptr<const TriangleTree> tree;
};

class FloatingPlacer {
 public:
  FloatingPlacer(const v1::SceneConfig& config, SceneInProgress& scene)
      : config_(config.floating()),
        scene_(scene),
        bounds_(scene.surroundings.bounds),
        box_(BoxOf(config_.box(), bounds_)),
        guard_(config.rigs(), scene.recipe),
        motion_(config_, scene.recipe, scene.solid, guard_,
                [this](const Box3f& bounds, const Pose& pose) { return InBounds(bounds, pose); }) {}

  absl::Status Place(const std::string& name, uint32_t index, const Rng& stream,
                     const FloatingChoice& choice, size_t number) {
    ASSIGN_OR_RETURN(const Floater floater, Make(stream, choice));
    Rng poses = stream.Child("pose");
    for (int k = 0; k < kFloatTries; ++k) {
      const std::optional<Pose> pose = Draft(poses, floater, number);
      if (!pose || !InBounds(floater.bounds, *pose) ||
          !guard_.Allows(floater.bounds, [&](double) { return *pose; })) {
        continue;
      }
      const FloatingBody body{floater.tree, floater.bounds, ToProto(*pose)};
      if (!config_.allow_intersections() &&
          (scene_.solid.Overlaps(*floater.tree, pose->Affine()) || !motion_.IsClear(body))) {
        continue;
      }
      const std::optional<v1::RigidMotion> motion = motion_.Draw(stream.Child("motion"), body);
      guard_.Take();
      v1::SceneObject& object = *scene_.recipe.add_objects();
      object.set_index(index);
      object.set_name(floater.class_name + "_floating_" + name);
      object.set_asset_class(floater.class_name);
      object.set_seed(floater.seed);
      object.set_warp_seed(floater.warp_seed);
      object.set_warp(floater.warp);
      object.set_role(v1::OBJECT_ROLE_FLOATING);
      object.set_relation("floating");
      *object.mutable_world_from_object() = ToProto(*pose);
      if (motion) {
        *object.mutable_motion() = *motion;
        scene_.movers.push_back({object, floater.bounds});
      }
      scene_.solid.Add(floater.tree, pose->Affine());
      break;
    }
    return absl::OkStatus();
  }

 private:
  absl::StatusOr<Floater> Make(const Rng& stream, const FloatingChoice& choice) {
    Floater floater;
    const FloatingChoice::Model model = choice.Draw(stream);
    floater.class_name = model.asset_class;
    floater.seed = model.seed;
    floater.size = FloatingSize::Draw(config_, stream);
    floater.warp = Draw(config_.warp(), stream.Child("warp").Uniform());
    if (floater.warp > 0) {
      floater.warp_seed = stream.Child("warp seed").Seed();
      v1::SceneObject object;
      object.set_asset_class(floater.class_name);
      object.set_seed(floater.seed);
      object.set_warp_seed(floater.warp_seed);
      object.set_warp(floater.warp);
      ASSIGN_OR_RETURN(const Mesh mesh, MakeObjectMesh(object));
      floater.tree = std::make_shared<TriangleTree>(mesh);
      floater.bounds = mesh.Bounds();
    } else {
      ASSIGN_OR_RETURN(const PooledAsset* asset, scene_.pool.Get(floater.class_name, floater.seed));
      floater.tree = asset->Tree();
      floater.bounds = asset->bounds;
    }
    return floater;
  }

  // Draws a pose; nothing when it fails. Consumes equally many random numbers either way.
  std::optional<Pose> Draft(Rng& rng, const Floater& floater, size_t number) const {
    const Eigen::Quaterniond rotation = RandomRotation(rng);
    const double x = rng.Uniform(), y = rng.Uniform(), z = rng.Uniform();
    const double side = std::max(double{floater.bounds.diagonal().maxCoeff()}, 1e-6);
    const bool view = config_.placement() == v1::FloatingConfig::PLACEMENT_VIEW;
    if (!view) {
      const Vec3d at = box_.min() + Vec3d(x, y, z).cwiseProduct(box_.sizes());
      return PoseAbout(at, rotation, floater.size.Grown(1) / side, floater.bounds);
    }
    if (guard_.views().empty()) return std::nullopt;
    const size_t rig = config_.view_rig() >= 0 ? static_cast<size_t>(config_.view_rig()) : number;
    const RigView& from = guard_.views()[rig % guard_.views().size()];
    const double distance = Draw(config_.distance_m(), z);
    const Vec3d direction = from.Direction(2 * x - 1, 2 * y - 1);
    const auto hit = scene_.solid.Intersect(from.eye.cast<float>(), direction.cast<float>());
    if (!hit || double{hit->distance} <= distance) return std::nullopt;
    return PoseAbout(from.eye + distance * direction, rotation,
                     floater.size.At(config_, distance) / side, floater.bounds);
  }

  bool InBounds(const Box3f& bounds, const Pose& pose) const {
    const Vec3d middle = pose * bounds.center().cast<double>();
    const Vec3d half =
        0.5 * pose.scale *
        (pose.rotation.toRotationMatrix().cwiseAbs() * bounds.diagonal().cast<double>());
    return ((middle - half).array() > bounds_.min().array() + kWallGap_m).all() &&
           ((middle + half).array() < bounds_.max().array() - kWallGap_m).all();
  }

  const v1::FloatingConfig& config_;
  SceneInProgress& scene_;
  const Eigen::AlignedBox3d bounds_;
  const Eigen::AlignedBox3d box_;
  ViewGuard guard_;
  FloatingMotion motion_;
};

}  // namespace

absl::Status AddFloating(const v1::SceneConfig& config, uint32_t first_index,
                         SceneInProgress& scene) {
  const Rng root(scene.seed, "dress/floating");
  ASSIGN_OR_RETURN(const FloatingChoice choice, FloatingChoice::Of(config, scene.own));
  const long count = std::lround(Draw(config.floating().count(), root.Child("count").Uniform()));
  FloatingPlacer placer(config, scene);
  for (long i = 0; i < count; ++i) {
    const auto number = static_cast<size_t>(i);
    RETURN_IF_ERROR(placer.Place(std::to_string(i), first_index + static_cast<uint32_t>(i),
                                 root.Child("object", number), choice, number));
  }
  return absl::OkStatus();
}

}  // namespace parallax
