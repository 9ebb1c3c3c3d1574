// Chooses lights by their importance.
#include "worker/render/lights/light_sampler.h"

namespace parallax {
namespace {

// Luminance of what the lamp sends to each position, before occlusion.
Float8 LampImportance(const Lamp& lamp, const Vec3x8& position) {
  const Vec3x8 from = position - Vec3x8(lamp.center);
  const Float8 d2 = Dot(from, from);
  const float radius2 = Square(lamp.radius);
  const Float8 importance = lamp.strength / Max(d2, radius2 + 1e-4f);
  if (!lamp.spot) return importance;
  // Intensity towards the point; the rim of a sphere may see it at a smaller angle.
  const Float8 cosine = Clamp(Dot(from, Vec3x8(lamp.axis)) / Sqrt(d2), -1.0f, 1.0f);
  const Float8 sin2 = radius2 / d2;
  const Float8 cos_rim = Sqrt(1.0f - sin2);
  const Float8 rim = cosine * cos_rim + Sqrt((1.0f - cosine * cosine) * sin2);
  const Float8 nearest = cosine >= cos_rim ? Splat(1) : rim;
  const float soft = lamp.cos_inner - lamp.cos_outer;
  const Float8 t = soft > 0.0f ? Min((nearest - lamp.cos_outer) / soft, 1.0f) : Splat(1);
  const Float8 part =
      nearest > lamp.cos_outer ? 0.05f + 0.95f * t * t * (3.0f - 2.0f * t) : Splat(0);
  return d2 > radius2 ? importance * part : importance;
}

}  // namespace

// Mean luminance of the sky times the approximate solid angle of the opening.
Float8 LightSampler::PortalImportance(const Portal& portal, const Vec3x8& position) const {
  const Vec3x8 to = Vec3x8(portal.center()) - position;
  const Float8 height = Dot(Vec3x8(portal.normal), to);
  const Float8 d2 = Dot(to, to);
  // Blended with its square root, so that openings seen at grazing angles, parts of which are
  // nearer than the middle, keep their share.
  const Float8 cosine = height / Sqrt(d2);
  const Float8 importance = table_->sky().mean_luminance() * portal.area *
                            (0.25f + 0.75f * cosine) / (d2 + 0.5f * portal.area);
  return height > 1e-4f ? importance : Splat(0);
}

float LightSampler::DomeImportance() const {
  return table_->sky().has_sky() ? 2.0f * kPi * table_->sky().mean_luminance() : 0.0f;
}

Float8 LightSampler::SunImportance(const Enclosure* in, const Vec3x8& position) const {
  if (!table_->sky().has_sun()) return Splat(0);
  const Float8 irradiance =
      Splat(Luminance(table_->sky().SunRadiance()) * table_->sky().sun_solid_angle());
  if (!in) return irradiance;
  // The sun shines in only through an opening.
  Mask8 shone_on{};
  for (const SunWindow& window : in->sun_windows) {
    const Float8 a = Dot(Vec3x8(window.along_u), position) + window.from_u;
    const Float8 b = Dot(Vec3x8(window.along_v), position) + window.from_v;
    // The disk's width at the opening may reach a little past its edge.
    shone_on |= (a > -0.05f) & (a < 1.05f) & (b > -0.05f) & (b < 1.05f);
  }
  return shone_on ? irradiance : Splat(0);
}

Float8 LightSampler::Importance(const Enclosure* in, const Vec3x8& position, Int8 cells,
                                size_t light) const {
  Float8 promise;
  if (light < table_->lamps().size()) {
    promise = LampImportance(table_->lamps()[light], position);
  } else if (light + 1 == table_->LightsIn(in)) {
    promise = SunImportance(in, position);
  } else if (!sky_) {
    promise = Splat(0);
  } else {
    promise = in ? PortalImportance(in->portals[light - table_->lamps().size()], position)
                 : Splat(DomeImportance());
  }
  return in ? promise * in->gains.Of(cells, light) : promise;
}

float LightSampler::Importance(const LightReceiver& at, size_t light) const {
  return Importance(table_->EnclosureAt(at.room), Vec3x8(at.position), Int8{} + at.cell, light)[0];
}

float LightSampler::Chance(const LightReceiver& at, size_t light) const {
  return at.total > 0.0f ? Importance(at, light) / at.total : 0.0f;
}

void LightSampler::Choose(const LightQueries8& queries, std::vector<Float8>* scratch,
                          LightReceivers8* receivers, LightChoices8* choices) const {
  *receivers = {queries.position, ~Int8{}, Int8{}, Splat(0)};
  *choices = {Int8{}, Splat(0), Int8{}};
  Mask8 left = FirstLanes(queries.count);
  for (size_t room = 0; room < table_->enclosures().size() && Any(left); ++room) {
    const Mask8 members = left & table_->enclosures()[room].Holds(queries.position);
    if (!Any(members)) continue;
    ChooseIn(static_cast<int32_t>(room), members, queries, scratch, receivers, choices);
    left &= ~members;
  }
  if (Any(left)) ChooseIn(-1, left, queries, scratch, receivers, choices);
}

PARALLAX_LANE_CLONES void LightSampler::ChooseIn(int32_t room, Mask8 members,
                                                 const LightQueries8& queries,
                                                 std::vector<Float8>* importances,
                                                 LightReceivers8* receivers,
                                                 LightChoices8* choices) const {
  const Enclosure* in = table_->EnclosureAt(room);
  const Int8 cells = in ? in->gains.CellOf(queries.position, queries.normal) : Int8{};
  const size_t count = table_->LightsIn(in);
  if (importances->size() < count) importances->resize(count);
  Float8* const of = importances->data();
  Float8 total = Splat(0);
  for (size_t light = 0; light < count; ++light) {
    of[light] = Importance(in, queries.position, cells, light);
    total += of[light];
  }
  Float8 rest = queries.choice * total, importance = Splat(0);
  Int8 chosen{};
  Mask8 seeking = members;
  for (size_t light = 0; light < count && Any(seeking); ++light) {
    const Mask8 found = seeking & (rest < of[light]);
    importance = found ? of[light] : importance;
    chosen = found ? Int8{} + static_cast<int32_t>(light) : chosen;
    rest -= of[light];
    seeking &= ~found;
  }
  receivers->room = members ? Int8{} + room : receivers->room;
  receivers->cell = members ? cells : receivers->cell;
  receivers->total = members ? total : receivers->total;
  choices->light = members ? chosen : choices->light;
  choices->importance = members ? importance : choices->importance;
}

// Lights without faces get a dummy face: unpredictable branches cost more than loading it.
void LightSampler::Aim(Float8 u, LightChoices8* choices) const {
  for (int lane = 0; lane < kLanes; ++lane) {
    const auto light = static_cast<size_t>(choices->light[lane]);
    const Lamp& lamp = table_->LampAt(light);
    const uint32_t face = lamp.FaceAt(u[lane] * lamp.area);
    choices->face[lane] = static_cast<int32_t>(face);
    __builtin_prefetch(lamp.faces.data() + face);
  }
}

}  // namespace parallax
