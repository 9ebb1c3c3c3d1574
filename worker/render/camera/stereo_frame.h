// One stereo pair with its ground truth, in memory; names and encodings are those of the dataset
// format. Both views have the same width and height.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <variant>
#include <vector>

#include "common/image/image.h"
#include "common/math/types.h"

namespace parallax {

// Bits of View::masks.
enum MaskBit : uint8_t {
  kMaskSky = 1,
  kMaskExterior = 2,
  kMaskTransparent = 4,
  kMaskMirror = 8,
  // Fewer than half of the pixel's samples lie within 1 px of its disparity: fine structure, where
  // the picture shows other surfaces than the ground truth.
  kMaskMixed = 16,
  kMaskVeiled = 32,  // Haze leaves less than a twentieth of its light.
};

// How clear a surface is, as layers tell it.
enum class Clearness : uint8_t { kOpaque, kThinGlass, kSolidGlass, kWater };

// Flow of one eye from a frame of a sequence to a neighbour. Empty unless render.maps has `flow`.
struct FlowMaps {
  // Channels 0 and 1: offset u, v in pixels from a pixel's centre to the surface point of its first
  // hit in the same eye of the neighbouring frame, after the motion of its object. Channel 2:
  // change of its disparity, pixels. A pixel without a surface has the flow of a point at infinity.
  ImageF3 flow;
  ImageU8 occlusion;  // FlowOcclusion.
};

// Values of FlowMaps::occlusion.
enum FlowOcclusion : uint8_t {
  kFlowVisible = 0,
  kFlowNone = 128,      // No such neighbour, or the point is behind its camera: flow is 0.
  kFlowOccluded = 255,  // Hidden in the neighbour, or outside its picture.
};

// One rectified eye: the picture and its maps, all of one size.
struct View {
  ImageRgb8 color;      // 8-bit sRGB.
  ImageF3 radiance;     // Linear, denoised, unexposed radiance behind `color`. Not written.
  ImageF depth_m;       // Along the optical axis at pixel centres, exact first hit; 0 = no surface.
  ImageF disparity_px;  // fx * baseline / depth in float precision, positive in both views; 0 = no
                        // surface.
  ImageU8 occlusion;    // 255 = occluded or outside the other view, 0 = visible in both.
  ImageU16 objects;     // SceneObject.index, 0 = none.
  ImageU16 materials;   // SceneMaterial.index, 0 = none.
  ImageF3 normals;      // Unit, the view's camera frame, facing the camera; 0 = no surface.
  ImageU8 masks;        // MaskBit.
  FlowMaps forward, backward;
  ImageU8 exact_occlusion;  // As `occlusion`, by rays; empty unless render.maps has it.
  ImageU8 infrared;         // As ToSrgb of infrared light; empty unless render.maps has `infrared`.
};

// One picture of the pair before rectification.
struct RawView {
  ImageRgb8 color;    // 8-bit sRGB, exposed as the rectified pair.
  ImageF3 radiance;   // As View's.
  ImageF3 flow;       // From a pixel to where the other raw picture shows the same point: x, y, px,
                      // and 1; 0 0 0 where the other lens does not see it at all.
  ImageU8 occlusion;  // 255 = occluded or outside the other picture, 0 = visible in both.
};

// A map of either type of images.
using MapImage = std::variant<ImageRgb8, ImageU8, ImageU16, ImageF, ImageF3>;

// The pair, and what it took to render.
struct StereoFrame {
  View left, right;
  RawView raw_left, raw_right;  // Empty unless render.maps has `raw` and the rig raw cameras.
  // Maps that no pass and no statistic reads, by file name (common/config/frame_maps.h).
  std::map<std::string, MapImage> more;
  // With layers: the see-through materials among them, by index, and the inner spaces of the place,
  // outside of which surfaces are exterior (Surroundings::interiors).
  std::map<uint32_t, Clearness> clear_materials;
  std::vector<Box3f> interiors;
  // Factor on scene radiance before the sRGB curve; the same for both eyes.
  float exposure = 1;
  float infrared_exposure = 1;  // Exposure of View::infrared (infrared.h).
  double trace_s = 0, denoise_s = 0, truth_s = 0;
  double cache_s = 0;  // Filling the radiance cache: only in a scene's first frame.
  uint64_t rays = 0;   // Rays traced for the images, shadow rays included.
};

}  // namespace parallax
