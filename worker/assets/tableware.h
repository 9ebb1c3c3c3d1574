// Things turned, thrown, blown or pressed for the table and the kitchen.
#pragma once

#include "worker/assets/families.h"
#include "worker/assets/parts.h"

namespace parallax {

struct VaseParams {
  float height_m = 0.3f;
  float radius_m = 0.09f;  // The widest.
  int form = 0;            // 0 bottle, 1 amphora, 2 trumpet, 3 gourd, 4 cylinder, 5 ball.
  int flutes = 0;          // Vertical ribs; 0 = smooth.
  float twist_rad = 0;     // Of the ribs over the height.
  bool handles = false;
  uint64_t seed = 0;
};
Asset MakeVase(const VaseParams& params);
Asset SampleVase(Rng& rng);

struct BottleParams {
  float height_m = 0.3f;
  float radius_m = 0.037f;
  int form = 0;  // 0 wine with shoulders, 1 sloping, 2 beer, 3 water with ribs, 4 soap with pump.
  float shoulder = 0;  // The shoulder moves up by this share of the height.
  float neck = 1;      // Factor on the neck's radius.
  float square = 0;    // 0 round, 1 nearly square in plan.
  bool label = true;
  uint64_t seed = 0;
};
Asset MakeBottle(const BottleParams& params);
Asset SampleBottle(Rng& rng);

struct CupParams {
  float height_m = 0.095f;
  float radius_m = 0.042f;
  int form = 0;  // 0 mug, 1 tea cup with saucer, 2 tumbler, 3 tapered.
  bool handle = true;
  uint64_t seed = 0;
};
Asset MakeCup(const CupParams& params);
Asset SampleCup(Rng& rng);

Asset SampleBowl(Rng& rng);
Asset SamplePlate(Rng& rng);
Asset SamplePot(Rng& rng);
Asset SamplePan(Rng& rng);
Asset SampleJar(Rng& rng);
Asset SampleWineglass(Rng& rng);
Asset SampleFork(Rng& rng);
Asset SampleKnife(Rng& rng);
Asset SampleSpoon(Rng& rng);
Asset SampleChopsticks(Rng& rng);
Asset SampleLid(Rng& rng);

}  // namespace parallax
