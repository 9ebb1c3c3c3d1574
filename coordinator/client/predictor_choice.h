// Finds the predictor that a user of `evaluate` or `predict` names.
#pragma once

#include <memory>
#include <string>

#include "common/base/status.h"
#include "worker/evaluate/predictors/predictor.h"
#include "worker/evaluate/scores.h"

namespace parallax::client {

struct PredictorChoice {
  std::string what;             // "sgbm", a checkpoint, or a folder of predictions.
  std::string command;          // Instead of `what`: a command with {list}.
  std::string trainer_program;  // Empty: `trainer` beside this program, or $PARALLAX_TRAINER.
  double pair_s = 120;          // Time limit of a pair.
  int threads = 0;              // CPU threads of a checkpoint's network; 0: its program chooses.
};

struct ChosenPredictor {
  std::unique_ptr<Predictor> predictor;
  RunIdentity run;  // Variant and trainer to be shown when the user gives none; no seed.
};

// Errors: kInvalidArgument when neither or both are given; kNotFound for a `what` that is no file
// or folder, and when there is no trainer program for a checkpoint; reading the checkpoint as
// ReadFile.
absl::StatusOr<ChosenPredictor> ChoosePredictor(const PredictorChoice& choice);

}  // namespace parallax::client
