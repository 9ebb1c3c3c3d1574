// The principled surface as a BSDF: evaluated, sampled, and with the density of sampling. Bsdf8
// does eight points at a time, because nothing here waits for memory; Bsdf does one.
//
// A blend of three bases lies below sheen below clearcoat. Metal is GGX with Schlick's Fresnel of
// the base colour and with the energy of multiple bounces between facets. Plastic is GGX above a
// Lambertian base that gets exactly the light that the gloss leaves. Glass is GGX reflection and
// refraction; thin-walled glass passes the rest straight through. Diffuse, conductor and dielectric
// are limits of the blend. Part of the Lambertian base may be subsurface scattering without its
// sideways spread: the Lommel-Seeliger law for one scattering inside, and Lambert for further ones.
// A sheet passes `transmitted_color` of the light below its gloss to the other side, as Lambert;
// both of its faces are alike. Every setting reflects at most the light that it receives, and
// reflection and the passage through sheets are reciprocal. Refraction carries flux, not radiance:
// the squared ratio of indices, which cancels out over a closed body, is left out.
//
// Local frame: z is the shading normal on the viewer's side; o and i are unit and point away from
// the surface. Constant.
#pragma once

#include <optional>

#include "worker/materials/kernel/material.h"
#include "worker/render/surface/microfacet.h"

namespace parallax {

// BSDF times cosine, and the density of sampling that direction, per solid angle.
struct BsdfValue8 {
  Vec3x8 f_cos = Vec3x8::Zero();  // f * |cos of i|.
  Float8 pdf = Splat(0);
};

// A surface's answer, towards o, to light that varies little over its lobes: the shares that it
// scatters of the irradiance over pi on o's side and on the other, and of the radiance about the
// mirror direction.
struct AmbientParts8 {
  Vec3x8 above, below, gloss;
};

// A sampled direction of light, local frame.
struct BsdfDirection8 {
  Vec3x8 direction;
  Float8 blur;     // How much the ray cone widens, in radians.
  Mask8 straight;  // Through a thin wall, direction = -o: no event for MIS.
  Mask8 refracted;
  Mask8 valid;  // Else it is absorbed.
};

// The BSDF at eight points.
class Bsdf8 {
 public:
  // `outside` says whether o is on the side that the triangle's winding faces.
  Bsdf8(const SurfaceSample8& surface, const Vec3x8& o, Mask8 outside);

  // Returns the BSDF times cosine, and density, for light from unit i. Excludes the straight part.
  BsdfValue8 Evaluate(const Vec3x8& i) const;

  // Samples a direction. `lobe` picks the lobe, `u` and `v` the direction in it; all are in [0, 1).
  // The density is Evaluate's.
  BsdfDirection8 Sample(Float8 lobe, Float8 u, Float8 v) const;

  // Returns whether the surface is too sharp for light sampling to be of use.
  Mask8 mirror_like() const { return mirror_like_; }
  // Returns whether light from the far side is scattered too.
  Mask8 translucent() const { return p_through_ > 0.0f; }
  // Returns the chance that a sample of glass passes through it.
  Float8 PassChance() const;
  // Returns the surface's answer to wide light, its glass left out.
  AmbientParts8 Ambient() const;
  // Return the transmittance of a smooth thin wall for light that is not deflected, and the chance
  // to sample that way.
  const Vec3x8& Straight() const { return straight_; }
  Float8 StraightChance() const { return p_straight_; }

 private:
  BsdfValue8 EvaluateReflection(const Vec3x8& i) const;
  BsdfValue8 EvaluateRefraction(const Vec3x8& i) const;
  BsdfValue8 EvaluateThinPassage(const Vec3x8& i) const;
  BsdfValue8 EvaluateThroughSheet(const Vec3x8& i) const;
  // Returns the reflectance of the glass part for a facet seen at this cosine.
  Float8 GlassReflectance(Float8 cosine) const;
  // Return the transmittance to the layers below: of sheen and clearcoat together, and of clearcoat
  // alone.
  Float8 Transmitted(Float8 cosine) const;
  Float8 CoatLeft(Float8 cosine) const;

  // Lobes that none of the eight lanes has are skipped; lanes without a lobe add nothing to it.
  bool any_metal_, any_glass_, any_coat_, any_sheen_, any_subsurface_, any_through_;

  Vec3x8 o_;
  Vec3x8 metal_f0_;
  Vec3x8 diffuse_;     // Base colour times the weight of plastic, over 1 - mean gloss.
  Vec3x8 through_;     // Likewise, for light that a sheet scatters to its other side.
  Vec3x8 multiple_;    // Colour of light bouncing between a metal's facets, over 1 - mean energy.
  Vec3x8 glass_tint_;  // Tint of one refraction or one pass through a thin wall.
  Float8 metal_, plastic_, glass_;
  Float8 plastic_f0_, plastic_f90_;
  Float8 eta_;  // Index on the far side over that on o's.
  Mask8 thin_;
  Vec3x8 straight_;  // Transmittance straight through a smooth thin wall.
  Mask8 mirror_like_;
  Ggx8 gloss_;
  EnergyOfAlpha8 gloss_energy_;
  // For direction o: Smith's Lambda; the visible share of facets over 4 cos o.
  Float8 lambda_o_, seen_o_;
  Ggx8 coat_gloss_;
  EnergyOfAlpha8 coat_energy_;
  Float8 coat_, sheen_, subsurface_;
  Float8 scattered_o_;  // Subsurface light that leaves after one scattering.
  Float8 kept_o_plastic_, kept_o_white_, transmitted_o_;
  // Chances of the parts; they sum to 1.
  Float8 p_coat_, p_gloss_, p_diffuse_, p_through_, p_glass_, p_straight_;
};

// A sampled direction of light for one point, local frame.
struct BsdfSample {
  Vec3f direction = Vec3f::UnitZ();
  Vec3f weight = Vec3f::Zero();  // f * |cos| / density.
  float pdf = 0;                 // Per solid angle; unused when `straight`.
  float blur = 0;
  bool straight = false;
};

// As BsdfValue8, for one point.
struct BsdfValue {
  Vec3f f_cos = Vec3f::Zero();
  float pdf = 0;
};

// The BSDF at one point. `o` is unit; `outside` is as for Bsdf8.
class Bsdf {
 public:
  Bsdf(const SurfaceSample& surface, const Vec3f& o, bool outside);

  BsdfValue Evaluate(const Vec3f& i) const;
  // Returns nothing when the sample is absorbed.
  std::optional<BsdfSample> Sample(float lobe, const Vec2f& u) const;
  Vec3f Straight() const { return eight_.Straight().Get(0); }

 private:
  Bsdf8 eight_;  // All lanes are equal.
};

}  // namespace parallax
