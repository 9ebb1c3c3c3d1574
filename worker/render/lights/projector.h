// A projector of dots (scene.proto, Projector): which radiant intensity leaves it in which
// direction.
//
// Its dots stand at pseudo-random places that depend on its seed and their number alone: one in
// each cell of a grid over the plane z = 1 of its frame, away from the cell's border, so that few
// of them overlap and no part of the field is bare. Each carries the same power and is a Gaussian
// of the angle from its middle, whose diameter is 4 sigma (D4sigma of ISO 11146). Frame: as a
// camera's, x right, y down, z forward. Constant; thread-safe.
#pragma once

#include <vector>

#include "common/base/status.h"
#include "common/math/types.h"
#include "parallax/v1/scene.pb.h"

namespace parallax {

// Surface that one sample sees: the sides of a parallelogram around a point, in metres.
struct SampleFootprint {
  Vec3f across = Vec3f::Zero(), down = Vec3f::Zero();
};

class DotPattern {
 public:
  // Errors: kInvalidArgument for numbers that are not finite, a power or number of dots below 0, a
  // field of view that is not between 0 and 180 degrees, a dot without width.
  static absl::StatusOr<DotPattern> Make(const v1::Projector& projector);

  // Returns the radiant intensity, in W/sr, in the direction of `to`, a point in the projector's
  // frame in metres. It is the mean over the footprint there, so that dots smaller than a pixel
  // keep their power. 0 where no dot shines.
  // Source: Heckbert, "Fundamentals of texture mapping and image warping", 1989: elliptical
  // Gaussian filters; here on the sphere of directions.
  float Intensity(const Vec3f& to, const SampleFootprint& footprint) const;

  // Middles of the dots, on the plane z = 1.
  const std::vector<Vec2f>& dots() const { return dots_; }

 private:
  DotPattern() = default;
  void PlaceDots(uint64_t seed, int count);

  float power_w_ = 0;           // Each dot's.
  float variance_ = 0;          // A dot's Gaussian along each axis, rad^2.
  Vec2f half_ = Vec2f::Ones();  // Half sides of the field, on the plane z = 1.
  int columns_ = 1, rows_ = 1;
  std::vector<Vec2f> dots_;
  std::vector<int32_t> dot_of_cell_;  // Row by row; -1: none.
};

}  // namespace parallax
