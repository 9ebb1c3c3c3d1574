#include "worker/scene/scene_pictures.h"

#include "worker/materials/pictures/picture_folder.h"
#include "worker/materials/pictures/user_picture.h"

namespace parallax {

absl::Status LocatePictures(const std::string& dir, v1::Scene& recipe) {
  for (v1::SceneMaterial& material : *recipe.mutable_materials()) {
    if (material.picture_sha256().empty()) continue;
    if (dir.empty()) {
      return InvalidArgument(
          "the scene shows the picture {}, and nobody says in which folder it is",
          material.picture_file());
    }
    ASSIGN_OR_RETURN(const std::string folder, BelowPictureRoot(dir));
    ASSIGN_OR_RETURN(*material.mutable_picture_file(),
                     FindPicture(folder, material.picture_file(), material.picture_sha256()));
  }
  return absl::OkStatus();
}

}  // namespace parallax
