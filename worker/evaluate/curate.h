// Curation: which frames of a dataset trained networks can't match. FoundationStereo's authors
// throw away what a network, trained on the set itself, misses by more than 2 px on most pixels.
// Source: Wen et al., FoundationStereo, CVPR 2025 (BP-2 above 60 %).
#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "common/base/cancel.h"
#include "common/base/clock.h"
#include "common/base/status.h"
#include "worker/dataset/archive_index.h"
#include "worker/dataset/curation_log.h"
#include "worker/evaluate/predictors/predictor.h"

namespace parallax {

struct CurationNetwork {
  std::string id;  // SHA-256 of the checkpoint.
  Predictor* predictor = nullptr;
};

struct CurateOptions {
  std::string work_dir;  // Exists; a few predictions at a time lie there.
  CancelToken cancel;
  Clock* clock = &Clock::System();
  // Frames that `network` has scored, and those that it has to.
  std::function<void(int64_t done, int64_t total)> progress = [](int64_t, int64_t) {};
};

// Scores the variant's frames that the log does not know of `network`, and adds them to it. Judged
// are the left pixels with truth, sky and the exterior of rooms left out; a pixel without a valid
// prediction is bad. Returns how many frames were scored now.
//
// Errors: kCancelled, after which another call goes on; kNotFound naming the first frame without a
// prediction; as the predictor's, ReadFrameTruth and CurationLog::Add.
absl::StatusOr<int64_t> ScoreFrames(const DatasetVariant& variant, const CurationNetwork& network,
                                    const CurateOptions& options, CurationLog& log);

// Each frame's mean share of bad pixels over the networks, in [0, 1]: for one network its bad-2.
// With several, the mean is what one of them, drawn at random, would be expected to miss. Frames
// that a network has not scored, and those without any truth, have none.
std::map<FrameKey, double> AmbiguousShares(const DatasetVariant& variant,
                                           const std::vector<std::string>& network_ids,
                                           const CurationLog& log);

}  // namespace parallax
