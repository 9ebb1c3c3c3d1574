// Curation: finds frames of a dataset that trained networks can't match. FoundationStereo's authors
// discard pairs on which a network, trained on the set itself, misses by more than 2 px on most
// pixels.
// Source: Wen et al., FoundationStereo, CVPR 2025 (BP-2 above 60 %).
#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "common/base/cancel.h"
#include "common/base/status.h"
#include "common/base/system/clock.h"
#include "worker/dataset/archive/archive_index.h"
#include "worker/dataset/archive/curation_log.h"
#include "worker/evaluate/predictors/predictor.h"

namespace parallax {

// A trained network as a judge.
struct CurationNetwork {
  std::string id;  // SHA-256 of the checkpoint.
  Predictor* predictor = nullptr;
};

struct CurateOptions {
  std::string work_dir;  // Exists; a few predictions at a time lie there.
  CancelToken cancel;
  Clock* clock = &Clock::System();
  // Counts of frames that `network` has scored, and has to score.
  std::function<void(int64_t done, int64_t total)> progress = [](int64_t, int64_t) {};
};

// Scores the variant's frames that the log lacks for `network`, and adds them to it. Counts left
// pixels with truth, except sky and the exterior of rooms; a pixel without a valid prediction is
// bad. Returns the number of frames scored now.
//
// Errors: kCancelled, after which another call goes on; kNotFound naming the first frame without a
// prediction; those of the predictor, ReadFrameTruth and CurationLog::Add.
absl::StatusOr<int64_t> ScoreFrames(const DatasetVariant& variant, const CurationNetwork& network,
                                    const CurateOptions& options, CurationLog& log);

// Returns for each frame the mean share of bad pixels over the networks, in [0, 1]. For one network
// this is its bad-2. With several, the mean is the expected share for a network drawn at random.
// Frames that a network has not scored, and frames without any truth, have no entry.
std::map<FrameId, double> AmbiguousShares(const DatasetVariant& variant,
                                          const std::vector<std::string>& network_ids,
                                          const CurationLog& log);

}  // namespace parallax
