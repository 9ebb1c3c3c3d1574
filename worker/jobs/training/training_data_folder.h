// The training data of a job, in the layout that its trainer reads.
#pragma once

#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "common/base/cancel.h"
#include "common/base/status.h"
#include "common/store/store.h"
#include "parallax/v1/train.pb.h"
#include "worker/evaluate/curate.h"
#include "worker/jobs/files/frame_cache.h"
#include "worker/train/contract/contract.h"

namespace parallax {

// The source and destination of the data.
struct TrainingDataOptions {
  const Store* store = nullptr;
  FrameCacheOptions cache;
  std::string dir;  // Must not exist.
  CancelToken cancel;
  std::function<void(double fraction)> progress = [](double) {};
  // For curated sets: the network that scores the frames. `predictor` outlives the call.
  CurationNetwork curator = {};
};

// The folders made, and a summary.
struct TrainingDataFolder {
  // Folder and weight, as in CommandValues.
  std::vector<std::pair<std::string, std::string>> parts;
  int64_t pairs = 0;
  nlohmann::ordered_json facts;  // The manifest, also in `dir`/manifest.json.
};

// Makes the training data: in the layout "archive" one folder for each part; in other layouts one
// folder for all, in which parts are repeated according to their weights, as far as whole
// repetitions can do that. Leaves out frames of a curated job that `curator` misses.
// Errors: kInvalidArgument for a curated job without `curator`; those of BringFrames, ScoreFrames
// and ExportDataset.
absl::StatusOr<TrainingDataFolder> MakeTrainingData(const v1::TrainJob& job,
                                                    const TrainerContract& contract,
                                                    const TrainingDataOptions& options);

// Returns how often each part is repeated in a folder that a trainer reads evenly, so that the
// parts' shares of the drawn pairs are about `weights`: at least once, at most 20 times. `pairs` >
// 0.
std::vector<int> Repetitions(const std::vector<int64_t>& pairs, const std::vector<double>& weights);

}  // namespace parallax
