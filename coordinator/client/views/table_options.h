// The table of a study's scores: its rows, their order and what they are compared with. Pure
// functions.
#pragma once

#include <vector>

#include "common/base/status.h"
#include "parallax/v1/study.pb.h"
#include "worker/evaluate/score_table.h"

namespace parallax::client {

// Returns options for rows in the order of the study's training sets, compared with its reference,
// whose means weigh pairs, and whose verdicts are made, as the study says.
TableOptions TableOptionsOf(const v1::StudySpec& study);

// Makes the study's table of these scores, one or more; without a reference while that has none.
// Errors: those of MakeTable.
absl::StatusOr<ResultTable> MakeStudyTable(const v1::StudySpec& study,
                                           const std::vector<Evaluation>& scores);

}  // namespace parallax::client
