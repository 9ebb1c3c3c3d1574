// Cover of the ground outdoors: stones, litter, grass, herbs, shrubs. The origin is the foot of a
// plant or the middle of a patch.
#pragma once

#include "worker/assets/asset.h"
#include "worker/assets/nature/species.h"

namespace parallax {

// ---- Stones

// The form of one stone, cut from a block by planes and roughened.
struct StoneForm {
  Vec3f size = Vec3f::Constant(0.5f);  // Half of the extent along each axis, about.
  int planes = 20;                     // That cut it from a block; few: angular.
  int cracks = 0;
  float sharpness = 14;  // How sharp the edges are: 5 a pebble, 30 freshly broken.
  float rough = 0.14f;   // Depth of chips and dents, in sizes.
  float bedding = 0;     // Height of the steps between layers, in sizes.
  int cells = 30;        // A side of the sphere it is made from; 12 n^2 triangles.
};

// A single boulder.
struct BoulderParams {
  StoneForm form;
  uint64_t seed = 0;
};
Asset MakeBoulder(const BoulderParams& params);
Asset SampleBoulder(Rng& rng);
Asset SampleSlab(Rng& rng);

// A heap of broken stones.
struct RockPileParams {
  float size_m = 0.9f;  // Half of its width.
  int stones = 12;
  uint64_t seed = 0;
};
Asset MakeRockPile(const RockPileParams& params);
Asset SampleRockPile(Rng& rng);

// A patch of pebbles.
struct PebblesParams {
  float radius_m = 0.2f;  // Size of the patch.
  float coarse = 1;
  int stones = 36;
  uint64_t seed = 0;
};
Asset MakePebbles(const PebblesParams& params);
Asset SamplePebbles(Rng& rng);

// A pillar or a block of bedded rock that stands in the surf.
Asset SampleSeaStack(Rng& rng);
// A block of ice that pressure heaved up or that broke off a glacier.
Asset SampleIceBlock(Rng& rng);

// ---- Litter

// A patch of litter: its radius and the number of pieces.
struct LitterParams {
  float radius_m = 0.4f;
  int count = 120;
  uint64_t seed = 0;
};
// Fallen leaves that lie over each other, some curled.
Asset MakeLeafLitter(const LitterParams& params);
Asset SampleLeafLitter(Rng& rng);
// Broken twigs.
Asset MakeTwigs(const LitterParams& params);
Asset SampleTwigs(Rng& rng);
// Cones of pine or spruce.
Asset MakeCones(const LitterParams& params);
Asset SampleCones(Rng& rng);
// Dry needles in pairs.
Asset MakeNeedlePatch(const LitterParams& params);
Asset SampleNeedlePatch(Rng& rng);

// ---- Shores

// A flat piece of floating ice.
struct IceFloeParams {
  float radius_m = 1;
  float thick_m = 0.28f;
  int sides = 7;  // Sides of the polygon that broke off.
  uint64_t seed = 0;
};
// The origin is in the middle of its lower side.
Asset MakeIceFloe(const IceFloeParams& params);
Asset SampleIceFloe(Rng& rng);
Asset MakeShells(const LitterParams& params);
Asset SampleShells(Rng& rng);
// Seaweed at the tide's line.
Asset MakeWrack(const LitterParams& params);
Asset SampleWrack(Rng& rng);

// ---- Grass

// A tuft of grass.
struct GrassParams {
  int blades = 45;
  float height_m = 0.25f;
  float radius_m = 0.05f;  // Size of the patch that blades rise from.
  float width_m = 0.005f;
  float droop = 0.8f;  // Radians that blades bend by, on average.
  float lean = 0.15f;  // To one side, as wind combs.
  float dry = 0.2f;    // Share of dry blades.
  int seed_heads = 0;
  bool short_outside = false;  // A mound: blades at the rim are shorter.
  uint64_t seed = 0;
};
Asset MakeGrass(const GrassParams& params);
Asset SampleGrassTuft(Rng& rng);
Asset SampleGrassClump(Rng& rng);
Asset SampleTussock(Rng& rng);

// Reeds at the edge of water; with `cattail`, flower spikes.
struct ReedParams {
  int stems = 14;
  float height_m = 1.7f;
  bool cattail = false;
  uint64_t seed = 0;
};
Asset MakeReed(const ReedParams& params);
Asset SampleReed(Rng& rng);

// ---- Herbs

// A fern: fronds that arch out of one root.
struct FernParams {
  int fronds = 10;
  float length_m = 0.6f;
  uint64_t seed = 0;
};
Asset MakeFern(const FernParams& params);
Asset SampleFern(Rng& rng);

// Forms of flower heads.
enum class FlowerKind { kDaisy, kPoppy, kBell, kDandelion, kCount };
struct FlowerParams {
  FlowerKind kind = FlowerKind::kDaisy;
  int stems = 6;
  float height_m = 0.3f;
  uint64_t seed = 0;
};
Asset MakeFlowerPlant(const FlowerParams& params);
Asset SampleFlowerPlant(Rng& rng);

// A group of mushrooms.
struct MushroomParams {
  int count = 5;
  float height_m = 0.07f;
  float cap_width = 1.1f;  // In heights.
  float cap_dome = 0.5f;   // 0 flat, 1 a ball.
  uint64_t seed = 0;
};
Asset MakeMushrooms(const MushroomParams& params);
Asset SampleMushrooms(Rng& rng);

// Rosettes of fleshy leaves.
struct SucculentParams {
  int rosettes = 3;
  float size_m = 0.25f;
  uint64_t seed = 0;
};
Asset MakeSucculent(const SucculentParams& params);
Asset SampleSucculent(Rng& rng);

// ---- Dry lands

// A tall ribbed cactus with arms (saguaro).
struct ColumnCactusParams {
  float height_m = 3, radius_m = 0.16f;
  int ribs = 14;
  int arms = 2;
  uint64_t seed = 0;
};
Asset MakeColumnCactus(const ColumnCactusParams& params);
Asset SampleColumnCactus(Rng& rng);

// Round ribbed cacti.
struct BarrelCactusParams {
  float radius_m = 0.22f;
  float tall = 1;  // Height over width.
  int ribs = 18;
  int heads = 1;
  uint64_t seed = 0;
};
Asset MakeBarrelCactus(const BarrelCactusParams& params);
Asset SampleBarrelCactus(Rng& rng);

// A cactus of flat pads (opuntia).
struct PricklyPearParams {
  float pad_m = 0.24f;
  int stems = 4;
  int levels = 3;  // Levels of pads, each on the last.
  uint64_t seed = 0;
};
Asset MakePricklyPear(const PricklyPearParams& params);
Asset SamplePricklyPear(Rng& rng);

// A rosette of stiff, pointed leaves, some with a flower stalk.
struct AgaveParams {
  float size_m = 0.6f;  // Length of its leaves.
  float width = 0.2f;   // Width of a leaf, in lengths.
  int leaves = 34;
  float mast_m = 0;  // Height of the dry flower stalk; 0: none.
  uint64_t seed = 0;
};
Asset MakeAgave(const AgaveParams& params);
Asset SampleAgave(Rng& rng);

// A palm tree.
struct PalmParams {
  float height_m = 6;
  float lean = 0.1f;
  float frond_m = 2.2f;
  int fronds = 26;
  int dead = 4;  // Dry fronds that hang below the crown.
  uint64_t seed = 0;
};
Asset MakePalm(const PalmParams& params);
Asset SamplePalm(Rng& rng);

// ---- Formations of rock

// A natural arch of bedded rock.
struct RockArchParams {
  float span_m = 9, rise_m = 6;
  float thick_m = 1.6f;  // Radius of its rock.
  float bed_m = 0.9f;    // Thickness of its beds.
  uint64_t seed = 0;
};
// An arch along x whose feet reach into the ground.
Asset MakeRockArch(const RockArchParams& params);
Asset SampleRockArch(Rng& rng);

// A free-standing pillar of bedded rock.
struct RockPillarParams {
  float height_m = 10, radius_m = 2;
  float cap = 0;  // How far a hard bed on top stands out, in radii.
  float bed_m = 0.9f;
  uint64_t seed = 0;
};
// A stack that the sea or rain left standing.
Asset MakeRockPillar(const RockPillarParams& params);
Asset SampleRockPillar(Rng& rng);

// Stalactites, stalagmites or columns in a cave.
struct DripstoneParams {
  float length_m = 0.8f, radius_m = 0.09f;
  int count = 5;
  float spread_m = 0.5f;
  bool hangs = true;    // From a roof, else it stands on the floor.
  bool column = false;  // Both grown together.
  uint64_t seed = 0;
};
Asset MakeDripstone(const DripstoneParams& params);
Asset SampleStalactites(Rng& rng);
Asset SampleStalagmites(Rng& rng);
Asset SampleDripstoneColumn(Rng& rng);

// ---- Shrubs

// A bush of forked stems with leaves.
struct ShrubParams {
  float height_m = 1.2f;
  float width = 1.1f;  // In heights.
  LeafForm leaf;
  float leaf_m = 0.045f;
  int leaves = 2200;
  float blossoms = 0;  // Share of twigs that end in flowers.
  bool bare = false;   // Dry: no leaves.
  Season season = Season::kSummer;
  uint64_t seed = 0;
};
Asset MakeShrub(const ShrubParams& params);
Asset SampleShrub(Rng& rng);
Asset SampleFlowerBush(Rng& rng);
Asset SampleDryBush(Rng& rng);

}  // namespace parallax
