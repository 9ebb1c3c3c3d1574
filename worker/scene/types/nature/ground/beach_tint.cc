#include "worker/scene/types/nature/ground/beach_tint.h"

#include <array>

#include "worker/materials/kernel/material.h"

namespace parallax {

absl::StatusOr<Vec3d> MeanColor(const char* material_class, uint64_t seed) {
  ASSIGN_OR_RETURN(const auto material, MakeMaterial(material_class, seed));
  std::array<SurfacePoint, kLanes> points;
  for (size_t i = 0; i < points.size(); ++i) {
    points[i].texture_m = static_cast<float>(i) * Vec3f(3.1f, 1.7f, 0);
    points[i].footprint_m = 0.5f;
  }
  const SurfaceSample8 samples = material->Evaluate(SurfacePoint8(points));
  Vec3d sum = Vec3d::Zero();
  for (int lane = 0; lane < kLanes; ++lane) sum += samples.base_color.Get(lane).cast<double>();
  return Vec3d(sum / kLanes);
}

absl::StatusOr<Vec3d> BeachTint(uint64_t sand_seed) {
  constexpr double kWashed = 0.7;
  const Vec3d beige(1.12, 1.0, 0.83), luminance(0.2126, 0.7152, 0.0722);
  ASSIGN_OR_RETURN(const Vec3d color, MeanColor("Sand", sand_seed));
  const Vec3d washed = color.dot(luminance) / beige.dot(luminance) * beige;
  return Vec3d((color + kWashed * (washed - color)).cwiseQuotient(color));
}

absl::StatusOr<Vec3d> ShingleTint(uint64_t gravel_seed, uint64_t sand_seed) {
  constexpr double kDarker = 0.72;
  ASSIGN_OR_RETURN(const Vec3d gravel, MeanColor("Gravel", gravel_seed));
  ASSIGN_OR_RETURN(const Vec3d sand, MeanColor("Sand", sand_seed));
  ASSIGN_OR_RETURN(const Vec3d beach, BeachTint(sand_seed));
  const Vec3d wanted = kDarker * sand.cwiseProduct(beach);
  return Vec3d(wanted.cwiseQuotient(gravel).cwiseMin(3.0));
}

}  // namespace parallax
