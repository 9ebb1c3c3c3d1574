#include "worker/scene/types/nature/ground/scatter.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "tests/worker/scene/small_land.h"
#include "worker/scene/types/nature/rules/recipe.h"

namespace parallax {
namespace {

// Adds full rows, 2.5 m from each other, with a plant every 1.2 m.
void AddVines(v1::Terrain& recipe) {
  v1::ScatterLayer& vines = AddLayer(recipe, "vines", 40, 1.2);
  vines.mutable_mask()->set_rows_m(2.5);
  vines.mutable_mask()->set_row_width_m(0.2);
  vines.mutable_mask()->set_row_direction_rad(0.6);
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

absl::StatusOr<std::vector<std::vector<Standing>>> TryToPlaceOn(const v1::Terrain& recipe,
                                                                const TileSet& tiles) {
  const auto terrain = TerrainOf(recipe).value();
  return Scatter(recipe, *terrain)
      .Place(std::vector<TileSet>(static_cast<size_t>(recipe.layers_size()), tiles));
}

std::vector<std::vector<Standing>> PlaceOn(const v1::Terrain& recipe, const TileSet& tiles) {
  return TryToPlaceOn(recipe, tiles).value();
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
  v1::Terrain recipe = WoodedLand();
  AddVines(recipe);
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

// N(> s) falls as s^-2 between the ends, where other things are mostly of middling size.
TEST(Scatter, SizesOfBrokenRockFollowAPowerLaw) {
  v1::Terrain recipe = SmallLand();
  v1::ScatterLayer& layer = AddLayer(recipe, "stones", 2);
  layer.set_size_low(0.1);
  layer.set_size_high(1);
  layer.set_broken(true);
  const std::vector<Standing> stones = PlaceOn(recipe, Square(-5, 5))[0];
  const auto count = static_cast<double>(stones.size());
  ASSERT_GT(count, 50'000);
  for (const double size : {0.1, 0.15, 0.2, 0.4, 0.8}) {
    const auto larger = std::count_if(stones.begin(), stones.end(), [&](const Standing& stone) {
      return static_cast<double>(stone.scale()) > size;
    });
    const double expected = (1 / (size * size) - 1) / (1 / (0.1 * 0.1) - 1);
    const double deviation = std::sqrt(expected * (1 - expected) / count);
    EXPECT_NEAR(static_cast<double>(larger) / count, expected, 4 * deviation + 0.004) << size;
  }
}

// 100 million blades would take gigabytes before anyone counts them.
TEST(Scatter, TooManyCandidatesAreRefusedBeforeAnythingIsPlaced) {
  v1::Terrain recipe = SmallLand();
  AddLayer(recipe, "stones", 0.05, 1);
  AddLayer(recipe, "grass", 60);
  const absl::Status status = TryToPlaceOn(recipe, Square(-40, 40)).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kOutOfRange);
  EXPECT_THAT(std::string(ToStd(status.message())), testing::HasSubstr("layer \"grass\""));
  EXPECT_TRUE(TryToPlaceOn(recipe, Square(-4, 4)).ok());
  // Spacing asks for candidates around each tile, too.
  v1::Terrain wide = SmallLand();
  AddLayer(wide, "trees", 0.002, 12).set_size_high(15);
  EXPECT_EQ(TryToPlaceOn(wide, Square(-80, 80)).status().code(), absl::StatusCode::kOutOfRange);
}

TEST(Scatter, LayersThatMatterToEachOtherFromAfarAreRefused) {
  v1::Terrain recipe = SmallLand();
  for (const char* name : {"a", "b", "c", "d", "e", "f"}) {
    v1::ScatterLayer& layer = AddLayer(recipe, name, 1e-7, 12);
    layer.set_size_high(15);
    layer.set_crown_m(12);
  }
  const absl::Status status = TryToPlaceOn(recipe, Square(-9, 9)).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kOutOfRange);
  EXPECT_THAT(std::string(ToStd(status.message())), testing::HasSubstr("tiles"));
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
  EXPECT_TRUE(refused([](v1::Terrain& t) { t.set_clearance_m(1e3); }));
  EXPECT_TRUE(refused([](v1::Terrain& t) { t.set_clearance_baseline_m(NAN); }));
  v1::Terrain bad = good;
  bad.set_site_samples(100'000);
  EXPECT_EQ(TerrainSpecOf(bad).status().code(), absl::StatusCode::kInvalidArgument);
}

TEST(Scatter, RowsAreStraightAndRunWhereTheyAreAskedTo) {
  v1::Terrain recipe = SmallLand();
  v1::GroundMask& mask = *AddLayer(recipe, "vines", 3, 0.5).mutable_mask();
  mask.set_rows_m(2.5);
  mask.set_row_width_m(0.3);
  mask.set_row_direction_rad(0.6);
  const auto standing = PlaceOn(recipe, Square(-1, 1)).at(0);
  ASSERT_GT(standing.size(), 50u);
  std::set<int> rows;
  for (const Standing& vine : standing) {
    const Vec2f& p = vine.position();
    const float across = (-std::sin(0.6f) * p.x() + std::cos(0.6f) * p.y()) / 2.5f;
    EXPECT_LE(std::abs(across - std::round(across)) * 2.5f, 0.15f + 1e-4f);
    rows.insert(static_cast<int>(std::round(across)));
  }
  EXPECT_GT(rows.size(), 3u);
}

TEST(Scatter, RowsWithASpacingHaveAPlantAtEachStep) {
  v1::Terrain recipe = SmallLand();
  AddVines(recipe);
  const auto standing = PlaceOn(recipe, Square(-1, 1)).at(0);
  const float area_m2 = std::pow(3 * kTile_m, 2.0f);
  EXPECT_NEAR(static_cast<float>(standing.size()) / area_m2, 1 / (2.5f * 1.2f), 0.02f);
  for (const Standing& vine : standing) {
    if (TileAt(vine.position()) != Tile(0, 0)) continue;  // Others' neighbours may lie outside.
    const float nearest_m = Nearest(vine, standing);
    EXPECT_GT(nearest_m, 0.8f * 1.2f * 0.85f);
    EXPECT_LT(nearest_m, 1.2f * 1.31f);
  }
}

// Ten thousand places a square metre, four of which have a candidate.
TEST(Scatter, TooManyPlacesInRowsAreRefusedBeforeAnyIsLookedAt) {
  v1::Terrain recipe = SmallLand();
  AddVines(recipe);
  v1::ScatterLayer& vines = *recipe.mutable_layers(0);
  vines.set_spacing_m(0.001);
  vines.mutable_mask()->set_rows_m(0.1);
  vines.mutable_mask()->set_row_width_m(0.01);
  EXPECT_TRUE(CheckRules(recipe).ok()) << CheckRules(recipe);
  const absl::Status status = TryToPlaceOn(recipe, Square(-20, 20)).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kOutOfRange);
  EXPECT_THAT(std::string(ToStd(status.message())), testing::HasSubstr("layer \"vines\": a place"));
  vines.set_spacing_m(1e-6);
  EXPECT_EQ(CheckRules(recipe).code(), absl::StatusCode::kInvalidArgument);
}

TEST(Rules, MasksAreCheckedWhereverTheyStand) {
  const v1::Terrain good = WoodedLand();
  const auto refused = [&](auto mask_of, auto change) {
    v1::Terrain bad = good;
    change(*mask_of(bad));
    return CheckRules(bad).code() == absl::StatusCode::kInvalidArgument;
  };
  const auto of_layer = [](v1::Terrain& t) { return t.mutable_layers(2)->mutable_mask(); };
  const auto of_ground = [](v1::Terrain& t) { return t.mutable_ground(0)->mutable_mask(); };
  const auto of_walk = [](v1::Terrain& t) { return t.mutable_walk(); };
  const auto fine = [](v1::GroundMask& mask) { mask.set_noise_m(1e-20); };
  EXPECT_TRUE(refused(of_layer, fine) && refused(of_ground, fine) && refused(of_walk, fine));
  EXPECT_TRUE(refused(of_layer, [](v1::GroundMask& mask) { mask.set_noise_m(-1); }));
  EXPECT_TRUE(refused(of_layer, [](v1::GroundMask& mask) { mask.set_noise_cover(NAN); }));
  EXPECT_TRUE(refused(of_ground, [](v1::GroundMask& mask) { mask.set_noise_soft(-1); }));
  EXPECT_TRUE(refused(of_walk, [](v1::GroundMask& mask) { mask.mutable_slope()->set_low(NAN); }));
  EXPECT_TRUE(refused(of_layer, [](v1::GroundMask& mask) { mask.mutable_snow_m()->set_soft(-1); }));
  EXPECT_TRUE(refused(of_layer, [](v1::GroundMask& mask) { mask.set_rows_m(-1); }));
  EXPECT_TRUE(refused(of_ground, [](v1::GroundMask& mask) { mask.set_rows_m(2); })) << "no width";
  EXPECT_FALSE(refused(of_layer, [](v1::GroundMask& mask) { mask.set_noise_m(2); }));
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
