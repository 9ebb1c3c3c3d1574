#include "worker/scene/types/nature/rules/layer_writer.h"

#include <fmt/core.h>

#include <algorithm>

#include "worker/scene/types/nature/rules/recipe.h"

namespace parallax {
namespace {

// Higher than waves run up a beach and than a bank's edge.
constexpr MaskSpec::Range kDry = {0.4, 1e4, 0.15};

void Set(const MaskSpec::Range& range, v1::SoftRange* (v1::GroundMask::*field)(),
         v1::GroundMask& mask) {
  if (range.low == 0 && range.high == 0) return;
  v1::SoftRange& made = *(mask.*field)();
  made.set_low(range.low);
  made.set_high(range.high);
  made.set_soft(range.soft);
}

}  // namespace

v1::GroundMask LayerWriter::MaskOf(const MaskSpec& spec, const std::string& name) const {
  v1::GroundMask mask;
  Set(spec.slope, &v1::GroundMask::mutable_slope, mask);
  Set(spec.height_m, &v1::GroundMask::mutable_height_m, mask);
  Set(spec.above_water_m, &v1::GroundMask::mutable_above_water_m, mask);
  Set(spec.wetness, &v1::GroundMask::mutable_wetness, mask);
  Set(spec.deposit_m, &v1::GroundMask::mutable_deposit_m, mask);
  Set(spec.shade, &v1::GroundMask::mutable_shade, mask);
  Set(spec.snow_m, &v1::GroundMask::mutable_snow_m, mask);
  if (spec.patches_m <= 0) return mask;
  mask.set_noise_m(spec.patches_m);
  mask.set_noise_cover(spec.cover);
  mask.set_noise_soft(spec.soft);
  mask.set_noise_seed(draft_.rng.Child("patches").Child(name).Bits32());
  return mask;
}

uint32_t LayerWriter::PrototypeFor(const LayerSpec& spec) {
  auto& prototypes = *draft_.recipe.mutable_prototypes();
  for (int i = 0; i < prototypes.size(); ++i) {
    if (prototypes[i].asset_class() == spec.asset && prototypes[i].snow_m() == spec.snow_m) {
      return static_cast<uint32_t>(i);
    }
  }
  v1::Prototype& made = *prototypes.Add();
  made.set_asset_class(spec.asset);
  made.set_seed(draft_.rng.Child("prototype").Child(spec.asset).Seed());
  made.set_shapes(spec.shapes);
  if (spec.asset.find('/') != std::string::npos) made.set_season(draft_.season);
  made.set_role(spec.role);
  if (spec.snow_m > 0) made.set_snow_m(spec.snow_m);
  return static_cast<uint32_t>(prototypes.size() - 1);
}

void LayerWriter::Add(const LayerSpec& spec) {
  v1::ScatterLayer& layer = *draft_.recipe.add_layers();
  layer.set_name(spec.name);
  layer.set_index_each(spec.each);
  layer.add_prototypes(PrototypeFor(spec));
  layer.add_weights(1);
  const double scale = spec.role == v1::OBJECT_ROLE_VEGETATION ? draft_.density : 1;
  layer.set_per_m2(std::min(spec.per_m2 * scale, kMostPerM2));
  layer.set_spacing_m(spec.spacing_m);
  layer.set_reach_m(spec.reach_m);
  layer.set_size_low(spec.low);
  layer.set_size_high(spec.high);
  layer.set_broken(spec.broken);
  layer.set_upright(spec.upright);
  layer.set_sink_m(spec.sink_m);
  layer.set_claim_m(spec.claim_m);
  layer.set_crown_m(spec.crown_m);
  layer.set_casts_litter(spec.litter);
  layer.set_near_parents_m(spec.near_parents_m);
  if (spec.hangs) layer.set_hangs(true);
  layer.set_seed(draft_.rng.Child("layer").Child(spec.name).Seed());
  layer.set_floats(spec.floats);
  MaskSpec mask = spec.mask;
  if (draft_.recipe.has_water() && mask.above_water_m.low == 0 && mask.above_water_m.high == 0) {
    mask.above_water_m = kDry;
  }
  *layer.mutable_mask() = MaskOf(mask, spec.name);
}

void LayerWriter::SetWalk(const MaskSpec& mask) {
  *draft_.recipe.mutable_walk() = MaskOf(mask, "walk");
}

void LayerWriter::AddGround(const MaskSpec& mask) {
  v1::GroundRule& rule = *draft_.recipe.add_ground();
  const int index = draft_.recipe.ground_size();
  rule.set_material_index(static_cast<uint32_t>(index));
  *rule.mutable_mask() = MaskOf(mask, fmt::format("ground {}", index));
}

}  // namespace parallax
