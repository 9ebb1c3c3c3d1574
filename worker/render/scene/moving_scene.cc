#include "worker/render/scene/moving_scene.h"

#include "common/math/sequence.h"

namespace parallax {

std::vector<bool> MoversOf(const v1::Scene& scene, const SceneGeometry& geometry) {
  if (scene.keyframes_size() > 0) return std::vector<bool>(geometry.meshes.size(), true);
  if (!HasMotion(scene)) return {};
  std::vector<bool> movers(geometry.meshes.size(), false);
  for (int i = 0; i < scene.objects_size(); ++i) {
    if (scene.objects(i).has_motion()) movers[static_cast<size_t>(i)] = true;
  }
  return movers;
}

MovingScene::MovingScene(const v1::Scene& scene, RenderScene* geometry) : geometry_(*geometry) {
  if (HasMotion(scene)) objects_.assign(scene.objects().begin(), scene.objects().end());
}

absl::Status MovingScene::MoveTo(double time_s) {
  if (!moves() || time_s_ == time_s) return absl::OkStatus();
  std::vector<Eigen::Affine3f> places;
  for (const v1::SceneObject& object : objects_) {
    places.push_back(PoseAt(object, time_s).Affine());
  }
  const auto& meshes = geometry_.geometry().meshes;
  for (size_t i = places.size(); i < meshes.size(); ++i) {
    places.push_back(meshes[i].world_from_object);
  }
  time_s_.reset();
  RETURN_IF_ERROR(geometry_.Move(places));
  time_s_ = time_s;
  return absl::OkStatus();
}

std::map<uint32_t, Eigen::Affine3d> MovingScene::MotionBetween(double now_s, double then_s) const {
  std::map<uint32_t, Eigen::Affine3d> motions;
  for (const v1::SceneObject& object : objects_) {
    if (!object.has_motion()) continue;
    const Pose then_from_now = PoseAt(object, then_s) * PoseAt(object, now_s).Inverse();
    motions[object.index()] = Eigen::Translation3d(then_from_now.translation) *
                              then_from_now.rotation * Eigen::Scaling(then_from_now.scale);
  }
  return motions;
}

}  // namespace parallax
