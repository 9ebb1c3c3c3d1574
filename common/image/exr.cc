#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfInputFile.h>
#include <ImfOutputFile.h>
#include <half.h>

#include <cstring>

#include "common/base/status.h"
#include "common/base/system/file.h"
#include "common/image/io.h"

namespace parallax {
namespace {

// Measured on a room's 1280x720 disparity (tests/bench/dataset): ZIP at level 2 takes 88 ms and
// 1.93 MB, at OpenEXR's default level 4 106 ms and 1.88 MB; ZIPS 105 ms and 2.9 MB; PIZ 145 ms and
// 2.2 MB.
constexpr Imf::Compression kCompression = Imf::ZIP_COMPRESSION;
constexpr int kCompressionLevel = 2;

class MemoryOut final : public Imf::OStream {
 public:
  MemoryOut() : OStream("memory") {}
  void write(const char bytes[], int count) override {
    if (at_ + static_cast<size_t>(count) > bytes_.size()) {
      bytes_.resize(at_ + static_cast<size_t>(count));
    }
    std::memcpy(bytes_.data() + at_, bytes, static_cast<size_t>(count));
    at_ += static_cast<size_t>(count);
  }
  uint64_t tellp() override { return at_; }
  void seekp(uint64_t position) override { at_ = position; }
  std::string Take() { return std::move(bytes_); }

 private:
  std::string bytes_;
  size_t at_ = 0;
};

class MemoryIn final : public Imf::IStream {
 public:
  explicit MemoryIn(std::string_view bytes) : IStream("memory"), bytes_(bytes) {}
  bool read(char out[], int count) override {
    if (count < 0 || at_ > bytes_.size() || bytes_.size() - at_ < static_cast<size_t>(count)) {
      throw std::runtime_error("ends early");
    }
    std::memcpy(out, bytes_.data() + at_, static_cast<size_t>(count));
    at_ += static_cast<size_t>(count);
    return at_ < bytes_.size();
  }
  uint64_t tellg() override { return at_; }
  void seekg(uint64_t position) override { at_ = position; }

 private:
  std::string_view bytes_;
  size_t at_ = 0;
};

struct Channel {
  const char* name;
  Imf::PixelType type;
  char* data;  // Points to pixel (0, 0).
  size_t stride;
};

absl::StatusOr<std::string> Encode(int width, int height, const std::vector<Channel>& channels) {
  if (width <= 0 || height <= 0) return InvalidArgument("EXR of an empty image");
  try {
    Imf::Header header(width, height);
    header.compression() = kCompression;
    header.zipCompressionLevel() = kCompressionLevel;
    Imf::FrameBuffer buffer;
    for (const Channel& channel : channels) {
      header.channels().insert(channel.name, Imf::Channel(channel.type));
      buffer.insert(channel.name, Imf::Slice(channel.type, channel.data, channel.stride,
                                             channel.stride * static_cast<size_t>(width)));
    }
    MemoryOut out;
    {
      Imf::OutputFile file(out, header, /*numThreads=*/0);
      file.setFrameBuffer(buffer);
      file.writePixels(height);
    }
    return out.Take();
  } catch (const std::exception& error) {
    return Internal("EXR: {}", error.what());
  }
}

template <int channels>
absl::StatusOr<Image<float, channels>> Decode(std::string_view bytes,
                                              const std::array<const char*, channels>& names) {
  if (bytes.substr(0, 4) != std::string_view("\x76\x2f\x31\x01", 4)) {
    return InvalidArgument("not an EXR");
  }
  try {
    MemoryIn in(bytes);
    Imf::InputFile file(in, /*numThreads=*/0);
    const Imath::Box2i window = file.header().dataWindow();
    const int width = window.max.x - window.min.x + 1, height = window.max.y - window.min.y + 1;
    constexpr int kMostSide = 1 << 16;
    if (width <= 0 || height <= 0 || width > kMostSide || height > kMostSide) {
      return InvalidArgument("EXR of an impossible size");
    }
    for (const char* name : names) {
      if (file.header().channels().findChannel(name) == nullptr) {
        return InvalidArgument("EXR without channel {}", name);
      }
    }
    Image<float, channels> image(width, height);
    const size_t stride = sizeof(float) * channels, row = stride * static_cast<size_t>(width);
    Imf::FrameBuffer buffer;
    for (int c = 0; c < channels; ++c) {
      char* origin = reinterpret_cast<char*>(image.data() + c);
      buffer.insert(names[static_cast<size_t>(c)],
                    Imf::Slice(Imf::FLOAT,
                               origin - window.min.x * static_cast<ptrdiff_t>(stride) -
                                   window.min.y * static_cast<ptrdiff_t>(row),
                               stride, row));
    }
    file.setFrameBuffer(buffer);
    file.readPixels(window.min.y, window.max.y);
    return image;
  } catch (const std::exception& error) {
    return InvalidArgument("broken EXR: {}", error.what());
  }
}

}  // namespace

absl::StatusOr<std::string> EncodeExrY(const ImageF& image) {
  char* data = reinterpret_cast<char*>(const_cast<float*>(image.data()));
  return Encode(image.width(), image.height(), {{"Y", Imf::FLOAT, data, sizeof(float)}});
}

absl::StatusOr<std::string> EncodeExrHalfRgb(const ImageF3& image) {
  std::vector<half> halves(image.values().begin(), image.values().end());
  char* data = reinterpret_cast<char*>(halves.data());
  constexpr size_t kStride = 3 * sizeof(half);
  return Encode(image.width(), image.height(),
                {{"R", Imf::HALF, data, kStride},
                 {"G", Imf::HALF, data + sizeof(half), kStride},
                 {"B", Imf::HALF, data + 2 * sizeof(half), kStride}});
}

absl::StatusOr<std::string> EncodeExrRgb(const ImageF3& image) {
  char* data = reinterpret_cast<char*>(const_cast<float*>(image.data()));
  constexpr size_t kStride = 3 * sizeof(float);
  return Encode(image.width(), image.height(),
                {{"R", Imf::FLOAT, data, kStride},
                 {"G", Imf::FLOAT, data + sizeof(float), kStride},
                 {"B", Imf::FLOAT, data + 2 * sizeof(float), kStride}});
}

absl::StatusOr<ImageF> DecodeExrY(std::string_view bytes) { return Decode<1>(bytes, {"Y"}); }
absl::StatusOr<ImageF3> DecodeExrRgb(std::string_view bytes) {
  return Decode<3>(bytes, {"R", "G", "B"});
}

absl::StatusOr<ImageF> ReadExrY(const std::string& path) {
  ASSIGN_OR_RETURN(const std::string bytes, ReadFile(path));
  absl::StatusOr<ImageF> image = DecodeExrY(bytes);
  if (!image.ok()) return WithContext(image.status(), path);
  return image;
}
absl::StatusOr<ImageF3> ReadExrRgb(const std::string& path) {
  ASSIGN_OR_RETURN(const std::string bytes, ReadFile(path));
  absl::StatusOr<ImageF3> image = DecodeExrRgb(bytes);
  if (!image.ok()) return WithContext(image.status(), path);
  return image;
}

absl::Status WriteExrY(const std::string& path, const ImageF& image) {
  ASSIGN_OR_RETURN(const std::string bytes, EncodeExrY(image));
  return WriteFile(path, bytes);
}
absl::Status WriteExrHalfRgb(const std::string& path, const ImageF3& image) {
  ASSIGN_OR_RETURN(const std::string bytes, EncodeExrHalfRgb(image));
  return WriteFile(path, bytes);
}

}  // namespace parallax
