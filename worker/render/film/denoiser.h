// Wraps Open Image Denoise in one class; only denoiser.cc includes its C interface.
//
// Device and filter are kept for the scene; images of one size reuse them. Not thread-safe: one
// Execute at a time.
#pragma once

#include <memory>

#include "common/base/cancel.h"
#include "common/base/status.h"
#include "common/image/image.h"
#include "worker/render/paths/profiles.h"

namespace parallax {

// Denoises HDR pictures with albedo and normal guides.
class Denoiser {
 public:
  // Creates device and filter. Errors: kResourceExhausted, kInternal, with the library's message.
  static absl::StatusOr<std::unique_ptr<Denoiser>> Create(DenoiseQuality quality);
  ~Denoiser();

  // Denoises linear HDR `color` in place. `albedo` in [0, 1] and `normal` in [-1, 1] must be nearly
  // free of noise. All have the same size. Errors: kCancelled; kResourceExhausted; kInternal.
  absl::Status Execute(const CancelToken& cancel, const ImageF3& albedo, const ImageF3& normal,
                       ImageF3* color);

 private:
  struct State;
  explicit Denoiser(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace parallax
