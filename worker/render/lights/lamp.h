// A lamp of a scene, ready for sampling: a sphere or spot that only light sees, an ideal point, or
// the shining faces of a mesh.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "parallax/v1/scene.pb.h"
#include "worker/render/scene/render_scene.h"

namespace parallax {

// A triangle of a mesh light. It fills one cache line, because faces are read at random.
struct alignas(64) LampFace {
  Vec3f corner, edge_u, edge_v;
  Vec3f back;            // Unit, opposite to the side that shines.
  float below = 0;       // Area of the faces before it, m^2.
  float area = 0;        // m^2.
  float unused[2] = {};  // Loaded with the rest.
};

// One lamp. Lengths are in m, in the world's frame; power-like values are per colour channel.
struct Lamp {
  Vec3f center = Vec3f::Zero();
  float radius = 0;                 // Radius of the sphere, or of one around a mesh light's faces.
  Vec3f radiance = Vec3f::Zero();   // W / (m^2 sr); ideal points have none.
  Vec3f intensity = Vec3f::Zero();  // W / sr; only ideal points have one.
  float strength = 0;               // Luminance of the flux, as seen from any side.

  // Only spot lights have a cone; the others shine to all sides.
  bool spot = false;
  Vec3f axis = Vec3f::UnitZ();
  float cos_outer = -1, cos_inner = -1;  // Dark beyond the first, full within the second.

  // Only mesh lights have faces.
  bool mesh = false;
  std::vector<LampFace> faces;
  float area = 0;  // Total area of the faces, m^2.

  // The share of the full intensity along unit `direction`, away from the lamp.
  float Falloff(const Vec3f& direction) const {
    if (!spot) return 1.0f;
    const float cosine = direction.dot(axis);
    if (cosine >= cos_inner) return cosine > cos_outer ? 1.0f : 0.0f;
    if (cosine <= cos_outer) return 0.0f;
    const float t = (cosine - cos_outer) / (cos_inner - cos_outer);
    return t * t * (3.0f - 2.0f * t);
  }

  // The face at a position in the cumulative area, 0 <= at < area; 0 for a lamp without faces.
  uint32_t FaceAt(float at) const;

  // Adds a triangle; false for one without area.
  bool AddFace(const Vec3f corners[3]);
  // Builds the index that FaceAt uses. Call once, after the last face.
  void IndexFaces();

 private:
  // An index into the faces' cumulative area: for each of its equal parts, the first face and the
  // end of that face. One entry where there are no faces.
  struct Guide {
    uint32_t face = 0;
    float end = 0;
  };
  std::vector<Guide> guides_ = {{0, kInfinity}};
  float guides_per_m2_ = 0;
};

// A lamp of a point or spot light that emits `power_w`. Errors: kInvalidArgument for a spot without
// a direction, or with a cone outside of (0, pi].
absl::StatusOr<Lamp> MakePointLamp(const v1::Light& light, const Vec3f& power_w);

}  // namespace parallax
