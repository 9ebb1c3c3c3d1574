// Brings a finished attempt's folder into a store that this machine does not see as a folder.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "common/base/cancel.h"
#include "common/base/clock.h"
#include "common/base/status.h"
#include "common/store/store.h"
#include "worker/agent/job_handler.h"

namespace parallax {

// Puts the files, whose names are below `dir`, to the same names below `path` in the store. A store
// that can't be reached, is full or busy is tried again until `cancel`: the work is done and must
// not be lost for a restart of the coordinator. Any other error ends it. What had arrived is not
// sent again.
absl::Status UploadFiles(Store& store, const std::string& dir, const std::string& path,
                         const std::vector<OutputFile>& files, const CancelToken& cancel);

}  // namespace parallax
