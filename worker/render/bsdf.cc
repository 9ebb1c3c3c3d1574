#include "worker/render/bsdf.h"

namespace parallax {
namespace {

constexpr float kMinAlpha = 1e-3f;     // Sharper is numerically a mirror.
constexpr float kMirrorAlpha = 4e-3f;  // Sharper needs no light sampling.
constexpr float kStraightAlpha =
    0.01f;  // Thin walls up to here don't scatter what they let through.
constexpr float kCoatF0 = 0.04f;

Vec3f Clamp01(const Vec3f& v) { return v.cwiseMax(0.0f).cwiseMin(1.0f); }

// Part of the light that leaves a white half-space after one scattering, for light at this cosine;
// its cosine-weighted mean.   Source: Lommel and Seeliger; Chandrasekhar, "Radiative transfer".
float SingleScattering(float cosine) {
  const float c = std::max(cosine, 1e-6f);
  return 1.0f - c * std::log1p(1.0f / c);
}
constexpr float kMeanSingleScattering = 0.40913709f;  // 4/3 (1 - ln 2).

float ThinReflectance(float reflectance) { return 2.0f * reflectance / (1.0f + reflectance); }

float AlphaOf(float roughness, float min_alpha) {
  return std::clamp(Square(roughness), std::max(kMinAlpha, min_alpha), 1.0f);
}

}  // namespace

Bsdf::Bsdf(const SurfaceSample& surface, const Vec3f& o, bool outside, float min_alpha)
    : o_(o),
      gloss_{AlphaOf(surface.roughness, min_alpha)},
      gloss_energy_(gloss_.alpha),
      lambda_o_(gloss_.Lambda(o)),
      seen_o_(1.0f / ((1.0f + lambda_o_) * 4.0f * o.z())) {
  const Vec3f base = Clamp01(surface.base_color);
  const float transmission = std::clamp(surface.transmission, 0.0f, 1.0f);
  metal_ = std::clamp(surface.metallic, 0.0f, 1.0f);
  glass_ = (1.0f - metal_) * transmission;
  plastic_ = (1.0f - metal_) * (1.0f - transmission);
  thin_ = surface.thin_walled;
  const float alpha = gloss_.alpha;
  coat_ = std::clamp(surface.clearcoat, 0.0f, 1.0f);
  coat_gloss_ = Ggx{AlphaOf(surface.clearcoat_roughness, min_alpha)};
  sheen_ = std::clamp(surface.sheen, 0.0f, 1.0f) * plastic_;

  plastic_f0_ = 0.08f * std::clamp(surface.specular, 0.0f, 1.0f);
  plastic_f90_ = std::min(1.0f, 50.0f * plastic_f0_);
  subsurface_ = plastic_ > 0.0f ? std::clamp(surface.subsurface, 0.0f, 1.0f) : 0.0f;
  if (subsurface_ > 0.0f) scattered_o_ = SingleScattering(o.z());
  metal_f0_ = base;
  const float ior = std::max(surface.ior, 1.0f + 1e-3f);
  eta_ = thin_ || outside ? ior : 1.0f / ior;
  glass_tint_ = thin_ ? base : Vec3f(base.cwiseSqrt());

  const KeptEnergy kept = gloss_energy_.At(o.z());
  const KeptEnergy mean = MeanEnergy(alpha);
  kept_o_plastic_ = kept.At(plastic_f0_, plastic_f90_);
  kept_o_white_ = kept.White();
  diffuse_ = base * (plastic_ / (1.0f - mean.At(plastic_f0_, plastic_f90_)));
  if (metal_ > 0.0f) {
    const float e = mean.White();
    const Vec3f f = base + (Vec3f::Ones() - base) / 21.0f;  // Mean of Schlick's Fresnel.
    const Vec3f bounced =
        f.cwiseProduct(f).cwiseProduct((Vec3f::Ones() - f * (1.0f - e)).cwiseInverse()) * e;
    multiple_ = bounced * (metal_ / std::max(1.0f - e, 1e-3f));
  } else {
    multiple_ = Vec3f::Zero();
  }
  transmitted_o_ = Transmitted(o.z());

  // Chances by the energy of each part.
  const float coat = coat_ * DirectionalEnergy(o.z(), coat_gloss_.alpha).At(kCoatF0, 1.0f);
  const float metal_kept = kept.At(Luminance(base), 1.0f);
  const float gloss = transmitted_o_ * (metal_ * metal_kept + plastic_ * kept_o_plastic_);
  const float diffuse = transmitted_o_ * (plastic_ * (1.0f - kept_o_plastic_) * Luminance(base) +
                                          metal_ * (1.0f - kept_o_white_) * Luminance(base)) +
                        sheen_ * SheenEnergy(o.z());
  const bool lets_straight = thin_ && Square(surface.roughness) <= kStraightAlpha;
  straight_ = lets_straight ? Vec3f(glass_tint_ * (glass_ * (1.0f - GlassReflectance(o.z())) *
                                                   Square(transmitted_o_)))
                            : Vec3f::Zero();
  const float straight = Luminance(straight_);
  const float glass = transmitted_o_ * glass_ * (lets_straight ? GlassReflectance(o.z()) : 1.0f);
  const float total = coat + gloss + diffuse + straight + glass;
  if (total > 0.0f) {
    p_coat_ = coat / total;
    p_gloss_ = gloss / total;
    p_diffuse_ = diffuse / total;
    p_straight_ = straight / total;
    p_glass_ = glass / total;
  }
  const bool sharp = alpha <= kMirrorAlpha && (coat_ <= 0.0f || coat_gloss_.alpha <= kMirrorAlpha);
  mirror_like_ = sharp && p_diffuse_ < 0.02f;
}

float Bsdf::GlassReflectance(float cosine) const {
  const float reflectance = DielectricFresnel(cosine, eta_);
  return thin_ ? ThinReflectance(reflectance) : reflectance;
}

float Bsdf::Transmitted(float cosine) const {
  if (coat_ <= 0.0f && sheen_ <= 0.0f) return 1.0f;
  const float c = std::abs(cosine);
  float left = 1.0f;
  if (coat_ > 0.0f) {
    left *= 1.0f - coat_ * DirectionalEnergy(c, coat_gloss_.alpha).At(kCoatF0, 1.0f);
  }
  if (sheen_ > 0.0f) left *= 1.0f - sheen_ * SheenEnergy(c);
  return left;
}

BsdfValue Bsdf::Evaluate(const Vec3f& i) const {
  if (o_.z() <= 0.0f) return {};
  return i.z() > 0.0f ? EvaluateReflection(i) : EvaluateRefraction(i);
}

BsdfValue Bsdf::EvaluateReflection(const Vec3f& i) const {
  BsdfValue value;
  const Vec3f h = (o_ + i).normalized();
  const float cos_h = std::max(0.0f, o_.dot(h));
  const float schlick = SchlickWeight(cos_h);
  const float transmitted = transmitted_o_ * Transmitted(i.z());

  // Gloss of metal and plastic, and glass's reflection: one lobe, three Fresnels.
  const float d = gloss_.D(h);
  const float masked = (1.0f + lambda_o_) / (1.0f + lambda_o_ + gloss_.Lambda(i));
  const float pdf_h = d * seen_o_;
  const float lobe = pdf_h * masked;  // Times cos i; height-correlated masking.
  const float glass_reflectance = glass_ > 0.0f ? GlassReflectance(cos_h) : 0.0f;
  const Vec3f fresnel =
      metal_ * (metal_f0_ + (Vec3f::Ones() - metal_f0_) * schlick) +
      Vec3f::Constant(plastic_ * (plastic_f0_ + (plastic_f90_ - plastic_f0_) * schlick) +
                      glass_ * glass_reflectance);
  value.f_cos = fresnel * (lobe * transmitted);
  value.pdf = (p_gloss_ + p_glass_ * (p_straight_ > 0.0f ? 1.0f : glass_reflectance)) * pdf_h;

  // Lambert below the gloss, facets' multiple bounces.
  const float cosine = i.z() * kInvPi;
  if (plastic_ > 0.0f || metal_ > 0.0f) {
    const KeptEnergy kept = gloss_energy_.At(i.z());
    float below = (1.0f - kept_o_plastic_) * (1.0f - kept.At(plastic_f0_, plastic_f90_)) * cosine;
    if (subsurface_ > 0.0f) {
      // Over Lambert's value: one scattering, and the rest.
      const float inside = 0.5f / (o_.z() + i.z()) + (1.0f - scattered_o_) *
                                                         (1.0f - SingleScattering(i.z())) /
                                                         (1.0f - kMeanSingleScattering);
      below *= 1.0f + subsurface_ * (inside - 1.0f);
    }
    const float between = (1.0f - kept_o_white_) * (1.0f - kept.White()) * cosine;
    value.f_cos += (diffuse_ * below + multiple_ * between) * transmitted;
  }
  value.pdf += p_diffuse_ * cosine;

  if (sheen_ > 0.0f) {
    const float coat_left =
        coat_ > 0.0f
            ? (1.0f - coat_ * DirectionalEnergy(o_.z(), coat_gloss_.alpha).At(kCoatF0, 1.0f)) *
                  (1.0f - coat_ * DirectionalEnergy(i.z(), coat_gloss_.alpha).At(kCoatF0, 1.0f))
            : 1.0f;
    value.f_cos += Vec3f::Constant(sheen_ * schlick * i.z() * coat_left);
  }
  if (coat_ > 0.0f) {
    const float coat_d = coat_gloss_.D(h);
    const float f = kCoatF0 + (1.0f - kCoatF0) * schlick;
    value.f_cos += Vec3f::Constant(coat_ * f * coat_d * coat_gloss_.G2(o_, i) / (4.0f * o_.z()));
    value.pdf += p_coat_ * coat_d * coat_gloss_.G1(o_) / (4.0f * o_.z());
  }
  return value;
}

BsdfValue Bsdf::EvaluateRefraction(const Vec3f& i) const {
  if (glass_ <= 0.0f || p_straight_ > 0.0f) return {};
  if (thin_) return EvaluateThinPassage(i);
  Vec3f h = (o_ + eta_ * i).normalized();
  if (h.z() < 0.0f) h = -h;
  const float cos_o = o_.dot(h);
  const float cos_i = i.dot(h);
  if (cos_o <= 0.0f || cos_i >= 0.0f) return {};
  const float through = 1.0f - DielectricFresnel(cos_o, eta_);
  // Jacobian of h by i.   Source: Walter et al., "Microfacet models for refraction", EGSR 2007,
  // eq. 17.
  const float jacobian = eta_ * eta_ * -cos_i / Square(cos_o + eta_ * cos_i);
  const Vec3f mirrored(i.x(), i.y(), -i.z());
  const float d = gloss_.D(h);
  const float common = d * through * jacobian * cos_o / o_.z();
  BsdfValue value;
  value.f_cos = glass_tint_ *
                (glass_ * common * gloss_.G2(o_, mirrored) * transmitted_o_ * Transmitted(i.z()));
  value.pdf = p_glass_ * common * gloss_.G1(o_);
  return value;
}

// As if mirrored, then put on the other side.
BsdfValue Bsdf::EvaluateThinPassage(const Vec3f& i) const {
  const Vec3f mirrored(i.x(), i.y(), -i.z());
  const Vec3f h = (o_ + mirrored).normalized();
  const float through = 1.0f - GlassReflectance(std::max(0.0f, o_.dot(h)));
  const float common = gloss_.D(h) * through / (4.0f * o_.z());
  BsdfValue value;
  value.f_cos = glass_tint_ *
                (glass_ * common * gloss_.G2(o_, mirrored) * transmitted_o_ * Transmitted(i.z()));
  value.pdf = p_glass_ * common * gloss_.G1(o_);
  return value;
}

float Bsdf::PassChance() const {
  if (p_straight_ > 0.0f) return p_straight_;
  return p_glass_ * (1.0f - GlassReflectance(o_.z()));
}

std::optional<BsdfSample> Bsdf::Sample(float lobe, const Vec2f& u) const {
  if (o_.z() <= 0.0f) return std::nullopt;
  BsdfSample sample;
  if (lobe < p_straight_) {
    sample.direction = -o_;
    sample.weight = straight_ / p_straight_;
    sample.straight = true;
    return sample;
  }
  lobe -= p_straight_;
  bool refracted = false;
  if (lobe < p_diffuse_) {
    sample.direction = SampleCosineHemisphere(u);
    sample.blur = 0.5f;
  } else if (lobe < p_diffuse_ + p_coat_) {
    const Vec3f h = coat_gloss_.SampleVisible(o_, u);
    sample.direction = 2.0f * o_.dot(h) * h - o_;
    sample.blur = 0.5f * coat_gloss_.alpha;
  } else if (lobe < p_diffuse_ + p_coat_ + p_gloss_ || p_glass_ <= 0.0f) {
    const Vec3f h = gloss_.SampleVisible(o_, u);
    sample.direction = 2.0f * o_.dot(h) * h - o_;
    sample.blur = 0.5f * gloss_.alpha;
  } else {
    const Vec3f h = gloss_.SampleVisible(o_, u);
    const float cos_h = o_.dot(h);
    const float reflectance = p_straight_ > 0.0f ? 1.0f : GlassReflectance(cos_h);
    const float choice = (lobe - p_diffuse_ - p_coat_ - p_gloss_) / p_glass_;
    if (choice < reflectance) {
      sample.direction = 2.0f * cos_h * h - o_;
    } else if (thin_) {
      sample.direction = 2.0f * cos_h * h - o_;
      sample.direction.z() = -sample.direction.z();
      refracted = true;
    } else {
      const float sin2_t = (1.0f - cos_h * cos_h) / (eta_ * eta_);
      const float cos_t = std::sqrt(std::max(0.0f, 1.0f - sin2_t));
      sample.direction = (-o_ / eta_ + (cos_h / eta_ - cos_t) * h).normalized();
      refracted = true;
    }
    sample.blur = 0.5f * gloss_.alpha;
  }
  // Facets can mirror light into the surface; shadowing says that it is absorbed there.
  if (refracted ? sample.direction.z() >= 0.0f : sample.direction.z() <= 0.0f) return std::nullopt;
  const BsdfValue value = Evaluate(sample.direction);
  if (!(value.pdf > 0.0f) || !std::isfinite(value.pdf)) return std::nullopt;
  sample.pdf = value.pdf;
  sample.weight = value.f_cos / value.pdf;
  return sample;
}

}  // namespace parallax
