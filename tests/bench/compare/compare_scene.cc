// Our side of the comparisons with other renderers.
//   compare_scene prepare solve:7 OUT --size 480x270      recipe.pb with scaled rigs
//   compare_scene export OUT/recipe.pb OUT                arrays and scene.json (export_scene.h)
//   compare_scene render OUT/recipe.pb OUT --rigs 20      pictures by a profile; its cost as JSON
//   compare_scene radiance OUT/recipe.pb OUT --rig 0      linear float32 of the reference
//                                                         integrator
//   compare_scene denoise COLOR ALBEDO NORMAL OUT --size  raw float32 in and out
// All but `prepare` and `denoise` replace the materials as --flavour says (plain_materials.h).
#include <sys/resource.h>
#include <tbb/parallel_for.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "common/base/status.h"
#include "common/image/io.h"
#include "tests/bench/compare/export_scene.h"
#include "tests/bench/compare/plain_materials.h"
#include "tests/bench/program_main.h"
#include "tests/bench/render/load_scene.h"
#include "worker/render/camera/camera_rays.h"
#include "worker/render/film/denoiser.h"
#include "worker/render/lights/light_table.h"
#include "worker/render/paths/path_tracer.h"
#include "worker/render/renderer.h"

namespace parallax {
namespace {

struct Options {
  std::string scene, out, flavour = "principled", profile = "default", size = "480x270", source;
  std::vector<std::string> files;  // Inputs of `denoise`: color, albedo, normal.
  int rigs = 20, rig = 0, eye = 0, samples = 0, bounces = 0, threads = 0;
  uint64_t noise = 0;
  std::vector<int> write;
  std::vector<std::string> lights;  // Kinds that `prepare` keeps; none: all.
};

double CpuSeconds() {
  rusage usage;
  getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

absl::StatusOr<std::pair<int, int>> ParseSize(const std::string& text) {
  int width = 0, height = 0;
  if (std::sscanf(text.c_str(), "%dx%d", &width, &height) != 2 || width <= 0 || height <= 0) {
    return InvalidArgument("--size {}: wants WIDTHxHEIGHT", text);
  }
  return std::pair(width, height);
}

absl::Status WriteFloats(const std::string& path, const ImageF3& image) {
  std::ofstream file(path, std::ios::binary);
  file.write(reinterpret_cast<const char*>(image.data()),
             static_cast<std::streamsize>(image.values().size() * sizeof(float)));
  return file ? absl::OkStatus() : Unavailable("cannot write {}", path);
}

absl::StatusOr<ImageF3> ReadFloats(const std::string& path, int width, int height) {
  ImageF3 image(width, height);
  std::ifstream file(path, std::ios::binary);
  file.read(reinterpret_cast<char*>(image.data()),
            static_cast<std::streamsize>(image.values().size() * sizeof(float)));
  if (!file) return NotFound("cannot read {}", path);
  return image;
}

// Leaves the lights of the named kinds, so that what differs can be told apart.
absl::Status KeepLights(const std::vector<std::string>& kinds, v1::Scene* scene) {
  bool point = false, spot = false, mesh = false, sky = false, sun = false;
  for (const std::string& kind : kinds) {
    if (kind != "point" && kind != "spot" && kind != "mesh" && kind != "sky" && kind != "sun") {
      return InvalidArgument("--lights {}; allowed: point, spot, mesh, sky, sun", kind);
    }
    point |= kind == "point";
    spot |= kind == "spot";
    mesh |= kind == "mesh";
    sky |= kind == "sky";
    sun |= kind == "sun";
  }
  for (v1::Light& light : *scene->mutable_lights()) {
    const bool kept = light.kind() == v1::Light::KIND_POINT  ? point
                      : light.kind() == v1::Light::KIND_SPOT ? spot
                                                             : mesh;
    if (!kept) light.clear_power_w();
  }
  if (!sun) scene->mutable_sky()->set_sun_strength(0);
  if (!sky && !sun) scene->mutable_sky()->set_strength(0);  // A sun has its sky.
  return absl::OkStatus();
}

// The recipe with pictures of another size: the same view.
absl::Status Prepare(const Options& options) {
  ASSIGN_OR_RETURN(const auto size, ParseSize(options.size));
  ASSIGN_OR_RETURN(bench::LoadedScene scene, bench::LoadScene(options.scene, 1));
  for (v1::Rig& rig : *scene.recipe.mutable_rigs()) {
    const double sx = static_cast<double>(size.first) / rig.width_px();
    const double sy = static_cast<double>(size.second) / rig.height_px();
    rig.set_fx_px(rig.fx_px() * sx);
    rig.set_cx_px(rig.cx_px() * sx);
    rig.set_fy_px(rig.fy_px() * sy);
    rig.set_cy_px(rig.cy_px() * sy);
    rig.set_width_px(size.first);
    rig.set_height_px(size.second);
  }
  // Ideal points: no other renderer has spheres that only light sees.
  for (v1::Light& light : *scene.recipe.mutable_lights()) light.set_radius_m(0);
  if (!options.lights.empty()) RETURN_IF_ERROR(KeepLights(options.lights, &scene.recipe));
  std::filesystem::create_directories(options.out);
  std::ofstream file(options.out + "/recipe.pb", std::ios::binary);
  scene.recipe.SerializeToOstream(&file);
  return file ? absl::OkStatus() : Unavailable("cannot write {}", options.out);
}

absl::StatusOr<bench::LoadedScene> LoadPlain(const Options& options) {
  ASSIGN_OR_RETURN(const bench::Flavour flavour, bench::ParseFlavour(options.flavour));
  ASSIGN_OR_RETURN(bench::LoadedScene scene, bench::LoadScene(options.scene, 1));
  bench::MakePlain(flavour, &scene.geometry);
  // Noise of its own for each run that asks for it.
  scene.recipe.set_scene_seed(scene.recipe.scene_seed() ^ (options.noise << 40));
  return scene;
}

absl::Status Export(const Options& options) {
  ASSIGN_OR_RETURN(const bench::LoadedScene scene, LoadPlain(options));
  return bench::ExportScene(scene.recipe, scene.geometry, options.out);
}

absl::Status Render(const Options& options) {
  ASSIGN_OR_RETURN(bench::LoadedScene scene, LoadPlain(options));
  v1::RenderConfig config;
  config.set_profile(options.profile);
  config.set_samples_per_pixel(options.samples);
  config.set_max_bounces(options.bounces);
  ASSIGN_OR_RETURN(const auto renderer,
                   Renderer::Create(scene.recipe, std::move(scene.geometry), config));
  std::filesystem::create_directories(options.out);
  nlohmann::json exposures = nlohmann::json::object();
  const int count = std::min(options.rigs, scene.recipe.rigs_size());
  std::vector<int> rigs;
  for (int i = 0; i < count; ++i) rigs.push_back(i);
  if (options.rigs <= 0) rigs = options.write;  // Only what is asked for.
  for (const int i : rigs) {
    ASSIGN_OR_RETURN(const StereoFrame frame, renderer->RenderRig(scene.recipe.rigs(i), {}, {}));
    if (std::find(options.write.begin(), options.write.end(), i) == options.write.end()) continue;
    const std::string name = options.out + "/" + options.profile + "_" +
                             std::to_string(options.noise) + "_" + std::to_string(i);
    RETURN_IF_ERROR(WritePng(name + "_left.png", frame.left.color));
    RETURN_IF_ERROR(WritePng(name + "_right.png", frame.right.color));
    RETURN_IF_ERROR(WriteFloats(name + ".f32", frame.left.radiance));
    exposures[std::to_string(i)] = frame.exposure;
  }
  rusage usage;
  getrusage(RUSAGE_SELF, &usage);
  std::printf("%s\n", nlohmann::json({{"cpu_s", CpuSeconds()},
                                      {"pairs", rigs.size()},
                                      {"peak_mb", usage.ru_maxrss / 1024},
                                      {"exposures", exposures}})
                          .dump()
                          .c_str());
  return absl::OkStatus();
}

absl::Status Radiance(const Options& options) {
  ASSIGN_OR_RETURN(bench::LoadedScene scene, LoadPlain(options));
  if (options.rig < 0 || options.rig >= scene.recipe.rigs_size()) {
    return InvalidArgument("--rig: the scene has {}", scene.recipe.rigs_size());
  }
  ASSIGN_OR_RETURN(const StereoCamera stereo,
                   StereoCamera::FromRig(scene.recipe.rigs(options.rig)));
  ASSIGN_OR_RETURN(const auto geometry, RenderScene::Build(std::move(scene.geometry), 0));
  ASSIGN_OR_RETURN(const LightTable lights, LightTable::Build(scene.recipe, *geometry));
  const PinholeCamera& camera = stereo.eyes[options.eye];
  PathOptions path;
  path.max_bounces = options.bounces > 0 ? options.bounces : 32;
  const int samples = options.samples > 0 ? options.samples : 64;
  const uint32_t stream =
      SampleStream{scene.recipe.scene_seed(), static_cast<uint32_t>(options.rig),
                   static_cast<uint32_t>(options.eye), 0}
          .Hash();
  ImageF3 image(camera.width_px, camera.height_px);
  tbb::parallel_for(0, camera.height_px, [&](int y) {
    PathTracer tracer(*geometry, lights, path);
    const CameraRays rays(camera);
    std::vector<Path> paths;
    for (int x = 0; x < camera.width_px; ++x) {
      paths.clear();
      for (int s = 0; s < samples; ++s) {
        Sampler sampler(stream, static_cast<uint32_t>(x), static_cast<uint32_t>(y),
                        static_cast<uint32_t>(s));
        const Vec2f jitter = sampler.Pair();
        const Ray ray =
            rays.Through(static_cast<float>(x) + jitter.x(), static_cast<float>(y) + jitter.y());
        paths.emplace_back(sampler, ray);
      }
      tracer.Trace(paths);
      Vec3d sum = Vec3d::Zero();
      for (const Path& traced : paths) sum += traced.result.radiance.cast<double>();
      for (int c = 0; c < 3; ++c) image(x, y, c) = static_cast<float>(sum[c] / samples);
    }
  });
  std::filesystem::create_directories(options.out);
  return WriteFloats(options.out + "/radiance_" + std::to_string(options.noise) + "_" +
                         std::to_string(options.rig) + ".f32",
                     image);
}

absl::Status Denoise(const Options& options) {
  ASSIGN_OR_RETURN(const auto size, ParseSize(options.size));
  ASSIGN_OR_RETURN(ImageF3 color, ReadFloats(options.files[0], size.first, size.second));
  ASSIGN_OR_RETURN(const ImageF3 albedo, ReadFloats(options.files[1], size.first, size.second));
  ASSIGN_OR_RETURN(const ImageF3 normal, ReadFloats(options.files[2], size.first, size.second));
  ASSIGN_OR_RETURN(const auto denoiser, Denoiser::Create(DenoiseQuality::kHigh));
  const double start = CpuSeconds();  // Without loading the weights, which many pictures share.
  RETURN_IF_ERROR(denoiser->Execute({}, albedo, normal, &color));
  std::printf("{\"cpu_s\": %.4f}\n", CpuSeconds() - start);
  return WriteFloats(options.files[3], color);
}

absl::Status Run(int argc, char** argv, int* exit_code) {
  Options options;
  CLI::App app("Our side of the comparisons with other renderers");
  app.require_subcommand(1);
  const auto scene_command = [&](const char* name, const char* help) {
    CLI::App* command = app.add_subcommand(name, help);
    command->add_option("scene", options.scene)->required();
    command->add_option("out", options.out)->required();
    command->add_option("--flavour", options.flavour, "principled, shared or lambert");
    command->add_option("--spp", options.samples);
    command->add_option("--bounces", options.bounces);
    command->add_option("--noise", options.noise, "another number, other noise");
    return command;
  };
  CLI::App* prepare = app.add_subcommand("prepare", "write a recipe with rigs of another size");
  prepare->add_option("scene", options.scene)->required();
  prepare->add_option("out", options.out)->required();
  prepare->add_option("--size", options.size);
  prepare->add_option("--lights", options.lights, "only these: point, spot, mesh, sky, sun")
      ->delimiter(',');
  CLI::App* exporting = scene_command("export", "write arrays and scene.json");
  CLI::App* render = scene_command("render", "render by a profile");
  render->add_option("--profile", options.profile);
  render->add_option("--rigs", options.rigs, "render the first so many; 0: only those of --write");
  render->add_option("--write", options.write, "rigs whose pictures are kept")->delimiter(',');
  CLI::App* radiance = scene_command("radiance", "linear radiance by the reference integrator");
  radiance->add_option("--rig", options.rig);
  radiance->add_option("--eye", options.eye)->check(CLI::Range(0, 1));
  CLI::App* denoise = app.add_subcommand("denoise", "color, albedo, normal, result: raw float32");
  denoise->add_option("files", options.files)->required()->expected(4);
  denoise->add_option("--size", options.size);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    *exit_code = app.exit(error);
    return absl::OkStatus();
  }
  if (prepare->parsed()) return Prepare(options);
  if (exporting->parsed()) return Export(options);
  if (render->parsed()) return Render(options);
  if (radiance->parsed()) return Radiance(options);
  return Denoise(options);
}

}  // namespace
}  // namespace parallax

int main(int argc, char** argv) {
  return parallax::ProgramMain("compare_scene", parallax::Run, argc, argv);
}
