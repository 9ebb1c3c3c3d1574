// A scene of very many triangles: memory and time to build it and to render a small pair; one JSON
// line.
//   bench_scale [--triangles 20] [--instances 1] [--limit-mb 4096]
// `--triangles` in millions, all different; `--instances` places each mesh so many times. A scene
// beyond the limit must end with an error, status 3.
#include <sys/resource.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>

#include "common/base/system/memory_budget.h"
#include "tests/bench/program_main.h"
#include "tests/worker/render/test_scenes.h"
#include "worker/render/renderer.h"
#include "worker/render/surface/sampler.h"

namespace parallax {
namespace {

double Seconds(const timeval& t) {
  return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
}

rusage Usage() {
  rusage usage;
  getrusage(RUSAGE_SELF, &usage);
  return usage;
}

double CpuSeconds() {
  const rusage usage = Usage();
  return Seconds(usage.ru_utime) + Seconds(usage.ru_stime);
}

// A ball with bumps of its own.
std::shared_ptr<const Mesh> Bumpy(uint32_t seed, int rings) {
  auto mesh = std::make_shared<Mesh>(*test::MakeSphere(Vec3f::Zero(), 0.4f, rings));
  for (size_t i = 0; i < mesh->positions.size(); ++i) {
    const uint32_t hash = CombineHash(seed, static_cast<uint32_t>(i));
    mesh->positions[i] *= 1.0f + 2e-3f * static_cast<float>(hash >> 8) * 0x1p-24f;
  }
  return mesh;
}

absl::Status Run(int argc, char** argv, int* exit_code) {
  double millions = 20;
  int instances = 1, rings = 500;
  int64_t limit_mb = 4096;
  CLI::App app("Memory and time of a scene of very many triangles");
  app.add_option("--triangles", millions, "different ones, in millions");
  app.add_option("--instances", instances, "places of each mesh")->check(CLI::Range(1, 1000));
  app.add_option("--rings", rings, "of each ball: 4 rings^2 triangles")->check(CLI::Range(4, 2000));
  app.add_option("--limit-mb", limit_mb, "memory the process may use; 0: the machine's");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    *exit_code = app.exit(error);
    return absl::OkStatus();
  }
  SetMemoryLimit(limit_mb << 20);

  test::TestScene scene = test::MakeBoxRoom();
  const uint32_t grey = scene.AddMaterial(test::DiffuseSample(Vec3f::Constant(0.5f)));
  size_t unique = 0, placed = 0;
  for (uint32_t k = 0; static_cast<double>(unique) < millions * 1e6; ++k) {
    const auto mesh = Bumpy(k, rings);
    unique += mesh->triangles.size();
    for (int i = 0; i < instances; ++i) {
      const uint32_t spot = CombineHash(k, static_cast<uint32_t>(i));
      const auto along = [&](int shift, float low, float high) {
        return low + (high - low) * static_cast<float>((spot >> shift) & 0x3ff) / 1023.0f;
      };
      Eigen::Affine3f at = Eigen::Affine3f::Identity();
      at.translate(Vec3f(along(0, 0.5f, 3.5f), along(10, 1.5f, 3.5f), along(20, 0.5f, 2.5f)));
      scene.AddMesh(mesh, grey, at);
      placed += mesh->triangles.size();
    }
  }
  const long meshes_mb = Usage().ru_maxrss / 1024;
  const double start = CpuSeconds();
  absl::StatusOr<std::unique_ptr<Renderer>> renderer =
      Renderer::Create(scene.recipe, std::move(scene.geometry), test::MakeConfig(2, 2, false));
  if (!renderer.ok()) {
    *exit_code = 3;
    return renderer.status();
  }
  const double build_s = CpuSeconds() - start;
  const long build_mb = Usage().ru_maxrss / 1024;
  ASSIGN_OR_RETURN(const StereoFrame frame,
                   (*renderer)->RenderRig(test::BoxRoomRig(320, 180), {}, {}));
  std::printf(
      "{\"bench\": \"scale\", \"triangles\": %zu, \"triangles_placed\": %zu, \"meshes_mb\": %ld, "
      "\"build_peak_mb\": %ld, \"peak_mb\": %ld, \"build_core_s\": %.1f, \"trace_s\": %.2f, "
      "\"mrays_per_s\": %.2f}\n",
      unique, placed, meshes_mb, build_mb, Usage().ru_maxrss / 1024, build_s, frame.trace_s,
      static_cast<double>(frame.rays) / frame.trace_s * 1e-6);
  return absl::OkStatus();
}

}  // namespace
}  // namespace parallax

int main(int argc, char** argv) {
  return parallax::ProgramMain("bench_scale", parallax::Run, argc, argv);
}
