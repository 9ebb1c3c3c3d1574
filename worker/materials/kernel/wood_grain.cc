#include "worker/materials/kernel/wood_grain.h"

namespace parallax {

using namespace noise;  // NOLINT: the vocabulary of patterns.

const WoodSpecies kOak = {0xc9a477, 0x98693c, 3, 6.5, 0.75, 0.40, 1.0, 6, 0.02};
const WoodSpecies kWalnut = {0x7d5a41, 0x472c1d, 3, 7, 0.85, 0.45, 0.7, 9, 0.01};
const WoodSpecies kPine = {0xe0bd86, 0xb97f45, 4, 9, 1.0, 0.30, 0.0, 7, 0.22};
const WoodSpecies kCherry = {0xb4764e, 0x8b4a2b, 2.5, 5, 0.6, 0.35, 0.15, 8, 0.01};
const WoodSpecies kBeech = {0xd8b58b, 0xc0925f, 2, 4, 0.45, 0.35, 0.25, 4, 0.0};
const WoodSpecies kMahogany = {0x8f4a2e, 0x64291a, 4, 8, 0.55, 0.50, 0.6, 10, 0.0};
const WoodSpecies kAsh = {0xdcc7a4, 0xab8757, 3, 7, 0.9, 0.35, 0.9, 8, 0.01};
const WoodSpecies kEbony = {0x3a2b22, 0x1d1512, 1.5, 3, 0.7, 0.50, 0.3, 3, 0.0};

WoodGrain::WoodGrain(Rng& rng, const WoodSpecies& species) {
  early_ = VaryColor(rng, SrgbColor(species.early_srgb), 0.12, 0.05);
  late_ = VaryColor(rng, SrgbColor(species.late_srgb), 0.10, 0.05);
  pore_ = late_ * 0.45f;
  ring_m_ = Draw(rng, species.ring_low_mm, species.ring_high_mm) * 1e-3f;
  contrast_ = Float(species.ring_contrast) * Draw(rng, 0.75, 1.05);
  late_share_ = Float(species.late_share);
  pores_ = Float(species.pores) * Draw(rng, 0.6, 1.0);
  figure_m_ = Float(species.figure_mm) * Draw(rng, 0.6, 1.4) * 1e-3f;
  knots_ = Float(species.knots);
  streaks_ = Draw(rng, 0.10, 0.22);
  // The saw passes the heart at some distance: near gives cathedrals, far gives straight lines.
  const double distance = rng.Uniform(0.015, 0.11), angle = rng.Uniform(0, 6.2831853);
  heart_y_m_ = Float(distance * std::cos(angle));
  heart_z_m_ = Float(distance * std::sin(angle));
  fold_m_ = Draw(rng, 0.24, 0.5);
  tilt_y_ = Draw(rng, -0.3, 0.3);
  tilt_z_ = Draw(rng, -0.3, 0.3);
  seed_ = DrawSeed(rng);
}

template <typename Vec>
RealOf<Vec> WoodGrain::Pores(const Vec& p_m, Float8 footprint_m) const {
  constexpr float kMean = 0.12f;  // Mean of the step below.
  const Float8 fade = Fade(1.4e-3f, footprint_m);
  if (pores_ <= 0 || !Any(fade > 0)) return Splat(pores_ * kMean);
  const auto n = Gradient3(p_m.x * 90.0f, p_m.y * 1400.0f, p_m.z * 1400.0f, seed_ + 11);
  return pores_ * (kMean + fade * (SmoothStep(0.22f, 0.5f, n) - kMean));
}

Float8 WoodGrain::Fold(Float8 x_m) const {
  return fold_m_ * (1.0f / 6.2831853f) * noise::CosTurn(x_m / fold_m_ - 0.25f);
}

WoodGrain::Point WoodGrain::At(const Vec3x8& p_m, const Vec3x8& face, Float8 footprint_m) const {
  const Float8 x = p_m.x;

  // Distance from the heart, bent by slow wander, by figure, and by knots pushing the rings aside.
  const Float8 wander = Gradient3(x * 1.3f, p_m.y * 2.0f, p_m.z * 2.0f, seed_);
  // The body is folded every few hands' breadths, so that no part of a wide panel lies so far from
  // a heart that its rings would be mere parallel lines.
  const Float8 y = Fold(p_m.y) + heart_y_m_ + tilt_y_ * Fold(0.3f * x) + 0.02f * wander;
  const Float8 z = Fold(p_m.z + 0.09f) + heart_z_m_ + tilt_z_ * Fold(0.3f * x) - 0.015f * wander;
  Float8 r = Sqrt(y * y + z * z);
  r += figure_m_ * Gradient3(x * 5.0f, p_m.y * 22.0f, p_m.z * 22.0f, seed_ + 1);
  r += 0.25f * figure_m_ * Gradient3(x * 14.0f, p_m.y * 90.0f, p_m.z * 90.0f, seed_ + 2);
  Float8 knot = Splat(0);
  if (knots_ > 0) {
    const noise::Cell8 cell =
        noise::Cells3(Vec3x8(x * 4.0f, p_m.y * 8.3f, p_m.z * 8.3f), seed_ + 3, 0.7f);
    const Float8 d2 = cell.f1 * cell.f1;
    knot = noise::Unit(cell.id) < knots_ ? 1.0f / (1.0f + 900.0f * d2 * d2 + 90.0f * d2) : knot;
    r += 0.028f * knot;
    knot *= Fade(0.06f, footprint_m);
  }

  // Where in its year the point grew: pale in spring, dark towards autumn, then a sharp end.
  const Float8 years = r / ring_m_;
  const Float8 shift = 0.6f * Gradient2(years * 0.23f, Splat(0.3f), seed_ + 4);
  const Float8 phase = noise::Fract(years + shift);
  const Float8 along = (y * face.y + z * face.z) / Max(r, 1e-4f);
  const Float8 ring_shown_m = ring_m_ / Sqrt(Max(0.01f, 1.0f - along * along));
  const Float8 ring_fade = Fade(ring_shown_m, footprint_m);
  const Float8 sharp = Max(0.05f, footprint_m / ring_shown_m);
  const Float8 rise = SmoothStep(0.85f - 1.6f * late_share_, 0.97f - sharp * 0.5f, phase);
  const Float8 late = rise * (1.0f - SmoothStep(1.0f - sharp, 1.0f, phase));
  const float mean_late = 0.8f * late_share_ + 0.07f;  // From where the rise is half done.
  // Good and bad years come in groups: these bands still show where single rings have faded.
  const Float8 group =
      Fade(7.0f * ring_shown_m, footprint_m) * Gradient2(years * 0.16f, Splat(0.3f), seed_ + 8);
  const Float8 dark = contrast_ * (mean_late + (late - mean_late) * ring_fade + 0.3f * group);

  // Fibres at three widths run along x; the widest are the streaks that one sees from across the
  // room.
  const Float8 fine = Fade(1.5e-3f, footprint_m);
  const Float8 middle = Fade(5e-3f, footprint_m);
  Float8 fibre = Splat(0);
  if (Any(middle > 0)) {
    fibre += 0.8f * middle * Gradient3(x * 5.0f, p_m.y * 210.0f, p_m.z * 210.0f, seed_ + 5);
  }
  if (Any(fine > 0)) {
    fibre += fine * Gradient3(x * 16.0f, p_m.y * 800.0f, p_m.z * 800.0f, seed_ + 6);
  }
  const Float8 streak =
      Fade(0.025f, footprint_m) * Gradient3(x * 1.7f, p_m.y * 42.0f, p_m.z * 42.0f, seed_ + 7);
  const Float8 pores = Pores(p_m, footprint_m) * (1.2f - late);

  Point out;
  out.color = Mix(early_, late_, Saturate(dark + 0.35f * streak));
  out.color = out.color * (1.0f + 0.16f * fibre + streaks_ * streak);
  out.color = Mix(out.color, pore_, Saturate(0.75f * pores));
  if (knots_ > 0) out.color = Mix(out.color, pore_, 0.75f * SmoothStep(0.15f, 0.75f, knot));
  out.color = Albedo(out.color);
  out.roughness_gain = 1.0f + 0.18f * fibre + 0.25f * pores - 0.1f * late;
  return out;
}

template <typename Vec>
RealOf<Vec> WoodGrain::HeightAt(const Vec& p_m, Float8 footprint_m) const {
  auto height = -6e-5f * Pores(p_m, footprint_m);
  const Float8 fine = Fade(1.5e-3f, footprint_m);
  const Float8 middle = Fade(5e-3f, footprint_m);
  if (Any(fine > 0)) {
    height += 1.2e-5f * fine * Gradient3(p_m.x * 16.0f, p_m.y * 800.0f, p_m.z * 800.0f, seed_ + 6);
  }
  if (Any(middle > 0)) {
    height += 3e-5f * middle * Gradient3(p_m.x * 5.0f, p_m.y * 210.0f, p_m.z * 210.0f, seed_ + 5);
  }
  return height;
}

template Float8 WoodGrain::HeightAt(const Vec3x8&, Float8) const;
template Dual8 WoodGrain::HeightAt(const DualVec8&, Float8) const;

WoodFinish::WoodFinish(Rng& rng) {
  const double kind = rng.Uniform();
  specular = Draw(rng, 0.35, 0.5);
  clearcoat = 0;
  clearcoat_roughness = 0.1f;
  if (kind < 0.4) {  // Oiled.
    roughness = Draw(rng, 0.45, 0.62);
  } else if (kind < 0.8) {  // Satin varnish.
    roughness = Draw(rng, 0.32, 0.45);
    clearcoat = Draw(rng, 0.1, 0.3);
    clearcoat_roughness = Draw(rng, 0.25, 0.4);
  } else {  // Gloss varnish.
    roughness = Draw(rng, 0.3, 0.4);
    clearcoat = Draw(rng, 0.5, 0.9);
    clearcoat_roughness = Draw(rng, 0.06, 0.15);
  }
}

void WoodFinish::Apply(const WoodGrain::Point& grain, SurfaceSample8& out) const {
  out.base_color = grain.color;
  out.roughness = Saturate(roughness * grain.roughness_gain);
  out.specular = Splat(specular);
  out.clearcoat = Splat(clearcoat);
  out.clearcoat_roughness = Splat(clearcoat_roughness);
}

}  // namespace parallax
