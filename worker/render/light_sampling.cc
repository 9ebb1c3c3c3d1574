// Samples the chosen lights, and computes the densities and radiance that MIS needs of lights hit.
#include "worker/render/lights.h"

namespace parallax {
namespace {

constexpr float kUpperShare = 0.85f;  // Share of sky samples that go above the horizon.

// Distance along the ray to the near side of the sphere, or infinity; infinity from inside it.
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

void LightSamples8::Set(int lane, const LightSample& sample) {
  direction.Set(lane, sample.direction);
  radiance.Set(lane, sample.radiance);
  distance[lane] = sample.distance;
  pdf[lane] = sample.pdf;
  ideal[lane] = sample.ideal ? -1 : 0;
}

LightSample LightSamples8::Get(int lane) const {
  return {direction.Get(lane), distance[lane], radiance.Get(lane), pdf[lane], ideal[lane] != 0};
}

void LightTable::Sample(const LightReceivers8& at, const LightChoices8& choices, Float8 u, Float8 v,
                        LightSamples8* out) const {
  LightSamples8& samples = *out;
  samples.direction = Vec3x8(Vec3f::UnitZ());
  samples.radiance = Vec3x8::Zero();
  samples.distance = samples.pdf = Splat(0);
  samples.ideal = Mask8{};
  const Int8 beyond_lamps = Int8{} + static_cast<int32_t>(lamps_.size());
  const Mask8 lamp = choices.light < beyond_lamps;
  const Float8 kind = Gather(kinds_.data(), lamp ? choices.light : beyond_lamps);
  const Mask8 chosen = choices.importance > 0.0f;
  const Mask8 faces = chosen & (kind == kFaces), spheres = chosen & (kind == kSphere);
  Mask8 others = chosen & (kind == kIdeal), skies = chosen & ~lamp;
  for (uint32_t left = BitsOf(skies); left != 0; left &= left - 1) {
    const int lane = __builtin_ctz(left);
    const auto last = static_cast<int32_t>(LightsIn(RoomAt(at.room[lane]))) - 1;
    if (choices.light[lane] != last) continue;  // The sun is.
    skies[lane] = 0;
    others[lane] = -1;
  }
  if (Any(faces)) SampleFaces(at, choices, faces, u, v, &samples);
  if (Any(spheres)) SampleSpheres(at, choices, spheres, u, v, &samples);
  if (Any(skies)) SampleSky(at, choices, skies, u, v, &samples);
  for (int lane = 0; Any(others) && lane < kLanes; ++lane) {
    if (others[lane] == 0) continue;
    const auto light = static_cast<size_t>(choices.light[lane]);
    samples.Set(lane, light < lamps_.size() ? SampleIdeal(lamps_[light], at.position.Get(lane))
                                            : SampleSun({u[lane], v[lane]}));
  }
  // The density of sky directions already includes all ways to sample them.
  const Float8 chance = skies ? Splat(1) : choices.importance / at.total;
  samples.pdf = samples.pdf > 0.0f ? samples.pdf * chance : samples.pdf;
}

PARALLAX_LANE_CLONES void LightTable::SampleFaces(const LightReceivers8& at,
                                                  const LightChoices8& choices, Mask8 lanes,
                                                  Float8 u, Float8 v,
                                                  LightSamples8* samples) const {
  static_assert(sizeof(Face) == 16 * sizeof(float));
  Float8 front[kLanes]{}, rest[kLanes]{};
  Vec3x8 radiance = Vec3x8::Zero();
  Float8 area = Splat(1);
  for (int lane = 0; lane < kLanes; ++lane) {
    if (lanes[lane] == 0) continue;
    const Lamp& lamp = lamps_[static_cast<size_t>(choices.light[lane])];
    const float* face = lamp.faces[static_cast<size_t>(choices.face[lane])].corner.data();
    front[lane] = _mm256_load_ps(face);
    rest[lane] = _mm256_load_ps(face + kLanes);
    radiance.Set(lane, lamp.radiance);
    area[lane] = lamp.area;
  }
  Transpose(front);
  Transpose(rest);
  const Vec3x8 corner(front[0], front[1], front[2]), edge_u(front[3], front[4], front[5]);
  const Vec3x8 edge_v(front[6], front[7], rest[0]), back(rest[1], rest[2], rest[3]);
  const Float8 below = rest[4], face_area = rest[5];
  // The rest of `u` after the choice is uniform again: it picks the point on the triangle.
  const Float8 root = Sqrt(Clamp((u * area - below) / face_area, 0.0f, 1.0f));
  const Vec3x8 to = corner + edge_u * (root * (1.0f - v)) + edge_v * (root * v) - at.position;
  const Float8 d2 = Inner(to, to), distance = Sqrt(d2);
  const Vec3x8 direction = to / distance;
  const Float8 cosine = Inner(back, direction);
  const Mask8 shines = lanes & (d2 > 1e-12f) & (cosine > 1e-5f);
  const Float8 pdf = d2 / (cosine * area);
  samples->distance = shines ? distance : samples->distance;
  samples->direction = Select(shines, direction, samples->direction);
  samples->radiance = Select(shines, radiance, samples->radiance);
  samples->pdf = shines ? pdf : samples->pdf;
}

PARALLAX_LANE_CLONES void LightTable::SampleSpheres(const LightReceivers8& at,
                                                    const LightChoices8& choices, Mask8 lanes,
                                                    Float8 u, Float8 v,
                                                    LightSamples8* samples) const {
  Vec3x8 to = Vec3f(0, 0, 1);
  Float8 radius = Splat(0.5f);
  for (int lane = 0; lane < kLanes; ++lane) {
    if (lanes[lane] == 0) continue;
    const Lamp& lamp = lamps_[static_cast<size_t>(choices.light[lane])];
    to.Set(lane, lamp.center - at.position.Get(lane));
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
  // Distance to the near side; at the rim, rounding may miss the sphere.
  const Float8 along = Inner(to, direction);
  const Vec3x8 miss = to - direction * along;
  const Float8 half2 = radius2 - Inner(miss, miss);
  const Float8 distance = (along > 0.0f) & (half2 > 0.0f) ? along - Sqrt(Max(half2, 0.0f))
                                                          : Sqrt(Max(d2 - radius2, 0.0f));
  const Float8 pdf = 1.0f / (2.0f * kPi * cone);
  for (int lane = 0; lane < kLanes; ++lane) {
    if (shines[lane] == 0) continue;
    const Lamp& lamp = lamps_[static_cast<size_t>(choices.light[lane])];
    samples->radiance.Set(lane, lamp.radiance * lamp.Falloff(-direction.Get(lane)));
  }
  samples->distance = shines ? distance : samples->distance;
  samples->direction = Select(shines, direction, samples->direction);
  samples->pdf = shines ? pdf : samples->pdf;
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

void LightTable::SampleSky(const LightReceivers8& at, const LightChoices8& choices, Mask8 lanes,
                           Float8 u, Float8 v, LightSamples8* samples) const {
  Vec3x8 to(Vec3f::UnitZ());
  for (int lane = 0; lane < kLanes; ++lane) {
    if (lanes[lane] == 0) continue;
    if (const Enclosure* in = RoomAt(at.room[lane])) {
      const size_t way = static_cast<size_t>(choices.light[lane]) - lamps_.size();
      const Portal& portal = in->portals[way];
      to.Set(lane, portal.corner + portal.edge_u * u[lane] + portal.edge_v * v[lane] -
                       at.position.Get(lane));
    } else if (sky_.has_environment()) {
      to.Set(lane, sky_.SampleEnvironment(u[lane], v[lane]));
    } else {
      const bool above = u[lane] < kUpperShare;
      const float z =
          above ? u[lane] / kUpperShare : -(u[lane] - kUpperShare) / (1.0f - kUpperShare);
      to.Set(lane, DirectionAt(z, 2.0f * kPi * v[lane]));
    }
  }
  const Float8 d2 = Inner(to, to);
  const Mask8 shines = lanes & (d2 > 1e-12f);
  const Vec3x8 direction = to / Sqrt(d2);
  samples->direction = Select(shines, direction, samples->direction);
  samples->radiance = Select(shines, sky_.Radiance(direction), samples->radiance);
  samples->distance = shines ? Splat(kInfinity) : samples->distance;
  samples->pdf = shines ? SkyPdf(at, direction) : samples->pdf;
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

Float8 LightTable::SkyPdf(const LightReceivers8& at, const Vec3x8& directions) const {
  Float8 all = Splat(0);
  Mask8 left = at.total > 0.0f;
  while (Any(left)) {
    const int32_t room = at.room[__builtin_ctz(BitsOf(left))];
    const Mask8 members = left & (at.room == room);
    left &= ~members;
    const Enclosure* in = RoomAt(room);
    if (!in && sky_.has_environment()) {
      Float8 pdf = Splat(0);
      for (int lane = 0; lane < kLanes; ++lane) {
        if (members[lane] != 0) pdf[lane] = sky_.EnvironmentPdf(directions.Get(lane));
      }
      all = members ? pdf * DomeImportance() / at.total : all;
      continue;
    }
    if (!in) {
      const Float8 share = directions.z >= 0.0f ? Splat(kUpperShare) : Splat(1.0f - kUpperShare);
      all = members ? share / (2.0f * kPi) * DomeImportance() / at.total : all;
      continue;
    }
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
      const Float8 importance = Importance(in, at.position, at.cell, lamps_.size() + i);
      pdf += through ? importance * Square(distance) / (cosine * portal.area) : Splat(0);
    }
    all = members ? pdf / at.total : all;
  }
  return all;
}

Vec3f LightTable::MeshRadiance(uint32_t placed, uint16_t slot) const {
  const int32_t light = MeshLight(placed, slot);
  return light >= 0 ? lamps_[static_cast<size_t>(light)].radiance : Vec3f::Zero();
}

float LightTable::MeshPdf(const LightReceiver& at, uint32_t placed, uint16_t slot, float distance,
                          float cosine) const {
  const int32_t light = MeshLight(placed, slot);
  if (light < 0 || !(at.total > 0.0f) || cosine <= 1e-5f) return 0;
  const Lamp& lamp = lamps_[static_cast<size_t>(light)];
  return Chance(at, static_cast<size_t>(light)) * Square(distance) / (cosine * lamp.area);
}

Mask8 LightTable::MeetSpheres(const Vec3x8& origin, const Vec3x8& direction,
                              Float8 distance) const {
  Mask8 meet{};
  for (const size_t index : spheres_) {
    const Vec3x8 to = Vec3x8(lamps_[index].center) - origin;
    const Float8 along = Inner(to, direction);
    const Vec3x8 miss = to - direction * along;
    // The far side counts too: SphereRadiance decides which.
    meet |= (along > 0.0f) & (Inner(miss, miss) < Square(lamps_[index].radius)) &
            (along - lamps_[index].radius < distance);
  }
  return meet;
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
    float weight = 1;
    if (weighted) {
      const Float8 pdf = SkyPdf(LightReceivers8::All(at), Vec3x8(direction));
      weight = PowerHeuristic(bsdf_pdf, pdf[0]);
    }
    sum += sky_.Radiance(direction) * weight;
  }
  if (sky_.InSun(direction)) {
    const float pdf = weighted && at.total > 0.0f
                          ? Chance(at, LightsIn(RoomAt(at.room)) - 1) / sky_.sun_solid_angle()
                          : 0.0f;
    sum += sky_.SunRadiance() * (weighted ? PowerHeuristic(bsdf_pdf, pdf) : 1.0f);
  }
  return sum;
}

}  // namespace parallax
