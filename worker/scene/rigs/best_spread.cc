#include "worker/scene/rigs/best_spread.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <vector>

#include "common/base/rng.h"
#include "common/config/config.h"
#include "common/math/stereo.h"
#include "worker/scene/rigs/rig_camera.h"

namespace parallax {
namespace {

// Probe rays of one view: enough to rank candidates, cheap enough for hundreds of them.
constexpr int kProbesX = 20, kProbesY = 11;
constexpr int kCandidatesPerRig = 15;  // Accepted candidates among which each rig is chosen.
constexpr int kTriesPerRig = 120;
constexpr int kRedraws = 4;           // New heights and pitches for a rig when no place suits.
constexpr double kMaxSky = 0.35;      // Share of probes that may leave the room by a window.
constexpr double kMaxOnePlane = 0.8;  // Share that may fall on one flat surface.
constexpr double kClose_m = 0.55, kMaxClose = 0.3;  // Share that may be nearer than this.
// Beyond these shares of the view, what is close or one thing alone counts against a candidate.
constexpr double kSomeClose = 0.03, kOneThing = 0.35;
constexpr double kMaxOneThing = 0.65;
constexpr double kNear_m = 1.0;  // A twentieth of the view should not be nearer than this.
constexpr double kCeilingGap_m = 0.2;
// Two rigs this far apart, or turned this much, show different things.
constexpr double kApart_m = 0.9;
constexpr double kApart_rad = 0.7;

struct Candidate {
  size_t slot = 0;  // Which rig it would be.
  Vec3d position = Vec3d::Zero();
  Mat3f camera = Mat3f::Identity();  // Columns: right, down, forward; world frame.
  RigCamera view;
  double depth_std_m = 0;
  double value = 0;  // Rank among the candidates.
};

}  // namespace

ViewProbe ProbeView(const SceneInProgress& scene, const Vec3f& eye, const Mat3f& camera,
                    const RigCamera& view) {
  const RayScene& solid = scene.solid;
  int things = 0, out = 0;
  std::vector<double> depths;
  std::map<std::array<int, 4>, int> planes;  // Body and normal.
  std::map<uint32_t, int> bodies;            // Things only.
  for (int y = 0; y < kProbesY; ++y) {
    for (int x = 0; x < kProbesX; ++x) {
      const Vec3f local =
          view.DirectionAt(2 * (x + 0.5) / kProbesX - 1, 2 * (y + 0.5) / kProbesY - 1)
              .cast<float>();
      // The direction has length 1 along the axis, so a hit's distance is its depth.
      const Vec3f direction = camera * local;
      const auto hit = solid.Intersect(eye, direction);
      if (!hit) {
        ++out;
        if (scene.view_out_m > 0) depths.push_back(scene.view_out_m);
        continue;
      }
      if (scene.recipe.objects(static_cast<int>(hit->body)).part().empty()) {
        ++things;
        ++bodies[hit->body];
      }
      depths.push_back(static_cast<double>(hit->distance));
      ++planes[{static_cast<int>(hit->body), static_cast<int>(std::lround(hit->normal.x() * 8)),
                static_cast<int>(std::lround(hit->normal.y() * 8)),
                static_cast<int>(std::lround(hit->normal.z() * 8))}];
    }
  }
  ViewProbe probe;
  const double total = kProbesX * kProbesY;
  probe.things = things / total;
  probe.sky = 1 - (total - out) / total;
  if (depths.empty()) return probe;
  double mean = 0, square = 0;
  for (const double d : depths) {
    probe.nearest_m = std::min(probe.nearest_m, d);
    mean += d;
    square += d * d;
    probe.close += d < kClose_m ? 1 / total : 0;
  }
  mean /= static_cast<double>(depths.size());
  square /= static_cast<double>(depths.size());
  probe.std_m = std::sqrt(std::max(0.0, square - mean * mean));
  for (const auto& [plane, count] : planes) {
    probe.one_plane = std::max(probe.one_plane, count / total);
  }
  for (const auto& [body, count] : bodies) {
    probe.one_thing = std::max(probe.one_thing, count / total);
  }
  const auto twentieth = depths.begin() + static_cast<std::ptrdiff_t>(depths.size() / 20);
  std::nth_element(depths.begin(), twentieth, depths.end());
  probe.near_m = *twentieth;
  return probe;
}

// Walks in steps that the distance found so far makes safe.
bool SegmentClear(const RayScene& solid, const Vec3f& from, const Vec3f& right, float length,
                  float distance) {
  constexpr float kSlack = 0.004f, kReach = 0.5f;
  for (float t = 0;;) {
    const float free = solid.NearestDistance(from + t * right, distance + kReach);
    if (free < distance + kSlack) return false;
    if (t >= length) return true;
    t = std::min(length, t + (free - distance));
  }
}

namespace {

double Difference(const Candidate& a, const Candidate& b) {
  const double apart = (a.position - b.position).norm() / kApart_m;
  const double cosine = std::clamp(a.camera.col(2).dot(b.camera.col(2)), -1.0f, 1.0f);
  return std::hypot(apart, std::acos(cosine) / kApart_rad);
}

class RigChooser {
 public:
  RigChooser(const v1::RigConfig& config, const SceneInProgress& scene)
      : config_(config),
        scene_(scene),
        bounds_(scene.surroundings.bounds),
        solid_(scene.solid),
        root_(scene.seed, "dress/rigs"),
        reach_m_(
            static_cast<float>(std::max(config.clearance_baseline_m(), LargestBaseline(config)))) {}

  // Each rig has its own height, pitch and field of view, drawn as the config says; only where it
  // stands and which way it turns is chosen among candidates. So the choice does not bend those
  // distributions.
  std::vector<Candidate> Choose() const {
    std::vector<Candidate> candidates;
    for (int slot = 0; slot < config_.count(); ++slot) {
      const size_t before = candidates.size();
      for (int draw = 0; draw < kRedraws && candidates.size() == before; ++draw) {
        for (int i = 0; i < kTriesPerRig && candidates.size() < before + kCandidatesPerRig; ++i) {
          Candidate candidate = Draft(static_cast<size_t>(slot), draw, i);
          if (Accept(candidate)) candidates.push_back(candidate);
        }
      }
    }
    return PickDifferent(std::move(candidates));
  }

 private:
  Candidate Draft(size_t slot, int draw, int i) const {
    const Rng own = root_.Child("rig", slot).Child("draw", static_cast<uint64_t>(draw));
    Rng shape = own, place = own.Child("place", static_cast<uint64_t>(i));
    Candidate candidate;
    candidate.slot = slot;
    const double altitude = Draw(config_.altitude_m(), shape.Uniform());
    const double pitch = Draw(config_.pitch_deg(), shape.Uniform()) * std::numbers::pi / 180;
    candidate.view =
        DrawRigCamera(config_, root_.Child("fov", slot).Uniform(), root_.Child("camera", slot));
    const double x = place.Uniform(), y = place.Uniform();
    const double yaw = 2 * std::numbers::pi * place.Uniform();
    const Vec3d size = bounds_.sizes();
    candidate.position = bounds_.min() + Vec3d(x * size.x(), y * size.y(), altitude);
    candidate.camera = CameraAxes(yaw, pitch).cast<float>();
    return candidate;
  }

  bool Accept(Candidate& candidate) const {
    const double gap = config_.min_distance_m();
    if (candidate.position.z() > bounds_.max().z() - kCeilingGap_m) return false;
    const Vec3f eye = candidate.position.cast<float>(), right = candidate.camera.col(0);
    const Vec3f far_eye = eye + reach_m_ * right;
    // Both eyes stay within the bounds: a segment may not lead out by a window.
    const Vec3d &low = bounds_.min(), &high = bounds_.max();
    for (const Vec3f& p : {eye, far_eye}) {
      if (p.x() < low.x() + gap || p.y() < low.y() + gap || p.x() > high.x() - gap ||
          p.y() > high.y() - gap) {
        return false;
      }
    }
    // Depth is measured along the axis: what is `gap` away at a corner of the image is less deep.
    const float clear = static_cast<float>(gap * candidate.view.Corner() + 0.002);
    if (!SegmentClear(solid_, eye, right, reach_m_, clear)) return false;
    if (solid_.Inside(eye) || solid_.Inside(far_eye)) return false;
    const ViewProbe left = ProbeView(scene_, eye, candidate.camera, candidate.view);
    if (left.nearest_m < gap || left.sky > kMaxSky) return false;
    if (left.one_plane > kMaxOnePlane || left.close > kMaxClose) return false;
    if (left.one_thing > kMaxOneThing) return false;
    for (const float t : {0.5f, 1.0f}) {
      const ViewProbe other =
          ProbeView(scene_, eye + t * reach_m_ * right, candidate.camera, candidate.view);
      if (other.nearest_m < gap) return false;
    }
    candidate.depth_std_m = left.std_m;
    // Depth spreads most along a wall; so that not all rigs do that, bare walls count against it
    // and things for it.
    candidate.value = left.std_m * (1 - left.one_plane) * (0.4 + left.things);
    // Views that a thing right before the lens fills have their spread of depth for nothing.
    const auto beyond = [](double share, double limit) { return std::max(0.0, share / limit - 1); };
    candidate.value *= std::min(1.0, left.near_m / kNear_m);
    candidate.value /= 1 + beyond(left.close, kSomeClose) + 2 * beyond(left.one_thing, kOneThing);
    return true;
  }

  // Greedy: each time the largest spread of depth, discounted for candidates that resemble a chosen
  // one. One for each rig; in order of rigs.
  std::vector<Candidate> PickDifferent(std::vector<Candidate> candidates) const {
    std::vector<Candidate> chosen;
    std::vector<double> difference(candidates.size(), std::numeric_limits<double>::infinity());
    std::vector<bool> filled(static_cast<size_t>(config_.count()), false);
    while (static_cast<int>(chosen.size()) < config_.count()) {
      size_t best = candidates.size();
      double best_value = -1;
      for (size_t i = 0; i < candidates.size(); ++i) {
        if (filled[candidates[i].slot]) continue;
        const double value = candidates[i].value * std::min(1.0, difference[i]);
        if (value > best_value) {
          best_value = value;
          best = i;
        }
      }
      if (best == candidates.size()) break;
      chosen.push_back(candidates[best]);
      for (size_t i = 0; i < candidates.size(); ++i) {
        difference[i] = std::min(difference[i], Difference(candidates[i], chosen.back()));
      }
      filled[candidates[best].slot] = true;
    }
    std::sort(chosen.begin(), chosen.end(),
              [](const Candidate& a, const Candidate& b) { return a.slot < b.slot; });
    return chosen;
  }

  const v1::RigConfig& config_;
  const SceneInProgress& scene_;
  const Eigen::AlignedBox3d bounds_;
  const RayScene& solid_;
  Rng root_;
  float reach_m_;
};

}  // namespace

void BestSpreadRigs(const v1::RigConfig& config, SceneInProgress& scene) {
  const std::vector<Candidate> chosen = RigChooser(config, scene).Choose();
  const Rng root(scene.seed, "dress/rig");
  for (size_t i = 0; i < chosen.size(); ++i) {
    const Candidate& candidate = chosen[i];
    v1::Rig& rig = *scene.recipe.add_rigs();
    rig = MakeRig({.index = static_cast<uint32_t>(i),
                   .position = candidate.position,
                   .axes = candidate.camera.cast<double>(),
                   .baseline_m = Draw(config.baseline_m(), root.Child("baseline", i).Uniform()),
                   .k = candidate.view.k,
                   .width_px = config.width_px(),
                   .height_px = config.height_px()});
    rig.set_depth_std_m(candidate.depth_std_m);
    AddRawCameras(config, Rng(scene.seed, "dress/rigs").Child("camera", candidate.slot), &rig);
  }
}

}  // namespace parallax
