// Image-based lighting from an equirectangular picture: its middle column looks along +x, its top
// row up, and azimuth grows from right to left. Constant; thread-safe.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "common/base/status.h"
#include "common/image/image.h"
#include "common/math/lanes.h"
#include "common/math/types.h"

namespace parallax {

// The picture as a light source: evaluated, sampled, and with its density.
class Environment {
 public:
  // Reads a .hdr or .exr. Errors: kInvalidArgument naming the file if it can't be decoded, its
  // width is not twice its height (to a pixel), a value is no number, or it has no light at all;
  // those of ReadFile.
  static absl::StatusOr<std::shared_ptr<const Environment>> Read(const std::string& path);
  // Makes an environment from a picture in memory. Errors: kInvalidArgument, as in Read, and for a
  // value that is below 0 or infinite.
  static absl::StatusOr<std::shared_ptr<const Environment>> Make(const ImageF3& picture);

  // Returns the radiance from unit directions, interpolated bilinearly between pixels.
  Vec3f Radiance(const Vec3f& direction) const;
  Vec3x8 Radiance(const Vec3x8& directions) const;

  // Samples a unit direction in proportion to the light, from (u, v) in [0, 1)^2; and the density
  // of that, per solid angle.   Source: Pharr, Jakob, Humphreys, "Physically based rendering", 4th
  // ed., 12.5.2.
  Vec3f Sample(float u, float v) const;
  float Pdf(const Vec3f& direction) const;

  // Return the mean luminance of the upper hemisphere, and the irradiance of a horizontal ground.
  float mean_luminance() const { return mean_luminance_; }
  float ground_irradiance() const { return ground_irradiance_; }

  // Returns which values of the file were changed, to which, and where the first lies; or "".
  const std::string& note() const { return note_; }

 private:
  Environment() = default;
  static absl::StatusOr<std::shared_ptr<const Environment>> MakeNoted(const ImageF3& picture,
                                                                      std::string note);
  void MakeDensity();
  // Returns the image point of a direction, in columns and rows; pixel (x, y) has its middle at (x
  // + 0.5, y + 0.5).
  Vec2f PlaceOf(const Vec3f& direction) const;
  Vec3f DirectionOf(float x, float y) const;

  ImageF3 picture_;
  // Density of each cell of a grid, and cumulative sums: over rows, and over cells in each row.
  int columns_ = 0, rows_ = 0;
  std::vector<float> density_;      // Per solid angle.
  std::vector<float> rows_up_to_;   // rows_ + 1 numbers, the last is 1.
  std::vector<float> cells_up_to_;  // columns_ + 1 for each row, the last is 1.
  float mean_luminance_ = 0, ground_irradiance_ = 0;
  std::string note_;
};

// Opens the picture that Sky.environment names, from a folder that this process has read; the last
// few stay open. Errors: those of FindEnvironment and Environment::Read.
absl::StatusOr<std::shared_ptr<const Environment>> OpenEnvironment(uint64_t seed);

}  // namespace parallax
