#include "common/image/hdr.h"

#include <cstring>
#include <memory>
#include <string>

#define STBI_ONLY_HDR
#define STBI_NO_STDIO
#define STB_IMAGE_STATIC
#define STB_IMAGE_IMPLEMENTATION
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
#include <stb/stb_image.h>
#pragma GCC diagnostic pop

namespace parallax {

absl::StatusOr<ImageF3> DecodeHdr(std::string_view bytes) {
  const auto* data = reinterpret_cast<const stbi_uc*>(bytes.data());
  const int size = static_cast<int>(bytes.size());
  if (stbi_is_hdr_from_memory(data, size) == 0) {
    return InvalidArgument("not a .hdr of Radiance's");
  }
  int width = 0, height = 0, channels = 0;
  const std::unique_ptr<float, void (*)(void*)> values(
      stbi_loadf_from_memory(data, size, &width, &height, &channels, 3), &stbi_image_free);
  if (values == nullptr) {
    return InvalidArgument("broken .hdr: {}", stbi_failure_reason());
  }
  ImageF3 image(width, height);
  std::memcpy(image.data(), values.get(), image.values().size() * sizeof(float));
  return image;
}

}  // namespace parallax
