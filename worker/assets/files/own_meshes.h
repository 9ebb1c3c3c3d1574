// The user's own meshes as classes of assets. A class is "own:" plus the name of the meshes'
// folder; a mesh is identified by a seed from its content, so that recipes mean the same meshes
// wherever the folders are. Thread-safe.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/status.h"
#include "worker/assets/asset.h"
#include "worker/assets/files/mesh_file.h"

namespace parallax {

// One mesh of the user's.
struct OwnMesh {
  std::string asset_class;  // "own:chairs"
  uint64_t seed = 0;
  std::string path;
};

// The meshes of all folders.
struct OwnMeshes {
  std::vector<OwnMesh> meshes;  // In order of folders and names; at least one.
  std::string sha256;  // Over the classes, names and contents of all that they are made of.
};

// Finds the meshes (.glb, .obj, .ply) in these folders and the folders below them, and remembers
// their paths in this process, so that MakeAsset finds them. Materials and pictures beside an .obj
// or .ply count for its seed, and the pictures that a .glb names for its. Errors: kNotFound for a
// folder without a mesh; kInvalidArgument for a folder whose name can't be a class's (letters,
// digits, "_" and "-"); those of ReadContentFolder.
absl::StatusOr<OwnMeshes> ReadMeshFolders(const std::vector<std::string>& dirs);

// Whether a class is the user's: begins with "own:".
bool IsOwnClass(std::string_view asset_class);

// Opens the file of a class "own:..."; the most recent files stay open within a sixteenth of the
// process's memory. Errors: kNotFound for a mesh of no folder that this process has read; kDataLoss
// when it has changed since; those of ReadMeshFile.
absl::StatusOr<std::shared_ptr<const MeshFile>> OpenOwnMesh(std::string_view asset_class,
                                                            uint64_t seed);

// The name in recipes of an own mesh's material for a slot: "mesh:0". Its seed is the mesh's.
std::string OwnMeshMaterial(std::string_view slot);
bool IsOwnMeshMaterial(std::string_view material_class);
// Makes the material of such a name. Errors: as OpenOwnMesh; kInvalidArgument for another name.
absl::StatusOr<std::unique_ptr<const Material>> MakeOwnMeshMaterial(std::string_view name,
                                                                    uint64_t seed);

}  // namespace parallax
