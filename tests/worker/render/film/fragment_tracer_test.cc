#include "worker/render/film/fragment_tracer.h"

#include <gtest/gtest.h>

#include "tests/worker/render/radiance.h"
#include "worker/render/raster/rasteriser.h"

namespace parallax {
namespace {

using test::Build;
using test::Built;
using test::MakeQuad;
using test::TestScene;

// Laths a few pixels wide before coloured walls, a mirror among them, and no ceiling.
TestScene Laths() {
  TestScene test = test::MakeBoxRoom();
  SurfaceSample mirror;
  mirror.base_color = Vec3f::Constant(0.9f);
  mirror.metallic = 1;
  mirror.roughness = 0;
  const uint32_t shiny = test.AddMaterial(mirror);
  const uint32_t pale = test.AddMaterial(test::DiffuseSample(Vec3f(0.8f, 0.6f, 0.4f)));
  for (int i = 0; i < 40; ++i) {
    const float x = -1.6f + 0.08f * static_cast<float>(i);
    test.AddMesh(MakeQuad({x, 1.2f, 0.4f}, {0.03f, 0, 0}, {0.2f, 0, 1.8f}),
                 i % 4 == 0 ? shiny : pale);
  }
  return test;
}

PixelSampling Sampling(uint32_t stream_hash, const VisibilityBuffer& visible) {
  PixelSampling sampling{.stream_hash = stream_hash};
  sampling.visible = &visible;
  return sampling;
}

// The guides of all samples of a pixel, each traced as a ray.
TEST(FragmentTracer, GuidesAreThoseOfAllSamplesOfAPixelForFewRays) {
  const Built built = Build(Laths());
  const PinholeCamera eye = StereoCamera::FromRig(test::BoxRoomRig(48, 32))->eyes[0];
  constexpr uint32_t kStream = 5;
  const VisibilityBuffer visible = Rasteriser::Create(*built.scene)->Draw(eye, kStream, {});
  PathOptions options;
  options.only_guides = true;
  std::vector<PixelAt> pixels;
  for (int i = 0; i < eye.width_px * eye.height_px; ++i) {
    pixels.push_back({i % eye.width_px, i / eye.width_px});
  }
  Film film(eye), wanted(eye);
  FragmentTracer guides(*built.scene, built.lights, options, eye, Sampling(kStream, visible));
  const uint64_t rays_traced = guides.Trace(pixels, {}, &film);

  PathTracer tracer(*built.scene, built.lights, options);
  const CameraRays rays(eye);
  uint64_t rays_wanted = 0;
  double off = 0;
  int far_off = 0;
  for (const PixelAt& at : pixels) {
    PixelSum sum;
    for (int k = 0; k < VisibilityBuffer::kSamples; ++k) {
      Sampler sampler(kStream, static_cast<uint32_t>(at.x), static_cast<uint32_t>(at.y),
                      static_cast<uint32_t>(k));
      const Ray ray = rays.Through(static_cast<float>(at.x) + visible.points().X(at.x, at.y)[k],
                                   static_cast<float>(at.y) + visible.points().Y(at.x, at.y)[k]);
      const PathResult result = tracer.Trace(ray, sampler);
      sum.Add(result);
      rays_wanted += result.rays;
    }
    wanted.AddGuides(at, sum);
    for (int c = 0; c < 3; ++c) {
      const float albedo = std::abs(film.albedo(at.x, at.y, c) - wanted.albedo(at.x, at.y, c));
      const float normal = std::abs(film.normal(at.x, at.y, c) - wanted.normal(at.x, at.y, c));
      off += albedo + normal;
      far_off += std::max(albedo, normal) > 0.02f ? 1 : 0;
    }
  }
  const auto numbers = static_cast<double>(3 * pixels.size());
  EXPECT_LT(off / numbers, 0.01);
  EXPECT_LT(far_off / numbers, 0.1);  // Round things and mirrors are seen at fewer points.
  EXPECT_LT(10 * rays_traced, rays_wanted);
}

// Rays through the same points, each traced alone.
TEST(PixelTracer, PathsThatBeginAtRasterisedTrianglesBringTheLightOfRays) {
  constexpr int kSamples = 4, kLog2 = 2;
  constexpr uint32_t kStream = 5;
  const Built built = Build(Laths());
  const PinholeCamera eye = StereoCamera::FromRig(test::BoxRoomRig(48, 32))->eyes[0];
  const VisibilityBuffer visible = Rasteriser::Create(*built.scene)->Draw(eye, kStream, {});
  std::vector<PixelAt> pixels;
  for (int i = 0; i < eye.width_px * eye.height_px; ++i) {
    pixels.push_back({i % eye.width_px, i / eye.width_px});
  }
  Film film(eye);
  PixelSampling sampling{.stream_hash = kStream, .samples = kSamples, .together = true};
  sampling.visible = &visible;
  PixelTracer pixel_tracer(*built.scene, built.lights, PathOptions(), eye, sampling);
  const uint64_t rays_traced = pixel_tracer.Trace(pixels, {}, &film);

  PathTracer tracer(*built.scene, built.lights, PathOptions());
  const CameraRays rays(eye);
  uint64_t rays_wanted = 0;
  int other = 0;
  for (const PixelAt& at : pixels) {
    PixelSum sum;
    for (int k = 0; k < kSamples; ++k) {
      Sampler sampler =
          Sampler::OfImage(kStream, static_cast<uint32_t>(at.x), static_cast<uint32_t>(at.y), kLog2,
                           static_cast<uint32_t>(k));
      sampler.Pair();  // The place in the pixel.
      const PathResult result =
          tracer.Trace(rays.Through(static_cast<float>(at.x) + visible.points().X(at.x, at.y)[k],
                                    static_cast<float>(at.y) + visible.points().Y(at.x, at.y)[k]),
                       sampler);
      sum.Add(result);
      rays_wanted += result.rays;
    }
    for (int c = 0; c < 3; ++c) {
      const float wanted = sum.color[c] / kSamples;
      other += std::abs(film.color(at.x, at.y, c) - wanted) > 1e-3f * (wanted + 0.01f) ? 1 : 0;
    }
  }
  // Points that lie on edges to rounding.
  EXPECT_LT(other, 0.01 * 3.0 * static_cast<double>(pixels.size()));
  EXPECT_EQ(rays_traced + pixels.size() * kSamples, rays_wanted);
}

TEST(FragmentTracer, ACancelLeavesPixelsAsTheyAre) {
  const Built built = Build(Laths());
  const PinholeCamera eye = StereoCamera::FromRig(test::BoxRoomRig(8, 8))->eyes[0];
  const VisibilityBuffer visible = Rasteriser::Create(*built.scene)->Draw(eye, 5, {});
  FragmentTracer guides(*built.scene, built.lights, PathOptions(), eye, Sampling(5, visible));
  Film film(eye);
  const CancelToken cancel;
  cancel.Cancel();
  EXPECT_EQ(guides.Trace(std::vector<PixelAt>{{1, 1}}, cancel, &film), 0u);
  EXPECT_EQ(film.albedo(1, 1, 0), 0);
}

}  // namespace
}  // namespace parallax
