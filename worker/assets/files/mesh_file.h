// The user's meshes from files: .glb, .obj and .ply.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/base/status.h"
#include "worker/assets/asset.h"
#include "worker/materials/pictures/pbr_material.h"

namespace parallax {

inline constexpr int64_t kMostTrianglesOfAFile = 2'000'000;

// The content of a mesh file.
struct MeshFile {
  // In the asset frame: upright, above the floor, the footprint's middle at the origin; in the
  // file's own unit. One slot ("0", "1"...) for each material of the faces. A mesh that is not
  // closed consists of sheets.
  Mesh mesh;
  // The material of each slot as the file describes it; nullopt where it describes none.
  std::vector<std::optional<PbrPictures>> materials;
};

// Reads and checks a file. glTF and OBJ count as y up and facing +z (glTF's rule), PLY as z up and
// facing -y. Parts are assembled as the file says, larger faces are split into triangles, missing
// normals are computed. Animations, cameras, lights and vertex colours are ignored. Pictures may be
// in the file or beside it, not outside of its folder. Errors: kInvalidArgument naming the file,
// the fault and the expectation: those of CheckGlb and CheckPly, not readable, no triangle, more
// than kMostTrianglesOfAFile, corners that are not finite, no extent, a picture that is missing,
// outside or not named .png, .jpg or .jpeg; kNotFound, as ReadFile.
absl::StatusOr<MeshFile> ReadMeshFile(const std::string& path);

}  // namespace parallax
