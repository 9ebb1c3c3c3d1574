// The sequences of a dataset, cut where a frame is missing or filtered out. Private to
// worker/dataset.
#pragma once

#include <string>
#include <vector>

#include "common/base/status.h"
#include "worker/dataset/archive/dataset_reader.h"

namespace parallax {

// Frames that follow each other, of one scene, way and baseline.
struct SequenceRun {
  std::string suffix;  // For names: "-p1", with several baselines "-p1-b0", after a gap "-p1-r1".
  std::vector<const DatasetFrame*> frames;  // At least two.
};

// Finds the runs of a variant, in order of scene, baseline, path. `unfiltered`: frames that fail a
// filter too. Adds the frames that have no neighbour to `single`. Errors: kFailedPrecondition for a
// frame of no sequence or without flow maps; kDataLoss for a damaged frame.json; reading as
// ReadFrameJson.
absl::StatusOr<std::vector<SequenceRun>> FindRuns(const DatasetVariant& variant, bool unfiltered,
                                                  int64_t& single);

}  // namespace parallax
