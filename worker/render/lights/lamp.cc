#include "worker/render/lights/lamp.h"

#include "common/math/proto.h"

namespace parallax {

bool Lamp::AddFace(const Vec3f corners[3]) {
  LampFace face;
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

void Lamp::IndexFaces() {
  // Four would end more searches at once but miss the caches; one leaves too many faces to search.
  constexpr size_t kGuidesPerFace = 2;
  constexpr float kRounded = 1.0f - 1e-6f;  // Rounding may begin a part early.
  guides_.resize(kGuidesPerFace * faces.size());
  guides_per_m2_ = static_cast<float>(guides_.size()) / area;
  uint32_t face = 0;
  for (size_t i = 0; i < guides_.size(); ++i) {
    const float start = static_cast<float>(i) / guides_per_m2_ * kRounded;
    while (face + 1 < faces.size() && faces[face + 1].below <= start) ++face;
    guides_[i] = {face, face + 1 < faces.size() ? faces[face + 1].below : kInfinity};
  }
}

uint32_t Lamp::FaceAt(float at) const {
  const auto part = static_cast<size_t>(static_cast<uint32_t>(at * guides_per_m2_));
  const Guide& guide = guides_[std::min(part, guides_.size() - 1)];
  if (guide.end > at) return guide.face;
  uint32_t face = guide.face + 1;
  while (face + 1 < faces.size() && faces[face + 1].below <= at) ++face;
  return face;
}

absl::StatusOr<Lamp> MakePointLamp(const v1::Light& light, const Vec3f& power_w) {
  Lamp lamp;
  lamp.center = FromProto(light.position_m()).cast<float>();
  lamp.radius = static_cast<float>(std::max(0.0, light.radius_m()));
  float solid_angle = 4.0f * kPi;  // Filled by the flux, with the soft edge weighted.
  if (light.kind() == v1::Light::KIND_SPOT) {
    const Vec3f axis = FromProto(light.direction()).cast<float>();
    const auto cone = static_cast<float>(light.cone_rad());
    if (!(axis.norm() > 1e-12f) || !(cone > 0.0f) || !(cone <= kPi + 1e-5f)) {
      return InvalidArgument(
          "light \"{}\": a spot wants a direction and a cone_rad of more than 0 up to pi",
          light.name());
    }
    lamp.spot = true;
    lamp.axis = axis.normalized();
    lamp.cos_outer = std::min(std::cos(cone), 0.999999f);
    const auto blend = static_cast<float>(std::clamp(light.cone_blend(), 0.0, 1.0));
    lamp.cos_inner = lamp.cos_outer + blend * (1.0f - lamp.cos_outer);
    // The mean of the smooth step is a half.
    solid_angle = 2.0f * kPi * (1.0f - 0.5f * (lamp.cos_outer + lamp.cos_inner));
  }
  lamp.strength = Luminance(power_w) / solid_angle;
  if (lamp.radius > 0.0f) {
    lamp.radiance = power_w / (kPi * solid_angle * Square(lamp.radius));
  } else {
    lamp.intensity = power_w / solid_angle;
  }
  return lamp;
}

}  // namespace parallax
