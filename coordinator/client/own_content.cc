#include "coordinator/client/own_content.h"

#include "worker/assets/own_meshes.h"
#include "worker/materials/environment_folder.h"
#include "worker/materials/picture_folder.h"
#include "worker/materials/texture_sets.h"
#include "worker/render/environment.h"

namespace parallax::client {
namespace {

absl::StatusOr<std::string> CheckMeshes(const std::vector<std::string>& dirs) {
  ASSIGN_OR_RETURN(const OwnMeshes meshes, ReadMeshFolders(dirs));
  for (const OwnMesh& mesh : meshes.meshes) {
    const auto file = OpenOwnMesh(mesh.asset_class, mesh.seed);
    if (!file.ok()) return WithContext(file.status(), mesh.path);
  }
  return meshes.sha256;
}

absl::StatusOr<std::string> CheckTextures(const std::string& dir) {
  ASSIGN_OR_RETURN(const TextureFolder folder, ReadTextureFolder(dir));
  for (const TextureSet& set : folder.sets) RETURN_IF_ERROR(CheckTextureSet(set));
  return folder.sha256;
}

absl::StatusOr<std::string> CheckHdris(const std::string& dir) {
  ASSIGN_OR_RETURN(const EnvironmentFolder folder, ReadEnvironmentFolder(dir));
  for (const uint64_t seed : folder.seeds) RETURN_IF_ERROR(OpenEnvironment(seed).status());
  return folder.sha256;
}

absl::StatusOr<std::string> CheckFolders(ContentKind kind, const std::vector<std::string>& dirs) {
  switch (kind) {
    case ContentKind::kMeshes:
      return CheckMeshes(dirs);
    case ContentKind::kTextures:
      return CheckTextures(dirs.front());
    case ContentKind::kHdris:
      return CheckHdris(dirs.front());
    case ContentKind::kPictures:
      break;
  }
  ASSIGN_OR_RETURN(const std::vector<FolderFile> pictures, ReadPictureFolder(dirs.front()));
  return ContentHashOf(pictures);
}

}  // namespace

absl::StatusOr<std::string> ContentHashes::Of(ContentKind kind,
                                              const std::vector<std::string>& dirs) {
  auto [entry, is_new] = known_.try_emplace({kind, dirs});
  if (!is_new) return entry->second;
  absl::StatusOr<std::string> sha256 = CheckFolders(kind, dirs);
  if (sha256.ok()) {
    entry->second = *sha256;
  } else {
    known_.erase(entry);
  }
  return sha256;
}

}  // namespace parallax::client
