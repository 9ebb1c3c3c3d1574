// Erosion of height fields by water and gravity: valleys that branch, gullies, alluvial fans and
// screes. Each is a pure function of its input and seed, the same on any number of threads.
#pragma once

#include <cstdint>

#include "worker/terrain/field.h"

namespace parallax {

struct StreamPowerOptions {
  int steps = 50;  // More: older landscape. About 20 ms each at 512^2.
  // Kilometres that the cut of a stream which drains one square kilometre moves upstream in a step.
  // Larger: valleys reach the divides sooner, and are wider.
  float erodibility = 0.4f;
  float area_exponent = 0.45f;  // m of the stream power law; slope's exponent is 1.
  float talus = 0.9f;           // Slope that hillsides keep, on average: rise over run.
  // Share of its difference from its neighbours that a sample loses in a step: rounds the divides.
  float diffusion = 0.02f;
  uint32_t seed = 0;  // Where rock is hard.
};

// Replaces `height` by land that rose where `height` is high while streams cut it: valleys that
// branch, each sample draining to the border. The relief (5 % to 95 %) and the lowest point stay
// about as they were.
// Source: Braun, Willett, "A very efficient O(n), implicit and parallel method to solve the stream
// power equation", Geomorphology 2013; Cordonnier et al., "Large scale terrain generation from
// tectonic uplift and fluvial erosion", 2016.
void ErodeByStreams(Field& height, const StreamPowerOptions& options);

struct DropletOptions {
  int droplets = 150'000;     // For a field of 1024^2; about 3 us each.
  float inertia = 0.05f;      // How straight a drop runs: 0 follows the slope, 1 never turns.
  float capacity = 6.0f;      // Sediment that a drop carries for each metre of fall.
  float erosion = 0.3f;       // Share of the free capacity that it takes up in a cell.
  float deposition = 0.3f;    // Share of the surplus that it lays down in a cell.
  float evaporation = 0.02f;  // Share of its water that it loses in a cell.
  int lifetime = 48;          // Cells that it crosses at most.
  uint64_t seed = 0;
};

// Lets rain drops run down `height` one after the other: gullies where they cut, fans where they
// lay down. Adds what was laid down, in metres, to `deposit`, a field of the same raster.
void ErodeByDroplets(Field& height, Field& deposit, const DropletOptions& options);

struct ThermalOptions {
  int passes = 20;
  float talus = 0.65f;  // Slope at which loose stone comes to rest; 0.65 = 33 degrees.
  // Rock stands at up to this times the talus slope, by noise: cliffs above their screes.
  float hardness_low = 0.4f, hardness_high = 2.5f;
  float band_m = 40;  // Height of such a band.
  uint32_t seed = 0;
};

// Steep ground crumbles and comes to rest below at the talus slope. Adds what was laid down to
// `deposit`.
void ErodeByGravity(Field& height, Field& deposit, const ThermalOptions& options);

}  // namespace parallax
