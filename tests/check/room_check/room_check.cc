// Holds solved rooms against what people expect of them, with another library (FCL) for overlaps:
// no two meshes meet, nothing floats unless it should, every door can be reached, doors and windows
// open to where they say. Prints one JSON line a kind of room; the exit status is 1 when something
// is wrong.
//   room_check [--seeds 100] [--first 0] [--kind living_room] [--rooms 1] [--mode full]
#include <fcl/geometry/bvh/BVH_model.h>
#include <fcl/math/bv/OBB.h>
#include <fcl/narrowphase/collision.h>
#include <fcl/narrowphase/collision_object.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "common/config/config.h"
#include "common/math/proto.h"
#include "worker/geometry/ray_scene.h"
#include "worker/layout/anneal/asset_pool.h"
#include "worker/layout/anneal/room_table.h"
#include "worker/layout/layout.h"
#include "worker/layout/plan/room_shell.h"
#include "worker/layout/plan/wall_frame.h"

namespace parallax {
namespace {

struct Options {
  int seeds = 100, first = 0, rooms = 1;
  std::string kind, mode = "full";
  bool verbose = false;
};

struct Tally {
  int scenes = 0, rejected = 0, objects = 0, overlaps = 0, floating = 0, doors_blocked = 0,
      openings_wrong = 0, hard = 0;
  std::map<std::string, int> lacking;  // Scenes without what their table asks for exactly so often.
};

// Doubles, for which FCL's library holds what would else be compiled here, for minutes.
using Model = fcl::BVHModel<fcl::OBBd>;

std::shared_ptr<Model> ModelOf(const Mesh& mesh) {
  auto model = std::make_shared<Model>();
  std::vector<fcl::Vector3d> positions;
  for (const Vec3f& p : mesh.positions) positions.push_back(p.cast<double>());
  std::vector<fcl::Triangle> triangles;
  for (const Triangle& t : mesh.triangles) triangles.emplace_back(t.a, t.b, t.c);
  model->beginModel();
  model->addSubModel(positions, triangles);
  model->endModel();
  return model;
}

struct Solid {
  const v1::SceneObject* object = nullptr;
  std::shared_ptr<const Mesh> mesh;
  Eigen::Affine3f place;
  Box3f own, box;  // In its own frame; in the world.
};

class Checker {
 public:
  Checker(const v1::Layout& layout, bool verbose) : layout_(layout), verbose_(verbose) {
    for (const v1::SceneObject& object : layout.objects()) {
      Solid solid;
      solid.object = &object;
      solid.place = FromProto(object.world_from_object()).Affine();
      if (object.part().empty()) {
        solid.mesh = (*pool_.Get(object.asset_class(), object.seed()))->mesh;
      } else {
        solid.mesh = std::make_shared<Mesh>(*MakeRoomPart(layout.place().house(), object));
      }
      solid.own = solid.mesh->Bounds();
      for (const Vec3f& p : solid.mesh->positions) solid.box.extend(solid.place * p);
      solids_.push_back(std::move(solid));
    }
  }

  void Check(Tally& tally) {
    tally.objects += layout_.objects_size();
    tally.overlaps += Overlaps();
    tally.floating += Floating();
    tally.doors_blocked += DoorsBlocked();
    tally.openings_wrong += OpeningsWrong();
    const auto add = [&](const v1::SolveReport& report) {
      for (const auto& c : report.constraints()) tally.hard += c.hard() && c.violation() > 0;
    };
    add(layout_.report());
    for (const auto& report : layout_.room_reports()) add(report);
  }

 private:
  const v1::Room& Room(size_t index) const {
    return layout_.place().house().rooms(static_cast<int>(index));
  }
  size_t RoomCount() const { return static_cast<size_t>(layout_.place().house().rooms_size()); }
  size_t RoomIndex(const v1::SceneObject& object) const {
    return static_cast<size_t>(RoomIndexOf(layout_.place().house(), object.index()));
  }
  void Say(const char* what, const std::string& a, const std::string& b = "") const {
    if (verbose_) std::fprintf(stderr, "  %s: %s %s\n", what, a.c_str(), b.c_str());
  }

  // Its name, its room, and what it takes up in the world.
  std::string Where(const Solid& solid) const {
    char text[160];
    std::snprintf(text, sizeof text, "%s (room %zu, %.2f %.2f %.2f to %.2f %.2f %.2f)",
                  solid.object->name().c_str(), RoomIndex(*solid.object),
                  double{solid.box.min().x()}, double{solid.box.min().y()},
                  double{solid.box.min().z()}, double{solid.box.max().x()},
                  double{solid.box.max().y()}, double{solid.box.max().z()});
    return text;
  }

  // Furniture is turned and moved, never scaled.
  static fcl::Transform3d RigidOf(const Eigen::Affine3f& place) {
    fcl::Transform3d rigid = fcl::Transform3d::Identity();
    rigid.linear() = place.linear().cast<double>();
    rigid.translation() = place.translation().cast<double>();
    return rigid;
  }

  // Made when first asked for: most things come near nothing.
  const std::shared_ptr<Model>& ModelFor(const Solid& solid) {
    std::shared_ptr<Model>& model = models_[solid.mesh.get()];
    if (model == nullptr) model = ModelOf(*solid.mesh);
    return model;
  }

  int Overlaps() {
    int count = 0;
    for (size_t i = 0; i < solids_.size(); ++i) {
      for (size_t k = 0; k < i; ++k) {
        const Solid &a = solids_[i], &b = solids_[k];
        // Joinery is set into masonry on purpose; legs press into the pile of rugs.
        if (!a.object->part().empty() && !b.object->part().empty()) continue;
        if (a.object->relation() == "under" || b.object->relation() == "under") continue;
        if (!a.box.intersects(b.box)) continue;
        fcl::CollisionObjectd first(ModelFor(a), RigidOf(a.place)),
            second(ModelFor(b), RigidOf(b.place));
        fcl::CollisionRequestd request;
        fcl::CollisionResultd result;
        fcl::collide(&first, &second, request, result);
        if (!result.isCollision()) continue;
        ++count;
        Say("overlap", Where(a), Where(b));
      }
    }
    return count;
  }

  int Floating() const {
    int count = 0;
    for (const Solid& solid : solids_) {
      const std::string& relation = solid.object->relation();
      if (relation.empty()) continue;
      const v1::Room& room = Room(RoomIndex(*solid.object));
      bool held = true;
      if (relation == "on_ceiling") {
        held = std::abs(solid.box.max().z() - room.floor_z_m() - room.height_m()) < 0.05;
      } else if (relation == "on_wall") {
        held = NearWall(solid, room);
      } else if (relation == "on_top_of") {
        held = Borne(solid, solids_[solid.object->parent_index() - 1]);
      } else {
        held = std::abs(solid.box.min().z() - room.floor_z_m()) < 2e-3;
      }
      count += !held;
      if (!held) Say("floats", solid.object->name(), relation);
    }
    return count;
  }

  static bool NearWall(const Solid& solid, const v1::Room& room) {
    const double x0 = room.origin_x_m(), y0 = room.origin_y_m();
    const double gap = std::min({solid.box.min().x() - x0, solid.box.min().y() - y0,
                                 x0 + room.width_m() - solid.box.max().x(),
                                 y0 + room.depth_m() - solid.box.max().y()});
    return std::abs(gap) < 0.01;
  }

  // Some point of it is within a centimetre of what bears it.
  static bool Borne(const Solid& solid, const Solid& bearer) {
    RayScene below;
    below.Add(*bearer.mesh, bearer.place);
    below.Commit();
    for (const Vec3f& p : solid.mesh->positions) {
      const Vec3f above = solid.place * p + Vec3f(0, 0, 0.0005f);
      if (below.Intersect(above, {0, 0, -1}, 0.0105f)) return true;
    }
    return false;
  }

  // Doors of a room between which a person can't walk, on a grid of 8 cm. Chairs are moved aside.
  int DoorsBlocked() const {
    int blocked = 0;
    for (size_t r = 0; r < RoomCount(); ++r) {
      const v1::Room& room = Room(r);
      constexpr double kCell = 0.08, kBody = 0.2;
      const int nx = std::max(1, static_cast<int>(room.width_m() / kCell));
      const int ny = std::max(1, static_cast<int>(room.depth_m() / kCell));
      std::vector<char> state(static_cast<size_t>(nx * ny), 0);
      for (const Solid& solid : solids_) {
        const std::string& relation = solid.object->relation();
        if (RoomIndex(*solid.object) != r || relation == "under" || relation == "around") continue;
        if (!solid.object->part().empty() && solid.object->part() != "pillars") continue;
        const double z = room.floor_z_m();
        if (solid.box.min().z() > z + 0.7 || solid.box.max().z() < z + 0.05) continue;
        for (int i = 0; i < nx * ny; ++i) {
          const double x = room.origin_x_m() + (i % nx + 0.5) * room.width_m() / nx;
          const double y = room.origin_y_m() + (i / nx + 0.5) * room.depth_m() / ny;
          // Works in the object's own frame, so that a turned object takes its own rectangle.
          const Vec3f p =
              solid.place.inverse() * Vec3f(static_cast<float>(x), static_cast<float>(y), 0);
          const Box3f& own = solid.own;
          if (p.x() > own.min().x() - kBody && p.x() < own.max().x() + kBody &&
              p.y() > own.min().y() - kBody && p.y() < own.max().y() + kBody) {
            state[static_cast<size_t>(i)] = 1;
          }
        }
      }
      if (room.has_stairs()) continue;  // Its doors lie on two levels.
      bool first = true;
      for (const v1::Opening& o : room.openings()) {
        if (o.kind() == v1::Opening::KIND_WINDOW) continue;
        const WallFrame frame = FrameOfWall(room, o.wall());
        const Vec2d at = frame.At(frame.LocalOf(o.center_m()), 0.45);
        const int x = std::clamp(static_cast<int>(at.x() / room.width_m() * nx), 0, nx - 1);
        const int y = std::clamp(static_cast<int>(at.y() / room.depth_m() * ny), 0, ny - 1);
        const size_t cell = static_cast<size_t>(y * nx + x);
        if (first && state[cell] == 0) Flood(state, nx, ny, static_cast<int>(cell));
        first = false;
        if (state[cell] != 2) {
          ++blocked;
          Say("door can't be reached", room.name());
        }
      }
    }
    return blocked;
  }

  static void Flood(std::vector<char>& state, int nx, int ny, int from) {
    std::vector<int> stack = {from};
    while (!stack.empty()) {
      const int c = stack.back();
      stack.pop_back();
      if (state[static_cast<size_t>(c)] != 0) continue;
      state[static_cast<size_t>(c)] = 2;
      if (c % nx > 0) stack.push_back(c - 1);
      if (c % nx + 1 < nx) stack.push_back(c + 1);
      if (c / nx > 0) stack.push_back(c - nx);
      if (c / nx + 1 < ny) stack.push_back(c + nx);
    }
  }

  // Openings behind which something else is than they say, or whose mate is missing; rooms that no
  // door leads to.
  int OpeningsWrong() const {
    int wrong = 0;
    std::vector<std::vector<size_t>> ways(RoomCount());
    for (size_t r = 0; r < RoomCount(); ++r) {
      for (const v1::Opening& o : Room(r).openings()) {
        const WallFrame frame = FrameOfWall(Room(r), o.wall());
        const double deep = (o.depth_m() > 0 ? o.depth_m() : frame.depth_m) + 0.1;
        const Vec2d local = frame.At(frame.LocalOf(o.center_m()), -deep);
        const Vec3d behind(Room(r).origin_x_m() + local.x(), Room(r).origin_y_m() + local.y(),
                           Room(r).floor_z_m() + o.sill_m() + 0.5 * o.height_m());
        const int found = RoomAt(behind);
        const int said = static_cast<int>(o.leads_to()) - 1;
        bool good = found == said;
        if (said >= 0) {
          good = good && HasMate(r, static_cast<size_t>(said), o);
          ways[r].push_back(static_cast<size_t>(said));
        }
        wrong += !good;
        if (!good)
          Say("opening", Room(r).name(), std::to_string(said) + " is " + std::to_string(found));
      }
    }
    std::vector<bool> reached(RoomCount(), false);
    std::vector<size_t> stack = {0};
    while (!stack.empty()) {
      const size_t r = stack.back();
      stack.pop_back();
      if (reached[r]) continue;
      reached[r] = true;
      for (const size_t next : ways[r]) stack.push_back(next);
    }
    for (size_t r = 0; r < RoomCount(); ++r) {
      wrong += !reached[r];
      if (!reached[r]) Say("no way to", Room(r).name());
    }
    return wrong;
  }

  int RoomAt(const Vec3d& p) const {
    for (size_t r = 0; r < RoomCount(); ++r) {
      const v1::Room& room = Room(r);
      const Vec3d at = p - Vec3d(room.origin_x_m(), room.origin_y_m(), room.floor_z_m());
      if ((at.array() > 0).all() && at.x() < room.width_m() && at.y() < room.depth_m() &&
          at.z() < room.height_m()) {
        return static_cast<int>(r);
      }
    }
    return -1;
  }

  static Vec3d PlaceOf(const v1::Room& room, const v1::Opening& o) {
    const WallFrame frame = FrameOfWall(room, o.wall());
    const Vec2d at = frame.At(frame.LocalOf(o.center_m()), -0.5 * o.depth_m());
    return Vec3d(room.origin_x_m() + at.x(), room.origin_y_m() + at.y(),
                 room.floor_z_m() + o.sill_m());
  }
  bool HasMate(size_t from, size_t to, const v1::Opening& o) const {
    if (to >= RoomCount()) return false;
    for (const v1::Opening& mate : Room(to).openings()) {
      if (mate.leads_to() == from + 1 && mate.mated() != o.mated() && mate.kind() == o.kind() &&
          (PlaceOf(Room(to), mate) - PlaceOf(Room(from), o)).norm() < 1e-6) {
        return true;
      }
    }
    return false;
  }

  const v1::Layout& layout_;
  bool verbose_;
  AssetPool pool_;
  std::map<const Mesh*, std::shared_ptr<Model>> models_;
  std::vector<Solid> solids_;
};

void CountLacking(const RoomTable& table, const v1::SolveReport& report, Tally& tally) {
  for (const RoomRow& row : table.rows) {
    if (row.least != row.most) continue;
    for (const auto& c : report.constraints()) {
      if (c.name() == "fullness: " + row.group + " wanted" && c.violation() > 0) {
        ++tally.lacking[row.group];
      }
    }
  }
}

void SayRoom(const v1::Room& room) {
  std::fprintf(stderr, "  %s: %.2f %.2f %.2f to %.2f %.2f %.2f\n", room.name().c_str(),
               room.origin_x_m(), room.origin_y_m(), room.floor_z_m(),
               room.origin_x_m() + room.width_m(), room.origin_y_m() + room.depth_m(),
               room.floor_z_m() + room.height_m());
}

int Main(const Options& options) {
  bool good = true;
  for (const RoomTable& table : RoomTables()) {
    if (table.kind == "stairs" || (!options.kind.empty() && table.kind != options.kind)) continue;
    Tally tally;
    v1::SceneConfig config = DefaultSceneConfig();
    config.mutable_solver()->set_mode(options.mode == "full" ? v1::SolverConfig::MODE_FULL
                                                             : v1::SolverConfig::MODE_REDUCED);
    config.mutable_room()->clear_kinds();
    config.mutable_room()->add_kinds(table.kind);
    config.mutable_room()->mutable_rooms()->set_constant(options.rooms);
    for (int i = 0; i < options.seeds; ++i) {
      const uint64_t seed = static_cast<uint64_t>(options.first + i);
      const auto solved = SolveLayout(config, SceneSeed{seed}, CancelToken());
      ++tally.scenes;
      if (!solved.ok()) {
        std::fprintf(stderr, "%s\n", solved.status().ToString().c_str());
        return 1;
      }
      const v1::Layout* layout = std::get_if<v1::Layout>(&*solved);
      if (layout == nullptr) {
        ++tally.rejected;
        continue;
      }
      if (options.verbose) {
        std::fprintf(stderr, "%s %d\n", table.kind.c_str(), options.first + i);
        for (const v1::Room& room : layout->place().house().rooms()) SayRoom(room);
      }
      Checker(*layout, options.verbose).Check(tally);
      CountLacking(table, layout->report(), tally);
    }
    const nlohmann::json line = {{"bench", "room_check"},
                                 {"kind", table.kind},
                                 {"rooms", options.rooms},
                                 {"scenes", tally.scenes},
                                 {"rejected", tally.rejected},
                                 {"objects", tally.objects},
                                 {"overlaps", tally.overlaps},
                                 {"floating", tally.floating},
                                 {"doors_blocked", tally.doors_blocked},
                                 {"openings_wrong", tally.openings_wrong},
                                 {"hard_violations", tally.hard},
                                 {"lacking", tally.lacking}};
    std::printf("%s\n", line.dump().c_str());
    std::fflush(stdout);
    good = good && tally.rejected * 50 <= tally.scenes && tally.overlaps == 0 &&
           tally.floating == 0 && tally.doors_blocked == 0 && tally.openings_wrong == 0 &&
           tally.hard == 0;
  }
  return good ? 0 : 1;
}

}  // namespace
}  // namespace parallax

int main(int argc, char** argv) {
  parallax::Options options;
  CLI::App app("Checks solved rooms: overlaps by FCL, floating things, doors, windows");
  app.add_option("--seeds", options.seeds);
  app.add_option("--first", options.first);
  app.add_option("--kind", options.kind, "Of the main room; default: every kind");
  app.add_option("--rooms", options.rooms, "Of each house")->check(CLI::Range(1, 8));
  app.add_option("--mode", options.mode)->check(CLI::IsMember({"full", "reduced"}));
  app.add_flag("--verbose", options.verbose, "Say what is wrong where");
  CLI11_PARSE(app, argc, argv);
  return parallax::Main(options);
}
