// Smooth free-form deformation of objects, for SceneObject.warp_seed and .warp.
#pragma once

#include <cstdint>

#include "common/base/status.h"
#include "parallax/v1/scene.pb.h"
#include "worker/geometry/mesh.h"

namespace parallax {

// Displaces every vertex by a smooth field of a few long waves, a twist and a taper, by at most
// `amount` of the mesh's longest side (in [0, 0.5]), and turns the normals with it. Texture
// coordinates stay: the material bends along. The field is too small for surfaces to fold over.
// Equal arguments give equal bytes.
void WarpMesh(uint64_t seed, double amount, Mesh& mesh);

// Makes the mesh of a recipe's object that is not a part of a room, warp included. Errors:
// kNotFound for an unknown class.
absl::StatusOr<Mesh> MakeObjectMesh(const v1::SceneObject& object);

}  // namespace parallax
