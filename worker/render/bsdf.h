// The principled surface as a scattering function: evaluated, sampled, and with the density of
// sampling; of eight points at a time, for nothing here waits for memory. Bsdf is that of one.
//
// A blend of three bases - metal (GGX with Schlick's Fresnel of the base colour and what multiple
// bounces between facets give back), plastic (GGX above a Lambert base that gets exactly what the
// gloss leaves) and glass (GGX reflection and refraction; thin-walled glass lets the rest straight
// through) - below sheen below clearcoat. Diffuse, conductor and dielectric are its limits. Part of
// the Lambert base may be subsurface scattering, without its sideways spread: the law of Lommel and
// Seeliger (one scattering inside) and, as Lambert, what further scatterings give back. A sheet
// scatters `transmitted_color` of the light below its gloss through to the other side, as Lambert;
// both of its faces are alike. Every setting gives back at most what it receives, and reflection
// and the passage through sheets are reciprocal. Refraction carries flux,
// not radiance: the squared ratio of indices that cancels out over a closed body is left out.
//
// Local frame: z is the shading normal on the viewer's side; o and i are unit and point away from
// the surface. Constant.
#pragma once

#include <optional>

#include "worker/materials/material.h"
#include "worker/render/microfacet.h"

namespace parallax {

struct BsdfValue8 {
  Vec3x8 f_cos = Vec3x8::Zero();  // f * |cos of i|.
  Float8 pdf = Splat(0);
};

struct BsdfDirection8 {
  Vec3x8 direction;
  Float8 blur;     // How much the ray cone widens, in radians.
  Mask8 straight;  // Through a thin wall, direction = -o: no event for MIS.
  Mask8 refracted;
  Mask8 valid;  // Else it is absorbed.
};

class Bsdf8 {
 public:
  // `outside`: o is on the side that the triangle's winding faces.
  Bsdf8(const SurfaceSample8& surface, const Vec3x8& o, Mask8 outside);

  // Value and density for light from i; the straight part is not in it.
  BsdfValue8 Evaluate(const Vec3x8& i) const;

  // `lobe` picks the part, `u` and `v` the direction; all in [0, 1). Its density is Evaluate's.
  BsdfDirection8 Sample(Float8 lobe, Float8 u, Float8 v) const;

  // So sharp that light sampling is useless.
  Mask8 mirror_like() const { return mirror_like_; }
  // Scatters light from its far side, too.
  Mask8 translucent() const { return p_through_ > 0.0f; }
  // Chance that a sample of glass goes through it.
  Float8 PassChance() const;
  // Transmittance of a smooth thin wall without deflection; the chance to sample that way.
  const Vec3x8& Straight() const { return straight_; }
  Float8 StraightChance() const { return p_straight_; }

 private:
  BsdfValue8 EvaluateReflection(const Vec3x8& i) const;
  BsdfValue8 EvaluateRefraction(const Vec3x8& i) const;
  BsdfValue8 EvaluateThinPassage(const Vec3x8& i) const;
  BsdfValue8 EvaluateThroughSheet(const Vec3x8& i) const;
  // Reflectance of the glass part for a facet seen at this cosine.
  Float8 GlassReflectance(Float8 cosine) const;
  // Transmittance of sheen and clearcoat together, and of clearcoat alone, to the layers below.
  Float8 Transmitted(Float8 cosine) const;
  Float8 CoatLeft(Float8 cosine) const;

  // Lobes that none of the eight lanes has are skipped; lanes without a lobe add nothing to it.
  bool any_metal_, any_glass_, any_coat_, any_sheen_, any_subsurface_, any_through_;

  Vec3x8 o_;
  Vec3x8 metal_f0_;
  Vec3x8 diffuse_;     // Base colour times the weight of plastic, over 1 - mean gloss.
  Vec3x8 through_;     // Likewise, of what a sheet scatters to its other side.
  Vec3x8 multiple_;    // Colour of light bouncing between a metal's facets, over 1 - mean energy.
  Vec3x8 glass_tint_;  // Tint of one refraction or one pass through a thin wall.
  Float8 metal_, plastic_, glass_;
  Float8 plastic_f0_, plastic_f90_;
  Float8 eta_;  // Index on the far side over that on o's.
  Mask8 thin_;
  Vec3x8 straight_;  // Passed straight through a smooth thin wall.
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

struct BsdfSample {
  Vec3f direction = Vec3f::UnitZ();
  Vec3f weight = Vec3f::Zero();  // f * |cos| / density.
  float pdf = 0;                 // Per solid angle; unused when `straight`.
  float blur = 0;
  bool straight = false;
};

struct BsdfValue {
  Vec3f f_cos = Vec3f::Zero();
  float pdf = 0;
};

class Bsdf {
 public:
  Bsdf(const SurfaceSample& surface, const Vec3f& o, bool outside);

  BsdfValue Evaluate(const Vec3f& i) const;
  // None when the direction is absorbed.
  std::optional<BsdfSample> Sample(float lobe, const Vec2f& u) const;
  Vec3f Straight() const { return eight_.Straight().Get(0); }

 private:
  Bsdf8 eight_;  // All alike.
};

}  // namespace parallax
