// Pairs of a stream as members of a tar file, in the layout `webdataset` of exports.
#pragma once

#include <string>

#include "common/base/status.h"
#include "parallax/v1/stream.pb.h"

namespace parallax {

// Returns the members of a pair whose files are in `folder`. Their names begin with
// "<chunk>_<variant>_<scene>_<rig>". Errors: kDataLoss for maps or a frame.json that do not fit; as
// ReadFile.
absl::StatusOr<std::string> StreamSample(const v1::StreamedPair& pair, const std::string& folder);
// Returns the end of a tar file.
std::string StreamEnd();

}  // namespace parallax
