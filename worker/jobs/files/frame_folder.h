// Copies a variant's frames from the store into a folder for trainers and benchmarks: an archive of
// this variant alone, without the frames that its filters reject.
#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "common/base/cancel.h"
#include "common/base/status.h"
#include "common/store/store.h"
#include "parallax/v1/train.pb.h"
#include "worker/dataset/archive/archive_index.h"
#include "worker/jobs/files/frame_cache.h"

namespace parallax {

// Return the names of the files for training, and for evaluation, which also needs the maps for
// errors by class and material.
std::vector<std::string> FilesForTraining();
std::vector<std::string> FilesForEvaluation();

// The choice of frames and of their files.
struct FrameFolderOptions {
  // Files wanted of each frame; maps that were not rendered are left out.
  std::vector<std::string> files;
  double share = 1;  // Share of the passing frames, from the first on; at least one.
  // A control experiment: this share of the pairs, spread evenly and at least one if above 0, get
  // the right image of the pair half the set away. The pairs of a share are among those of each
  // larger one.
  double mismatched = 0;
  // For a curated set: each frame's share of pixels that networks miss. Frames above
  // filters.max_ambiguous_share are rejected too. Null: the set is not curated.
  const std::map<FrameId, double>* ambiguous_shares = nullptr;
  CancelToken cancel;
  std::function<void(double fraction)> progress = [](double) {};
};

// A summary of the folder.
struct FrameFolderFacts {
  int64_t pairs = 0;       // In the folder.
  int64_t left_out = 0;    // Turned down by filters.
  int64_t mismatched = 0;  // In the folder, with the right image of another pair.
  std::string sha256;      // Over names and contents, lower-case hex.
};

// Writes `dir`/index.jsonl, dataset.json and frames/<scene>/<rig>/. Files are hard links if
// possible, else symbolic links to a store's folder or copies of the cache's files. The same set
// gives the same folder on every machine. `dir` ends in the variant's name. With set.truth
// "behind", the maps are those of the last layer (behind_truth.h).
//
// Errors: kFailedPrecondition when no frame is left, and when two are needed for `mismatched`;
// kCancelled; those of Judge, the store and the cache.
absl::StatusOr<FrameFolderFacts> BringFrames(const v1::FrameSet& set, const Store& store,
                                             const FrameCache& cache, const std::string& dir,
                                             const FrameFolderOptions& options);

}  // namespace parallax
