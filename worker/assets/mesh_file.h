// Meshes of the user's from files: .glb, .obj and .ply.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/base/status.h"
#include "worker/assets/asset.h"
#include "worker/materials/pbr_material.h"

namespace parallax {

inline constexpr int64_t kMostTrianglesOfAFile = 2'000'000;

struct MeshFile {
  // In the asset frame: upright, above the floor, its footprint's middle at the origin; in the
  // file's own unit. One slot ("0", "1"...) for each material that faces have. A mesh that is not
  // closed is one of sheets.
  Mesh mesh;
  // The material of each slot as the file describes it; nullopt where it describes none.
  std::vector<std::optional<PbrPictures>> materials;
};

// Reads and checks a file. glTF and OBJ are taken to have y up and to face +z (glTF's rule), PLY to
// have z up and to face -y; parts are put together as the file says, faces of more corners are
// split, normals that are missing are made. Animations, cameras, lights and vertex colours are
// passed over. Pictures may be inside of the file or beside it, not outside of its folder. Errors:
// kInvalidArgument naming the file, what is wrong and what is wanted: not readable, no triangle,
// more than kMostTrianglesOfAFile, corners that are not finite, no extent, a picture that is
// missing or outside; kNotFound, as ReadFile.
absl::StatusOr<MeshFile> ReadMeshFile(const std::string& path);

}  // namespace parallax
