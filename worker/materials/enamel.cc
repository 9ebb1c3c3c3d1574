// Enamel of one colour, for machines and bathrooms: baked on sheet steel, or fired on ceramic.
#include <span>

#include "worker/materials/kernel/material_families.h"
#include "worker/materials/kernel/surface.h"

namespace parallax {
namespace {

using namespace noise;  // NOLINT: the vocabulary of patterns.

struct EnamelStyle {
  std::span<const uint32_t> usual, colours;  // sRGB.
  double usual_share;
  double roughness_low, roughness_high;
  double peel_um;  // Depth of the orange peel.
};

constexpr uint32_t kMachines[] = {0xeeeeea, 0xe9e9e4, 0xf0efe9, 0xe4e3dc, 0x18191b, 0x202225,
                                  0x2b2d30, 0x9a9da0, 0xb6b8b9, 0x74787c, 0xe8e1cc, 0xd9d6cf};
constexpr uint32_t kRetro[] = {0x9fc2bd, 0xa9302a, 0x2f4a63, 0xd8b45a,
                               0xb7c9a2, 0xd9a6a0, 0x31564a, 0xc7d6de};
constexpr uint32_t kSanitary[] = {0xf0efeb, 0xf1f0ee, 0xeceae4, 0xe9e5da, 0xefece2};
constexpr uint32_t kBathrooms[] = {0xc9dcd6, 0xe6cfcb, 0xcfdbe6, 0xd8d2b4,
                                   0x2b3a4a, 0x232426, 0x8fa08c, 0xb98f84};

class Enamel final : public Carved<Enamel> {
 public:
  Enamel(Rng& rng, const EnamelStyle& style) {
    const bool usual = rng.Bernoulli(style.usual_share);
    color_ = VaryColor(rng, SrgbColor(rng.Pick(usual ? style.usual : style.colours)), 0.05, 0.02);
    roughness_ = Draw(rng, style.roughness_low, style.roughness_high);
    peel_m_ = Draw(rng, 1.5e-3, 4e-3);
    depth_m_ = Draw(rng, 0.9, 1.5) * static_cast<float>(style.peel_um) * 1e-6f;
    used_ = rng.Bernoulli(0.4) ? Draw(rng, 0.05, 0.2) : 0.0f;
    seed_ = DrawSeed(rng);
  }
  SurfaceSample8 Evaluate(const SurfacePoint8& point) const override {
    const Float8 w = point.footprint_m;
    const Float8 n = Fbm3(point.texture_m, 0.25f, 3, w, seed_);
    const Float8 smear = Fbm3(point.texture_m, 0.09f, 4, w, seed_ + 1);
    SurfaceSample8 out;
    out.base_color = Albedo(color_ * (1.0f + 0.02f * n));
    // Where hands and cloths go it is duller.
    out.roughness = Saturate(roughness_ + used_ * Max(0.0f, smear));
    out.clearcoat = Splat(0.3f);
    return out;
  }
  auto HeightOf(const auto& point) const {
    return depth_m_ * Fbm3(point.texture_m, peel_m_, 2, point.footprint_m, seed_ + 3);
  }

 private:
  Vec3f color_;
  float roughness_, peel_m_, depth_m_, used_;
};

}  // namespace

void AddEnamelMaterials(MaterialList& list) {
  list.push_back(Entry<Enamel>("ApplianceEnamel", "paint", {},
                               EnamelStyle{kMachines, kRetro, 0.78, 0.1, 0.34, 22}));
  list.push_back(Entry<Enamel>("SanitaryCeramic", "ceramic", {},
                               EnamelStyle{kSanitary, kBathrooms, 0.75, 0.05, 0.16, 20}));
}

}  // namespace parallax
