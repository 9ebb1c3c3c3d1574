// Measures the renderer on one scene; prints one JSON line.
//   bench_render [SCENE.pb | solve:SEED] [--profile default] [--pairs 2] [--size 1280x720]
#include <sys/resource.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>

#include "tests/bench/render/load_scene.h"
#include "worker/render/renderer.h"

namespace parallax {
namespace {

double CpuSeconds() {
  rusage usage;
  getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

absl::Status Run(int argc, char** argv, int* exit_code) {
  std::string scene_path, profile = "default";
  uint64_t seed = 1;
  int pairs = 2, samples = 0;
  CLI::App app("Measure core-seconds a stereo pair");
  app.add_option("scene", scene_path, "recipe (.pb) or solve:SEED[:CONFIG]; absent: the demo room");
  app.add_option("--seed", seed, "of the demo room");
  app.add_option("--profile", profile);
  app.add_option("--spp", samples);
  app.add_option("--pairs", pairs, "rigs to render");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    *exit_code = app.exit(error);
    return absl::OkStatus();
  }
  ASSIGN_OR_RETURN(bench::LoadedScene scene, bench::LoadScene(scene_path, seed));
  size_t triangles = 0;
  for (const PlacedMesh& placed : scene.geometry.meshes) triangles += placed.mesh->triangles.size();
  v1::RenderConfig config;
  config.set_profile(profile);
  config.set_samples_per_pixel(samples);

  const double build_start = CpuSeconds();
  ASSIGN_OR_RETURN(const auto renderer,
                   Renderer::Create(scene.recipe, std::move(scene.geometry), config));
  const double build_core_s = CpuSeconds() - build_start;

  pairs = std::min(pairs, scene.recipe.rigs_size());
  double trace_s = 0, truth_s = 0, denoise_s = 0;
  uint64_t rays = 0;
  const double start = CpuSeconds();
  const auto wall_start = std::chrono::steady_clock::now();
  for (int i = 0; i < pairs; ++i) {
    ASSIGN_OR_RETURN(const StereoFrame frame, renderer->RenderRig(scene.recipe.rigs(i), {}, {}));
    trace_s += frame.trace_s;
    truth_s += frame.truth_s;
    denoise_s += frame.denoise_s;
    rays += frame.rays;
  }
  const double core_s = CpuSeconds() - start;
  const double wall_s =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - wall_start).count();
  const double n = std::max(pairs, 1);
  rusage usage;
  getrusage(RUSAGE_SELF, &usage);
  std::printf(
      "{\"bench\": \"render\", \"profile\": \"%s\", \"pairs\": %d, \"triangles\": %zu, "
      "\"core_s_per_pair\": %.2f, \"wall_s_per_pair\": %.2f, \"trace_s\": %.2f, \"truth_s\": %.2f, "
      "\"denoise_s\": %.2f, \"build_core_s\": %.2f, \"mrays_per_s\": %.2f, \"rays_per_pair\": "
      "%.0f, "
      "\"peak_mb\": %ld}\n",
      profile.c_str(), pairs, triangles, core_s / n, wall_s / n, trace_s / n, truth_s / n,
      denoise_s / n, build_core_s, static_cast<double>(rays) / trace_s * 1e-6,
      static_cast<double>(rays) / n, usage.ru_maxrss / 1024);
  return absl::OkStatus();
}

}  // namespace
}  // namespace parallax

int main(int argc, char** argv) {
  int exit_code = 0;
  const absl::Status status = parallax::Run(argc, argv, &exit_code);
  if (status.ok()) return exit_code;
  std::fprintf(stderr, "bench_render: %s\n", std::string(status.message()).c_str());
  return 1;
}
