#include "worker/scene/types/nature/ground/water_surface.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/math/proto.h"
#include "worker/materials/kernel/noise.h"
#include "worker/materials/kernel/surface.h"

namespace parallax {
namespace {

constexpr float kIor = 1.333f, kReflectance = 0.0204f;  // At normal incidence.
// Light goes down at a slant and comes back: longer than the depth.
constexpr float kWay = 2.1f;
constexpr float kSquarePixel_m = 2e-3f;  // SeenWidth's, of a pixel.
constexpr float kShown = 1e-3f;          // Share of the bed's light that is still drawn.
const Vec3f kFoam(0.74f, 0.77f, 0.78f);

class WaterSurface final : public Material {
 public:
  WaterSurface(const v1::Water& water, std::shared_ptr<const Terrain> terrain,
               std::shared_ptr<const Material> bed)
      : terrain_(std::move(terrain)),
        water_(*terrain_->water()),
        bed_(std::move(bed)),
        tint_(FromProto(water.tint()).cast<float>()),
        seed_(water.seed() * 2654435761u + 41u) {
    // Colours that the body sends back little of are those that it swallows.
    const float most = std::max(tint_.maxCoeff(), 1e-4f);
    const auto clarity = static_cast<float>(water.clarity_m());
    extinction_ = (Vec3f::Constant(1.0f) + 0.9f * (Vec3f::Constant(1.0f) - tint_ / most)) / clarity;
  }

  SurfaceSample8 Evaluate(const SurfacePoint8& points) const override {
    const Local local = LocalOf(points);
    SurfaceSample8 out;
    Vec3x8 body = Vec3x8(tint_);
    const Vec3x8 passes = Passes(local.depth);
    if (Any(passes.y > kShown)) {
      SurfacePoint8 below = points;
      below.texture_m.z = points.texture_m.z - local.depth;
      below.normal = Vec3x8(Vec3f::UnitZ());
      const Vec3x8 bed = bed_->Evaluate(below).base_color;
      body = Mix(body, bed, passes);
    }
    const Float8 foam = FoamAt(points, local);
    out.base_color = Mix(body, Vec3x8(kFoam), foam);
    // GGX's alpha is the root of the mean square slope (of Beckmann's, nearly).
    out.roughness = Clamp(Sqrt(Sqrt(local.lost_slope)), 0.05f, 0.6f);
    out.roughness += (0.85f - out.roughness) * foam;
    out.specular = Splat(kReflectance / 0.08f) * (1.0f - 0.5f * foam);
    out.ior = Splat(kIor);
    return out;
  }

  Float8 Height(const SurfacePoint8& points) const override {
    Tangents8 none;
    for (int k = 0; k < 2; ++k) {
      none.texture[k] = Vec3x8::Zero();
      none.u[k] = none.v[k] = Splat(0);
    }
    return Relief(points, none).value;
  }

  Dual8 Relief(const SurfacePoint8& points, const Tangents8& tangents) const override {
    const DualVec8 p = ReliefPoint8(points, tangents).texture_m;
    Float8 seen;
    for (int lane = 0; lane < kLanes; ++lane) {
      seen[lane] = SeenWidth(points.footprint_m[lane], kSquarePixel_m);
    }
    return water_.Ripples(p.x, p.y, points.u, seen);
  }

 private:
  struct Local {
    Float8 depth, lost_slope, foam;  // `foam` before its pattern.
    Float8 along, across;            // Water::Adrift.
  };

  Local LocalOf(const SurfacePoint8& points) const {
    Local local;
    for (int lane = 0; lane < kLanes; ++lane) {
      if (lane >= points.count && lane > 0) {
        for (Float8* part :
             {&local.depth, &local.lost_slope, &local.foam, &local.along, &local.across}) {
          (*part)[lane] = (*part)[lane - 1];
        }
        continue;
      }
      const Vec2f p(points.texture_m.x[lane], points.texture_m.y[lane]);
      const float footprint_m = std::max(points.footprint_m[lane], 0.05f);
      const float depth =
          std::max(0.0f, points.texture_m.z[lane] - terrain_->Height(p, footprint_m));
      local.depth[lane] = depth;
      local.lost_slope[lane] =
          water_.LostSlope(p, SeenWidth(points.footprint_m[lane], kSquarePixel_m));
      local.foam[lane] = water_.Foam(p, depth);
      const Vec2f drift = water_.Adrift(p);
      local.along[lane] = drift.x();
      local.across[lane] = drift.y();
    }
    return local;
  }

  // Share of the bed's light that comes back.
  Vec3x8 Passes(Float8 depth) const {
    const auto share = [&](float extinction) { return Exp(depth * (-kWay * extinction)); };
    return {share(extinction_.x()), share(extinction_.y()), share(extinction_.z())};
  }

  static Vec3x8 Mix(const Vec3x8& a, const Vec3x8& b, const Vec3x8& t) { return a + (b - a) * t; }
  static Vec3x8 Mix(const Vec3x8& a, const Vec3x8& b, Float8 t) { return a + (b - a) * t; }

  // Foam lies in a net of bubbles: closed where there is much, threads where there is little. On a
  // river it is drawn out.
  Float8 FoamAt(const SurfacePoint8& points, const Local& local) const {
    if (!Any(local.foam > 0.005f)) return Splat(0);
    const Float8 w = points.footprint_m;
    const bool river = water_.spec().kind == WaterKind::kRiver;
    const float along_m = river ? 1.7f : 1.0f;
    const Vec3x8 p(local.along / along_m, local.across, Splat(0.3f));
    const Float8 bent = noise::Fbm3(p, 0.9f, 3, w, seed_ + 1);
    Float8 net = Splat(0), weight = Splat(0);
    float size_m = 0.55f, strength = 1;
    for (uint32_t k = 0; k < 3; ++k) {
      const Float8 fade = strength * noise::Fade(size_m, w);
      if (!Any(fade > 0)) break;
      const noise::Cell8 cell = noise::Cells2((p.x + 0.35f * bent) / size_m,
                                              (p.y - 0.35f * bent) / size_m, seed_ + 7 + k);
      net += fade * (1.0f - noise::SmoothStep(0.0f, 0.42f, cell.f2 - cell.f1));
      weight += fade;
      size_m *= 0.38f;
      strength *= 0.8f;
    }
    // Covers about the share `foam` of the net, whose values lie in [0, 1]; from afar its mean.
    const Float8 pattern = net / Max(weight, 1e-3f);
    const Float8 broad = 0.5f + 0.6f * noise::Fbm3(p, 2.7f, 2, w, seed_ + 3);
    const Float8 value = 0.55f * pattern + 0.45f * broad;
    const Float8 cover =
        noise::SmoothStep(0.82f - 0.8f * local.foam, 0.98f - 0.72f * local.foam, value);
    const Float8 near = noise::Saturate(weight);
    return noise::Saturate(local.foam + near * (cover - local.foam)) *
           noise::SmoothStep(0.0f, Splat(0.02f), local.foam);
  }

  const std::shared_ptr<const Terrain> terrain_;
  const Water& water_;
  const std::shared_ptr<const Material> bed_;
  Vec3f tint_, extinction_;
  uint32_t seed_;
};

}  // namespace

std::shared_ptr<const Material> MakeWaterSurface(const v1::Water& water,
                                                 std::shared_ptr<const Terrain> terrain,
                                                 std::shared_ptr<const Material> bed) {
  return std::make_shared<const WaterSurface>(water, std::move(terrain), std::move(bed));
}

}  // namespace parallax
