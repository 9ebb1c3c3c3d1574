#include "worker/layout/anneal/score.h"

#include <gtest/gtest.h>

#include "common/config/config.h"
#include "worker/layout/anneal/annealer.h"
#include "worker/layout/furnish.h"
#include "worker/layout/plan/house_plan.h"

namespace parallax {
namespace {

struct ProblemAndWishes {
  RoomProblem problem;
  std::vector<Wish> wishes;
};

ProblemAndWishes ProblemOf(const std::string& kind, uint64_t seed) {
  v1::SceneConfig config = DefaultSceneConfig();
  config.mutable_room()->clear_kinds();
  config.mutable_room()->add_kinds(kind);
  const House house = *DrawHouse(config.room(), SceneSeed{seed});
  const RoomTable& table = *FindRoomTable(kind);
  return {MakeRoomProblem(house.rooms[0], table, config.assets(), SceneSeed{seed}),
          WishesOf(table)};
}

TEST(Score, WhatMovesLeftUntouchedIsStillRightAfterAWholeAnnealing) {
  for (const char* kind : {"living_room", "dining_room", "bedroom", "kitchen"}) {
    for (uint64_t seed = 0; seed < 3; ++seed) {
      const ProblemAndWishes room = ProblemOf(kind, seed);
      AssetPool pool;
      const ModelRack rack(SceneSeed{seed}, pool);
      const AnnealResult result =
          *Anneal(room.problem, room.wishes, {}, rack, AnnealPlan{}, SceneSeed{seed}, {});
      Score fresh(room.problem, room.wishes);
      fresh.Reset(result.arrangement);
      EXPECT_NEAR(result.score.total(), fresh.total(), 1e-9) << kind << " " << seed;
      EXPECT_LT(result.score.evaluated(), result.score.possible()) << kind;
    }
  }
}

TEST(Score, LongerAnnealingsAndMoreOfThemGiveLessLoss) {
  double quick = 0, best = 0;
  for (uint64_t seed = 0; seed < 4; ++seed) {
    const ProblemAndWishes room = ProblemOf("dining_room", seed);
    AssetPool pool;
    const ModelRack rack(SceneSeed{seed}, pool);
    AnnealPlan plan;
    quick += Anneal(room.problem, room.wishes, {}, rack, plan, SceneSeed{seed}, {})->score.total();
    plan.large_steps *= 3;
    plan.medium_steps *= 3;
    plan.runs = 2;
    best += Anneal(room.problem, room.wishes, {}, rack, plan, SceneSeed{seed}, {})->score.total();
  }
  EXPECT_LT(best, quick);
}

Item ItemOf(const ProblemAndWishes& room, const std::string& group, const PooledAsset* asset,
            Vec2d at, double yaw_rad) {
  Item item;
  for (size_t r = 0; r < room.problem.rows.size(); ++r) {
    if (room.problem.rows[r].row.group == group) item.row = static_cast<int>(r);
  }
  item.asset = asset;
  item.footprint = {at, {0.5, 0.5}, yaw_rad};
  item.top_m = 0.8;
  return item;
}

TEST(Wish, CostsNothingWhereFulfilledAndMoreTheFartherFromIt) {
  const ProblemAndWishes room = ProblemOf("living_room", 1);
  AssetPool pool;
  const PooledAsset* sofa = *pool.Get("Sofa", 1);
  Arrangement facing(room.problem, {}), away(room.problem, {});
  // A front looks along +y turned by the yaw.
  facing.Add(ItemOf(room, "sofa", sofa, {1, 1}, 0));
  facing.Add(ItemOf(room, "tv stand", sofa, {1, 4}, 0));
  away.Add(ItemOf(room, "sofa", sofa, {1, 1}, 3.14159265));
  away.Add(ItemOf(room, "tv stand", sofa, {1, 4}, 0));
  FloorRegion seen;
  EXPECT_NEAR(Facing("sofa", "tv stand").Of(facing, seen), 0, 1e-9);
  EXPECT_NEAR(Facing("sofa", "tv stand").Of(away, seen), 2, 1e-9);
  EXPECT_NEAR(Distance("sofa", "tv stand", 1, 4).Of(facing, seen), 0, 1e-9);
  EXPECT_NEAR(Distance("sofa", "tv stand", 1, 2).Of(facing, seen), 1, 1e-9);
  EXPECT_NEAR(AwayFrom("sofa", "tv stand", 2.5).Of(facing, seen), 0.5, 1e-9);
}

TEST(Wish, SeatsWithoutATableAreNeitherEvenNorUneven) {
  const ProblemAndWishes room = ProblemOf("dining_room", 1);
  AssetPool pool;
  Arrangement alone(room.problem, {});
  alone.Add(ItemOf(room, "chair", *pool.Get("Chair", 1), {1, 1}, 0));
  FloorRegion seen;
  EXPECT_EQ(EvenlyAround("chair").Of(alone, seen), 0);
}

TEST(Wish, SumsWeighsAndTakesTheWorst) {
  const ProblemAndWishes room = ProblemOf("living_room", 1);
  const Wish one("one", WishKind::kRelation, {"sofa"},
                 [](const Arrangement&, FloorRegion&) { return 1.0; });
  const Wish two = one.Weight(2).Named("two");
  const Arrangement empty(room.problem, {});
  FloorRegion seen;
  EXPECT_EQ((one + two).Of(empty, seen), 3);
  EXPECT_EQ(Worst(one, two).Of(empty, seen), 2);
  EXPECT_EQ((one + two).Weight(0.5).Of(empty, seen), 1.5);
  EXPECT_EQ(If("sofa", one).Of(empty, seen), 0);
}

}  // namespace
}  // namespace parallax
