// Family `fabric`: terry cloth. Loops of cotton stand on a ground weave, row by row and each
// leaning its own way; now and then a flat band woven without loops runs across.
#include <array>

#include "worker/materials/kernel/material_families.h"
#include "worker/materials/kernel/surface.h"

namespace parallax {
namespace {

using namespace noise;  // NOLINT: the vocabulary of patterns.

class TerryCloth final : public Carved<TerryCloth> {
 public:
  explicit TerryCloth(Rng& rng) {
    static constexpr std::array<uint32_t, 16> kTowels = {
        0xf0ece2, 0xe4dccd, 0xcbb89c, 0xa8b7bd, 0x7f98a8, 0x3f5f7d, 0x24324a, 0x9fb3a0,
        0x5f7a66, 0xd9a9a0, 0xb5606a, 0x7a2f3a, 0xd9a64a, 0xc9723f, 0x8a8784, 0x3d3d40};
    loop_m_ = Draw(rng, 0.0017, 0.003);
    stretch_ = Draw(rng, 1.15, 1.7);
    pile_ = VaryColor(rng, SrgbColor(rng.Pick(kTowels)), 0.1, 0.05);
    deep_ = Albedo(pile_ * Draw(rng, 0.42, 0.6));
    band_ = rng.Bernoulli(0.3) ? VaryColor(rng, SrgbColor(rng.Pick(kTowels)), 0.1, 0.05)
                               : Albedo(pile_ * 0.9f);
    // Worn towels are crushed in patches and have pulled loops.
    crush_ = Draw(rng, 0.25, 0.8);
    period_m_ = Draw(rng, 0.3, 0.6);
    band_m_ = rng.Bernoulli(0.5) ? Draw(rng, 0.018, 0.045) : 0.0f;
    ribs_m_ = Draw(rng, 0.0018, 0.004);
    phase_ = Draw(rng, 0, 1);
    seed_ = DrawSeed(rng);
  }

  SurfaceSample8 Evaluate(const SurfacePoint8& point) const override {
    const Float8 w = point.footprint_m;
    const PlanePoint8 plane = OnPlane(point);
    const Float8 fade = Fade(1.5f * loop_m_, w);
    Float8 top = Splat(kMean), own = Splat(0);
    if (Any(fade > 0)) {
      const noise::Cell8 cell = At(plane);
      top += fade * (Loop(cell) - kMean);
      own = fade * (UnitByte(cell.id, 1) - 0.5f);
    }
    // The nap lies this way and that, as after drying.
    const Float8 nap = Fbm3(point.texture_m, 0.045f, 4, w, seed_ + 3, 0.6f);
    const Vec3x8 loops = Mix(deep_, pile_, top) * (1.0f + 0.22f * own + 0.35f * crush_ * nap);
    const Float8 band = Band(plane, w);
    const Vec3x8 flat = band_ * (1.0f + 0.18f * Ribs(plane, w));
    return {.base_color = Albedo(Mix(loops, flat, band)),
            .roughness = Splat(0.95f),
            .specular = Splat(0.2f),
            .sheen = Saturate(0.5f + 0.2f * nap - 0.3f * band)};
  }

  auto HeightOf(const auto& point) const {
    const Float8 w = point.footprint_m;
    const auto plane = OnPlane(point);
    const auto band = Band(plane, w);
    return (1.0f - band) * 0.42f * loop_m_ * Loops(plane, w) +
           0.08f * ribs_m_ * band * Ribs(plane, w) +
           crush_ * 5e-4f * Fbm3(point.texture_m, 0.02f, 2, w, seed_ + 4);
  }

 private:
  static constexpr float kMean = 0.46f;

  template <typename Real>
  noise::CellOf8<Vec3Of8<Real>> At(const PlaneOf8<Real>& plane) const {
    const Real u = plane.u / (stretch_ * loop_m_), v = plane.v / loop_m_;
    const Real shake = 0.25f * Gradient2(0.9f * u, 0.9f * v, seed_ + 5);
    return noise::Cells2(u + shake, v - shake, seed_, 0.7f);
  }
  template <typename Real>
  Real Loops(const PlaneOf8<Real>& plane, Float8 w) const {
    const Float8 fade = Fade(1.5f * loop_m_, w);
    if (!Any(fade > 0)) return Splat(0);
    return fade * Loop(At(plane));
  }
  // A small arch seen from above: long, narrow, turned its own way; 0 where it meets the next.
  template <typename Vec>
  static RealOf<Vec> Loop(const noise::CellOf8<Vec>& cell) {
    const Float8 turn = 0.25f * (UnitByte(cell.id, 2) - 0.5f);
    const Float8 c = noise::CosTurn(turn), s = noise::CosTurn(turn - 0.25f);
    const auto along = c * cell.offset.x + s * cell.offset.y;
    const auto across = c * cell.offset.y - s * cell.offset.x;
    const auto far = along * along / 0.5f + across * across / 0.2f;
    return Saturate(1.25f - far) * SmoothStep(0.0f, 0.22f, cell.f2 - cell.f1);
  }
  // 1 within a flat band.
  template <typename Real>
  Real Band(const PlaneOf8<Real>& plane, Float8 w) const {
    if (band_m_ <= 0) return Splat(0);
    const float share = band_m_ / period_m_;
    const Float8 fade = Fade(period_m_, w);
    if (!Any(fade > 0)) return Splat(share);
    const Real at = Abs(noise::Fract(plane.u / period_m_ + phase_) - 0.5f) * period_m_;
    return share + fade * (LineShare(at, 0.5f * band_m_, 0.002f, w) - share);
  }
  template <typename Real>
  Real Ribs(const PlaneOf8<Real>& plane, Float8 w) const {
    return Fade(ribs_m_, w) * noise::CosTurn(plane.u / ribs_m_);
  }

  Vec3f pile_, deep_, band_;
  float loop_m_, stretch_, crush_, period_m_, band_m_, ribs_m_, phase_;
};

}  // namespace

void AddTowelMaterials(MaterialList& list) {
  list.push_back(Entry<TerryCloth>("TerryCloth", "fabric", {.diffuse = true}));
}

}  // namespace parallax
