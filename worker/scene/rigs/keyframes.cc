#include "worker/scene/rigs/keyframes.h"

#include <numbers>

#include "common/config/config.h"
#include "common/math/stereo.h"

namespace parallax {

void KeyframeRigs(const v1::RigConfig& config, const Rng& root, v1::Scene& recipe) {
  for (uint32_t k = 0; k < static_cast<uint32_t>(config.count()); ++k) {
    const Rng keyframe = KeyframeStream(root, k);
    Rng rng = keyframe.Child("rig");
    const double yaw = rng.Uniform(0, 2 * std::numbers::pi);
    const double pitch = Draw(config.pitch_deg(), rng.Uniform()) * std::numbers::pi / 180;
    const double fov = Draw(config.horizontal_fov_deg(), rng.Uniform()) * std::numbers::pi / 180;
    *recipe.add_rigs() =
        MakeRig({.index = k,
                 .axes = CameraAxes(yaw, pitch),
                 .baseline_m = Draw(config.baseline_m(), keyframe.Child("baseline").Uniform()),
                 .horizontal_fov_rad = fov,
                 .width_px = config.width_px(),
                 .height_px = config.height_px()});
  }
}

}  // namespace parallax
