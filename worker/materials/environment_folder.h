// The user's folder of surroundings: pictures of all directions. Thread-safe.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/base/status.h"

namespace parallax {

struct EnvironmentFolder {
  std::vector<uint64_t> seeds;  // By the contents of the pictures, in order of names; at least one.
  std::string sha256;           // Over their names and contents.
};

// The pictures (.hdr, .exr) in `dir` and the folders below it. This process knows their places from
// now on. Errors: as ReadContentFolder.
absl::StatusOr<EnvironmentFolder> ReadEnvironmentFolder(const std::string& dir);

// Where the picture of this content is. Errors: kNotFound for one of no folder that this process
// has read; kDataLoss when it has changed since.
absl::StatusOr<std::string> FindEnvironment(uint64_t seed);

}  // namespace parallax
