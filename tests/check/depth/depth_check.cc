// How deep the scenes of a study's variants are: shares of disparities, quartiles of disparity and
// depth, and what solving and building cost. From exact first hits.
//   depth_check depth [--scenes 6] [--rigs 10] [--only halls] [--json] [--pictures DIR]
// Prints a table in Markdown, or one JSON line a variant. --pictures renders left views, too.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <iostream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "common/base/system/clock.h"
#include "common/config/config.h"
#include "common/image/io.h"
#include "common/math/proto.h"
#include "worker/render/camera/camera.h"
#include "worker/render/renderer.h"
#include "worker/render/scene/render_scene.h"
#include "worker/render/truth/ground_truth.h"
#include "worker/scene/build_geometry.h"
#include "worker/scene/solve_scene.h"

namespace parallax {
namespace {

constexpr double kLimits_px[] = {4, 8, 15, 30, 60, 120};
constexpr int kCoarser = 4;  // Takes every fourth pixel along both sides.

struct Options {
  std::string study = "depth", only, pictures;
  int scenes = 6, rigs = 10;
  uint64_t first = 1;
  bool json = false;
};

struct Figures {
  std::vector<float> disparity_px, depth_m;  // At the left view's pixels that see a surface.
  int64_t pixels = 0;
  int scenes = 0, rejected = 0, views = 0;
  double solve_s = 0, build_s = 0, objects = 0;
};

double Now() {
  return std::chrono::duration<double>(Clock::System().Steady().time_since_epoch()).count();
}

// `rig` with fewer pixels of the same view.
v1::Rig Coarse(v1::Rig rig) {
  rig.set_width_px(rig.width_px() / kCoarser);
  rig.set_height_px(rig.height_px() / kCoarser);
  rig.set_fx_px(rig.fx_px() / kCoarser);
  rig.set_fy_px(rig.fy_px() / kCoarser);
  rig.set_cx_px(rig.cx_px() / kCoarser);
  rig.set_cy_px(rig.cy_px() / kCoarser);
  return rig;
}

absl::Status AddView(const RenderScene& scene, const v1::Rig& full, Figures& figures) {
  const v1::Rig rig = Coarse(full);
  ASSIGN_OR_RETURN(const StereoCamera camera, StereoCamera::FromRig(rig));
  View view;
  RETURN_IF_ERROR(TraceGroundTruth(scene, camera.eyes[0], rig.baseline_m(), CancelToken(), &view));
  for (int y = 0; y < rig.height_px(); ++y) {
    for (int x = 0; x < rig.width_px(); ++x) {
      ++figures.pixels;
      if (!(view.depth_m(x, y) > 0)) continue;
      figures.depth_m.push_back(view.depth_m(x, y));
      figures.disparity_px.push_back(kCoarser * view.disparity_px(x, y));
    }
  }
  ++figures.views;
  return absl::OkStatus();
}

// Writes the left view of each rig as DIR/<name>_<rig>.png.
absl::Status Photograph(const Options& options, const v1::SceneConfig& config,
                        const v1::Scene& recipe, const std::string& name) {
  ASSIGN_OR_RETURN(SceneGeometry geometry, BuildSceneGeometry(recipe));
  ASSIGN_OR_RETURN(const auto renderer,
                   Renderer::Create(recipe, std::move(geometry), config.render()));
  for (int i = 0; i < std::min(options.rigs, recipe.rigs_size()); ++i) {
    ASSIGN_OR_RETURN(const StereoFrame frame,
                     renderer->RenderRig(recipe.rigs(i), CancelToken(), [](double) {}));
    const std::string file = options.pictures + "/" + name + "_" + std::to_string(i) + ".png";
    RETURN_IF_ERROR(WritePng(file, frame.left.color));
  }
  return absl::OkStatus();
}

absl::Status AddScene(const Options& options, const v1::VariantSpec& variant, uint64_t seed,
                      Figures& figures) {
  const v1::SceneConfig& config = variant.config();
  v1::SolveJob job;
  job.set_scene_seed(seed);
  *job.mutable_config() = config;
  double begin = Now();
  ASSIGN_OR_RETURN(const v1::SolveResult solved, Solve(job, CancelToken()));
  if (!solved.has_scene()) {
    ++figures.rejected;
    return absl::OkStatus();
  }
  figures.solve_s += Now() - begin;
  const v1::Scene& recipe = solved.scene();
  begin = Now();
  ASSIGN_OR_RETURN(SceneGeometry geometry, BuildSceneGeometry(recipe));
  const bool moves = recipe.keyframes_size() > 0;
  ASSIGN_OR_RETURN(const auto scene, RenderScene::Build(std::move(geometry), 0, moves));
  figures.build_s += Now() - begin;
  figures.objects += recipe.objects_size();
  ++figures.scenes;
  for (int i = 0; i < std::min(options.rigs, recipe.rigs_size()); ++i) {
    if (moves) {
      std::vector<Eigen::Affine3f> places;
      for (int k = 0; k < recipe.objects_size(); ++k) {
        places.push_back(KeyframePose(recipe.keyframes(i), k).Affine());
      }
      RETURN_IF_ERROR(scene->Move(places));
    }
    RETURN_IF_ERROR(AddView(*scene, recipe.rigs(i), figures));
  }
  if (options.pictures.empty()) return absl::OkStatus();
  return Photograph(options, config, recipe, variant.name() + "_" + std::to_string(seed));
}

double Quantile(std::vector<float>& values, double share) {
  if (values.empty()) return 0;
  const auto at =
      values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return double{*at};
}

double ShareBelow(const std::vector<float>& values, double limit) {
  const auto below =
      std::count_if(values.begin(), values.end(), [&](float v) { return double{v} < limit; });
  return static_cast<double>(below) / static_cast<double>(std::max<size_t>(values.size(), 1));
}

void Print(const Options& options, const std::string& name, Figures& f) {
  nlohmann::ordered_json line = {{"check", "depth"},
                                 {"variant", name},
                                 {"scenes", f.scenes},
                                 {"views", f.views},
                                 {"rejected", f.rejected}};
  std::string row = "| " + name;
  char text[48];
  const auto add = [&](const char* key, const char* format, double value) {
    std::snprintf(text, sizeof text, format, value);
    row += std::string(" | ") + text;
    line[key] = value;
  };
  for (const double limit : kLimits_px) {
    const std::string key = "below_" + std::to_string(static_cast<int>(limit)) + "_px";
    add(key.c_str(), "%.1f", 100 * ShareBelow(f.disparity_px, limit));
  }
  add("disparity_q1", "%.1f", Quantile(f.disparity_px, 0.25));
  add("disparity_median", "%.1f", Quantile(f.disparity_px, 0.5));
  add("disparity_q3", "%.1f", Quantile(f.disparity_px, 0.75));
  add("depth_q1", "%.2f", Quantile(f.depth_m, 0.25));
  add("depth_median", "%.2f", Quantile(f.depth_m, 0.5));
  add("depth_q3", "%.2f", Quantile(f.depth_m, 0.75));
  add("sky", "%.1f",
      100 * (1 - static_cast<double>(f.depth_m.size()) /
                     static_cast<double>(std::max<int64_t>(f.pixels, 1))));
  const double scenes = std::max(f.scenes, 1);
  add("solve_s", "%.2f", f.solve_s / scenes);
  add("build_s", "%.2f", f.build_s / scenes);
  add("objects", "%.0f", f.objects / scenes);
  std::cout << (options.json ? line.dump() : row + " |") << std::endl;
}

absl::Status Run(const Options& options) {
  ASSIGN_OR_RETURN(const v1::StudySpec study, LoadStudy(options.study));
  if (!options.json) {
    std::cout
        << "| variant | < 4 px, % | < 8 | < 15 | < 30 | < 60 | < 120 | disparity Q1, px | "
           "median | Q3 | depth Q1, m | median | Q3 | sky, % | solve, s | build, s | "
           "objects |\n|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|\n";
  }
  for (const v1::VariantSpec& variant : study.variants()) {
    if (!options.only.empty() && variant.name() != options.only) continue;
    Figures figures;
    for (int i = 0; i < options.scenes; ++i) {
      RETURN_IF_ERROR(
          AddScene(options, variant, options.first + static_cast<uint64_t>(i), figures));
    }
    Print(options, variant.name(), figures);
  }
  return absl::OkStatus();
}

}  // namespace
}  // namespace parallax

int main(int argc, char** argv) {
  parallax::Options options;
  CLI::App app("Measures disparities and depths of a study's variants");
  app.add_option("study", options.study, "File or built-in name");
  app.add_option("--scenes", options.scenes, "Of each variant");
  app.add_option("--rigs", options.rigs, "Of each scene, at most");
  app.add_option("--first", options.first, "Seed of the first scene");
  app.add_option("--only", options.only, "This variant alone");
  app.add_option("--pictures", options.pictures, "An existing folder for rendered left views");
  app.add_flag("--json", options.json, "A JSON line a variant");
  CLI11_PARSE(app, argc, argv);
  const absl::Status status = parallax::Run(options);
  if (!status.ok()) std::cerr << status << "\n";
  return status.ok() ? 0 : 1;
}
