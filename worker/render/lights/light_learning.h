// Learns from paths already traced which lights matter where: gains of lights in the cells of a
// room (light_gains.h) and the bright spots of its surfaces (bright_spots.h).
//
// These functions change the table: none may run while lights are sampled.
#pragma once

#include <span>
#include <vector>

#include "worker/render/lights/light_sampler.h"
#include "worker/render/lights/light_table.h"

namespace parallax {

// The result of one light sample.
struct LightTrial {
  int32_t room = -1;  // Index of the table's enclosure; negative: nothing to be learnt.
  int32_t cell = 0;
  int32_t light = 0;
  float gain = 0;
};

// Light that a surface scattered towards a path.
struct LightSeen {
  Vec3f position = Vec3f::Zero();
  Vec3f normal = Vec3f::UnitZ();
  float radiance = 0;  // Luminance.
};

// The trial of a sample with density `pdf` of which this much irradiance arrived. Thread-safe.
LightTrial TrialOf(const LightTable& lights, const LightReceiver& at, int32_t light, float pdf,
                   float irradiance);

// Uses these trials, and earlier ones, for future choices among lights.
void LearnGains(std::span<const std::vector<LightTrial>> trials, LightTable* lights);

// Uses this scattered light, and earlier, to find the bright spots.
void LearnSpots(std::span<const std::vector<LightSeen>> seen, LightTable* lights);

// Discards all that was learnt.
void ForgetLights(LightTable* lights);

}  // namespace parallax
