// GGX with its distribution of visible normals, Fresnel's equations, and tables of the energy that
// one bounce keeps. Local frames: z is the normal; o and i point away from the surface.
#pragma once

#include <array>

#include "worker/render/sampling.h"

namespace parallax {

// Isotropic GGX of the given alpha (= roughness^2).
struct Ggx {
  float alpha;

  float D(const Vec3f& h) const {
    const float a2 = alpha * alpha;
    const float q = (h.x() * h.x() + h.y() * h.y()) / a2 + h.z() * h.z();
    return kInvPi / (a2 * q * q);
  }
  float Lambda(const Vec3f& w) const {
    const float tan2 = (w.x() * w.x() + w.y() * w.y()) / std::max(w.z() * w.z(), 1e-20f);
    return 0.5f * (std::sqrt(1.0f + alpha * alpha * tan2) - 1.0f);
  }
  float G1(const Vec3f& w) const { return 1.0f / (1.0f + Lambda(w)); }
  // Height-correlated masking and shadowing.
  float G2(const Vec3f& o, const Vec3f& i) const { return 1.0f / (1.0f + Lambda(o) + Lambda(i)); }

  // A normal seen from o (o.z > 0).   Source: Dupuy and Benyoub, "Sampling visible GGX normals with
  // spherical caps", 2023.
  Vec3f SampleVisible(const Vec3f& o, const Vec2f& u) const {
    const Vec3f stretched = Vec3f(alpha * o.x(), alpha * o.y(), o.z()).normalized();
    const float phi = 2.0f * kPi * u.x();
    const float z = (1.0f - u.y()) * (1.0f + stretched.z()) - stretched.z();
    const Vec3f h = DirectionAt(std::clamp(z, -1.0f, 1.0f), phi) + stretched;
    return Vec3f(alpha * h.x(), alpha * h.y(), std::max(h.z(), 1e-6f)).normalized();
  }
  // Its density.
  float PdfVisible(const Vec3f& o, const Vec3f& h) const {
    return D(h) * G1(o) * std::max(0.0f, o.dot(h)) / o.z();
  }
};

inline float SchlickWeight(float cosine) {
  const float m = std::clamp(1.0f - cosine, 0.0f, 1.0f);
  const float m2 = m * m;
  return m2 * m2 * m;
}

// Unpolarised reflectance where light meets a medium of relative index eta (transmitted / incident)
// at cosine >= 0.
inline float DielectricFresnel(float cosine, float eta) {
  const float sin2_t = (1.0f - cosine * cosine) / (eta * eta);
  if (sin2_t >= 1.0f) return 1.0f;
  const float cos_t = std::sqrt(1.0f - sin2_t);
  const float parallel = (eta * cosine - cos_t) / (eta * cosine + cos_t);
  const float perpendicular = (cosine - eta * cos_t) / (cosine + eta * cos_t);
  return 0.5f * (parallel * parallel + perpendicular * perpendicular);
}

// Part of the energy that one GGX reflection keeps with Fresnel F = f0 (1 - s) + f90 s, s =
// Schlick's weight: f0 * a + f90 * b.
struct KeptEnergy {
  float a = 0, b = 0;
  float At(float f0, float f90) const { return f0 * a + f90 * b; }
  float White() const { return a + b; }
};
KeptEnergy DirectionalEnergy(float cosine, float alpha);
// The same for many cosines at one alpha.
class EnergyOfAlpha {
 public:
  static constexpr int kSteps = 32;  // Nodes in sqrt(cosine) and in sqrt(alpha), both over [0, 1].
  using Row = std::array<KeptEnergy, kSteps>;  // By cosine.

  explicit EnergyOfAlpha(float alpha);
  KeptEnergy At(float cosine) const;

 private:
  const Row* low_;
  const Row* high_;
  float fraction_;
};
// Cosine-weighted mean over the hemisphere.
KeptEnergy MeanEnergy(float alpha);

// Part of the energy that a full sheen layer reflects.
float SheenEnergy(float cosine);

}  // namespace parallax
