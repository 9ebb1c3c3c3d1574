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
Asset SampleRockPile(Rng& rng);
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
Asset SampleLeafLitter(Rng& rng);
Asset SampleTwigs(Rng& rng);
Asset SampleCones(Rng& rng);
Asset SampleNeedlePatch(Rng& rng);

// Shores.
Asset SampleIceFloe(Rng& rng);
Asset SampleShells(Rng& rng);
Asset SampleWrack(Rng& rng);

// Grass.
Asset SampleGrassTuft(Rng& rng);
Asset SampleGrassClump(Rng& rng);
Asset SampleTussock(Rng& rng);
Asset SampleReed(Rng& rng);

// Herbs.
Asset SampleFern(Rng& rng);
Asset SampleFlowerPlant(Rng& rng);
Asset SampleMushrooms(Rng& rng);
Asset SampleSucculent(Rng& rng);

// Dry lands.
Asset SampleColumnCactus(Rng& rng);
Asset SampleBarrelCactus(Rng& rng);
Asset SamplePricklyPear(Rng& rng);
Asset SampleAgave(Rng& rng);
Asset SamplePalm(Rng& rng);

// Formations of rock.
Asset SampleRockArch(Rng& rng);
Asset SampleRockPillar(Rng& rng);
Asset SampleStalactites(Rng& rng);
Asset SampleStalagmites(Rng& rng);
Asset SampleDripstoneColumn(Rng& rng);

// Shrubs.
Asset SampleShrub(Rng& rng);
Asset SampleFlowerBush(Rng& rng);
Asset SampleDryBush(Rng& rng);

}  // namespace parallax
