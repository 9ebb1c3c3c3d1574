// Vessels and tools for the table and the kitchen.
#pragma once

#include "worker/assets/asset_families.h"
#include "worker/assets/parts.h"

namespace parallax {

// A vase, turned about z.
struct VaseParams {
  float height_m = 0.3f;
  float radius_m = 0.09f;  // The widest.
  int form = 0;            // 0 bottle, 1 amphora, 2 trumpet, 3 gourd, 4 cylinder, 5 ball.
  int flutes = 0;          // Vertical ribs; 0 = smooth.
  float twist_rad = 0;     // Twist of the ribs over the height.
  bool handles = false;
  uint64_t seed = 0;
};
Asset MakeVase(const VaseParams& params);
Asset SampleVase(Rng& rng);

// A bottle with cap and label.
struct BottleParams {
  float height_m = 0.3f;
  float radius_m = 0.037f;
  // 0 wine with shoulders, 1 sloping, 2 beer, 3 water with ribs, 4 soap with pump, 5 oval flask of
  // washing-up liquid or shampoo.
  int form = 0;
  float shoulder = 0;  // The shoulder moves up by this share of the height.
  float neck = 1;      // Factor on the neck's radius.
  float square = 0;    // 0 round, 1 nearly square in plan; of a flask: how flat it is.
  bool label = true;
  uint64_t seed = 0;
};
Asset MakeBottle(const BottleParams& params);
Asset SampleBottle(Rng& rng);

// A drinking vessel.
struct CupParams {
  float height_m = 0.095f;
  float radius_m = 0.042f;
  int form = 0;  // 0 mug, 1 tea cup with saucer, 2 tumbler, 3 tapered.
  bool handle = true;
  uint64_t seed = 0;
};
Asset MakeCup(const CupParams& params);
Asset SampleCup(Rng& rng);

// An open bowl.
struct BowlParams {
  float radius_m = 0.1f, height_m = 0.07f;
  int form = 0;      // 0 flaring, 1 straight-sided, 2 on a foot.
  int scallops = 0;  // Waves of the rim; 0 = round.
  uint64_t seed = 0;
};
Asset MakeBowl(const BowlParams& params);
Asset SampleBowl(Rng& rng);

// A plate.
struct PlateParams {
  float radius_m = 0.13f, height_m = 0.022f;
  bool coupe = false;   // Without a rim.
  bool square = false;  // In plan, with round corners.
  uint64_t seed = 0;
};
Asset MakePlate(const PlateParams& params);
Asset SamplePlate(Rng& rng);

// A cooking pot or pan.
struct PotParams {
  float radius_m = 0.12f, height_m = 0.13f;
  bool pan = false;  // One long handle instead of two loops.
  bool lid = false;
  uint64_t seed = 0;
};
Asset MakePot(const PotParams& params);
Asset SamplePot(Rng& rng);
Asset SamplePan(Rng& rng);

// Closures of jars.
enum class JarClosure { kScrewCap, kCork, kGlassStopper, kCount };

// A storage jar with its contents.
struct JarParams {
  float radius_m = 0.045f, height_m = 0.12f;
  bool square = false;  // In plan, up to the shoulder.
  JarClosure closure = JarClosure::kScrewCap;
  float filled = 0.5f;  // Share of the height.
  uint64_t seed = 0;
};
Asset MakeJar(const JarParams& params);
Asset SampleJar(Rng& rng);

// A glass with a stem.
struct WineglassParams {
  float height_m = 0.19f, radius_m = 0.038f;
  int form = 0;  // 0 tulip, 1 flute, 2 coupe.
  uint64_t seed = 0;
};
Asset MakeWineglass(const WineglassParams& params);
Asset SampleWineglass(Rng& rng);

// A pot's lid by itself.
struct LidParams {
  float radius_m = 0.11f;
  float dome = 0.2f;  // Height in radii.
  bool knob = true;   // Else a bow handle.
  uint64_t seed = 0;
};
Asset MakeLid(const LidParams& params);
Asset SampleLid(Rng& rng);

// A fork or spoon.
struct CutleryParams {
  float length_m = 0.18f;
  int handle = 0;  // 0 pointed spatula, 1 straight, 2 waisted.
  int tines = 4;   // Tines of a fork.
  uint64_t seed = 0;
};
Asset MakeFork(const CutleryParams& params);
Asset MakeSpoon(const CutleryParams& params);
Asset SampleFork(Rng& rng);
Asset SampleSpoon(Rng& rng);

// A knife.
struct KnifeParams {
  float length_m = 0.24f, grip_m = 0.1f;
  float blade_m = 0.02f;  // Its width.
  float belly = 0.8f;     // How much the edge curves to the tip.
  bool kitchen = false;   // Riveted scales instead of a moulded handle.
  uint64_t seed = 0;
};
Asset MakeKnife(const KnifeParams& params);
Asset SampleKnife(Rng& rng);

// A pair of chopsticks.
struct ChopsticksParams {
  float length_m = 0.23f;
  uint64_t seed = 0;  // How the two lie.
};
Asset MakeChopsticks(const ChopsticksParams& params);
Asset SampleChopsticks(Rng& rng);

}  // namespace parallax
