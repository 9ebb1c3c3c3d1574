// The user's pictures in a recipe, which names them relative to their folder.
#pragma once

#include <string>

#include "common/base/status.h"
#include "parallax/v1/scene.pb.h"

namespace parallax {

// Replaces each SceneMaterial.picture_file by its path in the folder `dir` of the picture root, so
// that BuildSceneGeometry finds it. Recipes without hashes of their pictures hold paths already and
// stay as they are. Errors: those of BelowPictureRoot and FindPicture; kInvalidArgument when the
// recipe has pictures and `dir` is empty.
absl::Status LocatePictures(const std::string& dir, v1::Scene& recipe);

}  // namespace parallax
