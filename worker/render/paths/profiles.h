// The settings behind each render profile, in one table.
#pragma once

#include <string_view>

#include "common/base/status.h"
#include "parallax/v1/config.pb.h"

namespace parallax {

// Quality of the denoiser: the values of OIDN's `quality`.
enum class DenoiseQuality { kOff = 0, kFast = 4, kBalanced = 5, kHigh = 6 };

// The settings of a profile; configs may override each.
struct RenderProfile {
  std::string_view name;
  int samples_per_pixel = 4;  // For 1280x720; SamplesPerPixel gives other sizes.
  // Whether smaller pictures get more samples: they hold more detail and more edges a pixel.
  bool more_when_small = false;
  int max_bounces = 6;  // Surface interactions after the first.
  DenoiseQuality denoise = DenoiseQuality::kHigh;
  // Indirect radiance of one sample is clamped to this multiple of the picture's mean luminance
  // (against fireflies). 0: never.
  float clamp = 0;
  // Number of paths that fill the scene's radiance cache; 0: no cache.
  int64_t cache_paths = 0;
  // Width of a path's footprint, in cells, at which it may end in the cache. Lower is less noisy,
  // higher keeps light in corners exact.
  float cache_footprint = 1.5f;

  // Samples per pixel of a picture of this size: with `more_when_small`, `samples_per_pixel` times
  // the power of two, up to 4, that is nearest to the ratio of 1280x720 to it in width.
  int SamplesPerPixel(int width_px, int height_px) const;
};

// Returns the profile of a config with its overrides; `denoise: on` means the best quality. Errors:
// kInvalidArgument for an unknown name or a negative number.
absl::StatusOr<RenderProfile> ResolveProfile(const v1::RenderConfig& config);

}  // namespace parallax
