// Truth of what is behind glass and water: a frame's maps with its last layer in place of the
// first. Trainers and benchmarks read them as they read any frame's.
#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "common/base/status.h"

namespace parallax {

// Returns the files, beside those that it makes anew, that MakeBehindTruth may read.
std::vector<std::string> FilesForBehindTruth();

// Returns the bytes of disparity, occlusion, masks, objects and materials of both eyes, by file
// name. A pixel's truth is that of its last layer. It has none (disparity 0, mask kMaskSky) where
// that is see-through itself, because nothing is behind it, or has more layers behind it. Occlusion
// is that of the layers: by re-projection, as of first surfaces. `path_of` returns the path of one
// of the frame's files, empty if the frame has no such file.
// Errors: kFailedPrecondition for a frame without layers; kDataLoss for maps of different sizes or
// a frame.json that lacks something; as Read*.
absl::StatusOr<std::map<std::string, std::string>> MakeBehindTruth(
    const std::function<std::string(const std::string&)>& path_of);

}  // namespace parallax
