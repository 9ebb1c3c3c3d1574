// A landscape in words and as a small map, for `scene show`.
#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "common/math/stereo.h"
#include "worker/scene/types/nature/nature.h"
#include "worker/scene/types/nature/rules/recipe.h"

namespace parallax {
namespace {

constexpr int kColumns = 64, kRows = 26;
constexpr float kSide_m = 900;

// Heights as shades, streams as "~", the walk as digits of its frames' tens.
std::vector<std::string> MapOf(const v1::Scene& scene, const Terrain& terrain) {
  Vec2f middle = Vec2f::Zero();
  for (const v1::Rig& rig : scene.rigs()) middle += EyePosition(rig, 0).head<2>().cast<float>();
  middle /= std::max(1.0f, static_cast<float>(scene.rigs_size()));
  const auto place = [&](int column, int row) -> Vec2f {
    return middle + kSide_m * Vec2f((static_cast<float>(column) + 0.5f) / kColumns - 0.5f,
                                    0.5f - (static_cast<float>(row) + 0.5f) / kRows);
  };
  float low = 1e9f, high = -1e9f;
  for (int row = 0; row < kRows; ++row) {
    for (int column = 0; column < kColumns; ++column) {
      const float height = terrain.Height(place(column, row), 15);
      low = std::min(low, height);
      high = std::max(high, height);
    }
  }
  constexpr std::string_view kShades = " .:-=+*#%@";
  std::vector<std::string> lines;
  for (int row = 0; row < kRows; ++row) {
    std::string line;
    for (int column = 0; column < kColumns; ++column) {
      const Vec2f p = place(column, row);
      const float t = (terrain.Height(p, 15) - low) / std::max(high - low, 0.01f);
      const auto shade = std::clamp(static_cast<int>(t * 10), 0, 9);
      const bool water = terrain.AboveWater(p) < 0;
      line += water                            ? '='
              : terrain.DrainageArea(p) > 4e4f ? '~'
                                               : kShades[static_cast<size_t>(shade)];
    }
    lines.push_back("  |" + line + "|");
  }
  for (int i = 0; i < scene.rigs_size(); ++i) {
    const Vec2f at = (EyePosition(scene.rigs(i), 0).head<2>().cast<float>() - middle) / kSide_m;
    const int column = static_cast<int>(std::floor((at.x() + 0.5f) * kColumns));
    const int row = static_cast<int>(std::floor((0.5f - at.y()) * kRows));
    if (column < 0 || column >= kColumns || row < 0 || row >= kRows) continue;
    lines[static_cast<size_t>(row)][static_cast<size_t>(column) + 3] =
        static_cast<char>('0' + i / 10 % 10);
  }
  lines.insert(
      lines.begin(),
      fmt::format("map: {:.0f} m across, north up, {:.0f} to {:.0f} m high, = water, ~ streams, "
                  "digits the walk",
                  static_cast<double>(kSide_m), static_cast<double>(low),
                  static_cast<double>(high)));
  return lines;
}

}  // namespace

SceneDescription DescribeLand(const v1::Scene& scene) {
  SceneDescription description;
  const v1::Terrain& land = scene.place().terrain();
  description.kind = land.biome();
  if (land.biome().empty()) return description;
  description.lines.push_back(fmt::format("{} in {}, {} things of {} kinds in {} layers",
                                          land.biome(), land.season(), land.instances(),
                                          land.prototypes_size(), land.layers_size()));
  for (const v1::ScatterLayer& layer : land.layers()) {
    description.lines.push_back(fmt::format(
        "  {:<20} {:8.4f} a m2 to {:4.0f} m, object{} {} to {}", layer.name(), layer.per_m2(),
        layer.reach_m(), layer.index_each() ? "s" : " ", layer.first_object_index(),
        layer.first_object_index() + std::max(layer.indices(), 1u) - 1));
  }
  return description;
}

std::vector<std::string> DescribeMap(const v1::Scene& scene) {
  const auto terrain = TerrainOf(scene.place().terrain());
  if (!terrain.ok()) return {};
  return MapOf(scene, **terrain);
}

}  // namespace parallax
