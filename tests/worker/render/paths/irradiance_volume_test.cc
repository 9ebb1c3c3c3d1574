// The irradiance volume: closed forms, sparse cells, determinism, and pictures of open land with
// it.
#include "worker/render/paths/irradiance_volume.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cstring>

#include "common/base/rng.h"
#include "tests/worker/render/radiance.h"
#include "tests/worker/render/render_frame.h"
#include "worker/render/camera/camera_rays.h"
#include "worker/render/paths/volume_fill.h"
#include "worker/render/renderer.h"
#include "worker/render/surface/sampling.h"

namespace parallax {
namespace {

using test::Built;
using test::DiffuseSample;
using test::MakeConfig;
using test::MakeQuad;
using test::MakeRig;
using test::TestScene;

CacheGrid Grid(float cell_m) { return {Box3f(Vec3f::Zero(), Vec3f::Zero()), cell_m}; }

// Records of evenly spread directions at a place, of the radiance that `light` gives them.
template <typename Light>
void AddRecords(const Vec3f& position, int count, Light light, VolumeBuilder* builder) {
  std::vector<VolumeBuilder::Batch> batches(1);
  for (int i = 0; i < count; ++i) {
    Sampler sampler(3, 0, 0, static_cast<uint32_t>(i));
    const Vec2f u = sampler.Pair();
    const Vec3f direction = DirectionAt(1 - 2 * u.x(), 2 * kPi * u.y());
    builder->Put({position, direction, light(direction)}, &batches[0]);
  }
  builder->Add(batches);
}

IncomingLight8 At(const IrradianceVolume& volume, const Vec3f& position) {
  return volume.At(Vec3x8(position), Vec3x8::Zero(), ~Mask8{});
}

TEST(IrradianceVolume, EvenLightGivesItsClosedForm) {
  VolumeBuilder builder(Grid(0.1f), 1000);
  const Vec3f radiance(1, 2, 4);
  AddRecords(
      {1, 2, 3}, 4096, [&](const Vec3f&) { return radiance; }, &builder);
  const IrradianceVolume volume = builder.Freeze();
  EXPECT_EQ(volume.cells(), 3u);
  const IncomingLight8 light = At(volume, {1.001f, 2.001f, 3.001f});
  ASSERT_EQ(BitsOf(light.known), 0xffu);
  for (const Vec3f& normal : {Vec3f(0, 0, 1), Vec3f(0, 0, -1), Vec3f(0.6f, -0.8f, 0)}) {
    const Vec3f irradiance = light.Irradiance(Vec3x8(normal)).Get(3);
    const Vec3f about = light.RadianceAbout(Vec3x8(normal)).Get(5);
    for (int c = 0; c < 3; ++c) {
      EXPECT_NEAR(irradiance[c] / (kPi * radiance[c]), 1, 0.01);
      EXPECT_NEAR(about[c] / radiance[c], 1, 0.01);
    }
  }
}

TEST(IrradianceVolume, SurfacesBelowABrightSkyAreDarkOnTheirLowerSide) {
  VolumeBuilder builder(Grid(0.1f), 1000);
  AddRecords(
      {0, 0, 0}, 4096,
      [](const Vec3f& direction) { return Vec3f(Vec3f::Constant(direction.z() > 0 ? 1 : 0)); },
      &builder);
  const IncomingLight8 light = At(builder.Freeze(), Vec3f::Zero());
  EXPECT_NEAR(light.Irradiance(Vec3x8(Vec3f(0, 0, 1))).Get(0).y(), kPi, 0.07);
  EXPECT_NEAR(light.Irradiance(Vec3x8(Vec3f(1, 0, 0))).Get(0).y(), kPi / 2, 0.05);
  EXPECT_LT(light.Irradiance(Vec3x8(Vec3f(0, 0, -1))).Get(0).y(), 0.1);
  EXPECT_GE(light.Irradiance(Vec3x8(Vec3f(0, 0, -1))).Get(0).y(), 0);
}

TEST(IrradianceVolume, CellsOfFewRecordsLeanOnTheirParents) {
  VolumeBuilder builder(Grid(0.1f), 1000);
  const auto even = [](float value) {
    return [value](const Vec3f&) { return Vec3f(Vec3f::Constant(value)); };
  };
  // Cells of one parent: the grid is shifted by less than a cell.
  AddRecords({0.05f, 0.05f, 0.05f}, 1000, even(1), &builder);
  AddRecords({0.15f, 0.05f, 0.05f}, 4, even(0), &builder);
  const IrradianceVolume volume = builder.Freeze();
  const auto irradiance = [&](const Vec3f& at) {
    return At(volume, at).Irradiance(Vec3x8(Vec3f(0, 0, 1))).Get(0).x() / kPi;
  };
  EXPECT_NEAR(irradiance({0.05f, 0.05f, 0.05f}), 1, 0.02);
  EXPECT_NEAR(irradiance({0.15f, 0.05f, 0.05f}), 16.0 / 20, 0.03);
  EXPECT_NEAR(irradiance({0.25f, 0.05f, 0.05f}), 1, 0.02);  // The parent's own.
  EXPECT_EQ(BitsOf(At(volume, {3, 3, 3}).known), 0u);
}

VolumeFill SmallFill(int64_t looks, float cell_m) {
  VolumeFill fill;
  fill.looks = looks;
  fill.cell_m = cell_m;
  return fill;
}

// A scene ready to trace, with a volume filled from its rigs.
struct Lit {
  Built built;
  PathOptions options;
  std::vector<StereoCamera> cameras;
  IrradianceVolume volume;

  Lit(const TestScene& test, const VolumeFill& fill) : built(Build(test)) {
    options.max_bounces = 16;
    for (const v1::Rig& rig : test.recipe.rigs()) cameras.push_back(*StereoCamera::FromRig(rig));
    PathOptions filling = options;
    filling.direct = DirectLight::kSunByLightSampling;
    volume = *FillIrradianceVolume(*built.scene, built.lights, filling, 7, cameras, fill, {});
  }

  // Mean radiance over the first left picture, by `samples` paths.
  Vec3f Mean(int samples, bool with_volume, double* rays) const {
    PathOptions how = options;
    if (with_volume) how.volume = &volume;
    if (with_volume) how.direct = DirectLight::kSunByLightSampling;
    const PinholeCamera& camera = cameras[0].eyes[0];
    const CameraRays through(camera);
    PathTracer tracer(*built.scene, built.lights, how);
    Vec3d sum = Vec3d::Zero();
    for (int i = 0; i < samples; ++i) {
      Sampler sampler(with_volume ? 11 : 12, 0, 0, static_cast<uint32_t>(i));
      const Vec2f at = sampler.Pair();
      const PathResult path =
          tracer.Trace(through.Through(at.x() * static_cast<float>(camera.width_px),
                                       at.y() * static_cast<float>(camera.height_px)),
                       sampler);
      sum += path.radiance.cast<double>();
      *rays += path.rays;
    }
    return (sum / samples).cast<float>();
  }
};

// Bare ground below the sky receives the same everywhere; cells differ by their noise alone: by
// 0.003, and by 0.027 where each look draws its directions for itself.
TEST(IrradianceVolume, TheRaysOfACellCoverAllDirectionsEvenly) {
  TestScene test;
  test.AddMesh(MakeQuad({-8, -8, 0}, {16, 0, 0}, {0, 16, 0}),
               test.AddMaterial(DiffuseSample(Vec3f::Constant(0.3f))));
  test.recipe.mutable_sky()->set_strength(1);
  *test.recipe.add_rigs() = MakeRig({0, -3, 3}, {0, 1, -1.5}, 96, 64, 80, 0.1);
  const Lit lit(test, SmallFill(4000, 0.5f));
  double sum = 0, squares = 0, count = 0;
  for (float x = -1; x <= 1; x += 0.5f) {
    for (float y = -2; y <= 0; y += 0.5f) {
      const IncomingLight8 light = At(lit.volume, {x, y, 0.01f});
      ASSERT_TRUE(Any(light.known));
      const double up = light.Irradiance(Vec3x8(Vec3f(0, 0, 1))).Get(0).y();
      sum += up;
      squares += up * up;
      ++count;
    }
  }
  const double mean = sum / count;
  EXPECT_LT(std::sqrt(squares / count - mean * mean) / mean, 0.01);
}

// A closed box of 2 m whose walls shine: lamps are sampled, all else is in the volume.
TEST(IrradianceVolume, AShiningFurnaceHasTheRadianceOfItsClosedForm) {
  constexpr double kAlbedo = 0.6, kPower = 240;
  TestScene test;
  const uint32_t box =
      test.AddMesh(test::MakeBox({0, 0, 0}, {2, 2, 2}, true),
                   test.AddMaterial(DiffuseSample(Vec3f::Constant(static_cast<float>(kAlbedo)))));
  test.AddMeshLight(box, kPower);
  *test.recipe.add_rigs() = MakeRig({1, 0.3, 1}, {0.1, 1, 0.05}, 64, 48, 30, 0.1);
  const Lit lit(test, SmallFill(8000, 0.2f));
  double rays = 0;
  EXPECT_NEAR(lit.Mean(8000, true, &rays).x() / (kPower / (M_PI * 24) / (1 - kAlbedo)), 1, 0.02);
}

// Ground, a pool, and leaves in a swarm above it, under a clear sky.
TestScene Swarm() {
  TestScene test;
  test.AddMesh(MakeQuad({-8, -8, 0}, {16, 0, 0}, {0, 16, 0}),
               test.AddMaterial(DiffuseSample(Vec3f(0.35f, 0.3f, 0.2f))));
  SurfaceSample water = DiffuseSample(Vec3f(0.02f, 0.04f, 0.05f));
  water.roughness = 0.05f;
  water.specular = 0.5f;
  test.AddMesh(MakeQuad({-1, 0, 0.02f}, {2, 0, 0}, {0, 1, 0}), test.AddMaterial(water));
  SurfaceSample green = DiffuseSample(Vec3f(0.1f, 0.3f, 0.05f));
  green.transmitted_color = Vec3f(0.1f, 0.25f, 0.05f);
  const uint32_t leaf = test.AddMaterial(green);
  auto mesh = std::make_shared<Mesh>(*MakeQuad({-0.1f, -0.1f, 0}, {0.2f, 0, 0}, {0, 0.2f, 0}));
  mesh->slots[0].sheet = true;
  test.geometry.prototypes.push_back({mesh, {leaf}});
  Rng rng(SceneSeed{1}, "leaves");
  for (int i = 0; i < 500; ++i) {
    const auto draw = [&](double low, double high) {
      return static_cast<float>(rng.Uniform(low, high));
    };
    Eigen::Affine3f place(Eigen::Translation3f(draw(-1.5, 1.5), draw(1, 4), draw(0.3, 2)));
    place.rotate(Eigen::AngleAxisf(draw(0, 6), Vec3f(draw(-1, 1), draw(-1, 1), 1).normalized()));
    test.geometry.instances.push_back({place.matrix().topRows<3>(), 0, 1});
  }
  test.recipe.mutable_sky()->set_strength(1);
  test.recipe.mutable_sky()->set_sun_strength(1);
  test.recipe.mutable_sky()->set_sun_elevation_rad(0.8);
  *test.recipe.add_rigs() = MakeRig({0, -3, 1.2}, {0, 1, -0.1}, 96, 64, 80, 0.1);
  *test.recipe.add_rigs() = MakeRig({0.5, -3, 1.4}, {-0.1, 1, -0.15}, 96, 64, 80, 0.1);
  return test;
}

TEST(IrradianceVolume, GivesTheLightOfOpenLandThatPathsGive) {
  const Lit lit(Swarm(), SmallFill(20000, 0.1f));
  constexpr int kSamples = 20000;
  double rays = 0, rays_without = 0;
  const Vec3f with = lit.Mean(kSamples, true, &rays);
  const Vec3f without = lit.Mean(kSamples, false, &rays_without);
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(with[c] / without[c], 1, 0.03) << "channel " << c;
  EXPECT_LT(rays, 2.0 * kSamples);  // One from the eye and one to the sun, less what sees sky.
  EXPECT_LT(rays, 0.8 * rays_without);
}

TEST(IrradianceVolume, DoesNotDependOnTheNumberOfThreads) {
  std::vector<IncomingLight8> seen;
  for (const size_t threads : {1, 2, 5}) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
    const Lit lit(Swarm(), SmallFill(6000, 0.2f));
    seen.push_back(At(lit.volume, {0.3f, 0.5f, 0.05f}));
    ASSERT_TRUE(Any(seen.back().known));
  }
  for (size_t i = 1; i < seen.size(); ++i) {
    EXPECT_EQ(std::memcmp(&seen[0].terms, &seen[i].terms, sizeof(seen[0].terms)), 0);
  }
}

TEST(IrradianceVolume, ACancelEndsItsFill) {
  const Built built = Build(Swarm());
  CancelToken cancel;
  cancel.Cancel();
  const std::vector<StereoCamera> rigs = {*StereoCamera::FromRig(Swarm().recipe.rigs(0))};
  EXPECT_TRUE(absl::IsCancelled(
      FillIrradianceVolume(*built.scene, built.lights, {}, 1, rigs, SmallFill(4000, 0.2f), cancel)
          .status()));
}

// The right rig alone, after the left one, and on other threads.
TEST(IrradianceVolume, PicturesOfOpenLandDoNotDependOnThreadsOrOrderOfRigs) {
  const TestScene test = Swarm();
  const v1::RenderConfig config = MakeConfig(2, 4, false, "preview");
  const v1::Rig& rig = test.recipe.rigs(1);
  StereoFrame alone, after;
  {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, 1);
    alone = test::RenderFrame(test, config, rig);
  }
  auto renderer = *Renderer::Create(test.recipe, test.geometry, config);
  ASSERT_TRUE(renderer->RenderRig(test.recipe.rigs(0), {}, {}).ok());
  after = *renderer->RenderRig(rig, {}, {});
  EXPECT_EQ(alone.left.color, after.left.color);
  EXPECT_EQ(alone.right.color, after.right.color);
  EXPECT_EQ(alone.left.masks, after.left.masks);
}

// Against many samples of the unbiased profile.
TEST(IrradianceVolume, PicturesOfOpenLandAreNearTheReference) {
  const TestScene test = Swarm();
  const v1::Rig& rig = test.recipe.rigs(0);
  const StereoFrame fast = test::RenderFrame(test, MakeConfig(4, 6, false, "default"), rig);
  const StereoFrame wanted = test::RenderFrame(test, MakeConfig(256, 16, false), rig);
  EXPECT_LT(test::MeanSquare(fast.left.color, wanted.left.color), 8 * 8);
  EXPECT_NEAR(fast.exposure / wanted.exposure, 1, 0.04);
  EXPECT_EQ(fast.left.depth_m, wanted.left.depth_m);
}

}  // namespace
}  // namespace parallax
