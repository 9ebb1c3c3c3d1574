// The container of a .glb (binary glTF 2.0): its header, JSON and binary chunk. Thread-safe.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/status.h"

namespace parallax {

struct GlbChunks {
  nlohmann::json json;    // An object, at most 64 levels deep, no key twice in an object.
  std::string_view body;  // The binary chunk in the file's bytes; empty where none exists.
};

// Takes a file's bytes apart, which must outlive the result. Errors: kInvalidArgument saying what
// is wrong and what is wanted, without the file's name.   Source: Khronos, "glTF 2.0
// specification", chapter 4.
absl::StatusOr<GlbChunks> ReadGlb(std::string_view bytes);

// Returns the names of pictures that lie beside the file, as its JSON has them. Empty for a file
// that is none: CheckGlb says what is wrong with it.
std::vector<std::string> PicturesBesideGlb(const std::string& path);

}  // namespace parallax
