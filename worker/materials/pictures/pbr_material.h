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
#include "worker/materials/pictures/mip_picture.h"

namespace parallax {

// A picture on a surface: its own (u, v) is `turn` * (u, v) + `offset` of the surface's.
struct PbrPicture {
  ImageRgb8 image;
  Eigen::Matrix2f turn = Eigen::Matrix2f::Identity();
  Vec2f offset = Vec2f::Zero();
  MipPicture::Edges edges;
};

// A number at each point: `factor`, times one channel of a picture if there is one.
struct PbrNumber {
  float factor = 1;
  std::optional<PbrPicture> picture;
  int channel = 0;
};

// The pictures of one material.
struct PbrPictures {
  Vec3f color = Vec3f::Ones();       // Linear; multiplies the picture if there is one.
  std::optional<PbrPicture> albedo;  // sRGB.
  PbrNumber roughness{0.6f, {}, 0}, metallic{0, {}, 0};
  // Tangent space, x along u and y along v, in [0, 255] for [-1, 1].
  std::optional<PbrPicture> normal;
  float normal_scale = 1;  // Scales the normal's x and y.
};

// How the pictures are mapped to a surface.
enum class PbrMapping {
  kUv,     // Over uv: by a mesh's own coordinates.
  kPlane,  // On the texture plane across the surface, in tiles of kPbrTile_m.
};
// Side of a tile, metres.
inline constexpr float kPbrTile_m = 1;

// Makes an opaque material. Thread-safe.
std::unique_ptr<const Material> MakePbrMaterial(const PbrPictures& pictures, PbrMapping mapping);

}  // namespace parallax
