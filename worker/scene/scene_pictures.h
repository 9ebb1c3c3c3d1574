// The user's pictures in a recipe, which names them relative to their folder.
#pragma once

#include <string>

#include "common/base/status.h"
#include "parallax/v1/scene.pb.h"

namespace parallax {

// Sets each SceneMaterial.picture_file to its path in the folder `dir` of the picture root, so that
// BuildSceneGeometry finds it.
// Recipes that say no content of their pictures hold paths already and are left as they are.
// Errors: those of BelowPictureRoot and FindPicture; kInvalidArgument when the recipe has pictures
// and `dir` is empty.
absl::Status LocatePictures(const std::string& dir, v1::Scene& recipe);

}  // namespace parallax
