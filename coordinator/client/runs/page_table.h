// The table of results of a study for the web page, as `parallax table` and table.txt have it.
#pragma once

#include <cstdint>
#include <string>

#include "common/base/status.h"

namespace parallax {

class JobQueue;
class Store;

// Returns {"text": table.txt, "table": table.json} of the scores that are in `store` now; both null
// while there are none. Reads all score files of the study. Thread-safe. Errors: kNotFound for an
// unknown study; those of the queue, the store, DecodeEvaluation and MakeTable.
absl::StatusOr<std::string> PageTable(JobQueue& queue, const Store& store, int64_t study);

}  // namespace parallax
