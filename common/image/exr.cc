#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfInputFile.h>
#include <ImfInputPart.h>
#include <ImfMultiPartInputFile.h>
#include <ImfOutputFile.h>
#include <ImfPartType.h>
#include <half.h>

#include <algorithm>
#include <cctype>
#include <cstring>
#include <map>

#include "common/base/names.h"
#include "common/base/status.h"
#include "common/base/system/file.h"
#include "common/image/hdr.h"
#include "common/image/io.h"
#include "common/image/picture_size.h"

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

// The channels that a picture is read from, all in one part of the file.
struct Source {
  int part = 0;
  std::vector<std::string> channels;
};

// A file's channels: by layer, then by the last part of the name in lower case.
class Channels {
 public:
  explicit Channels(const Imf::MultiPartInputFile& file) {
    for (int part = 0; part < file.parts(); ++part) Add(file.header(part), part);
  }

  // The layer's own R G B; of several layers the one without a name, or Blender's Combined; of
  // files without colours the luminance, three times.
  absl::StatusOr<Source> Colors() const {
    ASSIGN_OR_RETURN(const Layer* const found, LayerThat([](const Layer& layer) {
                       return layer.Has({"r", "g", "b"});
                     }));
    if (found != nullptr) return found->SourceOf({"r", "g", "b"});
    if (all_.size() <= 2 && !layers_.empty() && layers_.begin()->second.Has({"y"})) {
      return layers_.begin()->second.SourceOf({"y", "y", "y"});
    }
    return NoColors();
  }

  // R, G and B as our own maps have them, in the part that has them.
  absl::StatusOr<Source> Rgb() const {
    const std::vector<std::string> names = {"R", "G", "B"};
    ASSIGN_OR_RETURN(
        const Layer* const found, LayerThat([&](const Layer& layer) {
          return layer.Has({"r", "g", "b"}) && layer.SourceOf({"r", "g", "b"}).channels == names;
        }));
    if (found == nullptr) return NoColors();
    return Source{found->part, names};
  }

  // Y, else Z, of a layer that has no X, for with X they are vectors; else the only channel of the
  // file.
  absl::StatusOr<Source> Value() const {
    for (const char* wanted : {"y", "z"}) {
      ASSIGN_OR_RETURN(const Layer* const found, LayerThat([&](const Layer& layer) {
                         return layer.Has({wanted}) && !layer.Has({"x"});
                       }));
      if (found != nullptr) return found->SourceOf({wanted});
    }
    if (all_.size() == 1) {
      const Layer& layer = layers_.begin()->second;
      return layer.SourceOf({layer.names.begin()->first});
    }
    return InvalidArgument("EXR without channel Y, or Z, or one channel alone; it has {}", Names());
  }

 private:
  struct Layer {
    int part = 0;
    std::map<std::string, std::string> names;  // As the file writes them, by "r", "g"...

    bool Has(const std::vector<std::string>& wanted) const {
      return std::all_of(wanted.begin(), wanted.end(),
                         [&](const std::string& name) { return names.contains(name); });
    }
    Source SourceOf(const std::vector<std::string>& wanted) const {
      Source source{part, {}};
      for (const std::string& name : wanted) source.channels.push_back(names.at(name));
      return source;
    }
  };

  // The layer that `fits`: of several the one without a name, or Blender's Combined; nullptr if
  // none does. Errors: kInvalidArgument naming several others.
  template <typename Fits>
  absl::StatusOr<const Layer*> LayerThat(const Fits& fits) const {
    std::vector<const Layer*> found;
    std::string names;
    for (const auto& [name, layer] : layers_) {
      if (!fits(layer)) continue;
      if (name.empty() || EndsWith(name, "combined")) return &layer;
      names += (names.empty() ? "" : ", ") + Quoted(name);
      found.push_back(&layer);
    }
    if (found.size() > 1) {
      return InvalidArgument("EXR of several pictures, {}: keep one of them", names);
    }
    return found.empty() ? nullptr : found[0];
  }

  absl::Status NoColors() const {
    return InvalidArgument("EXR without channel R, G or B; it has {}", Names());
  }

  static std::string Lower(std::string text) {
    for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return text;
  }
  static bool EndsWith(const std::string& name, std::string_view end) {
    return Lower(name).ends_with(end);
  }

  void Add(const Imf::Header& header, int part) {
    if (header.hasType() && Imf::isDeepData(header.type())) return;
    const std::string part_name = header.hasName() ? header.name() : "";
    for (auto at = header.channels().begin(); at != header.channels().end(); ++at) {
      const std::string full = at.name();
      const size_t dot = full.rfind('.');
      const std::string layer = dot != full.npos ? full.substr(0, dot) : "";
      // A part's name is the layer of channels that have none.
      Layer& found = layers_[layer.empty() ? (part == 0 ? "" : part_name) : layer];
      if (found.names.empty()) found.part = part;
      if (found.part != part) continue;
      found.names[Lower(dot != full.npos ? full.substr(dot + 1) : full)] = full;
      all_.push_back(full);
    }
  }

  std::string Names() const {
    std::string text;
    for (const std::string& name : all_) text += (text.empty() ? "" : " ") + Printable(name);
    return text.empty() ? "none that is flat" : text;
  }

  std::map<std::string, Layer> layers_;
  std::vector<std::string> all_;
};

// A frame buffer holds one slice a channel: of a channel named three times only the last is read.
void CopyLastToAll(ImageF3& image) {
  for (size_t i = 0; i < image.pixels(); ++i) {
    float* pixel = image.data() + 3 * i;
    pixel[0] = pixel[1] = pixel[2];
  }
}

template <int channels>
absl::StatusOr<Image<float, channels>> Decode(std::string_view bytes,
                                              absl::StatusOr<Source> (Channels::*choose)() const) {
  if (bytes.substr(0, 4) != std::string_view("\x76\x2f\x31\x01", 4)) {
    return InvalidArgument("not an EXR");
  }
  try {
    MemoryIn in(bytes);
    Imf::MultiPartInputFile file(in, /*numThreads=*/0);
    ASSIGN_OR_RETURN(const Source source, (Channels(file).*choose)());
    Imf::InputPart part(file, source.part);
    const Imath::Box2i window = part.header().dataWindow();
    const int64_t columns = int64_t{window.max.x} - window.min.x + 1;
    const int64_t rows = int64_t{window.max.y} - window.min.y + 1;
    RETURN_IF_ERROR(
        picture_internal::CheckPictureSize("EXR", columns, rows, channels * sizeof(float)));
    const auto width = static_cast<int>(columns), height = static_cast<int>(rows);
    Image<float, channels> image(width, height);
    const size_t stride = sizeof(float) * channels, row = stride * static_cast<size_t>(width);
    Imf::FrameBuffer buffer;
    for (int c = 0; c < channels; ++c) {
      char* origin = reinterpret_cast<char*>(image.data() + c);
      buffer.insert(source.channels[static_cast<size_t>(c)],
                    Imf::Slice(Imf::FLOAT,
                               origin - window.min.x * static_cast<ptrdiff_t>(stride) -
                                   window.min.y * static_cast<ptrdiff_t>(row),
                               stride, row));
    }
    part.setFrameBuffer(buffer);
    part.readPixels(window.min.y, window.max.y);
    if constexpr (channels == 3) {
      if (source.channels[0] == source.channels[2]) CopyLastToAll(image);
    }
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

absl::StatusOr<ImageF> DecodeExrY(std::string_view bytes) {
  return Decode<1>(bytes, &Channels::Value);
}
absl::StatusOr<ImageF3> DecodeExrRgb(std::string_view bytes) {
  return Decode<3>(bytes, &Channels::Rgb);
}

absl::StatusOr<ImageF3> DecodeExrPicture(std::string_view bytes) {
  return Decode<3>(bytes, &Channels::Colors);
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
