// The user's own pictures as a material: printed over uv in [0, 1]^2, stretched to fill it.
// Thread-safe.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "common/base/status.h"
#include "worker/materials/kernel/material.h"

namespace parallax {

// The class name of this material in recipes. It is not in the catalogue, because it needs a file.
inline constexpr char kUserPicture[] = "UserPicture";

// Sets the folder below which this process may read pictures. Studies name folders below it. They
// may come from people whom the worker's operator does not know, so nothing is read before a root
// is set. "/" allows any folder, for programs that work for the person who started them. Call it
// before other threads run.
void SetPictureRoot(std::string root);

// Sets a second folder, whose content this process itself has put there and names by absolute
// paths. Call it before other threads run.
void SetContentRoot(std::string root);

// Returns the path of a file or folder that a study names: relative to the picture root, links
// resolved; or an absolute one below the content root.
// Errors: kFailedPrecondition without a root, or for a path outside it.
absl::StatusOr<std::string> BelowPictureRoot(const std::string& path);

// Makes the material of the picture in `file`, at most 1024 pixels wide or high; draws gloss and
// grain of the print from `seed`. Errors: kNotFound and kInvalidArgument naming the file;
// kFailedPrecondition outside the picture root.
absl::StatusOr<std::unique_ptr<const Material>> MakeUserPicture(const std::string& file,
                                                                uint64_t seed);

}  // namespace parallax
