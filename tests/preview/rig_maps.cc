// render: rigs of a scene; color and all maps of both eyes as PNGs to look at, and timing as JSON.
#include <chrono>
#include <cmath>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>

#include "common/base/seconds.h"
#include "common/image/io.h"
#include "tests/bench/render/image_error.h"
#include "tests/bench/render/load_scene.h"
#include "tests/preview/preview.h"
#include "worker/dataset/sheets/drawing.h"
#include "worker/render/renderer.h"

namespace parallax::preview {
namespace {

struct Options {
  std::string scene, out = "preview.out", profile = "default", save, compare;
  std::vector<int> size;
  uint64_t seed = 1;
  int rig = 0, rigs = 0, samples = 0, bounces = 0;
  bool raw = false, no_cache = false;
};

double CpuSeconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

ImageRgb8 ColorDepth(const ImageF& depth_m) {
  return Colored(depth_m, [](const float* z) {
    return *z > 0 ? Turbo(1 - std::log2(static_cast<double>(*z) / 0.25) / 6) : Rgb{};
  });
}

ImageRgb8 ColorMasks(const ImageU8& masks) {
  return Colored(masks, [](const uint8_t* mask) {
    const int m = *mask;
    return Rgb{static_cast<uint8_t>((m & kMaskSky ? 120 : 0) + (m & kMaskExterior ? 130 : 0)),
               static_cast<uint8_t>(m & kMaskTransparent ? 220 : 0),
               static_cast<uint8_t>(m & kMaskMirror ? 220 : 0)};
  });
}

// Writes the picture, its maps, and a sheet of all at half their size.
absl::Status WriteView(const std::string& dir, const std::string& eye, const View& v) {
  const float largest =
      *std::max_element(v.disparity_px.values().begin(), v.disparity_px.values().end());
  const std::pair<std::string, ImageRgb8> pictures[] = {
      {eye, v.color},
      {"disparity_" + eye, ColorDisparity(v.disparity_px, static_cast<double>(largest))},
      {"depth_" + eye, ColorDepth(v.depth_m)},
      {"objects_" + eye, ColorIndices(v.objects)},
      {"materials_" + eye, ColorIndices(v.materials)},
      {"normals_" + eye, ColorNormals(v.normals)},
      {"masks_" + eye, ColorMasks(v.masks)},
      {"occlusion_" + eye, ColorOcclusion(v.occlusion)}};
  const int w = v.color.width() / 2, h = v.color.height() / 2;
  Canvas sheet(3 * w, 3 * h);
  int i = 0;
  for (const auto& [name, picture] : pictures) {
    RETURN_IF_ERROR(WritePng(dir + "/" + name + ".png", picture));
    sheet.DrawImage(i % 3 * w, i / 3 * h, w, h, picture);
    ++i;
  }
  return WritePng(dir + "/sheet_" + eye + ".png", sheet.image());
}

void Resize(v1::Rig& rig, int width, int height) {
  const double scale = static_cast<double>(width) / rig.width_px();
  rig.set_fx_px(rig.fx_px() * scale);
  rig.set_fy_px(rig.fy_px() * scale);
  rig.set_cx_px(0.5 * width);
  rig.set_cy_px(0.5 * height);
  rig.set_width_px(width);
  rig.set_height_px(height);
}

absl::Status Run(const Options& options) {
  const int last = options.rig + std::max(options.rigs, 1);
  ASSIGN_OR_RETURN(const bench::LoadedScene scene,
                   bench::LoadScene(options.scene, options.seed, options.rigs > 0 ? last : 0));
  if (!options.save.empty()) {
    std::ofstream(options.save, std::ios::binary) << scene.recipe.SerializeAsString();
  }
  if (options.rig < 0 || last > scene.recipe.rigs_size()) {
    return InvalidArgument("--rig: the scene has {} rigs", scene.recipe.rigs_size());
  }
  v1::RenderConfig config;
  config.set_profile(options.profile);
  config.set_samples_per_pixel(options.samples);
  config.set_max_bounces(options.bounces);
  if (options.raw) config.set_denoise(v1::RenderConfig::DENOISE_OFF);
  if (options.no_cache) config.set_cache(v1::RenderConfig::CACHE_OFF);
  size_t triangles = 0;
  for (const PlacedMesh& placed : scene.geometry.meshes) {
    triangles += placed.mesh->triangles.size();
  }
  const auto start = std::chrono::steady_clock::now();
  double cpu = CpuSeconds();
  ASSIGN_OR_RETURN(const auto renderer, Renderer::Create(scene.recipe, scene.geometry, config));
  nlohmann::ordered_json json = {{"objects", scene.recipe.objects_size()},
                                 {"triangles", triangles},
                                 {"recipe_bytes", scene.recipe.ByteSizeLong()},
                                 {"solve_core_s", scene.solve_core_s},
                                 {"geometry_s", scene.geometry_s},
                                 {"build_s", SecondsSince(start)},
                                 {"build_core_s", CpuSeconds() - cpu}};
  for (int i = options.rig; i < last; ++i) {
    v1::Rig rig = scene.recipe.rigs(i);
    if (!options.size.empty()) Resize(rig, options.size[0], options.size[1]);
    cpu = CpuSeconds();
    ASSIGN_OR_RETURN(const StereoFrame frame, renderer->RenderRig(rig, {}, {}));
    json.update(nlohmann::ordered_json{{"rig", i},
                                       {"render_core_s", CpuSeconds() - cpu},
                                       {"truth_s", frame.truth_s},
                                       {"trace_s", frame.trace_s},
                                       {"cache_s", frame.cache_s},
                                       {"denoise_s", frame.denoise_s},
                                       {"exposure", frame.exposure},
                                       {"rays", frame.rays}});
    const std::string out =
        options.rigs == 0 ? options.out : fmt::format("{}/{:03}", options.out, i);
    std::filesystem::create_directories(out);
    RETURN_IF_ERROR(WriteView(out, "left", frame.left));
    RETURN_IF_ERROR(WriteView(out, "right", frame.right));
    if (!options.compare.empty()) {
      ASSIGN_OR_RETURN(const ImageRgb8 wanted, ReadPngRgb8(options.compare + "/left.png"));
      ASSIGN_OR_RETURN(const bench::ImageError error,
                       bench::CompareImages(frame.left.color, wanted));
      json.update(nlohmann::ordered_json{{"psnr_db", error.psnr_db},
                                         {"flip", error.flip},
                                         {"bias", error.bias},
                                         {"worst_block", error.worst_block}});
      RETURN_IF_ERROR(
          WritePng(out + "/difference.png", bench::DifferenceImage(frame.left.color, wanted, 8)));
    }
    std::ofstream(out + "/timing.json") << json.dump() << "\n";
    std::cout << json.dump() << "\n";
  }
  return absl::OkStatus();
}

}  // namespace

Action Render(CLI::App& command) {
  const auto o = std::make_shared<Options>();
  command.add_option("scene", o->scene, "Recipe (.pb) or solve:SEED[:CONFIG]; absent: a demo room");
  command.add_option("--seed", o->seed, "Of the demo room");
  command.add_option("--rig", o->rig, "Index of the rig, or of the first");
  command.add_option(
      "--rigs", o->rigs,
      "Solves the scene with N more from there and draws all, each to a folder in --out");
  command.add_option("--out", o->out, "Folder");
  command.add_option("--profile", o->profile);
  command.add_option("--spp", o->samples);
  command.add_option("--bounces", o->bounces);
  command.add_option("--size", o->size, "WxH; keeps the field of view")
      ->delimiter('x')
      ->expected(2);
  command.add_option("--save", o->save, "Writes the recipe to this file, too");
  command.add_option("--compare", o->compare,
                     "Prints how far the left picture is from the one in this folder");
  command.add_flag("--raw", o->raw, "No denoising");
  command.add_flag("--no-cache", o->no_cache, "No radiance cache");
  return [o] { return Run(*o); };
}

}  // namespace parallax::preview
