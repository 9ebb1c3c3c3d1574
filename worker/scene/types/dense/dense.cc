#include "worker/scene/types/dense/dense.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/base/rng.h"
#include "common/base/status.h"
#include "common/config/config.h"
#include "common/math/proto.h"
#include "worker/scene/choose_materials.h"
#include "worker/scene/floating/floating_choice.h"
#include "worker/scene/floating/place_floating.h"
#include "worker/scene/floating/warp.h"
#include "worker/scene/glass_parts.h"
#include "worker/scene/rigs/keyframes.h"
#include "worker/scene/rigs/rig_camera.h"
#include "worker/scene/types/dense/street.h"

namespace parallax {
namespace {

constexpr int kDenseTries = 60;
// Middles may lie this far (of half an image) outside of the view.
constexpr double kMargin = 0.12;
constexpr double kLeastClear_m = 0.05;  // No camera stands in a thing, whatever the config allows.

struct DenseObject {
  std::shared_ptr<const TriangleTree> tree;
  Box3f bounds;
  FloatingSize size;
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

class DenseDresser {
 public:
  // `scene` has its rigs.
  DenseDresser(const v1::SceneConfig& config, SceneInProgress& scene)
      : config_(config),
        scene_(scene),
        root_(scene.seed, "dense"),
        reach_m_(std::max(config.rigs().clearance_baseline_m(), LargestBaseline(config.rigs()))),
        clearance_m_(std::max(kLeastClear_m, config.rigs().min_distance_m())) {}

  absl::Status MakeObjects(const CancelToken& cancel) {
    const v1::FloatingConfig& floating = config_.floating();
    ASSIGN_OR_RETURN(const FloatingChoice choice, FloatingChoice::Of(config_, scene_.own));
    const long count = std::lround(Draw(floating.count(), root_.Child("count").Uniform()));
    for (long i = 0; i < count; ++i) {
      if (cancel.cancelled()) return Cancelled("solve: cancelled");
      const Rng stream = root_.Child("object", static_cast<uint64_t>(i));
      v1::SceneObject& object = *scene_.recipe.add_objects();
      object.set_index(static_cast<uint32_t>(i) + 1);
      const FloatingChoice::Model model = choice.Draw(stream);
      object.set_asset_class(model.asset_class);
      object.set_name(fmt::format("{}_floating_{}", object.asset_class(), i));
      object.set_seed(model.seed);
      object.set_warp(Draw(floating.warp(), stream.Child("warp").Uniform()));
      if (object.warp() > 0) object.set_warp_seed(stream.Child("warp seed").Seed());
      object.set_role(v1::OBJECT_ROLE_FLOATING);
      object.set_relation("floating");
      auto mesh = MakeObjectMesh(object);
      if (!mesh.ok()) return WithContext(mesh.status(), "object " + object.name());
      DenseObject made;
      made.bounds = mesh->Bounds();
      made.size = FloatingSize::Draw(floating, stream);
      if (!floating.allow_intersections()) made.tree = std::make_shared<TriangleTree>(*mesh);
      objects_.push_back(std::move(made));
    }
    if (street() != nullptr) AddStreet();
    return absl::OkStatus();
  }

  // Adds the keyframe that rig `index` sees; rigs that share a left eye see the same.
  void AddKeyframe(int index) {
    v1::Rig& rig = *scene_.recipe.mutable_rigs(index);
    if (rig.shares_left()) {
      rig.set_depth_std_m(scene_.recipe.rigs(index - 1).depth_std_m());
      *scene_.recipe.add_keyframes() = v1::Keyframe(scene_.recipe.keyframes(index - 1));
      return;
    }
    const Rng root = KeyframeStream(root_, lefts_++);
    v1::Keyframe& keyframe = *scene_.recipe.add_keyframes();
    const std::vector<Placed> placed = PlaceObjects(root, rig, keyframe);
    const Rng light = root.Child("lighting");
    ChooseSky(config_.lighting(), light, *keyframe.mutable_sky());
    if (config_.lighting().mode() == v1::LightingConfig::MODE_AUGMENTED) {
      const RigView view = RigView::Of(rig);
      AddPointLights(
          config_.lighting(), light,
          [&](Rng& rng, double ball_m) { return PlaceLight(rng, ball_m, view, placed); },
          *keyframe.mutable_lights());
    }
  }

  // Copies the first keyframe into the scene, for viewers without keyframes.
  void ShowFirstKeyframe() {
    v1::Scene& recipe = scene_.recipe;
    const v1::Keyframe& first = recipe.keyframes(0);
    for (int i = 0; i < recipe.objects_size(); ++i) {
      *recipe.mutable_objects(i)->mutable_world_from_object() = ToProto(KeyframePose(first, i));
    }
    *recipe.mutable_lights() = first.lights();
    *recipe.mutable_sky() = first.sky();
  }

 private:
  // nullptr: the open sky.
  const v1::Street* street() const {
    const v1::OpenSky& sky = scene_.recipe.place().open_sky();
    return sky.has_street() ? &sky.street() : nullptr;
  }

  // Last, so that the objects keep their indices with and without it.
  void AddStreet() {
    v1::SceneObject& object = *scene_.recipe.add_objects();
    object.set_index(static_cast<uint32_t>(scene_.recipe.objects_size()));
    object.set_name("Street");
    object.set_asset_class("Street");
    object.set_part(kStreetPart);
    object.set_role(v1::OBJECT_ROLE_ARCHITECTURE);
    *object.mutable_world_from_object() = ToProto(Pose{});
  }

  static void AddPose(const Pose& p, v1::Keyframe& keyframe) {
    for (const double number :
         {p.translation.x(), p.translation.y(), p.translation.z(), p.rotation.w(), p.rotation.x(),
          p.rotation.y(), p.rotation.z(), p.scale}) {
      keyframe.add_world_from_object(static_cast<float>(number));
    }
  }

  // All objects are in every keyframe.
  std::vector<Placed> PlaceObjects(const Rng& root, v1::Rig& rig, v1::Keyframe& keyframe) const {
    const RigView view = RigView::Of(rig);
    std::vector<Placed> placed;
    double sum = 0, square = 0;
    for (size_t i = 0; i < objects_.size(); ++i) {
      Rng rng = root.Child("object", i);
      const Placed thing =
          street() != nullptr ? AlongStreet(rng, view, i, placed) : InView(rng, view, i, placed);
      AddPose(thing.pose, keyframe);
      const double depth = view.axes.col(2).dot(thing.middle - view.eye);
      sum += depth;
      square += depth * depth;
      placed.push_back(thing);
    }
    if (street() != nullptr) AddPose(Pose{}, keyframe);
    const double n = static_cast<double>(std::max<size_t>(objects_.size(), 1));
    rig.set_depth_std_m(std::sqrt(std::max(0.0, square / n - sum / n * (sum / n))));
    return placed;
  }

  // An object that finds no free place takes the last one that leaves the eyes clear: among
  // hundreds nobody sees what it meets, and the recipe keeps its shape.
  Placed InView(Rng& rng, const RigView& view, size_t i, const std::vector<Placed>& placed) const {
    std::optional<Placed> last;
    Placed thing;
    for (int k = 0; k < kDenseTries; ++k) {
      thing = Draft(rng, view, i);
      if (!IsClearOfEyes(view, reach_m_, clearance_m_, objects_[i].bounds, thing.pose)) continue;
      if (config_.floating().allow_intersections() || IsFree(thing, placed)) return thing;
      last = thing;
    }
    return last ? *last : PushedAway(thing, view);
  }

  // Farther away in its direction, until its bounding sphere leaves all eyes clear.
  Placed PushedAway(Placed thing, const RigView& view) const {
    const Vec3d way = thing.middle - view.eye;
    const double distance = thing.radius_m + clearance_m_ + reach_m_;
    const Vec3d shift = (distance / std::max(way.norm(), 1e-9) - 1) * way;
    thing.middle += shift;
    thing.pose.translation += shift;
    return thing;
  }

  // On the street or beside it; far behind everything where it finds no place.
  Placed AlongStreet(Rng& rng, const RigView& view, size_t i,
                     const std::vector<Placed>& placed) const {
    const DenseObject& object = objects_[i];
    const StreetPlacer placer(config_, *street(), view);
    for (int k = 0; k < kDenseTries; ++k) {
      const std::optional<Pose> pose = placer.Draft(rng, object.bounds, object.size);
      if (!pose) continue;
      const Placed thing = PlacedAt(i, *pose);
      if (config_.floating().allow_intersections() || IsFree(thing, placed)) return thing;
    }
    return PlacedAt(i, placer.FarAway(object.bounds, object.size.drawn_m, i));
  }

  Placed PlacedAt(size_t i, const Pose& pose) const {
    const Box3f& bounds = objects_[i].bounds;
    return {i, pose, pose * bounds.center().cast<double>(),
            0.5 * pose.scale * double{bounds.diagonal().norm()}};
  }

  // In the view, at a distance of its own, larger when farther away.
  Placed Draft(Rng& rng, const RigView& view, size_t i) const {
    const v1::FloatingConfig& floating = config_.floating();
    const DenseObject& object = objects_[i];
    const Eigen::Quaterniond rotation = RandomRotation(rng);
    const double x = rng.Uniform(-1 - kMargin, 1 + kMargin);
    const double y = rng.Uniform(-1 - kMargin, 1 + kMargin);
    const double distance = Draw(floating.distance_m(), rng.Uniform());
    const double size = object.size.At(floating, distance);
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

  // Anywhere in front of the camera or beside it, but in no object. A ball of radius `ball_m`
  // shrinks until it meets none.
  LightPlace PlaceLight(Rng& rng, double ball_m, const RigView& view,
                        const std::vector<Placed>& placed) const {
    const double distance = Draw(config_.lighting().point_distance_m(), rng.Uniform());
    LightPlace light;
    light.whiteness = rng.Uniform();
    light.radius_m = 0.015 * distance;
    for (int k = 0; k < kDenseTries; ++k) {
      const double x = rng.Uniform(-2, 2), y = rng.Uniform(-2, 2);
      light.position = view.eye + distance * view.Direction(x, y);
      if (street() != nullptr && !StreetPlacer::Lights(light.position)) continue;
      const bool inside = std::any_of(placed.begin(), placed.end(), [&](const Placed& thing) {
        return (thing.middle - light.position).norm() < 0.5 * thing.radius_m + light.radius_m;
      });
      if (!inside) break;
    }
    for (const Placed& thing : placed) {
      ball_m = std::min(ball_m, (thing.middle - light.position).norm() - thing.radius_m);
    }
    light.radius_m = std::max(light.radius_m, ball_m);
    return light;
  }

  const v1::SceneConfig& config_;
  SceneInProgress& scene_;
  const Rng root_;
  const double reach_m_, clearance_m_;  // The largest baseline; what is left free around the eyes.
  std::vector<DenseObject> objects_;
  uint32_t lefts_ = 0;  // Left eyes that have a keyframe.
};

// Nothing stands still in a dense scene.
absl::StatusOr<std::variant<v1::Layout, Rejected>> NoLayout(const v1::SceneConfig&, SceneSeed,
                                                            const CancelToken&) {
  v1::Layout layout;
  layout.mutable_place()->mutable_open_sky();
  return std::variant<v1::Layout, Rejected>(std::move(layout));
}

absl::Status PlaceRigs(const v1::SceneConfig& config, const CancelToken&, SceneInProgress& scene) {
  const Rng root(scene.seed, "dense");
  if (config.floating().placement() != v1::FloatingConfig::PLACEMENT_STREET) {
    KeyframeRigs(config.rigs(), root, scene.recipe);
    return absl::OkStatus();
  }
  v1::Street& street = *scene.recipe.mutable_place()->mutable_open_sky()->mutable_street();
  street = DrawStreet(root.Child("street"));
  StreetRigs(config.rigs(), root, street, scene.recipe);
  return absl::OkStatus();
}

absl::Status Dress(const v1::SceneConfig& config, const CancelToken& cancel,
                   SceneInProgress& scene) {
  DenseDresser dresser(config, scene);
  RETURN_IF_ERROR(dresser.MakeObjects(cancel));
  for (int i = 0; i < scene.recipe.rigs_size(); ++i) {
    if (cancel.cancelled()) return Cancelled("solve: cancelled");
    dresser.AddKeyframe(i);
  }
  RETURN_IF_ERROR(OmitGlassParts(config.assets(), scene));
  const auto part_material = [](const v1::SceneObject&, const MaterialSlot& slot,
                                Palettes& palettes) { return StreetMaterial(slot, palettes); };
  RETURN_IF_ERROR(ChooseMaterials(config.materials(), part_material, scene));
  dresser.ShowFirstKeyframe();
  return absl::OkStatus();
}

absl::StatusOr<Mesh> MakeDensePart(const v1::Scene& scene, const v1::SceneObject& object) {
  const v1::OpenSky& sky = scene.place().open_sky();
  if (sky.has_street() && object.part() == kStreetPart) return MakeStreet(sky.street());
  return NotFound("the open sky has no part \"{}\"", object.part());
}

Surroundings OpenSkySurroundings(const v1::Place& place) {
  Surroundings around;
  around.ground_below_horizon = !place.open_sky().has_street();  // A street's ground reaches it.
  return around;
}

// preview render solve:1:dense --rigs 1, and --rigs 3: solve_core_s.
SceneCosts CostsOf(const v1::SceneConfig& config) {
  // Where everything moves from rig to rig nothing is cached.
  return {.layout_s = 0, .dress_s = 1.65 + 0.1 * config.rigs().count(), .rigs_share_light = false};
}

// A street from above, as far as its first keyframe's objects stand near.
SceneDescription Describe(const v1::Scene& scene) {
  SceneDescription description;
  if (!scene.place().open_sky().has_street()) return description;
  const v1::Street& street = scene.place().open_sky().street();
  description.kind = "street";
  description.lines.push_back(
      fmt::format("street {:.2f} m wide, walks of {:.2f} m", street.width_m(), street.walk_m()));
  constexpr double kAlong_m = 60, kBeside_m = 22;
  GroundPlan plan;
  plan.extent = {Vec3d(-kAlong_m, -kBeside_m, 0), Vec3d(kAlong_m, kBeside_m, 30)};
  const double half = 0.5 * street.width_m();
  for (const int edge : {1, 3}) {
    plan.gaps.push_back({edge, kBeside_m - half, kBeside_m + half, '='});
  }
  description.plan = plan;
  return description;
}

}  // namespace

const SceneType kDenseScenes = {
    .type = v1::SCENE_TYPE_DENSE,
    .place = v1::Place::kOpenSky,
    .layout = &NoLayout,
    .rigs = &PlaceRigs,
    .dress = &Dress,
    .part = &MakeDensePart,
    .surroundings = &OpenSkySurroundings,
    .costs = &CostsOf,
    .describe = &Describe,
};

}  // namespace parallax
