#include "common/image/picture_size.h"

#include <fmt/core.h>

#include "common/base/system/memory_budget.h"

namespace parallax::picture_internal {

absl::Status CheckPictureSize(std::string_view format, int64_t width, int64_t height,
                              int64_t pixel_bytes) {
  constexpr int64_t kMostSide = 1 << 16, kMostPixels = int64_t{1} << 28;
  if (width <= 0 || height <= 0 || width > kMostSide || height > kMostSide ||
      width * height > kMostPixels) {
    return InvalidArgument("{} of {} x {} pixels, allowed are {}", format, width, height,
                           kMostPixels);
  }
  constexpr int64_t kSmall = 16 << 20;  // Fits whenever anything does.
  const int64_t bytes = width * height * pixel_bytes;
  if (bytes <= kSmall) return absl::OkStatus();
  return CheckMemory(fmt::format("{} of {} x {} pixels", format, width, height), bytes);
}

}  // namespace parallax::picture_internal
