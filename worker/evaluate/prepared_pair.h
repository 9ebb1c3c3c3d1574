// Pictures of a pair as every predictor reads them alike, and what is odd about a user's own pairs.
// Thread-safe.
#pragma once

#include <string>
#include <vector>

#include "common/base/status.h"
#include "common/image/image.h"
#include "worker/evaluate/benchmark.h"

namespace parallax {

// Where a predictor finds a pair's pictures, and notes on them for people, one line each.
struct PreparedPair {
  std::string left, right;
  std::vector<std::string> notes;
};

// Which files of a pair are read although a predictor could take them as they are.
enum class PairCheck { kNothing, kPictures, kPicturesAndTruth };

// Prepares the pictures of `pair`: those that are to be reduced, and those of cameras of few bits
// in files of 16 (ReadPicturePair), become `stem`_left.png and `stem`_right.png; all others stay
// where they are. With its truth it also notes eyes that look swapped, and disparities that look
// wrongly scaled. Errors: those of ReadPicturePair and of the pair's truth; kInvalidArgument for
// truth of another size than the pictures; those of WriteFile.
absl::StatusOr<PreparedPair> PreparePair(const BenchmarkPair& pair, const std::string& stem,
                                         PairCheck check);

// Returns what the truth says against the pictures: that the eyes are one, look swapped, or that
// disparities have another scale (as read by files of 256 steps a pixel); or "". All three have one
// size; 0 in `disparity_px` is no truth.
std::string WhyTruthMisfits(const ImageRgb8& left, const ImageRgb8& right,
                            const ImageF& disparity_px);

}  // namespace parallax
