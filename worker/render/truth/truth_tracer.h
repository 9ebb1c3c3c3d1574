// Exact hits of lines of sight: the surfaces at pixel centres, and those behind what is
// see-through. Private to worker/render/truth. Constant; thread-safe.
#pragma once

#include <array>
#include <span>

#include "worker/render/camera/camera.h"
#include "worker/render/camera/stereo_frame.h"
#include "worker/render/scene/render_scene.h"
#include "worker/render/truth/ground_truth.h"

namespace parallax {

// A surface on a pixel's line.
struct PixelTruth {
  bool surface = false;  // False: none there.
  double depth = 0;
  Vec3f normal = Vec3f::Zero();  // Camera frame.
  uint32_t object = 0;
  uint32_t material = 0;
  uint8_t mask = 0;
  Clearness clear = Clearness::kOpaque;
};

// Where a pixel's line meets a surface.
struct SurfaceHit {
  Ray ray;
  Vec3d in_world = Vec3d::UnitZ();  // Along the line, as long as PinholeCamera::DirectionAt's.
  RawHit raw;
  SurfaceId id;
};

// Traces from one camera, by the robust tree.
class TruthTracer {
 public:
  static constexpr int kRun = kLanes;

  TruthTracer(const RenderScene& scene, const PinholeCamera& camera)
      : scene_(scene), surroundings_(scene.geometry().surroundings), camera_(camera) {}

  // Sets the first surfaces of up to kRun pixels of a row, from `x` on, and where they are met.
  void At(int x, int y, int count, PixelTruth* truths, std::array<SurfaceHit, kRun>* hits) const;
  // Moves on to the next surface behind `hit`, holes left out. Returns it without its normal.
  PixelTruth Behind(SurfaceHit* hit) const;
  // Does what LookAt does.
  void Judge(std::span<Sight> sights) const;

 private:
  static constexpr RayTrees::Tree kTree = RayTrees::Tree::kRobust;

  // Finds the surface seen, through holes. `raw`: the first hit, if the ray `met` anything; then
  // the surface's.
  PixelTruth Look(const Ray& ray, bool met, RawHit* raw, SurfaceId* id) const;
  // Fills in the rest of a surface but its normal.
  void Measure(const SurfaceHit& hit, PixelTruth* truth) const;
  Vec3f NormalOf(const SurfaceHit& hit, const Vec3f& shading_normal) const;

  const RenderScene& scene_;
  const Surroundings& surroundings_;
  const PinholeCamera& camera_;
};

}  // namespace parallax
