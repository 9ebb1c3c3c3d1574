// Surfaces that pictures describe: colour, roughness, metal and bent normals, by the metallic and
// roughness model that glTF and most libraries of materials use.
//   Source: Khronos, "glTF 2.0 specification", 3.9.2 and appendix B.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <vector>

#include "common/image/image.h"
#include "worker/materials/material.h"

namespace parallax {

// A number for each point: `factor`, times one channel of a picture if there is one.
struct PbrNumber {
  float factor = 1;
  std::optional<ImageRgb8> picture;
  int channel = 0;
};

struct PbrPictures {
  Vec3f color = Vec3f::Ones();      // Linear; times the picture if there is one.
  std::optional<ImageRgb8> albedo;  // sRGB.
  PbrNumber roughness{0.6f, {}, 0}, metallic{0, {}, 0};
  // Tangent space, x along u and y along v, in [0, 255] for [-1, 1].
  std::optional<ImageRgb8> normal;
};

// Where the pictures lie on a surface.
enum class PbrMapping {
  kUv,     // Over uv, repeated: as a mesh's own coordinates say.
  kPlane,  // On the texture plane across the surface, in tiles of kPbrTile_m.
};
inline constexpr float kPbrTile_m = 1;

// Thread-safe. Opaque.
std::unique_ptr<const Material> MakePbrMaterial(const PbrPictures& pictures, PbrMapping mapping);

}  // namespace parallax
