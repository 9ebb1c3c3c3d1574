// Erosion of height fields by water and gravity: valleys that branch, gullies, alluvial fans and
// screes. Each is a pure function of its input and seed, the same on any number of threads.
#pragma once

#include <cstdint>

#include "worker/terrain/field.h"

namespace parallax {

// Options of stream erosion.
struct StreamPowerOptions {
  int steps = 50;  // A larger number makes an older landscape. About 20 ms each at 512^2.
  // Distance, in kilometres, that the cut of a stream which drains one square kilometre moves
  // upstream in a step. At larger values valleys reach the divides sooner, and are wider.
  float erodibility = 0.4f;
  float area_exponent = 0.45f;  // m of the stream power law; slope's exponent is 1.
  float talus = 0.9f;           // Mean slope of hillsides: rise over run.
  // Share of its difference from its neighbours that a sample loses in a step: rounds the divides.
  float diffusion = 0.02f;
  uint32_t seed = 0;  // Seeds the hardness of rock.
};

// Replaces `height` by land that was uplifted where `height` is high while streams cut it. Valleys
// branch, and each sample drains to the border. The relief (5 % to 95 %) and the lowest point stay
// about as they were.
// Source: Braun, Willett, "A very efficient O(n), implicit and parallel method to solve the stream
// power equation", Geomorphology 2013; Cordonnier et al., "Large scale terrain generation from
// tectonic uplift and fluvial erosion", 2016.
void ErodeByStreams(Field& height, const StreamPowerOptions& options);

// Options of droplet erosion.
struct DropletOptions {
  int droplets = 150'000;     // For a field of 1024^2; about 3 us each.
  float inertia = 0.05f;      // Straightness of a drop's path: 0 follows the slope, 1 never turns.
  float capacity = 6.0f;      // Sediment that a drop carries for each metre of fall.
  float erosion = 0.3f;       // Share of the free capacity that it takes up in a cell.
  float deposition = 0.3f;    // Share of the surplus that it lays down in a cell.
  float evaporation = 0.02f;  // Share of its water that it loses in a cell.
  int lifetime = 48;          // Limit of the cells that it crosses.
  uint64_t seed = 0;
};

// Lets rain drops run down `height` one after the other. They cut gullies and deposit fans. Adds
// the deposited height, in metres, to `deposit`, a field of the same raster.
void ErodeByDroplets(Field& height, Field& deposit, const DropletOptions& options);

// Options of thermal erosion.
struct ThermalOptions {
  int passes = 20;
  float talus = 0.65f;  // Slope at which loose stone comes to rest; 0.65 = 33 degrees.
  // Rock holds up to this factor times the talus slope, by noise: cliffs above their screes.
  float hardness_low = 0.4f, hardness_high = 2.5f;
  float band_m = 40;  // Height of such a band.
  uint32_t seed = 0;
};

// Moves material from ground steeper than the talus slope downhill until it rests. Adds the
// deposited height to `deposit`.
void ErodeByGravity(Field& height, Field& deposit, const ThermalOptions& options);

}  // namespace parallax
