// terrain: shaded relief of landforms from above, the region and the site side by side, a row a
// seed; prints a JSON line with core-seconds and relief for each.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>

#include "common/image/io.h"
#include "tests/preview/preview.h"
#include "worker/terrain/landforms.h"

namespace parallax::preview {
namespace {

double CpuSeconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

// Light from the north-west, 40 degrees up, with a tint by wetness and by loose material.
void DrawRelief(const parallax::Terrain& terrain, float extent_m, int side_px, int left_px,
                int top_px, ImageRgb8& image) {
  const Vec3f light = Vec3f(-0.54f, 0.54f, 0.64f).normalized();
  const float pixel_m = extent_m / static_cast<float>(side_px);
  for (int y = 0; y < side_px; ++y) {
    for (int x = 0; x < side_px; ++x) {
      const Vec2f p((static_cast<float>(x) - 0.5f * static_cast<float>(side_px)) * pixel_m,
                    (0.5f * static_cast<float>(side_px) - static_cast<float>(y)) * pixel_m);
      const Vec2f slope = terrain.Slope(p, pixel_m);
      const float shade =
          std::max(0.0f, Vec3f(-slope.x(), -slope.y(), 1).normalized().dot(light)) / 0.85f;
      const float wet = terrain.Wetness(p), loose = std::min(1.0f, terrain.Deposit(p));
      const Vec3f color = Vec3f(0.72f, 0.70f, 0.62f) + loose * Vec3f(0.12f, 0.05f, -0.05f) -
                          wet * wet * Vec3f(0.35f, 0.15f, 0.1f);
      for (int c = 0; c < 3; ++c) {
        image(left_px + x, top_px + y, c) =
            static_cast<uint8_t>(std::clamp(255 * shade * color[c], 0.0f, 255.0f));
      }
    }
  }
}

struct Options {
  std::string landform = "mountains", out = "terrain.png";
  int seeds = 2, side_px = 700;
};

absl::Status Run(const Options& options) {
  const int side_px = options.side_px;
  ImageRgb8 sheet(2 * side_px, options.seeds * side_px);
  for (int seed = 0; seed < options.seeds; ++seed) {
    ASSIGN_OR_RETURN(const TerrainSpec spec,
                     DrawLandform(options.landform, Rng(SceneSeed{static_cast<uint64_t>(seed)})));
    const double begin = CpuSeconds();
    const parallax::Terrain terrain = MakeTerrain(spec);
    const double core_s = CpuSeconds() - begin;
    DrawRelief(terrain, spec.region_m, side_px, 0, seed * side_px, sheet);
    DrawRelief(terrain, spec.site_m, side_px, side_px, seed * side_px, sheet);
    const FieldRange region = RangeOf(terrain.region()), site = RangeOf(terrain.site());
    std::printf(
        "{\"landform\":\"%s\",\"seed\":%d,\"core_s\":%.2f,\"region_relief_m\":%.1f,"
        "\"site_relief_m\":%.1f}\n",
        options.landform.c_str(), seed, core_s, region.high - region.low, site.high - site.low);
  }
  return WritePng(options.out, sheet);
}

}  // namespace

Action Terrain(CLI::App& command) {
  const auto options = std::make_shared<Options>();
  command.add_option("--landform", options->landform, "One of LandformNames()")
      ->capture_default_str();
  command.add_option("--seeds", options->seeds, "Rows of the sheet")->capture_default_str();
  command.add_option("--size", options->side_px, "Side of a picture in pixels")
      ->capture_default_str();
  command.add_option("--out", options->out, "PNG to write")->capture_default_str();
  return [options] { return Run(*options); };
}

}  // namespace parallax::preview
