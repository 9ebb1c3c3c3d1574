#include "worker/scene/types/dense/street.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/config/config.h"
#include "common/math/stereo.h"
#include "worker/layout/plan/part_builder.h"
#include "worker/scene/rigs/keyframes.h"
#include "worker/scene/rigs/rig_camera.h"

namespace parallax {
namespace {

constexpr double kStreetDegree = std::numbers::pi / 180;
constexpr float kStreetReach_m = 4000, kDeep_m = 1, kKerb_m = 0.14f;
constexpr double kLook_rad = 6 * kStreetDegree, kMostLook_rad = 14 * kStreetDegree;
constexpr double kLane_m = 0.9;      // Eyes keep this far from the walks.
constexpr double kClear_m = 0.5;     // And so far from things.
constexpr double kClearSizes = 0.3;  // Large things stay farther away.
constexpr double kOnRoad_p = 0.06, kOnRoadFrom_m = 7;
constexpr double kInAir_p = 0.22, kHighest_m = 9;
constexpr double kBeside_m = 28;  // How far from the walks the last row stands.
constexpr double kFarAway_m = 600;

// Half of the extent in the world, by axes.
Vec3d HalfExtent(const Box3f& bounds, const Eigen::Quaterniond& rotation, double scale) {
  return 0.5 * scale * (rotation.toRotationMatrix().cwiseAbs() * bounds.diagonal().cast<double>());
}

double ScaleFor(const Box3f& bounds, double size_m) {
  return size_m / std::max(double{bounds.diagonal().maxCoeff()}, 1e-6);
}

MaterialClasses Named(std::initializer_list<const char*> names) {
  MaterialClasses classes;
  for (const char* name : names) {
    if (const MaterialClass* found = FindMaterialClass(name)) classes.push_back(found);
  }
  return classes;
}

}  // namespace

v1::Street DrawStreet(const Rng& root) {
  v1::Street street;
  street.set_width_m(root.Child("width").Uniform(4.2, 10));
  street.set_walk_m(root.Child("walk").Uniform(1.2, 3.5));
  street.set_kerb_m(root.Child("kerb").Uniform(0.06, 0.16));
  return street;
}

Mesh MakeStreet(const v1::Street& street) {
  PartBuilder mesh;
  const uint16_t road_slot = mesh.Slot("road", {"concrete"}),
                 kerb_slot = mesh.Slot("kerb", {"stone"}),
                 walk_slot = mesh.Slot("walk", {"concrete"}),
                 ground_slot = mesh.Slot("ground", {"soil"});
  const auto road = static_cast<float>(0.5 * street.width_m());
  const auto walk = static_cast<float>(street.walk_m()), up = static_cast<float>(street.kerb_m());
  const auto strip = [&](float from, float to, float top, uint16_t slot) {
    mesh.Box(slot, {-kStreetReach_m, from, -kDeep_m}, {kStreetReach_m, to, top}, 0,
             PartBuilder::Grain::kX);
  };
  strip(-road, road, 0, road_slot);
  for (const float side : {-1.0f, 1.0f}) {
    const auto both = [&](float a, float b, float top, uint16_t slot) {
      strip(std::min(side * a, side * b), std::max(side * a, side * b), top, slot);
    };
    both(road, road + kKerb_m, up, kerb_slot);
    both(road + kKerb_m, road + walk, up - 0.006f, walk_slot);
    both(road + walk, kStreetReach_m, 0, ground_slot);
  }
  return mesh.Take();
}

uint32_t StreetMaterial(const MaterialSlot& slot, Palettes& palettes) {
  const Rng where = palettes.root().Child("street/" + slot.name);
  MaterialClasses classes = Named({"Grass", "Grass", "Soil", "Gravel", "ForestFloor", "Sand"});
  if (slot.name == "road") classes = Named({"Concrete", "Concrete", "Gravel", "Slate", "Soil"});
  if (slot.name == "kerb") classes = Named({"Granite", "Concrete"});
  if (slot.name == "walk") classes = Named({"Concrete", "Brick", "Slate", "Gravel", "Terrazzo"});
  return palettes.FromPalette(classes, "street/" + slot.name, 1, where);
}

void StreetRigs(const v1::RigConfig& config, const Rng& root, const v1::Street& street,
                v1::Scene& recipe) {
  for (uint32_t k = 0; k < static_cast<uint32_t>(config.count()); ++k) {
    const Rng keyframe = KeyframeStream(root, k);
    Rng rng = keyframe.Child("rig");
    const double way = rng.Bernoulli(0.5) ? 0 : std::numbers::pi;
    const double yaw = way + std::clamp(rng.Normal(0, kLook_rad), -kMostLook_rad, kMostLook_rad);
    const double pitch = Draw(config.pitch_deg(), rng.Uniform()) * kStreetDegree;
    const RigCamera camera = DrawRigCamera(config, rng.Uniform(), keyframe.Child("camera"));
    const double lane = std::max(0.0, 0.5 * street.width_m() - kLane_m);
    const double y = rng.Uniform(-lane, lane);
    const double altitude = Draw(config.altitude_m(), rng.Uniform());
    AddKeyframeRig(config, keyframe, k, {0, y, altitude}, CameraAxes(yaw, pitch), camera, recipe);
  }
}

StreetPlacer::StreetPlacer(const v1::SceneConfig& config, const v1::Street& street,
                           const RigView& view)
    : config_(config), street_(street), view_(view), ahead_(view.axes(0, 2) >= 0 ? 1 : -1) {}

std::optional<Pose> StreetPlacer::Draft(Rng& rng, const Box3f& bounds,
                                        const FloatingSize& size) const {
  const v1::FloatingConfig& floating = config_.floating();
  const double distance = Draw(floating.distance_m(), rng.Uniform());
  const double side = rng.Bernoulli(0.5) ? 1 : -1, lateral = rng.Uniform(), height = rng.Uniform();
  const bool on_road = rng.Bernoulli(kOnRoad_p), near_walk = rng.Bernoulli(0.6);
  const bool in_air = rng.Bernoulli(kInAir_p);
  const Eigen::Quaterniond tumbled = RandomRotation(rng);
  const Eigen::Quaterniond upright(
      Eigen::AngleAxisd(rng.Uniform(0, 2 * std::numbers::pi), Vec3d::UnitZ()));
  const Eigen::Quaterniond& rotation = in_air ? tumbled : upright;
  const double size_m = size.At(floating, distance);
  const double scale = ScaleFor(bounds, size_m);
  const Vec3d half = HalfExtent(bounds, rotation, scale);
  // From the carriageway's edge to the thing's near side.
  const double beside = near_walk ? lateral * street_.walk_m() + 0.25 * size_m * height
                                  : street_.walk_m() + kBeside_m * lateral * lateral;
  Vec3d middle(view_.eye.x() + ahead_ * distance,
               side * (0.5 * street_.width_m() + beside + half.y()), 0);
  if (on_road) {
    if (distance - half.x() < kOnRoadFrom_m) return std::nullopt;
    middle.y() = (lateral - 0.5) * street_.width_m();
  }
  middle.z() = GroundAt(middle.y()) + half.z() + 1e-3;
  if (in_air) middle.z() += 0.1 + kHighest_m * height * height;
  const Pose pose = PoseAbout(middle, rotation, scale, bounds);
  if (!ClearOfEyes(bounds, pose)) return std::nullopt;
  return pose;
}

Pose StreetPlacer::FarAway(const Box3f& bounds, double size_m, size_t number) const {
  const double scale = ScaleFor(bounds, size_m);
  const Vec3d half = HalfExtent(bounds, Eigen::Quaterniond::Identity(), scale);
  const double place = static_cast<double>(number);
  const Vec3d middle(view_.eye.x() + ahead_ * (kFarAway_m + 10 * place),
                     (number % 2 == 0 ? 1 : -1) * (20 + half.y()), half.z() + 1e-3);
  return PoseAbout(middle, Eigen::Quaterniond::Identity(), scale, bounds);
}

// By the oriented box, along the way from eye to eye.
bool StreetPlacer::ClearOfEyes(const Box3f& bounds, const Pose& pose) const {
  const v1::RigConfig& rigs = config_.rigs();
  const double clear = std::max({kClear_m, rigs.min_distance_m(),
                                 kClearSizes * pose.scale * double{bounds.diagonal().maxCoeff()}});
  const double reach = std::max(rigs.clearance_baseline_m(), LargestBaseline(rigs));
  return IsClearOfEyes(view_, reach, clear, bounds, pose);
}

double StreetPlacer::GroundAt(double y) const {
  const double from = std::abs(y) - 0.5 * street_.width_m();
  return from > 0 && from < street_.walk_m() ? street_.kerb_m() : 0;
}

}  // namespace parallax
