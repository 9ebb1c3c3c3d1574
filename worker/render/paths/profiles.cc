#include "worker/render/paths/profiles.h"

#include <string>

namespace parallax {
namespace {

constexpr int64_t kUsualCachePaths = 2'000'000;

// clang-format off
constexpr RenderProfile kProfiles[] = {
    // name         spp   more  bounces  denoise                     clamp  cache paths  footprint
    {"preview",       2,  true,       3, DenoiseQuality::kFast,      16.0f,    500'000,      0.5f},
    {"default",       4,  true,       6, DenoiseQuality::kBalanced, 1024.0f, 2'000'000,      0.5f},
    {"high",         64, false,      10, DenoiseQuality::kHigh,    2048.0f,  4'000'000,      1.5f},
    {"reference",  4096, false,      32, DenoiseQuality::kOff,        0.0f,          0,      1.5f},
};
// clang-format on

}  // namespace

int RenderProfile::SamplesPerPixel(int width_px, int height_px) const {
  constexpr int64_t kUsualPixels = 1280 * 720;
  const int64_t pixels = int64_t{width_px} * height_px;
  // The power of two, up to 4, that is nearest to the ratio of widths.
  int times = 1;
  while (more_when_small && times < 4 && 2 * times * times * pixels < kUsualPixels) times *= 2;
  return times * samples_per_pixel;
}

absl::StatusOr<RenderProfile> ResolveProfile(const v1::RenderConfig& config) {
  const std::string name = config.profile().empty() ? "default" : config.profile();
  const RenderProfile* found = nullptr;
  for (const RenderProfile& profile : kProfiles) {
    if (profile.name == name) found = &profile;
  }
  if (!found) {
    return InvalidArgument(
        "render.profile: unknown \"{}\"; allowed: preview, default, high, reference", name);
  }
  if (config.samples_per_pixel() < 0 || config.max_bounces() < 0) {
    return InvalidArgument("render: samples_per_pixel and max_bounces must not be negative");
  }
  RenderProfile profile = *found;
  if (config.samples_per_pixel() > 0) {
    profile.samples_per_pixel = config.samples_per_pixel();
    profile.more_when_small = false;
  }
  if (config.max_bounces() > 0) profile.max_bounces = config.max_bounces();
  if (config.denoise() == v1::RenderConfig::DENOISE_OFF) profile.denoise = DenoiseQuality::kOff;
  if (config.denoise() == v1::RenderConfig::DENOISE_ON) profile.denoise = DenoiseQuality::kHigh;
  if (config.cache() == v1::RenderConfig::CACHE_OFF) profile.cache_paths = 0;
  if (config.cache() == v1::RenderConfig::CACHE_ON && profile.cache_paths == 0) {
    profile.cache_paths = kUsualCachePaths;
  }
  return profile;
}

}  // namespace parallax
