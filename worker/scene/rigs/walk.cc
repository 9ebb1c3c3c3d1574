#include "worker/scene/rigs/walk.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/config/config.h"
#include "common/math/stereo.h"

namespace parallax {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kKey_m = 3;  // Between the points that a walk leads through.
constexpr int kWalkProbesX = 16, kWalkProbesY = 9;
constexpr double kFar_m = 5;                              // The stricter filter of the study.
constexpr double kWalkClose_m = 1, kWalkMaxClose = 0.05;  // Share of a view that may be nearer.
constexpr double kSteepest = 0.5;                         // Rise over run under the feet.
// Share of a view that may be sky or so far away that no picture has disparities to learn there.
constexpr double kDistant_m = 1000, kMaxDistant = 0.8;
constexpr double kMaxOneDistance = 0.9;  // Share of a view within a tenth of one depth.
// Mean share of a walk's views, beside water.
constexpr double kLeastWater = 0.1, kMostWater = 0.65;

// Catmull-Rom through keys; `at` in keys.
double Smooth(const std::vector<double>& keys, double at) {
  const auto last = static_cast<int>(keys.size()) - 1;
  const int i = std::clamp(static_cast<int>(at), 0, last - 1);
  const double t = at - i;
  const auto key = [&](int k) { return keys[static_cast<size_t>(std::clamp(k, 0, last))]; };
  const double a = key(i - 1), b = key(i), c = key(i + 1), d = key(i + 2);
  return b + 0.5 * t * (c - a + t * (2 * a - 5 * b + 4 * c - d + t * (3 * (b - c) + d - a)));
}

struct View {
  double sky = 0, close = 0;  // Shares of the probes.
  double distant = 0;         // Share of distant pixels, sky included.
  double nearest_m = 1e9;     // Depth.
  double log_std = 0;
  double one_distance = 0;  // Largest share whose depths differ by a tenth at most.
  double water = 0;         // Share of the probes.
};

View Look(const WalkLand& land, const Vec3f& eye, const Mat3f& axes, const RigCamera& camera) {
  View view;
  std::vector<double> logs;
  for (int y = 0; y < kWalkProbesY; ++y) {
    for (int x = 0; x < kWalkProbesX; ++x) {
      // The outermost probes are at the picture's border.
      const Vec3f local =
          camera.DirectionAt(2.0 * x / (kWalkProbesX - 1) - 1, 2.0 * y / (kWalkProbesY - 1) - 1)
              .cast<float>();
      const auto hit = land.solid.Intersect(eye, axes * local);
      if (!hit) continue;
      const auto depth = static_cast<double>(hit->distance);
      view.nearest_m = std::min(view.nearest_m, depth);
      view.close += depth < kWalkClose_m;
      view.distant += depth > kDistant_m;
      view.water += land.wet && hit->body == land.water_body;
      logs.push_back(std::log(std::max(depth, 0.01)));
    }
  }
  constexpr double kCount = kWalkProbesX * kWalkProbesY;
  view.sky = 1 - static_cast<double>(logs.size()) / kCount;
  view.close /= kCount;
  view.distant = view.distant / kCount + view.sky;
  view.water /= kCount;
  if (logs.empty()) return view;
  double sum = 0, squares = 0;
  for (const double log : logs) {
    sum += log;
    squares += log * log;
  }
  const auto n = static_cast<double>(logs.size());
  view.log_std = std::sqrt(std::max(0.0, squares / n - sum / n * (sum / n)));
  std::sort(logs.begin(), logs.end());
  size_t begin = 0;
  for (size_t end = 0; end < logs.size(); ++end) {
    while (logs[end] - logs[begin] > 0.1) ++begin;
    view.one_distance = std::max(view.one_distance, static_cast<double>(end - begin + 1) / kCount);
  }
  return view;
}

// Whether nothing is nearer than `distance` to the segment; walks in steps that are safe.
bool SegmentClear(const RayScene& solid, const Vec3f& from, const Vec3f& to, float distance) {
  constexpr float kReach = 0.6f, kSlack = 0.004f;
  const float length = (to - from).norm();
  const Vec3f along = length > 0 ? Vec3f((to - from) / length) : Vec3f::UnitX();
  for (float t = 0;;) {
    const float free = solid.NearestDistance(from + t * along, distance + kReach);
    if (free < distance + kSlack) return false;
    if (t >= length) return true;
    t = std::min(length, t + (free - distance));
  }
}

}  // namespace

WalkFinder::WalkFinder(const v1::SceneConfig& config, int frames)
    : rigs_(config.rigs()),
      walks_(config.nature().walk()),
      frames_(frames),
      reach_m_(static_cast<float>(
          std::max(config.rigs().clearance_baseline_m(), LargestBaseline(config.rigs())))) {}

Walk WalkFinder::Draft(const WalkLand& land, const Rng& rng, const RigCamera& camera) const {
  Rng shape = rng.Child("shape"), way = rng.Child("way");
  const double altitude = Draw(rigs_.altitude_m(), shape.Uniform());
  const double pitch = Draw(rigs_.pitch_deg(), shape.Uniform()) * kDegree;
  const double speed = Draw(walks_.speed_mps(), shape.Uniform());
  const double step = speed / std::max(walks_.fps(), 1e-3);
  const double angle = way.Uniform(0, 2 * std::numbers::pi);
  const double away = static_cast<double>(land.radius_m) * std::sqrt(way.Uniform());
  double heading = way.Uniform(0, 2 * std::numbers::pi);
  const double look = heading + way.Uniform(0, 2 * std::numbers::pi);
  // Keys of the way, of the height that feet follow, and of what the view turns by.
  const auto keys = static_cast<size_t>(std::ceil(step * frames_ / kKey_m)) + 2;
  std::vector<double> x, y, ground, yaw, tilt;
  Vec2d at = land.middle.cast<double>() + away * Vec2d(std::cos(angle), std::sin(angle));
  for (size_t k = 0; k < keys; ++k) {
    x.push_back(at.x());
    y.push_back(at.y());
    // The mean over a stride or two: heads do not follow every bump.
    double sum = 0;
    for (int i = 0; i < 8; ++i) {
      const double a = i * std::numbers::pi / 4;
      const Vec2d p = at + 0.8 * Vec2d(std::cos(a), std::sin(a));
      sum += static_cast<double>(land.height(p.cast<float>())) / 8;
    }
    ground.push_back(sum);
    yaw.push_back(look + way.Normal(0, 5 * kDegree));
    tilt.push_back(way.Normal(0, 2 * kDegree));
    heading += way.Uniform(-20, 20) * kDegree;
    at += kKey_m * Vec2d(std::cos(heading), std::sin(heading));
  }
  Walk walk;
  walk.camera = camera;
  // Between frames that are far apart, the way is not straight.
  const int parts = std::max(1, static_cast<int>(std::ceil(step / kKey_m)));
  for (int i = 0; i <= (frames_ - 1) * parts; ++i) {
    const double key = step * i / parts / kKey_m;
    Walk::Frame frame;
    frame.eye = {Smooth(x, key), Smooth(y, key), Smooth(ground, key) + altitude};
    frame.yaw_rad = Smooth(yaw, key);
    frame.pitch_rad = std::clamp(pitch + Smooth(tilt, key), 0.02, std::numbers::pi - 0.02);
    walk.way.push_back(frame);
    if (i % parts == 0) walk.frames.push_back(frame);
  }
  return walk;
}

bool WalkFinder::Probe(const WalkLand& land, Walk& walk, std::string& reason) const {
  double far = 0, spread = 0, seen = 0, water = 0;
  for (size_t i = 0; i < walk.frames.size(); i += i + 2 < walk.frames.size() ? 2 : 1) {
    const Walk::Frame& frame = walk.frames[i];
    const Mat3f axes = CameraAxes(frame.yaw_rad, frame.pitch_rad).cast<float>();
    const View view = Look(land, frame.eye.cast<float>(), axes, walk.camera);
    if (view.sky > walks_.max_sky_share()) return reason = "sky", false;
    if (view.distant > kMaxDistant) return reason = "distant", false;
    if (view.nearest_m < rigs_.min_distance_m()) return reason = "near", false;
    if (view.close > kWalkMaxClose) return reason = "close", false;
    if (view.one_distance > kMaxOneDistance) return reason = "bare", false;
    far += view.nearest_m >= kFar_m;
    spread += view.log_std;
    water += view.water;
    ++seen;
  }
  walk.water_share = water / seen;
  if (land.wet && walk.water_share < kLeastWater) return reason = "no water", false;
  if (land.wet && walk.water_share > kMostWater) return reason = "water only", false;
  walk.far_share = far / seen;
  walk.log_depth_std = spread / seen;
  return true;
}

bool WalkFinder::Clear(const RayScene& solid, const Walk& walk) const {
  const auto clearance = static_cast<float>(walks_.clearance_m());
  const auto eye = [&](size_t i, float t) -> Vec3f {
    const Walk::Frame& frame = walk.way[i];
    const Vec3d right = CameraAxes(frame.yaw_rad, frame.pitch_rad).col(0);
    return (frame.eye + static_cast<double>(t * reach_m_) * right).cast<float>();
  };
  for (size_t i = 0; i < walk.way.size(); ++i) {
    if (!SegmentClear(solid, eye(i, 0), eye(i, 1), clearance)) return false;
    if (i + 1 == walk.way.size()) break;
    for (const float t : {0.0f, 0.5f, 1.0f}) {
      if (!SegmentClear(solid, eye(i, t), eye(i + 1, t), clearance)) return false;
    }
  }
  return true;
}

std::optional<Walk> WalkFinder::Try(const WalkLand& land, const Rng& rng, const RigCamera& camera) {
  Walk walk = Draft(land, rng, camera);
  std::string reason;
  const auto steep = [&] {
    for (size_t i = 0; i + 1 < walk.way.size(); ++i) {
      const Vec3d step = walk.way[i + 1].eye - walk.way[i].eye;
      if (std::abs(step.z()) > kSteepest * step.head<2>().norm() + 0.02) return true;
    }
    return false;
  };
  const auto wet = [&] {
    return land.wet && std::any_of(walk.way.begin(), walk.way.end(), [&](const Walk::Frame& frame) {
             return land.wet(frame.eye.head<2>().cast<float>());
           });
  };
  const auto turns = [&] {
    for (size_t i = 0; i + 1 < walk.frames.size(); ++i) {
      const Walk::Frame &a = walk.frames[i], &b = walk.frames[i + 1];
      const double turn = std::hypot(a.yaw_rad - b.yaw_rad, a.pitch_rad - b.pitch_rad);
      if (turn > walks_.max_turn_deg() * kDegree) return true;
    }
    return false;
  };
  if (steep()) {
    reason = "steep";
  } else if (turns()) {
    reason = "turns";
  } else if (wet()) {
    reason = "wet";
  } else if (!Clear(land.solid, walk)) {
    reason = "blocked";
  } else if (Probe(land, walk, reason)) {
    return walk;
  }
  ++reasons_[reason];
  return std::nullopt;
}

std::string WalkFinder::Reasons() const {
  std::string text;
  for (const auto& [reason, count] : reasons_) {
    text += fmt::format("{}{} {}", text.empty() ? "" : ", ", count, reason);
  }
  return text;
}

}  // namespace parallax
