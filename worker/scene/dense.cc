#include "worker/scene/dense.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "common/base/rng.h"
#include "common/base/version.h"
#include "common/config/config.h"
#include "common/math/proto.h"
#include "worker/scene/dress.h"
#include "worker/scene/glass_parts.h"
#include "worker/scene/place_floating.h"
#include "worker/scene/warp.h"

namespace parallax {
namespace {

constexpr int kTries = 60;
constexpr double kMargin =
    0.12;  // Middles may lie this far (of half an image) outside of the view.

struct DenseObject {
  std::shared_ptr<const TriangleTree> tree;
  Box3f bounds;
  double size_m = 0;  // At FloatingConfig.size_at_m.
};

// A thing that stands in the keyframe being drawn.
struct Placed {
  size_t object = 0;
  Pose pose;
  Vec3d middle;
  double radius_m = 0;
};

// Whether the oriented boxes are apart along one of their faces' normals: cheap, and certain when
// true.
bool BoxesApart(const Box3f& a, const Pose& world_from_a, const Box3f& b,
                const Pose& world_from_b) {
  const auto apart = [](const Box3f& own, const Pose& world_from_own, const Box3f& other,
                        const Pose& world_from_other) {
    const Pose own_from_other = world_from_own.Inverse() * world_from_other;
    const Vec3d middle = own_from_other * other.center().cast<double>();
    const Vec3d half =
        0.5 * own_from_other.scale *
        (own_from_other.rotation.toRotationMatrix().cwiseAbs() * other.diagonal().cast<double>());
    return ((middle - half).array() > own.max().cast<double>().array()).any() ||
           ((middle + half).array() < own.min().cast<double>().array()).any();
  };
  return apart(a, world_from_a, b, world_from_b) || apart(b, world_from_b, a, world_from_a);
}

class DenseSolver {
 public:
  DenseSolver(const v1::SceneConfig& config, SceneSeed seed)
      : config_(config), root_(seed, "dense") {
    scene_.seed = seed;
  }

  absl::Status MakeObjects(const CancelToken& cancel) {
    const v1::FloatingConfig& floating = config_.floating();
    ASSIGN_OR_RETURN(const std::vector<std::string> classes, FloatingClasses(config_));
    const long count = std::lround(Draw(floating.count(), root_.Child("count").Uniform()));
    for (long i = 0; i < count; ++i) {
      if (cancel.cancelled()) return absl::CancelledError("solve: cancelled");
      const Rng stream = root_.Child("object", static_cast<uint64_t>(i));
      v1::SceneObject& object = *scene_.recipe.add_objects();
      object.set_index(static_cast<uint32_t>(i) + 1);
      object.set_asset_class(stream.Child("class").Pick(classes));
      object.set_name(object.asset_class() + "_floating_" + std::to_string(i));
      object.set_seed(stream.Child("asset").Seed());
      object.set_warp(Draw(floating.warp(), stream.Child("warp").Uniform()));
      if (object.warp() > 0) object.set_warp_seed(stream.Child("warp seed").Seed());
      object.set_role(v1::OBJECT_ROLE_FLOATING);
      object.set_relation("floating");
      auto mesh = MakeObjectMesh(object);
      if (!mesh.ok()) return WithContext(mesh.status(), "object " + object.name());
      DenseObject made;
      made.bounds = mesh->Bounds();
      made.size_m = Draw(floating.size_m(), stream.Child("size").Uniform());
      if (!floating.allow_intersections()) made.tree = std::make_shared<TriangleTree>(*mesh);
      objects_.push_back(std::move(made));
    }
    return absl::OkStatus();
  }

  void AddKeyframe(uint32_t index) {
    const Rng root = root_.Child("keyframe", index);
    v1::Rig& rig = *scene_.recipe.add_rigs();
    MakeRig(root, index, rig);
    v1::Keyframe& keyframe = *scene_.recipe.add_keyframes();
    const std::vector<Placed> placed = PlaceObjects(root, rig, keyframe);
    const Rng light = root.Child("lighting");
    ChooseSky(config_.lighting(), light, *keyframe.mutable_sky());
    if (config_.lighting().mode() == v1::LightingConfig::MODE_AUGMENTED) {
      AddLights(light, RigView::Of(rig), placed, keyframe);
    }
  }

  absl::StatusOr<v1::Scene> Finish() {
    RETURN_IF_ERROR(OmitGlassParts(config_.assets(), scene_));
    RETURN_IF_ERROR(ChooseMaterials(config_.materials(), scene_));
    v1::Scene& recipe = scene_.recipe;
    const v1::Keyframe& first = recipe.keyframes(0);
    for (int i = 0; i < recipe.objects_size(); ++i) {
      *recipe.mutable_objects(i)->mutable_world_from_object() = ToProto(KeyframePose(first, i));
    }
    *recipe.mutable_lights() = first.lights();
    *recipe.mutable_sky() = first.sky();
    recipe.set_layout_version(kLayoutVersion);
    recipe.set_generator_version(kSceneVersion);
    recipe.set_scene_seed(scene_.seed.value);
    recipe.set_type(v1::SCENE_TYPE_DENSE);
    return std::move(recipe);
  }

 private:
  // At the origin, looking anywhere around.
  void MakeRig(const Rng& root, uint32_t index, v1::Rig& rig) const {
    const v1::RigConfig& config = config_.rigs();
    Rng rng = root.Child("rig");
    const double yaw = rng.Uniform(0, 2 * std::numbers::pi);
    const double pitch = Draw(config.pitch_deg(), rng.Uniform()) * std::numbers::pi / 180;
    const double fov = Draw(config.horizontal_fov_deg(), rng.Uniform()) * std::numbers::pi / 180;
    Eigen::Matrix3d axes;
    axes.col(2) =
        Vec3d(std::sin(pitch) * std::cos(yaw), std::sin(pitch) * std::sin(yaw), -std::cos(pitch));
    axes.col(0) = Vec3d(std::sin(yaw), -std::cos(yaw), 0);
    axes.col(1) = axes.col(2).cross(axes.col(0));
    rig.set_index(index);
    *rig.mutable_world_from_left() =
        ToProto(Pose{Vec3d::Zero(), Eigen::Quaterniond(axes).normalized(), 1.0});
    rig.set_baseline_m(Draw(config.baseline_m(), root.Child("baseline").Uniform()));
    rig.set_width_px(config.width_px());
    rig.set_height_px(config.height_px());
    const double focal = config.width_px() / 2.0 / std::tan(fov / 2);
    rig.set_fx_px(focal);
    rig.set_fy_px(focal);
    rig.set_cx_px(config.width_px() / 2.0);
    rig.set_cy_px(config.height_px() / 2.0);
  }

  // All objects are in every keyframe. One that finds no free place takes its last one: among
  // hundreds nobody sees it, and the recipe keeps its shape.
  std::vector<Placed> PlaceObjects(const Rng& root, v1::Rig& rig, v1::Keyframe& keyframe) const {
    const RigView view = RigView::Of(rig);
    std::vector<Placed> placed;
    double sum = 0, square = 0;
    for (size_t i = 0; i < objects_.size(); ++i) {
      Rng rng = root.Child("object", i);
      Placed thing;
      for (int k = 0; k < kTries; ++k) {
        thing = Draft(rng, view, i);
        if (config_.floating().allow_intersections() || IsFree(thing, placed)) break;
      }
      const Pose& p = thing.pose;
      for (const double number :
           {p.translation.x(), p.translation.y(), p.translation.z(), p.rotation.w(), p.rotation.x(),
            p.rotation.y(), p.rotation.z(), p.scale}) {
        keyframe.add_world_from_object(static_cast<float>(number));
      }
      const double depth = view.axes.col(2).dot(thing.middle - view.eye);
      sum += depth;
      square += depth * depth;
      placed.push_back(thing);
    }
    const double n = static_cast<double>(std::max<size_t>(objects_.size(), 1));
    rig.set_depth_std_m(std::sqrt(std::max(0.0, square / n - sum / n * (sum / n))));
    return placed;
  }

  // In the view, at a distance of its own, larger when farther away.
  Placed Draft(Rng& rng, const RigView& view, size_t i) const {
    const v1::FloatingConfig& floating = config_.floating();
    const DenseObject& object = objects_[i];
    const Eigen::Quaterniond rotation = RandomRotation(rng);
    const double x = rng.Uniform(-1 - kMargin, 1 + kMargin);
    const double y = rng.Uniform(-1 - kMargin, 1 + kMargin);
    const double distance = Draw(floating.distance_m(), rng.Uniform());
    const double size =
        object.size_m * (floating.size_at_m() > 0 ? distance / floating.size_at_m() : 1);
    const double side = std::max(double{object.bounds.diagonal().maxCoeff()}, 1e-6);
    Placed thing;
    thing.object = i;
    thing.middle = view.eye + distance * view.Direction(x, y);
    thing.pose = PoseAbout(thing.middle, rotation, size / side, object.bounds);
    thing.radius_m = 0.5 * thing.pose.scale * double{object.bounds.diagonal().norm()};
    return thing;
  }

  bool IsFree(const Placed& thing, const std::vector<Placed>& others) const {
    const DenseObject& own = objects_[thing.object];
    for (const Placed& other : others) {
      const double reach = thing.radius_m + other.radius_m;
      if ((thing.middle - other.middle).squaredNorm() >= reach * reach) continue;
      const DenseObject& there = objects_[other.object];
      if (BoxesApart(own.bounds, thing.pose, there.bounds, other.pose)) continue;
      if (Overlap(*own.tree, thing.pose.Affine(), *there.tree, other.pose.Affine())) return false;
    }
    return true;
  }

  void AddLights(const Rng& root, const RigView& view, const std::vector<Placed>& placed,
                 v1::Keyframe& keyframe) const {
    const v1::LightingConfig& config = config_.lighting();
    const long count = std::lround(Draw(config.point_lights(), root.Child("points").Uniform()));
    const double total_w = Draw(config.point_power_w(), root.Child("power").Uniform());
    std::vector<double> share;
    double sum = 0;
    for (long i = 0; i < count; ++i) {
      share.push_back(root.Child("share", static_cast<uint64_t>(i)).Uniform(0.1, 1.0));
      sum += share.back();
    }
    for (long i = 0; i < count; ++i) {
      Rng rng = root.Child("point", static_cast<uint64_t>(i));
      const double distance = Draw(config.point_distance_m(), rng.Uniform());
      const double whiteness = rng.Uniform();
      v1::Light& light = *keyframe.add_lights();
      light.set_kind(v1::Light::KIND_POINT);
      light.set_name("Point_" + std::to_string(i));
      light.set_radius_m(0.015 * distance);
      const double power = total_w * share[static_cast<size_t>(i)] / sum;
      *light.mutable_power_w() = ToProto(LampColor(whiteness, power));
      // Anywhere in front of the camera or beside it, but in no object.
      Vec3d at = Vec3d::Zero();
      for (int k = 0; k < kTries; ++k) {
        const double x = rng.Uniform(-2, 2), y = rng.Uniform(-2, 2);
        at = view.eye + distance * view.Direction(x, y);
        const bool inside = std::any_of(placed.begin(), placed.end(), [&](const Placed& thing) {
          return (thing.middle - at).norm() < 0.5 * thing.radius_m + light.radius_m();
        });
        if (!inside) break;
      }
      *light.mutable_position_m() = ToProto(at);
    }
  }

  const v1::SceneConfig& config_;
  const Rng root_;
  SceneInProgress scene_;
  std::vector<DenseObject> objects_;
};

}  // namespace

absl::StatusOr<v1::Scene> SolveDense(const v1::SceneConfig& config, SceneSeed seed,
                                     const CancelToken& cancel) {
  DenseSolver solver(config, seed);
  RETURN_IF_ERROR(solver.MakeObjects(cancel));
  for (int i = 0; i < config.rigs().count(); ++i) {
    if (cancel.cancelled()) return absl::CancelledError("solve: cancelled");
    solver.AddKeyframe(static_cast<uint32_t>(i));
  }
  return solver.Finish();
}

}  // namespace parallax
