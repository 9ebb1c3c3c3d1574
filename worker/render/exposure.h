// From scene radiance to 8-bit sRGB.
//
// Exposure is automatic, one value for both eyes of a rig. It brings the picture's typical
// luminance L (geometric mean of small blocks, bright lamps cut at the 95th percentile) to kKey *
// (L / kUsualLuminance)^(1 - kAdaptation): the eye adapts to most of the scene's level but not to
// all of it, so that dim rooms look dim and night stays dark. Where the brightest fifth of the
// picture would burn out (a dark thing close by in a bright room), exposure is held back by
// kHoldBack of what it is too much. Then a shoulder: linear up to kShoulder, above it exponentially
// towards 1, so that lamps and windows roll off instead of clipping; then the sRGB curve.
#pragma once

#include "common/image/image.h"

namespace parallax {

inline constexpr float kKey = 0.20f;            // Linear; sRGB 124 of 255.
inline constexpr float kUsualLuminance = 2.0f;  // W / (m^2 sr): a furnished room by lamp light.
inline constexpr float kAdaptation = 0.85f;
inline constexpr float kMaxExposure =
    50.0f;                              // Darker scenes stay dark: the dataset's filter drops them.
inline constexpr float kBright = 0.8f;  // Where the 80th percentile should lie at most.
inline constexpr float kHoldBack = 0.7f;
inline constexpr float kShoulder = 0.6f;

// The factor for both images (same size, linear radiance; noise does no harm).
float AutomaticExposure(const ImageF3& left, const ImageF3& right);

// Linear [0, inf) after exposure to display-linear [0, 1).
float RollOff(float value);

// Radiance after exposure to an 8-bit level, before rounding: shoulder and sRGB curve.
float DisplayLevel(float value);

// Applies exposure, shoulder and sRGB curve; rounds to nearest.
ImageRgb8 ToSrgb(const ImageF3& radiance, float exposure);

}  // namespace parallax
