// A trained network of the store, ready to predict by its trainer's command.
#pragma once

#include <memory>
#include <string>

#include "common/base/cancel.h"
#include "common/base/status.h"
#include "common/store/store.h"
#include "parallax/v1/train.pb.h"
#include "worker/evaluate/predictors/predictor.h"
#include "worker/train/contract/installed_trainers.h"

namespace parallax {

struct StoredNetwork {
  std::string trainer;
  std::string path;    // In the store.
  v1::FileEntry file;  // Its size and hash.
  int looks = 0;       // Looks at a pair; 0: as many as the network takes.
};

// Copies the network's file into `dir`, which exists, and returns a predictor that uses `threads`
// threads and keeps its own files in `dir`. Its command runs in the trainer's `directory`, by
// default in `dir`.
//
// Errors: kDataLoss for a file whose hash differs from the trained network's; kUnimplemented when
// the trainer can't be told the number of looks; those of
// InstalledTrainers::Find, CommandToRun and the store.
absl::StatusOr<std::unique_ptr<Predictor>> OpenStoredNetwork(const StoredNetwork& network,
                                                             const InstalledTrainers& trainers,
                                                             const Store& store,
                                                             const std::string& dir, int threads);

}  // namespace parallax
