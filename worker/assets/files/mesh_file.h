// The user's meshes from files: .glb, .obj and .ply.
#pragma once

#include <string>
#include <vector>

#include "common/base/status.h"
#include "worker/assets/asset.h"
#include "worker/assets/files/mesh_parts.h"

namespace parallax {

// The content of a mesh file.
struct MeshFile {
  // In the asset frame: upright, above the floor, the footprint's middle at the origin; in the
  // file's own unit. One slot ("0", "1"...) for each material of the faces. A mesh that is not
  // closed consists of sheets.
  Mesh mesh;
  std::vector<FileMaterial> materials;  // One for each slot, as the file describes it.
  std::vector<std::string> left_out;    // Parts of the file that are not used, and why.
};

// Reads and checks a file. glTF and OBJ count as y up and facing +z (glTF's rule), PLY as z up and
// facing -y. Parts are assembled as the file says, larger faces are split into triangles, missing
// normals are computed: flat for glTF (its rule), smooth up to edges of 40 degrees for OBJ and PLY.
// `left_out` lists the parts that are not used. Pictures may be in the file or beside it, not
// outside of its folder. Errors: kInvalidArgument naming the file, the fault and the expectation:
// those of ReadGlb, ReadObj and ReadPly, no triangle, more than kMostTrianglesOfAFile, corners that
// are not finite, no extent; kNotFound, as ReadFile.
absl::StatusOr<MeshFile> ReadMeshFile(const std::string& path);

}  // namespace parallax
