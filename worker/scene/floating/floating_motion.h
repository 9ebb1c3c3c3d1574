// Motion of floating objects in sequences: straight on and turning, clear of the cameras and of all
// else at the time of every frame. Private to worker/scene.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "common/base/rng.h"
#include "parallax/v1/config.pb.h"
#include "parallax/v1/scene.pb.h"
#include "worker/geometry/ray_scene.h"
#include "worker/scene/floating/view_guard.h"

namespace parallax {

// An object that may move, at its place at time 0.
struct FloatingBody {
  std::shared_ptr<const TriangleTree> tree;
  Box3f bounds;  // Object frame.
  v1::Transform world_from_object;
};

// Not thread-safe. What it is given outlives it.
class FloatingMotion {
 public:
  // `may_be`: whether bounds at a pose are within the room.
  FloatingMotion(const v1::FloatingConfig& config, const v1::Scene& scene, const RayScene& solid,
                 ViewGuard& guard, std::function<bool(const Box3f&, const Pose&)> may_be);

  // Draws whether and how `body` moves, from addresses below `stream`. The guard must have allowed
  // its resting place last; it is left as the body's views then are. Absent: the body rests, as
  // drawn or because it hits something whichever way it goes.
  std::optional<v1::RigidMotion> Draw(const Rng& stream, const FloatingBody& body);

  // Returns whether a body that rests there is clear of all that moves.
  bool IsClear(const FloatingBody& body) const;

 private:
  bool MayMove(const FloatingBody& body, const v1::RigidMotion& motion) const;
  bool MeetsMovers(const TriangleTree& tree, double time_s, const Pose& pose) const;

  struct Mover {
    std::shared_ptr<const TriangleTree> tree;
    v1::SceneObject object;  // Place and motion.
  };

  const v1::FloatingConfig& config_;
  const RayScene& solid_;
  ViewGuard& guard_;
  const std::function<bool(const Box3f&, const Pose&)> may_be_;
  std::vector<double> times_s_;  // The frames' times, ascending.
  std::vector<Mover> movers_;
};

}  // namespace parallax
