// A variant's frames, brought out of the store into a folder that trainers and benchmarks read: an
// archive of this variant alone, without the frames that its filters turn down.
#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "common/base/cancel.h"
#include "common/base/status.h"
#include "common/store/store.h"
#include "parallax/v1/train.pb.h"
#include "worker/dataset/archive_index.h"
#include "worker/jobs/frame_cache.h"

namespace parallax {

// Maps that are read to train, and those for errors by class and material as well.
std::vector<std::string> FilesForTraining();
std::vector<std::string> FilesForEvaluation();

struct FrameFolderOptions {
  // Files that are wanted of each frame; maps that were not rendered are left out.
  std::vector<std::string> files;
  double share = 1;  // Part of the frames that pass, the first ones; at least one.
  // A control: each pair gets the right image of the pair that stands half the set away.
  bool mismatched = false;
  // Of a curated set: the share of each frame's pixels that networks miss, by which frames are
  // turned down as well (filters.max_ambiguous_share). Null: frames are not judged so.
  const std::map<FrameKey, double>* ambiguous_shares = nullptr;
  CancelToken cancel;
  std::function<void(double fraction)> progress = [](double) {};
};

struct FrameFolderFacts {
  int64_t pairs = 0;     // In the folder.
  int64_t left_out = 0;  // Turned down by filters.
  std::string sha256;    // Over names and contents, lower-case hex.
};

// Writes `dir`/index.jsonl, dataset.json and frames/<scene>/<rig>/. Files are hard links where that
// can be, else links to a store's folder or copies of the cache's files. The same set gives the
// same folder on every machine. `dir` ends in the variant's name.
//
// Errors: kFailedPrecondition when no frame is left, and when two are needed for `mismatched`;
// kCancelled; those of Judge, the store and the cache.
absl::StatusOr<FrameFolderFacts> BringFrames(const v1::FrameSet& set, const Store& store,
                                             const FrameCache& cache, const std::string& dir,
                                             const FrameFolderOptions& options);

}  // namespace parallax
