// A dataset in the folder layouts that public training code reads.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "common/base/cancel.h"
#include "common/base/status.h"
#include "worker/dataset/frame/histogram.h"

namespace parallax {

struct ExportOptions {
  std::string layout = "flyingthings";  // One of ExportLayouts().
  bool unfiltered = false;              // Includes frames that fail a filter.
  bool flat = false;                    // crestereo: no sub-folders.
  bool allow_incomplete = false;        // Without all variants and pairs that were asked for.
  // Names; a trailing * matches the rest. Empty: all but the held-out variant.
  std::vector<std::string> variants;
  bool infrared = false;  // The infrared pictures are the pair, in place of colour.
  int test_every = 20;    // Every n-th scene goes to TEST; at least one does.
  int shard_pairs = 500;  // webdataset: pairs in one shard.
  CancelToken cancel;
};

struct ExportResult {
  int64_t pairs = 0, pairs_test = 0;
  int64_t pairs_filtered_out = 0;
  int64_t scenes = 0, scenes_test = 0;
  int64_t files_linked = 0, files_written = 0;
  int64_t bytes_written = 0;
  // Left pixels with a surface whose disparity the layout's encoding can't represent; written as
  // invalid.
  int64_t pixels_out_of_range = 0;
  Histogram disparity = DisparityHistogram();  // Left views of the exported frames.
  std::map<int, double> below_limit;           // Share of pixels below each of kDisparityLimitsPx.
  std::vector<std::string> notes;              // Hints to the user, one sentence each.
};

// Returns the names of the layouts: "flyingthings", "fsd", "crestereo", "wmgstereo", "middlebury",
// "kitti", "webdataset"; for sequences with flow "flyingthings-flow", "sintel", "dynamic-replica".
const std::vector<std::string>& ExportLayouts();

// Converts the dataset in `dir` to `out_dir`, which must not exist, or be empty. Images are hard
// links to the dataset's where the layout takes PNG and both are on one file system. Besides the
// layout's own files it has train.txt and test.txt (the splits), export.json (the origin of each
// frame) and SHA256SUMS. `out_dir` appears only when it is complete.
//
// Errors: kFailedPrecondition for an incomplete dataset (missing or unexpected files, fewer pairs
// or variants than asked for), naming the first fault, for an `out_dir` that is not empty, a link
// or a mount point, and for sequences whose baseline changes where the layout has one for all;
// kNotFound when no frame is left; kInvalidArgument for an unknown layout or variant; kDataLoss for
// unreadable maps, a damaged frame.json or a copied file that is not what the index says, naming
// the frame; writing as WriteFile.
absl::StatusOr<ExportResult> ExportDataset(const std::string& dir, const std::string& out_dir,
                                           const ExportOptions& options);

}  // namespace parallax
