#include "worker/dataset/frame/frame_images.h"

#include <algorithm>
#include <cmath>

#include "common/config/frame_files.h"
#include "common/image/io.h"

namespace parallax {
namespace {

// Encodes with a function that takes one type of images.
template <typename ImageType>
absl::StatusOr<std::string> EncodedAs(const FrameMap& row, const FrameImage& image,
                                      absl::StatusOr<std::string> (*encode)(const ImageType&)) {
  if (const auto* typed = std::get_if<const ImageType*>(&image)) return encode(**typed);
  return Internal("the image of {} has another type than its encoding", row.file);
}

template <typename ImageType>
absl::StatusOr<std::string> EncodedPng(const ImageType& image) {
  return EncodePng(image);
}

template <typename ImageType>
absl::Status ReadInto(absl::StatusOr<ImageType> (*read)(const std::string&),
                      const std::string& frame_dir, std::string_view stem, std::string_view eye,
                      ImageType* image) {
  ASSIGN_OR_RETURN(*image, read(frame_dir + "/" + MapFile(stem, eye)));
  return absl::OkStatus();
}

}  // namespace

ImageF3 LightOf(const View& view, float exposure) {
  ImageF3 light = view.radiance;
  for (float& value : light.values()) {
    value = std::isfinite(value) ? std::clamp(value * exposure, 0.0f, kMostLight) : 0.0f;
  }
  return light;
}

std::map<std::string, FrameImage> ImagesOf(const StereoFrame& frame) {
  std::map<std::string, FrameImage> images;
  for (const std::string eye : {"left", "right"}) {
    const View& view = eye == "left" ? frame.left : frame.right;
    const RawView& raw = eye == "left" ? frame.raw_left : frame.raw_right;
    const auto put = [&](std::string_view stem, const auto& image) {
      images[MapFile(stem, eye)] = &image;
    };
    images[eye + ".png"] = &view.color;
    put("hdr", view.radiance);
    put("depth", view.depth_m);
    put("disparity", view.disparity_px);
    put("occlusion", view.occlusion);
    put("objects", view.objects);
    put("materials", view.materials);
    put("normals", view.normals);
    put("masks", view.masks);
    put("exact_occlusion", view.exact_occlusion);
    put("infrared", view.infrared);
    put("raw", raw.color);
    put("raw_flow", raw.flow);
    put("raw_occlusion", raw.occlusion);
    for (const std::string way : {"forward", "backward"}) {
      const FlowMaps& maps = way == "forward" ? view.forward : view.backward;
      images[FrameMapOf("flow").FileOf(eye, way)] = &maps.flow;
      images[FrameMapOf("flow_occlusion").FileOf(eye, way)] = &maps.occlusion;
    }
  }
  for (const auto& [file, image] : frame.more) {
    std::visit([&, &name = file](const auto& typed) { images[name] = &typed; }, image);
  }
  return images;
}

absl::StatusOr<std::string> EncodeMap(const FrameMap& row, const FrameImage& image) {
  switch (row.encoding) {
    case FrameMap::kRgb8:
      return EncodedAs<ImageRgb8>(row, image, &EncodedPng);
    case FrameMap::kGrey8:
      return EncodedAs<ImageU8>(row, image, &EncodedPng);
    case FrameMap::kIndex16:
      return EncodedAs<ImageU16>(row, image, &EncodedPng);
    case FrameMap::kFloatY:
      return EncodedAs<ImageF>(row, image, &EncodeExrY);
    case FrameMap::kFloatRgb:
      return EncodedAs<ImageF3>(row, image, &EncodeExrRgb);
    case FrameMap::kHalfRgb:
      return EncodedAs<ImageF3>(row, image, &EncodeExrHalfRgb);
  }
  return Internal("{} has no encoding", row.file);
}

absl::Status ReadMap(const std::string& frame_dir, std::string_view stem, std::string_view eye,
                     ImageU8* image) {
  return ReadInto(&ReadPngU8, frame_dir, stem, eye, image);
}
absl::Status ReadMap(const std::string& frame_dir, std::string_view stem, std::string_view eye,
                     ImageU16* image) {
  return ReadInto(&ReadPngU16, frame_dir, stem, eye, image);
}
absl::Status ReadMap(const std::string& frame_dir, std::string_view stem, std::string_view eye,
                     ImageF* image) {
  return ReadInto(&ReadExrY, frame_dir, stem, eye, image);
}
absl::Status ReadMap(const std::string& frame_dir, std::string_view stem, std::string_view eye,
                     ImageF3* image) {
  return ReadInto(&ReadExrRgb, frame_dir, stem, eye, image);
}

}  // namespace parallax
