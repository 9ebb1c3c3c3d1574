// Triangle meshes as plain data: assets make them, everything else reads them.
//
// Invariants (ValidateMesh checks them): all per-vertex arrays have one length; indices are in
// range; normals are unit length; no NaN. Triangles are counter-clockwise seen from outside.
// Surfaces are closed, but for those of slots marked as sheets; no two triangles of sheets have the
// same corners.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/base/status.h"
#include "common/math/types.h"

namespace parallax {

// Indices of three vertices, counter-clockwise from outside.
struct Triangle {
  uint32_t a = 0, b = 0, c = 0;
  uint16_t slot = 0;  // Index into Mesh::slots.
};

// A named part of an object that gets one material, with the families that suit it in order of
// preference ("wood", "fabric", "metal"...: worker/materials). `picture` slots show a printed
// picture over uv in [0, 1]^2.
struct MaterialSlot {
  std::string name;
  std::vector<std::string> families;
  bool emissive = false;  // A lamp's bulb or shade lining: a mesh light of the fixture.
  // The part consists of open surfaces without thickness that are seen from both sides (leaves,
  // petals, blades of grass). They enclose nothing.
  bool sheet = false;
};

// Vertices, triangles and material slots.
struct Mesh {
  std::vector<Vec3f> positions;  // Metres, object frame.
  std::vector<Vec3f> normals;    // Unit shading normals, object frame.
  // Metres: where solid materials are evaluated; x runs along the part's grain.
  std::vector<Vec3f> texture;
  // Coordinates of printed pictures. On sheets of plants, two random numbers in [0, 1] for each
  // leaf, constant over it. Elsewhere 0.
  std::vector<Vec2f> uv;
  std::vector<Triangle> triangles;
  std::vector<MaterialSlot> slots;

  Box3f Bounds() const;
};

// Checks the invariants above. Errors: kInvalidArgument naming the first broken one.
absl::Status ValidateMesh(const Mesh& mesh);

// Appends `part`, transformed by `mesh_from_part` (a rotation and translation, so that normals stay
// unit), to `mesh`; joins slots by name. Texture coordinates are copied unchanged.
void Append(Mesh& mesh, const Mesh& part,
            const Eigen::Affine3f& mesh_from_part = Eigen::Affine3f::Identity());

}  // namespace parallax
