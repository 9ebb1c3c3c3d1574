#include "worker/render/surface/bsdf.h"

namespace parallax {
namespace {

constexpr float kMinAlpha = 1e-3f;     // Below this it is numerically a mirror.
constexpr float kMirrorAlpha = 4e-3f;  // Below this, light sampling is useless.
// Thin walls up to this roughness transmit without scattering.
constexpr float kStraightAlpha = 0.01f;
constexpr float kCoatF0 = 0.04f;

Float8 Clamp01(Float8 x) { return Clamp(x, 0.0f, 1.0f); }
Vec3x8 Clamp01(const Vec3x8& v) { return {Clamp01(v.x), Clamp01(v.y), Clamp01(v.z)}; }
Vec3x8 operator+(const Vec3x8& a, Float8 b) { return {a.x + b, a.y + b, a.z + b}; }
Vec3x8 MirroredAtPlane(const Vec3x8& v) { return {v.x, v.y, -v.z}; }

// Share of the light from a white half-space that leaves after one scattering, for light at this
// cosine.   Source: Lommel and Seeliger; Chandrasekhar, "Radiative transfer".
Float8 SingleScattering(Float8 cosine) {
  const Float8 c = Max(cosine, 1e-6f);
  return 1.0f - c * Log1p(1.0f / c);
}
constexpr float kMeanSingleScattering = 0.40913709f;  // 4/3 (1 - ln 2).

Float8 ThinReflectance(Float8 reflectance) { return 2.0f * reflectance / (1.0f + reflectance); }

Float8 AlphaOf(Float8 roughness) { return Clamp(Square(roughness), Splat(kMinAlpha), Splat(1)); }

// Concentric mapping of the unit square to a disk: the azimuth, and the radius, which is the sine
// of the angle to the pole of a cosine-weighted hemisphere.
void ConcentricDisk(Float8 u, Float8 v, Float8* angle, Float8* radius) {
  const Float8 a = 2.0f * u - 1.0f;
  const Float8 b = 2.0f * v - 1.0f;
  const Mask8 wide = Abs(a) > Abs(b);
  const Float8 long_side = wide ? a : b, short_side = wide ? b : a;
  const Float8 turn = kPi / 4 * (short_side / (long_side == 0.0f ? Splat(1) : long_side));
  *angle = wide ? turn : kPi / 2 - turn;
  *radius = long_side;
}

}  // namespace

Bsdf8::Bsdf8(const SurfaceSample8& surface, const Vec3x8& o, Mask8 outside) : o_(o) {
  const Vec3x8 base = Clamp01(surface.base_color);
  const Float8 luminance = Luminance(base);
  const Float8 transmission = Clamp01(surface.transmission);
  metal_ = Clamp01(surface.metallic);
  glass_ = (1.0f - metal_) * transmission;
  plastic_ = (1.0f - metal_) * (1.0f - transmission);
  thin_ = surface.thin_walled;
  coat_ = Clamp01(surface.clearcoat);
  sheen_ = Clamp01(surface.sheen) * plastic_;
  subsurface_ = plastic_ > 0.0f ? Clamp01(surface.subsurface) : Splat(0);
  any_metal_ = Any(metal_ > 0.0f);
  any_glass_ = Any(glass_ > 0.0f);
  any_coat_ = Any(coat_ > 0.0f);
  any_sheen_ = Any(sheen_ > 0.0f);
  any_subsurface_ = Any(subsurface_ > 0.0f);
  // Limited to the light that the base leaves.
  const Vec3x8 left = Vec3x8::All(Splat(1)) - base, wanted = Clamp01(surface.transmitted_color);
  const Vec3x8 through(Min(wanted.x, left.x), Min(wanted.y, left.y), Min(wanted.z, left.z));
  any_through_ = Any(MaxCoeff(through) > 0.0f);

  gloss_ = {AlphaOf(surface.roughness)};
  gloss_energy_ = EnergyOfAlpha8(gloss_.alpha);
  lambda_o_ = gloss_.Lambda(o);
  seen_o_ = 1.0f / ((1.0f + lambda_o_) * 4.0f * o.z);
  coat_gloss_ = {AlphaOf(surface.clearcoat_roughness)};
  if (any_coat_) coat_energy_ = EnergyOfAlpha8(coat_gloss_.alpha);

  plastic_f0_ = 0.08f * Clamp01(surface.specular);
  plastic_f90_ = Min(50.0f * plastic_f0_, 1.0f);
  scattered_o_ = any_subsurface_ ? SingleScattering(o.z) : Splat(0);
  metal_f0_ = base;
  const Float8 ior = Max(surface.ior, 1.0f + 1e-3f);
  eta_ = (thin_ | outside) ? ior : 1.0f / ior;
  glass_tint_ = Select(thin_, base, Sqrt(base));

  const KeptEnergy8 kept = gloss_energy_.At(o.z);
  const KeptEnergy8 mean = gloss_energy_.Mean();
  kept_o_plastic_ = kept.At(plastic_f0_, plastic_f90_);
  kept_o_white_ = kept.White();
  const Float8 over_kept = plastic_ / (1.0f - mean.At(plastic_f0_, plastic_f90_));
  diffuse_ = base * over_kept;
  through_ = through * over_kept;
  multiple_ = Vec3x8::Zero();
  if (any_metal_) {
    const Float8 e = mean.White();
    const Vec3x8 white = Vec3x8::All(Splat(1));
    const Vec3x8 f = base + (white - base) * (1.0f / 21.0f);  // Mean of Schlick's Fresnel.
    const Vec3x8 left = white - f * (1.0f - e);
    const Vec3x8 bounced = Vec3x8{f.x * f.x / left.x, f.y * f.y / left.y, f.z * f.z / left.z} * e;
    multiple_ = bounced * (metal_ / Max(1.0f - e, 1e-3f));
  }
  transmitted_o_ = Transmitted(o.z);

  // Probabilities of the lobes, by their energy.
  const Float8 coat =
      any_coat_ ? coat_ * coat_energy_.At(o.z).At(Splat(kCoatF0), Splat(1)) : Splat(0);
  const Float8 metal_kept = kept.At(luminance, Splat(1));
  const Float8 gloss = transmitted_o_ * (metal_ * metal_kept + plastic_ * kept_o_plastic_);
  Float8 diffuse = transmitted_o_ * luminance *
                   (plastic_ * (1.0f - kept_o_plastic_) + metal_ * (1.0f - kept_o_white_));
  if (any_sheen_) diffuse += sheen_ * SheenEnergy(o.z);
  straight_ = Vec3x8::Zero();
  Float8 glass = Splat(0), straight = Splat(0);
  if (any_glass_) {
    const Float8 reflectance = GlassReflectance(o.z);
    const Mask8 lets_straight = thin_ & (Square(surface.roughness) <= kStraightAlpha);
    const Float8 passed = glass_ * (1.0f - reflectance) * Square(transmitted_o_);
    straight_ = glass_tint_ * (lets_straight ? passed : Splat(0));
    straight = Luminance(straight_);
    glass = transmitted_o_ * glass_ * (lets_straight ? reflectance : Splat(1));
  }
  const Float8 passing =
      any_through_ ? transmitted_o_ * Luminance(through) * plastic_ * (1.0f - kept_o_plastic_)
                   : Splat(0);
  const Float8 total = coat + gloss + diffuse + straight + glass + passing;
  const Float8 part = total > 0.0f ? 1.0f / total : Splat(0);
  p_coat_ = coat * part;
  p_gloss_ = gloss * part;
  p_diffuse_ = diffuse * part;
  p_through_ = passing * part;
  p_straight_ = straight * part;
  p_glass_ = glass * part;
  mirror_like_ = (gloss_.alpha <= kMirrorAlpha) &
                 ((coat_ <= 0.0f) | (coat_gloss_.alpha <= kMirrorAlpha)) &
                 (p_diffuse_ + p_through_ < 0.02f);
}

Float8 Bsdf8::GlassReflectance(Float8 cosine) const {
  const Float8 reflectance = DielectricFresnel(cosine, eta_);
  return thin_ ? ThinReflectance(reflectance) : reflectance;
}

Float8 Bsdf8::CoatLeft(Float8 cosine) const {
  if (!any_coat_) return Splat(1);
  return 1.0f - coat_ * coat_energy_.At(cosine).At(Splat(kCoatF0), Splat(1));
}

Float8 Bsdf8::Transmitted(Float8 cosine) const {
  const Float8 c = Abs(cosine);
  const Float8 left = CoatLeft(c);
  return any_sheen_ ? left * (1.0f - sheen_ * SheenEnergy(c)) : left;
}

BsdfValue8 Bsdf8::Evaluate(const Vec3x8& i) const {
  const Mask8 above = i.z > 0.0f;
  BsdfValue8 value = EvaluateReflection(i);
  if ((any_glass_ || any_through_) && Any(~above)) {
    BsdfValue8 below;
    if (any_glass_) below = EvaluateRefraction(i);
    if (any_through_) {
      const Mask8 glass = glass_ > 0.0f;
      const BsdfValue8 through = EvaluateThroughSheet(i);
      below.f_cos = Select(glass, below.f_cos, Vec3x8::Zero()) + through.f_cos;
      below.pdf = (glass ? below.pdf : Splat(0)) + through.pdf;
    }
    value.f_cos = Select(above, value.f_cos, below.f_cos);
    value.pdf = above ? value.pdf : below.pdf;
  }
  const Mask8 seen = (o_.z > 0.0f) & (above | (glass_ > 0.0f) | translucent());
  return {Select(seen, value.f_cos, Vec3x8::Zero()), seen ? value.pdf : Splat(0)};
}

PARALLAX_LANE_CLONES BsdfValue8 Bsdf8::EvaluateReflection(const Vec3x8& i) const {
  BsdfValue8 value;
  const Vec3x8 h = Normalized(o_ + i);
  const Float8 cos_h = Max(Dot(o_, h), 0.0f);
  const Float8 schlick = SchlickWeight(cos_h);
  const Float8 transmitted = transmitted_o_ * Transmitted(i.z);

  // Gloss of metal and plastic and reflection of glass share one lobe and have three Fresnel terms.
  const Float8 masked = (1.0f + lambda_o_) / (1.0f + lambda_o_ + gloss_.Lambda(i));
  const Float8 pdf_h = gloss_.D(h) * seen_o_;
  const Float8 lobe = pdf_h * masked;  // Times cos i; height-correlated masking.
  const Float8 glass_reflectance = any_glass_ ? GlassReflectance(cos_h) : Splat(0);
  const Float8 colourless = plastic_ * (plastic_f0_ + (plastic_f90_ - plastic_f0_) * schlick) +
                            glass_ * glass_reflectance;
  const Vec3x8 fresnel = (metal_f0_ * (1.0f - schlick) + schlick) * metal_ + colourless;
  value.f_cos = fresnel * (lobe * transmitted);
  value.pdf = (p_gloss_ + p_glass_ * (p_straight_ > 0.0f ? Splat(1) : glass_reflectance)) * pdf_h;

  // Lambert below the gloss, and multiple bounces between facets.
  const Float8 cosine = i.z * kInvPi;
  const KeptEnergy8 kept = gloss_energy_.At(i.z);
  Float8 below = (1.0f - kept_o_plastic_) * (1.0f - kept.At(plastic_f0_, plastic_f90_)) * cosine;
  if (any_subsurface_) {
    // Ratio to Lambert: one scattering, and all further ones.
    const Float8 inside = 0.5f / (o_.z + i.z) + (1.0f - scattered_o_) *
                                                    (1.0f - SingleScattering(i.z)) *
                                                    (1.0f / (1.0f - kMeanSingleScattering));
    below *= subsurface_ > 0.0f ? 1.0f + subsurface_ * (inside - 1.0f) : Splat(1);
  }
  Vec3x8 wide = diffuse_ * below;
  if (any_metal_) {
    wide = wide + multiple_ * ((1.0f - kept_o_white_) * (1.0f - kept.White()) * cosine);
  }
  value.f_cos = value.f_cos + wide * transmitted;
  value.pdf += p_diffuse_ * cosine;

  if (any_sheen_) {
    value.f_cos = value.f_cos + sheen_ * schlick * i.z * CoatLeft(o_.z) * CoatLeft(i.z);
  }
  if (any_coat_) {
    const Float8 coat_d = coat_gloss_.D(h);
    const Float8 f = kCoatF0 + (1.0f - kCoatF0) * schlick;
    value.f_cos = value.f_cos + coat_ * f * coat_d * coat_gloss_.G2(o_, i) / (4.0f * o_.z);
    value.pdf += p_coat_ * coat_d * coat_gloss_.G1(o_) / (4.0f * o_.z);
  }
  return value;
}

BsdfValue8 Bsdf8::EvaluateRefraction(const Vec3x8& i) const {
  const BsdfValue8 thin = EvaluateThinPassage(i);
  Vec3x8 h = Normalized(o_ + i * eta_);
  h = Select(h.z < 0.0f, -h, h);
  const Float8 cos_o = Dot(o_, h);
  const Float8 cos_i = Dot(i, h);
  const Float8 through = 1.0f - DielectricFresnel(cos_o, eta_);
  // Jacobian of h by i.   Source: Walter et al., "Microfacet models for refraction", EGSR 2007,
  // eq. 17.
  const Float8 jacobian = eta_ * eta_ * -cos_i / Square(cos_o + eta_ * cos_i);
  const Float8 common = gloss_.D(h) * through * jacobian * cos_o / o_.z;
  const Vec3x8 f_cos = glass_tint_ * (glass_ * common * gloss_.G2(o_, MirroredAtPlane(i)) *
                                      transmitted_o_ * Transmitted(i.z));
  const Float8 pdf = p_glass_ * common * gloss_.G1(o_);
  const Mask8 solid = (cos_o > 0.0f) & (cos_i < 0.0f) & ~thin_;
  const Mask8 scatters = (p_straight_ <= 0.0f) & (thin_ | solid);
  return {Select(scatters, Select(thin_, thin.f_cos, f_cos), Vec3x8::Zero()),
          scatters ? (thin_ ? thin.pdf : pdf) : Splat(0)};
}

// Light enters below the gloss of one face and leaves through that of the other.
BsdfValue8 Bsdf8::EvaluateThroughSheet(const Vec3x8& i) const {
  const Float8 cosine = Abs(i.z);
  const Float8 kept = gloss_energy_.At(cosine).At(plastic_f0_, plastic_f90_);
  const Float8 common = (1.0f - kept_o_plastic_) * (1.0f - kept) * cosine * kInvPi;
  return {through_ * (common * transmitted_o_ * Transmitted(i.z)), p_through_ * cosine * kInvPi};
}

// Light is mirrored and then moved to the other side.
BsdfValue8 Bsdf8::EvaluateThinPassage(const Vec3x8& i) const {
  const Vec3x8 mirrored = MirroredAtPlane(i);
  const Vec3x8 h = Normalized(o_ + mirrored);
  const Float8 through = 1.0f - GlassReflectance(Max(Dot(o_, h), 0.0f));
  const Float8 common = gloss_.D(h) * through / (4.0f * o_.z);
  return {
      glass_tint_ * (glass_ * common * gloss_.G2(o_, mirrored) * transmitted_o_ * Transmitted(i.z)),
      p_glass_ * common * gloss_.G1(o_)};
}

AmbientParts8 Bsdf8::Ambient() const {
  const KeptEnergy8 kept = gloss_energy_.At(o_.z), mean = gloss_energy_.Mean();
  // Light from all sides passes coat and sheen about as at its mean cosine, mirrored light as o's.
  const Float8 passed = transmitted_o_ * Transmitted(Splat(2.0f / 3));
  const Float8 mirrored = transmitted_o_ * transmitted_o_;
  const Float8 below_gloss =
      passed * (1.0f - kept_o_plastic_) * (1.0f - mean.At(plastic_f0_, plastic_f90_));
  AmbientParts8 parts{diffuse_ * below_gloss, through_ * below_gloss,
                      Vec3x8::All(mirrored * plastic_ * kept_o_plastic_)};
  if (any_metal_) {
    const Float8 metal = mirrored * metal_;
    const auto gloss = [&](Float8 f0) { return metal * kept.At(f0, Splat(1)); };
    parts.gloss = parts.gloss + Vec3x8{gloss(metal_f0_.x), gloss(metal_f0_.y), gloss(metal_f0_.z)};
    parts.above =
        parts.above + multiple_ * (passed * (1.0f - kept_o_white_) * (1.0f - mean.White()));
  }
  if (any_sheen_) parts.above = parts.above + sheen_ * SheenEnergy(o_.z) * CoatLeft(o_.z);
  if (any_coat_) {
    const Float8 coat = coat_ * coat_energy_.At(o_.z).At(Splat(kCoatF0), Splat(1));
    parts.gloss = parts.gloss + coat;
  }
  return parts;
}

Float8 Bsdf8::PassChance() const {
  return p_straight_ > 0.0f ? p_straight_ : p_glass_ * (1.0f - GlassReflectance(o_.z));
}

PARALLAX_LANE_CLONES BsdfDirection8 Bsdf8::Sample(Float8 lobe, Float8 u, Float8 v) const {
  BsdfDirection8 sample;
  sample.straight = lobe < p_straight_;
  const Float8 rest = lobe - p_straight_;
  const Mask8 diffuse = rest < p_diffuse_;
  const Float8 p_wide = p_diffuse_ + p_through_;
  const Mask8 wide = rest < p_wide;
  const Mask8 through = wide & ~diffuse;
  const Mask8 coat = ~wide & (rest < p_wide + p_coat_);
  const Mask8 glass = (rest >= p_wide + p_coat_ + p_gloss_) & (p_glass_ > 0.0f);

  Float8 angle, radius;
  ConcentricDisk(u, v, &angle, &radius);
  const Turn8 turn(wide ? angle : 2.0f * kPi * u);
  const Vec3x8 scattered{radius * turn.cosine, radius * turn.sine,
                         Sqrt(Max(1.0f - radius * radius, 0.0f))};
  const Ggx8 facets{coat ? coat_gloss_.alpha : gloss_.alpha};
  const Vec3x8 h = facets.SampleVisible(o_, turn, v);
  const Float8 cos_h = Dot(o_, h);
  const Vec3x8 mirrored = h * (2.0f * cos_h) - o_;
  sample.direction = Select(diffuse, scattered, mirrored);
  if (any_through_)
    sample.direction = Select(through, MirroredAtPlane(scattered), sample.direction);
  sample.blur = wide ? Splat(0.5f) : 0.5f * facets.alpha;
  sample.refracted = Mask8{};
  if (Any(glass)) {
    const Float8 reflectance = p_straight_ > 0.0f ? Splat(1) : GlassReflectance(cos_h);
    const Float8 choice = (rest - p_wide - p_coat_ - p_gloss_) / p_glass_;
    sample.refracted = glass & (choice >= reflectance);
    const Float8 sin2_t = (1.0f - cos_h * cos_h) / (eta_ * eta_);
    const Float8 cos_t = Sqrt(Max(1.0f - sin2_t, 0.0f));
    const Vec3x8 bent = Normalized(h * (cos_h / eta_ - cos_t) - o_ * (1.0f / eta_));
    sample.direction =
        Select(sample.refracted, Select(thin_, MirroredAtPlane(mirrored), bent), sample.direction);
  }
  // Facets may mirror light into the surface, where it is absorbed by shadowing.
  const Float8 height = sample.direction.z;
  sample.valid = (o_.z > 0.0f) &
                 (sample.straight | ((sample.refracted | through) ? height < 0.0f : height > 0.0f));
  sample.direction = Select(sample.straight, -o_, sample.direction);
  return sample;
}

namespace {

SurfaceSample8 Alike(const SurfaceSample& surface) {
  SurfaceSample8 eight;
  for (int lane = 0; lane < kLanes; ++lane) eight.Set(lane, surface);
  return eight;
}

}  // namespace

Bsdf::Bsdf(const SurfaceSample& surface, const Vec3f& o, bool outside)
    : eight_(Alike(surface), Vec3x8(o), Mask8{} - (outside ? 1 : 0)) {}

BsdfValue Bsdf::Evaluate(const Vec3f& i) const {
  const BsdfValue8 value = eight_.Evaluate(Vec3x8(i));
  return {value.f_cos.Get(0), value.pdf[0]};
}

std::optional<BsdfSample> Bsdf::Sample(float lobe, const Vec2f& u) const {
  const BsdfDirection8 way = eight_.Sample(Splat(lobe), Splat(u.x()), Splat(u.y()));
  if (way.valid[0] == 0) return std::nullopt;
  BsdfSample sample;
  sample.direction = way.direction.Get(0);
  sample.blur = way.blur[0];
  sample.straight = way.straight[0] != 0;
  if (sample.straight) {
    sample.weight = Straight() / eight_.StraightChance()[0];
    return sample;
  }
  const BsdfValue value = Evaluate(sample.direction);
  if (!(value.pdf > 0.0f) || !std::isfinite(value.pdf)) return std::nullopt;
  sample.pdf = value.pdf;
  sample.weight = value.f_cos / value.pdf;
  return sample;
}

}  // namespace parallax
