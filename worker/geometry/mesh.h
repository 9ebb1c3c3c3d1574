// Triangle meshes as plain data: what assets make and everything else reads.
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

struct Triangle {
  uint32_t a = 0, b = 0, c = 0;
  uint16_t slot = 0;  // Index into Mesh::slots.
};

// A named part of an object that gets one material, with the families that suit it in order of
// preference
// ("wood", "fabric", "metal"...: worker/materials). `picture` slots show a printed picture over uv
// in [0, 1]^2.
struct MaterialSlot {
  std::string name;
  std::vector<std::string> families;
  bool emissive = false;  // A lamp's bulb or shade lining: a mesh light of the fixture.
  // Open surfaces without thickness that are seen from both sides (leaves, petals, blades of
  // grass): nothing is inside of them.
  bool sheet = false;
};

struct Mesh {
  std::vector<Vec3f> positions;  // Metres, object frame.
  std::vector<Vec3f> normals;    // Unit shading normals, object frame.
  std::vector<Vec3f>
      texture;  // Metres: where solid materials are evaluated; x runs along the part's grain.
  // Printed pictures; on sheets of plants (how this leaf differs from others, in [0, 1]; a second
  // random number), constant over a leaf. Else 0.
  std::vector<Vec2f> uv;
  std::vector<Triangle> triangles;
  std::vector<MaterialSlot> slots;

  Box3f Bounds() const;
};

// kInvalidArgument naming the first broken invariant.
absl::Status ValidateMesh(const Mesh& mesh);

// Appends `part` (transformed by `mesh_from_part`, rotation and translation only for normals to
// stay unit) to `mesh`; slots are joined by name. Texture coordinates are copied unchanged.
void Append(Mesh& mesh, const Mesh& part,
            const Eigen::Affine3f& mesh_from_part = Eigen::Affine3f::Identity());

}  // namespace parallax
