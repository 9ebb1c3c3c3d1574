// Scenes made by hand for the renderer's tests: quads, spheres, one-line materials, a closed box
// with a lamp.
#pragma once

#include <atomic>
#include <memory>
#include <string>
#include <vector>

#include "common/base/cancel.h"
#include "common/base/system/clock.h"
#include "common/image/image.h"
#include "parallax/v1/scene.pb.h"
#include "worker/geometry/scene_geometry.h"
#include "worker/materials/kernel/material.h"

namespace parallax::test {

// A material that is the same everywhere.
class ConstantMaterial : public PointMaterial {
 public:
  explicit ConstantMaterial(const SurfaceSample& sample) : sample_(sample) {}
  SurfaceSample EvaluatePoint(const SurfacePoint&) const override { return sample_; }

 private:
  SurfaceSample sample_;
};

// Lambert's surface of the given colour: no gloss at all.
SurfaceSample DiffuseSample(const Vec3f& color);

// Grey; cancels from inside of the tracing, at its `looks`-th look at a surface after Arm.
class CancellingMaterial : public PointMaterial {
 public:
  explicit CancellingMaterial(CancelToken cancel) : cancel_(std::move(cancel)) {}
  void Arm(int64_t looks) { left_ = looks; }
  SurfaceSample EvaluatePoint(const SurfacePoint& point) const override;
  SteadyTime asked() const { return asked_; }

 private:
  const CancelToken cancel_;
  mutable std::atomic<int64_t> left_{int64_t{1} << 40};
  mutable SteadyTime asked_;
};

// Geometry and recipe grow together, so that they agree.
struct TestScene {
  v1::Scene recipe;
  SceneGeometry geometry;

  TestScene() { geometry.materials.resize(1); }

  uint32_t AddMaterial(std::shared_ptr<const Material> material);
  uint32_t AddMaterial(const SurfaceSample& sample) {
    return AddMaterial(std::make_shared<ConstantMaterial>(sample));
  }
  // Returns the object index (from 1).
  uint32_t AddMesh(std::shared_ptr<const Mesh> mesh, uint32_t material,
                   const Eigen::Affine3f& world_from_object = Eigen::Affine3f::Identity());
  void AddPointLight(const Vec3d& position, double radius_m, double power_w);
  void AddMeshLight(uint32_t object, double power_w);
};

// RenderScene::Build's: each so-many-th mesh moves; 0: none.
std::vector<bool> MoversOfEvery(int every, const TestScene& test);

// Corner, corner + u, corner + u + v, corner + v; faces u x v. One slot "surface". Texture
// coordinates are metres along u and v.
std::shared_ptr<const Mesh> MakeQuad(const Vec3f& corner, const Vec3f& u, const Vec3f& v);
std::shared_ptr<const Mesh> MakeSphere(const Vec3f& center, float radius, int rings = 48);
// Faces look outwards, or inwards when `inwards`.
std::shared_ptr<const Mesh> MakeBox(const Vec3f& low, const Vec3f& high, bool inwards = false);

// Returns a rig at `position` that looks along `forward` with z up.
v1::Rig MakeRig(const Vec3d& position, const Vec3d& forward, int width_px, int height_px,
                double focal_px, double baseline_m);

// A diffuse square of 10 x 10 m at z = 0, its middle at the origin.
TestScene MakeFloor(float albedo);

// A closed room of 4 x 4 x 3 m with a lamp below the ceiling, two boxes, a ball and coloured walls,
// all diffuse.
TestScene MakeBoxRoom();
v1::Rig BoxRoomRig(int width_px, int height_px);

v1::RenderConfig MakeConfig(int samples, int bounces, bool denoise,
                            const std::string& profile = "reference");

// Mean square of all channels' differences, in squared levels. The pictures have one size.
double MeanSquare(const ImageRgb8& a, const ImageRgb8& b);

}  // namespace parallax::test
