// Checks of a .glb (binary glTF 2.0) before the importer reads it, which trusts the file's counts,
// ranges and indices. Thread-safe.
#pragma once

#include <string_view>

#include "common/base/status.h"

namespace parallax {

// Checks a file's bytes: its one buffer lies in it, views lie in the buffer and accessors in their
// views, indices name corners that are there, nodes form trees, and there are at most
// kMostTrianglesOfAFile triangles and three times as many corners. Errors: kInvalidArgument saying
// what is wrong and what is wanted, without the file's name.   Source: Khronos, "glTF 2.0
// specification", chapters 3 and 4.
absl::Status CheckGlb(std::string_view bytes);

}  // namespace parallax
