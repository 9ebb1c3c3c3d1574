// Scattering at eight surface points that paths have reached: direct light from one sample, and the
// next ray. Works in lanes and reads no memory besides its arguments.
#pragma once

#include "common/math/lanes.h"
#include "worker/render/lights/bright_spots.h"
#include "worker/render/lights/light_sampler.h"
#include "worker/render/surface/bsdf.h"
#include "worker/render/surface/sampling.h"

namespace parallax {

// The surface interactions of eight paths. World frame.
struct SurfaceInteraction8 {
  Vec3x8 position, out;  // `out`: unit, back along the ray.
  Vec3x8 normal;         // Geometric, on the viewer's side.
  Vec3x8 shading;        // With relief, on the same side.
  Mask8 outside;
  SurfaceSample8 surface;
  Vec3x8 throughput;
  // The bright spots as seen from here; unset where `spot_share` is 0.
  SpotView spots[kLanes];
  Float8 spot_share;
  // Random numbers in [0, 1): lobe or spot; the direction.
  Float8 choice, u, v;
  LightSamples8 light;  // Density 0: none.
};

// Light on its way to eight points, to be added if nothing is in between.
struct Shadow8 {
  Mask8 lit;  // Lanes with a ray to trace.
  Vec3x8 origin, direction;
  Float8 distance;      // 0: too short for anything to be in between.
  Vec3x8 contribution;  // To the path, if nothing weakens it.
};

// The next rays of eight paths, sampled from their BSDFs or towards bright spots.
struct BsdfSample8 {
  Mask8 goes;  // Lanes whose path goes on.
  Mask8 straight;
  Mask8 passes;  // The ray continues on the other side.
  Vec3x8 origin, direction;
  Vec3x8 weight;  // Throughput of the path from here on.
  Float8 pdf;     // For MIS.
  Float8 blur;
};

// Light and next rays of eight interactions.
class Scatter8 {
 public:
  // `at` must outlive it.
  explicit Scatter8(const SurfaceInteraction8& at);

  // Makes the shadow rays of the light samples. `weighted`: by MIS; else light sampling stands
  // alone.
  void Light(bool weighted, Shadow8* shadow) const;
  // Samples the next rays.
  BsdfSample8 SampleBsdf() const;

  const Vec3x8& normal() const { return frame_.z; }  // Shading normal.
  const Bsdf8& bsdf() const { return bsdf_; }

 private:
  // Share of the light from a direction that is admitted: none when shading and true normal lie on
  // different sides of it (light would leak or blacken), and less near the true horizon, so that
  // the coarse faces of smooth meshes cast no hard edge.
  Float8 Admits(const Vec3x8& world, const Vec3x8& local) const;
  // Density of the mixture of bright spots and BSDF.
  Float8 Mixed(const Vec3x8& world, Float8 by_bsdf) const;

  const SurfaceInteraction8& at_;
  Frame8 frame_;
  Float8 bend2_;  // Sine squared of the angle by which the frame leans away from the true normal.
  Bsdf8 bsdf_;
  Float8 spot_share_;  // 0 for mirrors.
};

}  // namespace parallax
