// The scores of a study in the store, and their table for the web page, as `parallax table` and
// table.txt have it.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/base/status.h"
#include "parallax/v1/service.pb.h"
#include "worker/evaluate/scores.h"

namespace parallax {

class JobQueue;
class Store;

// Returns the scores of the study's last checkpoints and baselines that are in `store` now, under
// the names that the study gives them. Thread-safe. Errors: those of the queue, the store and
// DecodeEvaluation.
absl::StatusOr<std::vector<Evaluation>> StudyScores(JobQueue& queue, const Store& store,
                                                    const v1::StudyStatus& study);

// Returns {"text": table.txt, "table": table.json} of the scores that are in `store` now; both null
// while there are none. Reads all score files of the study. Thread-safe. Errors: kNotFound for an
// unknown study; those of the queue, the store, DecodeEvaluation and MakeTable.
absl::StatusOr<std::string> PageTable(JobQueue& queue, const Store& store, int64_t study);

}  // namespace parallax
