// A dataset in the folder layouts that public training code reads.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "common/base/cancel.h"
#include "common/base/status.h"
#include "worker/dataset/histogram.h"

namespace parallax {

struct ExportOptions {
  std::string layout = "flyingthings";  // One of ExportLayouts().
  bool unfiltered = false;              // Frames that fail a filter too.
  bool flat = false;                    // crestereo: no sub-folders.
  bool allow_incomplete = false;        // A variant with fewer pairs than were asked for.
  std::vector<std::string> variants;    // Names; a trailing * matches the rest. Empty: all.
  bool infrared = false;                // The infrared pictures are the pair, in place of colour.
  int test_every = 20;                  // Each so-many-th scene goes to TEST; at least one does.
  int shard_pairs = 500;                // webdataset: pairs of one shard.
  CancelToken cancel;
};

struct ExportResult {
  int64_t pairs = 0, pairs_test = 0;
  int64_t pairs_filtered_out = 0;
  int64_t scenes = 0, scenes_test = 0;
  int64_t files_linked = 0, files_written = 0;
  int64_t bytes_written = 0;
  // Left pixels with a surface whose disparity the layout's encoding can't hold: written as
  // invalid.
  int64_t pixels_out_of_range = 0;
  Histogram disparity = DisparityHistogram();  // Of the left views, exported frames.
  std::map<int, double> below_limit;           // kDisparityLimitsPx -> part of the pixels.
  std::vector<std::string> notes;              // What the user should know, one sentence each.
};

// "flyingthings", "fsd", "crestereo", "wmgstereo", "middlebury", "kitti", "webdataset".
const std::vector<std::string>& ExportLayouts();

// Writes `out_dir` (which must not exist, or be empty) from the dataset in `dir`. Images are hard
// links to the dataset's where the layout takes PNG and both are on one file system. Beside the
// layout's own files: train.txt and test.txt (what is in which split), export.json (where each
// frame came from) and SHA256SUMS. out_dir appears only when it is whole.
//
// Errors: kFailedPrecondition for a dataset with holes (missing files, strays, fewer pairs than
// asked for) naming the first, and for an out_dir that holds something; kNotFound when no frame is
// left; kInvalidArgument for an unknown layout or variant; kDataLoss for maps that can't be read;
// writing as WriteFile.
absl::StatusOr<ExportResult> ExportDataset(const std::string& dir, const std::string& out_dir,
                                           const ExportOptions& options);

}  // namespace parallax
