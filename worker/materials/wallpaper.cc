// Family `wallpaper`: a ground and one or two inks in a repeating pattern, a little embossed.
#include <array>

#include "worker/materials/families.h"
#include "worker/materials/surface.h"

namespace parallax {
namespace {

using noise::CosTurn;
using noise::Fade;
using noise::Fbm3;
using noise::Fract;
using noise::Saturate;

enum class Pattern {
  kStripes,
  kDots,
  kOgee,
  kChevron,
  kDamask,
  kSprigs,
  kHoneycomb,
  kFans,
  kCount
};

float Length(float x, float y) { return std::sqrt(x * x + y * y); }
// Folds x into [-period / 2, period / 2).
float Centred(float x, float period) { return (Fract(x / period + 0.5f) - 0.5f) * period; }

// Distance into the ink in repeats (positive inside), for a pattern whose repeat is 1 wide and
// `kHeights` high.
struct InkField {
  Pattern pattern;
  float weight = 0.5f;  // [0, 1]: how bold.
  int petals = 5;

  float height() const {
    switch (pattern) {
      case Pattern::kOgee:
      case Pattern::kDamask:
        return 1.6f;
      case Pattern::kSprigs:
        return 1.5f;
      case Pattern::kHoneycomb:
        return 1.7320508f;
      default:
        return 1.0f;
    }
  }

  float At(float u, float v) const {
    switch (pattern) {
      case Pattern::kStripes: {
        const float x = std::fabs(Centred(u, 1.0f));
        const float broad = 0.10f + 0.2f * weight - x;
        const float pin = 0.018f - std::fabs(x - 0.40f);
        return std::max(broad, pin);
      }
      case Pattern::kDots: {
        const float r = 0.08f + 0.14f * weight;
        const float near = Length(Centred(u, 1.0f), Centred(v, 1.0f));
        const float drop = Length(Centred(u + 0.5f, 1.0f), Centred(v + 0.5f, 1.0f));
        return r - std::min(near, drop);
      }
      case Pattern::kOgee:
        return 0.02f + 0.03f * weight - OgeeDistance(u, v);
      case Pattern::kChevron: {
        const float zigzag = std::fabs(Centred(u, 1.0f)) * 0.8f;
        return (0.10f + 0.12f * weight - std::fabs(Centred(v + zigzag, 0.5f))) * 0.78f;
      }
      case Pattern::kDamask: {
        const float frame = 0.02f + 0.02f * weight - OgeeDistance(u, v);
        const float a = Flower(Centred(u, 1.0f), Centred(v, 1.6f));
        const float b = Flower(Centred(u + 0.5f, 1.0f), Centred(v + 0.8f, 1.6f));
        return std::max(frame, std::max(a, b));
      }
      case Pattern::kSprigs: {
        float best = -1;
        for (int side = 0; side < 2; ++side) {
          const float x = Centred(u + 0.5f * static_cast<float>(side), 1.0f),
                      y = v + 0.75f * static_cast<float>(side);
          const float bend = x - 0.06f * CosTurn(y / 1.5f);
          best = std::max(best, 0.012f - std::fabs(bend));
          // Leaves to the left and right of the stem in turn.
          const float row = Fract(y / 0.25f) - 0.5f;
          const bool left = noise::FloorInt(y / 0.25f) & 1;
          const float lx = (left ? -bend : bend) - 0.14f, ly = row * 0.25f - 0.35f * lx;
          const float length = 0.12f, width = 0.035f + 0.025f * weight;
          const float along = lx / length;
          if (along > -1 && along < 1) {
            best = std::max(best, 0.7f * (width * (1 - along * along) - std::fabs(ly)));
          }
        }
        return best;
      }
      case Pattern::kHoneycomb: {
        // Distance to the border between the two nearest centres of a hexagonal lattice.
        const float ax = Centred(u, 1.0f), ay = Centred(v, 1.7320508f);
        const float bx = Centred(u + 0.5f, 1.0f), by = Centred(v + 0.8660254f, 1.7320508f);
        const bool a_near = ax * ax + ay * ay < bx * bx + by * by;
        const float x = std::fabs(a_near ? ax : bx), y = std::fabs(a_near ? ay : by);
        const float edge = 0.5f - std::max(x, 0.5f * x + 0.8660254f * y);
        return std::max(0.02f + 0.035f * weight - edge, 0.012f - std::fabs(edge - 0.18f));
      }
      default: {  // Fans: rows of discs of concentric arcs, each row in front of the next higher
                  // one.
        const float line = 0.012f + 0.014f * weight;
        const int row = noise::FloorInt(2.0f * v);
        const auto radius = [&](int j) {
          return Length(Centred(u + ((j & 1) ? 0.5f : 0.0f), 1.0f),
                        v - 0.5f * static_cast<float>(j));
        };
        const auto arcs = [&](float r) { return line - std::fabs(Centred(r, 0.125f)); };
        const float r = radius(row);
        const float here = r < 0.5f ? arcs(r) : std::max(line - (r - 0.5f), arcs(radius(row + 1)));
        return std::max(here, line - std::fabs(radius(row - 1) - 0.5f));
      }
    }
  }

 private:
  static float OgeeDistance(float u, float v) {
    // Two wavy lines that swing against each other and touch.
    const float swing = 0.25f * CosTurn(v / 1.6f);
    const float a = std::fabs(Centred(u - 0.25f - swing, 1.0f)),
                b = std::fabs(Centred(u + 0.25f + swing, 1.0f));
    return 0.75f * std::min(a, b);
  }
  float Flower(float x, float y) const {
    // Petals by angle, stretched upwards, with a ring cut out; a bud above and below.
    const float r = Length(x, 0.62f * y);
    const float turn = std::atan2(0.62f * y, std::fabs(x)) * (1.0f / 6.2831853f);
    const float lobe = 0.5f + 0.5f * CosTurn(turn * static_cast<float>(petals) * 2.0f);
    float d = (0.13f + 0.10f * lobe) * (0.8f + 0.3f * weight) - r;
    d = std::min(d, std::fabs(r - 0.10f) - 0.012f);
    const float bud = 0.05f - Length(x, 0.6f * (std::fabs(y) - 0.48f));
    const float side = 0.04f - Length(std::fabs(x) - 0.13f - 0.2f * (std::fabs(y) - 0.33f),
                                      0.7f * (std::fabs(y) - 0.36f));
    return std::max(d, std::max(bud, side));
  }
};

class Wallpaper final : public Material {
 public:
  Wallpaper(Rng& rng, std::vector<Pattern> patterns) {
    static constexpr std::array<uint32_t, 14> kGrounds = {
        0xe2dccd, 0xd8cfbb, 0xc9cdc4, 0xb9c3c4, 0x8fa3a0, 0x5d7a78, 0x2f4a52,
        0x33405c, 0x6a3a44, 0xb98f86, 0xd9bfae, 0xcbb276, 0x7f8a66, 0x3f4a40};
    field_.pattern = rng.Pick(patterns);
    field_.weight = Draw(rng, 0, 1);
    field_.petals = rng.UniformInt(3, 7);
    ground_ = VaryColor(rng, SrgbColor(rng.Pick(kGrounds)), 0.08, 0.04);
    const Vec3f other = VaryColor(rng, SrgbColor(rng.Pick(kGrounds)), 0.08, 0.04);
    const bool light = Luminance(ground_) > 0.25f;
    const Vec3f tone =
        light ? Vec3f(ground_ * Draw(rng, 0.45, 0.8)) : Albedo(ground_ * Draw(rng, 1.5, 2.6));
    ink_ = rng.Bernoulli(0.55) ? tone : other;
    repeat_m_ = field_.pattern == Pattern::kDamask || field_.pattern == Pattern::kSprigs
                    ? Draw(rng, 0.16, 0.4)
                    : Draw(rng, 0.05, 0.18);
    roughness_ = Draw(rng, 0.6, 0.85);
    ink_roughness_ = rng.Bernoulli(0.3) ? Draw(rng, 0.25, 0.4) : roughness_;
    relief_m_ = Draw(rng, 3e-5, 1.5e-4);
    linen_ = rng.Bernoulli(0.5);
    seed_ = DrawSeed(rng);
    // What the pattern fades to is its own coverage.
    constexpr int kSide = 48;
    int inked = 0;
    for (int i = 0; i < kSide * kSide; ++i) {
      const float u = (static_cast<float>(i % kSide) + 0.5f) / kSide,
                  v = (static_cast<float>(i / kSide) + 0.5f) / kSide;
      inked += field_.At(u, v * field_.height()) > 0;
    }
    coverage_ = static_cast<float>(inked) / (kSide * kSide);
  }
  SurfaceSample Evaluate(const SurfacePoint& point) const override {
    const float w = point.footprint_m;
    const PlanePoint plane = OnPlane(point);
    const float ink = Ink(plane, 0.0004f, w);
    const float cloud = Fbm3(point.texture_m, 0.3f, 5, w, seed_ + 1, 0.55f);
    const float weave = Weave(plane, w);
    SurfaceSample out;
    out.base_color = Albedo(Mix(ground_, ink_, ink) * (1.0f + 0.04f * cloud + 0.08f * weave));
    out.roughness = Saturate(noise::Lerp(roughness_, ink_roughness_, ink) * (1.0f + 0.06f * cloud));
    out.specular = 0.4f;
    return out;
  }
  float Height(const SurfacePoint& point) const override {
    const float w = point.footprint_m;
    const PlanePoint plane = OnPlane(point);
    return relief_m_ * (Ink(plane, 0.0012f, w) - coverage_) + 3e-5f * Weave(plane, w) +
           1.5e-4f * Fbm3(point.texture_m, 0.2f, 2, w, seed_ + 4);
  }

 private:
  float Ink(const PlanePoint& plane, float soft_m, float w) const {
    const float fade = Fade(0.45f * repeat_m_, w);
    if (fade <= 0) return coverage_;
    const float d = repeat_m_ * field_.At(plane.u / repeat_m_, plane.v / repeat_m_);
    return coverage_ + fade * (Edge(d, soft_m, 1.2f * w) - coverage_);
  }
  // The paper's own grain: threads or fleece.
  float Weave(const PlanePoint& plane, float w) const {
    const float fade = Fade(2.5e-3f, w);
    if (fade <= 0) return 0;
    if (!linen_) return fade * noise::Gradient2(plane.u * 380.0f, plane.v * 380.0f, seed_ + 2);
    return 0.7f * fade *
           (noise::Gradient2(plane.u * 60.0f, plane.v * 700.0f, seed_ + 2) +
            noise::Gradient2(plane.u * 700.0f, plane.v * 60.0f, seed_ + 3));
  }

  InkField field_;
  Vec3f ground_, ink_;
  float repeat_m_, roughness_, ink_roughness_, relief_m_, coverage_;
  bool linen_;
  uint32_t seed_;
};

}  // namespace

void AddWallpaperMaterials(MaterialList& list) {
  const MaterialTags wall = {.diffuse = true, .walls = true};
  const auto add = [&](const char* name, std::vector<Pattern> patterns) {
    list.push_back(Entry<Wallpaper>(name, "wallpaper", wall, patterns));
  };
  add("DamaskWallpaper", {Pattern::kDamask, Pattern::kOgee});
  add("DottedWallpaper", {Pattern::kDots});
  add("GeometricWallpaper", {Pattern::kChevron, Pattern::kHoneycomb, Pattern::kFans});
  add("SprigWallpaper", {Pattern::kSprigs});
  add("StripedWallpaper", {Pattern::kStripes});
}

}  // namespace parallax
