// GGX with its distribution of visible normals, Fresnel's equations, and tables of the energy that
// one bounce keeps; for eight surfaces at a time. Local frames: z is the normal; o and i point away
// from the surface.
#pragma once

#include "common/math/lanes.h"
#include "worker/render/surface/sampling.h"

namespace parallax {

// Isotropic GGX of the given alpha (= roughness^2).
struct Ggx8 {
  Float8 alpha;

  // Returns the density of facets with normal h.
  Float8 D(const Vec3x8& h) const {
    const Float8 a2 = alpha * alpha;
    const Float8 q = (h.x * h.x + h.y * h.y) / a2 + h.z * h.z;
    return kInvPi / (a2 * q * q);
  }
  // Returns Smith's auxiliary function for direction w.
  Float8 Lambda(const Vec3x8& w) const {
    const Float8 tan2 = (w.x * w.x + w.y * w.y) / Max(w.z * w.z, 1e-20f);
    return 0.5f * (Sqrt(1.0f + alpha * alpha * tan2) - 1.0f);
  }
  // Returns the masking of one direction.
  Float8 G1(const Vec3x8& w) const { return 1.0f / (1.0f + Lambda(w)); }
  // Returns the height-correlated masking and shadowing.
  Float8 G2(const Vec3x8& o, const Vec3x8& i) const {
    return 1.0f / (1.0f + Lambda(o) + Lambda(i));
  }

  // Samples a normal visible from o (o.z > 0), for a turn of 2 pi u and v in [0, 1).   Source:
  // Dupuy and Benyoub, "Sampling visible GGX normals with spherical caps", 2023.
  Vec3x8 SampleVisible(const Vec3x8& o, const Turn8& turn, Float8 v) const {
    const Vec3x8 stretched = Normalized({alpha * o.x, alpha * o.y, o.z});
    const Float8 z = Clamp((1.0f - v) * (1.0f + stretched.z) - stretched.z, -1.0f, 1.0f);
    const Float8 sine = Sqrt(Max(1.0f - z * z, 0.0f));
    return Normalized({alpha * (sine * turn.cosine + stretched.x),
                       alpha * (sine * turn.sine + stretched.y), Max(z + stretched.z, 1e-6f)});
  }
};

// Returns Schlick's Fresnel weight (1 - cosine)^5.
inline Float8 SchlickWeight(Float8 cosine) {
  const Float8 m = Clamp(1.0f - cosine, 0.0f, 1.0f);
  const Float8 m2 = m * m;
  return m2 * m2 * m;
}

// Returns the unpolarised Fresnel reflectance at a medium of relative index eta (transmitted /
// incident), for cosine >= 0.
inline Float8 DielectricFresnel(Float8 cosine, Float8 eta) {
  const Float8 sin2_t = (1.0f - cosine * cosine) / (eta * eta);
  const Float8 cos_t = Sqrt(Max(1.0f - sin2_t, 0.0f));
  const Float8 parallel = (eta * cosine - cos_t) / (eta * cosine + cos_t);
  const Float8 perpendicular = (cosine - eta * cos_t) / (cosine + eta * cos_t);
  const Float8 reflectance = 0.5f * (parallel * parallel + perpendicular * perpendicular);
  return sin2_t >= 1.0f ? Splat(1) : reflectance;
}

// Share of energy that one GGX reflection keeps with Fresnel F = f0 (1 - s) + f90 s, where s is
// Schlick's weight: f0 * a + f90 * b.
struct KeptEnergy8 {
  Float8 a, b;
  Float8 At(Float8 f0, Float8 f90) const { return f0 * a + f90 * b; }
  // Returns the kept energy for a Fresnel reflectance of 1.
  Float8 White() const { return a + b; }
};
// The table's row for one alpha, to be read at many cosines.
class EnergyOfAlpha8 {
 public:
  static constexpr int kSteps = 32;  // Nodes in sqrt(cosine) and in sqrt(alpha), both over [0, 1].

  EnergyOfAlpha8() = default;
  explicit EnergyOfAlpha8(Float8 alpha);
  KeptEnergy8 At(Float8 cosine) const;
  // Returns the cosine-weighted mean over the hemisphere.
  KeptEnergy8 Mean() const;

 private:
  Int8 row_{};
  Float8 fraction_{};
};

// Returns the share of energy that a full sheen layer reflects.
Float8 SheenEnergy(Float8 cosine);

}  // namespace parallax
