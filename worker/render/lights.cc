#include "worker/render/lights.h"

#include "common/math/proto.h"

namespace parallax {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();
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
        std::array<Vec3f, 3> corners;
        geometry.Corners(p, t, corners.data());
        const float area = 0.5f * (corners[1] - corners[0]).cross(corners[2] - corners[0]).norm();
        if (!(area > 0.0f)) continue;
        lights[slot] = static_cast<int>(table.lamps_.size());
        lamp.cumulative.push_back(area + (lamp.cumulative.empty() ? 0 : lamp.cumulative.back()));
        lamp.faces.push_back(corners);
        for (const Vec3f& corner : corners) box.extend(corner);
      }
    }
    if (lamp.faces.empty()) continue;
    lamp.center = box.center();
    lamp.radius = 0.5f * box.diagonal().norm();
    lamp.radiance = power / (kPi * lamp.cumulative.back());
    table.lamps_.push_back(std::move(lamp));
  }
  table.AddPortals(scene, geometry);
  return table;
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

void LightTable::AddPortals(const v1::Scene& scene, const RenderScene& geometry) {
  if (!scene.has_room() || !(scene.room().width_m() > 0)) return;
  const v1::Room& room = scene.room();
  const auto w = static_cast<float>(room.width_m());
  const auto d = static_cast<float>(room.depth_m());
  const auto h = static_cast<float>(room.height_m());
  const auto wall = static_cast<float>(room.wall_thickness_m());
  has_room_ = true;
  // A little less than the walls' outer faces, whose own points are outside.
  const float rim = std::max(0.0f, wall - 1e-3f);
  room_ = Box3f(Vec3f(-rim, -rim, -rim), Vec3f(w + rim, d + rim, h + rim));

  const auto add = [&](const Vec3f& corner, const Vec3f& u, const Vec3f& v, const Vec3f& out) {
    Portal portal{corner, u, v, out, u.cross(v).norm()};
    // A portal that lets nothing through (a closed door) is not worth samples.
    constexpr int kProbes = 8;
    int open = 0;
    for (int i = 0; i < kProbes * kProbes; ++i) {
      const Vec3f p = corner + u * ((static_cast<float>(i % kProbes) + 0.5f) / kProbes) +
                      v * ((static_cast<float>(i / kProbes) + 0.5f) / kProbes);
      const Vec3f start = p - out * (wall + 0.05f);
      if (geometry.Transmittance(start, out, 1e3f).maxCoeff() > 0.0f) ++open;
    }
    if (open > 0 && portal.area > 0.0f) portals_.push_back(portal);
  };
  for (const v1::Opening& opening : room.openings()) {
    const auto width = static_cast<float>(opening.width_m());
    const auto height = static_cast<float>(opening.height_m());
    const auto start = static_cast<float>(opening.center_m()) - 0.5f * width;
    const auto sill = static_cast<float>(opening.sill_m());
    const Vec3f up = height * Vec3f::UnitZ();
    switch (opening.wall()) {
      case 0:
        add({start, -wall, sill}, width * Vec3f::UnitX(), up, -Vec3f::UnitY());
        break;
      case 1:
        add({w + wall, start, sill}, width * Vec3f::UnitY(), up, Vec3f::UnitX());
        break;
      case 2:
        add({start, d + wall, sill}, width * Vec3f::UnitX(), up, Vec3f::UnitY());
        break;
      default:
        add({-wall, start, sill}, width * Vec3f::UnitY(), up, -Vec3f::UnitX());
        break;
    }
  }
  if (scene.ceiling_removed()) {
    room_.max().z() = h - 1e-3f;
    add({0, 0, h}, w * Vec3f::UnitX(), d * Vec3f::UnitY(), Vec3f::UnitZ());
  }
}

float LightTable::LampImportance(const Lamp& lamp, const Vec3f& position) const {
  const Vec3f from = position - lamp.center;
  const float d2 = from.squaredNorm();
  const float importance = lamp.strength / std::max(d2, Square(lamp.radius) + 1e-4f);
  if (!lamp.spot || d2 <= Square(lamp.radius)) return importance;
  // By the intensity towards the point; a sphere's rim may see it at a smaller angle.
  const float cosine = std::clamp(from.dot(lamp.axis) / std::sqrt(d2), -1.0f, 1.0f);
  const float sin2 = Square(lamp.radius) / d2;
  const float cos_rim = std::sqrt(1.0f - sin2);
  const float nearest =
      cosine >= cos_rim ? 1.0f : cosine * cos_rim + std::sqrt((1.0f - cosine * cosine) * sin2);
  if (nearest <= lamp.cos_outer) return 0.0f;
  const float t =
      lamp.cos_inner > lamp.cos_outer
          ? std::min(1.0f, (nearest - lamp.cos_outer) / (lamp.cos_inner - lamp.cos_outer))
          : 1.0f;
  return importance * (0.05f + 0.95f * t * t * (3.0f - 2.0f * t));
}

// Mean luminance of the sky times about the solid angle of the opening.
float LightTable::PortalImportance(const Portal& portal, const Vec3f& position) const {
  const Vec3f to = portal.corner + 0.5f * (portal.edge_u + portal.edge_v) - position;
  const float height = portal.normal.dot(to);
  if (height <= 1e-4f) return 0;
  const float d2 = to.squaredNorm();
  const float d = std::sqrt(d2);
  // Mixed with its square root so that obliquely seen openings, nearer than their middle, keep
  // their share.
  const float cosine = height / d;
  return sky_.mean_luminance() * portal.area * (0.25f + 0.75f * cosine) / (d2 + 0.5f * portal.area);
}

float LightTable::DomeImportance() const {
  return sky_.has_sky() ? 2.0f * kPi * sky_.mean_luminance() : 0.0f;
}

float LightTable::SunImportance(const LightReceiver& at) const {
  if (!sky_.has_sun()) return 0;
  const float irradiance = Luminance(sky_.SunRadiance()) * sky_.sun_solid_angle();
  if (!at.in_room) return irradiance;
  // Only through an opening.
  for (const Portal& portal : portals_) {
    const float cosine = portal.normal.dot(sky_.sun_direction());
    const float height = portal.normal.dot(portal.corner - at.position);
    if (cosine <= 1e-4f || height <= 0.0f) continue;
    const Vec3f q = at.position + sky_.sun_direction() * (height / cosine) - portal.corner;
    const float a = q.dot(portal.edge_u) / portal.edge_u.squaredNorm();
    const float b = q.dot(portal.edge_v) / portal.edge_v.squaredNorm();
    // The disk's width at the opening may reach a little past its edge.
    if (a > -0.05f && a < 1.05f && b > -0.05f && b < 1.05f) return irradiance;
  }
  return 0;
}

LightReceiver LightTable::Receive(const Vec3f& position) const {
  LightReceiver at;
  at.position = position;
  at.in_room = has_room_ && room_.contains(position);
  for (const Lamp& lamp : lamps_) at.total += LampImportance(lamp, position);
  if (at.in_room) {
    for (const Portal& portal : portals_) at.total += PortalImportance(portal, position);
  } else {
    at.total += DomeImportance();
  }
  at.total += SunImportance(at);
  return at;
}

LightSample LightTable::Sample(const LightReceiver& at, float choice, const Vec2f& u) const {
  float left = choice * at.total;
  if (!(at.total > 0.0f)) return {};
  const auto chosen = [&](float importance) {
    if (left < importance) return true;
    left -= importance;
    return false;
  };
  for (const Lamp& lamp : lamps_) {
    const float importance = LampImportance(lamp, at.position);
    if (!chosen(importance)) continue;
    LightSample sample = SampleLamp(lamp, at.position, u);
    sample.pdf *= importance / at.total;
    return sample;
  }
  if (at.in_room) {
    for (const Portal& portal : portals_) {
      if (chosen(PortalImportance(portal, at.position))) return SamplePortal(portal, at, u);
    }
  } else if (chosen(DomeImportance())) {
    return SampleDome(at, u);
  }
  const float importance = SunImportance(at);
  if (importance <= 0.0f) return {};
  LightSample sample = SampleSun(u);
  sample.pdf *= importance / at.total;
  return sample;
}

LightSample LightTable::SampleLamp(const Lamp& lamp, const Vec3f& position, const Vec2f& u) const {
  LightSample sample;
  const Vec3f to = lamp.center - position;
  const float d2 = to.squaredNorm();
  if (lamp.mesh) {
    const float area = u.x() * lamp.cumulative.back();
    const auto found = std::upper_bound(lamp.cumulative.begin(), lamp.cumulative.end(), area);
    const size_t face = std::min<size_t>(static_cast<size_t>(found - lamp.cumulative.begin()),
                                         lamp.cumulative.size() - 1);
    const float below = face > 0 ? lamp.cumulative[face - 1] : 0.0f;
    const float own = lamp.cumulative[face] - below;
    // What is left of the first number after the choice serves again.
    const Vec2f b = SampleTriangle({std::clamp((area - below) / own, 0.0f, 1.0f), u.y()});
    const auto& corners = lamp.faces[face];
    const Vec3f e1 = corners[1] - corners[0];
    const Vec3f e2 = corners[2] - corners[0];
    const Vec3f v = corners[0] + b.x() * e1 + b.y() * e2 - position;
    const float v2 = v.squaredNorm();
    if (!(v2 > 1e-12f)) return sample;
    sample.distance = std::sqrt(v2);
    sample.direction = v / sample.distance;
    const float cosine = -e1.cross(e2).normalized().dot(sample.direction);
    if (cosine <= 1e-5f) return sample;
    sample.pdf = v2 / (cosine * lamp.cumulative.back());
    sample.radiance = lamp.radiance;
    return sample;
  }
  if (lamp.radius <= 0.0f) {
    if (!(d2 > 1e-12f)) return sample;
    sample.distance = std::sqrt(d2);
    sample.direction = to / sample.distance;
    sample.radiance = lamp.intensity * (lamp.Falloff(-sample.direction) / d2);
    sample.pdf = 1;
    sample.ideal = true;
    return sample;
  }
  const float sin2 = Square(lamp.radius) / d2;
  if (sin2 >= 1.0f) return sample;  // Inside of the lamp.
  const float cone = ConeHeight(sin2);
  const float one_minus_cos = u.x() * cone;
  const float sin_theta = std::sqrt(std::max(0.0f, one_minus_cos * (2.0f - one_minus_cos)));
  const float phi = 2.0f * kPi * u.y();
  const ShadingFrame frame(to / std::sqrt(d2));
  sample.direction =
      frame.ToWorld({sin_theta * std::cos(phi), sin_theta * std::sin(phi), 1.0f - one_minus_cos});
  sample.distance = HitSphere(position, sample.direction, lamp.center, lamp.radius);
  if (!std::isfinite(sample.distance)) sample.distance = std::sqrt(d2 - Square(lamp.radius));
  sample.pdf = 1.0f / (2.0f * kPi * cone);
  sample.radiance = lamp.radiance * lamp.Falloff(-sample.direction);
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
  if (!at.in_room) {
    const float pdf = (direction.z() >= 0.0f ? kUpperShare : 1.0f - kUpperShare) / (2.0f * kPi);
    return pdf * DomeImportance() / at.total;
  }
  float pdf = 0;
  for (const Portal& portal : portals_) {
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
    pdf += PortalImportance(portal, at.position) * Square(distance) / (cosine * portal.area);
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
  return LampImportance(lamp, at.position) / at.total * Square(distance) /
         (cosine * lamp.cumulative.back());
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
      const float pdf = sin2 < 1.0f ? LampImportance(lamp, at.position) / at.total /
                                          (2.0f * kPi * ConeHeight(sin2))
                                    : 0.0f;
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
    const float pdf =
        weighted && at.total > 0.0f ? SunImportance(at) / at.total / sky_.sun_solid_angle() : 0.0f;
    sum += sky_.SunRadiance() * (weighted ? PowerHeuristic(bsdf_pdf, pdf) : 1.0f);
  }
  return sum;
}

}  // namespace parallax
