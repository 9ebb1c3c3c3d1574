// The user's folder of environment maps: pictures of all directions. Thread-safe.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/base/status.h"

namespace parallax {

// The content of such a folder.
struct EnvironmentFolder {
  std::vector<std::string> names;  // Sorted; at least one.
  std::vector<uint64_t> seeds;     // By the contents of the pictures, in order of names.
  std::string sha256;              // Over their names and contents.
};

// Reads the pictures (.hdr, .exr) in `dir` and the folders below it, and remembers their paths in
// this process. Errors: as ReadContentFolder.
absl::StatusOr<EnvironmentFolder> ReadEnvironmentFolder(const std::string& dir);

// Returns the path of the picture with this content. Errors: kNotFound unless this process has read
// a folder with it; kDataLoss when the file has changed since.
absl::StatusOr<std::string> FindEnvironment(uint64_t seed);

}  // namespace parallax
