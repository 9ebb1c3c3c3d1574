// Predicts the disparities of any stereo pair by a checkpoint. This header does not include torch.
//
// Sizes and ranges: the pair is padded to a multiple of 32 px. A pair wider than kNetworkWidth is
// reduced to that width first and its disparities are scaled back. At the size that the network
// sees it searches `max_disparity` px (by default as far as it was trained, 192), at most
// kNetworkDisparity: for more, the pair is reduced further. Truth beyond the range is missed, never
// reported as an error.
//
// A pair is predicted twice: first reduced (kFirstLook), which shows how far it may be enlarged for
// the second look, up to kNetworkWidth and kMostEnlarged, so that the search still reaches all
// disparities. The errors of the network are the same in its own pixels, so those of the second
// look are smaller in pixels of the input; but walls without texture are matched only where the
// network sees as far as their borders, as it does in the reduced pair. Each pixel takes the look
// that is surer of it (JoinLooks). A network that was trained without changes of scale looks once.
// Pixels that the right eye does not see are filled from the background beside them
// (FillHiddenPixels).
#pragma once

#include <memory>
#include <string>

#include "common/base/status.h"
#include "common/image/image.h"
#include "worker/train/network/settings.h"

namespace parallax {

// Search range and threads.
struct PredictOptions {
  // Pixels of the input; 0: the range of training, at the network's size.
  double max_disparity = 0;
  int threads = 0;  // 0: as torch chooses.
  int looks = 2;    // 1: one prediction, of a small pair in a fifth of the time, less exactly.
};

// The size at which the network sees an input.
struct NetworkSize {
  int width = 0, height = 0;                // After reduction or enlargement.
  int padded_width = 0, padded_height = 0;  // Multiples of 32.
  int max_disparity = 0;                    // A multiple of 16.
};

// Chooses the size at which the network sees the pair, reduced by `reduction` once more.
NetworkSize ChooseNetworkSize(int width, int height, int trained_disparity, double max_disparity,
                              double reduction = 1);

// Returns the factor by which the input is enlarged for a second prediction. `disparity_px` is the
// first one, in pixels of the input.
double ChooseEnlargement(const ImageF& disparity_px, int trained_disparity);

// What the network gives at one look, on the pixels of the input. `certainty` in [0, 1]: the
// probability of a disparity's three candidates at a quarter of the network's size.
struct Look {
  ImageF disparity_px, certainty;
};

// Returns the disparities of `fine`, but those of `coarse` where it is surer by far around a pixel.
// All pictures are of one size.
ImageF JoinLooks(const Look& coarse, const Look& fine);

// Thread-safe after Load.
class Predictor {
 public:
  // Loads a checkpoint. Errors: those of ReadCheckpoint; kDataLoss for a weight that is not finite,
  // naming it.
  static absl::StatusOr<Predictor> Load(const std::string& checkpoint);

  // Returns the disparity of each left pixel in pixels of the input, finite, >= 0, of the input's
  // size. The same pair, options and threads give the same bytes. Errors: kInvalidArgument for an
  // empty image or two sizes; kResourceExhausted when memory is short; kInternal for a disparity
  // that is not finite.
  absl::StatusOr<ImageF> Predict(const ImageRgb8& left, const ImageRgb8& right,
                                 const PredictOptions& options) const;

  Predictor(Predictor&&) noexcept;
  ~Predictor();

 private:
  struct State;
  explicit Predictor(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace parallax
