#include "worker/layout/layout.h"

#include <gtest/gtest.h>

#include <array>

#include "common/config/config.h"
#include "common/math/proto.h"
#include "worker/geometry/ray_scene.h"
#include "worker/layout/anneal/asset_pool.h"
#include "worker/layout/plan/room_shell.h"

namespace parallax {
namespace {

constexpr uint64_t kSeeds = 20;

v1::SceneConfig ConfigOf(uint64_t seed) {
  v1::SceneConfig config = DefaultSceneConfig();
  config.mutable_solver()->set_mode(seed % 3 == 0 ? v1::SolverConfig::MODE_REDUCED
                                                  : v1::SolverConfig::MODE_FULL);
  const char* kinds[] = {"living_room", "dining_room", "bedroom", "office"};
  config.mutable_room()->clear_kinds();
  config.mutable_room()->add_kinds(kinds[seed % 4]);
  return config;
}

v1::Layout LayoutOf(const v1::SceneConfig& config, uint64_t seed) {
  auto solved = SolveLayout(config, SceneSeed{seed}, CancelToken());
  EXPECT_TRUE(solved.ok()) << solved.status();
  return std::get<v1::Layout>(*solved);
}

struct Solid {
  const v1::SceneObject* object;
  std::shared_ptr<const TriangleTree> tree;
  Eigen::Affine3f place;
  Box3f box;
};

std::vector<Solid> SolidsOf(const v1::Layout& layout, AssetPool& pool) {
  std::vector<Solid> solids;
  for (const v1::SceneObject& object : layout.objects()) {
    Solid solid;
    solid.object = &object;
    solid.place = FromProto(object.world_from_object()).Affine();
    if (object.part().empty()) {
      solid.tree = (*pool.Get(object.asset_class(), object.seed()))->Tree();
    } else {
      solid.tree = std::make_shared<TriangleTree>(
          *MakeRoomPart(layout.place().house().rooms(0), object.part()));
    }
    for (const auto& t : solid.tree->triangles()) {
      for (const uint32_t v : t) solid.box.extend(solid.place * solid.tree->positions()[v]);
    }
    solids.push_back(solid);
  }
  return solids;
}

bool IsRug(const v1::SceneObject& object) { return object.relation() == "under"; }

struct Solved {
  uint64_t seed;
  v1::Layout layout;
  std::vector<Solid> solids;
};
Solved SolvedOf(const v1::SceneConfig& config, uint64_t seed) {
  AssetPool pool;
  Solved solved{seed, LayoutOf(config, seed), {}};
  solved.solids = SolidsOf(solved.layout, pool);
  return solved;
}

void ExpectApart(const Solved& solved) {
  const auto& [seed, layout, solids] = solved;
  for (size_t i = 0; i < solids.size(); ++i) {
    for (size_t k = 0; k < i; ++k) {
      const Solid &a = solids[i], &b = solids[k];
      // Joinery is set into walls and floor on purpose; legs press into the pile of rugs.
      if (!a.object->part().empty() && !b.object->part().empty()) continue;
      if (IsRug(*a.object) || IsRug(*b.object)) continue;
      EXPECT_FALSE(Overlap(*a.tree, a.place, *b.tree, b.place))
          << "seed " << seed << ": " << a.object->name() << " and " << b.object->name();
    }
  }
}

void ExpectInsideTheRoom(const Solved& solved) {
  const auto& [seed, layout, solids] = solved;
  const Vec3f size =
      Vec3d(layout.place().house().rooms(0).width_m(), layout.place().house().rooms(0).depth_m(),
            layout.place().house().rooms(0).height_m())
          .cast<float>();
  for (const Solid& solid : solids) {
    if (!solid.object->part().empty()) continue;
    EXPECT_TRUE((solid.box.min().array() > -1e-3f).all()) << seed << solid.object->name();
    EXPECT_TRUE((solid.box.max().array() < size.array() + 1e-3f).all())
        << seed << solid.object->name();
  }
}

void ExpectDoorsFree(const Solved& solved) {
  const auto& [seed, layout, solids] = solved;
  const v1::Room& room = layout.place().house().rooms(0);
  for (const v1::Opening& o : room.openings()) {
    if (o.kind() != v1::Opening::KIND_DOOR) continue;
    const double a = o.center_m() - o.width_m() / 2, b = o.center_m() + o.width_m() / 2;
    const double w = room.width_m(), d = room.depth_m(), deep = 0.7;
    const Vec3d lows[] = {{a, 0, 0.1}, {w - deep, a, 0.1}, {a, d - deep, 0.1}, {0, a, 0.1}};
    const Vec3d highs[] = {{b, deep, 1.8}, {w, b, 1.8}, {b, d, 1.8}, {deep, b, 1.8}};
    const Box3f zone(lows[o.wall()].cast<float>().eval(), highs[o.wall()].cast<float>().eval());
    for (const Solid& solid : solids) {
      if (!solid.object->part().empty()) continue;
      EXPECT_FALSE(solid.box.intersects(zone)) << seed << " " << solid.object->name();
    }
  }
}

void ExpectBorne(const Solved& solved) {
  const auto& [seed, layout, solids] = solved;
  for (const Solid& solid : solids) {
    const std::string& relation = solid.object->relation();
    if (relation.empty() || relation == "on_wall") continue;
    if (relation == "on_ceiling") {
      EXPECT_NEAR(solid.box.max().z(), layout.place().house().rooms(0).height_m(), 2e-3)
          << solid.object->name();
    } else if (relation == "on_top_of") {
      // Some point of it touches its bearer, but for the half millimetre that keeps them apart.
      const Solid& bearer = solids[solid.object->parent_index() - 1];
      RayScene below;
      below.Add(bearer.tree, bearer.place);
      below.Commit();
      bool held = false;
      for (const Vec3f& p : solid.tree->positions()) {
        const Vec3f above = solid.place * p + Vec3f(0, 0, 0.0005f);
        held = held || below.Intersect(above, {0, 0, -1}, 0.0105f).has_value();
      }
      EXPECT_TRUE(held) << "seed " << seed << ": " << solid.object->name() << " floats over "
                        << bearer.object->name();
    } else {
      EXPECT_NEAR(solid.box.min().z(), 0, 2e-3) << seed << " " << solid.object->name();
    }
  }
}

void ExpectHardConstraintsReported(const Solved& solved) {
  const auto& [seed, layout, solids] = solved;
  const v1::SolveReport& report = layout.report();
  int hard = 0;
  for (const auto& constraint : report.constraints()) {
    if (!constraint.hard()) continue;
    ++hard;
    EXPECT_EQ(constraint.violation(), 0) << seed << " " << constraint.name();
  }
  EXPECT_GT(hard, 0);
  EXPECT_LE(report.final_loss(), report.initial_loss());
  EXPECT_FALSE(report.loss_curve().empty());
}

void ExpectEveryHardConstraint(const Solved& solved) {
  ExpectApart(solved);
  ExpectInsideTheRoom(solved);
  ExpectDoorsFree(solved);
  ExpectBorne(solved);
  ExpectHardConstraintsReported(solved);
}

TEST(Layout, RoomsOfManySeedsKeepEveryHardConstraint) {
  for (uint64_t seed = 0; seed < kSeeds; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    ExpectEveryHardConstraint(SolvedOf(ConfigOf(seed), seed));
  }
}

// Things of the room's own in each quarter of its floor.
std::array<int, 4> ThingsByQuarter(const Solved& solved) {
  const v1::Room& room = solved.layout.place().house().rooms(0);
  std::array<int, 4> things{};
  for (const Solid& solid : solved.solids) {
    const std::string& relation = solid.object->relation();
    if (!solid.object->part().empty() || relation == "on_ceiling" || relation == "on_wall")
      continue;
    const Vec3f at = solid.box.center();
    const size_t east = double{at.x()} > room.width_m() / 2;
    const size_t north = double{at.y()} > room.depth_m() / 2;
    ++things[2 * north + east];
  }
  return things;
}

void ExpectLitEvenly(const Solved& solved) {
  const v1::Room& room = solved.layout.place().house().rooms(0);
  const double area = room.width_m() * room.depth_m();
  double power_w = 0;
  int lamps = 0;
  for (const v1::Light& light : solved.layout.lights()) {
    const v1::SceneObject& owner =
        solved.layout.objects(static_cast<int>(light.object_index()) - 1);
    if (owner.relation() != "on_ceiling") continue;
    power_w += FromProto(light.power_w()).mean();
    ++lamps;
  }
  EXPECT_GE(lamps, 4);
  EXPECT_GE(power_w / area, 6) << "watts a square metre";
}

TEST(Layout, HallsAreLargeFurnishedAllOverAndLit) {
  int columns = 0;
  for (uint64_t seed = 0; seed < 4; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    v1::SceneConfig config = ConfigOf(seed);
    config.mutable_room()->set_hall_p(1);
    const Solved solved = SolvedOf(config, seed);
    const v1::Room& room = solved.layout.place().house().rooms(0);
    EXPECT_TRUE(room.hall());
    for (const double side : {room.width_m(), room.depth_m()}) {
      EXPECT_GE(side, 8);
      EXPECT_LE(side, 12);
    }
    EXPECT_GE(room.height_m(), 3.5);
    EXPECT_LE(room.height_m(), 6);
    ExpectEveryHardConstraint(solved);
    for (const int things : ThingsByQuarter(solved)) EXPECT_GE(things, 5);
    ExpectLitEvenly(solved);
    columns += room.pillars_size();
  }
  EXPECT_GT(columns, 0);
}

TEST(Layout, SameSeedGivesTheSameBytes) {
  for (uint64_t seed = 0; seed < 4; ++seed) {
    EXPECT_EQ(LayoutOf(ConfigOf(seed), seed).SerializeAsString(),
              LayoutOf(ConfigOf(seed), seed).SerializeAsString());
  }
}

TEST(Layout, WithoutFurnitureRoomAndLampsStayTheSame) {
  for (uint64_t seed = 0; seed < 4; ++seed) {
    v1::SceneConfig config = ConfigOf(seed);
    const v1::Layout full = LayoutOf(config, seed);
    config.mutable_furniture()->set_enabled(false);
    const v1::Layout bare = LayoutOf(config, seed);
    EXPECT_EQ(full.place().SerializeAsString(), bare.place().SerializeAsString());
    ASSERT_LE(bare.objects_size(), full.objects_size());
    for (int i = 0; i < bare.objects_size(); ++i) {
      EXPECT_NE(bare.objects(i).role(), v1::OBJECT_ROLE_FURNITURE);
      EXPECT_EQ(bare.objects(i).SerializeAsString(), full.objects(i).SerializeAsString());
    }
    for (int i = 0; i < bare.lights_size(); ++i) {
      EXPECT_EQ(bare.lights(i).SerializeAsString(), full.lights(i).SerializeAsString());
    }
  }
}

TEST(Layout, ExcludedClassesAreNotMade) {
  v1::SceneConfig config = ConfigOf(1);
  config.mutable_room()->clear_kinds();
  config.mutable_room()->add_kinds("dining_room");
  const auto chairs = [&] {
    const v1::Layout layout = LayoutOf(config, 2);
    return std::count_if(layout.objects().begin(), layout.objects().end(),
                         [](const auto& object) { return object.asset_class() == "Chair"; });
  };
  EXPECT_GT(chairs(), 1);
  config.mutable_assets()->add_exclude("Chair");
  EXPECT_EQ(chairs(), 0);
}

TEST(Layout, TinyAndHugeRoomsSolve) {
  for (uint64_t seed = 100; seed < 108; ++seed) {
    v1::SceneConfig config = ConfigOf(seed);
    const bool tiny = seed % 2 == 0;
    config.mutable_room()->mutable_width_m()->set_constant(tiny ? 2.0 : 12.0);
    config.mutable_room()->mutable_depth_m()->set_constant(tiny ? 2.0 : 12.0);
    config.mutable_room()->mutable_height_m()->set_constant(tiny ? 2.1 : 6.0);
    config.mutable_room()->mutable_doors()->set_constant(4);
    config.mutable_room()->mutable_windows()->set_constant(8);
    const v1::Layout layout = LayoutOf(config, seed);
    for (const auto& constraint : layout.report().constraints()) {
      if (constraint.hard()) {
        EXPECT_EQ(constraint.violation(), 0) << seed;
      }
    }
  }
}

TEST(Layout, UnknownRoomKindIsAnInvalidArgument) {
  v1::SceneConfig config = ConfigOf(1);
  config.mutable_room()->add_kinds("ballroom");
  EXPECT_EQ(SolveLayout(config, SceneSeed{1}, CancelToken()).status().code(),
            absl::StatusCode::kInvalidArgument);
}

TEST(Layout, CancelledSolveSaysSo) {
  CancelToken cancel;
  cancel.Cancel();
  EXPECT_EQ(SolveLayout(ConfigOf(1), SceneSeed{1}, cancel).status().code(),
            absl::StatusCode::kCancelled);
}

}  // namespace
}  // namespace parallax
