// The user's own content in a store: files by their SHA-256, and lists that make folders of them.
//
//   content/<2 hex>/<64 hex>   a file, named by its hash; a list is such a file, too
//
// A study names a folder that is in the store as "store:<hash of its list>/<path>", where <path> is
// the folder below a worker's --picture-root in which the same content may lie. So nobody can put
// other content in the place of a study's. Pure; thread-safe.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/status.h"

namespace parallax {

inline constexpr char kContentFolder[] = "content";
inline constexpr int64_t kMostContentFileBytes = int64_t{1} << 30;
inline constexpr int64_t kMostContentBytes = int64_t{16} << 30;  // In one folder.
inline constexpr size_t kMostContentFiles = 20'000;              // In one folder.
inline constexpr size_t kMostContentListBytes = 8 << 20;

// Returns the path in the store of the file with this hash, which is 64 lower-case hex digits.
std::string ContentPath(std::string_view sha256);
// Returns whether `path` begins with the folder of content. It need not be a valid path of content.
bool IsBelowContent(std::string_view path);

struct ContentFile {
  std::string name;    // Relative to the folder, '/'-separated.
  int64_t size = 0;    // Bytes.
  std::string sha256;  // Lower-case hex.
};

// Returns the text of a list. Files are sorted by name, so that equal folders have equal lists.
std::string ContentListText(std::vector<ContentFile> files);
// Errors: kInvalidArgument, naming the line, for a text that is none, a name that leads out of its
// folder or occurs twice, and more files or bytes than are allowed.
absl::StatusOr<std::vector<ContentFile>> ParseContentList(std::string_view text);
// Checks whether number and sizes of the files are allowed. `folder` is for the message. Errors:
// kInvalidArgument naming the file, what it has and what is allowed.
absl::Status CheckContentSizes(const std::vector<ContentFile>& files, const std::string& folder);

struct ContentReference {
  std::string sha256;  // The list's own hash.
  std::string path;    // As it was before it was in the store.
};

std::string ContentReferenceText(const ContentReference& reference);
// Returns the reference in a text; nothing for a plain path.
std::optional<ContentReference> FindContentReference(std::string_view text);

}  // namespace parallax
