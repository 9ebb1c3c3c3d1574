// Family `paper`: sheets, page blocks, cardboard, kraft.
#include <array>

#include "worker/materials/kernel/material_families.h"
#include "worker/materials/kernel/surface.h"

namespace parallax {
namespace {

using namespace noise;  // NOLINT: the vocabulary of patterns.

// Fibres in every direction, a little yellowed in clouds.
class Paper final : public Carved<Paper> {
 public:
  explicit Paper(Rng& rng) {
    static constexpr std::array<uint32_t, 7> kSheets = {0xe9e6df, 0xe4dcc8, 0xdfd3b8, 0xd8d9da,
                                                        0xcbb9a0, 0xc9d0c0, 0xd9bfb8};
    sheet_ = VaryColor(rng, SrgbColor(rng.Pick(kSheets)), 0.05, 0.03);
    fibre_ = Draw(rng, 0.04, 0.12);
    foxing_ = rng.Bernoulli(0.4) ? Draw(rng, 0.05, 0.3) : 0.0f;
    seed_ = DrawSeed(rng);
  }
  SurfaceSample8 Evaluate(const SurfacePoint8& point) const override {
    const Float8 w = point.footprint_m;
    const Vec3x8& p = point.texture_m;
    const Float8 fibre = Fbm3(p, 0.012f, 4, w, seed_, 0.65f);
    const Float8 cloud = Fbm3(p, 0.12f, 4, w, seed_ + 2);
    const Float8 old =
        foxing_ * noise::Above(noise::Fbm3Filtered(p, 0.07f, 5, w, seed_ + 4, 0.6f), 0.4f, 0.3f);
    return {.base_color = Albedo(
                Mix(sheet_ * (1.0f + fibre_ * fibre + 0.05f * cloud), SrgbColor(0xa8845a), old)),
            .roughness = Splat(0.85f),
            .specular = Splat(0.3f)};
  }
  auto HeightOf(const auto& point) const {
    return 1.2e-5f * Fbm3(point.texture_m, 0.002f, 2, point.footprint_m, seed_ + 7) +
           1e-4f * Fbm3(point.texture_m, 0.08f, 2, point.footprint_m, seed_ + 8);
  }

 private:
  Vec3f sheet_;
  float fibre_, foxing_;
};

// The edges of a book's leaves: thin lines across z.
class PageEdges final : public Carved<PageEdges> {
 public:
  explicit PageEdges(Rng& rng) {
    sheet_ = VaryColor(rng, SrgbColor(rng.Bernoulli(0.6) ? 0xe2dac6 : 0xe8e5de), 0.06, 0.03);
    leaf_m_ = Draw(rng, 0.0003, 0.0007);
    seed_ = DrawSeed(rng);
  }
  SurfaceSample8 Evaluate(const SurfacePoint8& point) const override {
    const Float8 w = point.footprint_m;
    const Vec3x8& p = point.texture_m;
    Float8 lines =
        0.5f * Fade(leaf_m_, w) * Gradient3(p.x * 8.0f, p.y * 8.0f, p.z / leaf_m_, seed_);
    lines += 0.6f * Fade(5.0f * leaf_m_, w) *
             Gradient3(p.x * 3.0f, p.y * 3.0f, 0.2f * p.z / leaf_m_, seed_ + 1);
    lines += 0.5f * Fade(0.008f, w) * Gradient3(p.x * 2.0f, p.y * 2.0f, p.z * 120.0f, seed_ + 2);
    const Float8 cloud = Fbm3(p, 0.06f, 3, w, seed_ + 3);
    return {.base_color = Albedo(sheet_ * (0.93f + 0.22f * lines + 0.05f * cloud)),
            .roughness = Splat(0.9f),
            .specular = Splat(0.25f)};
  }
  auto HeightOf(const auto& point) const {
    const Float8 w = point.footprint_m;
    const auto& p = point.texture_m;
    return 4e-5f * Fade(leaf_m_, w) * Gradient3(p.x * 8.0f, p.y * 8.0f, p.z / leaf_m_, seed_) +
           8e-5f * Fade(5.0f * leaf_m_, w) *
               Gradient3(p.x * 3.0f, p.y * 3.0f, 0.2f * p.z / leaf_m_, seed_ + 1);
  }

 private:
  Vec3f sheet_;
  float leaf_m_;
};

// Brown board: flutes show through as soft bands across x; specks of bark.
class Cardboard final : public Carved<Cardboard> {
 public:
  explicit Cardboard(Rng& rng) {
    board_ = VaryColor(rng, SrgbColor(0xb08a5f), 0.12, 0.04);
    flute_m_ = Draw(rng, 0.005, 0.009);
    flutes_ = Draw(rng, 0.2, 1.0);
    seed_ = DrawSeed(rng);
  }
  SurfaceSample8 Evaluate(const SurfacePoint8& point) const override {
    const Float8 w = point.footprint_m;
    const Vec3x8& p = point.texture_m;
    const Float8 fibre = Fbm3(Vec3x8(0.5f * p.x, p.y, p.z), 0.008f, 4, w, seed_, 0.65f);
    const Float8 speck =
        noise::Above(noise::Fbm3Filtered(p, 0.004f, 2, w, seed_ + 3), 0.75f, 0.08f);
    const Float8 scuff = Fbm3(p, 0.12f, 5, w, seed_ + 5, 0.6f);
    return {.base_color =
                Albedo(board_ * ((1.0f + 0.09f * fibre + 0.07f * scuff) * (1.0f - 0.45f * speck) *
                                 (1.0f + 0.03f * flutes_ * Flutes(OnPlane(point), w)))),
            .roughness = Saturate(0.82f + 0.06f * scuff),
            .specular = Splat(0.3f)};
  }
  auto HeightOf(const auto& point) const {
    return 6e-5f * flutes_ * Flutes(OnPlane(point), point.footprint_m) +
           1.5e-5f * Fbm3(point.texture_m, 0.003f, 2, point.footprint_m, seed_ + 6);
  }

 private:
  template <typename Real>
  Real Flutes(const PlaneOf8<Real>& plane, Float8 w) const {
    return Fade(flute_m_, w) * noise::CosTurn(plane.u / flute_m_);
  }

  Vec3f board_;
  float flute_m_, flutes_;
};

}  // namespace

void AddPaperMaterials(MaterialList& list) {
  const MaterialTags dull = {.diffuse = true};
  list.push_back(Entry<Cardboard>("Cardboard", "paper", dull));
  list.push_back(Entry<PageEdges>("PageEdges", "paper", {.diffuse = true, .any_object = false}));
  list.push_back(Entry<Paper>("Paper", "paper", dull));
}

}  // namespace parallax
