// dense_preview OUT_DIR [--keyframes N] [--objects N] [--seed N] [--size WxH] [--profile NAME]
// [--bounces N]:
// solves a dense scene, renders N keyframes, writes their left images and disparity, and one JSON
// line of what solve, build and render took (core-seconds of all threads).
#include <sys/resource.h>

#include <cstdio>
#include <cstring>
#include <filesystem>
#include <iostream>
#include <nlohmann/json.hpp>

#include "common/config/config.h"
#include "common/image/io.h"
#include "worker/dataset/sheets/drawing.h"
#include "worker/render/renderer.h"
#include "worker/scene/build_geometry.h"
#include "worker/scene/solve_scene.h"

namespace parallax {
namespace {

double CpuSeconds() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

int Fail(const absl::Status& status) {
  std::cerr << status << "\n";
  return 1;
}

int Main(int argc, char** argv) {
  if (argc < 2) {
    std::cerr << "usage: dense_preview OUT_DIR [--keyframes N] [--objects N] [--seed N] "
                 "[--size WxH] [--profile NAME] [--bounces N]\n";
    return 2;
  }
  const std::string out = argv[1];
  int keyframes = 20;
  v1::SolveJob job;
  job.set_scene_seed(1);
  v1::SceneConfig& config = *job.mutable_config();
  config = LoadSceneConfig("dense").value();
  for (int i = 2; i + 1 < argc; i += 2) {
    const std::string name = argv[i];
    if (name == "--keyframes") keyframes = std::atoi(argv[i + 1]);
    if (name == "--objects") {
      config.mutable_floating()->mutable_count()->set_constant(std::atoi(argv[i + 1]));
    }
    if (name == "--seed") job.set_scene_seed(std::strtoull(argv[i + 1], nullptr, 10));
    if (name == "--profile") config.mutable_render()->set_profile(argv[i + 1]);
    if (name == "--bounces") config.mutable_render()->set_max_bounces(std::atoi(argv[i + 1]));
    if (name == "--size") {
      int width = 0, height = 0;
      if (std::sscanf(argv[i + 1], "%dx%d", &width, &height) != 2) return 2;
      config.mutable_rigs()->set_width_px(width);
      config.mutable_rigs()->set_height_px(height);
    }
  }
  config.mutable_rigs()->set_count(1);
  double start = CpuSeconds();
  if (const auto one = Solve(job, CancelToken()); !one.ok()) return Fail(one.status());
  const double one_s = CpuSeconds() - start;
  config.mutable_rigs()->set_count(keyframes);
  start = CpuSeconds();
  const auto solved = Solve(job, CancelToken());
  if (!solved.ok()) return Fail(solved.status());
  const double solve_s = CpuSeconds() - start;
  const v1::Scene& scene = solved->scene();

  start = CpuSeconds();
  auto geometry = BuildSceneGeometry(scene);
  if (!geometry.ok()) return Fail(geometry.status());
  size_t triangles = 0;
  for (const PlacedMesh& placed : geometry->meshes) triangles += placed.mesh->triangles.size();
  auto renderer = Renderer::Create(scene, *std::move(geometry), config.render());
  if (!renderer.ok()) return Fail(renderer.status());
  const double build_s = CpuSeconds() - start;

  std::filesystem::create_directories(out);
  start = CpuSeconds();
  for (const v1::Rig& rig : scene.rigs()) {
    const auto frame = (*renderer)->RenderRig(rig, CancelToken(), {});
    if (!frame.ok()) return Fail(frame.status());
    char name[32];
    std::snprintf(name, sizeof(name), "/%03u", rig.index());
    if (!WritePng(out + name + "_left.png", frame->left.color).ok()) return 1;
    if (!WritePng(out + name + "_disparity.png", ColorDisparity(frame->left.disparity_px, 80))
             .ok()) {
      return 1;
    }
  }
  const double render_s = CpuSeconds() - start;
  const nlohmann::ordered_json json = {
      {"bench", "dense_preview"},
      {"objects", scene.objects_size()},
      {"triangles", triangles},
      {"keyframes", keyframes},
      {"width", config.rigs().width_px()},
      {"height", config.rigs().height_px()},
      {"profile", config.render().profile()},
      {"recipe_bytes", scene.ByteSizeLong()},
      {"objects_s", one_s},
      {"keyframe_s", keyframes > 1 ? (solve_s - one_s) / (keyframes - 1) : 0},
      {"solve_s", solve_s},
      {"build_s", build_s},
      {"render_s", render_s},
      {"core_seconds_per_pair", (solve_s + build_s + render_s) / keyframes}};
  std::cout << json.dump() << "\n";
  return 0;
}

}  // namespace
}  // namespace parallax

int main(int argc, char** argv) { return parallax::Main(argc, argv); }
