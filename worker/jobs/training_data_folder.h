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
#include "worker/jobs/frame_cache.h"
#include "worker/train/contract.h"

namespace parallax {

struct TrainingDataOptions {
  const Store* store = nullptr;
  FrameCacheOptions cache;
  std::string dir;  // Must not exist.
  CancelToken cancel;
  std::function<void(double fraction)> progress = [](double) {};
  // Of curated sets: the network that scores the frames. `predictor` outlives the call.
  CurationNetwork curator = {};
};

struct TrainingDataFolder {
  // Folder and weight, as in CommandValues.
  std::vector<std::pair<std::string, std::string>> parts;
  int64_t pairs = 0;
  nlohmann::ordered_json facts;  // The manifest, also in `dir`/manifest.json.
};

// A folder for each part in the layout "archive"; one for all in others, in which parts stand as
// often as their weights ask for, as far as whole repetitions can do that. Frames of a curated job
// that `curator` misses are left out.
// Errors: kInvalidArgument for a curated job without `curator`; those of BringFrames, ScoreFrames
// and ExportDataset.
absl::StatusOr<TrainingDataFolder> MakeTrainingData(const v1::TrainJob& job,
                                                    const TrainerContract& contract,
                                                    const TrainingDataOptions& options);

// How often each part stands in a folder that is read evenly, so that pairs of each are drawn in
// proportion to `weights`: at least once, at most 20 times. `pairs` > 0.
std::vector<int> Repetitions(const std::vector<int64_t>& pairs, const std::vector<double>& weights);

}  // namespace parallax
