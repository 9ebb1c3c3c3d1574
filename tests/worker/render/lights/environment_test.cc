#include "worker/render/lights/environment.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <numbers>

#include "common/base/rng.h"
#include "common/base/system/file.h"
#include "common/image/io.h"
#include "worker/materials/pictures/environment_folder.h"
#include "worker/materials/pictures/picture_folder.h"
#include "worker/render/lights/sky.h"

namespace parallax {
namespace {

using ::testing::HasSubstr;

// Dim all around, a bright patch above the horizon towards +y.
ImageF3 DayWithLamp() {
  ImageF3 picture(64, 32, 0.2f);
  for (int y = 8; y < 12; ++y) {
    for (int x = 14; x < 18; ++x) {  // A quarter of the way from the middle to the left: +y.
      for (int c = 0; c < 3; ++c) picture(x, y, c) = c == 2 ? 30.0f : 50.0f;
    }
  }
  return picture;
}

std::shared_ptr<const Environment> Make(const ImageF3& picture) {
  auto environment = Environment::Make(picture);
  EXPECT_TRUE(environment.ok()) << environment.status();
  return *environment;
}

TEST(Environment, LooksAlongItsAxes) {
  ImageF3 picture(64, 32, 0.01f);
  const struct {
    int x, y;
    Vec3f direction;
  } cases[] = {{31, 15, Vec3f::UnitX()},  {15, 15, Vec3f::UnitY()}, {0, 15, -Vec3f::UnitX()},
               {47, 15, -Vec3f::UnitY()}, {20, 0, Vec3f::UnitZ()},  {20, 31, -Vec3f::UnitZ()}};
  for (const auto& c : cases) {
    ImageF3 lit = picture;
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 2; ++dx) {
        const int y = std::clamp(c.y + dy, 0, 31);
        const bool pole = c.y == 0 || c.y == 31;
        for (int x = pole ? 0 : c.x + dx; x <= (pole ? 63 : c.x + dx); ++x) {
          lit((x + 64) % 64, y, 1) = 1;
        }
      }
    }
    EXPECT_GT(Make(lit)->Radiance(c.direction).y(), 0.9f) << c.direction.transpose();
    EXPECT_LT(Make(lit)->Radiance(-c.direction).y(), 0.1f) << c.direction.transpose();
  }
}

TEST(Environment, SamplesFollowTheirDensityAndTheLight) {
  const auto environment = Make(DayWithLamp());
  Rng rng(SceneSeed{3}, "environment");
  constexpr int kSamples = 200000;
  double angle = 0, irradiance = 0, square = 0;
  int lamp = 0;
  for (int i = 0; i < kSamples; ++i) {
    const Vec3f d =
        environment->Sample(static_cast<float>(rng.Uniform()), static_cast<float>(rng.Uniform()));
    ASSERT_NEAR(d.norm(), 1, 1e-5f);
    const double pdf = double{environment->Pdf(d)};
    ASSERT_GT(pdf, 0);
    angle += 1 / pdf / kSamples;
    const Vec3f radiance = environment->Radiance(d);
    const double light = 0.2126 * double{radiance.x()} + 0.7152 * double{radiance.y()} +
                         0.0722 * double{radiance.z()};
    const double lit = light * std::max(0.0, double{d.z()}) / pdf;
    irradiance += lit / kSamples;
    square += lit * lit / kSamples;
    lamp += d.y() > 0.6f && d.z() > 0.2f ? 1 : 0;
  }
  EXPECT_NEAR(angle, 4 * std::numbers::pi, 0.15) << "all around";
  const double error = std::sqrt((square - irradiance * irradiance) / kSamples);
  // Cells have one density, while radiance is interpolated.
  EXPECT_NEAR(irradiance, double{environment->ground_irradiance()}, 5 * error + 0.02 * irradiance);
  EXPECT_GT(lamp, kSamples / 2) << "most samples go where most light is";
  // The density of all directions sums to one.
  double total = 0;
  constexpr int kGrid = 400;
  for (int i = 0; i < kGrid; ++i) {
    const double z = -1 + 2 * (i + 0.5) / kGrid, r = std::sqrt(1 - z * z);
    for (int k = 0; k < kGrid; ++k) {
      const double phi = 2 * std::numbers::pi * (k + 0.5) / kGrid;
      const Vec3d d(r * std::cos(phi), r * std::sin(phi), z);
      total += double{environment->Pdf(d.cast<float>())} * 4 * std::numbers::pi / (kGrid * kGrid);
    }
  }
  EXPECT_NEAR(total, 1, 0.01);
}

TEST(Environment, BadPicturesAreRefusedWithWhatIsWrong) {
  const auto message = [](const ImageF3& picture) {
    return std::string(Environment::Make(picture).status().message());
  };
  EXPECT_THAT(message(ImageF3(64, 64, 1.0f)), HasSubstr("64 x 64 pixels, wanted twice as wide"));
  ImageF3 picture(64, 32, 1.0f);
  picture(3, 3) = -1;
  EXPECT_THAT(message(picture), HasSubstr("a value of -1"));
  picture(3, 3) = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THAT(message(picture), HasSubstr("wanted finite ones"));
  EXPECT_THAT(message(ImageF3(64, 32, 0.0f)), HasSubstr("black above the horizon"));
}

TEST(Environment, NegativeAndInfiniteLightOfAFileIsMendedAndNoted) {
  const std::string path = testing::TempDir() + "odd_sky.exr";
  ImageF3 picture(64, 32, 1.0f);
  picture(5, 3, 1) = -0.25f;
  picture(6, 3) = std::numeric_limits<float>::infinity();
  picture(7, 3) = -std::numeric_limits<float>::infinity();
  ASSERT_TRUE(WriteFile(path, *EncodeExrRgb(picture)).ok());
  testing::internal::CaptureStderr();
  const auto mended = Environment::Read(path);
  const std::string log = testing::internal::GetCapturedStderr();
  ASSERT_TRUE(mended.ok()) << mended.status();
  EXPECT_THAT(log,
              HasSubstr("2 values below 0 taken as 0, 1 infinite values as 65504; the first at "
                        "column 5, row 3"));
  EXPECT_THAT(log, HasSubstr((*mended)->note()));
  EXPECT_THAT((*mended)->note(), HasSubstr("2 values below 0"));
  picture = ImageF3(64, 32, 1.0f);
  picture(6, 3) = std::numeric_limits<float>::infinity();
  picture(7, 3) = 65504;
  picture(5, 3, 1) = 0;
  ASSERT_TRUE(WriteFile(path, *EncodeExrRgb(picture)).ok());
  testing::internal::CaptureStderr();
  const auto bright = Environment::Read(path);
  testing::internal::GetCapturedStderr();
  ASSERT_TRUE(bright.ok()) << bright.status();
  EXPECT_TRUE(std::isfinite((*bright)->mean_luminance()));
  EXPECT_GT((*bright)->mean_luminance(), (*mended)->mean_luminance());
  picture(3, 4) = std::numeric_limits<float>::quiet_NaN();
  ASSERT_TRUE(WriteFile(path, *EncodeExrRgb(picture)).ok());
  EXPECT_THAT(std::string(Environment::Read(path).status().message()),
              HasSubstr("odd_sky.exr: a value that is no number (NaN) at column 3, row 4"));
  std::filesystem::remove(path);
}

TEST(Environment, IsReadFromBothFormats) {
  const std::string dir = testing::TempDir() + "environments";
  std::filesystem::remove_all(dir);
  std::filesystem::create_directories(dir);
  ASSERT_TRUE(WriteExrHalfRgb(dir + "/day.exr", DayWithLamp()).ok());
  // Four by two pixels, not packed: 1, 0.5 and 0.25 with the exponent of 1.
  std::string pixels;
  for (int i = 0; i < 8; ++i) pixels += "\x80\x40\x20\x81";
  ASSERT_TRUE(WriteFile(dir + "/grey.hdr",
                        std::string("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 4\n") + pixels)
                  .ok());
  ASSERT_TRUE(WriteFile(dir + "/note.txt", "passed over").ok());
  const auto folder = ReadEnvironmentFolder(dir);
  ASSERT_TRUE(folder.ok()) << folder.status();
  ASSERT_EQ(folder->seeds.size(), 2u);
  const auto day = OpenEnvironment(folder->seeds[0]), grey = OpenEnvironment(folder->seeds[1]);
  ASSERT_TRUE(day.ok()) << day.status();
  ASSERT_TRUE(grey.ok()) << grey.status();
  EXPECT_TRUE((*grey)->Radiance(Vec3f(Vec3f::UnitX())).isApprox(Vec3f(1, 0.5f, 0.25f), 1e-3f))
      << (*grey)->Radiance(Vec3f(Vec3f::UnitX())).transpose();
  EXPECT_EQ(OpenEnvironment(1).status().code(), absl::StatusCode::kNotFound);
  ASSERT_TRUE(WriteFile(dir + "/grey.hdr", "something else").ok());
  const uint64_t other = ReadEnvironmentFolder(dir)->seeds[1];
  EXPECT_THAT(std::string(OpenEnvironment(other).status().message()), HasSubstr("grey.hdr"));
  std::filesystem::remove_all(dir);
}

TEST(SkyModel, AnEnvironmentLightsTheGroundAsTheSkyWould) {
  v1::Sky sky;
  sky.set_strength(0.8);
  sky.set_sun_strength(0.6);
  sky.set_sun_elevation_rad(0.7);
  const SkyModel plain(sky);
  const auto environment = Make(DayWithLamp());
  sky.set_environment_turn_rad(0.5 * std::numbers::pi);  // The lamp is at -x then.
  const SkyModel model(sky, true, environment);
  EXPECT_FALSE(model.has_sun());
  const auto ground = [](const SkyModel& of) {
    constexpr int kSide = 256;
    double sum = 0;
    for (int i = 0; i < kSide * kSide; ++i) {
      const float z = (static_cast<float>(i / kSide) + 0.5f) / kSide;
      const float phi = 2 * kPi * (static_cast<float>(i % kSide) + 0.5f) / kSide;
      const Vec3f d(std::sqrt(1 - z * z) * std::cos(phi), std::sqrt(1 - z * z) * std::sin(phi), z);
      sum += double{Luminance(of.Radiance(d))} * double{z} * 2 * std::numbers::pi / (kSide * kSide);
    }
    if (of.has_sun()) {
      sum += double{Luminance(of.SunRadiance()) * of.sun_solid_angle() * of.sun_direction().z()};
    }
    return sum;
  };
  EXPECT_NEAR(ground(model) / ground(plain), 1, 0.03);
  const Vec3f towards(-0.8f, 0, 0.6f), away(0.8f, 0, 0.6f);
  EXPECT_GT(Luminance(model.Radiance(towards)), 20 * Luminance(model.Radiance(away)));
  EXPECT_GT(model.EnvironmentPdf(towards), 20 * model.EnvironmentPdf(away));
}

}  // namespace
}  // namespace parallax
