#include "worker/scene/floating/floating_motion.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "common/config/config.h"
#include "common/math/sequence.h"

namespace parallax {
namespace {

constexpr uint64_t kMotionTries = 12;
constexpr uint64_t kSpinTries = 4;  // Then it may only turn where it is.

Vec3d RandomDirection(Rng& rng) {
  const double z = rng.Uniform(-1, 1), angle = rng.Uniform(0, 2 * std::numbers::pi);
  const double r = std::sqrt(std::max(0.0, 1 - z * z));
  return {r * std::cos(angle), r * std::sin(angle), z};
}

v1::SceneObject MovingObject(const v1::Transform& place, const v1::RigidMotion& motion) {
  v1::SceneObject object;
  *object.mutable_world_from_object() = place;
  *object.mutable_motion() = motion;
  return object;
}

}  // namespace

FloatingMotion::FloatingMotion(const v1::FloatingConfig& config, const v1::Scene& scene,
                               const RayScene& solid, ViewGuard& guard,
                               std::function<bool(const Box3f&, const Pose&)> may_be)
    : config_(config), solid_(solid), guard_(guard), may_be_(std::move(may_be)) {
  for (const v1::Rig& rig : scene.rigs()) times_s_.push_back(rig.time_s());
  std::sort(times_s_.begin(), times_s_.end());
  times_s_.erase(std::unique(times_s_.begin(), times_s_.end()), times_s_.end());
}

std::optional<v1::RigidMotion> FloatingMotion::Draw(const Rng& stream, const FloatingBody& body) {
  if (!(stream.Child("moves").Uniform() < config_.motion().p())) return std::nullopt;
  for (uint64_t k = 0; k < kMotionTries + kSpinTries; ++k) {
    Rng rng = stream.Child("try", k);
    const Vec3d way = RandomDirection(rng), axis = RandomDirection(rng);
    const double speed = parallax::Draw(config_.motion().speed_mps(), rng.Uniform());
    const double spin = parallax::Draw(config_.motion().spin_dps(), rng.Uniform());
    v1::RigidMotion motion;
    *motion.mutable_velocity_mps() = ToProto((k < kMotionTries ? speed : 0) * way);
    *motion.mutable_spin_rps() = ToProto(spin * std::numbers::pi / 180 * axis);
    const v1::SceneObject moving = MovingObject(body.world_from_object, motion);
    if (!MayMove(body, motion) ||
        !guard_.Allows(body.bounds, [&](double t) { return PoseAt(moving, t); })) {
      continue;
    }
    movers_.push_back({body.tree, moving});
    return motion;
  }
  guard_.Allows(body.bounds, [&](double) { return FromProto(body.world_from_object); });
  return std::nullopt;
}

bool FloatingMotion::MayMove(const FloatingBody& body, const v1::RigidMotion& motion) const {
  const v1::SceneObject moving = MovingObject(body.world_from_object, motion);
  return std::all_of(times_s_.begin(), times_s_.end(), [&](double time_s) {
    const Pose pose = PoseAt(moving, time_s);
    if (!may_be_(body.bounds, pose)) return false;
    return config_.allow_intersections() ||
           (!solid_.Overlaps(*body.tree, pose.Affine()) && !MeetsMovers(*body.tree, time_s, pose));
  });
}

bool FloatingMotion::IsClear(const FloatingBody& body) const {
  const Pose pose = FromProto(body.world_from_object);
  return movers_.empty() || std::all_of(times_s_.begin(), times_s_.end(), [&](double time_s) {
           return !MeetsMovers(*body.tree, time_s, pose);
         });
}

bool FloatingMotion::MeetsMovers(const TriangleTree& tree, double time_s, const Pose& pose) const {
  const Eigen::Affine3f place = pose.Affine();
  return std::any_of(movers_.begin(), movers_.end(), [&](const Mover& mover) {
    return Overlap(*mover.tree, PoseAt(mover.object, time_s).Affine(), tree, place);
  });
}

}  // namespace parallax
