#include "worker/layout/plan/room_shell.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <map>

#include "common/base/rng.h"
#include "common/config/config.h"
#include "worker/geometry/ray_scene.h"
#include "worker/layout/plan/house_plan.h"

namespace parallax {
namespace {

constexpr int kShells = 30;

v1::Room RoomOf(uint64_t seed) {
  v1::RoomConfig config = DefaultSceneConfig().room();
  config.mutable_doors()->mutable_uniform_int()->set_high(3);
  config.mutable_windows()->mutable_uniform_int()->set_high(6);
  return DrawHouse(config, SceneSeed{seed})->rooms[0];
}

// Edges, by rounded ends, that do not run as often one way as the other.
int OpenEdges(const Mesh& mesh) {
  using Key = std::array<long, 3>;
  const auto key = [&](uint32_t v) {
    const Vec3f& p = mesh.positions[v];
    return Key{std::lround(p.x() * 2e4f), std::lround(p.y() * 2e4f), std::lround(p.z() * 2e4f)};
  };
  std::map<std::pair<Key, Key>, int> balance;
  for (const Triangle& t : mesh.triangles) {
    const std::array<Key, 3> k = {key(t.a), key(t.b), key(t.c)};
    for (int i = 0; i < 3; ++i) {
      const Key &p = k[i], &q = k[(i + 1) % 3];
      if (p < q) {
        ++balance[{p, q}];
      } else if (q < p) {
        --balance[{q, p}];
      }
    }
  }
  int open = 0;
  for (const auto& [edge, count] : balance) open += count != 0;
  return open;
}

TEST(RoomShell, EveryPartIsAValidClosedMesh) {
  for (uint64_t seed = 0; seed < kShells; ++seed) {
    v1::Room room = RoomOf(seed);
    room.set_window_glass(seed % 2 == 0);
    for (const std::string& part : RoomParts(room)) {
      const Mesh mesh = MakeRoomPart(room, part).value();
      EXPECT_TRUE(ValidateMesh(mesh).ok()) << seed << " " << part << ValidateMesh(mesh);
      EXPECT_EQ(OpenEdges(mesh), 0) << seed << " " << part;
    }
  }
}

TEST(RoomShell, WindowsHaveGlassUnlessTheConfigLeavesItOut) {
  for (const bool glass : {true, false}) {
    v1::RoomConfig config = DefaultSceneConfig().room();
    config.mutable_windows()->set_constant(3);
    config.set_window_glass(glass);
    int windows = 0;
    for (uint64_t seed = 0; seed < 8; ++seed) {
      const v1::Room room = DrawHouse(config, SceneSeed{seed})->rooms[0];
      for (const std::string& part : RoomParts(room)) {
        if (part.rfind("window_", 0) != 0) continue;
        ++windows;
        const Mesh mesh = MakeRoomPart(room, part).value();
        const bool panes =
            std::any_of(mesh.triangles.begin(), mesh.triangles.end(),
                        [&](const Triangle& t) { return mesh.slots[t.slot].name == "glass"; });
        EXPECT_EQ(panes, glass) << seed << " " << part;
      }
    }
    EXPECT_GE(windows, 8);
  }
}

TEST(RoomShell, ClosedRoomLetsNoRayOut) {
  Rng rng(SceneSeed{5}, "rays");
  for (uint64_t seed = 0; seed < 10; ++seed) {
    v1::Room room = RoomOf(seed);
    room.clear_openings();
    room.clear_pillars();  // Rays start anywhere.
    RayScene scene;
    for (const std::string& part : RoomParts(room)) {
      scene.Add(*MakeRoomPart(room, part), Eigen::Affine3f::Identity());
    }
    scene.Commit();
    for (int i = 0; i < 2000; ++i) {
      const Vec3d from(rng.Uniform(0.1, room.width_m() - 0.1),
                       rng.Uniform(0.1, room.depth_m() - 0.1),
                       rng.Uniform(0.1, room.height_m() - 0.1));
      const Vec3d direction(rng.Normal(), rng.Normal(), rng.Normal());
      const auto hit = scene.Intersect(from.cast<float>(), direction.cast<float>());
      ASSERT_TRUE(hit.has_value()) << "seed " << seed;
      EXPECT_LT(hit->normal.dot(direction.cast<float>()), 0) << "faces look into the room";
    }
  }
}

TEST(RoomShell, RayThroughAWindowWithoutGlassLeavesTheRoom) {
  int windows = 0;
  for (uint64_t seed = 0; seed < kShells; ++seed) {
    const v1::Room room = RoomOf(seed);
    RayScene scene;
    scene.Add(*MakeRoomPart(room, "walls"), Eigen::Affine3f::Identity());
    scene.Commit();
    for (const v1::Opening& o : room.openings()) {
      const Vec3f middle(static_cast<float>(room.width_m() / 2),
                         static_cast<float>(room.depth_m() / 2), 1.2f);
      const float c = static_cast<float>(o.center_m()),
                  h = static_cast<float>(o.sill_m() + o.height_m() / 2);
      const float w = static_cast<float>(room.width_m()), d = static_cast<float>(room.depth_m());
      const Vec3f targets[] = {{c, 0, h}, {w, c, h}, {c, d, h}, {0, c, h}};
      EXPECT_FALSE(scene.Intersect(middle, targets[o.wall()] - middle, 1.05f)) << seed;
      ++windows;
    }
  }
  EXPECT_GT(windows, kShells);
}

TEST(RoomShell, OpeningsKeepApartAndInsideTheirWalls) {
  for (uint64_t seed = 0; seed < 200; ++seed) {
    const v1::Room room = RoomOf(seed);
    for (int i = 0; i < room.openings_size(); ++i) {
      const v1::Opening& a = room.openings(i);
      const double length = a.wall() % 2 == 0 ? room.width_m() : room.depth_m();
      EXPECT_GT(a.center_m() - a.width_m() / 2, 0.2);
      EXPECT_LT(a.center_m() + a.width_m() / 2, length - 0.2);
      EXPECT_LT(a.sill_m() + a.height_m(), room.height_m() - 0.1);
      for (int k = 0; k < i; ++k) {
        const v1::Opening& b = room.openings(k);
        if (b.wall() != a.wall()) continue;
        EXPECT_GT(std::abs(a.center_m() - b.center_m()), (a.width_m() + b.width_m()) / 2 + 0.2);
      }
    }
  }
}

TEST(RoomShell, UnknownPartIsNotFound) {
  EXPECT_EQ(MakeRoomPart(RoomOf(1), "door_9").status().code(), absl::StatusCode::kNotFound);
}

}  // namespace
}  // namespace parallax
