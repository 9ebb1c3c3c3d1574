// Checks the user's own folders (pictures, textures, skies, meshes) and hashes their content.
#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "common/base/status.h"

namespace parallax::client {

enum class ContentKind { kPictures, kTextures, kHdris, kMeshes };

// Computes hashes of folders and remembers them: variants of a study mostly name the same folders.
// Not thread-safe.
class ContentHashes {
 public:
  // Returns the hash for the config's field of this kind. Only meshes may have several folders.
  // Every file is opened, so that a bad one is found before any work is done. Errors: kNotFound for
  // a folder without such files; kInvalidArgument that names the bad file, what is wrong with it
  // and what is wanted.
  absl::StatusOr<std::string> Of(ContentKind kind, const std::vector<std::string>& dirs);

 private:
  std::map<std::pair<ContentKind, std::vector<std::string>>, std::string> known_;
};

}  // namespace parallax::client
