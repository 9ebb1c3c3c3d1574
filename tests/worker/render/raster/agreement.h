// How far the rasteriser and Embree agree about what an eye sees.
#pragma once

#include <cmath>

#include "common/base/rng.h"
#include "worker/render/camera/camera_rays.h"
#include "worker/render/raster/rasteriser.h"

namespace parallax::test {

// Numbers of samples.
struct Agreement {
  int samples = 0;
  int same_triangle = 0;
  int same_depth = 0;  // Another triangle, at the same distance to 1e-3 of it.
  int missed = 0;      // Nothing where Embree sees something,
  int invented = 0;    // and the other way round.
  double agreeing() const { return (same_triangle + same_depth) / static_cast<double>(samples); }
};

// Adds `count` random samples of what the camera sees, which are also returned as hits of the
// rasteriser's triangles.
inline void Compare(const RenderScene& scene, const PinholeCamera& camera,
                    const VisibilityBuffer& visible, int count, Rng& rng, Agreement* sum) {
  const CameraRays rays(camera);
  for (int i = 0; i < count; ++i, ++sum->samples) {
    const int x = rng.UniformInt(0, camera.width_px - 1),
              y = rng.UniformInt(0, camera.height_px - 1);
    const int k = rng.UniformInt(0, VisibilityBuffer::kSamples - 1);
    const Ray ray = rays.Through(static_cast<float>(x) + visible.points().X(x, y)[k],
                                 static_cast<float>(y) + visible.points().Y(x, y)[k]);
    RawHit wanted;
    const bool met = scene.trees().Intersect(RayTrees::Tree::kRobust, ray, 0, &wanted);
    const uint32_t id = visible.Ids(x, y)[k];
    if (id == VisibilityBuffer::kNothing) {
      (met ? sum->missed : sum->same_triangle) += 1;
      continue;
    }
    if (!met) {
      ++sum->invented;
      continue;
    }
    const SeenTriangle seen = visible.TriangleOf(id);
    if (seen.body == wanted.placed && seen.triangle == wanted.triangle) {
      ++sum->same_triangle;
      continue;
    }
    Hits8 hits;
    hits.met = FirstLanes(1);
    hits.placed[0] = static_cast<int32_t>(seen.body);
    hits.triangle[0] = static_cast<int32_t>(seen.triangle);
    scene.HitTriangles({Vec3x8(ray.origin), Vec3x8(ray.direction)}, &hits);
    sum->same_depth += std::abs(hits.distance[0] - wanted.distance) <= 1e-3f * wanted.distance;
  }
}

}  // namespace parallax::test
