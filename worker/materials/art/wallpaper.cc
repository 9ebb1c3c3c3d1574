// Family `wallpaper`: a ground and one or two inks in a repeating pattern, a little embossed.
#include <array>

#include "worker/materials/kernel/material_families.h"
#include "worker/materials/kernel/surface.h"

namespace parallax {
namespace {

using namespace noise;  // NOLINT: the vocabulary of patterns.

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

Float8 Length(Float8 x, Float8 y) { return Sqrt(x * x + y * y); }
// Folds x into [-period / 2, period / 2).
Float8 Centred(Float8 x, float period) { return (Fract(x / period + 0.5f) - 0.5f) * period; }

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

  Float8 At(Float8 u, Float8 v) const {
    switch (pattern) {
      case Pattern::kStripes: {
        const Float8 x = Abs(Centred(u, 1.0f));
        const Float8 broad = 0.10f + 0.2f * weight - x;
        const Float8 pin = 0.018f - Abs(x - 0.40f);
        return Max(broad, pin);
      }
      case Pattern::kDots: {
        const float r = 0.08f + 0.14f * weight;
        const Float8 near = Length(Centred(u, 1.0f), Centred(v, 1.0f));
        const Float8 drop = Length(Centred(u + 0.5f, 1.0f), Centred(v + 0.5f, 1.0f));
        return r - Min(near, drop);
      }
      case Pattern::kOgee:
        return 0.02f + 0.03f * weight - OgeeDistance(u, v);
      case Pattern::kChevron: {
        const Float8 zigzag = Abs(Centred(u, 1.0f)) * 0.8f;
        return (0.10f + 0.12f * weight - Abs(Centred(v + zigzag, 0.5f))) * 0.78f;
      }
      case Pattern::kDamask: {
        const Float8 frame = 0.02f + 0.02f * weight - OgeeDistance(u, v);
        const Float8 a = Flower(Centred(u, 1.0f), Centred(v, 1.6f));
        const Float8 b = Flower(Centred(u + 0.5f, 1.0f), Centred(v + 0.8f, 1.6f));
        return Max(frame, Max(a, b));
      }
      case Pattern::kSprigs: {
        Float8 best = Splat(-1);
        for (int side = 0; side < 2; ++side) {
          const Float8 x = Centred(u + 0.5f * static_cast<float>(side), 1.0f),
                       y = v + 0.75f * static_cast<float>(side);
          const Float8 bend = x - 0.06f * CosTurn(y / 1.5f);
          best = Max(best, 0.012f - Abs(bend));
          // Leaves to the left and right of the stem in turn.
          const Float8 row = Fract(y / 0.25f) - 0.5f;
          const Mask8 left = (noise::FloorInt(y / 0.25f) & 1) != 0;
          const Float8 lx = (left ? -bend : bend) - 0.14f, ly = row * 0.25f - 0.35f * lx;
          const float length = 0.12f, width = 0.035f + 0.025f * weight;
          const Float8 along = lx / length;
          const Float8 leaf = 0.7f * (width * (1.0f - along * along) - Abs(ly));
          best = (along > -1) & (along < 1) ? Max(best, leaf) : best;
        }
        return best;
      }
      case Pattern::kHoneycomb: {
        // Distance to the border between the two nearest centres of a hexagonal lattice.
        const Float8 ax = Centred(u, 1.0f), ay = Centred(v, 1.7320508f);
        const Float8 bx = Centred(u + 0.5f, 1.0f), by = Centred(v + 0.8660254f, 1.7320508f);
        const Mask8 a_near = ax * ax + ay * ay < bx * bx + by * by;
        const Float8 x = Abs(a_near ? ax : bx), y = Abs(a_near ? ay : by);
        const Float8 edge = 0.5f - Max(x, 0.5f * x + 0.8660254f * y);
        return Max(0.02f + 0.035f * weight - edge, 0.012f - Abs(edge - 0.18f));
      }
      default: {  // Fans: rows of discs of concentric arcs, each row in front of the next higher
                  // one.
        const float line = 0.012f + 0.014f * weight;
        const Int8 row = noise::FloorInt(2.0f * v);
        const auto radius = [&](Int8 j) {
          return Length(Centred(u + 0.5f * ToFloat(j & 1), 1.0f), v - 0.5f * ToFloat(j));
        };
        const auto arcs = [&](Float8 r) { return line - Abs(Centred(r, 0.125f)); };
        const Float8 r = radius(row);
        const Float8 here = r < 0.5f ? arcs(r) : Max(line - (r - 0.5f), arcs(radius(row + 1)));
        return Max(here, line - Abs(radius(row - 1) - 0.5f));
      }
    }
  }

 private:
  static Float8 OgeeDistance(Float8 u, Float8 v) {
    // Two wavy lines that swing against each other and touch.
    const Float8 swing = 0.25f * CosTurn(v / 1.6f);
    const Float8 a = Abs(Centred(u - 0.25f - swing, 1.0f)),
                 b = Abs(Centred(u + 0.25f + swing, 1.0f));
    return 0.75f * Min(a, b);
  }
  Float8 Flower(Float8 x, Float8 y) const {
    // Petals by angle, stretched upwards, with a ring cut out; a bud above and below.
    const Float8 r = Length(x, 0.62f * y);
    Float8 turn;
    for (int lane = 0; lane < kLanes; ++lane) {
      turn[lane] = std::atan2(0.62f * y[lane], std::fabs(x[lane])) * (1.0f / 6.2831853f);
    }
    const Float8 lobe = 0.5f + 0.5f * CosTurn(turn * static_cast<float>(petals) * 2.0f);
    Float8 d = (0.13f + 0.10f * lobe) * (0.8f + 0.3f * weight) - r;
    d = Min(d, Abs(r - 0.10f) - 0.012f);
    const Float8 bud = 0.05f - Length(x, 0.6f * (Abs(y) - 0.48f));
    const Float8 side =
        0.04f - Length(Abs(x) - 0.13f - 0.2f * (Abs(y) - 0.33f), 0.7f * (Abs(y) - 0.36f));
    return Max(d, Max(bud, side));
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
    // Far away, the pattern fades to its own mean coverage.
    constexpr int kSide = 48;
    int inked = 0;
    for (int i = 0; i < kSide * kSide; i += kLanes) {
      const Int8 k = i + Int8{0, 1, 2, 3, 4, 5, 6, 7};
      const Float8 u = (ToFloat(k % kSide) + 0.5f) / kSide, v = (ToFloat(k / kSide) + 0.5f) / kSide;
      const Mask8 ink = field_.At(u, v * field_.height()) > 0;
      for (int lane = 0; lane < kLanes; ++lane) inked += ink[lane] != 0;
    }
    coverage_ = static_cast<float>(inked) / (kSide * kSide);
  }
  SurfaceSample8 Evaluate(const SurfacePoint8& point) const override {
    const Float8 w = point.footprint_m;
    const PlanePoint8 plane = OnPlane(point);
    const Float8 ink = Ink(plane, 0.0004f, w);
    const Float8 cloud = Fbm3(point.texture_m, 0.3f, 5, w, seed_ + 1, 0.55f);
    const Float8 weave = Weave(plane, w);
    return {.base_color = Albedo(Mix(ground_, ink_, ink) * (1.0f + 0.04f * cloud + 0.08f * weave)),
            .roughness =
                Saturate(noise::Lerp(roughness_, ink_roughness_, ink) * (1.0f + 0.06f * cloud)),
            .specular = Splat(0.4f)};
  }
  Float8 Height(const SurfacePoint8& point) const override {
    const Float8 w = point.footprint_m;
    const PlanePoint8 plane = OnPlane(point);
    return relief_m_ * (Ink(plane, 0.0012f, w) - coverage_) + 3e-5f * Weave(plane, w) +
           1.5e-4f * Fbm3(point.texture_m, 0.2f, 2, w, seed_ + 4);
  }

 private:
  Float8 Ink(const PlanePoint8& plane, float soft_m, Float8 w) const {
    const Float8 fade = Fade(0.45f * repeat_m_, w);
    if (!Any(fade > 0)) return Splat(coverage_);
    const Float8 d = repeat_m_ * field_.At(plane.u / repeat_m_, plane.v / repeat_m_);
    return coverage_ + fade * (Edge(d, soft_m, 1.2f * w) - coverage_);
  }
  // The paper's own grain: threads or fleece.
  Float8 Weave(const PlanePoint8& plane, Float8 w) const {
    const Float8 fade = Fade(2.5e-3f, w);
    if (!Any(fade > 0)) return Splat(0);
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
