#include "worker/render/lights/light_table.h"

#include "common/math/proto.h"

namespace parallax {
namespace {

Mask8 Contains(const Box3f& box, const Vec3x8& p) {
  const Vec3x8 low = Vec3x8(box.min()), high = Vec3x8(box.max());
  return (p.x >= low.x) & (p.x <= high.x) & (p.y >= low.y) & (p.y <= high.y) & (p.z >= low.z) &
         (p.z <= high.z);
}

// Whether skylight passes through the opening somewhere. A closed door's is not worth samples.
// Hills and trees may stand before an opening, so that rays that rise count as well.
bool IsOpen(const SkyPortal& way, const RenderScene& geometry) {
  constexpr int kProbes = 8;
  constexpr float kRises[] = {0.0f, 0.35f, 1.0f};  // Up against out.
  for (const float rise : kRises) {
    const Vec3f out = (way.normal + rise * Vec3f::UnitZ()).normalized();
    for (int i = 0; i < kProbes * kProbes; ++i) {
      const Vec3f p = way.corner +
                      way.edge_u * ((static_cast<float>(i % kProbes) + 0.5f) / kProbes) +
                      way.edge_v * ((static_cast<float>(i / kProbes) + 0.5f) / kProbes);
      const Vec3f inside = p - way.normal * (way.depth_m + 0.05f);
      if (geometry.Transmittance(inside, out, 1e3f).maxCoeff() > 0.0f) return true;
    }
  }
  return false;
}

}  // namespace

Mask8 Enclosure::Holds(const Vec3x8& points) const {
  Mask8 held = Contains(box, points);
  for (const HalfSpace& half : within) held &= Dot(points, Vec3x8(half.normal)) <= half.offset;
  return held;
}

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
    RETURN_IF_ERROR(table.AddLight(light, geometry));
  }
  for (const Lamp& lamp : table.lamps_) {
    table.kinds_.push_back(lamp.mesh ? kFaces : lamp.radius > 0.0f ? kSphere : kIdeal);
  }
  table.kinds_.push_back(kNoLamp);
  for (const SkyEnclosure& enclosure : surroundings.enclosures) {
    table.AddEnclosure(enclosure, geometry);
  }
  return table;
}

absl::Status LightTable::AddLight(const v1::Light& light, const RenderScene& geometry) {
  const Vec3f power = FromProto(light.power_w()).cast<float>().cwiseMax(0.0f);
  if (!(power.maxCoeff() > 0.0f)) return absl::OkStatus();
  if (light.kind() == v1::Light::KIND_POINT || light.kind() == v1::Light::KIND_SPOT) {
    ASSIGN_OR_RETURN(Lamp lamp, MakePointLamp(light, power));
    if (lamp.radius > 0.0f) spheres_.push_back(lamps_.size());
    lamps_.push_back(std::move(lamp));
    return absl::OkStatus();
  }
  if (light.kind() != v1::Light::KIND_MESH) {
    return InvalidArgument("light \"{}\": kind must be point, spot or mesh", light.name());
  }
  AddMeshLight(light, power, geometry);
  return absl::OkStatus();
}

void LightTable::AddMeshLight(const v1::Light& light, const Vec3f& power,
                              const RenderScene& geometry) {
  Lamp lamp;
  lamp.mesh = true;
  lamp.strength = Luminance(power) / (4.0f * kPi);
  Box3f box;
  for (uint32_t p = 0; p < geometry.geometry().meshes.size(); ++p) {
    if (geometry.geometry().meshes[p].object_index != light.object_index()) continue;
    AddFaces(light, geometry, p, &lamp, &box);
  }
  if (lamp.faces.empty()) return;
  lamp.center = box.center();
  lamp.radius = 0.5f * box.diagonal().norm();
  lamp.radiance = power / (kPi * lamp.area);
  lamp.IndexFaces();
  lamps_.push_back(std::move(lamp));
}

void LightTable::AddFaces(const v1::Light& light, const RenderScene& geometry, uint32_t placed,
                          Lamp* lamp, Box3f* box) {
  const Mesh& mesh = *geometry.geometry().meshes[placed].mesh;
  SlotLights& lights = lights_of_body_[placed];
  if (lights.count == 0) {
    lights = {static_cast<uint32_t>(mesh_lights_.size()), static_cast<uint32_t>(mesh.slots.size())};
    mesh_lights_.resize(lights.first + lights.count, -1);
  }
  for (uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    const uint16_t slot = mesh.triangles[t].slot;
    if (slot >= mesh.slots.size() || mesh.slots[slot].name != light.slot()) continue;
    Vec3f corners[3];
    geometry.Corners(placed, t, corners);
    if (!lamp->AddFace(corners)) continue;
    mesh_lights_[lights.first + slot] = static_cast<int32_t>(lamps_.size());
    for (const Vec3f& corner : corners) box->extend(corner);
  }
}

void LightTable::AddEnclosure(const SkyEnclosure& from, const RenderScene& geometry) {
  Enclosure enclosure;
  enclosure.box = from.box;
  enclosure.within = from.within;
  for (const SkyPortal& way : from.portals) {
    const Portal portal{way.corner, way.edge_u, way.edge_v, way.normal,
                        way.edge_u.cross(way.edge_v).norm()};
    if (IsOpen(way, geometry) && portal.area > 0.0f) enclosure.portals.push_back(portal);
  }
  if (sky_.has_sun()) AddSunWindows(&enclosure);
  enclosure.gains = LightGains(enclosure.box, LightsIn(&enclosure));
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

size_t LightTable::portals() const {
  size_t sum = 0;
  for (const Enclosure& enclosure : enclosures_) sum += enclosure.portals.size();
  return sum;
}

Vec3f LightTable::MeshRadiance(uint32_t placed, uint16_t slot) const {
  const int32_t light = MeshLight(placed, slot);
  return light >= 0 ? lamps_[static_cast<size_t>(light)].radiance : Vec3f::Zero();
}

}  // namespace parallax
