// Sends a finished attempt's folder to a store that this machine does not see as a folder.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "common/base/cancel.h"
#include "common/base/status.h"
#include "common/base/system/clock.h"
#include "common/store/store.h"
#include "worker/agent/attempts/job_handler.h"

namespace parallax {

// Puts the files, named relative to `dir`, under the same names below `path` in the store. Retries
// a store that can't be reached, is full or busy until `cancel`, because finished work must survive
// a restart of the coordinator. Files that have arrived are not sent again. Errors: kCancelled; any
// other error of the store ends it.
absl::Status UploadFiles(Store& store, const std::string& dir, const std::string& path,
                         const std::vector<OutputFile>& files, const CancelToken& cancel);

}  // namespace parallax
