// Makes files of a study's scores: its table, errors by class and material, and learning curves.
#pragma once

#include <set>
#include <string>
#include <vector>

#include "common/base/status.h"
#include "parallax/v1/study.pb.h"
#include "worker/evaluate/scores.h"

namespace parallax::client {

// Writes pictures and CSV files of errors by class and material to `dir`, for each variant and
// trainer over all seeds and benchmarks that have such groups. Returns the paths. Errors: kNotFound
// if no evaluation has such groups; those of writing.
absl::StatusOr<std::vector<std::string>> WriteGroupErrors(
    const std::vector<Evaluation>& evaluations, const std::string& dir);

// Writes `out_dir`/table.txt, table.md and table.json, errors/ and, where checkpoints before the
// last were evaluated, curves/learning_curves.csv and .png. `score_files` are the study's files in
// `out_dir`/scores and /curves (StudyResults::score_files); what else is there counts for nothing.
// Returns the text of table.txt; empty if there are no scores. Errors: those of reading, of
// MakeTable and of writing.
absl::StatusOr<std::string> WriteStudyTable(const std::string& out_dir, const v1::StudySpec& study,
                                            const std::set<std::string>& score_files);

}  // namespace parallax::client
