#include "worker/render/paths/scattering.h"

#include "worker/render/scene/render_scene.h"

namespace parallax {
namespace {

// The shading normal on the viewer's side, bent just enough that the mirror direction stays above
// the surface (below it, glossy relief would turn black).
Vec3x8 UsableNormal(const Vec3x8& shading, const Vec3x8& geometric, const Vec3x8& out) {
  Vec3x8 n = shading;
  const Float8 facing = Dot(n, out);
  const Mask8 averted = facing < 0.01f;
  if (Any(averted)) n = Select(averted, Normalized(n + out * ((0.01f - facing) * 1.02f)), n);
  const Vec3x8 mirrored = n * (2.0f * Dot(n, out)) - out;
  const Float8 height = Dot(mirrored, geometric);
  const Mask8 dips = height < 0.01f;
  if (Any(dips)) {
    const Vec3x8 lifted = Normalized(mirrored + geometric * (0.01f - height));
    const Vec3x8 bisector = Normalized(lifted + out);
    n = Select(dips & (Dot(bisector, out) > 0.0f), bisector, n);
  }
  return n;
}

// Softens the terminator of a smooth mesh's face near its true horizon: rises from 0 to 1 within
// half the angle (its sine squared is `bend2`) between shading and true normal. Thus coarse faces
// cast no hard edge, and little light is lost: a factor that reaches further (Chiang et al. 2019)
// lost 0.7 % of a room's.
Float8 TerminatorFactor(Float8 true_cosine, Float8 bend2) {
  const Float8 t = 2.0f * true_cosine / Sqrt(bend2);
  return 4.0f * true_cosine * true_cosine >= bend2 ? Splat(1) : t * t * (3.0f - 2.0f * t);
}

// Weight of the strategy with density `a` against another with density `b`.
Float8 PowerHeuristic(Float8 a, Float8 b) {
  const Float8 a2 = a * a;
  return IsFinite(a2) ? a2 / (a2 + b * b) : Splat(1);
}

}  // namespace

Scatter8::Scatter8(const SurfaceInteraction8& at)
    : at_(at),
      frame_(UsableNormal(at.shading, at.normal, at.out)),
      bend2_(1.0f - Square(Dot(frame_.z, at.normal))),
      bsdf_(at.surface, frame_.ToLocal(at.out), at.outside),
      spot_share_(bsdf_.mirror_like() ? Splat(0) : at.spot_share) {}

Float8 Scatter8::Admits(const Vec3x8& world, const Vec3x8& local) const {
  const Float8 height = Dot(at_.normal, world);
  const Mask8 above = local.z > 0.0f;
  const Mask8 soft = above | bsdf_.translucent();
  const Float8 part = soft ? TerminatorFactor(Abs(height), bend2_) : Splat(1);
  return (height > 0.0f) == above ? part : Splat(0);
}

Float8 Scatter8::Mixed(const Vec3x8& world, Float8 by_bsdf) const {
  if (!Any(spot_share_ > 0.0f)) return by_bsdf;
  Float8 by_spots = Splat(0);
  for (int lane = 0; lane < kLanes; ++lane) {
    if (spot_share_[lane] > 0.0f) by_spots[lane] = at_.spots[lane].Pdf(world.Get(lane));
  }
  return spot_share_ * by_spots + (1.0f - spot_share_) * by_bsdf;
}

PARALLAX_LANE_CLONES void Scatter8::Light(bool weighted, Shadow8* out) const {
  Shadow8& shadow = *out;
  const Vec3x8& world = at_.light.direction;
  const Vec3x8 i = frame_.ToLocal(world);
  const Float8 part = Admits(world, i);
  const BsdfValue8 value = bsdf_.Evaluate(i);
  const Mask8 alone = weighted ? at_.light.ideal : ~Mask8{};
  const Float8 weight = alone ? Splat(1) : PowerHeuristic(at_.light.pdf, Mixed(world, value.pdf));
  shadow.contribution =
      at_.throughput * value.f_cos * at_.light.radiance * (part * weight / at_.light.pdf);
  shadow.lit = (at_.light.pdf > 0.0f) & ~bsdf_.mirror_like() & (part > 0.0f) &
               (MaxCoeff(shadow.contribution) > 1e-7f) & IsFinite(shadow.contribution);

  // The ray starts clear of the surface and is aimed again at the light's point, ending clear
  // of that: otherwise, on short distances, the shifted start would let the light shade
  // itself.
  shadow.origin = OffsetPoint(at_.position, Select(i.z > 0.0f, at_.normal, -at_.normal));
  const Mask8 far = ~IsFinite(at_.light.distance);
  const Vec3x8 target = at_.position + world * at_.light.distance;
  const Vec3x8 to = target - shadow.origin;
  const Float8 distance = Sqrt(Dot(to, to));
  const Float8 clear = 2.0f * OffsetDistance(target) + 1e-4f * distance;
  shadow.distance = far ? at_.light.distance : Max(distance - clear, 0.0f);
  shadow.direction = Select(far, world, to * (1.0f / distance));
}

// Samples a bright spot or the BSDF, with the density of their mixture.
PARALLAX_LANE_CLONES BsdfSample8 Scatter8::SampleBsdf() const {
  BsdfSample8 next;
  const Mask8 to_spot = at_.choice < spot_share_;
  const BsdfDirection8 way =
      bsdf_.Sample((at_.choice - spot_share_) / (1.0f - spot_share_), at_.u, at_.v);
  next.straight = way.straight & ~to_spot;
  next.blur = to_spot ? Splat(0.5f) : way.blur;
  next.direction = frame_.ToWorld(way.direction);
  Vec3x8 local = way.direction;
  if (Any(to_spot)) {
    for (int lane = 0; lane < kLanes; ++lane) {
      if (to_spot[lane] == 0) continue;
      const float choice = at_.choice[lane] / spot_share_[lane];
      next.direction.Set(lane, at_.spots[lane].Sample(choice, {at_.u[lane], at_.v[lane]}));
    }
    local = Select(to_spot, frame_.ToLocal(next.direction), local);
  }
  const BsdfValue8 value = bsdf_.Evaluate(local);
  const Mask8 scattered = (value.pdf > 0.0f) & IsFinite(value.pdf);
  next.pdf = Mixed(next.direction, value.pdf);
  next.direction = Normalized(next.direction);
  const Float8 part = Admits(next.direction, local);
  next.weight = Select(next.straight, bsdf_.Straight() * (1.0f / bsdf_.StraightChance()),
                       value.f_cos * (part / next.pdf));
  next.goes = (way.valid | to_spot) & (next.straight | (scattered & (part > 0.0f))) &
              IsFinite(next.weight) & (MaxCoeff(next.weight) > 0.0f);
  const Mask8 above = local.z > 0.0f;
  next.passes = ~above;
  next.origin = OffsetPoint(at_.position, Select(above, at_.normal, -at_.normal));
  return next;
}

}  // namespace parallax
