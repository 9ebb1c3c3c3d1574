// One stereo pair with its ground truth, in memory, as dataset-format names it. Both views share
// width and height.
#pragma once

#include <cstdint>

#include "common/image/image.h"

namespace parallax {

// Bits of View::masks.
enum MaskBit : uint8_t {
  kMaskSky = 1,
  kMaskExterior = 2,
  kMaskTransparent = 4,
  kMaskMirror = 8,
  // Less than half of the samples that the pixel's colour is made of lie within 1 px of its
  // disparity: fine structure, a label that the picture does not show.
  kMaskMixed = 16,
  kMaskVeiled = 32,  // Haze leaves less than a twentieth of it.
};

struct View {
  ImageRgb8 color;      // 8-bit sRGB.
  ImageF3 radiance;     // What `color` was made of: linear, denoised, before exposure. Not written.
  ImageF depth_m;       // Along the optical axis at pixel centres, exact first hit; 0 = no surface.
  ImageF disparity_px;  // fx * baseline / depth in float precision, positive in both views; 0 = no
                        // surface.
  ImageU8 occlusion;    // 255 = occluded or outside the other view, 0 = visible in both.
  ImageU16 objects;     // SceneObject.index, 0 = none.
  ImageU16 materials;   // SceneMaterial.index, 0 = none.
  ImageF3 normals;      // Unit, the view's camera frame, facing the camera; 0 = no surface.
  ImageU8 masks;        // MaskBit.
  ImageU8 infrared;     // As ToSrgb of infrared light; empty unless render.maps has `infrared`.
};

// One picture of the pair before rectification.
struct RawView {
  ImageRgb8 color;    // 8-bit sRGB, exposed as the rectified pair.
  ImageF3 radiance;   // As View's.
  ImageF3 flow;       // From a pixel to where the other raw picture shows the same point: x, y, px,
                      // and 1; 0 0 0 where the other lens does not see it at all.
  ImageU8 occlusion;  // 255 = occluded or outside the other picture, 0 = visible in both.
};

struct StereoFrame {
  View left, right;
  RawView raw_left, raw_right;  // Empty unless render.maps has `raw` and the rig raw cameras.
  float exposure =
      1;  // Scene radiance is multiplied by it before the sRGB curve; one value for both eyes.
  float infrared_exposure = 1;  // Likewise of View::infrared (infrared.h).
  double trace_s = 0, denoise_s = 0, truth_s = 0;
  double cache_s = 0;  // Filling the radiance cache: of a scene's first frame only.
  uint64_t rays = 0;   // Of the images, shadow rays included.
};

}  // namespace parallax
