// Eight points of surfaces that paths have reached: light from one direction, and the way on. All
// that needs no memory but what it is given, in lanes.
#pragma once

#include "common/math/lanes.h"
#include "worker/render/bright_spots.h"
#include "worker/render/bsdf.h"
#include "worker/render/lights.h"
#include "worker/render/sampling.h"

namespace parallax {

// Where eight paths met surfaces. World frame.
struct SurfaceInteraction8 {
  Vec3x8 position, out;  // `out`: unit, back along the ray.
  Vec3x8 normal;         // Geometric, on the viewer's side.
  Vec3x8 shading;        // With relief, likewise.
  Mask8 outside;
  SurfaceSample8 surface;
  Vec3x8 throughput;
  // Bright spots' view from here; none where its share is 0.
  SpotView spots[kLanes];
  Float8 spot_share;
  // Random numbers in [0, 1): lobe or spot; the direction.
  Float8 choice, u, v;
  LightSamples8 light;  // Density 0: none.
};

// Light on its way to the eight, should nothing stand between.
struct Shadow8 {
  Mask8 lit;  // Else there is nothing to be traced.
  Vec3x8 origin, direction;
  Float8 distance;      // 0: too short for anything to stand in it.
  Vec3x8 contribution;  // To the path, if nothing weakens it.
};

// The next rays of eight paths, sampled from their BSDFs or towards bright spots.
struct BsdfSample8 {
  Mask8 goes;  // Else the path ends.
  Mask8 straight;
  Mask8 passes;  // To the surface's other side, straight or not.
  Vec3x8 origin, direction;
  Vec3x8 weight;  // Throughput of the path from here on.
  Float8 pdf;     // For MIS.
  Float8 blur;
};

class Scatter8 {
 public:
  // `at` must outlive it.
  explicit Scatter8(const SurfaceInteraction8& at);

  // `weighted`: by MIS; else light sampling stands alone.
  void Light(bool weighted, Shadow8* shadow) const;
  BsdfSample8 SampleBsdf() const;

  const Vec3x8& normal() const { return frame_.z; }  // For shading.
  const Bsdf8& bsdf() const { return bsdf_; }

 private:
  // How much of the light from a direction is admitted: none when shading and true normal see it
  // on different sides (it would leak or blacken), and less near the true horizon, so that the
  // coarse faces of smooth meshes cast no hard edge.
  Float8 Admits(const Vec3x8& world, const Vec3x8& local) const;
  // Density of a direction that is towards a bright spot now and then, else by the BSDF.
  Float8 Mixed(const Vec3x8& world, Float8 by_bsdf) const;

  const SurfaceInteraction8& at_;
  Frame8 frame_;
  Float8 bend2_;  // Sine squared of the angle by which the frame leans away from the true normal.
  Bsdf8 bsdf_;
  Float8 spot_share_;  // None for mirrors.
};

}  // namespace parallax
