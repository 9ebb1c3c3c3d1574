#include "worker/sensor/take_picture.h"

#include <cmath>
#include <utility>

#include "common/base/rng.h"
#include "common/image/jpeg.h"
#include "worker/render/film/exposure.h"
#include "worker/sensor/mosaic.h"
#include "worker/sensor/optics.h"
#include "worker/sensor/sensor_noise.h"

namespace parallax {
namespace {

void Multiply(double red, double green, double blue, ImageF3& picture) {
  const float gains[3] = {static_cast<float>(red), static_cast<float>(green),
                          static_cast<float>(blue)};
  if (red == 1 && green == 1 && blue == 1) return;
  for (size_t i = 0; i < picture.values().size(); ++i) picture.values()[i] *= gains[i % 3];
}

// Light to measurements.
void Measure(const SensorDraw& draw, const SensorAddress& address, ImageF3& picture) {
  const Rng stream = Rng(address.seed, "sensor")
                         .Child("rig", address.rig)
                         .Child(address.eye == 0 ? "left" : "right");
  const NoiseModel model{draw.white_e, draw.read_noise_e};
  const bool noisy = draw.white_e > 0;
  if (draw.bayer) {
    ImageF mosaic = Mosaic(picture);
    if (noisy) AddNoise(model, stream, mosaic);
    picture = Demosaic(mosaic);
  } else if (noisy) {
    AddNoise(model, stream, picture);
  }
}

}  // namespace

absl::StatusOr<ImageRgb8> TakePicture(const SensorDraw& draw, const SensorAddress& address,
                                      LinearView view) {
  ImageF3& picture = view.light;
  if (picture.empty()) return InvalidArgument("sensor: an empty picture");
  const bool same_size =
      view.depth_m.width() == picture.width() && view.depth_m.height() == picture.height();
  if ((draw.defocus_px > 0 || !view.motion.IsStill()) && !same_size) {
    return InvalidArgument(
        "sensor: defocus and motion need the depth of each pixel, which is {} x {}, wanted {} x {}",
        view.depth_m.width(), view.depth_m.height(), picture.width(), picture.height());
  }
  const auto eye = static_cast<size_t>(address.eye);
  const double gain = std::exp2(draw.exposure_ev[eye]);
  Multiply(gain, gain, gain, picture);
  BlurByMotion(view.motion, view.depth_m, picture);
  Defocus(draw.defocus_px, draw.focus_m, view.depth_m, picture);
  SpreadPoints(draw.psf_sigma_px, picture);
  Vignette(draw.vignetting, picture);
  Measure(draw, address, picture);
  Multiply(std::exp2(draw.red_ev[eye]), 1, std::exp2(draw.blue_ev[eye]), picture);
  ImageRgb8 developed = ToSrgb(picture, 1);
  if (draw.jpeg_quality == 0) return developed;
  ASSIGN_OR_RETURN(const std::string packed, EncodeJpeg(developed, draw.jpeg_quality));
  return DecodePictureRgb8(packed);
}

}  // namespace parallax
