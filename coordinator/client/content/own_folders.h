// Checks the user's own folders (pictures, textures, skies, meshes) and hashes their content.
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/base/status.h"

namespace parallax::client {

// Adds --follow-links to a command that reads own folders.
void AddFollowLinksOption(CLI::App& command);

enum class ContentKind { kPictures, kTextures, kHdris, kMeshes };

// One picture, texture set, sky or mesh as it was understood.
struct ContentItem {
  std::string name;                   // Its file, relative to the folder, or the name of the set.
  std::string text;                   // "12 triangles, 1 x 0.6 x 0.6, paint (colour tex.png)"
  std::vector<std::string> left_out;  // Parts of the file that are not used, and why.
  int64_t memory_bytes = 0;           // Asked for while it is read; 0 for small items.
};

// All that folders of one kind hold.
struct ContentReport {
  std::string sha256;  // For the config's field of this kind.
  std::vector<ContentItem> items;
  std::vector<std::string> left_out;  // Files and folders that are no content of this kind.
  std::vector<std::string> classes;   // Classes of meshes, each once: "own:chairs".
};

// Opens every file in the folders. Only meshes may have several. Errors: kNotFound for a folder
// without such files; kInvalidArgument that names the bad file, what is wrong with it and what is
// wanted.
absl::StatusOr<ContentReport> CheckContent(ContentKind kind, const std::vector<std::string>& dirs);

// Reads folders and remembers what they hold: variants of a study mostly name the same folders.
// Not thread-safe.
class ContentReports {
 public:
  // Returns what the folders hold; it lives as long as this object. Every file is opened, so that a
  // bad one is found before any work is done. Errors: those of CheckContent.
  absl::StatusOr<const ContentReport*> Of(ContentKind kind, const std::vector<std::string>& dirs);

  // The item, among all that Of has read, that takes most memory; nothing before any was read.
  const std::optional<ContentItem>& largest() const { return largest_; }

 private:
  std::map<std::pair<ContentKind, std::vector<std::string>>, ContentReport> known_;
  std::optional<ContentItem> largest_;
};

}  // namespace parallax::client
