#include "worker/render/lights.h"

#include "common/math/proto.h"

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

Mask8 Contains(const Box3f& box, const Vec3x8& p) {
  const Vec3x8 low = Vec3x8(box.min()), high = Vec3x8(box.max());
  return (p.x >= low.x) & (p.x <= high.x) & (p.y >= low.y) & (p.y <= high.y) & (p.z >= low.z) &
         (p.z <= high.z);
}

// 1 - cos of the sphere's angular radius, exact for small angles.
float ConeHeight(float sin2) { return sin2 / (1.0f + std::sqrt(std::max(0.0f, 1.0f - sin2))); }
Float8 ConeHeight(Float8 sin2) { return sin2 / (1.0f + Sqrt(Max(1.0f - sin2, 0.0f))); }

}  // namespace

absl::StatusOr<LightTable> LightTable::Build(const v1::Scene& scene, const RenderScene& geometry) {
  LightTable table;
  table.sky_ = SkyModel(scene.sky());
  table.mesh_lights_.resize(geometry.geometry().meshes.size());
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
      return MakeError(absl::StatusCode::kInvalidArgument,
                       "light \"" + light.name() + "\": kind must be point, spot or mesh");
    }
    lamp.mesh = true;
    Box3f box;
    for (uint32_t p = 0; p < geometry.geometry().meshes.size(); ++p) {
      const PlacedMesh& placed = geometry.geometry().meshes[p];
      if (placed.object_index != light.object_index()) continue;
      const Mesh& mesh = *placed.mesh;
      std::vector<int>& lights = table.mesh_lights_[p];
      lights.resize(mesh.slots.size(), -1);
      for (uint32_t t = 0; t < mesh.triangles.size(); ++t) {
        const uint16_t slot = mesh.triangles[t].slot;
        if (slot >= mesh.slots.size() || mesh.slots[slot].name != light.slot()) continue;
        Vec3f corners[3];
        geometry.Corners(p, t, corners);
        if (!lamp.AddFace(corners)) continue;
        lights[slot] = static_cast<int>(table.lamps_.size());
        for (const Vec3f& corner : corners) box.extend(corner);
      }
    }
    if (lamp.faces.empty()) continue;
    lamp.center = box.center();
    lamp.radius = 0.5f * box.diagonal().norm();
    lamp.radiance = power / (kPi * lamp.area);
    lamp.MakeGuide();
    table.lamps_.push_back(std::move(lamp));
  }
  if (scene.has_room()) table.AddRoom(scene.room(), scene.ceiling_removed(), geometry);
  for (const v1::Room& room : scene.rooms()) table.AddRoom(room, false, geometry);
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
  below.push_back(face.below);
  return true;
}

void LightTable::Lamp::MakeGuide() {
  guide.resize(faces.size());
  uint32_t face = 0;
  for (size_t i = 0; i < guide.size(); ++i) {
    const float start = area * static_cast<float>(i) / static_cast<float>(guide.size());
    while (face + 1 < faces.size() && below[face + 1] <= start) ++face;
    guide[i] = face;
  }
}

uint32_t LightTable::Lamp::FaceAt(float at) const {
  const auto part = static_cast<size_t>(at / area * static_cast<float>(guide.size()));
  uint32_t face = guide[std::min(part, guide.size() - 1)];
  while (face + 1 < below.size() && below[face + 1] <= at) ++face;
  return face;
}

absl::Status LightTable::AddSphereOrSpot(const v1::Light& light, const Vec3f& power, Lamp* lamp) {
  lamp->center = FromProto(light.position_m()).cast<float>();
  lamp->radius = static_cast<float>(std::max(0.0, light.radius_m()));
  float solid_angle = 4.0f * kPi;  // Into which the flux goes, the soft edge weighted.
  if (light.kind() == v1::Light::KIND_SPOT) {
    const Vec3f axis = FromProto(light.direction()).cast<float>();
    const auto cone = static_cast<float>(light.cone_rad());
    if (!(axis.norm() > 1e-12f) || !(cone > 0.0f) || !(cone <= kPi + 1e-5f)) {
      return MakeError(absl::StatusCode::kInvalidArgument,
                       "light \"" + light.name() +
                           "\": a spot wants a direction and a cone_rad of more than 0 up to pi");
    }
    lamp->spot = true;
    lamp->axis = axis.normalized();
    lamp->cos_outer = std::min(std::cos(cone), 0.999999f);
    const auto blend = static_cast<float>(std::clamp(light.cone_blend(), 0.0, 1.0));
    lamp->cos_inner = lamp->cos_outer + blend * (1.0f - lamp->cos_outer);
    // The smooth step's mean is a half.
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

void LightTable::AddRoom(const v1::Room& room, bool open_top, const RenderScene& geometry) {
  if (!(room.width_m() > 0)) return;
  const Vec3f origin = Vec3d(room.origin_x_m(), room.origin_y_m(), room.floor_z_m()).cast<float>();
  const Vec3f size = Vec3d(room.width_m(), room.depth_m(), room.height_m()).cast<float>();
  const auto wall_m = [&](int wall) {
    return static_cast<float>(room.wall_depth_m_size() == 4 ? room.wall_depth_m(wall)
                                                            : room.wall_thickness_m());
  };
  // A little less than the walls' outer faces, whose own points are outside.
  const auto rim = [&](int wall) { return std::max(0.0f, wall_m(wall) - 1e-3f); };
  Enclosure enclosure;
  enclosure.box = Box3f(origin - Vec3f(rim(3), rim(0), rim(0)),
                        origin + size + Vec3f(rim(1), rim(2), open_top ? -1e-3f : rim(0)));

  const auto add = [&](const Vec3f& corner, const Vec3f& u, const Vec3f& v, const Vec3f& out,
                       float depth) {
    Portal portal{origin + corner, u, v, out, u.cross(v).norm()};
    // A portal that lets nothing through (a closed door) is not worth samples.
    constexpr int kProbes = 8;
    bool open = false;
    for (int i = 0; i < kProbes * kProbes && !open; ++i) {
      const Vec3f p = portal.corner + u * ((static_cast<float>(i % kProbes) + 0.5f) / kProbes) +
                      v * ((static_cast<float>(i / kProbes) + 0.5f) / kProbes);
      open = geometry.Transmittance(p - out * (depth + 0.05f), out, 1e3f).maxCoeff() > 0.0f;
    }
    if (open && portal.area > 0.0f) enclosure.portals.push_back(portal);
  };
  for (const v1::Opening& opening : room.openings()) {
    const auto start = static_cast<float>(opening.center_m() - 0.5 * opening.width_m());
    const auto sill = static_cast<float>(opening.sill_m());
    const bool along_x = opening.wall() == 0 || opening.wall() == 2;
    const bool far = opening.wall() == 1 || opening.wall() == 2;
    const float depth = wall_m(opening.wall());
    const float across = far ? (along_x ? size.y() : size.x()) + depth : -depth;
    const Vec3f along = along_x ? Vec3f::UnitX() : Vec3f::UnitY();
    const Vec3f out = (far ? 1.0f : -1.0f) * (along_x ? Vec3f::UnitY() : Vec3f::UnitX());
    add(along_x ? Vec3f(start, across, sill) : Vec3f(across, start, sill),
        static_cast<float>(opening.width_m()) * along,
        static_cast<float>(opening.height_m()) * Vec3f::UnitZ(), out, depth);
  }
  if (open_top) {
    add({0, 0, size.z()}, {size.x(), 0, 0}, {0, size.y(), 0}, Vec3f::UnitZ(), wall_m(0));
  }
  if (sky_.has_sun()) AddSunWindows(&enclosure);
  enclosures_.push_back(std::move(enclosure));
}

// A point p goes to the sun through p + s (height - n.p) / n.s: both coordinates there are linear
// in p.
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
  // By the intensity towards the point; a sphere's rim may see it at a smaller angle.
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

// Mean luminance of the sky times about the solid angle of the opening.
Float8 LightTable::PortalImportance(const Portal& portal, const Vec3x8& position) const {
  const Vec3x8 to = Vec3x8(portal.center()) - position;
  const Float8 height = Dot(Vec3x8(portal.normal), to);
  const Float8 d2 = Dot(to, to);
  // Mixed with its square root so that obliquely seen openings, nearer than their middle, keep
  // their share.
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
  // Only through an opening.
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
  return Importance(at.enclosure, Vec3x8(at.position), Int8{} + static_cast<int32_t>(at.cell),
                    light)[0];
}

float LightTable::Chance(const LightReceiver& at, size_t light) const {
  return at.total > 0.0f ? Importance(at, light) / at.total : 0.0f;
}

void LightTable::Choose(const LightSeekers8& seekers, std::vector<Float8>* scratch,
                        LightReceiver* receivers, LightChoice* choices) const {
  Mask8 left{};
  for (int lane = 0; lane < seekers.count; ++lane) left[lane] = -1;
  for (const Enclosure& enclosure : enclosures_) {
    const Mask8 members = left & Contains(enclosure.box, seekers.position);
    if (!Any(members)) continue;
    ChooseIn(&enclosure, members, seekers, scratch, receivers, choices);
    left &= ~members;
  }
  if (Any(left)) ChooseIn(nullptr, left, seekers, scratch, receivers, choices);
}

void LightTable::ChooseIn(const Enclosure* in, Mask8 members, const LightSeekers8& seekers,
                          std::vector<Float8>* importances, LightReceiver* receivers,
                          LightChoice* choices) const {
  const Int8 cells = in ? in->gains.CellOf(seekers.position, seekers.normal) : Int8{};
  const size_t count = LightsIn(in);
  if (importances->size() < count) importances->resize(count);
  Float8* const of = importances->data();
  Float8 total = Splat(0);
  for (size_t light = 0; light < count; ++light) {
    of[light] = Importance(in, seekers.position, cells, light);
    total += of[light];
  }
  Float8 rest = seekers.choice * total, importance = Splat(0);
  Int8 chosen{};
  Mask8 seeking = members;
  for (size_t light = 0; light < count && Any(seeking); ++light) {
    const Mask8 found = seeking & (rest < of[light]);
    importance = found ? of[light] : importance;
    chosen = found ? chosen * 0 + static_cast<int32_t>(light) : chosen;
    rest -= of[light];
    seeking &= ~found;
  }
  for (int lane = 0; lane < seekers.count; ++lane) {
    if (members[lane] == 0) continue;
    receivers[lane] = {seekers.position.Get(lane), in, static_cast<uint32_t>(cells[lane]),
                       total[lane]};
    choices[lane] = {static_cast<uint32_t>(chosen[lane]), importance[lane]};
  }
}

void LightTable::Aim(const Vec2f& u, LightChoice* choice) const {
  if (choice->light >= lamps_.size() || !lamps_[choice->light].mesh) return;
  const Lamp& lamp = lamps_[choice->light];
  choice->face = lamp.FaceAt(u.x() * lamp.area);
  __builtin_prefetch(&lamp.faces[choice->face]);
}

LightTrial LightTable::Trial(const LightReceiver& at, const LightSample& sample,
                             float irradiance) const {
  if (!at.enclosure) return {};
  const float gain = at.enclosure->gains.Of(at.cell, sample.light);
  const float arrived = irradiance > 0.0f ? irradiance / sample.pdf : 0.0f;
  return {static_cast<int>(at.enclosure - enclosures_.data()), at.cell, sample.light,
          arrived * gain / at.total};
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
