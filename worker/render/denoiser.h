// Open Image Denoise behind one class: the only file that knows its C interface is denoiser.cc.
//
// Device and filter are kept for the scene; images of one size reuse them. Not thread-safe: one
// Execute at a time.
#pragma once

#include <memory>

#include "common/base/cancel.h"
#include "common/base/status.h"
#include "common/image/image.h"
#include "worker/render/profiles.h"

namespace parallax {

class Denoiser {
 public:
  // Errors: kResourceExhausted, kInternal with the library's message.
  static absl::StatusOr<std::unique_ptr<Denoiser>> Create(DenoiseQuality quality);
  ~Denoiser();

  // Replaces linear HDR `color` by its denoised self. `albedo` in [0, 1] and `normal` in [-1, 1]
  // must be as good as free of noise. Each bounded by one image; same sizes. Errors: kCancelled;
  // kResourceExhausted; kInternal.
  absl::Status Execute(const CancelToken& cancel, const ImageF3& albedo, const ImageF3& normal,
                       ImageF3* color);

 private:
  struct State;
  explicit Denoiser(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace parallax
