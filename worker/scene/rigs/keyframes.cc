#include "worker/scene/rigs/keyframes.h"

#include <numbers>

#include "common/config/config.h"
#include "common/math/stereo.h"
#include "worker/scene/rigs/rig_camera.h"

namespace parallax {

void AddKeyframeRig(const v1::RigConfig& config, const Rng& keyframe, uint32_t index,
                    const Vec3d& position, const Eigen::Matrix3d& axes, const RigCamera& camera,
                    v1::Scene& recipe) {
  v1::Rig& rig = *recipe.add_rigs();
  rig = MakeRig({.index = index,
                 .position = position,
                 .axes = axes,
                 .baseline_m = Draw(config.baseline_m(), keyframe.Child("baseline").Uniform()),
                 .k = camera.k,
                 .width_px = config.width_px(),
                 .height_px = config.height_px()});
  AddRawCameras(config, keyframe.Child("camera"), &rig);
}

void KeyframeRigs(const v1::RigConfig& config, const Rng& root, v1::Scene& recipe) {
  for (uint32_t k = 0; k < static_cast<uint32_t>(config.count()); ++k) {
    const Rng keyframe = KeyframeStream(root, k);
    Rng rng = keyframe.Child("rig");
    const double yaw = rng.Uniform(0, 2 * std::numbers::pi);
    const double pitch = Draw(config.pitch_deg(), rng.Uniform()) * std::numbers::pi / 180;
    const RigCamera camera = DrawRigCamera(config, rng.Uniform(), keyframe.Child("camera"));
    AddKeyframeRig(config, keyframe, k, Vec3d::Zero(), CameraAxes(yaw, pitch), camera, recipe);
  }
}

}  // namespace parallax
