// The principled surface of one point as a scattering function: evaluated, sampled, and with the
// density of sampling.
//
// A blend of three bases - metal (GGX with Schlick's Fresnel of the base colour and what multiple
// bounces between facets give back), plastic (GGX above a Lambert base that gets exactly what the
// gloss leaves) and glass (GGX reflection and refraction; thin-walled glass lets the rest straight
// through) - below sheen below clearcoat. Diffuse, conductor and dielectric are its limits. Part of
// the Lambert base may be subsurface scattering, without its sideways spread: the law of Lommel and
// Seeliger (one scattering inside) and, as Lambert, what further scatterings give back. Every
// setting reflects at most what it receives, and reflection is reciprocal. Refraction carries flux,
// not radiance: the squared ratio of indices that cancels out over a closed body is left out.
//
// Local frame: z is the shading normal on the viewer's side; o and i are unit and point away from
// the surface. Constant.
#pragma once

#include <optional>

#include "worker/materials/material.h"
#include "worker/render/microfacet.h"

namespace parallax {

struct BsdfSample {
  Vec3f direction = Vec3f::UnitZ();
  Vec3f weight = Vec3f::Zero();  // f * |cos| / density.
  float pdf = 0;                 // Per solid angle; unused when `straight`.
  float blur = 0;                // How much the ray cone widens, in radians.
  bool straight = false;         // Through a thin wall, direction = -o: no event for MIS.
};

struct BsdfValue {
  Vec3f f_cos = Vec3f::Zero();  // f * |cos of i|.
  float pdf = 0;
};

class Bsdf {
 public:
  // `outside`: o is on the side that the triangle's winding faces. Alpha is at least `min_alpha`
  // (path regularisation).
  Bsdf(const SurfaceSample& surface, const Vec3f& o, bool outside, float min_alpha = 0);

  // Value and density for light from i; the straight part is not in it.
  BsdfValue Evaluate(const Vec3f& i) const;

  // `lobe` picks the part, `u` the direction. None when the direction is absorbed.
  std::optional<BsdfSample> Sample(float lobe, const Vec2f& u) const;

  // So sharp that light sampling is useless.
  bool mirror_like() const { return mirror_like_; }
  // Chance that a sample of glass goes through it.
  float PassChance() const;
  // What a smooth thin wall lets straight through.
  Vec3f Straight() const { return straight_; }

 private:
  BsdfValue EvaluateReflection(const Vec3f& i) const;
  BsdfValue EvaluateRefraction(const Vec3f& i) const;
  BsdfValue EvaluateThinPassage(const Vec3f& i) const;
  // Reflectance of the glass part for a facet seen at this cosine.
  float GlassReflectance(float cosine) const;
  // What sheen and clearcoat leave to the layers below.
  float Transmitted(float cosine) const;

  Vec3f o_;
  Vec3f metal_f0_;
  Vec3f diffuse_;     // Base colour times the weight of plastic, over 1 - mean gloss.
  Vec3f multiple_;    // Colour of light bouncing between a metal's facets, over 1 - mean energy.
  Vec3f glass_tint_;  // Of one refraction or one pass through a thin wall.
  float metal_ = 0, plastic_ = 0, glass_ = 0;
  float plastic_f0_ = 0, plastic_f90_ = 0;
  float eta_ = 1;  // Index on the far side over that on o's.
  bool thin_ = false;
  Vec3f straight_;  // Passed straight through a smooth thin wall.
  bool mirror_like_ = false;
  Ggx gloss_{1};
  EnergyOfAlpha gloss_energy_;
  // Of o: Smith's Lambda, which part of the facets it sees over 4 cos o.
  float lambda_o_ = 0, seen_o_ = 0;
  Ggx coat_gloss_{1};
  float coat_ = 0, sheen_ = 0, subsurface_ = 0;
  float scattered_o_ = 0;  // Subsurface light that leaves after one scattering.
  float kept_o_plastic_ = 0, kept_o_white_ = 0, transmitted_o_ = 1;
  // Chances of the parts; they sum to 1.
  float p_coat_ = 0, p_gloss_ = 0, p_diffuse_ = 0, p_glass_ = 0, p_straight_ = 0;
};

}  // namespace parallax
