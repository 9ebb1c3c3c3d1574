// Finds the predictor that the user of `evaluate` or `predict` names.
#pragma once

#include <memory>
#include <string>

#include "common/base/status.h"
#include "worker/evaluate/predictors/predictor.h"
#include "worker/evaluate/scores.h"

namespace parallax::client {

struct PredictorChoice {
  // "sgbm", "network" (the trained one that comes with Parallax), a checkpoint, or a folder of
  // predictions.
  std::string what;
  std::string command;          // In place of `what`: a command line with {list}.
  std::string trainer_program;  // Empty: $PARALLAX_TRAINER, or `trainer` beside this program.
  double pair_s = 120;          // Time limit for each pair, in seconds.
  int threads = 0;              // CPU threads of a checkpoint's network; 0: its program chooses.
  int looks = 0;                // Looks of a checkpoint's network at a pair; 0: its own number.
};

struct ChosenPredictor {
  std::unique_ptr<Predictor> predictor;
  // Variant, trainer and seed to show if the user names none. A checkpoint has the seed of the card
  // beside it (training.json, train.json), else 0; what is not trained here has none.
  RunIdentity run;
};

// The name of the trained network that comes with Parallax.
inline constexpr char kShippedNetwork[] = "network";

// Makes the predictor of the choice. Errors: kInvalidArgument if neither or both of `what` and
// `command` are given, and for looks of what is no checkpoint; those of FindNetwork; kNotFound if
// `what` is not a file or folder, or a checkpoint has no trainer program; those of ReadFile for the
// checkpoint.
absl::StatusOr<ChosenPredictor> ChoosePredictor(const PredictorChoice& choice);

}  // namespace parallax::client
