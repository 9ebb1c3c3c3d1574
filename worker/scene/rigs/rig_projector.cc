#include "worker/scene/rigs/rig_projector.h"

#include <cmath>
#include <numbers>

#include "common/base/rng.h"
#include "common/config/config.h"

namespace parallax {

void AddProjectors(const v1::ProjectorConfig& config, SceneSeed seed, v1::Scene& recipe) {
  const Rng root(seed, "dress/projector");
  const auto draw = [&root](const v1::Distribution& distribution, const char* name) {
    return Draw(distribution, root.Child(name).Uniform());
  };
  constexpr double kRadians = std::numbers::pi / 180;
  v1::Projector device;
  device.set_power_w(draw(config.power_w(), "power"));
  if (!(device.power_w() > 0)) return;
  device.set_dots(static_cast<int32_t>(std::lround(draw(config.dots(), "dots"))));
  device.set_horizontal_fov_rad(draw(config.horizontal_fov_deg(), "horizontal_fov") * kRadians);
  device.set_vertical_fov_rad(draw(config.vertical_fov_deg(), "vertical_fov") * kRadians);
  device.set_dot_rad(draw(config.dot_deg(), "dot") * kRadians);
  Rng pattern = root.Child("pattern");
  device.set_seed(pattern.Seed());
  const double place = draw(config.place(), "place");
  for (v1::Rig& rig : *recipe.mutable_rigs()) {
    if (!rig.shares_left()) device.set_place_m(place * rig.baseline_m());
    *rig.mutable_projector() = device;
  }
}

}  // namespace parallax
