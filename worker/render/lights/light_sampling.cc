// Samples the chosen lights.
#include "worker/render/lights/light_cones.h"
#include "worker/render/lights/light_sampler.h"

namespace parallax {
namespace {

LightSample SampleIdeal(const Lamp& lamp, const Vec3f& position) {
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

void LightSampler::Sample(const LightReceivers8& at, const LightChoices8& choices, Float8 u,
                          Float8 v, LightSamples8* out) const {
  LightSamples8& samples = *out;
  samples.direction = Vec3x8(Vec3f::UnitZ());
  samples.radiance = Vec3x8::Zero();
  samples.distance = samples.pdf = Splat(0);
  samples.ideal = Mask8{};
  const Int8 beyond_lamps = Int8{} + static_cast<int32_t>(table_->lamps().size());
  const Mask8 lamp = choices.light < beyond_lamps;
  const Float8 kind = Gather(table_->kinds().data(), lamp ? choices.light : beyond_lamps);
  const Mask8 chosen = choices.importance > 0.0f;
  const Mask8 faces = chosen & (kind == LightTable::kFaces),
              spheres = chosen & (kind == LightTable::kSphere);
  Mask8 others = chosen & (kind == LightTable::kIdeal), skies = chosen & ~lamp;
  for (uint32_t left = BitsOf(skies); left != 0; left &= left - 1) {
    const int lane = __builtin_ctz(left);
    const auto last =
        static_cast<int32_t>(table_->LightsIn(table_->EnclosureAt(at.room[lane]))) - 1;
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
    samples.Set(lane, light < table_->lamps().size()
                          ? SampleIdeal(table_->lamps()[light], at.position.Get(lane))
                          : SampleSun({u[lane], v[lane]}));
  }
  // The density of sky directions already includes all ways to sample them.
  const Float8 chance = skies ? Splat(1) : choices.importance / at.total;
  samples.pdf = samples.pdf > 0.0f ? samples.pdf * chance : samples.pdf;
}

PARALLAX_LANE_CLONES void LightSampler::SampleFaces(const LightReceivers8& at,
                                                    const LightChoices8& choices, Mask8 lanes,
                                                    Float8 u, Float8 v,
                                                    LightSamples8* samples) const {
  static_assert(sizeof(LampFace) == 16 * sizeof(float));
  Float8 front[kLanes]{}, rest[kLanes]{};
  Vec3x8 radiance = Vec3x8::Zero();
  Float8 area = Splat(1);
  for (int lane = 0; lane < kLanes; ++lane) {
    if (lanes[lane] == 0) continue;
    const Lamp& lamp = table_->lamps()[static_cast<size_t>(choices.light[lane])];
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

PARALLAX_LANE_CLONES void LightSampler::SampleSpheres(const LightReceivers8& at,
                                                      const LightChoices8& choices, Mask8 lanes,
                                                      Float8 u, Float8 v,
                                                      LightSamples8* samples) const {
  Vec3x8 to = Vec3f(0, 0, 1);
  Float8 radius = Splat(0.5f);
  for (int lane = 0; lane < kLanes; ++lane) {
    if (lanes[lane] == 0) continue;
    const Lamp& lamp = table_->lamps()[static_cast<size_t>(choices.light[lane])];
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
    const Lamp& lamp = table_->lamps()[static_cast<size_t>(choices.light[lane])];
    samples->radiance.Set(lane, lamp.radiance * lamp.Falloff(-direction.Get(lane)));
  }
  samples->distance = shines ? distance : samples->distance;
  samples->direction = Select(shines, direction, samples->direction);
  samples->pdf = shines ? pdf : samples->pdf;
}

void LightSampler::SampleSky(const LightReceivers8& at, const LightChoices8& choices, Mask8 lanes,
                             Float8 u, Float8 v, LightSamples8* samples) const {
  Vec3x8 to(Vec3f::UnitZ());
  for (int lane = 0; lane < kLanes; ++lane) {
    if (lanes[lane] == 0) continue;
    if (const Enclosure* in = table_->EnclosureAt(at.room[lane])) {
      const size_t way = static_cast<size_t>(choices.light[lane]) - table_->lamps().size();
      const Portal& portal = in->portals[way];
      to.Set(lane, portal.corner + portal.edge_u * u[lane] + portal.edge_v * v[lane] -
                       at.position.Get(lane));
    } else if (table_->sky().has_environment()) {
      to.Set(lane, table_->sky().SampleEnvironment(u[lane], v[lane]));
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
  samples->radiance = Select(shines, table_->sky().Radiance(direction), samples->radiance);
  samples->distance = shines ? Splat(kInfinity) : samples->distance;
  samples->pdf = shines ? SkyPdf(at, direction) : samples->pdf;
}

LightSample LightSampler::SampleSun(const Vec2f& u) const {
  LightSample sample;
  const float one_minus_cos = u.x() * (1.0f - table_->sky().cos_sun());
  const ShadingFrame frame(table_->sky().sun_direction());
  sample.direction = frame.ToWorld(DirectionAt(1.0f - one_minus_cos, 2.0f * kPi * u.y()));
  sample.distance = kInfinity;
  sample.radiance = table_->sky().SunRadiance();
  sample.pdf = 1.0f / table_->sky().sun_solid_angle();
  return sample;
}

}  // namespace parallax
