// Haze and clouds of the sky.
#include "worker/render/lights/sky.h"

#include <gtest/gtest.h>

#include "common/math/proto.h"
#include "tests/worker/render/radiance.h"

namespace parallax {
namespace {

v1::Sky ClearDay(double elevation = 0.8) {
  v1::Sky sky;
  sky.set_strength(1);
  sky.set_sun_strength(1);
  sky.set_sun_elevation_rad(elevation);
  return sky;
}

std::vector<Vec3f> Directions(int count) {
  std::vector<Vec3f> all;
  for (int i = 0; i < count; ++i) {
    const float z = (static_cast<float>(i) + 0.5f) / static_cast<float>(count);
    all.push_back(DirectionAt(z, 2.39996f * static_cast<float>(i)));
  }
  return all;
}

TEST(Sky, AFlatColourIsTheSameInAllDirections) {
  v1::Sky sky = ClearDay();
  *sky.mutable_flat() = ToProto(Vec3d(1.5, 1, 0.5));
  sky.set_flat_share(1);
  const SkyModel flat(sky);
  const Vec3f expected = Vec3f(1.5f, 1, 0.5f) * SkyModel::kZenithRadiance;
  for (const Vec3f& up : Directions(20)) {
    EXPECT_TRUE(flat.Radiance(up).isApprox(expected, 1e-5f));
    EXPECT_TRUE(flat.Radiance(Vec3f(-up)).isApprox(expected, 1e-5f)) << "below the horizon too";
  }
  sky.set_flat_share(0.5);
  const SkyModel mixed(sky), open(ClearDay());
  const Vec3f up(0, 0, 1);
  EXPECT_TRUE(mixed.Radiance(up).isApprox(0.5f * (expected + open.Radiance(up)), 1e-5f));
  EXPECT_EQ(mixed.SunRadiance(), open.SunRadiance());
}

// Without a given turbidity, a sky has the usual one, under a veil of thin cloud.
TEST(Sky, GivenTurbidityLiftsTheVeil) {
  v1::Sky said = ClearDay();
  said.set_turbidity(3);
  const SkyModel veiled(ClearDay()), open(said);
  EXPECT_EQ(veiled.SunRadiance(), open.SunRadiance());
  const auto blue = [](const SkyModel& model) {
    const Vec3f away = model.Radiance(Vec3f(-0.7f, 0, 0.7f).normalized());
    return away.z() / away.x();
  };
  EXPECT_GT(blue(open), 1.15f * blue(veiled));
  said.set_cloud_cover(0);  // The clearest of skies.
  EXPECT_EQ(blue(SkyModel(said)), blue(open));
}

TEST(Sky, HazeReddensTheSunAndPalesTheSky) {
  for (const double elevation : {0.2, 0.8, 1.4}) {
    float last_sun = 1e9f, last_warmth = 0, last_blue = 1e9f;
    for (const double turbidity : {2.0, 3.0, 5.0, 8.0}) {
      v1::Sky sky = ClearDay(elevation);
      sky.set_turbidity(turbidity);
      const SkyModel model(sky);
      const Vec3f sun = model.SunRadiance();
      EXPECT_LT(Luminance(sun), last_sun) << turbidity;
      EXPECT_GT(sun.x() / sun.z(), last_warmth) << turbidity;
      // Away from the sun, low, where haze is thick.
      const Vec3f away = model.Radiance(Vec3f(-0.95f, 0, 0.3f).normalized());
      if (turbidity > 3) {  // Clearer air than usual is as blue.
        EXPECT_LT(away.z() / away.x(), last_blue) << turbidity;
      }
      last_sun = Luminance(sun);
      last_warmth = sun.x() / sun.z();
      last_blue = away.z() / away.x();
      for (const Vec3f& d : Directions(300)) {
        const Vec3f radiance = model.Radiance(d);
        ASSERT_TRUE(radiance.allFinite());
        ASSERT_GE(radiance.minCoeff(), 0.0f);
        const float magenta = 0.5f * (radiance.x() + radiance.z());
        EXPECT_LE(radiance.y(), 1.05f * magenta) << "a green sky";
        if (radiance.x() > 0.8f * radiance.z()) {
          EXPECT_GE(radiance.y(), 0.96f * magenta) << "a pink sky";
        }
      }
    }
  }
}

CloudLight Noon() {
  CloudLight light;
  light.sun_direction = Vec3f(0.3f, 0.1f, 0.8f).normalized();
  light.sun_irradiance = Vec3f::Constant(60);
  return light;
}

// A light for clouds that need not leave a gap for the sun.
CloudLight NoSun() {
  CloudLight light = Noon();
  light.sun_irradiance = Vec3f::Zero();
  return light;
}

// Overhead, where the layer is seen from below and not through its sides.
double CoveredOverhead(const Clouds& clouds) {
  int covered = 0, all = 0;
  for (const Vec3f& d : Directions(6000)) {
    if (d.z() < 0.6f) continue;
    ++all;
    covered += clouds.At(Vec3x8(d)).kept[0] < 0.6f ? 1 : 0;
  }
  return static_cast<double>(covered) / all;
}

TEST(Clouds, CoverWhatTheyAreToldOnAverage) {
  double last = 0;
  for (const double cover : {0.15, 0.4, 0.7, 0.95}) {
    double sum = 0;
    constexpr int kSeeds = 2;
    for (uint64_t seed = 0; seed < kSeeds; ++seed) {
      sum += CoveredOverhead(*Clouds::Bake(cover, seed, NoSun())) / kSeeds;
    }
    EXPECT_NEAR(sum, cover, 0.22) << cover;
    EXPECT_GT(sum, last) << cover;
    last = sum;
  }
}

TEST(Clouds, AreThoseOfTheirSeed) {
  const auto one = Clouds::Bake(0.5, 7, Noon()), same = Clouds::Bake(0.5, 7, Noon()),
             other = Clouds::Bake(0.5, 8, Noon());
  int differ = 0;
  for (const Vec3f& d : Directions(400)) {
    const auto a = one->At(Vec3x8(d)), b = same->At(Vec3x8(d)), c = other->At(Vec3x8(d));
    ASSERT_EQ(a.radiance.Get(0), b.radiance.Get(0));
    ASSERT_EQ(a.kept[0], b.kept[0]);
    ASSERT_GE(a.radiance.Get(0).minCoeff(), 0.0f);
    ASSERT_GE(a.kept[0], 0.0f);
    ASSERT_LE(a.kept[0], 1.0f);
    differ += a.kept[0] != c.kept[0] ? 1 : 0;
  }
  EXPECT_GT(differ, 100);
}

// The sky of a sunny day is blue between its clouds.
TEST(Sky, IsBlueBetweenClouds) {
  v1::Sky sky = ClearDay();
  sky.set_turbidity(2.2);
  sky.set_cloud_cover(0.3);
  const SkyModel model(sky);
  int blue = 0, white = 0;
  for (const Vec3f& d : Directions(2000)) {
    if (d.z() < 0.35f || d.dot(model.sun_direction()) > 0.8f) continue;
    const Vec3f radiance = model.Radiance(d);
    (radiance.x() < 0.7f * radiance.z() ? blue : white) += 1;
  }
  EXPECT_GT(blue, white);
  EXPECT_GT(white, 100);  // The clouds.
}

// A white cloud in full sun is nearly as bright as a white board in it.
TEST(Clouds, AreAsBrightAsWhatLightsThem) {
  const auto clouds = Clouds::Bake(0.6, 3, Noon());
  const float board = 60 * kInvPi;
  double sum = 0, count = 0;
  for (const Vec3f& d : Directions(2000)) {
    const auto layer = clouds->At(Vec3x8(d));
    if (layer.kept[0] > 0.1f || d.z() < 0.3f) continue;
    const float radiance = layer.radiance.Get(0).y();
    EXPECT_LT(radiance, 3 * board);
    sum += static_cast<double>(radiance);
    ++count;
  }
  ASSERT_GT(count, 100);
  EXPECT_GT(sum / count, 0.4 * static_cast<double>(board));
  EXPECT_LT(sum / count, 1.5 * static_cast<double>(board));
}

// The haze before clouds far away is all that is seen of them, alike in every direction: what
// stands below the horizon of a hill shows no streaks.
TEST(Clouds, AreLostInTheHazeAtTheHorizon) {
  const auto clouds = Clouds::Bake(0.9, 5, Noon());
  for (int i = 0; i < 360; ++i) {
    const float azimuth = static_cast<float>(i) * kPi / 180;
    for (const float z : {0.0f, -0.1f}) {
      const float level = std::sqrt(1 - z * z);
      const auto layer =
          clouds->At(Vec3x8(Vec3f(level * std::cos(azimuth), level * std::sin(azimuth), z)));
      EXPECT_GT(layer.kept[0], 0.96f) << i;
      EXPECT_LT(Luminance(layer.radiance.Get(0)), 1.0f) << i;
    }
  }
}

// No edge of a texel shows: half a texel on, the slope has hardly changed.
TEST(Clouds, HaveNoEdgesOfTheTableTheyAreKeptIn) {
  const auto clouds = Clouds::Bake(0.5, 11, NoSun());
  constexpr float kStep = 2e-4f;  // Radians; a texel is four times as wide at least.
  double worst = 0, most = 0;
  for (int i = 0; i < 20000; ++i) {
    const auto kept = [&](int k) {
      const float angle = static_cast<float>(i + k) * kStep;
      const Vec3f d(0.8f * std::cos(angle), 0.8f * std::sin(angle), 0.6f);
      return static_cast<double>(clouds->At(Vec3x8(d)).kept[0]);
    };
    const double before = kept(1) - kept(0), after = kept(2) - kept(1);
    worst = std::max(worst, std::abs(after - before));
    most = std::max(most, std::abs(before));
  }
  EXPECT_GT(most, 1e-3) << "clouds have borders";
  EXPECT_LT(worst, 0.35 * most);
}

// Returns the sum of second differences of the radiance low in the sky, from pixel to pixel upwards
// or along the horizon.
double Unevenness(const Clouds& clouds, bool upwards) {
  constexpr float kPixel = 0.002f;  // Radians.
  double sum = 0;
  for (int i = 0; i < 4000; ++i) {
    const float height = 0.13f + 0.15f * static_cast<float>(i % 50) / 50;
    const float azimuth = 0.078f * static_cast<float>(i) / 50;
    const auto radiance = [&](float k) {
      const float up = height + (upwards ? k * kPixel : 0), turn = upwards ? 0 : k * kPixel;
      const Vec3f d(std::cos(azimuth + turn), std::sin(azimuth + turn), up);
      return clouds.At(Vec3x8(Vec3f(d.normalized()))).radiance.y[0];
    };
    sum += static_cast<double>(std::abs(radiance(-1) - 2 * radiance(0) + radiance(1)));
  }
  return sum;
}

// Clouds low in the sky have no stripes: from row to row they change 1.6 times as much as along a
// row, because they are flat below. With stripes it was three times.
TEST(Clouds, HaveNoStripes) {
  for (const uint64_t seed : {3, 4, 5}) {
    const auto clouds = Clouds::Bake(0.5, seed, Noon());
    const double along = Unevenness(*clouds, false), up = Unevenness(*clouds, true);
    EXPECT_GT(along, 0);
    EXPECT_LT(up, 2.2 * along) << seed;
  }
}

// The sun shines between the clouds where they leave a gap; where they don't, they hide it, and the
// light on the ground follows.
TEST(Clouds, ShowTheSunBetweenThem) {
  const float open = Luminance(SkyModel(ClearDay()).SunRadiance());
  const auto sun = [&](double cover, uint64_t seed) {
    v1::Sky sky = ClearDay();
    sky.set_cloud_cover(cover);
    sky.set_cloud_seed(seed);
    return Luminance(SkyModel(sky).SunRadiance());
  };
  for (uint64_t seed = 0; seed < 5; ++seed) {
    const float shines = sun(0.75, seed);
    EXPECT_GT(shines, 0.7f * open) << seed;
    EXPECT_LE(shines, 1.0001f * open) << seed;
  }
  EXPECT_LT(sun(1, 3), 0.3f * open);
}

TEST(Clouds, EstimatorsOfDirectLightAgreeBelowThem) {
  test::TestScene scene;
  scene.AddMesh(test::MakeQuad({-1, -1, 0}, {2, 0, 0}, {0, 2, 0}),
                scene.AddMaterial(test::DiffuseSample(Vec3f::Constant(0.5f))));
  *scene.recipe.mutable_sky() = ClearDay();
  scene.recipe.mutable_sky()->set_sun_strength(0);
  scene.recipe.mutable_sky()->set_cloud_cover(0.5);
  const test::Built built = test::Build(scene);
  const Vec3f from(0.2f, 0.1f, 1);
  const test::Estimate both = test::Radiance(built, from, {0, 0, 0}, 20000, 1);
  for (const DirectLight direct : {DirectLight::kLightSampling, DirectLight::kBsdfSampling}) {
    const test::Estimate one = test::Radiance(built, from, {0, 0, 0}, 40000, 1, direct);
    EXPECT_NEAR(Luminance(one.mean), Luminance(both.mean), 4 * (one.error + both.error));
  }
}

}  // namespace
}  // namespace parallax
