// Tools that the material families share: colours, the plane of a flat pattern, filtered edges.
#pragma once

#include <cstdint>
#include <initializer_list>
#include <vector>

#include "common/base/rng.h"
#include "common/math/color.h"
#include "worker/materials/kernel/material.h"
#include "worker/materials/kernel/noise.h"

namespace parallax {

// Converts 0xRRGGBB in sRGB to linear Rec. 709.
Vec3f SrgbColor(uint32_t hex);
// Converts hue [0, 1), saturation and value [0, 1] in sRGB to linear Rec. 709.
Vec3f HsvColor(double hue, double saturation, double value);
// Varies a colour randomly: `value` is the relative standard deviation of its brightness, `tint`
// that of its channels.
Vec3f VaryColor(Rng& rng, const Vec3f& color, double value = 0.12, double tint = 0.04);
// Varies one of `hexes`, each of equal probability.
Vec3f PickColor(Rng& rng, std::initializer_list<uint32_t> hexes, double value, double tint);
// Blends towards grey of the same luminance; 0 = unchanged, 1 = grey.
Vec3f Desaturate(const Vec3f& color, float amount);

// Interpolates linearly. Albedo, below, limits the result to albedos.
inline Vec3f Mix(const Vec3f& a, const Vec3f& b, float t) { return a + (b - a) * t; }
// Limits a colour to albedos of real surfaces: none is blacker than 2 % or whiter than 90 %.
inline Vec3f Albedo(const Vec3f& c) { return c.cwiseMax(0.02f).cwiseMin(0.9f); }
inline Vec3x8 Mix(const Vec3x8& a, const Vec3x8& b, Float8 t) { return a + (b - a) * t; }
inline Vec3x8 Albedo(const Vec3x8& c) {
  return {Clamp(c.x, 0.02f, 0.9f), Clamp(c.y, 0.02f, 0.9f), Clamp(c.z, 0.02f, 0.9f)};
}
// Returns the dot product of `axis` and `p` (numbers or duals), summed in the order of Eigen's.
inline auto Along(const Vec3f& axis, const auto& p) {
  return axis.x() * p.x + (axis.y() * p.y + axis.z() * p.z);
}
inline float Float(double x) { return static_cast<float>(x); }
inline float Draw(Rng& rng, double low, double high) { return Float(rng.Uniform(low, high)); }
inline uint32_t DrawSeed(Rng& rng) { return rng.Bits32(); }

// Coordinates in metres on the texture plane nearest to the surface: u is x wherever the surface
// contains the x axis; on the other faces u = y.
struct PlanePoint {
  float u = 0, v = 0;
};
inline PlanePoint OnPlane(const SurfacePoint& point) {
  const bool known = point.texture_normal != Vec3f::Zero();
  const Vec3f n = (known ? point.texture_normal : point.normal).cwiseAbs();
  const Vec3f& p = point.texture_m;
  if (n.z() >= n.x() && n.z() >= n.y()) return {p.x(), p.y()};
  if (n.y() >= n.x()) return {p.x(), p.z()};
  return {p.y(), p.z()};
}

// Eight points whose texture coordinates carry derivatives.
struct ReliefPoint8 {
  using Real = Dual8;

  DualVec8 texture_m;
  Vec3x8 normal, texture_normal;
  Float8 footprint_m;

  ReliefPoint8(const SurfacePoint8& points, const Tangents8& tangents)
      : texture_m{{points.texture_m.x, tangents.texture[0].x, tangents.texture[1].x},
                  {points.texture_m.y, tangents.texture[0].y, tangents.texture[1].y},
                  {points.texture_m.z, tangents.texture[0].z, tangents.texture[1].z}},
        normal(points.normal),
        texture_normal(points.texture_normal),
        footprint_m(points.footprint_m) {}
};

// A material whose relief is one formula, `HeightOf(const auto& point)`, for numbers
// (SurfacePoint8) and for duals (ReliefPoint8), so that its derivatives are exact. It returns
// `Point::Real`.
template <typename Self>
class Carved : public Material {
 public:
  Float8 Height(const SurfacePoint8& points) const final {
    return static_cast<const Self*>(this)->HeightOf(points);
  }
  Dual8 Relief(const SurfacePoint8& points, const Tangents8& tangents) const final {
    return static_cast<const Self*>(this)->HeightOf(ReliefPoint8(points, tangents));
  }

 protected:
  uint32_t seed_ = 0;  // Seed of its noise, which the class draws.
};

// A point on a plane; `Real` is Float8 or Dual8.
template <typename Real>
struct PlaneOf8 {
  Real u, v;
};
using PlanePoint8 = PlaneOf8<Float8>;
// Returns the normal of the face in texture space, or the point's normal where that is unknown.
inline Vec3x8 FaceOf(const auto& points) {
  const Vec3x8& t = points.texture_normal;
  return Select((t.x != 0) | (t.y != 0) | (t.z != 0), t, points.normal);
}
// Returns the plane coordinates of a SurfacePoint8 or ReliefPoint8, along the axes nearest to its
// face.
inline auto OnPlane(const auto& points) {
  const Vec3x8 n = FaceOf(points);
  const auto& p = points.texture_m;
  const Float8 nx = Abs(n.x), ny = Abs(n.y), nz = Abs(n.z);
  const Mask8 along_z = (nz >= nx) & (nz >= ny), along_y = ny >= nx;
  using Real = RealOf<std::remove_cvref_t<decltype(p)>>;
  return PlaneOf8<Real>{Select(along_z | along_y, p.x, p.y), Select(along_z, p.y, p.z)};
}

// Returns the plane's point in space, for three-dimensional noise.
template <typename Real>
auto InPlane(const PlaneOf8<Real>& plane) {
  return VecOf(plane.u, plane.v, Real(Splat(0)));
}

// Returns 0 where `distance` < 0 and 1 where it is > 0, with an edge between them at least as wide
// as `softness` and the footprint.
inline float Edge(float distance, float softness, float footprint) {
  const float width = std::max(softness, footprint);
  if (width <= 0) return distance > 0 ? 1.0f : 0.0f;
  return noise::SmoothStep(-0.5f * width, 0.5f * width, distance);
}

inline Float8 Edge(Float8 distance, float softness, Float8 footprint) {
  const Float8 width = Max(softness, footprint);
  const Float8 one = Splat(1), none = Splat(0);
  const Float8 sharp = distance > 0 ? one : none;
  return width <= 0 ? sharp : noise::SmoothStep(-0.5f * width, 0.5f * width, distance);
}

// Returns the share of a footprint that lies within `half_width` of a line whose middle is
// `distance` away, for seams and gaps of any width. Continuous in all arguments.
inline float LineShare(float distance, float half_width, float softness, float footprint) {
  const float width = std::max(std::max(softness, footprint), 1e-6f);
  const float low = std::max(distance - 0.5f * width, -half_width);
  const float high = std::min(distance + 0.5f * width, half_width);
  return std::max(0.0f, high - low) / width;
}

inline Float8 LineShare(Float8 distance, Float8 half_width, Float8 softness, Float8 footprint) {
  const Float8 width = Max(Max(softness, footprint), 1e-6f);
  const Float8 low = Max(distance - 0.5f * width, -half_width);
  const Float8 high = Min(distance + 0.5f * width, half_width);
  return Max(0.0f, high - low) / width;
}
inline Float8 LineShare(Float8 distance, float half_width, float softness, Float8 footprint) {
  return LineShare(distance, Splat(half_width), Splat(softness), footprint);
}
inline Dual8 LineShare(const Dual8& distance, float half_width, float softness, Float8 footprint) {
  const Float8 value = LineShare(distance.value, half_width, softness, footprint);
  const Float8 width = Max(Max(softness, footprint), 1e-6f), one = Splat(1), none = Splat(0);
  // It grows by what enters at one end and shrinks by what leaves at the other.
  const Float8 low = distance.value - 0.5f * width, high = distance.value + 0.5f * width;
  const Float8 enters = (high < half_width) & (high > -half_width) ? one : none;
  const Float8 leaves = (low < half_width) & (low > -half_width) ? one : none;
  return Chain(distance, value, (enters - leaves) / width);
}

// Makes a catalogue entry whose material is constructed from the stream and `args`.
template <typename M, typename... Args>
MaterialClass Entry(std::string name, std::string family, MaterialTags tags, Args... args) {
  return {std::move(name), std::move(family),
          [args...](Rng& rng) -> std::unique_ptr<const Material> {
            return std::make_unique<M>(rng, args...);
          },
          tags};
}

}  // namespace parallax
