// Family `foliage`: the sheets of plants outdoors. Each leaf differs from its neighbours by the two
// random numbers in its uv (Mesh::uv); texture x runs along it, y across from its midrib.
#include <array>

#include "worker/materials/kernel/material_families.h"
#include "worker/materials/kernel/surface.h"

namespace parallax {
namespace {

using namespace noise;  // NOLINT: the vocabulary of patterns.

// One kind of foliage. Leaves of a plant lie between `first` and `last` by way of `usual`.
struct FoliageKind {
  std::array<uint32_t, 3> first, usual, last;  // A plant takes one column.
  uint32_t odd;                                // The few that are ill or dry.
  float odd_share;
  float spread;  // How far leaves of one plant lie apart, 0 to 1.
  float veins;
  float rough_low, rough_high;
  // Light that passes through over light that is reflected; what stays in it of red, green, blue.
  std::array<float, 3> through;
};

class Foliage final : public Carved<Foliage> {
 public:
  Foliage(Rng& rng, const FoliageKind& kind) : kind_(kind) {
    const auto column = static_cast<size_t>(rng.UniformInt(0, 2));
    const float value = Draw(rng, 0.86, 1.14);
    usual_ = value * VaryColor(rng, SrgbColor(kind.usual[column]), 0.06, 0.04);
    first_ = value * Mix(usual_ / value, SrgbColor(kind.first[column]), kind.spread);
    last_ = value * Mix(usual_ / value, SrgbColor(kind.last[column]), kind.spread);
    odd_ = SrgbColor(kind.odd);
    mean_ = 0.25f * first_ + 0.5f * usual_ + 0.25f * last_;
    spacing_m_ = Draw(rng, 0.006, 0.013);
    slant_ = Draw(rng, 0.5, 1.1);
    roughness_ = Draw(rng, kind.rough_low, kind.rough_high);
    seed_ = DrawSeed(rng);
  }

  SurfaceSample8 Evaluate(const SurfacePoint8& point) const override {
    const Float8 w = point.footprint_m;
    const Float8 own = Fade(1.0f, point.footprint_uv);
    Vec3x8 color = ColorOf(point, own);
    const Float8 n = Fbm3(point.texture_m, 0.02f, 4, w, seed_, 0.6f);
    const Float8 vein = Veins(point.texture_m.x, point.texture_m.y, w);
    color *= (1.0f + 0.22f * n) * (1.0f + 0.3f * own * (point.v - 0.5f));
    // Veins are thick: dark against the light.
    const Vec3x8 passing{kind_.through[0] * color.x, kind_.through[1] * color.y,
                         kind_.through[2] * color.z};
    return {.base_color = Albedo(Mix(color, color * 1.5f, kind_.veins * vein)),
            .roughness = Saturate(roughness_ * (1.0f + 0.2f * n)),
            .specular = Splat(0.35f),
            .subsurface = Splat(0.3f),
            .transmitted_color = passing * (1.0f - 0.45f * kind_.veins * vein)};
  }

  auto HeightOf(const auto& point) const {
    const Float8 w = point.footprint_m;
    const auto& p = point.texture_m;
    return -2e-4f * kind_.veins * Veins(p.x, p.y, w) + 1.2e-4f * Fbm3(p, 0.008f, 2, w, seed_ + 6);
  }

 private:
  Vec3x8 ColorOf(const SurfacePoint8& point, Float8 own) const {
    const Float8 t = Saturate(point.u);
    const Vec3x8 low = Mix(Vec3x8(first_), Vec3x8(usual_), Saturate(2.0f * t));
    const Vec3x8 all = Mix(low, Vec3x8(last_), Saturate(2.0f * t - 1.0f));
    const Vec3x8 color = Mix(Vec3x8(mean_), all, own);
    // Every n-th, from any place between first and last.
    const Float8 turned = noise::Fract(point.u * 17.0f + point.v * 7.0f);
    const Float8 is = turned < kind_.odd_share ? Splat(1) : Splat(0);
    const Float8 odd = kind_.odd_share + own * (is - kind_.odd_share);
    return Mix(color, Vec3x8(odd_), 0.75f * odd);
  }

  // The midrib and side veins that leave it forwards.
  template <typename Real>
  Real Veins(const Real& along, const Real& across, Float8 w) const {
    const Real v = Abs(across);
    constexpr float kRib = 0.9e-3f, kMean = 0.06f;
    const Real rib = (kRib / (kRib + w)) * (1.0f - SmoothStep(0.3f * kRib, 1.6f * kRib + w, v));
    const Float8 fade = Fade(spacing_m_, w);
    const Real x = noise::Fract((along - slant_ * v) / spacing_m_);
    const Float8 wide = 0.08f + w / spacing_m_;
    const Real side = (0.08f / wide) * (1.0f - SmoothStep(0.0f, wide, Abs(x - 0.5f)));
    return Max(rib, Real(kMean + fade * (0.8f * side - kMean)));
  }

  FoliageKind kind_;
  Vec3f first_, usual_, last_, odd_, mean_;
  float spacing_m_, slant_, roughness_;
};

// Light that has passed a leaf is yellower than what it reflects.
constexpr std::array<float, 3> kGreen = {1.45f, 1.3f, 0.4f}, kThick = {0.7f, 0.65f, 0.25f},
                               kBlade = {1.3f, 1.15f, 0.45f}, kTender = {1.15f, 1.05f, 0.45f},
                               kGolden = {1.1f, 0.95f, 0.4f}, kDead = {0.6f, 0.45f, 0.25f},
                               kThin = {0.9f, 0.85f, 0.8f};

// clang-format off
constexpr FoliageKind kSpring = {{0x7f9248, 0x8a9a50, 0x768c48}, {0x687f3c, 0x748644, 0x637c40},
                                 {0x557238, 0x617a40, 0x527038}, 0xb5a860, 0.02f, 0.9f, 0.5f, 0.4f, 0.6f, kTender};
constexpr FoliageKind kSummer = {{0x6a7f36, 0x5f7a3c, 0x74833a}, {0x4d6a2c, 0x48662f, 0x586e30},
                                 {0x38542a, 0x36532d, 0x42592a}, 0xa8933c, 0.035f, 0.9f, 0.5f, 0.35f, 0.6f, kGreen};
constexpr FoliageKind kAutumn = {{0x87803c, 0x82743a, 0x78763e}, {0xb0853a, 0xa3663a, 0xad803c},
                                 {0x9c5f34, 0x80402e, 0x977040}, 0x6b4426, 0.12f, 1.0f, 0.5f, 0.45f, 0.7f, kGolden};
constexpr FoliageKind kDryLeaf = {{0x9a7a50, 0x8f6f48, 0xa8885a}, {0x7d5a38, 0x765234, 0x86663f},
                                  {0x583d27, 0x523824, 0x604629}, 0xb59a5c, 0.08f, 1.0f, 0.5f, 0.6f, 0.85f, kDead};
constexpr FoliageKind kNeedle = {{0x4f6534, 0x466038, 0x57683a}, {0x3a5230, 0x355034, 0x435630},
                                 {0x2b402a, 0x29402e, 0x32452a}, 0x7d6a3a, 0.03f, 0.9f, 0.15f, 0.4f, 0.6f, kThick};
constexpr FoliageKind kFreshNeedle = {{0x86a052, 0x7d9a55, 0x8fa04f}, {0x67863f, 0x5f8243, 0x728a40},
                                      {0x527036, 0x4c6c3a, 0x5c7436}, 0xa8984f, 0.03f, 0.9f, 0.15f, 0.4f, 0.6f, kGreen};
constexpr FoliageKind kGoldenNeedle = {{0xc0a545, 0xb8983a, 0xc4aa50}, {0xb58a2e, 0xad7c2a, 0xbd9236},
                                       {0x96682a, 0x8f5f27, 0xa0752c}, 0x7a5a30, 0.06f, 1.0f, 0.15f, 0.45f, 0.7f, kGolden};
constexpr FoliageKind kGrassBlade = {{0x7d8f42, 0x74883f, 0x87924a}, {0x5d7734, 0x567234, 0x687c38},
                                     {0x46602b, 0x405c2c, 0x50652e}, 0xb5a068, 0.12f, 0.9f, 0.3f, 0.4f, 0.65f, kBlade};
constexpr FoliageKind kDryGrass = {{0xc4b07c, 0xb8a470, 0xc9b688}, {0xa8935c, 0x9c8852, 0xb09c68},
                                   {0x857244, 0x7d6a3e, 0x8f7c4e}, 0x76803c, 0.12f, 1.0f, 0.3f, 0.5f, 0.75f, kDead};
constexpr FoliageKind kWhitePetal = {{0xf0ece0, 0xece8da, 0xf2ead4}, {0xe6e0d0, 0xe2dcc8, 0xeadfc2},
                                     {0xd6cdb4, 0xd2c9b2, 0xdccca6}, 0xb89a70, 0.04f, 0.8f, 0.25f, 0.5f, 0.7f, kThin};
constexpr FoliageKind kPetal = {{0xd9b036, 0x9a6ab8, 0xc4484a}, {0xd99f26, 0x8458a8, 0xb53038},
                                {0xc28420, 0x6a4494, 0x962430}, 0x8f7040, 0.04f, 0.8f, 0.25f, 0.45f, 0.7f, kThin};
constexpr FoliageKind kFern = {{0x7f9440, 0x748d40, 0x8a9846}, {0x5c7a34, 0x547634, 0x667f36},
                               {0x436028, 0x3e5e2a, 0x4c642a}, 0x9a7a3a, 0.05f, 0.8f, 0.35f, 0.45f, 0.7f, kGreen};
// clang-format on

}  // namespace

void AddFoliageMaterials(MaterialList& list) {
  const MaterialTags own = {.diffuse = true, .any_object = false};
  const std::pair<const char*, const FoliageKind*> kinds[] = {{"AutumnLeaf", &kAutumn},
                                                              {"DryGrass", &kDryGrass},
                                                              {"DryLeaf", &kDryLeaf},
                                                              {"FernLeaf", &kFern},
                                                              {"FreshNeedle", &kFreshNeedle},
                                                              {"GoldenNeedle", &kGoldenNeedle},
                                                              {"GrassBlade", &kGrassBlade},
                                                              {"Needle", &kNeedle},
                                                              {"Petal", &kPetal},
                                                              {"SpringLeaf", &kSpring},
                                                              {"SummerLeaf", &kSummer},
                                                              {"WhitePetal", &kWhitePetal}};
  for (const auto& [name, kind] : kinds) {
    list.push_back(Entry<Foliage>(name, "foliage", own, *kind));
  }
}

}  // namespace parallax
