// Checks of a .ply before the importer reads it, which trusts the file's counts and indices. Pure;
// thread-safe.
#pragma once

#include <string_view>

#include "common/base/status.h"

namespace parallax {

// Checks a file's bytes: its header ends within 64 KiB, it has the elements that the header counts,
// faces name vertices that are there, and there are at most kMostTrianglesOfAFile faces and three
// times as many of each other element. Errors: kInvalidArgument saying what is wrong and what is
// wanted, without the file's name.   Source: Greg Turk, "The PLY Polygon File Format".
absl::Status CheckPly(std::string_view bytes);

}  // namespace parallax
