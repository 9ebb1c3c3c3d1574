// Samples of chosen lights, and the densities and radiance that MIS needs of those met by chance.
#include "worker/render/lights.h"

namespace parallax {
namespace {

constexpr float kUpperShare = 0.85f;  // Of sky samples that go above the horizon.

// Distance along the ray to the sphere's near side, or infinity. None from inside of it.
float HitSphere(const Vec3f& origin, const Vec3f& direction, const Vec3f& center, float radius) {
  const Vec3f to = center - origin;
  const float along = to.dot(direction);
  if (along <= 0.0f || to.squaredNorm() <= radius * radius) return kInfinity;
  const float miss2 = (to - along * direction).squaredNorm();
  if (miss2 >= radius * radius) return kInfinity;
  return along - std::sqrt(radius * radius - miss2);
}

// 1 - cos of the sphere's angular radius, exact for small angles.
float ConeHeight(float sin2) { return sin2 / (1.0f + std::sqrt(std::max(0.0f, 1.0f - sin2))); }
Float8 ConeHeight(Float8 sin2) { return sin2 / (1.0f + Sqrt(Max(1.0f - sin2, 0.0f))); }

}  // namespace

void LightTable::Sample(const LightReceiver* at, const LightChoice* choices, int count, Float8 u,
                        Float8 v, LightSample* samples) const {
  Mask8 faces{}, spheres{};
  for (int lane = 0; lane < count; ++lane) {
    const LightChoice& choice = choices[lane];
    LightSample& sample = samples[lane];
    sample = {};
    sample.light = choice.light;
    if (!(choice.importance > 0.0f)) continue;
    const Enclosure* in = at[lane].enclosure;
    const Vec2f point(u[lane], v[lane]);
    const size_t first_way = lamps_.size(), sun = LightsIn(in) - 1;
    if (choice.light == sun) {
      sample = SampleSun(point);
    } else if (choice.light >= first_way) {
      sample = in ? SamplePortal(in->portals[choice.light - first_way], at[lane], point)
                  : SampleDome(at[lane], point);
    } else if (lamps_[choice.light].mesh) {
      faces[lane] = -1;
    } else if (lamps_[choice.light].radius > 0.0f) {
      spheres[lane] = -1;
    } else {
      sample = SampleIdeal(lamps_[choice.light], at[lane].position);
    }
    sample.light = choice.light;
  }
  if (Any(faces)) SampleFaces(at, choices, faces, u, v, samples);
  if (Any(spheres)) SampleSpheres(at, choices, spheres, u, v, samples);
  for (int lane = 0; lane < count; ++lane) {
    // The density of ways to the sky is that of all of them already.
    const size_t sun = LightsIn(at[lane].enclosure) - 1;
    if (choices[lane].light >= lamps_.size() && choices[lane].light != sun) continue;
    if (samples[lane].pdf > 0.0f) samples[lane].pdf *= choices[lane].importance / at[lane].total;
  }
}

void LightTable::SampleFaces(const LightReceiver* at, const LightChoice* choices, Mask8 lanes,
                             Float8 u, Float8 v, LightSample* samples) const {
  static_assert(sizeof(Face) == 16 * sizeof(float));
  Float8 front[kLanes]{}, rest[kLanes]{};
  Vec3x8 position = Vec3x8::Zero();
  Float8 area = Splat(1);
  for (int lane = 0; lane < kLanes; ++lane) {
    if (lanes[lane] == 0) continue;
    const Lamp& lamp = lamps_[choices[lane].light];
    const float* face = lamp.faces[choices[lane].face].corner.data();
    front[lane] = _mm256_load_ps(face);
    rest[lane] = _mm256_load_ps(face + kLanes);
    position.Set(lane, at[lane].position);
    area[lane] = lamp.area;
  }
  Transpose(front);
  Transpose(rest);
  const Vec3x8 corner(front[0], front[1], front[2]), edge_u(front[3], front[4], front[5]);
  const Vec3x8 edge_v(front[6], front[7], rest[0]), back(rest[1], rest[2], rest[3]);
  const Float8 below = rest[4], face_area = rest[5];
  // What is left of the first number after the choice serves again, uniformly over the triangle.
  const Float8 root = Sqrt(Clamp((u * area - below) / face_area, 0.0f, 1.0f));
  const Vec3x8 to = corner + edge_u * (root * (1.0f - v)) + edge_v * (root * v) - position;
  const Float8 d2 = Inner(to, to), distance = Sqrt(d2);
  const Vec3x8 direction = to / distance;
  const Float8 cosine = Inner(back, direction);
  const Mask8 shines = lanes & (d2 > 1e-12f) & (cosine > 1e-5f);
  const Float8 pdf = d2 / (cosine * area);
  for (int lane = 0; lane < kLanes; ++lane) {
    if (shines[lane] == 0) continue;
    LightSample& sample = samples[lane];
    sample.distance = distance[lane];
    sample.direction = direction.Get(lane);
    sample.radiance = lamps_[choices[lane].light].radiance;
    sample.pdf = pdf[lane];
  }
}

void LightTable::SampleSpheres(const LightReceiver* at, const LightChoice* choices, Mask8 lanes,
                               Float8 u, Float8 v, LightSample* samples) const {
  Vec3x8 to = Vec3f(0, 0, 1);
  Float8 radius = Splat(0.5f);
  for (int lane = 0; lane < kLanes; ++lane) {
    if (lanes[lane] == 0) continue;
    const Lamp& lamp = lamps_[choices[lane].light];
    to.Set(lane, lamp.center - at[lane].position);
    radius[lane] = lamp.radius;
  }
  const Float8 d2 = Inner(to, to), radius2 = radius * radius;
  const Float8 sin2 = radius2 / d2;
  const Mask8 shines = lanes & (sin2 < 1.0f);  // Not from inside of the lamp.
  const Float8 cone = ConeHeight(sin2);
  const Float8 one_minus_cos = u * cone;
  const Float8 sin_theta = Sqrt(Max(one_minus_cos * (2.0f - one_minus_cos), 0.0f));
  const Turn8 turn(2.0f * kPi * v);
  const Frame8 frame(to / Sqrt(d2));
  const Vec3x8 direction =
      frame.ToWorld({sin_theta * turn.cosine, sin_theta * turn.sine, 1.0f - one_minus_cos});
  // To the near side; at its rim, rounding may miss it.
  const Float8 along = Inner(to, direction);
  const Vec3x8 miss = to - direction * along;
  const Float8 half2 = radius2 - Inner(miss, miss);
  const Float8 distance = (along > 0.0f) & (half2 > 0.0f) ? along - Sqrt(Max(half2, 0.0f))
                                                          : Sqrt(Max(d2 - radius2, 0.0f));
  const Float8 pdf = 1.0f / (2.0f * kPi * cone);
  for (int lane = 0; lane < kLanes; ++lane) {
    if (shines[lane] == 0) continue;
    const Lamp& lamp = lamps_[choices[lane].light];
    LightSample& sample = samples[lane];
    sample.direction = direction.Get(lane);
    sample.distance = distance[lane];
    sample.pdf = pdf[lane];
    sample.radiance = lamp.radiance * lamp.Falloff(-sample.direction);
  }
}

LightSample LightTable::SampleIdeal(const Lamp& lamp, const Vec3f& position) const {
  LightSample sample;
  const Vec3f to = lamp.center - position;
  const float d2 = to.squaredNorm();
  if (!(d2 > 1e-12f)) return sample;
  sample.distance = std::sqrt(d2);
  sample.direction = to / sample.distance;
  sample.radiance = lamp.intensity * (lamp.Falloff(-sample.direction) / d2);
  sample.pdf = 1;
  sample.ideal = true;
  return sample;
}

LightSample LightTable::SamplePortal(const Portal& portal, const LightReceiver& at,
                                     const Vec2f& u) const {
  LightSample sample;
  const Vec3f to = portal.corner + portal.edge_u * u.x() + portal.edge_v * u.y() - at.position;
  const float d2 = to.squaredNorm();
  if (!(d2 > 1e-12f)) return sample;
  sample.direction = to / std::sqrt(d2);
  sample.distance = kInfinity;
  sample.radiance = sky_.Radiance(sample.direction);
  sample.pdf = SkyPdf(at, sample.direction);
  return sample;
}

LightSample LightTable::SampleDome(const LightReceiver& at, const Vec2f& u) const {
  LightSample sample;
  const bool above = u.x() < kUpperShare;
  const float z = above ? u.x() / kUpperShare : -(u.x() - kUpperShare) / (1.0f - kUpperShare);
  sample.direction = DirectionAt(z, 2.0f * kPi * u.y());
  sample.distance = kInfinity;
  sample.radiance = sky_.Radiance(sample.direction);
  sample.pdf = SkyPdf(at, sample.direction);
  return sample;
}

LightSample LightTable::SampleSun(const Vec2f& u) const {
  LightSample sample;
  const float one_minus_cos = u.x() * (1.0f - sky_.cos_sun());
  const ShadingFrame frame(sky_.sun_direction());
  sample.direction = frame.ToWorld(DirectionAt(1.0f - one_minus_cos, 2.0f * kPi * u.y()));
  sample.distance = kInfinity;
  sample.radiance = sky_.SunRadiance();
  sample.pdf = 1.0f / sky_.sun_solid_angle();
  return sample;
}

float LightTable::SkyPdf(const LightReceiver& at, const Vec3f& direction) const {
  if (!(at.total > 0.0f)) return 0;
  if (!at.enclosure) {
    const float pdf = (direction.z() >= 0.0f ? kUpperShare : 1.0f - kUpperShare) / (2.0f * kPi);
    return pdf * DomeImportance() / at.total;
  }
  float pdf = 0;
  for (size_t i = 0; i < at.enclosure->portals.size(); ++i) {
    const Portal& portal = at.enclosure->portals[i];
    const float cosine = portal.normal.dot(direction);
    const float height = portal.normal.dot(portal.corner - at.position);
    if (cosine <= 1e-5f || height <= 0.0f) continue;
    const float distance = height / cosine;
    const Vec3f q = at.position + direction * distance - portal.corner;
    const float a = q.dot(portal.edge_u);
    const float b = q.dot(portal.edge_v);
    if (a < 0.0f || b < 0.0f || a > portal.edge_u.squaredNorm() ||
        b > portal.edge_v.squaredNorm()) {
      continue;
    }
    pdf += Importance(at, lamps_.size() + i) * Square(distance) / (cosine * portal.area);
  }
  return pdf / at.total;
}

int LightTable::MeshLight(uint32_t placed, uint16_t slot) const {
  const std::vector<int>& lights = mesh_lights_[placed];
  return slot < lights.size() ? lights[slot] : -1;
}

Vec3f LightTable::MeshRadiance(uint32_t placed, uint16_t slot) const {
  const int light = MeshLight(placed, slot);
  return light >= 0 ? lamps_[static_cast<size_t>(light)].radiance : Vec3f::Zero();
}

float LightTable::MeshPdf(const LightReceiver& at, uint32_t placed, uint16_t slot, float distance,
                          float cosine) const {
  const int light = MeshLight(placed, slot);
  if (light < 0 || !(at.total > 0.0f) || cosine <= 1e-5f) return 0;
  const Lamp& lamp = lamps_[static_cast<size_t>(light)];
  return Chance(at, static_cast<size_t>(light)) * Square(distance) / (cosine * lamp.area);
}

Vec3f LightTable::SphereRadiance(const LightReceiver& at, const Vec3f& origin,
                                 const Vec3f& direction, float distance, float bsdf_pdf) const {
  Vec3f sum = Vec3f::Zero();
  for (const size_t index : spheres_) {
    const Lamp& lamp = lamps_[index];
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

Vec3f LightTable::EscapeRadiance(const LightReceiver& at, const Vec3f& direction,
                                 float bsdf_pdf) const {
  const bool weighted = std::isfinite(bsdf_pdf);
  Vec3f sum = Vec3f::Zero();
  if (sky_.has_sky()) {
    const float weight = weighted ? PowerHeuristic(bsdf_pdf, SkyPdf(at, direction)) : 1.0f;
    sum += sky_.Radiance(direction) * weight;
  }
  if (sky_.InSun(direction)) {
    const float pdf = weighted && at.total > 0.0f
                          ? Chance(at, LightsIn(at.enclosure) - 1) / sky_.sun_solid_angle()
                          : 0.0f;
    sum += sky_.SunRadiance() * (weighted ? PowerHeuristic(bsdf_pdf, pdf) : 1.0f);
  }
  return sum;
}

}  // namespace parallax
