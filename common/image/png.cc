#include <png.h>

#include <csetjmp>
#include <cstring>

#include "common/base/status.h"
#include "common/base/system/file.h"
#include "common/image/io.h"
#include "common/image/picture_codecs.h"
#include "common/image/picture_size.h"

namespace parallax {
namespace {

// State of libpng's callbacks. libpng leaves a failed call by longjmp, so no object with a
// destructor may be created between setjmp and the end of a call: all of them live here.
struct Transfer {
  std::string error;
  std::string written;
  std::string_view unread;
  std::vector<png_bytep> rows;
};

[[noreturn]] void OnError(png_structp png, png_const_charp message) {
  static_cast<Transfer*>(png_get_error_ptr(png))->error = message;
  std::longjmp(png_jmpbuf(png), 1);
}
void OnWarning(png_structp, png_const_charp) {}

void OnWrite(png_structp png, png_bytep data, png_size_t size) {
  static_cast<Transfer*>(png_get_io_ptr(png))
      ->written.append(reinterpret_cast<const char*>(data), size);
}
void OnFlush(png_structp) {}

void OnRead(png_structp png, png_bytep out, png_size_t size) {
  std::string_view& unread = static_cast<Transfer*>(png_get_io_ptr(png))->unread;
  if (unread.size() < size) png_error(png, "ends early");
  std::memcpy(out, unread.data(), size);
  unread.remove_prefix(size);
}

// Frees libpng's structs when a call ends, whichever way.
struct Writer {
  explicit Writer(Transfer& transfer)
      : png(png_create_write_struct(PNG_LIBPNG_VER_STRING, &transfer, OnError, OnWarning)),
        info(png_create_info_struct(png)) {
    png_set_write_fn(png, &transfer, OnWrite, OnFlush);
  }
  ~Writer() { png_destroy_write_struct(&png, &info); }
  png_structp png;
  png_infop info;
};
struct Reader {
  explicit Reader(Transfer& transfer)
      : png(png_create_read_struct(PNG_LIBPNG_VER_STRING, &transfer, OnError, OnWarning)),
        info(png_create_info_struct(png)) {
    png_set_read_fn(png, &transfer, OnRead);
  }
  ~Reader() { png_destroy_read_struct(&png, &info, nullptr); }
  png_structp png;
  png_infop info;
};

template <typename ImageType>
void PointToRows(ImageType& image, Transfer& transfer) {
  const size_t stride = image.values().size() / static_cast<size_t>(image.height());
  transfer.rows.resize(static_cast<size_t>(image.height()));
  for (size_t y = 0; y < transfer.rows.size(); ++y) {
    transfer.rows[y] = reinterpret_cast<png_bytep>(
        const_cast<typename ImageType::Value*>(image.data()) + y * stride);
  }
}

struct Layout {
  int width = 0, height = 0, bits = 0, color_type = 0;
};

// Bilevel images come as one byte a pixel.
bool WriteRows(Writer& writer, const Layout& layout, int compression, Transfer& transfer) {
  if (setjmp(png_jmpbuf(writer.png)) != 0) return false;
  png_set_compression_level(writer.png, compression);
  png_set_compression_strategy(writer.png, 0);  // Z_DEFAULT_STRATEGY
  png_set_IHDR(writer.png, writer.info, static_cast<png_uint_32>(layout.width),
               static_cast<png_uint_32>(layout.height), layout.bits, layout.color_type,
               PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  png_write_info(writer.png, writer.info);
  if (layout.bits == 1) png_set_packing(writer.png);
  if (layout.bits == 16) png_set_swap(writer.png);
  png_write_image(writer.png, transfer.rows.data());
  png_write_end(writer.png, writer.info);
  return true;
}

template <typename T, int channels>
absl::StatusOr<std::string> Encode(const Image<T, channels>& image, int compression, int bits) {
  if (image.empty()) return InvalidArgument("PNG of an empty image");
  Transfer transfer;
  PointToRows(image, transfer);
  Writer writer(transfer);
  const Layout layout = {image.width(), image.height(), bits,
                         channels == 3 ? PNG_COLOR_TYPE_RGB : PNG_COLOR_TYPE_GRAY};
  if (!WriteRows(writer, layout, compression, transfer)) {
    return Internal("PNG: {}", transfer.error);
  }
  return std::move(transfer.written);
}

// The header; palettes and fewer than eight bits a pixel count as what they unfold to.
bool ReadHeader(Reader& reader, Layout* layout) {
  if (setjmp(png_jmpbuf(reader.png)) != 0) return false;
  png_read_info(reader.png, reader.info);
  png_set_expand(reader.png);
  png_set_interlace_handling(reader.png);
  png_set_swap(reader.png);
  png_read_update_info(reader.png, reader.info);
  layout->width = static_cast<int>(png_get_image_width(reader.png, reader.info));
  layout->height = static_cast<int>(png_get_image_height(reader.png, reader.info));
  layout->bits = png_get_bit_depth(reader.png, reader.info);
  layout->color_type = png_get_channels(reader.png, reader.info);
  return true;
}

// As ReadHeader, but makes R G B of any PNG; transparent pixels keep their colour. Sets
// *significant_values to the largest value of the bits that the file's sBIT names.
bool ReadHeaderAsRgb(Reader& reader, Layout* layout, int* significant_values) {
  if (setjmp(png_jmpbuf(reader.png)) != 0) return false;
  png_read_info(reader.png, reader.info);
  png_set_expand(reader.png);
  png_set_gray_to_rgb(reader.png);
  png_set_strip_alpha(reader.png);
  png_set_interlace_handling(reader.png);
  png_set_swap(reader.png);
  png_color_8p significant = nullptr;
  if (png_get_sBIT(reader.png, reader.info, &significant) != 0) {
    const bool grey = (png_get_color_type(reader.png, reader.info) & PNG_COLOR_MASK_COLOR) == 0;
    const int bits = grey ? significant->gray : significant->green;
    if (bits > 0 && bits < 16) *significant_values = (1 << bits) - 1;
  }
  png_read_update_info(reader.png, reader.info);
  layout->width = static_cast<int>(png_get_image_width(reader.png, reader.info));
  layout->height = static_cast<int>(png_get_image_height(reader.png, reader.info));
  layout->bits = png_get_bit_depth(reader.png, reader.info);
  return true;
}

bool ReadRows(Reader& reader, Transfer& transfer) {
  if (setjmp(png_jmpbuf(reader.png)) != 0) return false;
  png_read_image(reader.png, transfer.rows.data());
  png_read_end(reader.png, nullptr);
  return true;
}

absl::Status Broken(const Transfer& transfer) {
  return InvalidArgument("broken PNG: {}", transfer.error);
}

template <typename T, int channels>
absl::StatusOr<Image<T, channels>> Decode(std::string_view bytes) {
  if (!picture_internal::IsPng(bytes)) return InvalidArgument("not a PNG");
  Transfer transfer{.unread = bytes};
  Reader reader(transfer);
  Layout layout;
  if (!ReadHeader(reader, &layout)) return Broken(transfer);
  RETURN_IF_ERROR(picture_internal::CheckPictureSize("PNG", layout.width, layout.height,
                                                     channels * int64_t{sizeof(T)}));
  if (layout.bits != 8 * static_cast<int>(sizeof(T)) || layout.color_type != channels) {
    return InvalidArgument("PNG of {} bits and {} channels, wanted {} bits and {}", layout.bits,
                           layout.color_type, 8 * sizeof(T), channels);
  }
  Image<T, channels> image(layout.width, layout.height);
  PointToRows(image, transfer);
  if (!ReadRows(reader, transfer)) return Broken(transfer);
  return image;
}

template <typename T, int channels>
absl::StatusOr<Image<T, channels>> Read(const std::string& path) {
  ASSIGN_OR_RETURN(const std::string bytes, ReadFile(path));
  absl::StatusOr<Image<T, channels>> image = Decode<T, channels>(bytes);
  if (!image.ok()) return WithContext(image.status(), path);
  return image;
}

template <typename ImageType>
absl::Status Write(const std::string& path, const ImageType& image, int compression) {
  ASSIGN_OR_RETURN(const std::string bytes, EncodePng(image, compression));
  return WriteFile(path, bytes);
}

}  // namespace

namespace picture_internal {

bool IsPng(std::string_view bytes) { return bytes.substr(0, 4) == "\x89PNG"; }

absl::StatusOr<Decoded> DecodePng(std::string_view bytes) {
  Transfer transfer{.unread = bytes};
  Reader reader(transfer);
  Layout layout;
  Decoded decoded;
  if (!ReadHeaderAsRgb(reader, &layout, &decoded.significant)) return Broken(transfer);
  RETURN_IF_ERROR(CheckPictureSize("PNG", layout.width, layout.height, layout.bits == 16 ? 6 : 3));
  if (layout.bits == 16) {
    decoded.deep = Image<uint16_t, 3>(layout.width, layout.height);
    PointToRows(decoded.deep, transfer);
  } else {
    decoded.shallow = ImageRgb8(layout.width, layout.height);
    PointToRows(decoded.shallow, transfer);
  }
  if (!ReadRows(reader, transfer)) return Broken(transfer);
  return decoded;
}

}  // namespace picture_internal

absl::StatusOr<std::string> EncodePng(const ImageRgb8& image, int compression) {
  return Encode(image, compression, 8);
}
absl::StatusOr<std::string> EncodePng(const ImageU8& image, int compression) {
  return Encode(image, compression, 8);
}
absl::StatusOr<std::string> EncodePng(const ImageU16& image, int compression) {
  return Encode(image, compression, 16);
}

absl::StatusOr<std::string> EncodePngBits(const ImageU8& image) {
  if (image.empty()) return InvalidArgument("PNG of an empty image");
  ImageU8 bits(image.width(), image.height());
  for (size_t i = 0; i < image.pixels(); ++i) bits.values()[i] = image.values()[i] ? 1 : 0;
  return Encode(bits, kPngCompression, 1);
}

absl::StatusOr<ImageRgb8> DecodePngRgb8(std::string_view bytes) {
  return Decode<uint8_t, 3>(bytes);
}
absl::StatusOr<ImageU8> DecodePngU8(std::string_view bytes) { return Decode<uint8_t, 1>(bytes); }
absl::StatusOr<ImageU16> DecodePngU16(std::string_view bytes) { return Decode<uint16_t, 1>(bytes); }

absl::StatusOr<ImageRgb8> ReadPngRgb8(const std::string& path) { return Read<uint8_t, 3>(path); }
absl::StatusOr<ImageU8> ReadPngU8(const std::string& path) { return Read<uint8_t, 1>(path); }
absl::StatusOr<ImageU16> ReadPngU16(const std::string& path) { return Read<uint16_t, 1>(path); }

absl::Status WritePng(const std::string& path, const ImageRgb8& image, int compression) {
  return Write(path, image, compression);
}
absl::Status WritePng(const std::string& path, const ImageU8& image, int compression) {
  return Write(path, image, compression);
}
absl::Status WritePng(const std::string& path, const ImageU16& image, int compression) {
  return Write(path, image, compression);
}

}  // namespace parallax
