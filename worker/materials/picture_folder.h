// A user's folder of pictures. What it holds counts, not where it lies: pictures are named relative
// to it, and their content is hashed, so that keys of results follow the pictures. Thread-safe.
#pragma once

#include <string>
#include <vector>

#include "common/base/status.h"

namespace parallax {

struct FolderPicture {
  std::string name;    // Relative to the folder: "posters/sea.jpg".
  std::string sha256;  // Hash of the file's bytes; 64 lower-case hex digits.
};

// The pictures in `dir` and the folders below it, sorted by name. A process reads a file again only
// when its size or a time of it has changed.
// Errors: kNotFound when there is no such folder or no picture in it; reading as ReadFile.
absl::StatusOr<std::vector<FolderPicture>> ReadPictureFolder(const std::string& dir);

// SHA-256 over the names and contents of all pictures, as hex: equal wherever the folder lies.
std::string ContentHashOf(const std::vector<FolderPicture>& pictures);

// The path of the picture `name` in `dir`, whose content must be `sha256`.
// Errors: kInvalidArgument for a name that leads out of the folder; kNotFound when the picture is
// not there, kDataLoss when its content is another.
absl::StatusOr<std::string> FindPicture(const std::string& dir, const std::string& name,
                                        const std::string& sha256);

}  // namespace parallax
