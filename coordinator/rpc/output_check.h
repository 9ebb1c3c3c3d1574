// Whether the files that a result names are in the store.
#pragma once

#include <string>
#include <vector>

#include "common/base/status.h"
#include "common/store/store.h"
#include "coordinator/queue/job_kind.h"

namespace parallax {

// Empty when all `files` are in the store with the size that they state, else the first that isn't:
// "ab/ab12.../.attempt-7/003/left.png: has 10 bytes, not 100". Lists each attempt's folder once,
// which an object store answers in one request for a thousand files. Files that are in no attempt's
// folder are left to the queue's own check. Errors: those of Store::List, when the store can't be
// asked.
absl::StatusOr<std::string> WhyNotInStore(const Store& store,
                                          const std::vector<JobKind::OutputFile>& files);

}  // namespace parallax
