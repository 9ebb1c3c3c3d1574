// Rig strategy: frames of walks through open land, like a hand-held rig whose bearer looks around.
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "common/base/rng.h"
#include "parallax/v1/config.pb.h"
#include "parallax/v1/scene.pb.h"
#include "worker/geometry/ray_scene.h"
#include "worker/scene/rigs/rig_camera.h"

namespace parallax {

// The land that walks lead through. Everything that it refers to must outlive it.
struct WalkLand {
  std::function<float(const Vec2f& p)> height;  // The ground's, world, metres.
  const RayScene& solid;                        // Ground, trunks, crowns, stones; committed.
  Vec2f middle = Vec2f::Zero();                 // Walks begin within
  float radius_m = 25;                          // this distance of it.
  // Beside water: whether a place is wet, and the water's body in `solid`. Walks stay dry and look
  // at the water.
  std::function<bool(const Vec2f& p)> wet = nullptr;
  uint32_t water_body = 0;
};

// A walk: its frames, its camera, and the measures that rank it.
struct Walk {
  struct Frame {
    Vec3d eye;  // Left, world.
    double yaw_rad = 0, pitch_rad = 0;
  };
  std::vector<Frame> frames;
  std::vector<Frame> way;  // All frames and, where they are far apart, points between them.
  RigCamera camera;
  double far_share = 0;      // Share of frames in which nothing is nearer than 5 m, by probe rays.
  double log_depth_std = 0;  // Mean over frames.
  double water_share = 0;    // Share of probes that meet water, mean over frames.
  double score() const { return log_depth_std * (0.35 + far_share); }
};

// Draws walks and counts the reasons why they fail. Height above the ground, pitch and speed are
// drawn as the config says, once a walk.
class WalkFinder {
 public:
  // `frames` is the number of frames of one walk.
  WalkFinder(const v1::SceneConfig& config, int frames);

  // Draws a walk from `rng`; returns nothing, and counts the reason, if it fails.
  std::optional<Walk> Try(const WalkLand& land, const Rng& rng, const RigCamera& camera);
  // Returns whether both eyes stay `clearance` away from everything in `solid`, in and between
  // frames.
  bool Clear(const RayScene& solid, const Walk& walk) const;

  // Returns the largest baseline at which the right eye must be clear, metres.
  float reach_m() const { return reach_m_; }

  // Returns the number of failures by reason: "blocked", "sky"...
  const std::map<std::string, int>& reasons() const { return reasons_; }
  std::string Reasons() const;

 private:
  Walk Draft(const WalkLand& land, const Rng& rng, const RigCamera& camera) const;
  bool Probe(const WalkLand& land, Walk& walk, std::string& reason) const;

  const v1::RigConfig& rigs_;
  const v1::WalkConfig& walks_;
  const int frames_;
  const float reach_m_;  // The largest baseline.
  std::map<std::string, int> reasons_;
};

}  // namespace parallax
