// Whole pictures: determinism, noise, denoising, stereo consistency, cancelling, errors.
#include "worker/render/renderer.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <atomic>
#include <cmath>

#include "common/base/rng.h"
#include "common/base/system/clock.h"
#include "common/base/system/memory_budget.h"
#include "tests/worker/render/render_frame.h"
#include "worker/render/film/exposure.h"
#include "worker/render/film/film.h"
#include "worker/render/paths/profiles.h"
#include "worker/render/scene/render_scene.h"
#include "worker/render/surface/sampling.h"

namespace parallax {
namespace {

using test::BoxRoomRig;
using test::DiffuseSample;
using test::MakeBoxRoom;
using test::MakeConfig;
using test::MakeQuad;
using test::MakeRig;
using test::MakeSphere;
using test::MeanSquare;
using test::TestScene;

StereoFrame RenderBoxRoom(const v1::RenderConfig& config, const v1::Rig& rig,
                          uint64_t scene_seed = 1) {
  TestScene test = MakeBoxRoom();
  test.recipe.set_scene_seed(scene_seed);
  return test::RenderFrame(test, config, rig);
}

TEST(Renderer, ImagesDoNotDependOnTheNumberOfThreads) {
  std::vector<StereoFrame> frames;
  for (const size_t threads : {1, 2, 5}) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
    frames.push_back(RenderBoxRoom(MakeConfig(2, 3, false, "default"), BoxRoomRig(100, 70)));
  }
  for (size_t i = 1; i < frames.size(); ++i) {
    EXPECT_EQ(frames[0].left.color, frames[i].left.color);
    EXPECT_EQ(frames[0].right.color, frames[i].right.color);
    EXPECT_EQ(frames[0].left.depth_m, frames[i].left.depth_m);
    EXPECT_EQ(frames[0].right.normals, frames[i].right.normals);
    EXPECT_EQ(frames[0].right.occlusion, frames[i].right.occlusion);
    EXPECT_EQ(frames[0].exposure, frames[i].exposure);
  }
}

TEST(Renderer, GroundTruthDoesNotDependOnTheProfile) {
  const StereoFrame a = RenderBoxRoom(MakeConfig(1, 1, false), BoxRoomRig(64, 48));
  const StereoFrame b = RenderBoxRoom(MakeConfig(3, 4, true, "preview"), BoxRoomRig(64, 48), 2);
  EXPECT_EQ(a.left.depth_m, b.left.depth_m);
  EXPECT_EQ(a.left.disparity_px, b.left.disparity_px);
  EXPECT_EQ(a.left.objects, b.left.objects);
  EXPECT_EQ(a.right.occlusion, b.right.occlusion);
}

// Signed noise of one eye: 1 sample against many, grey.
std::vector<double> Noise(const ImageRgb8& noisy, const ImageRgb8& clean) {
  std::vector<double> noise;
  for (size_t i = 0; i < clean.pixels(); ++i) {
    noise.push_back(static_cast<double>(noisy.values()[3 * i + 1]) - clean.values()[3 * i + 1]);
  }
  return noise;
}

TEST(Renderer, NoiseOfTheTwoEyesIsIndependent) {
  // Eyes a hair apart see the same picture: with shared random numbers their noise would be the
  // same too.
  v1::Rig rig = BoxRoomRig(160, 120);
  rig.set_baseline_m(1e-6);
  const StereoFrame clean = RenderBoxRoom(MakeConfig(48, 4, true), rig);
  const StereoFrame noisy = RenderBoxRoom(MakeConfig(2, 4, false), rig);
  const std::vector<double> a = Noise(noisy.left.color, clean.left.color);
  const std::vector<double> b = Noise(noisy.right.color, clean.right.color);
  double ab = 0, aa = 0, bb = 0, ma = 0, mb = 0;
  for (size_t i = 0; i < a.size(); ++i) ma += a[i], mb += b[i];
  ma /= static_cast<double>(a.size()), mb /= static_cast<double>(b.size());
  for (size_t i = 0; i < a.size(); ++i) {
    ab += (a[i] - ma) * (b[i] - mb), aa += (a[i] - ma) * (a[i] - ma),
        bb += (b[i] - mb) * (b[i] - mb);
  }
  EXPECT_GT(aa / static_cast<double>(a.size()), 25);  // There is noise.
  // Both have strong noise at the same places (its size, not its sign), so a little correlation of
  // the tails is left.
  EXPECT_LT(std::abs(ab / std::sqrt(aa * bb)), 0.1);
}

TEST(Renderer, DenoisingBringsTheImageNearerToTheReference) {
  const v1::Rig rig = BoxRoomRig(128, 96);
  const StereoFrame reference = RenderBoxRoom(MakeConfig(256, 6, false), rig);
  const StereoFrame raw = RenderBoxRoom(MakeConfig(8, 6, false), rig);
  const StereoFrame denoised = RenderBoxRoom(MakeConfig(8, 6, true), rig);
  EXPECT_LT(MeanSquare(denoised.left.color, reference.left.color),
            0.2 * MeanSquare(raw.left.color, reference.left.color));
}

TEST(Renderer, RightImageWarpedByDisparityIsTheLeftImage) {
  const StereoFrame frame = RenderBoxRoom(MakeConfig(256, 4, false), BoxRoomRig(200, 150));
  std::vector<double> differences;
  for (int y = 0; y < 150; ++y) {
    for (int x = 0; x < 200; ++x) {
      if (frame.left.occlusion(x, y) != 0) continue;
      const double at = x - static_cast<double>(frame.left.disparity_px(x, y));
      const int x0 = std::clamp(static_cast<int>(std::floor(at)), 0, 198);
      const double t = std::clamp(at - x0, 0.0, 1.0);
      for (int c = 0; c < 3; ++c) {
        const double right =
            (1 - t) * frame.right.color(x0, y, c) + t * frame.right.color(x0 + 1, y, c);
        differences.push_back(std::abs(frame.left.color(x, y, c) - right));
      }
    }
  }
  ASSERT_GT(differences.size(), 40000u);
  std::nth_element(differences.begin(),
                   differences.begin() + static_cast<long>(differences.size() / 2),
                   differences.end());
  const double median = differences[differences.size() / 2];
  RecordProperty("median_abs_difference", std::to_string(median));
  EXPECT_LT(median, 2.0);
}

TEST(Renderer, ProgressRisesToOne) {
  TestScene test = MakeBoxRoom();
  auto renderer = Renderer::Create(test.recipe, test.geometry, MakeConfig(1, 1, false));
  ASSERT_TRUE(renderer.ok());
  std::atomic<int> calls{0};
  std::atomic<double> highest{0};
  const auto frame = (*renderer)->RenderRig(BoxRoomRig(64, 48), {}, [&](double fraction) {
    ++calls;
    EXPECT_GE(fraction, 0.0);
    EXPECT_LE(fraction, 1.0);
    if (fraction > highest) highest = fraction;
  });
  ASSERT_TRUE(frame.ok());
  EXPECT_GT(calls, 5);
  EXPECT_EQ(highest, 1.0);
}

TEST(Renderer, CancelEndsARenderWithinASecond) {
  TestScene test = MakeBoxRoom();
  const CancelToken cancel;
  const auto material = std::make_shared<test::CancellingMaterial>(cancel);
  test.geometry.meshes[0].material_of_slot[0] = test.AddMaterial(material);  // The floor.
  // Minutes of work, if nobody stopped it.
  auto renderer = Renderer::Create(test.recipe, test.geometry, MakeConfig(20000, 8, false));
  ASSERT_TRUE(renderer.ok());
  material->Arm(1000);
  const auto frame = (*renderer)->RenderRig(BoxRoomRig(160, 120), cancel, {});
  EXPECT_EQ(frame.status().code(), absl::StatusCode::kCancelled);
  ASSERT_TRUE(cancel.cancelled());
  EXPECT_LT(std::chrono::duration<double>(Clock::System().Steady() - material->asked()).count(),
            1.0);
}

TEST(Renderer, UnknownProfileAndBrokenScenesAreRefused) {
  TestScene test = MakeBoxRoom();
  v1::RenderConfig config;
  config.set_profile("best");
  EXPECT_EQ(Renderer::Create(test.recipe, test.geometry, config).status().code(),
            absl::StatusCode::kInvalidArgument);
  test.geometry.meshes[0].material_of_slot[0] = 99;
  EXPECT_EQ(Renderer::Create(test.recipe, test.geometry, {}).status().code(),
            absl::StatusCode::kInvalidArgument);
}

TEST(Renderer, MoreRightEyesOfALeftOneThanAFilmCountsAreRefused) {
  TestScene test = MakeBoxRoom();
  test.recipe.clear_rigs();
  for (int i = 0; i < kMostPartners; ++i) {
    v1::Rig& rig = *test.recipe.add_rigs();
    rig = BoxRoomRig(16, 12);
    rig.set_index(static_cast<uint32_t>(i));
    rig.set_shares_left(i > 0);
  }
  const v1::RenderConfig config = MakeConfig(1, 1, false);
  EXPECT_TRUE(Renderer::Create(test.recipe, test.geometry, config).ok());
  const v1::Rig another = test.recipe.rigs(1);
  *test.recipe.add_rigs() = another;
  EXPECT_EQ(Renderer::Create(test.recipe, test.geometry, config).status().code(),
            absl::StatusCode::kInvalidArgument);
}

TEST(Renderer, TooLittleMemoryIsAnErrorNotACrash) {
  TestScene test;
  test.AddMesh(MakeSphere({0, 0, 0}, 1, 150), test.AddMaterial(DiffuseSample(Vec3f::Ones())));
  EXPECT_EQ(RenderScene::Build(test.geometry, 1 << 20).status().code(),
            absl::StatusCode::kResourceExhausted);
  EXPECT_TRUE(RenderScene::Build(test.geometry, 0).ok());
}

TEST(Renderer, ScenesAndImagesBeyondTheLimitFailAloneAndByName) {
  struct Limit {  // Back to the machine's at the end, however the test ends.
    explicit Limit(int64_t mb) { SetMemoryLimit(mb << 20); }
    ~Limit() { SetMemoryLimit(0); }
  } const limit(2000);
  TestScene test = MakeBoxRoom();
  auto renderer = Renderer::Create(test.recipe, test.geometry, MakeConfig(1, 1, false));
  ASSERT_TRUE(renderer.ok()) << renderer.status();
  v1::Rig rig = BoxRoomRig(8192, 8192);
  rig.set_index(7);
  const auto frame = (*renderer)->RenderRig(rig, {}, {});
  EXPECT_EQ(frame.status().code(), absl::StatusCode::kResourceExhausted);
  EXPECT_NE(std::string(frame.status().message()).find("rig 7"), std::string::npos);
  // The same renderer goes on.
  EXPECT_TRUE((*renderer)->RenderRig(BoxRoomRig(32, 24), {}, {}).ok());
  SetMemoryLimit(1);
  EXPECT_EQ(Renderer::Create(test.recipe, test.geometry, {}).status().code(),
            absl::StatusCode::kResourceExhausted);
}

// One tree holds every copy of a mesh; instances would share it.
TEST(Renderer, CopiesOfASharedMeshCountBeforeTheyAreMade) {
  TestScene test;
  const uint32_t white = test.AddMaterial(DiffuseSample(Vec3f::Ones()));
  const auto sphere = MakeSphere({0, 0, 0}, 1, 100);
  const auto per_copy = static_cast<int64_t>(sphere->triangles.size());
  const int64_t copies = 2'900'000 / per_copy;
  for (int64_t i = 0; i < copies; ++i) {
    test.AddMesh(sphere, white,
                 Eigen::Affine3f(Eigen::Translation3f(static_cast<float>(3 * i), 0, 0)));
  }
  struct Limit {
    explicit Limit(int64_t bytes) { SetMemoryLimit(bytes); }
    ~Limit() { SetMemoryLimit(0); }
  } const limit(ResidentMemory() + (int64_t{100} << 20));
  const absl::Status all = RenderScene::Build(test.geometry, 0).status();
  EXPECT_EQ(all.code(), absl::StatusCode::kResourceExhausted);
  EXPECT_NE(std::string(all.message()).find(std::to_string(copies * per_copy) + " triangles"),
            std::string::npos)
      << all;
  test.geometry.meshes.resize(2);
  EXPECT_TRUE(RenderScene::Build(test.geometry, 0).ok());
}

// Fine far detail: the texture is filtered by the ray's footprint, so that the same place looks
// alike to both eyes although their pixels fall differently on it.
TEST(Renderer, FarDetailDoesNotShimmerBetweenTheEyes) {
  class Stripes : public PointMaterial {
   public:
    explicit Stripes(bool filtered) : filtered_(filtered) {}
    SurfaceSample EvaluatePoint(const SurfacePoint& point) const override {
      constexpr float kPeriod_m = 0.011f;
      const float phase = point.texture_m.x() / kPeriod_m;
      const float stripe = phase - std::floor(phase) < 0.5f ? 0.9f : 0.1f;
      // Gone where a ray is wider than a stripe.
      const float seen =
          filtered_ ? std::clamp(2.0f - 2.0f * point.footprint_m / kPeriod_m, 0.0f, 1.0f) : 1.0f;
      return DiffuseSample(Vec3f::Constant(0.5f + seen * (stripe - 0.5f)));
    }

   private:
    bool filtered_;
  };
  const auto difference = [](bool filtered) {
    TestScene test;
    test.AddMesh(MakeQuad({-8, 6, -8}, {16, 0, 0}, {0, 0, 16}),
                 test.AddMaterial(std::make_shared<Stripes>(filtered)));
    test.AddPointLight({0, 0, 0}, 0, 2000);  // Without noise.
    auto renderer = *Renderer::Create(test.recipe, test.geometry, MakeConfig(4, 1, false));
    const StereoFrame frame =
        *renderer->RenderRig(MakeRig({0, 0, 0}, {0, 1, 0}, 160, 90, 150, 0.137), {}, {});
    double sum = 0;
    int count = 0;
    for (int y = 0; y < 90; ++y) {
      for (int x = 8; x < 160; ++x) {
        const float at = static_cast<float>(x) - frame.left.disparity_px(x, y);
        const int x0 = static_cast<int>(std::floor(at));
        if (x0 < 0 || x0 + 1 >= 160) continue;
        const float t = at - static_cast<float>(x0);
        const float right = (1 - t) * static_cast<float>(frame.right.color(x0, y, 1)) +
                            t * static_cast<float>(frame.right.color(x0 + 1, y, 1));
        sum += Square(right - static_cast<float>(frame.left.color(x, y, 1)));
        ++count;
      }
    }
    return std::sqrt(sum / count);
  };
  const double filtered = difference(true), raw = difference(false);  // Levels of 255.
  EXPECT_LT(filtered, 1);
  EXPECT_GT(raw, 20);
}

TEST(Renderer, AnEmptySceneIsSky) {
  v1::Scene recipe;
  recipe.mutable_sky()->set_strength(1);
  auto renderer = Renderer::Create(recipe, {}, MakeConfig(2, 2, true));
  ASSERT_TRUE(renderer.ok()) << renderer.status();
  const auto frame = (*renderer)->RenderRig(BoxRoomRig(64, 48), {}, {});
  ASSERT_TRUE(frame.ok()) << frame.status();
  EXPECT_EQ(frame->left.masks(3, 3), kMaskSky);
  EXPECT_GT(frame->left.color(32, 10), 40);
}

TEST(Exposure, DimScenesStayDimmerAndDarknessStaysDark) {
  const auto level = [](float radiance) {
    const ImageF3 image(32, 32, radiance);
    return static_cast<int>(ToSrgb(image, AutomaticExposure(image, image))(3, 3));
  };
  EXPECT_NEAR(level(kUsualLuminance), 124, 2);
  EXPECT_GT(level(20), level(2));
  EXPECT_LT(level(0.05f), level(0.5f));
  EXPECT_LT(level(0.5f), level(2));
  EXPECT_GT(level(0.05f), 60);
  EXPECT_LT(level(1e-5f), 10);  // The dataset's filter calls it dark.
  EXPECT_EQ(level(0), 0);
}

// White ground fills the view; half of the picture is sky, whose albedo says nothing.
TEST(Exposure, SnowIsLightAndGrassIsNot) {
  const ImageF3 light(32, 32, 3.0f);
  ImageF3 normal(32, 32, 0.0f);
  for (int y = 16; y < 32; ++y) {
    for (int x = 0; x < 32; ++x) normal(x, y, 1) = 1;
  }
  const auto level = [&](float albedo) {
    ImageF3 albedos(32, 32, 1.0f);
    for (int y = 16; y < 32; ++y) {
      for (int x = 0; x < 32; ++x) {
        for (int c = 0; c < 3; ++c) albedos(x, y, c) = albedo;
      }
    }
    return static_cast<int>(
        ToSrgb(light, AutomaticExposure(light, light, Lightness(albedos, normal)))(3, 3));
  };
  EXPECT_EQ(level(0.1f), level(kUsualAlbedo));
  EXPECT_GT(level(0.85f), level(kUsualAlbedo) + 25);
  EXPECT_LT(level(0.85f), 200);
  EXPECT_EQ(Lightness(ImageF3(32, 32, 1.0f), ImageF3(32, 32, 0.0f)), 1);  // Nothing but sky.
}

TEST(Exposure, ABrightLampDoesNotDarkenThePicture) {
  ImageF3 image(64, 64, 1.0f);
  const float without = AutomaticExposure(image, image);
  for (int y = 0; y < 8; ++y) {
    for (int x = 0; x < 8; ++x) {
      for (int c = 0; c < 3; ++c) image(x, y, c) = 1e4f;
    }
  }
  EXPECT_NEAR(AutomaticExposure(image, image) / without, 1, 0.05);
}

// Like a picture of 4 samples and its reference: the same mean, but one has a lot of noise.
TEST(Exposure, NeitherNoiseNorResolutionChangesIt) {
  Rng rng(SceneSeed{5});
  const ImageF3 calm(1280, 720, 1.0f);
  ImageF3 noisy(1280, 720);
  for (size_t i = 0; i < noisy.pixels(); ++i) {
    const float value = rng.Uniform(0, 1) < 0.05 ? 20.0f : 0.0f;
    for (size_t c = 0; c < 3; ++c) noisy.values()[3 * i + c] = value;
  }
  EXPECT_NEAR(AutomaticExposure(noisy, noisy) / AutomaticExposure(calm, calm), 1, 0.02);
  // Checks of 10 and of 40 pixels: the same picture, reduced.
  const auto checks = [](int scale) {
    ImageF3 image(32 * scale, 18 * scale);
    for (int y = 0; y < image.height(); ++y) {
      for (int x = 0; x < image.width(); ++x) {
        const float value = (x / scale + y / scale) % 2 ? 3.0f : 0.1f;
        for (int c = 0; c < 3; ++c) image(x, y, c) = value;
      }
    }
    return AutomaticExposure(image, image);
  };
  EXPECT_FLOAT_EQ(checks(10), checks(40));
}

TEST(Exposure, ADarkThingCloseByDoesNotBurnOutTheRoom) {
  ImageF3 image(64, 64, 1.0f);
  for (int y = 0; y < 64; ++y) {
    for (int x = 0; x < 44; ++x) {
      for (int c = 0; c < 3; ++c) image(x, y, c) = 0.003f;
    }
  }
  const ImageRgb8 seen = ToSrgb(image, AutomaticExposure(image, image));
  EXPECT_LT(seen(60, 30), 250);
  EXPECT_GT(seen(10, 30), 5);
}

TEST(Exposure, RollOffIsSmoothRisingAndBelowOne) {
  float before = -1;
  for (float x = 0; x < 4; x += 0.01f) {
    const float y = RollOff(x);
    EXPECT_GT(y, before);
    EXPECT_LT(y, 1.0f);
    EXPECT_LT(y - before, before < 0 ? 2.0f : 0.0101f);
    before = y;
  }
}

TEST(Profiles, OverridesReplaceTheTable) {
  const auto table = ResolveProfile({});
  ASSERT_TRUE(table.ok());
  EXPECT_EQ(table->name, "default");
  EXPECT_GT(table->clamp, 0);
  EXPECT_EQ(table->denoise, DenoiseQuality::kBalanced);
  v1::RenderConfig config = MakeConfig(5, 2, true);
  const auto changed = ResolveProfile(config);
  ASSERT_TRUE(changed.ok());
  EXPECT_EQ(changed->samples_per_pixel, 5);
  EXPECT_EQ(changed->max_bounces, 2);
  EXPECT_EQ(changed->denoise, DenoiseQuality::kHigh);
  EXPECT_EQ(changed->clamp, 0);
  EXPECT_EQ(ResolveProfile(MakeConfig(4, 2, true, "preview"))->denoise, DenoiseQuality::kHigh);
  EXPECT_EQ(ResolveProfile(MakeConfig(4, 2, false, "high"))->denoise, DenoiseQuality::kOff);
  config.set_samples_per_pixel(-1);
  EXPECT_FALSE(ResolveProfile(config).ok());
}

TEST(Profiles, SmallPicturesGetMoreSamplesOfAPixelUnlessAskedOtherwise) {
  const RenderProfile usual = *ResolveProfile({});
  EXPECT_EQ(usual.SamplesPerPixel(1920, 1080), usual.samples_per_pixel);
  EXPECT_EQ(usual.SamplesPerPixel(1280, 720), usual.samples_per_pixel);
  EXPECT_EQ(usual.SamplesPerPixel(960, 540), usual.samples_per_pixel);
  EXPECT_EQ(usual.SamplesPerPixel(640, 360), 2 * usual.samples_per_pixel);
  EXPECT_EQ(usual.SamplesPerPixel(480, 270), 2 * usual.samples_per_pixel);
  EXPECT_EQ(usual.SamplesPerPixel(320, 180), 4 * usual.samples_per_pixel);
  EXPECT_EQ(usual.SamplesPerPixel(16, 16), 4 * usual.samples_per_pixel);
  EXPECT_EQ(ResolveProfile(MakeConfig(5, 2, true))->SamplesPerPixel(320, 180), 5);
  EXPECT_EQ(ResolveProfile(MakeConfig(0, 0, true, "high"))->SamplesPerPixel(320, 180), 64);
}

}  // namespace
}  // namespace parallax
