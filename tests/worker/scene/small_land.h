// Lands on small rasters, which are made in a moment, and rigs that see them.
#pragma once

#include <numbers>

#include "common/math/stereo.h"
#include "parallax/v1/scene.pb.h"
#include "worker/scene/types/nature/rules/recipe.h"

namespace parallax {

// Hills without any layer. Its only prototype has an index of 0 and three shapes.
inline v1::Terrain SmallLand(const char* asset_class = "Boulder", float amplitude_m = 12) {
  TerrainSpec spec;
  spec.seed = 7;
  spec.terms = {
      {.kind = TermKind::kHills, .wavelength_m = 300, .amplitude_m = amplitude_m, .seed = 3}};
  spec.region_m = 1024;
  spec.region_samples = 65;
  spec.site_m = 256;
  spec.site_samples = 129;
  spec.streams.steps = 4;
  spec.rain.droplets = 500;
  spec.gravity.passes = 1;
  v1::Terrain recipe;
  SetTerrainSpec(spec, recipe);
  recipe.add_ground();
  v1::Prototype& any = *recipe.add_prototypes();
  any.set_asset_class(asset_class);
  any.set_shapes(3);
  return recipe;
}

// Adds a layer of the first prototype.
inline v1::ScatterLayer& AddLayer(v1::Terrain& recipe, const char* name, double per_m2,
                                  double spacing_m = 0) {
  v1::ScatterLayer& layer = *recipe.add_layers();
  layer.set_name(name);
  layer.add_prototypes(0);
  layer.add_weights(1);
  layer.set_per_m2(per_m2);
  layer.set_spacing_m(spacing_m);
  layer.set_reach_m(60);
  layer.set_size_low(0.5);
  layer.set_size_high(1.5);
  layer.set_upright(1);
  layer.set_seed(static_cast<uint64_t>(recipe.layers_size()) * 977);
  return layer;
}

// A narrow view towards the horizon, with a yaw of 90 degrees towards +y: then the right eye stands
// on the side of +x.
inline v1::Rig RigAt(const Vec3d& eye, uint32_t path, double yaw_rad = std::numbers::pi / 2) {
  v1::Rig rig = MakeRig({.position = eye,
                         .axes = CameraAxes(yaw_rad, std::numbers::pi / 2),
                         .baseline_m = 0.1,
                         .k = CentredIntrinsics(0.62, 160, 90),
                         .width_px = 160,
                         .height_px = 90});
  rig.set_path(path);
  return rig;
}

}  // namespace parallax
