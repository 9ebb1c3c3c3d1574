// Materials described by pictures: colour, roughness, metalness and normals, in the
// metallic-roughness model of glTF and most libraries of materials.
//   Source: Khronos, "glTF 2.0 specification", 3.9.2 and appendix B.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <vector>

#include "common/image/image.h"
#include "worker/materials/kernel/material.h"

namespace parallax {

// A number at each point: `factor`, times one channel of a picture if there is one.
struct PbrNumber {
  float factor = 1;
  std::optional<ImageRgb8> picture;
  int channel = 0;
};

// The pictures of one material.
struct PbrPictures {
  Vec3f color = Vec3f::Ones();      // Linear; multiplies the picture if there is one.
  std::optional<ImageRgb8> albedo;  // sRGB.
  PbrNumber roughness{0.6f, {}, 0}, metallic{0, {}, 0};
  // Tangent space, x along u and y along v, in [0, 255] for [-1, 1].
  std::optional<ImageRgb8> normal;
};

// How the pictures are mapped to a surface.
enum class PbrMapping {
  kUv,     // Over uv, repeated: by a mesh's own coordinates.
  kPlane,  // On the texture plane across the surface, in tiles of kPbrTile_m.
};
// Side of a tile, metres.
inline constexpr float kPbrTile_m = 1;

// Makes an opaque material. Thread-safe.
std::unique_ptr<const Material> MakePbrMaterial(const PbrPictures& pictures, PbrMapping mapping);

}  // namespace parallax
