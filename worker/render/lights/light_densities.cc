// Densities of light samples, and the radiance of lights that BSDF sampling found, weighted by MIS.
#include "worker/render/lights/light_cones.h"
#include "worker/render/lights/light_sampler.h"

namespace parallax {
namespace {

// Distance along the ray to the near side of the sphere, or infinity; infinity from inside it.
float HitSphere(const Vec3f& origin, const Vec3f& direction, const Vec3f& center, float radius) {
  const Vec3f to = center - origin;
  const float along = to.dot(direction);
  if (along <= 0.0f || to.squaredNorm() <= radius * radius) return kInfinity;
  const float miss2 = (to - along * direction).squaredNorm();
  if (miss2 >= radius * radius) return kInfinity;
  return along - std::sqrt(radius * radius - miss2);
}

}  // namespace

Float8 LightSampler::SkyPdf(const LightReceivers8& at, const Vec3x8& directions) const {
  Float8 all = Splat(0);
  Mask8 left = at.total > 0.0f;
  while (Any(left)) {
    const int32_t room = at.room[__builtin_ctz(BitsOf(left))];
    const Mask8 members = left & (at.room == room);
    left &= ~members;
    const Enclosure* in = table_->EnclosureAt(room);
    if (!in && table_->sky().has_environment()) {
      Float8 pdf = Splat(0);
      for (int lane = 0; lane < kLanes; ++lane) {
        if (members[lane] != 0) pdf[lane] = table_->sky().EnvironmentPdf(directions.Get(lane));
      }
      all = members ? pdf * DomeImportance() / at.total : all;
      continue;
    }
    if (!in) {
      const Float8 share = directions.z >= 0.0f ? Splat(kUpperShare) : Splat(1.0f - kUpperShare);
      all = members ? share / (2.0f * kPi) * DomeImportance() / at.total : all;
      continue;
    }
    // Cells of other rooms' points are none of this room's.
    const Int8 cells = members ? at.cell : Int8{};
    Float8 pdf = Splat(0);
    for (size_t i = 0; i < in->portals.size(); ++i) {
      const Portal& portal = in->portals[i];
      const Float8 cosine = Inner(Vec3x8(portal.normal), directions);
      const Float8 height = Inner(Vec3x8(portal.normal), Vec3x8(portal.corner) - at.position);
      const Float8 distance = height / cosine;
      const Vec3x8 q = at.position + directions * distance - Vec3x8(portal.corner);
      const Float8 a = Inner(q, Vec3x8(portal.edge_u)), b = Inner(q, Vec3x8(portal.edge_v));
      const Mask8 through = members & (cosine > 1e-5f) & (height > 0.0f) & (a >= 0.0f) &
                            (b >= 0.0f) & (a <= portal.edge_u.squaredNorm()) &
                            (b <= portal.edge_v.squaredNorm());
      if (!Any(through)) continue;
      const Float8 importance = Importance(in, at.position, cells, table_->lamps().size() + i);
      pdf += through ? importance * Square(distance) / (cosine * portal.area) : Splat(0);
    }
    all = members ? pdf / at.total : all;
  }
  return all;
}

float LightSampler::MeshPdf(const LightReceiver& at, uint32_t placed, uint16_t slot, float distance,
                            float cosine) const {
  const int32_t light = table_->MeshLight(placed, slot);
  if (light < 0 || !(at.total > 0.0f) || cosine <= 1e-5f) return 0;
  const Lamp& lamp = table_->lamps()[static_cast<size_t>(light)];
  return Chance(at, static_cast<size_t>(light)) * Square(distance) / (cosine * lamp.area);
}

Mask8 LightSampler::MeetSpheres(const Vec3x8& origin, const Vec3x8& direction,
                                Float8 distance) const {
  Mask8 meet{};
  for (const size_t index : table_->spheres()) {
    const Vec3x8 to = Vec3x8(table_->lamps()[index].center) - origin;
    const Float8 along = Inner(to, direction);
    const Vec3x8 miss = to - direction * along;
    // The far side counts too: SphereRadiance decides which.
    meet |= (along > 0.0f) & (Inner(miss, miss) < Square(table_->lamps()[index].radius)) &
            (along - table_->lamps()[index].radius < distance);
  }
  return meet;
}

Vec3f LightSampler::SphereRadiance(const LightReceiver& at, const Vec3f& origin,
                                   const Vec3f& direction, float distance, float bsdf_pdf) const {
  Vec3f sum = Vec3f::Zero();
  for (const size_t index : table_->spheres()) {
    const Lamp& lamp = table_->lamps()[index];
    if (HitSphere(origin, direction, lamp.center, lamp.radius) >= distance) continue;
    float weight = 1;
    if (std::isfinite(bsdf_pdf)) {
      const float sin2 = Square(lamp.radius) / (lamp.center - at.position).squaredNorm();
      const float pdf = sin2 < 1.0f ? Chance(at, index) / (2.0f * kPi * ConeHeight(sin2)) : 0.0f;
      weight = PowerHeuristic(bsdf_pdf, pdf);
    }
    sum += lamp.radiance * (weight * lamp.Falloff(-direction));
  }
  return sum;
}

Vec3f LightSampler::EscapeRadiance(const LightReceiver& at, const Vec3f& direction,
                                   float bsdf_pdf) const {
  const bool weighted = std::isfinite(bsdf_pdf);
  Vec3f sum = Vec3f::Zero();
  if (table_->sky().has_sky()) {
    float weight = 1;
    if (weighted) {
      const Float8 pdf = SkyPdf(LightReceivers8::All(at), Vec3x8(direction));
      weight = PowerHeuristic(bsdf_pdf, pdf[0]);
    }
    sum += table_->sky().Radiance(direction) * weight;
  }
  if (table_->sky().InSun(direction)) {
    const float pdf = weighted && at.total > 0.0f
                          ? Chance(at, table_->LightsIn(table_->EnclosureAt(at.room)) - 1) /
                                table_->sky().sun_solid_angle()
                          : 0.0f;
    sum += table_->sky().SunRadiance() * (weighted ? PowerHeuristic(bsdf_pdf, pdf) : 1.0f);
  }
  return sum;
}

}  // namespace parallax
