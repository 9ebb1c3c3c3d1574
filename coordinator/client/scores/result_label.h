// Makes the labels of trainings and evaluations. Pure functions.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "worker/evaluate/scores.h"

namespace parallax::client {

// The parts of a job's label: "narrow, seed 1 on shipped, checkpoint 2 of 5".
struct ResultName {
  std::string set;  // Training set, or the baseline's name.
  std::optional<int64_t> seed;
  std::string benchmark;  // Empty for a training.
  int checkpoint = 1, checkpoints = 1;
};
// Parses a label. Returns nothing for any other text, or if a part is not a name.
std::optional<ResultName> ParseResultLabel(const std::string& label);

// Gives a run the names that a study has for it: an equal evaluation of another study may have made
// the file. `trainer` is the study's; a baseline keeps its own.
void NameRun(const ResultName& name, const std::string& trainer, RunIdentity& run);

}  // namespace parallax::client
