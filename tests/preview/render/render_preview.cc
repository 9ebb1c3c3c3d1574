// Renders one rig of a recipe and writes color and all maps as PNGs to look at, and timing as JSON.
//   render_preview [SCENE.pb | solve:SEED] --rig 0 --out DIR [--profile default] [--spp N] [--size
//   1280x720]
#include <CLI/CLI.hpp>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>

#include "common/base/seconds.h"
#include "common/base/status.h"
#include "common/image/io.h"
#include "tests/bench/program_main.h"
#include "tests/bench/render/image_error.h"
#include "tests/bench/render/load_scene.h"
#include "worker/render/renderer.h"

namespace parallax {
namespace {

using Rgb = std::array<uint8_t, 3>;

// Blue over green to red.   Source: the polynomial fit of "Turbo", A. Mikhailov, 2019.
Rgb Turbo(double t) {
  t = std::clamp(t, 0.0, 1.0);
  const auto curve = [t](double a, double b, double c, double d, double e, double f) {
    const double v = a + t * (b + t * (c + t * (d + t * (e + t * f))));
    return static_cast<uint8_t>(std::clamp(v, 0.0, 1.0) * 255 + 0.5);
  };
  return {curve(0.1357, 4.5974, -42.3277, 130.5887, -150.5666, 58.1375),
          curve(0.0914, 2.1856, 4.8052, -14.0195, 4.2109, 2.7747),
          curve(0.1067, 12.5925, -60.1097, 109.0745, -88.5066, 26.8183)};
}

Rgb IndexColor(uint32_t index) {
  if (index == 0) return {0, 0, 0};
  uint32_t h = index * 0x9e3779b9u;
  h ^= h >> 15;
  h *= 0x85ebca6bu;
  h ^= h >> 13;
  return {static_cast<uint8_t>(64 + h % 192), static_cast<uint8_t>(64 + (h >> 8) % 192),
          static_cast<uint8_t>(64 + (h >> 16) % 192)};
}

template <typename Function>
ImageRgb8 Colored(int width, int height, Function color) {
  ImageRgb8 out(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const Rgb rgb = color(x, y);
      std::copy(rgb.begin(), rgb.end(), out.At(x, y));
    }
  }
  return out;
}

// Puts half-size copies of pictures of one size side by side, three in a row.
ImageRgb8 Sheet(const std::vector<ImageRgb8>& pictures) {
  const int w = pictures[0].width() / 2, h = pictures[0].height() / 2;
  const int rows = (static_cast<int>(pictures.size()) + 2) / 3;
  ImageRgb8 sheet(3 * w, rows * h);
  for (size_t i = 0; i < pictures.size(); ++i) {
    const int x0 = static_cast<int>(i % 3) * w, y0 = static_cast<int>(i / 3) * h;
    for (int y = 0; y < h; ++y) {
      for (int x = 0; x < w; ++x) {
        for (int c = 0; c < 3; ++c) {
          const ImageRgb8& p = pictures[i];
          sheet(x0 + x, y0 + y, c) =
              static_cast<uint8_t>((p(2 * x, 2 * y, c) + p(2 * x + 1, 2 * y, c) +
                                    p(2 * x, 2 * y + 1, c) + p(2 * x + 1, 2 * y + 1, c) + 2) /
                                   4);
        }
      }
    }
  }
  return sheet;
}

absl::Status WriteView(const std::string& dir, const std::string& eye, const View& v) {
  const int w = v.color.width(), h = v.color.height();
  std::vector<ImageRgb8> sheet = {v.color};
  float largest = 1e-3f;
  for (const float d : v.disparity_px.values()) largest = std::max(largest, d);
  const auto save = [&](const std::string& name, const ImageRgb8& image) {
    sheet.push_back(image);
    return WritePng(dir + "/" + name + "_" + eye + ".png", image);
  };
  RETURN_IF_ERROR(WritePng(dir + "/" + eye + ".png", v.color));
  RETURN_IF_ERROR(save("disparity", Colored(w, h, [&](int x, int y) {
                         const float d = v.disparity_px(x, y);
                         return d > 0 ? Turbo(d / largest) : Rgb{0, 0, 0};
                       })));
  RETURN_IF_ERROR(save("depth", Colored(w, h, [&](int x, int y) {
                         const float z = v.depth_m(x, y);
                         return z > 0 ? Turbo(1 - std::log2(z / 0.25) / 6) : Rgb{0, 0, 0};
                       })));
  RETURN_IF_ERROR(
      save("objects", Colored(w, h, [&](int x, int y) { return IndexColor(v.objects(x, y)); })));
  RETURN_IF_ERROR(save("materials",
                       Colored(w, h, [&](int x, int y) { return IndexColor(v.materials(x, y)); })));
  RETURN_IF_ERROR(save("normals", Colored(w, h, [&](int x, int y) {
                         Rgb rgb;
                         for (int c = 0; c < 3; ++c) {
                           rgb[static_cast<size_t>(c)] =
                               static_cast<uint8_t>(127.5f + 127.5f * v.normals(x, y, c));
                         }
                         return rgb;
                       })));
  RETURN_IF_ERROR(save(
      "masks", Colored(w, h, [&](int x, int y) {
        const int m = v.masks(x, y);
        return Rgb{static_cast<uint8_t>((m & kMaskSky ? 120 : 0) + (m & kMaskExterior ? 130 : 0)),
                   static_cast<uint8_t>(m & kMaskTransparent ? 220 : 0),
                   static_cast<uint8_t>(m & kMaskMirror ? 220 : 0)};
      })));
  RETURN_IF_ERROR(save("occlusion", Colored(w, h, [&](int x, int y) {
                         const uint8_t o = v.occlusion(x, y);
                         return Rgb{o, o, o};
                       })));
  return save("sheet", Sheet(sheet));
}

absl::Status Run(int argc, char** argv, int* exit_code) {
  std::string scene_path, out = "render_preview.out", profile = "default", size;
  uint64_t seed = 1;
  int rig_index = 0, samples = 0, bounces = 0;
  bool raw = false, no_cache = false;
  std::string save, compare;
  CLI::App app("Render one rig of a recipe to PNGs");
  app.add_option("scene", scene_path, "recipe (.pb) or solve:SEED[:CONFIG]; absent: the demo room");
  app.add_option("--seed", seed, "of the demo room");
  app.add_option("--rig", rig_index);
  app.add_option("--out", out, "folder");
  app.add_option("--profile", profile);
  app.add_option("--spp", samples);
  app.add_option("--bounces", bounces);
  app.add_option("--size", size, "WIDTHxHEIGHT; keeps the field of view");
  app.add_option("--save", save, "write the recipe to this file too");
  app.add_option("--compare", compare,
                 "print how far the left picture is from the one in this folder");
  app.add_flag("--raw", raw, "no denoising");
  app.add_flag("--no-cache", no_cache, "no radiance cache");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    *exit_code = app.exit(error);
    return absl::OkStatus();
  }
  ASSIGN_OR_RETURN(bench::LoadedScene scene, bench::LoadScene(scene_path, seed));
  if (!save.empty()) std::ofstream(save, std::ios::binary) << scene.recipe.SerializeAsString();
  if (rig_index < 0 || rig_index >= scene.recipe.rigs_size()) {
    return InvalidArgument("the scene has {} rigs", scene.recipe.rigs_size());
  }
  v1::Rig rig = scene.recipe.rigs(rig_index);
  int width = 0, height = 0;
  if (std::sscanf(size.c_str(), "%dx%d", &width, &height) == 2 && width > 0 && height > 0) {
    const double scale = static_cast<double>(width) / rig.width_px();
    rig.set_fx_px(rig.fx_px() * scale);
    rig.set_fy_px(rig.fy_px() * scale);
    rig.set_cx_px(0.5 * width);
    rig.set_cy_px(0.5 * height);
    rig.set_width_px(width);
    rig.set_height_px(height);
  }
  v1::RenderConfig config;
  config.set_profile(profile);
  config.set_samples_per_pixel(samples);
  config.set_max_bounces(bounces);
  if (raw) config.set_denoise(v1::RenderConfig::DENOISE_OFF);
  if (no_cache) config.set_cache(v1::RenderConfig::CACHE_OFF);
  const auto start = std::chrono::steady_clock::now();
  ASSIGN_OR_RETURN(const auto renderer, Renderer::Create(scene.recipe, scene.geometry, config));
  const double build_s = SecondsSince(start);
  ASSIGN_OR_RETURN(const StereoFrame frame, renderer->RenderRig(rig, {}, {}));
  std::filesystem::create_directories(out);
  RETURN_IF_ERROR(WriteView(out, "left", frame.left));
  RETURN_IF_ERROR(WriteView(out, "right", frame.right));
  bench::ImageError error;
  if (!compare.empty()) {
    ASSIGN_OR_RETURN(const ImageRgb8 wanted, ReadPngRgb8(compare + "/left.png"));
    ASSIGN_OR_RETURN(error, bench::CompareImages(frame.left.color, wanted));
    RETURN_IF_ERROR(
        WritePng(out + "/difference.png", bench::DifferenceImage(frame.left.color, wanted, 8)));
  }
  char json[512];
  std::snprintf(json, sizeof json,
                "{\"geometry_s\": %.3f, \"build_s\": %.3f, \"truth_s\": %.3f, \"trace_s\": %.3f, "
                "\"cache_s\": %.3f, \"denoise_s\": %.3f, \"exposure\": %.4f, \"rays\": %.0f, "
                "\"psnr_db\": %.2f, \"flip\": %.4f, \"bias\": %.2f, \"worst_block\": %.1f}\n",
                scene.geometry_s, build_s, frame.truth_s, frame.trace_s, frame.cache_s,
                frame.denoise_s, static_cast<double>(frame.exposure),
                static_cast<double>(frame.rays), error.psnr_db, error.flip, error.bias,
                error.worst_block);
  std::ofstream(out + "/timing.json") << json;
  std::fputs(json, stdout);
  return absl::OkStatus();
}

}  // namespace
}  // namespace parallax

int main(int argc, char** argv) {
  return parallax::ProgramMain("render_preview", parallax::Run, argc, argv);
}
