// Verifies a dataset: every file's hash, and the relations between images, maps, cameras and tables
// of each pair.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/base/cancel.h"
#include "common/base/status.h"

namespace parallax {

struct VerifyOptions {
  bool hashes = true;
  bool geometry = true;
  int max_findings = 1000;  // More are counted, not listed.
  CancelToken cancel;
};

// One fault of the dataset.
struct Finding {
  std::string check;    // "hash", "missing", "disparity", "pose", "tables"...
  std::string path;     // The file or folder.
  std::string message;  // Says what was seen and what was wanted.
};

struct VerifyResult {
  std::string kind;  // "archive" or "export".
  int64_t frames = 0, files = 0, bytes = 0, variants = 0;
  int64_t findings_total = 0;
  std::vector<Finding> findings;  // In order of path.
};

// Checks a dataset. `dir` is an archive, one of its variants, or a folder that `parallax export`
// wrote (its files are compared with SHA256SUMS). Geometry of a frame, with the archive's own
// numbers:
//   depth and disparity finite, >= 0, and disparity = fx * baseline / depth to 1e-6; sky bit and
//   depth 0 together; occlusion 0 or 255 and equal to what re-projection with 1 % gives (0.1 % of
//   the pixels may differ); exact occlusion 0 or 255, and 255 outside of the other picture;
//   object and material indices in their tables; normals of length 1 that face the camera; poses
//   rigid, the right camera at +x by the baseline; statistics and filter verdicts of the index as
//   the maps give them; where the study gives a camera (rigs.camera), its K, size and baseline to
//   1e-6; recipes with the seed and cameras of their frames; of raw pairs, correspondences that are
//   epipolar once rectified; of sequences, flow and disparity change as depth, cameras and motion
//   give them (2e-3 px), flow occlusion as the neighbours' depth has it (2 % of the pixels may
//   differ).
// Errors: kNotFound when `dir` is no dataset; kDataLoss for an index that can't be read. Faults of
// the dataset are findings, not errors.
absl::StatusOr<VerifyResult> VerifyDataset(const std::string& dir,
                                           const VerifyOptions& options = {});

}  // namespace parallax
