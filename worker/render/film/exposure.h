// Tone mapping: from scene radiance to 8-bit sRGB.
//
// Exposure is automatic, one value for both eyes of a rig. It brings the picture's typical
// luminance L (geometric mean of small blocks, bright lamps cut at the 95th percentile) to kKey *
// (L / kUsualLuminance)^(1 - kAdaptation).
// Dim rooms look dim and night stays dark, because the eye adapts to most of the scene's level but
// not to all of it. Where nearly everything is light, as snow is, the picture is exposed longer, as
// photographers do: otherwise snow would be grey (Lightness). Where the brightest fifth of the
// picture would burn out (a dark thing close by in a bright room), exposure is reduced by kHoldBack
// of the excess. Then follow a shoulder, linear up to kShoulder and above it exponential towards 1,
// so that lamps and windows roll off instead of clipping, and the sRGB curve.
#pragma once

#include "common/image/image.h"

namespace parallax {

inline constexpr float kKey = 0.20f;            // Linear; sRGB 124 of 255.
inline constexpr float kUsualLuminance = 2.0f;  // W / (m^2 sr): a furnished room by lamp light.
inline constexpr float kAdaptation = 0.85f;
// Darker scenes stay dark: the dataset's filter drops them.
inline constexpr float kMaxExposure = 50.0f;
inline constexpr float kUsualAlbedo = 0.5f;  // Surfaces that are lighter than that look light.
inline constexpr float kBright = 0.8f;       // The highest level wanted for the 80th percentile.
inline constexpr float kHoldBack = 0.7f;
inline constexpr float kShoulder = 0.6f;

// Returns by how much the typical albedo (geometric mean of small blocks) of what an eye sees
// exceeds kUsualAlbedo, at least 1. Haze counts as white. Pixels with a zero normal see the sky, or
// haze as thick, and do not count.
float Lightness(const ImageF3& albedo, const ImageF3& normal);

// Returns the exposure factor for a pair of linear pictures of the same size; robust to noise.
// `lightness` multiplies the level of the picture.
float AutomaticExposure(const ImageF3& left, const ImageF3& right, float lightness = 1);

// Maps exposed linear radiance in [0, inf) to display-linear [0, 1).
float RollOff(float value);

// Returns the 8-bit level of exposed radiance, before rounding: shoulder and sRGB curve.
float DisplayLevel(float value);

// Applies exposure, shoulder and sRGB curve; rounds to nearest.
ImageRgb8 ToSrgb(const ImageF3& radiance, float exposure);

}  // namespace parallax
