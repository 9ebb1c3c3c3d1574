#include "worker/scene/rigs/room_path.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "common/base/rng.h"
#include "common/config/config.h"
#include "common/math/stereo.h"
#include "worker/scene/rigs/best_spread.h"

namespace parallax {
namespace {

constexpr double kRadian = std::numbers::pi / 180;
constexpr uint64_t kShapes = 6;     // Heights, pitches and speeds that are tried.
constexpr uint64_t kWayTries = 40;  // For each.
constexpr uint64_t kStarts = 40, kEnoughStarts = 5;
constexpr uint64_t kSteps = 14,
                   kEnoughSteps = 5;  // Ways on from a key, and free ones to choose among.
constexpr double kKeyLength_m = 0.5, kKeyLength_s = 0.8;  // A key comes no later than either.
constexpr double kBend_rad = 50 * kRadian;  // The way's turn from key to key, at most.
// A key turns the view by this part of what it may; a smooth curve through keys turns faster.
constexpr double kTurnPart = 0.55;
constexpr double kTilt_rad = 8 * kRadian;  // The pitch keeps this near to the way's own.
constexpr double kCeilingClear_m = 0.2;
constexpr double kViewSky = 0.35, kViewClose = 0.3, kViewOneThing = 0.65, kViewOnePlane = 0.85;
constexpr int kCurveParts = 16;  // Straight pieces of a curve, for each key.

// Catmull-Rom through keys; `at` in keys.
template <typename Value>
Value CurveAt(const std::vector<Value>& keys, double at) {
  const auto last = static_cast<int>(keys.size()) - 1;
  const int i = std::clamp(static_cast<int>(at), 0, std::max(last - 1, 0));
  const double t = at - i;
  const auto key = [&](int k) { return keys[static_cast<size_t>(std::clamp(k, 0, last))]; };
  const Value a = key(i - 1), b = key(i), c = key(i + 1), d = key(i + 2);
  return b + 0.5 * t * (c - a + t * (2 * a - 5 * b + 4 * c - d + t * (3 * (b - c) + d - a)));
}

struct Stand {
  Vec3d eye = Vec3d::Zero();  // Left, world.
  double yaw_rad = 0, pitch_rad = 0;
  Mat3f Axes() const { return CameraAxes(yaw_rad, pitch_rad).cast<float>(); }
};

// Values that are drawn once a way.
struct WayShape {
  double altitude_m = 0, pitch_rad = 0, speed_mps = 0;
  RigCamera camera;
};

class RoomWays {
 public:
  RoomWays(const v1::RigConfig& config, const CancelToken& cancel, SceneInProgress& scene)
      : config_(config),
        cancel_(cancel),
        scene_(scene),
        bounds_(scene.surroundings.bounds),
        root_(scene.seed, "dress/paths"),
        reach_m_(
            static_cast<float>(std::max(config.clearance_baseline_m(), LargestBaseline(config)))) {}

  void Place() {
    const int paths = config_.path().paths(), count = config_.count();
    for (int p = 0; p < paths; ++p) {
      const int frames = count / paths + (p < count % paths ? 1 : 0);
      if (!AddWay(static_cast<uint32_t>(p), frames)) {
        scene_.why_no_rigs = fmt::format("rigs: no way of {} frames is free for path {} of {}",
                                         frames, p + 1, paths);
        return;
      }
    }
  }

 private:
  bool AddWay(uint32_t path, int frames) {
    const Rng own = root_.Child("path", path);
    WayShape shape;
    shape.camera = DrawRigCamera(config_, own.Child("fov").Uniform(), own.Child("camera"));
    for (uint64_t draw = 0; draw < kShapes; ++draw) {
      const Rng stream = own.Child("draw", draw);
      Rng numbers = stream.Child("shape");
      shape.altitude_m = Draw(config_.altitude_m(), numbers.Uniform());
      shape.pitch_rad = Draw(config_.pitch_deg(), numbers.Uniform()) * kRadian;
      shape.speed_mps = Draw(config_.path().speed_mps(), numbers.Uniform());
      for (uint64_t i = 0; i < kWayTries && !cancel_.cancelled(); ++i) {
        const std::vector<Stand> way = TryWay(stream.Child("try", i), shape, frames);
        if (way.empty()) continue;
        AddRigs(path, own, shape, way);
        return true;
      }
    }
    return false;
  }

  // Empty: it leads nowhere.
  std::vector<Stand> TryWay(const Rng& rng, const WayShape& shape, int frames) const {
    const double duration_s = (frames - 1) / config_.path().fps();
    const double key_s = std::min(
        kKeyLength_s, kKeyLength_m / std::max(shape.speed_mps, kKeyLength_m / kKeyLength_s));
    const auto count = static_cast<size_t>(std::ceil(duration_s / key_s)) + 2;
    std::vector<Stand> keys;
    if (const auto start = Start(rng.Child("start"), shape)) keys.push_back(*start);
    double heading = rng.Child("heading").Uniform() * 2 * std::numbers::pi;
    while (!keys.empty() && keys.size() < count) {
      if (cancel_.cancelled()) return {};
      if (!GoOn(rng.Child("key", keys.size()), shape, key_s, &heading, &keys)) return {};
    }
    if (keys.empty()) return {};
    // Between slow frames, the way is not straight: it is followed in pieces of a key's length.
    const int parts =
        std::max(1, static_cast<int>(std::ceil(1 / (config_.path().fps() * key_s) - 1e-9)));
    const std::vector<Stand> points = Smooth(keys, shape, key_s, frames, parts);
    std::vector<Stand> way;
    for (size_t i = 0; i < points.size(); i += static_cast<size_t>(parts)) way.push_back(points[i]);
    return IsFree(way, shape) && IsCurveFree(points, shape) ? way : std::vector<Stand>();
  }

  std::optional<Stand> Start(const Rng& rng, const WayShape& shape) const {
    std::optional<Stand> best;
    double best_value = 0;
    uint64_t found = 0;
    for (uint64_t i = 0; i < kStarts && found < kEnoughStarts; ++i) {
      Rng place = rng.Child("place", i);
      Stand stand;
      const double x = place.Uniform(), y = place.Uniform();
      stand.eye =
          bounds_.min() + Vec3d(x * bounds_.sizes().x(), y * bounds_.sizes().y(), shape.altitude_m);
      stand.yaw_rad = 2 * std::numbers::pi * place.Uniform();
      stand.pitch_rad = shape.pitch_rad;
      const auto value = ValueOf(stand, shape);
      if (!value) continue;
      ++found;
      if (best && *value <= best_value) continue;
      best = stand;
      best_value = *value;
    }
    return best;
  }

  // Adds the best of some free keys that the way may lead to.
  bool GoOn(const Rng& rng, const WayShape& shape, double key_s, double* heading,
            std::vector<Stand>* keys) const {
    const Stand from = keys->back();
    const double turn = kTurnPart * config_.path().max_turn_dps() * kRadian * key_s;
    std::optional<Stand> best;
    double best_value = 0, best_heading = *heading;
    uint64_t found = 0;
    for (uint64_t i = 0; i < kSteps && found < kEnoughSteps; ++i) {
      Rng step = rng.Child("step", i);
      // Wider where narrow bends lead nowhere.
      const double bend = kBend_rad * (1 + static_cast<double>(i) / kSteps);
      const double way = *heading + step.Uniform(-bend, bend);
      Stand stand = from;
      stand.eye += shape.speed_mps * key_s * Vec3d(std::cos(way), std::sin(way), 0);
      stand.yaw_rad += step.Uniform(-turn, turn);
      stand.pitch_rad = std::clamp(stand.pitch_rad + 0.25 * step.Uniform(-turn, turn),
                                   shape.pitch_rad - kTilt_rad, shape.pitch_rad + kTilt_rad);
      if (!IsWayFree(from, stand, shape)) continue;
      const auto value = ValueOf(stand, shape);
      if (!value) continue;
      ++found;
      if (best && *value <= best_value) continue;
      best = stand;
      best_value = *value;
      best_heading = way;
    }
    if (!best) return false;
    *heading = best_heading;
    keys->push_back(*best);
    return true;
  }

  // A smooth curve through the keys at an even speed: the stands of all frames, and those that part
  // the time between two into `parts`.
  std::vector<Stand> Smooth(const std::vector<Stand>& keys, const WayShape& shape, double key_s,
                            int frames, int parts) const {
    std::vector<Vec3d> eyes;
    std::vector<double> yaws, pitches;
    for (const Stand& key : keys) {
      eyes.push_back(key.eye);
      yaws.push_back(key.yaw_rad);
      pitches.push_back(key.pitch_rad);
    }
    const std::vector<double> lengths = CurveLengths(eyes);
    std::vector<Stand> way;
    for (int i = 0; i <= (frames - 1) * parts; ++i) {
      const double time_s = i / (config_.path().fps() * parts);
      const double at =
          lengths.back() > 1e-9 ? ParameterAt(lengths, shape.speed_mps * time_s) : time_s / key_s;
      way.push_back({CurveAt(eyes, at), CurveAt(yaws, at), CurveAt(pitches, at)});
    }
    return way;
  }

  // Length of the curve up to each of its pieces' ends.
  static std::vector<double> CurveLengths(const std::vector<Vec3d>& eyes) {
    std::vector<double> lengths = {0};
    Vec3d before = eyes.front();
    for (size_t i = 1; i <= kCurveParts * (eyes.size() - 1); ++i) {
      const Vec3d at = CurveAt(eyes, static_cast<double>(i) / kCurveParts);
      lengths.push_back(lengths.back() + (at - before).norm());
      before = at;
    }
    return lengths;
  }

  // In keys.
  static double ParameterAt(const std::vector<double>& lengths, double length) {
    const auto end = std::upper_bound(lengths.begin(), lengths.end() - 1, length);
    const auto i = static_cast<size_t>(std::max<std::ptrdiff_t>(end - lengths.begin(), 1)) - 1;
    const double part = std::max(lengths[i + 1] - lengths[i], 1e-12);
    return (static_cast<double>(i) + std::clamp((length - lengths[i]) / part, 0.0, 1.0)) /
           kCurveParts;
  }

  bool IsFree(const std::vector<Stand>& way, const WayShape& shape) const {
    const double most = config_.path().max_turn_dps() * kRadian / config_.path().fps() + 1e-9;
    for (size_t i = 0; i < way.size(); ++i) {
      if (!MayStand(way[i], shape)) return false;
      for (const float t : {0.0f, 0.5f, 1.0f}) {
        const Vec3f eye = EyeOf(way[i], t);
        const ViewProbe view = ProbeView(scene_, eye, way[i].Axes(), shape.camera);
        if (view.nearest_m < config_.min_distance_m() || view.sky > kViewSky) return false;
      }
      if (i == 0) continue;
      const Eigen::AngleAxisd turn(
          CameraAxes(way[i - 1].yaw_rad, way[i - 1].pitch_rad).transpose() *
          CameraAxes(way[i].yaw_rad, way[i].pitch_rad));
      if (std::abs(turn.angle()) > most) return false;
    }
    return true;
  }

  bool IsCurveFree(const std::vector<Stand>& points, const WayShape& shape) const {
    for (size_t i = 1; i < points.size(); ++i) {
      if (!IsWayFree(points[i - 1], points[i], shape)) return false;
    }
    return true;
  }

  Vec3f EyeOf(const Stand& stand, float part) const {
    return stand.eye.cast<float>() + part * reach_m_ * stand.Axes().col(0);
  }

  // Depth is measured along the axis: what is so far away at a corner of the image is less deep.
  float Clearance(const WayShape& shape) const {
    return static_cast<float>(config_.min_distance_m() * shape.camera.Corner() + 0.002);
  }

  // Both eyes have room there.
  bool MayStand(const Stand& stand, const WayShape& shape) const {
    const double gap = config_.min_distance_m();
    for (const float t : {0.0f, 1.0f}) {
      const Vec3d eye = EyeOf(stand, t).cast<double>();
      if (((eye - bounds_.min()).array() < gap).head<2>().any() ||
          ((bounds_.max() - eye).array() < gap).head<2>().any() ||
          eye.z() > bounds_.max().z() - kCeilingClear_m) {
        return false;
      }
      if (scene_.solid.Inside(eye.cast<float>())) return false;
    }
    return SegmentClear(scene_.solid, EyeOf(stand, 0), stand.Axes().col(0), reach_m_,
                        Clearance(shape));
  }

  // Both eyes and the middle between them have room on a straight way.
  bool IsWayFree(const Stand& from, const Stand& to, const WayShape& shape) const {
    for (const float t : {0.0f, 0.5f, 1.0f}) {
      const Vec3f begin = EyeOf(from, t), way = EyeOf(to, t) - begin;
      const float length = way.norm();
      const Vec3f along = length > 0 ? Vec3f(way / length) : Vec3f::UnitX();
      if (!SegmentClear(scene_.solid, begin, along, length, Clearance(shape))) return false;
    }
    return true;
  }

  // How much there is to see; nothing where the rig may not be.
  std::optional<double> ValueOf(const Stand& stand, const WayShape& shape) const {
    if (!MayStand(stand, shape)) return std::nullopt;
    const ViewProbe view = ProbeView(scene_, EyeOf(stand, 0), stand.Axes(), shape.camera);
    if (view.nearest_m < config_.min_distance_m() || view.sky > kViewSky ||
        view.close > kViewClose || view.one_thing > kViewOneThing ||
        view.one_plane > kViewOnePlane) {
      return std::nullopt;
    }
    return (0.5 + view.std_m) * (1.05 - view.one_plane) * (0.4 + view.things) *
           std::min(1.0, view.near_m) / (1 + 3 * view.close);
  }

  void AddRigs(uint32_t path, const Rng& own, const WayShape& shape,
               const std::vector<Stand>& way) {
    const double baseline_m = Draw(config_.baseline_m(), own.Child("baseline").Uniform());
    for (size_t i = 0; i < way.size(); ++i) {
      v1::Rig& rig = *scene_.recipe.add_rigs();
      rig = MakeRig({.index = static_cast<uint32_t>(scene_.recipe.rigs_size() - 1),
                     .position = way[i].eye,
                     .axes = CameraAxes(way[i].yaw_rad, way[i].pitch_rad),
                     .baseline_m = baseline_m,
                     .k = shape.camera.k,
                     .width_px = config_.width_px(),
                     .height_px = config_.height_px()});
      const ViewProbe view = ProbeView(scene_, EyeOf(way[i], 0), way[i].Axes(), shape.camera);
      rig.set_depth_std_m(view.std_m);
      rig.set_path(path + 1);
      rig.set_time_s(static_cast<double>(i) / config_.path().fps());
      AddRawCameras(config_, own.Child("camera"), &rig);
    }
  }

  const v1::RigConfig& config_;
  const CancelToken& cancel_;
  SceneInProgress& scene_;
  const Eigen::AlignedBox3d bounds_;
  const Rng root_;
  const float reach_m_;
};

}  // namespace

void RoomPathRigs(const v1::RigConfig& config, const CancelToken& cancel, SceneInProgress& scene) {
  RoomWays(config, cancel, scene).Place();
}

}  // namespace parallax
