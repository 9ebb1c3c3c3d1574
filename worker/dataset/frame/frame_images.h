// The images of a frame in memory by file name, and how each is encoded and read.
#pragma once

#include <map>
#include <string>
#include <string_view>
#include <variant>

#include "common/base/status.h"
#include "common/config/frame_maps.h"
#include "worker/render/camera/stereo_frame.h"

namespace parallax {

// Borrowed from a frame.
using FrameImage =
    std::variant<const ImageRgb8*, const ImageU8*, const ImageU16*, const ImageF*, const ImageF3*>;

// Returns the images of all rows of the table of maps that the frame may have, by file name; those
// that were not made are empty. For hdr_*.exr it is the radiance before exposure.
std::map<std::string, FrameImage> ImagesOf(const StereoFrame& frame);

// Returns a view's linear light with the exposure of its 8-bit picture, finite and at most
// kMostLight, which half floats can hold: hdr_*.exr.
ImageF3 LightOf(const View& view, float exposure);

// Encodes an image as the row says. Errors: kInternal for an image of another type than the
// encoding's; as Encode*.
absl::StatusOr<std::string> EncodeMap(const FrameMap& row, const FrameImage& image);

// Reads an eye's file of the row with that stem in a frame's folder. Errors: as Read*.
absl::Status ReadMap(const std::string& frame_dir, std::string_view stem, std::string_view eye,
                     ImageU8* image);
absl::Status ReadMap(const std::string& frame_dir, std::string_view stem, std::string_view eye,
                     ImageU16* image);
absl::Status ReadMap(const std::string& frame_dir, std::string_view stem, std::string_view eye,
                     ImageF* image);
absl::Status ReadMap(const std::string& frame_dir, std::string_view stem, std::string_view eye,
                     ImageF3* image);

// As ReadMap; a file that is not there leaves the image empty.
template <typename ImageType>
absl::Status ReadMapIfThere(const std::string& frame_dir, std::string_view stem,
                            std::string_view eye, ImageType* image) {
  const absl::Status status = ReadMap(frame_dir, stem, eye, image);
  return absl::IsNotFound(status) ? absl::OkStatus() : status;
}

}  // namespace parallax
