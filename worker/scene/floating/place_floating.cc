#include "worker/scene/floating/place_floating.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "common/math/stereo.h"
#include "worker/assets/asset.h"

namespace parallax {
namespace {

// The floating types of the study's Table 1.
const std::vector<std::pair<std::string, std::vector<std::string>>>& Groups() {
  static const std::vector<std::pair<std::string, std::vector<std::string>>> groups = {
      {"chairs", {"ArmChair", "BarChair", "Chair", "OfficeChair"}},
      {"shelves", {"CellShelf", "LargeShelf", "SimpleBookcase", "TriangleShelf"}},
      {"bushes", {"Bush"}},
  };
  return groups;
}

// Classes of the outdoors are drawn only where a config names them, their family or all of nature:
// studies that float "all" keep their draws.
bool AddNature(const std::string& name, std::vector<std::string>& names) {
  const size_t before = names.size();
  for (const AssetClass& entry : AssetCatalogue()) {
    if (entry.placement != Placement::kGround) continue;
    if (name == "nature" || name == entry.family) names.push_back(entry.name);
  }
  return names.size() > before;
}

void AddAll(const v1::AssetConfig& assets, std::vector<std::string>& names) {
  const auto& exclude = assets.exclude();
  for (const AssetClass& entry : AssetCatalogue()) {
    const bool excluded = std::find(exclude.begin(), exclude.end(), entry.name) != exclude.end();
    if (entry.on_by_default && !excluded) names.push_back(entry.name);
  }
}

}  // namespace

absl::StatusOr<std::vector<std::string>> FloatingClasses(const v1::SceneConfig& config) {
  std::vector<std::string> names;
  for (const std::string& name : config.floating().classes()) {
    const auto group = std::find_if(Groups().begin(), Groups().end(),
                                    [&](const auto& entry) { return entry.first == name; });
    if (group != Groups().end()) {
      names.insert(names.end(), group->second.begin(), group->second.end());
    } else if (name == "all") {
      AddAll(config.assets(), names);
    } else if (FindAssetClass(name) != nullptr) {
      names.push_back(name);
    } else if (AddNature(name, names)) {
      continue;
    } else {
      return InvalidArgument(
          "floating.classes: there is no class \"{}\" and no group of that name (all, chairs, "
          "shelves, bushes, nature, or a family of nature: trees, dead_wood, shrubs, herbs, "
          "litter, stones)",
          name);
    }
  }
  if (config.floating().classes().empty()) AddAll(config.assets(), names);
  if (names.empty()) return InvalidArgument("assets.exclude leaves no class to float");
  std::vector<std::string> once;
  for (std::string& name : names) {
    if (std::find(once.begin(), once.end(), name) == once.end()) once.push_back(std::move(name));
  }
  return once;
}

Eigen::Quaterniond RandomRotation(Rng& rng) {
  const double u = rng.Uniform(), a = 2 * std::numbers::pi * rng.Uniform(),
               b = 2 * std::numbers::pi * rng.Uniform();
  const double p = std::sqrt(1 - u), q = std::sqrt(u);
  return Eigen::Quaterniond(q * std::cos(b), p * std::sin(a), p * std::cos(a), q * std::sin(b));
}

RigView RigView::Of(const v1::Rig& rig) {
  const Pose pose = FromProto(rig.world_from_left());
  const Vec2d half = HalfTangents(rig), shift = ShiftTangents(rig);
  return {pose.translation, pose.rotation.toRotationMatrix(),
          half.x(),         half.y(),
          shift.x(),        shift.y(),
          rig.baseline_m(), rig.time_s()};
}

Pose PoseAbout(const Vec3d& middle, const Eigen::Quaterniond& rotation, double scale,
               const Box3f& bounds) {
  Pose pose;
  pose.scale = scale;
  pose.rotation = rotation;
  pose.translation = middle - scale * (rotation * bounds.center().cast<double>());
  return pose;
}

bool IsClearOfEyes(const RigView& view, double reach_m, double clearance_m, const Box3f& bounds,
                   const Pose& pose) {
  const Eigen::AlignedBox3d box(bounds.min().cast<double>(), bounds.max().cast<double>());
  const Vec3d right = view.axes.col(0), middle = pose * box.center();
  const double radius = pose.scale * box.diagonal().norm() / 2;
  const double along = std::clamp(right.dot(middle - view.eye), 0.0, reach_m);
  if ((middle - view.eye - along * right).norm() >= radius + clearance_m) return true;
  // In steps of a part of the clearance.
  const int steps = std::max(4, static_cast<int>(std::ceil(reach_m / (0.25 * clearance_m))));
  const Pose object_from_world = pose.Inverse();
  for (int s = 0; s <= steps; ++s) {
    const Vec3d eye = view.eye + reach_m * s / steps * right;
    if (pose.scale * box.exteriorDistance(object_from_world * eye) < clearance_m) return false;
  }
  return true;
}

}  // namespace parallax
