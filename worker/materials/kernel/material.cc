#include "worker/materials/kernel/material.h"

namespace parallax {

SurfacePoint8::SurfacePoint8(std::span<const SurfacePoint> points)
    : count(static_cast<int>(points.size())) {
  for (int lane = 0; lane < kLanes; ++lane) {
    const SurfacePoint& point = points[static_cast<size_t>(std::min(lane, count - 1))];
    texture_m.Set(lane, point.texture_m);
    normal.Set(lane, point.normal);
    u[lane] = point.uv.x();
    v[lane] = point.uv.y();
    footprint_m[lane] = point.footprint_m;
    texture_normal.Set(lane, point.texture_normal);
    footprint_uv[lane] = point.footprint_uv;
  }
}

SurfacePoint SurfacePoint8::Get(int lane) const {
  return {texture_m.Get(lane), normal.Get(lane),         {u[lane], v[lane]},
          footprint_m[lane],   texture_normal.Get(lane), footprint_uv[lane]};
}

void SurfaceSample8::Set(int lane, const SurfaceSample& s) {
  base_color.Set(lane, s.base_color);
  metallic[lane] = s.metallic;
  roughness[lane] = s.roughness;
  specular[lane] = s.specular;
  transmission[lane] = s.transmission;
  ior[lane] = s.ior;
  clearcoat[lane] = s.clearcoat;
  clearcoat_roughness[lane] = s.clearcoat_roughness;
  sheen[lane] = s.sheen;
  subsurface[lane] = s.subsurface;
  transmitted_color.Set(lane, s.transmitted_color);
  opacity[lane] = s.opacity;
  emission.Set(lane, s.emission);
  thin_walled[lane] = s.thin_walled ? -1 : 0;
}

SurfaceSample SurfaceSample8::Get(int lane) const {
  return {.base_color = base_color.Get(lane),
          .metallic = metallic[lane],
          .roughness = roughness[lane],
          .specular = specular[lane],
          .transmission = transmission[lane],
          .ior = ior[lane],
          .thin_walled = thin_walled[lane] != 0,
          .clearcoat = clearcoat[lane],
          .clearcoat_roughness = clearcoat_roughness[lane],
          .sheen = sheen[lane],
          .subsurface = subsurface[lane],
          .transmitted_color = transmitted_color.Get(lane),
          .opacity = opacity[lane],
          .emission = emission.Get(lane)};
}

Dual8 Material::Relief(const SurfacePoint8& points, const Tangents8& tangents) const {
  const Float8 height = Height(points);
  const Float8 step = Clamp(0.5f * points.footprint_m, 5e-5f, 0.02f);
  const auto slope = [&](int along) {
    SurfacePoint8 moved = points;
    moved.texture_m = points.texture_m + tangents.texture[along] * step;
    moved.u += tangents.u[along] * step;
    moved.v += tangents.v[along] * step;
    return (Height(moved) - height) / step;
  };
  return {height, slope(0), slope(1)};
}

SurfaceSample8 PointMaterial::Evaluate(const SurfacePoint8& points) const {
  SurfaceSample8 samples;
  for (int lane = 0; lane < points.count; ++lane) {
    samples.Set(lane, EvaluatePoint(points.Get(lane)));
  }
  return samples;
}

Float8 PointMaterial::Height(const SurfacePoint8& points) const {
  Float8 heights = Splat(0);
  for (int lane = 0; lane < points.count; ++lane) heights[lane] = HeightOfPoint(points.Get(lane));
  return heights;
}

}  // namespace parallax
