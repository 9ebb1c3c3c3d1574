// How a trainer's networks predict: a command, or a file in an exchange format that the program
// `trainer` runs.
#pragma once

#include <string>
#include <vector>

#include "worker/train/contract/contract_reader.h"

namespace parallax {

// Returns the command of the trainer's field `predict`. Errors stand in `reader`.
std::vector<std::string> ReadPredictCommand(ContractReader& reader, const YAML::Node& root);

}  // namespace parallax
