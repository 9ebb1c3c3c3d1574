// Helpers with which the biomes' rows write layers, prototypes and ground rules.
#pragma once

#include <string>

#include "worker/scene/types/nature/rules/biomes.h"

namespace parallax {

// Where something is, as a product of soft ranges. A default range is everywhere.
struct MaskSpec {
  // Ranges {low, high, soft}; {0, 0, 0}: everywhere.
  struct Range {
    double low = 0, high = 0, soft = 0;
  };
  Range slope, height_m, above_water_m, wetness, deposit_m, shade, snow_m;
  double patches_m = 0;  // Wavelength of patches; 0: none.
  double cover = 0.5;    // Share of the ground that they cover.
  double soft = 0.08;    // Width of their borders.
};

// One layer: an asset and the rule by which it is scattered.
struct LayerSpec {
  std::string name;
  std::string asset;  // A class; trees with their species: "Conifer/spruce".
  v1::ObjectRole role = v1::OBJECT_ROLE_VEGETATION;
  uint32_t shapes = 4;
  bool each = false;  // Each has its own object index; walks avoid it.
  double per_m2 = 0;
  double spacing_m = 0;
  double reach_m = 40;
  double low = 0.7, high = 1.3;  // Sizes.
  bool broken = false;           // Sizes are those of broken rock: many small, few large.
  double upright = 1;
  double sink_m = 0.02;
  double claim_m = 0;
  double crown_m = 0;
  bool litter = false;  // Litter lies below it.
  double near_parents_m = 0;
  bool floats = false;
  bool hangs = false;  // From the roof of a cave.
  double snow_m = 0;   // Depth of the snow on it.
  MaskSpec mask;       // Beside water, masks without above_water_m mean dry ground.
};

// Writes the layers and rules of one biome into its draft.
class LayerWriter {
 public:
  explicit LayerWriter(BiomeDraft& draft) : draft_(draft) {}

  // Adds a layer with one prototype; equal assets share theirs. The draft's density scales plants,
  // up to the most that a layer may have (kMostPerM2).
  void Add(const LayerSpec& spec);
  // Adds the ground's next rule; the first one covers everything.
  void AddGround(const MaskSpec& mask);
  // Makes walks begin where this mask is strong.
  void SetWalk(const MaskSpec& mask);

  Rng Stream(std::string_view name) const { return draft_.rng.Child(name); }
  const BiomeDraft& draft() const { return draft_; }
  // Whether deciduous plants have no leaves.
  bool bare() const { return draft_.season == "winter"; }

 private:
  uint32_t PrototypeFor(const LayerSpec& spec);
  v1::GroundMask MaskOf(const MaskSpec& spec, const std::string& name) const;

  BiomeDraft& draft_;
};

}  // namespace parallax
