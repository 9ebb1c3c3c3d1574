// Removes folders of attempts from the store that the database does not know. There are some after
// a restored backup, which lacks the attempts of the lost time, and where a worker wrote after its
// attempt's folder was removed.
#pragma once

#include <functional>

#include "common/base/status.h"
#include "common/store/store.h"
#include "coordinator/queue/job_queue.h"

namespace parallax {

// Removes unknown folders in which nothing has changed for `older_than_s` seconds before
// `now_unix_s`. Does nothing in a store that is not this database's. Stops early when `stopping`
// says so. Returns the number of removed folders. Errors: those of the queue and of the store.
absl::StatusOr<int> RemoveUnknownFolders(JobQueue& queue, Store& store, double older_than_s,
                                         double now_unix_s, const std::function<bool()>& stopping);

}  // namespace parallax
