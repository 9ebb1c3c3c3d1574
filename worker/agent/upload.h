// Brings a finished attempt's folder into a store that this machine does not see as a folder.
#pragma once

#include <memory>
#include <string>

#include "common/base/cancel.h"
#include "common/base/clock.h"
#include "common/base/status.h"
#include "common/store/store.h"
#include "parallax/v1/jobs.pb.h"

namespace parallax {

// Puts the files that `result` names, from below `dir` (the local folder of `path`). A store that
// can't be reached, is full or busy is tried again until `cancel`: the work is done and must not be
// lost for a restart of the coordinator. Any other error ends it. What had arrived is not sent
// again.
absl::Status UploadFrames(Store& store, const std::string& dir, const std::string& path,
                          const v1::RenderResult& result, const CancelToken& cancel);

}  // namespace parallax
