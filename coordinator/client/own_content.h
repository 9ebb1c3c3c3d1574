// Folders of the user's as they are seen from this machine: checked, and hashed by their content.
#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "common/base/status.h"

namespace parallax::client {

enum class ContentKind { kPictures, kTextures, kHdris, kMeshes };

// Remembers what it has seen: the variants of a study mostly name the same folders.
class ContentHashes {
 public:
  // The hash that the config's field of this kind takes. Only meshes may be of several folders.
  // Every file is opened, so that a bad one is found before anything is made of it. Errors:
  // kNotFound for a folder without any; kInvalidArgument naming the file that is bad, what is wrong
  // with it and what is wanted.
  absl::StatusOr<std::string> Of(ContentKind kind, const std::vector<std::string>& dirs);

 private:
  std::map<std::pair<ContentKind, std::vector<std::string>>, std::string> known_;
};

}  // namespace parallax::client
