// The user's own meshes as classes of assets. A class is "own:" and the name of the folder that its
// meshes lie in; a mesh of it is named by a seed that its content gives. So recipes mean the same
// meshes wherever the folders lie. Thread-safe.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/status.h"
#include "worker/assets/asset.h"
#include "worker/assets/mesh_file.h"

namespace parallax {

struct OwnMesh {
  std::string asset_class;  // "own:chairs"
  uint64_t seed = 0;
  std::string path;
};

struct OwnMeshes {
  std::vector<OwnMesh> meshes;  // In order of folders and names; at least one.
  std::string sha256;           // Over the names and contents of all that they are made of.
};

// The meshes (.glb, .obj, .ply) in these folders and the folders below them. This process knows
// their places from now on, so that MakeAsset finds them. Materials and pictures beside an .obj
// count for its seed. Errors: kNotFound for a folder without a mesh; kInvalidArgument for a folder
// whose name is no class's (letters, digits, "_" and "-"); those of ReadContentFolder.
absl::StatusOr<OwnMeshes> ReadMeshFolders(const std::vector<std::string>& dirs);

bool IsOwnClass(std::string_view asset_class);

// The file of a class "own:...", kept while it is among the last that were asked for.
// Errors: kNotFound for a mesh of no folder that this process has read; kDataLoss for one that has
// changed since; those of ReadMeshFile.
absl::StatusOr<std::shared_ptr<const MeshFile>> OpenOwnMesh(std::string_view asset_class,
                                                            uint64_t seed);

// The name in recipes of the material that an own mesh brings along for a slot: "mesh:0". Its seed
// is the mesh's.
std::string OwnMeshMaterial(std::string_view slot);
bool IsOwnMeshMaterial(std::string_view material_class);
// Makes the material of such a name. Errors: as OpenOwnMesh; kInvalidArgument for another name.
absl::StatusOr<std::unique_ptr<const Material>> MakeOwnMeshMaterial(std::string_view name,
                                                                    uint64_t seed);

}  // namespace parallax
