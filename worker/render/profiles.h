// The settings behind each render profile, in one table.
#pragma once

#include <string_view>

#include "common/base/status.h"
#include "parallax/v1/config.pb.h"

namespace parallax {

// Values of OIDN's `quality`.
enum class DenoiseQuality { kOff = 0, kFast = 4, kBalanced = 5, kHigh = 6 };

struct RenderProfile {
  std::string_view name;
  int samples_per_pixel = 4;  // For 1280x720; SamplesPerPixel gives other sizes.
  // Smaller pictures hold more detail in a pixel and have more edges among their pixels.
  bool more_when_small = false;
  int max_bounces = 6;  // Surface interactions after the first.
  DenoiseQuality denoise = DenoiseQuality::kHigh;
  // Indirect light of one sample above this multiple of the picture's mean luminance is cut
  // (fireflies). 0: never.
  float clamp = 0;
  // Paths that fill the radiance cache of a scene; 0: there is none.
  int64_t cache_paths = 0;
  // How many cells wide a path must be to end in the cache. Less is calmer, more keeps light in
  // corners exact.
  float cache_footprint = 1.5f;

  // Samples per pixel of a picture of this size: with `more_when_small`, `samples_per_pixel` times
  // the power of two, up to 4, that is nearest to the ratio of 1280x720 to it in width.
  int SamplesPerPixel(int width_px, int height_px) const;
};

// The profile of a config with its overrides; `denoise: on` is the denoiser at its best. Errors:
// kInvalidArgument for an unknown name or a negative number.
absl::StatusOr<RenderProfile> ResolveProfile(const v1::RenderConfig& config);

}  // namespace parallax
