#include "worker/scene/types/nature/scatter.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "worker/scene/types/nature/recipe.h"

namespace parallax {
namespace {

// Hills on small rasters.
v1::Terrain SmallLand() {
  TerrainSpec spec;
  spec.seed = 7;
  spec.terms = {{.kind = TermKind::kHills, .wavelength_m = 300, .amplitude_m = 12, .seed = 3}};
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
  any.set_asset_class("Boulder");
  any.set_shapes(3);
  return recipe;
}

v1::ScatterLayer& AddLayer(v1::Terrain& recipe, const char* name, double per_m2,
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

// Trees that claim ground and cast shade, stones between them, grass and litter.
v1::Terrain WoodedLand() {
  v1::Terrain recipe = SmallLand();
  v1::ScatterLayer& trees = AddLayer(recipe, "trees", 0.03, 2.5);
  trees.set_claim_m(0.8);
  trees.set_crown_m(3);
  trees.set_casts_litter(true);
  trees.mutable_mask()->set_noise_m(40);
  trees.mutable_mask()->set_noise_cover(0.6);
  trees.mutable_mask()->set_noise_soft(0.1);
  AddLayer(recipe, "stones", 0.05, 1).set_claim_m(0.5);
  AddLayer(recipe, "grass", 2).mutable_mask()->mutable_shade()->set_high(0.5);
  AddLayer(recipe, "litter", 1).set_near_parents_m(4);
  return recipe;
}

TileSet Square(int first, int last) {
  TileSet tiles;
  for (int y = first; y <= last; ++y) {
    for (int x = first; x <= last; ++x) tiles.insert({y, x});
  }
  return tiles;
}

std::vector<std::vector<Standing>> PlaceOn(const v1::Terrain& recipe, const TileSet& tiles) {
  const auto terrain = TerrainOf(recipe).value();
  return Scatter(recipe, *terrain)
      .Place(std::vector<TileSet>(static_cast<size_t>(recipe.layers_size()), tiles));
}

float Nearest(const Standing& thing, const std::vector<Standing>& others) {
  float least = std::numeric_limits<float>::infinity();
  for (const Standing& other : others) {
    if (other == thing) continue;
    least = std::min(least, (other.position() - thing.position()).norm());
  }
  return least;
}

TEST(Scatter, IsTheSameOnAnyNumberOfThreads) {
  const v1::Terrain recipe = WoodedLand();
  std::vector<std::vector<std::vector<Standing>>> results;
  for (const int threads : {1, 2, 16}) {
    tbb::global_control most(tbb::global_control::max_allowed_parallelism,
                             static_cast<size_t>(threads));
    tbb::task_arena(threads).execute([&] { results.push_back(PlaceOn(recipe, Square(-4, 4))); });
  }
  EXPECT_GT(results[0][0].size(), 100u);
  EXPECT_EQ(results[0], results[1]);
  EXPECT_EQ(results[0], results[2]);
}

TEST(Scatter, DoesNotDependOnWhichPartIsAskedFor) {
  const v1::Terrain recipe = WoodedLand();
  const auto all = PlaceOn(recipe, Square(-5, 5));
  const TileSet part = {{0, 0}, {0, 1}, {2, -3}};
  const auto some = PlaceOn(recipe, part);
  for (size_t layer = 0; layer < all.size(); ++layer) {
    std::vector<Standing> expected;
    for (const Standing& thing : all[layer]) {
      if (part.contains(TileAt(thing.position()))) expected.push_back(thing);
    }
    EXPECT_EQ(some[layer], expected) << recipe.layers(static_cast<int>(layer)).name();
  }
}

TEST(Scatter, NoTwoOfALayerAreNearerThanTheLargerOnesSpacing) {
  const v1::Terrain recipe = WoodedLand();
  const auto things = PlaceOn(recipe, Square(-5, 5));
  for (const size_t layer : {0u, 1u}) {
    const auto spacing = static_cast<float>(recipe.layers(static_cast<int>(layer)).spacing_m());
    for (const Standing& a : things[layer]) {
      for (const Standing& b : things[layer]) {
        if (a == b) continue;
        EXPECT_GE((a.position() - b.position()).norm(), spacing * std::max(a.scale(), b.scale()));
      }
    }
  }
}

TEST(Scatter, LaterLayersKeepOffClaimsAndLitterLiesByItsParents) {
  const v1::Terrain recipe = WoodedLand();
  const auto things = PlaceOn(recipe, Square(-5, 5));
  ASSERT_GT(things[3].size(), 200u);
  for (const size_t layer : {1u, 2u, 3u}) {
    for (const Standing& thing : things[layer]) {
      for (const Standing& tree : things[0]) {
        EXPECT_GE((thing.position() - tree.position()).norm(), 0.8f * tree.scale());
      }
    }
  }
  // Parents beyond the asked tiles count, too: only litter well inside is held against them.
  for (const Standing& thing : things[3]) {
    if (thing.position().cwiseAbs().maxCoeff() > 70) continue;
    EXPECT_LT(Nearest(thing, things[0]), 4);
  }
}

TEST(Scatter, GrassThinsOutInTheShade) {
  v1::Terrain recipe = SmallLand();
  v1::ScatterLayer& trees = AddLayer(recipe, "trees", 0.02, 3);
  trees.set_crown_m(4);
  AddLayer(recipe, "grass", 3).mutable_mask()->mutable_shade()->set_high(0.3);
  const auto things = PlaceOn(recipe, Square(-5, 4));
  const auto share_within = [&](float from, float to) {
    int count = 0;
    for (const Standing& grass : things[1]) {
      const float d = Nearest(grass, things[0]);
      count += d >= from && d < to;
    }
    return count / (to * to - from * from);
  };
  EXPECT_LT(share_within(0, 1.2f), 0.2f * share_within(5, 7));
}

TEST(Scatter, DensityIsWhatTheLayerSaysWithAndWithoutSpacing) {
  v1::Terrain recipe = SmallLand();
  AddLayer(recipe, "free", 0.5);
  AddLayer(recipe, "spaced", 0.03, 2.5).set_size_low(1);
  recipe.mutable_layers(1)->set_size_high(1);
  const auto things = PlaceOn(recipe, Square(-6, 5));
  const double area = 144 * 256;
  EXPECT_NEAR(static_cast<double>(things[0].size()) / area, 0.5, 0.02);
  EXPECT_NEAR(static_cast<double>(things[1].size()) / area, 0.03, 0.005);
}

TEST(Rules, WhatBreaksTheirBoundsIsRefused) {
  const v1::Terrain good = WoodedLand();
  EXPECT_TRUE(CheckRules(good).ok()) << CheckRules(good);
  const auto refused = [&](auto change) {
    v1::Terrain bad = good;
    change(bad);
    return CheckRules(bad).code() == absl::StatusCode::kInvalidArgument;
  };
  EXPECT_TRUE(refused([](v1::Terrain& t) { t.mutable_layers(0)->set_prototypes(0, 5); }));
  EXPECT_TRUE(refused([](v1::Terrain& t) { t.mutable_layers(0)->set_per_m2(1e6); }));
  EXPECT_TRUE(refused([](v1::Terrain& t) { t.mutable_layers(1)->set_size_high(NAN); }));
  EXPECT_TRUE(refused([](v1::Terrain& t) { t.mutable_layers(2)->clear_weights(); }));
  EXPECT_TRUE(refused([](v1::Terrain& t) { t.clear_ground(); }));
  v1::Terrain bad = good;
  bad.set_site_samples(100'000);
  EXPECT_EQ(TerrainSpecOf(bad).status().code(), absl::StatusCode::kInvalidArgument);
}

TEST(Recipe, TheGroundsSpecSurvivesTheRecipe) {
  const v1::Terrain recipe = SmallLand();
  v1::Terrain again;
  SetTerrainSpec(TerrainSpecOf(recipe).value(), again);
  v1::Terrain spec_only = recipe;
  spec_only.clear_ground();
  spec_only.clear_prototypes();
  EXPECT_EQ(again.SerializeAsString(), spec_only.SerializeAsString());
}

}  // namespace
}  // namespace parallax
