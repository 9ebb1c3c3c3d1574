#include "worker/render/lights.h"

#include "common/base/status.h"
#include "common/math/proto.h"

namespace parallax {
namespace {

Mask8 Contains(const Box3f& box, const Vec3x8& p) {
  const Vec3x8 low = Vec3x8(box.min()), high = Vec3x8(box.max());
  return (p.x >= low.x) & (p.x <= high.x) & (p.y >= low.y) & (p.y <= high.y) & (p.z >= low.z) &
         (p.z <= high.z);
}

}  // namespace

absl::StatusOr<LightTable> LightTable::Build(const v1::Scene& scene, const RenderScene& geometry) {
  LightTable table;
  const Surroundings& surroundings = geometry.geometry().surroundings;
  std::shared_ptr<const Environment> environment;
  if (scene.sky().environment() != 0) {
    ASSIGN_OR_RETURN(environment, OpenEnvironment(scene.sky().environment()));
  }
  table.sky_ = SkyModel(scene.sky(), surroundings.ground_below_horizon, std::move(environment));
  if (scene.has_air()) table.haze_ = Haze(scene.air());
  table.lights_of_body_.resize(geometry.body_count());
  for (const v1::Light& light : scene.lights()) {
    const Vec3f power = FromProto(light.power_w()).cast<float>().cwiseMax(0.0f);
    if (!(power.maxCoeff() > 0.0f)) continue;
    Lamp lamp;
    lamp.strength = Luminance(power) / (4.0f * kPi);
    if (light.kind() == v1::Light::KIND_POINT || light.kind() == v1::Light::KIND_SPOT) {
      RETURN_IF_ERROR(AddSphereOrSpot(light, power, &lamp));
      if (lamp.radius > 0.0f) table.spheres_.push_back(table.lamps_.size());
      table.lamps_.push_back(std::move(lamp));
      continue;
    }
    if (light.kind() != v1::Light::KIND_MESH) {
      return InvalidArgument("light \"{}\": kind must be point, spot or mesh", light.name());
    }
    lamp.mesh = true;
    Box3f box;
    for (uint32_t p = 0; p < geometry.geometry().meshes.size(); ++p) {
      const PlacedMesh& placed = geometry.geometry().meshes[p];
      if (placed.object_index != light.object_index()) continue;
      const Mesh& mesh = *placed.mesh;
      SlotLights& lights = table.lights_of_body_[p];
      if (lights.count == 0) {
        lights = {static_cast<uint32_t>(table.mesh_lights_.size()),
                  static_cast<uint32_t>(mesh.slots.size())};
        table.mesh_lights_.resize(lights.first + lights.count, -1);
      }
      for (uint32_t t = 0; t < mesh.triangles.size(); ++t) {
        const uint16_t slot = mesh.triangles[t].slot;
        if (slot >= mesh.slots.size() || mesh.slots[slot].name != light.slot()) continue;
        Vec3f corners[3];
        geometry.Corners(p, t, corners);
        if (!lamp.AddFace(corners)) continue;
        table.mesh_lights_[lights.first + slot] = static_cast<int32_t>(table.lamps_.size());
        for (const Vec3f& corner : corners) box.extend(corner);
      }
    }
    if (lamp.faces.empty()) continue;
    lamp.center = box.center();
    lamp.radius = 0.5f * box.diagonal().norm();
    lamp.radiance = power / (kPi * lamp.area);
    lamp.MakeGuides();
    table.lamps_.push_back(std::move(lamp));
  }
  for (const Lamp& lamp : table.lamps_) {
    table.kinds_.push_back(lamp.mesh ? kFaces : lamp.radius > 0.0f ? kSphere : kIdeal);
  }
  table.kinds_.push_back(kNoLamp);
  for (const SkyEnclosure& enclosure : surroundings.enclosures) {
    table.AddEnclosure(enclosure, geometry);
  }
  table.Forget();
  return table;
}

void LightTable::Forget() {
  for (Enclosure& enclosure : enclosures_) {
    enclosure.gains = LightGains(enclosure.box, lamps_.size() + enclosure.portals.size() + 1);
    enclosure.spots = BrightSpots();
  }
}

// False for a face without area.
bool LightTable::Lamp::AddFace(const Vec3f corners[3]) {
  Face face;
  face.corner = corners[0];
  face.edge_u = corners[1] - corners[0];
  face.edge_v = corners[2] - corners[0];
  const Vec3f cross = face.edge_v.cross(face.edge_u);
  const float length = cross.norm();
  face.below = area;
  face.area = area + 0.5f * length - face.below;
  if (!(face.area > 0.0f)) return false;
  face.back = cross / length;
  area = face.below + face.area;
  faces.push_back(face);
  return true;
}

void LightTable::Lamp::MakeGuides() {
  // Four would end more searches at once but miss the caches; one leaves too many faces to search.
  constexpr size_t kGuidesPerFace = 2;
  constexpr float kRounded = 1.0f - 1e-6f;  // Rounding may begin a part early.
  guides.resize(kGuidesPerFace * faces.size());
  guides_per_m2 = static_cast<float>(guides.size()) / area;
  uint32_t face = 0;
  for (size_t i = 0; i < guides.size(); ++i) {
    const float start = static_cast<float>(i) / guides_per_m2 * kRounded;
    while (face + 1 < faces.size() && faces[face + 1].below <= start) ++face;
    guides[i] = {face, face + 1 < faces.size() ? faces[face + 1].below : kInfinity};
  }
}

uint32_t LightTable::Lamp::FaceAt(float at) const {
  const Guide& guide = GuideAt(at);
  if (guide.end > at) return guide.face;
  uint32_t face = guide.face + 1;
  while (face + 1 < faces.size() && faces[face + 1].below <= at) ++face;
  return face;
}

absl::Status LightTable::AddSphereOrSpot(const v1::Light& light, const Vec3f& power, Lamp* lamp) {
  lamp->center = FromProto(light.position_m()).cast<float>();
  lamp->radius = static_cast<float>(std::max(0.0, light.radius_m()));
  float solid_angle = 4.0f * kPi;  // Filled by the flux, with the soft edge weighted.
  if (light.kind() == v1::Light::KIND_SPOT) {
    const Vec3f axis = FromProto(light.direction()).cast<float>();
    const auto cone = static_cast<float>(light.cone_rad());
    if (!(axis.norm() > 1e-12f) || !(cone > 0.0f) || !(cone <= kPi + 1e-5f)) {
      return InvalidArgument(
          "light \"{}\": a spot wants a direction and a cone_rad of more than 0 up to pi",
          light.name());
    }
    lamp->spot = true;
    lamp->axis = axis.normalized();
    lamp->cos_outer = std::min(std::cos(cone), 0.999999f);
    const auto blend = static_cast<float>(std::clamp(light.cone_blend(), 0.0, 1.0));
    lamp->cos_inner = lamp->cos_outer + blend * (1.0f - lamp->cos_outer);
    // The mean of the smooth step is a half.
    solid_angle = 2.0f * kPi * (1.0f - 0.5f * (lamp->cos_outer + lamp->cos_inner));
  }
  lamp->strength = Luminance(power) / solid_angle;
  if (lamp->radius > 0.0f) {
    lamp->radiance = power / (kPi * solid_angle * Square(lamp->radius));
  } else {
    lamp->intensity = power / solid_angle;
  }
  return absl::OkStatus();
}

void LightTable::AddEnclosure(const SkyEnclosure& from, const RenderScene& geometry) {
  Enclosure enclosure;
  enclosure.box = from.box;
  for (const SkyPortal& way : from.portals) {
    const Portal portal{way.corner, way.edge_u, way.edge_v, way.normal,
                        way.edge_u.cross(way.edge_v).norm()};
    // A portal that lets no light through (a closed door) is not worth samples.
    constexpr int kProbes = 8;
    bool open = false;
    for (int i = 0; i < kProbes * kProbes && !open; ++i) {
      const Vec3f p = portal.corner +
                      portal.edge_u * ((static_cast<float>(i % kProbes) + 0.5f) / kProbes) +
                      portal.edge_v * ((static_cast<float>(i / kProbes) + 0.5f) / kProbes);
      open = geometry.Transmittance(p - way.normal * (way.depth_m + 0.05f), way.normal, 1e3f)
                 .maxCoeff() > 0.0f;
    }
    if (open && portal.area > 0.0f) enclosure.portals.push_back(portal);
  }
  if (sky_.has_sun()) AddSunWindows(&enclosure);
  enclosures_.push_back(std::move(enclosure));
}

// The line from p to the sun is p + s (height - n.p) / n.s: both coordinates there are linear in
// p.
void LightTable::AddSunWindows(Enclosure* enclosure) const {
  const Vec3f sun = sky_.sun_direction();
  for (const Portal& portal : enclosure->portals) {
    const float cosine = portal.normal.dot(sun);
    if (cosine <= 1e-4f) continue;
    SunWindow window;
    const float height = portal.normal.dot(portal.corner);
    const auto coordinate = [&](const Vec3f& edge, Vec3f* along, float* from) {
      const Vec3f scaled = edge / edge.squaredNorm();
      const float slant = scaled.dot(sun) / cosine;
      *along = scaled - slant * portal.normal;
      *from = slant * height - scaled.dot(portal.corner);
    };
    coordinate(portal.edge_u, &window.along_u, &window.from_u);
    coordinate(portal.edge_v, &window.along_v, &window.from_v);
    enclosure->sun_windows.push_back(window);
  }
}

Float8 LightTable::LampImportance(const Lamp& lamp, const Vec3x8& position) const {
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

// Mean luminance of the sky times the approximate solid angle of the opening.
Float8 LightTable::PortalImportance(const Portal& portal, const Vec3x8& position) const {
  const Vec3x8 to = Vec3x8(portal.center()) - position;
  const Float8 height = Dot(Vec3x8(portal.normal), to);
  const Float8 d2 = Dot(to, to);
  // Blended with its square root, so that openings seen at grazing angles, parts of which are
  // nearer than the middle, keep their share.
  const Float8 cosine = height / Sqrt(d2);
  const Float8 importance =
      sky_.mean_luminance() * portal.area * (0.25f + 0.75f * cosine) / (d2 + 0.5f * portal.area);
  return height > 1e-4f ? importance : Splat(0);
}

float LightTable::DomeImportance() const {
  return sky_.has_sky() ? 2.0f * kPi * sky_.mean_luminance() : 0.0f;
}

Float8 LightTable::SunImportance(const Enclosure* in, const Vec3x8& position) const {
  if (!sky_.has_sun()) return Splat(0);
  const Float8 irradiance = Splat(Luminance(sky_.SunRadiance()) * sky_.sun_solid_angle());
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

size_t LightTable::portals() const {
  size_t sum = 0;
  for (const Enclosure& enclosure : enclosures_) sum += enclosure.portals.size();
  return sum;
}

size_t LightTable::LightsIn(const Enclosure* in) const {
  return lamps_.size() + (in ? in->portals.size() : 1) + 1;
}

Float8 LightTable::Importance(const Enclosure* in, const Vec3x8& position, Int8 cells,
                              size_t light) const {
  Float8 promise;
  if (light < lamps_.size()) {
    promise = LampImportance(lamps_[light], position);
  } else if (light + 1 == LightsIn(in)) {
    promise = SunImportance(in, position);
  } else {
    promise = in ? PortalImportance(in->portals[light - lamps_.size()], position)
                 : Splat(DomeImportance());
  }
  return in ? promise * in->gains.Of(cells, light) : promise;
}

float LightTable::Importance(const LightReceiver& at, size_t light) const {
  return Importance(RoomAt(at.room), Vec3x8(at.position), Int8{} + at.cell, light)[0];
}

float LightTable::Chance(const LightReceiver& at, size_t light) const {
  return at.total > 0.0f ? Importance(at, light) / at.total : 0.0f;
}

void LightTable::Choose(const LightQueries8& queries, std::vector<Float8>* scratch,
                        LightReceivers8* receivers, LightChoices8* choices) const {
  *receivers = {queries.position, ~Int8{}, Int8{}, Splat(0)};
  *choices = {Int8{}, Splat(0), Int8{}};
  Mask8 left = FirstLanes(queries.count);
  for (size_t room = 0; room < enclosures_.size() && Any(left); ++room) {
    const Mask8 members = left & Contains(enclosures_[room].box, queries.position);
    if (!Any(members)) continue;
    ChooseIn(static_cast<int32_t>(room), members, queries, scratch, receivers, choices);
    left &= ~members;
  }
  if (Any(left)) ChooseIn(-1, left, queries, scratch, receivers, choices);
}

PARALLAX_LANE_CLONES void LightTable::ChooseIn(int32_t room, Mask8 members,
                                               const LightQueries8& queries,
                                               std::vector<Float8>* importances,
                                               LightReceivers8* receivers,
                                               LightChoices8* choices) const {
  const Enclosure* in = RoomAt(room);
  const Int8 cells = in ? in->gains.CellOf(queries.position, queries.normal) : Int8{};
  const size_t count = LightsIn(in);
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
void LightTable::Aim(Float8 u, LightChoices8* choices) const {
  for (int lane = 0; lane < kLanes; ++lane) {
    const auto light = static_cast<size_t>(choices->light[lane]);
    const Lamp& lamp = light < lamps_.size() ? lamps_[light] : no_lamp_;
    const uint32_t face = lamp.FaceAt(u[lane] * lamp.area);
    choices->face[lane] = static_cast<int32_t>(face);
    __builtin_prefetch(lamp.faces.data() + face);
  }
}

LightTrial LightTable::Trial(const LightReceiver& at, int32_t light, float pdf,
                             float irradiance) const {
  if (at.room < 0) return {};
  const float gain = RoomAt(at.room)->gains.Of(at.cell, light);
  const float arrived = irradiance > 0.0f ? irradiance / pdf : 0.0f;
  return {at.room, at.cell, light, arrived * gain / at.total};
}

void LightTable::Learn(std::span<const std::vector<LightTrial>> trials) {
  for (const std::vector<LightTrial>& some : trials) {
    for (const LightTrial& trial : some) {
      LightGains& gains = enclosures_[static_cast<size_t>(trial.room)].gains;
      gains.Add(trial.cell, trial.light, trial.gain);
    }
  }
  for (Enclosure& enclosure : enclosures_) enclosure.gains.Learn();
}

void LightTable::Learn(std::span<const std::vector<LightSeen>> seen) {
  for (const std::vector<LightSeen>& some : seen) {
    for (const LightSeen& one : some) {
      for (Enclosure& enclosure : enclosures_) {
        if (!enclosure.box.contains(one.position)) continue;
        enclosure.spots.Add(one.position, one.normal, one.radiance);
        break;
      }
    }
  }
  for (Enclosure& enclosure : enclosures_) enclosure.spots.Learn();
}

}  // namespace parallax
