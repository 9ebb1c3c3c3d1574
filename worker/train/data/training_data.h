// Pairs to train on: finds the frames of dataset folders, orders them, and reads their maps.
//
// The order depends on the seed and the number of frames only, never on what they show, so two
// variants with the same scenes are visited alike.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/base/status.h"
#include "common/image/image.h"

namespace parallax {

// A frame by its folder.
struct TrainingFrame {
  std::string name;  // "<variant>/000012/003"
  std::string dir;
};

// One part of a mixture.
struct TrainingSource {
  std::string path;
  double weight = 1;      // Share of the batches' pairs, against the other sources' weights.
  std::string data_hash;  // SHA-256 over the names and file hashes of `frames`.
  int left_out = 0;       // Frames that a filter turned down.
  bool heldout_left_out = false;  // The archive has held-out pairs, which are not among `frames`.
  std::vector<TrainingFrame> frames;
};

// Options for the choice of a source's frames.
struct SourceOptions {
  bool unfiltered = false;     // Also frames that a filter turned down.
  bool allow_missing = false;  // Go on without frames whose files are gone.
  bool heldout = false;        // Also an archive's held-out pairs, which no network may train on.
};

// Lists the frames of a source. `spec` is "DIR" or "DIR=WEIGHT"; DIR is an archive (its
// variants, the held-out one as `options` say) or a variant's folder.
// Errors: kInvalidArgument for a weight that is not a positive number; kFailedPrecondition when no
// frame is left, or when a frame lacks an image or the left disparity; as ReadDataset.
absl::StatusOr<TrainingSource> ReadTrainingSource(const std::string& spec,
                                                  const SourceOptions& options);

// The kind of truth that a pixel has.
enum Trust : uint8_t { kNoTruth = 0, kOccluded = 1, kVisible = 2 };

// One eye: its image, disparity in pixels (positive) and Trust by pixel, all of one size.
struct TrainingEye {
  ImageRgb8 image;
  ImageF disparity_px;  // Empty: this eye has no truth.
  ImageU8 trust;
};

// Both eyes of a frame.
struct TrainingPair {
  TrainingEye left, right;
};

// Reads both eyes of a frame. Sky, the exterior seen through a room's windows, and pixels without a
// surface have no truth. If occlusion or mask files were not written, all pixels count as visible.
// Errors: kDataLoss for maps of different sizes or a disparity that is not finite; as Read*.
absl::StatusOr<TrainingPair> ReadTrainingPair(const std::string& frame_dir);

// Indices of a source and of a frame within it.
struct FrameChoice {
  int source = 0;
  int frame = 0;
};

// The endless sequence of pairs. Sources alternate so that after any number of pairs each source is
// within one pair of its share. Each source goes through its frames in a new random order every
// round.
class FrameOrder {
 public:
  // `sizes` are the sources' numbers of frames, `weights` their weights; all are positive.
  FrameOrder(uint64_t seed, std::vector<int> sizes, std::vector<double> weights);

  FrameChoice Next();

 private:
  struct Source {
    int size;
    double share;
    int64_t taken = 0;
    std::vector<int> round;
  };

  uint64_t seed_;
  int64_t taken_ = 0;
  std::vector<Source> sources_;
};

}  // namespace parallax
