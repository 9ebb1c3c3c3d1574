// The user's own meshes, texture sets and surroundings, from folders below the picture root.
// Recipes name them by the hash of their content (OwnMesh, TextureSet, Sky.environment).
#pragma once

#include <cstdint>
#include <vector>

#include "common/base/ids.h"
#include "common/base/status.h"
#include "parallax/v1/config.pb.h"
#include "parallax/v1/jobs.pb.h"
#include "worker/assets/files/own_meshes.h"
#include "worker/materials/pictures/texture_sets.h"

namespace parallax {

// The user's content. Seeds are made of the hashes of files.
struct OwnContent {
  std::vector<OwnMesh> meshes;
  std::vector<TextureSet> textures;
  std::vector<uint64_t> environments;
};

// Reads the folders that the config names and keeps their content in this process, where the makers
// of meshes and materials find it. Errors: those of BelowPictureRoot and of reading the folders;
// kDataLoss when a folder's content differs from the config's hash (include_sha256 and so on;
// empty: not compared).
absl::StatusOr<OwnContent> ReadOwnContent(const v1::SceneConfig& config);

// Reads the folders of the content that a render job's recipe uses. Errors: those of
// ReadOwnContent; kInvalidArgument if the recipe uses content and the job names no folder for it,
// or if rigs that share a left eye have keyframes with different surroundings.
absl::Status LocateOwnContent(const v1::RenderJob& job);

// Gives the recipe's sky, or each keyframe's, one of the surroundings with probability
// `config.hdri_p`, turned at random. Keyframes of rigs that share a left eye get the same, drawn by
// the number of the left eye. Changes nothing if none exist.
void ChooseEnvironments(const v1::LightingConfig& config, const OwnContent& own, SceneSeed seed,
                        v1::Scene& recipe);

}  // namespace parallax
