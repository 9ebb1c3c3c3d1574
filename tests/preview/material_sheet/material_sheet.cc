// Draws every material class, two seeds each, as a lit ball of 24 cm, a flat patch of 50 cm and a
// close-up of 6 cm into one contact sheet.
//   material_sheet OUT.png [--seed FIRST] [NAME-PART|FAMILY...]
#include <array>
#include <cmath>
#include <iostream>

#include "common/image/io.h"
#include "worker/materials/kernel/noise.h"
#include "worker/materials/kernel/stroke_font.h"
#include "worker/materials/kernel/surface.h"

namespace parallax {
namespace {

constexpr int kTile = 168;    // Pixels of a ball or patch.
constexpr int kCaption = 16;  // Pixels above each row.
constexpr int kGap = 4;
constexpr int kSeeds = 2;    // From --seed on.
constexpr int kColumns = 2;  // Classes beside each other.
constexpr int kSamples = 2;  // Squared, a pixel.

// A studio: grey sky, warm floor, two long soft boxes to be seen in what shines. Rough surfaces see
// it blurred.
Vec3f Studio(const Vec3f& d, float roughness) {
  const float blur = 0.03f + 0.9f * roughness;
  const float up = noise::SmoothStep(-0.4f * blur - 0.05f, 0.4f * blur + 0.05f, d.z());
  Vec3f light =
      Mix(Vec3f(0.16f, 0.14f, 0.12f), Vec3f(0.45f, 0.5f, 0.56f) * (0.6f + 0.4f * d.z()), up);
  const auto box = [&](const Vec3f& at, float half_u, float strength) {
    const float c = std::acos(std::clamp(d.dot(at), -1.0f, 1.0f));
    const float size = half_u;
    return strength * (1.0f - noise::SmoothStep(size - blur * 0.6f, size + blur * 0.6f, c)) /
           (1.0f + 6.0f * roughness * roughness);
  };
  light += Vec3f(3.2f, 3.0f, 2.8f) * box(Vec3f(-0.55f, -0.45f, 0.7f).normalized(), 0.3f, 1.0f);
  light += Vec3f(0.9f, 1.1f, 1.4f) * box(Vec3f(0.8f, 0.1f, 0.35f).normalized(), 0.22f, 1.0f);
  return light;
}

Vec3f Shade(const Material& material, SurfacePoint point, const Vec3f& normal, const Vec3f& tangent,
            const Vec3f& bitangent, const Vec3f& view, const Vec3f& texture_u,
            const Vec3f& texture_v) {
  // The relief bends the normal; differences over half a footprint.
  const float step = std::max(2e-5f, 0.5f * point.footprint_m);
  const float h0 = material.Height(point);
  SurfacePoint moved = point;
  moved.texture_m = point.texture_m + step * texture_u;
  const float hu = (material.Height(moved) - h0) / step;
  moved.texture_m = point.texture_m + step * texture_v;
  const float hv = (material.Height(moved) - h0) / step;
  const Vec3f n = (normal - hu * tangent - hv * bitangent).normalized();

  const SurfaceSample s = material.Evaluate(point);
  const Vec3f key_direction = Vec3f(-0.55f, -0.35f, 0.62f).normalized();
  const float key = std::max(0.0f, n.dot(key_direction));
  const Vec3f ambient =
      Mix(Vec3f(0.14f, 0.12f, 0.11f), Vec3f(0.42f, 0.45f, 0.5f), 0.5f + 0.5f * n.z());
  const Vec3f irradiance = ambient + Vec3f(2.1f, 2.0f, 1.85f) * key;
  const Vec3f diffuse =
      s.base_color.cwiseProduct(irradiance) * ((1 - s.metallic) * (1 - s.transmission));
  const float cosine = std::max(0.05f, std::fabs(n.dot(view)));
  const float grazing = std::pow(1 - cosine, 5.0f);
  const Vec3f f0 = Mix(Vec3f::Constant(0.08f * s.specular), s.base_color, s.metallic);
  const Vec3f fresnel = f0 + (Vec3f::Ones() - f0) * grazing * (1 - s.roughness);
  const Vec3f mirrored = 2.0f * n.dot(view) * n - view;
  Vec3f light = diffuse + fresnel.cwiseProduct(Studio(mirrored, s.roughness));
  if (s.clearcoat > 0) {
    light += Vec3f::Constant(s.clearcoat * (0.04f + 0.96f * grazing))
                 .cwiseProduct(Studio(mirrored, s.clearcoat_roughness));
  }
  light += s.base_color.cwiseProduct(irradiance) * (0.6f * s.sheen * std::pow(1 - cosine, 3.0f));
  if (s.transmission > 0) {
    // A chequered card stands behind it.
    const Vec3f through = point.texture_m + 0.05f * n;
    const bool dark = (noise::FloorInt(through.x() * 25) + noise::FloorInt(through.y() * 25)) & 1;
    const Vec3f behind = Mix(Vec3f::Constant(dark ? 0.15f : 0.7f), Vec3f::Constant(0.42f),
                             noise::Saturate(s.roughness * 2));
    light += s.transmission * s.base_color.cwiseProduct(behind);
  }
  return light + 0.02f * s.emission;
}

std::array<uint8_t, 3> Encode(const Vec3f& light) {
  std::array<uint8_t, 3> out;
  for (int c = 0; c < 3; ++c) {
    const float x = 0.62f * light[c];
    const float mapped =
        noise::Saturate(x < 0.8f ? x : 0.8f + 0.2f * (1 - std::exp(-(x - 0.8f) / 0.2f)));
    const float srgb =
        mapped <= 0.0031308f ? 12.92f * mapped : 1.055f * std::pow(mapped, 1 / 2.4f) - 0.055f;
    out[static_cast<size_t>(c)] = static_cast<uint8_t>(255.0f * srgb + 0.5f);
  }
  return out;
}

void Put(ImageRgb8& sheet, int x, int y, const std::array<uint8_t, 3>& rgb) {
  for (int c = 0; c < 3; ++c) sheet(x, y, c) = rgb[static_cast<size_t>(c)];
}

void DrawBall(const Material& material, ImageRgb8& sheet, int left, int top) {
  const float radius = 0.12f;
  for (int j = 0; j < kTile; ++j) {
    for (int i = 0; i < kTile; ++i) {
      Vec3f light = Vec3f::Zero();
      for (int k = 0; k < kSamples * kSamples; ++k) {
        const float x =
            ((static_cast<float>(i) + (static_cast<float>(k % kSamples) + 0.5f) / kSamples) /
                 kTile * 2 -
             1) *
            1.05f;
        const float z =
            (1 - (static_cast<float>(j) + (static_cast<float>(k / kSamples) + 0.5f) / kSamples) /
                     kTile * 2) *
            1.05f;
        if (x * x + z * z >= 1) {
          light += Vec3f::Constant(0.32f);
          continue;
        }
        // Seen from -y.
        const Vec3f n(x, -std::sqrt(1 - x * x - z * z), z);
        SurfacePoint point;
        point.texture_m = radius * n + Vec3f(0.3f, 0.2f, 0.1f);
        point.normal = point.texture_normal = n;
        point.uv = Vec2f(0.5f + std::atan2(n.x(), -n.y()) / 6.2831853f * 2,
                         0.5f + std::asin(z) / 3.1415927f);
        point.footprint_m = 2 * radius / (kTile * kSamples) / std::max(0.2f, -n.y());
        point.footprint_uv = 1.0f / (kTile * kSamples);
        const Vec3f t = Vec3f::UnitZ().cross(n).normalized();
        const Vec3f b = n.cross(t);
        light += Shade(material, point, n, t, b, -Vec3f::UnitY(), t, b);
      }
      Put(sheet, left + i, top + j, Encode(light / (kSamples * kSamples)));
    }
  }
}

// A wall patch seen square on: x to the right, z up.
void DrawPatch(const Material& material, float size_m, float uv_size, ImageRgb8& sheet, int left,
               int top) {
  for (int j = 0; j < kTile; ++j) {
    for (int i = 0; i < kTile; ++i) {
      Vec3f light = Vec3f::Zero();
      for (int k = 0; k < kSamples * kSamples; ++k) {
        const float x =
            (static_cast<float>(i) + (static_cast<float>(k % kSamples) + 0.5f) / kSamples) / kTile;
        const float z =
            1 -
            (static_cast<float>(j) + (static_cast<float>(k / kSamples) + 0.5f) / kSamples) / kTile;
        SurfacePoint point;
        point.texture_m = Vec3f(size_m * x + 0.31f, 0.137f, size_m * z + 0.22f);
        point.normal = point.texture_normal = -Vec3f::UnitY();
        point.uv = Vec2f(0.5f, 0.5f) + uv_size * Vec2f(x - 0.5f, z - 0.5f);
        point.footprint_m = size_m / (kTile * kSamples);
        point.footprint_uv = uv_size / (kTile * kSamples);
        const Vec3f view = Vec3f((0.5f - x) * 0.5f, -1, (0.5f - z) * 0.5f).normalized();
        light += Shade(material, point, -Vec3f::UnitY(), Vec3f::UnitX(), Vec3f::UnitZ(), view,
                       Vec3f::UnitX(), Vec3f::UnitZ());
      }
      Put(sheet, left + i, top + j, Encode(light / (kSamples * kSamples)));
    }
  }
}

void DrawText(std::string_view text, ImageRgb8& sheet, int left, int top) {
  const float scale = 0.6f;  // Cell units a pixel.
  for (int j = 0; j < kCaption; ++j) {
    for (int i = 0; i < static_cast<int>(TextWidth(text) / scale) + 4; ++i) {
      if (left + i >= sheet.width()) break;
      const float d = TextDistance(text, (static_cast<float>(i) - 1) * scale,
                                   (kCaption - 4.0f - static_cast<float>(j)) * scale);
      const float ink = 1 - noise::SmoothStep(0.3f, 0.9f, d);
      const auto grey = static_cast<uint8_t>(245 - 225 * ink);
      Put(sheet, left + i, top + j, {grey, grey, grey});
    }
  }
}

int Run(int argc, char** argv) {
  if (argc < 2 || argv[1][0] == '-') {
    std::cerr << "usage: material_sheet OUT.png [--seed FIRST] [NAME-PART|FAMILY...]\n";
    return 2;
  }
  uint64_t first_seed = 0;
  int names = 2;
  if (argc > 3 && std::string_view(argv[2]) == "--seed") {
    first_seed = std::stoull(argv[3]);
    names = 4;
  }
  std::vector<const MaterialClass*> chosen;
  for (const MaterialClass& c : MaterialCatalogue()) {
    bool wanted = argc <= names;
    for (int i = names; i < argc; ++i) {
      wanted = wanted || c.name.find(argv[i]) != std::string::npos || c.family == argv[i];
    }
    if (wanted) chosen.push_back(&c);
  }
  const int rows = (static_cast<int>(chosen.size()) + kColumns - 1) / kColumns;
  const int class_width = kSeeds * 3 * (kTile + kGap) + 2 * kGap;
  const int row_height = kTile + kCaption + kGap;
  ImageRgb8 sheet(kColumns * class_width, rows * row_height, 245);
  for (size_t k = 0; k < chosen.size(); ++k) {
    const int left = static_cast<int>(k) % kColumns * class_width,
              top = static_cast<int>(k) / kColumns * row_height;
    DrawText(chosen[k]->name + " / " + chosen[k]->family, sheet, left + kGap, top);
    for (int seed = 0; seed < kSeeds; ++seed) {
      const auto material =
          *MakeMaterial(chosen[k]->name, first_seed + static_cast<uint64_t>(seed));
      const int x = left + seed * 3 * (kTile + kGap);
      DrawBall(*material, sheet, x, top + kCaption);
      DrawPatch(*material, 0.5f, 1.0f, sheet, x + kTile + kGap, top + kCaption);
      DrawPatch(*material, 0.06f, 0.3f, sheet, x + 2 * (kTile + kGap), top + kCaption);
    }
  }
  const absl::Status written = WritePng(argv[1], sheet);
  if (!written.ok()) {
    std::cerr << "material_sheet: " << written.message() << "\n";
    return 1;
  }
  return 0;
}

}  // namespace
}  // namespace parallax

int main(int argc, char** argv) { return parallax::Run(argc, argv); }
