#include "common/image/jpeg.h"

// jpeglib.h needs stdio.h before it.
#include <cstdio>
// clang-format off
#include <jpeglib.h>
#include <jerror.h>
// clang-format on

#include <csetjmp>
#include <cstdlib>
#include <string_view>
#include <vector>

#include "common/base/system/file.h"
#include "common/image/picture_codecs.h"
#include "common/image/picture_size.h"

namespace parallax {
namespace {

// libjpeg leaves a failed call by longjmp to here.
struct ErrorManager {
  jpeg_error_mgr manager;  // First, so that libjpeg's pointer to it is one to this struct.
  std::jmp_buf escape;
  char message[JMSG_LENGTH_MAX] = "";
  char note[JMSG_LENGTH_MAX] = "";  // The first warning that does not matter.
};

[[noreturn]] void OnError(j_common_ptr codec) {
  auto* errors = reinterpret_cast<ErrorManager*>(codec->err);
  (*codec->err->format_message)(codec, errors->message);
  std::longjmp(errors->escape, 1);
}
// Negative levels are warnings. Webcams leave stray bytes between segments, and cameras that were
// switched off no end mark: neither loses a pixel. All other damage does: such a picture is
// refused, not shown half grey.
void OnMessage(j_common_ptr codec, int level) {
  if (level >= 0) return;
  const int code = codec->err->msg_code;
  if (code != JWRN_EXTRANEOUS_DATA && code != JWRN_JPEG_EOF) OnError(codec);
  auto* errors = reinterpret_cast<ErrorManager*>(codec->err);
  if (errors->note[0] == '\0') (*codec->err->format_message)(codec, errors->note);
}

void Prepare(ErrorManager* errors) {
  jpeg_std_error(&errors->manager);
  errors->manager.error_exit = OnError;
  errors->manager.emit_message = OnMessage;
}

// The encoder's buffer is malloc's; freed with this.
struct Encoder {
  Encoder() {
    Prepare(&errors);
    codec.err = &errors.manager;
    jpeg_create_compress(&codec);
  }
  ~Encoder() {
    jpeg_destroy_compress(&codec);
    std::free(bytes);
  }
  ErrorManager errors;
  jpeg_compress_struct codec{};
  unsigned char* bytes = nullptr;
  unsigned long size = 0;
};

struct Decoder {
  Decoder() {
    Prepare(&errors);
    codec.err = &errors.manager;
    jpeg_create_decompress(&codec);
  }
  ~Decoder() { jpeg_destroy_decompress(&codec); }
  ErrorManager errors;
  jpeg_decompress_struct codec{};
};

bool Compress(Encoder& encoder, const ImageRgb8& image, int quality) {
  if (setjmp(encoder.errors.escape) != 0) return false;
  jpeg_mem_dest(&encoder.codec, &encoder.bytes, &encoder.size);
  encoder.codec.image_width = static_cast<JDIMENSION>(image.width());
  encoder.codec.image_height = static_cast<JDIMENSION>(image.height());
  encoder.codec.input_components = 3;
  encoder.codec.in_color_space = JCS_RGB;
  jpeg_set_defaults(&encoder.codec);
  jpeg_set_quality(&encoder.codec, quality, TRUE);
  jpeg_start_compress(&encoder.codec, TRUE);
  const size_t stride = 3 * static_cast<size_t>(image.width());
  while (encoder.codec.next_scanline < encoder.codec.image_height) {
    JSAMPROW row = const_cast<uint8_t*>(image.data()) + encoder.codec.next_scanline * stride;
    jpeg_write_scanlines(&encoder.codec, &row, 1);
  }
  jpeg_finish_compress(&encoder.codec);
  return true;
}

bool ReadHeader(Decoder& decoder, std::string_view bytes) {
  if (setjmp(decoder.errors.escape) != 0) return false;
  jpeg_mem_src(&decoder.codec, reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size());
  jpeg_save_markers(&decoder.codec, JPEG_APP0 + 1, 0xffff);  // Exif.
  jpeg_read_header(&decoder.codec, TRUE);
  return true;
}

// Bytes of a pixel while it is decoded. A progressive file has all coefficients, of 16 bits, in
// memory beside the picture, from jpeg_start_decompress on.
int64_t PixelBytes(Decoder& decoder) {
  const int coefficients =
      jpeg_has_multiple_scans(&decoder.codec) ? decoder.codec.num_components : 0;
  return 3 + int64_t{2} * coefficients;
}

bool Decompress(Decoder& decoder, ImageRgb8& image) {
  if (setjmp(decoder.errors.escape) != 0) return false;
  decoder.codec.out_color_space = JCS_RGB;
  jpeg_start_decompress(&decoder.codec);
  const size_t stride = 3 * static_cast<size_t>(image.width());
  while (decoder.codec.output_scanline < decoder.codec.output_height) {
    JSAMPROW row = image.data() + decoder.codec.output_scanline * stride;
    jpeg_read_scanlines(&decoder.codec, &row, 1);
  }
  jpeg_finish_decompress(&decoder.codec);
  return true;
}

// How a camera was held: Exif's orientation, 1 (upright) to 8; 1 where none exists.
//   Source: CIPA DC-008 (Exif 2.3), 4.6.2 and 4.6.4.
int OrientationOf(std::string_view exif) {
  constexpr size_t kHeader = 6;  // "Exif", two zeros; then a TIFF header.
  if (exif.size() < kHeader + 8 || exif.substr(0, 4) != "Exif") return 1;
  const std::string_view tiff = exif.substr(kHeader);
  const bool big = tiff[0] == 'M';
  const auto number = [&](size_t at, size_t bytes) -> size_t {
    size_t value = 0;
    if (at + bytes > tiff.size()) return 0;
    for (size_t i = 0; i < bytes; ++i) {
      value = value << 8 | static_cast<uint8_t>(tiff[at + (big ? i : bytes - 1 - i)]);
    }
    return value;
  };
  const size_t directory = number(4, 4);
  const size_t entries = number(directory, 2);
  for (size_t i = 0; i < entries; ++i) {
    const size_t entry = directory + 2 + 12 * i;
    if (number(entry, 2) != 0x0112) continue;
    const size_t orientation = number(entry + 8, 2);
    return orientation >= 1 && orientation <= 8 ? static_cast<int>(orientation) : 1;
  }
  return 1;
}

int OrientationOf(const Decoder& decoder) {
  for (auto marker = decoder.codec.marker_list; marker != nullptr; marker = marker->next) {
    if (marker->marker != JPEG_APP0 + 1) continue;
    return OrientationOf({reinterpret_cast<const char*>(marker->data), marker->data_length});
  }
  return 1;
}

// Turns a picture as its Exif orientation asks for.
ImageRgb8 Upright(const ImageRgb8& image, int orientation) {
  if (orientation == 1) return image;
  const bool swaps = orientation >= 5;
  const int width = image.width(), height = image.height();
  ImageRgb8 upright(swaps ? height : width, swaps ? width : height);
  for (int y = 0; y < upright.height(); ++y) {
    for (int x = 0; x < upright.width(); ++x) {
      int from_x = swaps ? y : x, from_y = swaps ? x : y;
      const bool mirror_x =
          orientation == 2 || orientation == 3 || orientation == 7 || orientation == 8;
      const bool mirror_y =
          orientation == 3 || orientation == 4 || orientation == 6 || orientation == 7;
      if (mirror_x) from_x = width - 1 - from_x;
      if (mirror_y) from_y = height - 1 - from_y;
      for (int c = 0; c < 3; ++c) upright(x, y, c) = image(from_x, from_y, c);
    }
  }
  return upright;
}

}  // namespace

absl::StatusOr<std::string> EncodeJpeg(const ImageRgb8& image, int quality) {
  if (image.empty()) return InvalidArgument("JPEG of an empty image");
  Encoder encoder;
  if (!Compress(encoder, image, quality)) {
    return Internal("JPEG: {}", encoder.errors.message);
  }
  return std::string(reinterpret_cast<const char*>(encoder.bytes), encoder.size);
}

absl::Status WriteJpeg(const std::string& path, const ImageRgb8& image, int quality) {
  ASSIGN_OR_RETURN(const std::string bytes, EncodeJpeg(image, quality));
  return WriteFile(path, bytes);
}

namespace picture_internal {

bool IsJpeg(std::string_view bytes) { return bytes.substr(0, 2) == "\xff\xd8"; }

absl::StatusOr<Decoded> DecodeJpeg(std::string_view bytes) {
  Decoder decoder;
  const auto broken = [&decoder] {
    return InvalidArgument("broken JPEG: {}", decoder.errors.message);
  };
  if (!ReadHeader(decoder, bytes)) return broken();
  if (decoder.codec.num_components == 4) {
    return InvalidArgument("JPEG of four inks (CMYK), wanted grey or R G B: convert it");
  }
  RETURN_IF_ERROR(CheckPictureSize("JPEG", decoder.codec.image_width, decoder.codec.image_height,
                                   PixelBytes(decoder)));
  ImageRgb8 image(static_cast<int>(decoder.codec.image_width),
                  static_cast<int>(decoder.codec.image_height));
  const int orientation = OrientationOf(decoder);  // Decompress frees the markers.
  if (!Decompress(decoder, image)) return broken();
  return Decoded{.shallow = Upright(image, orientation), .note = decoder.errors.note};
}

}  // namespace picture_internal
}  // namespace parallax
