#include "worker/render/lights/light_learning.h"

namespace parallax {

LightTrial TrialOf(const LightTable& lights, const LightReceiver& at, int32_t light, float pdf,
                   float irradiance) {
  if (at.room < 0 || !(at.total > 0.0f)) return {};  // No light was to be sampled.
  const float gain = lights.EnclosureAt(at.room)->gains.Of(at.cell, light);
  const float arrived = irradiance > 0.0f ? irradiance / pdf : 0.0f;
  return {at.room, at.cell, light, arrived * gain / at.total};
}

void LearnGains(std::span<const std::vector<LightTrial>> trials, LightTable* lights) {
  std::vector<Enclosure>& enclosures = lights->mutable_enclosures();
  for (const std::vector<LightTrial>& some : trials) {
    for (const LightTrial& trial : some) {
      LightGains& gains = enclosures[static_cast<size_t>(trial.room)].gains;
      gains.Add(trial.cell, trial.light, trial.gain);
    }
  }
  for (Enclosure& enclosure : enclosures) enclosure.gains.Learn();
}

void LearnSpots(std::span<const std::vector<LightSeen>> seen, LightTable* lights) {
  std::vector<Enclosure>& enclosures = lights->mutable_enclosures();
  for (const std::vector<LightSeen>& some : seen) {
    for (const LightSeen& one : some) {
      for (Enclosure& enclosure : enclosures) {
        if (!enclosure.Holds(one.position)) continue;
        enclosure.spots.Add(one.position, one.normal, one.radiance);
        break;
      }
    }
  }
  for (Enclosure& enclosure : enclosures) enclosure.spots.Learn();
}

void ForgetLights(LightTable* lights) {
  for (Enclosure& enclosure : lights->mutable_enclosures()) {
    enclosure.gains = LightGains(enclosure.box, lights->LightsIn(&enclosure));
    enclosure.spots = BrightSpots();
  }
}

}  // namespace parallax
