// Measures the time to solve a scene and to make its meshes. Prints one JSON line.
// Usage: bench_solve [--scenes N] [--seed S] [--mode full|reduced|best] [--kind KIND] [--rooms N]
// Without options: furnished dining rooms by the full 550 steps.
#include <sys/resource.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <ctime>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "common/base/seconds.h"
#include "common/base/system/clock.h"
#include "common/config/config.h"
#include "worker/scene/build_geometry.h"
#include "worker/scene/solve_scene.h"

namespace parallax {
namespace {

struct Options {
  int scenes = 8;
  uint64_t seed = 1;
  int rooms = 1, steps = 0;
  double budget_s = 10;
  std::string mode = "full", kind = "dining_room";
  bool each = false;
};

double Median(std::vector<double> values) {
  if (values.empty()) return 0;
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

double PeakMb() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024;
}

// CPU time of this process, which a busy machine does not distort.
double CpuSeconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

int Main(const Options& options) {
  v1::SolveJob job;
  v1::SceneConfig& config = *job.mutable_config();
  config = DefaultSceneConfig();
  config.mutable_solver()->set_mode(options.mode == "full"   ? v1::SolverConfig::MODE_FULL
                                    : options.mode == "best" ? v1::SolverConfig::MODE_BEST
                                                             : v1::SolverConfig::MODE_REDUCED);
  config.mutable_solver()->set_steps(options.steps);
  config.mutable_solver()->set_budget_s(options.budget_s);
  config.mutable_room()->mutable_rooms()->set_constant(options.rooms);
  if (options.kind != "any") {
    config.mutable_room()->clear_kinds();
    config.mutable_room()->add_kinds(options.kind);
  }
  std::vector<double> layout_s, dress_s, cpu_s, mesh_s, mesh_cpu_s, objects, furniture, triangles,
      loss, rooms;
  int rejected = 0;
  double violations = 0, evaluated = 0, possible = 0;
  for (int i = 0; i < options.scenes; ++i) {
    job.set_scene_seed(options.seed + static_cast<uint64_t>(i));
    const double cpu_start = CpuSeconds();
    const auto result = Solve(job, CancelToken());
    cpu_s.push_back(CpuSeconds() - cpu_start);
    if (!result.ok()) {
      std::fprintf(stderr, "%s\n", result.status().ToString().c_str());
      return 1;
    }
    layout_s.push_back(result->layout_s());
    dress_s.push_back(result->dress_s());
    const v1::Layout& layout = result->layout();
    double scene_loss = layout.report().final_loss();
    const auto add = [&](const v1::SolveReport& report) {
      for (const auto& c : report.constraints()) violations += c.hard() ? c.violation() : 0;
      evaluated += static_cast<double>(report.terms_evaluated());
      possible += static_cast<double>(report.terms_total());
    };
    add(layout.report());
    for (const auto& report : layout.room_reports()) {
      add(report);
      scene_loss += report.final_loss();
    }
    loss.push_back(scene_loss);
    rooms.push_back(layout.place().house().rooms_size());
    if (result->has_rejected()) {
      ++rejected;
      continue;
    }
    const SteadyTime start = Clock::System().Steady();
    const double mesh_start = CpuSeconds();
    const SceneGeometry geometry = BuildSceneGeometry(result->scene()).value();
    mesh_s.push_back(SecondsSince(start));
    mesh_cpu_s.push_back(CpuSeconds() - mesh_start);
    objects.push_back(result->scene().objects_size());
    double count = 0, own = 0;
    for (const PlacedMesh& placed : geometry.meshes) {
      count += static_cast<double>(placed.mesh->triangles.size());
    }
    for (const auto& object : result->scene().objects()) {
      own += object.role() == v1::OBJECT_ROLE_FURNITURE;
    }
    triangles.push_back(count);
    furniture.push_back(own);
    if (options.each) {
      std::printf(
          "seed %llu: %.0f rooms, %d objects, %.0f of furniture, loss %.2f, CPU %.2f s + %.2f s\n",
          static_cast<unsigned long long>(job.scene_seed()), rooms.back(),
          result->scene().objects_size(), own, loss.back(), cpu_s.back(), mesh_cpu_s.back());
    }
  }
  std::vector<double> solve_s;
  for (size_t i = 0; i < layout_s.size(); ++i) solve_s.push_back(layout_s[i] + dress_s[i]);
  const nlohmann::json line = {{"bench", "solve"},
                               {"mode", options.mode},
                               {"kind", options.kind},
                               {"rooms", Median(rooms)},
                               {"scenes", options.scenes},
                               {"rejected", rejected},
                               {"solve_s", Median(solve_s)},
                               {"solve_max_s", *std::max_element(solve_s.begin(), solve_s.end())},
                               {"solve_cpu_s", Median(cpu_s)},
                               {"solve_cpu_max_s", *std::max_element(cpu_s.begin(), cpu_s.end())},
                               {"mesh_cpu_s", Median(mesh_cpu_s)},
                               {"layout_s", Median(layout_s)},
                               {"dress_s", Median(dress_s)},
                               {"mesh_s", Median(mesh_s)},
                               {"objects", Median(objects)},
                               {"furniture", Median(furniture)},
                               {"triangles", Median(triangles)},
                               {"final_loss", Median(loss)},
                               {"violations", violations},
                               {"terms_evaluated_share", possible > 0 ? evaluated / possible : 0},
                               {"peak_mb", PeakMb()}};
  std::printf("%s\n", line.dump().c_str());
  return 0;
}

}  // namespace
}  // namespace parallax

int main(int argc, char** argv) {
  parallax::Options options;
  CLI::App app("Times solving and meshing of indoor scenes; prints one JSON line");
  app.add_option("--scenes", options.scenes);
  app.add_option("--seed", options.seed);
  app.add_option("--mode", options.mode)->check(CLI::IsMember({"full", "reduced", "best"}));
  app.add_option("--steps", options.steps, "0: the mode's own");
  app.add_option("--budget", options.budget_s, "Seconds a room, of mode best");
  app.add_option("--kind", options.kind, "Of the main room; any: as the config draws");
  app.add_option("--rooms", options.rooms, "Of the house")->check(CLI::Range(1, 8));
  app.add_flag("--each", options.each, "Also a line a scene");
  CLI11_PARSE(app, argc, argv);
  return parallax::Main(options);
}
