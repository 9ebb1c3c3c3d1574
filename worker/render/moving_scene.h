// A scene whose objects move (SceneObject.motion), brought to the time of a frame.
#pragma once

#include <Eigen/Geometry>
#include <map>
#include <optional>
#include <vector>

#include "parallax/v1/scene.pb.h"
#include "worker/render/render_scene.h"

namespace parallax {

// By mesh, whether it moves within the scene's frames or from keyframe to keyframe; empty: none.
std::vector<bool> MoversOf(const v1::Scene& scene, const SceneGeometry& geometry);

class MovingScene {
 public:
  // `geometry` stands as at time 0, and outlives it. Scenes without motion stay as they are.
  MovingScene(const v1::Scene& scene, RenderScene* geometry);

  bool moves() const { return !objects_.empty(); }
  // Everything stands as at that time. Errors: as RenderScene::Move.
  absl::Status MoveTo(double time_s);
  // How points of objects that move go from one time to another, world, by SceneObject.index.
  std::map<uint32_t, Eigen::Affine3d> MotionBetween(double now_s, double then_s) const;

 private:
  RenderScene& geometry_;
  std::vector<v1::SceneObject> objects_;  // None unless some move.
  std::optional<double> time_s_ = 0;      // At which they stand; nothing: a move failed.
};

}  // namespace parallax
