// A user's folder of pictures, or of other content. Only its content matters, not its path: files
// are named relative to it, and their content is hashed, so that keys of results depend on it.
// Thread-safe.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/status.h"

namespace parallax {

// A file of the folder.
struct FolderFile {
  std::string name;    // Relative to the folder: "posters/sea.jpg".
  std::string sha256;  // Hash of the file's bytes; 64 lower-case hex digits.
};

// The files of a folder by their names relative to it, sorted.
struct ContentNames {
  std::vector<std::string> files;
  // Other files and folders (with "/" at their ends): other endings, hidden ones, and the twins of
  // files that systems make ("._a.png", "__MACOSX").
  std::vector<std::string> left_out;
};

// Allows links in folders of content to lead out of them. False at first. Call it before other
// threads run.
void SetFollowLinks(bool follows);
bool FollowsLinks();

// Whether walks leave out a file or folder of this name: hidden ones, and the twins that systems
// make.
bool IsForeignName(const std::string& name);

// Walks `dir`, which has no files if it is no folder, and the folders below it for files whose
// names end in one of `endings` (".png"; ignoring case). Links are followed. All content is found
// by this function. Errors: kInvalidArgument for a link that leads nowhere, to a folder that it
// lies in, or out of `dir` (see SetFollowLinks); those of reading folders.
absl::StatusOr<ContentNames> NamesOfContent(const std::string& dir,
                                            std::span<const std::string_view> endings);

// Returns the pictures in `dir` and the folders below it, sorted by name. A process reads a file
// again only when its size or one of its times has changed. Errors: kNotFound when there is no such
// folder or no picture in it; those of NamesOfContent and of ReadFile.
absl::StatusOr<std::vector<FolderFile>> ReadPictureFolder(const std::string& dir);

// Returns the files of NamesOfContent, like ReadPictureFolder. Errors: the same.
absl::StatusOr<std::vector<FolderFile>> ReadContentFolder(
    const std::string& dir, std::span<const std::string_view> endings);

// Returns the first 8 bytes of a hex SHA-256, big-endian: the seed by which recipes name user
// content.
uint64_t ContentSeed(std::string_view sha256);

// Returns the hex SHA-256 over the names and contents of all pictures: independent of the folder's
// path.
std::string ContentHashOf(const std::vector<FolderFile>& pictures);

// Returns the path of the picture `name` in `dir`, whose content must have the hash `sha256`.
// Errors: kInvalidArgument for a name that leads out of the folder; kNotFound when the picture is
// not there; kDataLoss when its content differs.
absl::StatusOr<std::string> FindPicture(const std::string& dir, const std::string& name,
                                        const std::string& sha256);

}  // namespace parallax
