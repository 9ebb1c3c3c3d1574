// Counts how many of the floating objects that a config asks for find a place in furnished rooms,
// and how many of them the rigs see. Prints one JSON line.
//   floating_check [--scenes 20] [--first 1] [--each]
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "common/base/rng.h"
#include "common/config/config.h"
#include "common/math/proto.h"
#include "worker/geometry/ray_scene.h"
#include "worker/scene/build_geometry.h"
#include "worker/scene/solve_scene.h"

namespace parallax {
namespace {

struct Options {
  int scenes = 20;
  uint64_t first = 1;
  bool each = false;
};

constexpr int kProbesX = 48, kProbesY = 27;
constexpr double kSeen = 0.002;  // Part of the view from which on a thing counts as seen.

struct View {
  int seen = 0;
  double covered = 0, largest = 0;
};

View Look(const RayScene& solid, const std::vector<bool>& floats, const v1::Rig& rig) {
  const Pose pose = FromProto(rig.world_from_left());
  std::map<uint32_t, int> hits;
  for (int i = 0; i < kProbesX * kProbesY; ++i) {
    const double x = (i % kProbesX + 0.5) / kProbesX * rig.width_px();
    const double y = (i / kProbesX + 0.5) / kProbesY * rig.height_px();
    const Vec3d ray((x - rig.cx_px()) / rig.fx_px(), (y - rig.cy_px()) / rig.fy_px(), 1);
    const auto hit =
        solid.Intersect(pose.translation.cast<float>(), (pose.rotation * ray).cast<float>());
    if (hit && floats[hit->body]) ++hits[hit->body];
  }
  View view;
  for (const auto& [body, count] : hits) {
    const double share = static_cast<double>(count) / (kProbesX * kProbesY);
    view.seen += share >= kSeen;
    view.covered += share;
    view.largest = std::max(view.largest, share);
  }
  return view;
}

int Main(const Options& options) {
  double drawn = 0, placed = 0, seen = 0, covered = 0, views = 0, empty = 0, filled = 0;
  double largest = 0;
  for (int i = 0; i < options.scenes; ++i) {
    v1::SolveJob job;
    job.set_scene_seed(options.first + static_cast<uint64_t>(i));
    *job.mutable_config() = DefaultSceneConfig();
    const auto result = Solve(job, CancelToken());
    if (!result.ok() || !result->has_scene()) continue;
    const Rng root(SceneSeed{job.scene_seed()}, "dress/floating");
    const long wanted =
        std::lround(Draw(job.config().floating().count(), root.Child("count").Uniform()));
    const v1::Scene& scene = result->scene();
    const SceneGeometry geometry = BuildSceneGeometry(scene).value();
    RayScene solid;
    std::vector<bool> floats;
    std::map<uint32_t, bool> role;
    for (const auto& o : scene.objects()) {
      role[o.index()] = o.role() == v1::OBJECT_ROLE_FLOATING;
    }
    for (const PlacedMesh& placed_mesh : geometry.meshes) {
      solid.Add(*placed_mesh.mesh, placed_mesh.world_from_object);
      floats.push_back(role[placed_mesh.object_index]);
    }
    solid.Commit();
    const double found = static_cast<double>(std::count(floats.begin(), floats.end(), true));
    double scene_seen = 0;
    for (const v1::Rig& rig : scene.rigs()) {
      const View view = Look(solid, floats, rig);
      scene_seen += view.seen;
      covered += view.covered;
      largest += view.largest;
      empty += view.seen == 0;
      filled += view.covered > 0.75;
      ++views;
    }
    seen += scene_seen;
    drawn += static_cast<double>(wanted);
    placed += found;
    if (options.each) {
      std::printf("seed %llu: %ld drawn, %.0f placed, %.1f seen a view\n",
                  static_cast<unsigned long long>(job.scene_seed()), wanted, found,
                  scene_seen / scene.rigs_size());
    }
  }
  const nlohmann::json line = {{"bench", "floating_check"},
                               {"scenes", options.scenes},
                               {"drawn_mean", drawn / options.scenes},
                               {"placed_share", placed / std::max(drawn, 1.0)},
                               {"seen_mean", seen / views},
                               {"covered_mean", covered / views},
                               {"largest_mean", largest / views},
                               {"views_without", empty / views},
                               {"views_filled", filled / views}};
  std::printf("%s\n", line.dump().c_str());
  return 0;
}

}  // namespace
}  // namespace parallax

int main(int argc, char** argv) {
  parallax::Options options;
  CLI::App app("Counts floating objects: drawn, placed, seen");
  app.add_option("--scenes", options.scenes);
  app.add_option("--first", options.first, "Seed of the first");
  app.add_flag("--each", options.each, "Also a line a scene");
  CLI11_PARSE(app, argc, argv);
  return parallax::Main(options);
}
