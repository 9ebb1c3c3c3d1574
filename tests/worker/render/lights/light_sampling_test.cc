// Every kind of light: its sampler against its density and against brute force, many lights at
// once, and form factors with closed forms.
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>

#include "common/base/rng.h"
#include "common/image/io.h"
#include "common/math/proto.h"
#include "tests/worker/render/radiance.h"
#include "worker/materials/pictures/environment_folder.h"
#include "worker/render/lights/environment.h"
#include "worker/scene/types/indoor/house.h"

namespace parallax {
namespace {

using test::Build;
using test::Built;
using test::DiffuseSample;
using test::Estimate;
using test::MakeFloor;
using test::MakeQuad;
using test::Radiance;
using test::TestScene;

LightSample SampleAt(const Built& built, const Vec3f& position, float choice, const Vec2f& u) {
  test::Sought sought = test::Seek(built.lights, position, choice);
  const LightSampler sampler(built.lights);
  sampler.Aim(Splat(u.x()), &sought.lights);
  LightSamples8 samples;
  sampler.Sample(sought.receivers, sought.lights, Splat(u.x()), Splat(u.y()), &samples);
  return samples.Get(0);
}

void AddSpot(TestScene* test, const Vec3d& position, const Vec3d& direction, double radius_m,
             double power_w, double cone_rad, double blend) {
  test->AddPointLight(position, radius_m, power_w);
  v1::Light* light = test->recipe.mutable_lights(test->recipe.lights_size() - 1);
  light->set_kind(v1::Light::KIND_SPOT);
  *light->mutable_direction() = ToProto(direction);
  light->set_cone_rad(cone_rad);
  light->set_cone_blend(blend);
}

// The seed of surroundings whose one half is ten times as bright as the other.
uint64_t BrightPatch() {
  const std::string dir = testing::TempDir() + "light_sampling_" + std::to_string(getpid());
  std::filesystem::create_directories(dir);
  ImageF3 picture(64, 32, 0.3f);
  for (int y = 4; y < 14; ++y) {
    for (int x = 10; x < 30; ++x) {
      for (int c = 0; c < 3; ++c) picture(x, y, c) = 3;
    }
  }
  EXPECT_TRUE(WriteExrHalfRgb(dir + "/patch.exr", picture).ok());
  const auto folder = ReadEnvironmentFolder(dir);
  EXPECT_TRUE(folder.ok()) << folder.status();
  EXPECT_TRUE(OpenEnvironment(folder->seeds[0]).ok());  // It stays open.
  std::filesystem::remove_all(dir);
  return folder->seeds[0];
}

struct NamedScene {
  std::string name;
  TestScene scene;
};

// One light each; all can be found by BSDF sampling too.
std::vector<NamedScene> OneOfEachKind() {
  std::vector<NamedScene> all;
  const auto add = [&](const std::string& name, auto light) {
    all.push_back({name, MakeFloor(0.5f)});
    light(&all.back().scene);
  };
  add("point", [](TestScene* t) { t->AddPointLight({0.4, 0.2, 1.1}, 0.3, 80); });
  add("spot", [](TestScene* t) {
    AddSpot(t, {0.5, 0.3, 1}, {-0.5, -0.4, -1}, 0.25, 80, 0.5, 0.6);
  });
  add("mesh", [](TestScene* t) {
    const uint32_t black = t->AddMaterial(DiffuseSample(Vec3f::Zero()));
    t->AddMeshLight(t->AddMesh(MakeQuad({0.1f, 0, 0.8f}, {0, 0.8f, 0.2f}, {0.9f, 0, 0}), black),
                    60);
  });
  add("sky", [](TestScene* t) {
    t->recipe.mutable_sky()->set_strength(0.7);
    t->recipe.mutable_sky()->set_sun_strength(0.4);
    t->recipe.mutable_sky()->set_sun_elevation_rad(-0.1);  // Glow without a disk.
  });
  add("environment", [](TestScene* t) {
    t->recipe.mutable_sky()->set_strength(0.7);
    t->recipe.mutable_sky()->set_environment(BrightPatch());
    t->recipe.mutable_sky()->set_environment_turn_rad(1);
  });
  return all;
}

// Pearson's test of directions around the receiver: counts against the density that Sample claims.
TEST(LightSampling, DirectionsFollowTheClaimedDensity) {
  constexpr int kCosines = 100, kAngles = 100, kSamples = 400000;
  for (const NamedScene& named : OneOfEachKind()) {
    const Built built = Build(named.scene);
    Rng rng(SceneSeed{1}, named.name);
    const auto u = [&] { return static_cast<float>(rng.Uniform()); };
    std::vector<double> seen(kCosines * kAngles), inverse_density(kCosines * kAngles);
    for (int i = 0; i < kSamples; ++i) {
      const LightSample sample = SampleAt(built, Vec3f::Zero(), u(), {u(), u()});
      if (!(sample.pdf > 0)) continue;
      const Vec3f& d = sample.direction;
      const double phi = std::atan2(d.y(), d.x()) + M_PI;
      const int c = std::clamp(static_cast<int>((d.z() + 1) / 2 * kCosines), 0, kCosines - 1);
      const int a = std::clamp(static_cast<int>(phi / (2 * M_PI) * kAngles), 0, kAngles - 1);
      const auto cell = static_cast<size_t>(c * kAngles + a);
      ++seen[cell];
      inverse_density[cell] += 1.0 / static_cast<double>(sample.pdf);
    }
    // In a cell that the light fills, the sum of 1 / density is the cell's solid angle times the
    // number of samples.
    const double solid_angle = 4 * M_PI / (kCosines * kAngles);
    int full = 0;
    double statistic = 0;
    for (int c = 1; c + 1 < kCosines; ++c) {
      for (int a = 0; a < kAngles; ++a) {
        const auto at_cell = [&](int dc, int da) {
          return static_cast<size_t>((c + dc) * kAngles + (a + da + kAngles) % kAngles);
        };
        bool inside = true;  // The light fills the cell.
        for (int dc = -1; dc <= 1; ++dc) {
          for (int da = -1; da <= 1; ++da) inside &= seen[at_cell(dc, da)] > 0;
        }
        if (!inside) continue;
        const double sum = inverse_density[at_cell(0, 0)];
        const double expected = solid_angle * kSamples * seen[at_cell(0, 0)] / sum;
        if (expected < 10) continue;
        const double estimate = sum / kSamples / solid_angle;
        statistic += (estimate - 1) * (estimate - 1) * expected;
        ++full;
      }
    }
    ASSERT_GT(full, 15) << named.name;
    EXPECT_LT(statistic, full + 6 * std::sqrt(2.0 * full)) << named.name << " cells " << full;
  }
}

TEST(LightSampling, EachKindAgreesWithBruteForce) {
  const Vec3f eye(-0.9f, -0.7f, 0.9f);
  for (const NamedScene& named : OneOfEachKind()) {
    const Built built = Build(named.scene);
    const Estimate both = Radiance(built, eye, Vec3f::Zero(), 20000, 1);
    for (const DirectLight one : {DirectLight::kLightSampling, DirectLight::kBsdfSampling}) {
      const Estimate single = Radiance(built, eye, Vec3f::Zero(), 60000, 1, one);
      EXPECT_NEAR(both.mean.y(), single.mean.y(), 4 * (both.error + single.error))
          << named.name << " strategy " << static_cast<int>(one);
      EXPECT_GT(single.mean.y(), 0) << named.name;
      EXPECT_LT(single.error, 0.03f * single.mean.y()) << named.name;
    }
  }
}

TEST(LightSampling, ManyLightsAgreeWithBruteForceAndAreChosenByWhatTheyGive) {
  TestScene test = MakeFloor(0.5f);
  Rng rng(SceneSeed{5}, "many");
  const uint32_t black = test.AddMaterial(DiffuseSample(Vec3f::Zero()));
  for (int i = 0; i < 40; ++i) {
    const Vec3d at(rng.Uniform(-4, 4), rng.Uniform(-4, 4), rng.Uniform(1.2, 3));
    const double power = std::exp(rng.Uniform(0, 5));
    switch (i % 3) {
      case 0:
        test.AddPointLight(at, rng.Uniform(0.1, 0.4), power);
        break;
      case 1:
        AddSpot(&test, at, {rng.Uniform(-1, 1), rng.Uniform(-1, 1), -1}, 0.2, power,
                rng.Uniform(0.3, 1.2), rng.Uniform());
        break;
      default:
        test.AddMeshLight(
            test.AddMesh(MakeQuad(at.cast<float>(), {0, 0.5f, 0}, {0.5f, 0, 0}), black), power);
    }
  }
  const Built built = Build(test);
  const Vec3f eye(0.5f, 0.4f, 0.9f);
  const Estimate both = Radiance(built, eye, Vec3f::Zero(), 40000, 1);
  const Estimate brute = Radiance(built, eye, Vec3f::Zero(), 400000, 1, DirectLight::kBsdfSampling);
  EXPECT_NEAR(both.mean.y(), brute.mean.y(), 4 * (both.error + brute.error));
  // Per sample, choosing by power and distance is much quieter than hoping to hit.
  EXPECT_LT(both.error * std::sqrt(40000.0f), 0.5f * brute.error * std::sqrt(400000.0f));
}

TEST(LightSampling, IdealLightsAreChosenWithChancesThatSumToOne) {
  TestScene test = MakeFloor(0.5f);
  constexpr int kLights = 40;
  for (int i = 0; i < kLights; ++i) {
    test.AddPointLight({0.2 * i - 3, 0.1 * i, 1 + 0.05 * i}, 0, 5.0 * (i + 1));
  }
  const Built built = Build(test);
  const Vec3f at(0.2f, 0.1f, 0);
  // The mean of 1 / chance counts the lights; the mean of the light sums them.
  Rng rng(SceneSeed{2}, "choice");
  double count = 0, light = 0;
  constexpr int kSamples = 200000;
  for (int i = 0; i < kSamples; ++i) {
    const LightSample sample =
        SampleAt(built, at, (static_cast<float>(i) + 0.5f) / kSamples, {0.5f, 0.5f});
    count += 1 / sample.pdf;
    light += sample.radiance.y() / sample.pdf;
  }
  double wanted = 0;
  for (const v1::Light& one : test.recipe.lights()) {
    wanted += one.power_w().y() / (4 * M_PI) /
              (FromProto(one.position_m()) - Vec3d(0.2, 0.1, 0)).squaredNorm();
  }
  EXPECT_NEAR(count / kSamples, kLights, 0.1);
  EXPECT_NEAR(light / kSamples, wanted, 1e-3 * wanted);
}

// Points of two rooms and of the garden, lamps of every kind in reach of all.
TEST(LightSampling, EightPointsChooseAndSampleAsEachAlone) {
  TestScene test = MakeFloor(0.5f);
  test.recipe.mutable_sky()->set_strength(1);
  test.recipe.mutable_sky()->set_sun_strength(1);
  test.recipe.mutable_sky()->set_sun_elevation_rad(0.9);
  for (const double x : {0.0, 4.0}) {
    v1::Room* room = test.recipe.mutable_place()->mutable_house()->add_rooms();
    room->set_origin_x_m(x);
    room->set_width_m(3);
    room->set_depth_m(3);
    room->set_height_m(2.5);
    for (int k = 0; k < (x > 0 ? 2 : 1); ++k) {
      v1::Opening* window = room->add_openings();
      window->set_kind(v1::Opening::KIND_WINDOW);
      window->set_wall(k);
      window->set_center_m(1.5);
      window->set_width_m(1.2);
      window->set_sill_m(0.9);
      window->set_height_m(1.2);
    }
  }
  test.geometry.surroundings = HouseSurroundings(test.recipe.place());
  test.AddPointLight({1, 1, 2}, 0.1, 50);
  AddSpot(&test, {5, 1, 2}, {0.1, 0.2, -1}, 0.05, 50, 0.8, 0.5);
  AddSpot(&test, {2, -1, 2}, {0.1, 0.6, -1}, 0, 50, 0.8, 0);
  const uint32_t black = test.AddMaterial(DiffuseSample(Vec3f::Zero()));
  test.AddMeshLight(test.AddMesh(MakeQuad({3, 0, 2.3f}, {0, 1, 0.1f}, {0.5f, 0, 0}), black), 50);
  const Built built = Build(test);
  ASSERT_GT(built.lights.portals(), 2u);

  Rng rng(SceneSeed{4}, "places");
  std::vector<int> chosen(8);
  for (int round = 0; round < 200; ++round) {
    LightQueries8 queries{};
    queries.count = 1 + round % kLanes;
    for (int lane = 0; lane < kLanes; ++lane) {
      queries.position.Set(lane, Vec3f(static_cast<float>(rng.Uniform(-1, 8)),
                                       static_cast<float>(rng.Uniform(-1, 4)),
                                       static_cast<float>(rng.Uniform(0, 2.4))));
      queries.normal.Set(lane, Vec3f::UnitZ());
      queries.choice[lane] = static_cast<float>(rng.Uniform());
    }
    LightReceivers8 at;
    LightChoices8 lights;
    std::vector<Float8> scratch;
    const LightSampler sampler(built.lights);
    sampler.Choose(queries, &scratch, &at, &lights);
    Float8 u, v;
    for (int lane = 0; lane < kLanes; ++lane) {
      u[lane] = static_cast<float>(rng.Uniform());
      v[lane] = static_cast<float>(rng.Uniform());
    }
    LightSamples8 samples;
    sampler.Aim(u, &lights);
    sampler.Sample(at, lights, u, v, &samples);
    for (int lane = 0; lane < queries.count; ++lane) {
      const test::Sought alone =
          test::Seek(built.lights, queries.position.Get(lane), queries.choice[lane]);
      const auto light = static_cast<size_t>(lights.light[lane]);
      EXPECT_EQ(at.room[lane], alone.at().room);
      EXPECT_EQ(at.total[lane], alone.at().total);
      EXPECT_EQ(lights.light[lane], alone.lights.light[0]);
      EXPECT_EQ(lights.importance[lane] / at.total[lane], sampler.Chance(alone.at(), light));
      const LightSample sample =
          SampleAt(built, queries.position.Get(lane), queries.choice[lane], {u[lane], v[lane]});
      const LightSample seen = samples.Get(lane);
      EXPECT_EQ(seen.direction, sample.direction);
      EXPECT_EQ(seen.distance, sample.distance);
      EXPECT_EQ(seen.radiance, sample.radiance);
      EXPECT_EQ(seen.pdf, sample.pdf);
      EXPECT_EQ(seen.ideal, sample.ideal);
      if (sample.pdf > 0.0f) ++chosen[light];
    }
    for (int lane = queries.count; lane < kLanes; ++lane) {
      EXPECT_EQ(at.total[lane], 0);
      EXPECT_EQ(samples.pdf[lane], 0);
    }
  }
  for (int light = 0; light < 7; ++light) EXPECT_GT(chosen[static_cast<size_t>(light)], 5) << light;
}

// A hall has a thousand times the cells of a cupboard: its numbers lie far beyond the cupboard's.
TEST(LightSampling, PointsOfAHallLeaveTheGainsOfASmallRoomAlone) {
  TestScene test = MakeFloor(0.5f);
  test.recipe.mutable_sky()->set_strength(1);
  for (const double size : {1.0, 40.0}) {
    v1::Room* room = test.recipe.mutable_place()->mutable_house()->add_rooms();
    room->set_origin_x_m(size > 1 ? 2 : 0);
    room->set_width_m(size);
    room->set_depth_m(size);
    room->set_height_m(size);
    v1::Opening* window = room->add_openings();
    window->set_kind(v1::Opening::KIND_WINDOW);
    window->set_wall(0);
    window->set_center_m(0.5);
    window->set_width_m(0.6);
    window->set_sill_m(0.2);
    window->set_height_m(0.6);
  }
  test.geometry.surroundings = HouseSurroundings(test.recipe.place());
  Built built = Build(test);
  ASSERT_EQ(built.lights.portals(), 2u);
  for (Enclosure& room : built.lights.mutable_enclosures()) room.gains.Learn();
  LightQueries8 queries{};
  queries.count = 2;
  for (int lane = 0; lane < queries.count; ++lane) {
    queries.position.Set(lane, lane == 0 ? Vec3f(0.5f, 0.5f, 0.5f) : Vec3f(41, 39, 39));
    queries.normal.Set(lane, Vec3f::UnitZ());
    queries.choice[lane] = 0.2f;
  }
  LightReceivers8 at;
  LightChoices8 lights;
  std::vector<Float8> scratch;
  const LightSampler sampler(built.lights);
  sampler.Choose(queries, &scratch, &at, &lights);
  ASSERT_EQ(at.room[0], 0);
  ASSERT_EQ(at.room[1], 1);
  ASSERT_GT(at.cell[1], 1'000'000);
  LightSamples8 samples;
  sampler.Sample(at, lights, Splat(0.5f), Splat(0.5f), &samples);
  const LightSample alone =
      SampleAt(built, queries.position.Get(0), queries.choice[0], {0.5f, 0.5f});
  EXPECT_GT(alone.pdf, 0.0f);
  EXPECT_EQ(samples.Get(0).pdf, alone.pdf);
}

TEST(LightSampling, ASpotSendsItsPowerIntoItsCone) {
  for (const double blend : {0.0, 0.5, 1.0}) {
    for (const double radius : {0.0, 0.1}) {
      TestScene test = MakeFloor(0.5f);
      AddSpot(&test, {0, 0, 2}, {0, 0, -3}, radius, 100, 0.6, blend);
      const Built built = Build(test);
      // Flux through a sphere of 1 m around it, seen from points of that sphere.
      Rng rng(SceneSeed{3}, "flux");
      double flux = 0;
      constexpr int kSamples = 40000;
      for (int i = 0; i < kSamples; ++i) {
        const Vec3f away = DirectionAt(static_cast<float>(rng.Uniform(-1, 1)),
                                       static_cast<float>(rng.Uniform(0, 2 * M_PI)));
        const LightSample sample =
            SampleAt(built, Vec3f(0, 0, 2) + away, 0.5f,
                     {static_cast<float>(rng.Uniform()), static_cast<float>(rng.Uniform())});
        if (!(sample.pdf > 0)) continue;
        flux +=
            sample.radiance.y() / sample.pdf * -sample.direction.dot(away) * 4 * M_PI / kSamples;
      }
      EXPECT_NEAR(flux, 100, 2.5) << "blend " << blend << " radius " << radius;
      if (radius > 0) continue;
      // Below it and outside of the cone.
      const double solid_angle = 2 * M_PI * (1 - std::cos(0.6)) * (1 - blend / 2);
      const Estimate below = Radiance(built, {1, 0, 1}, {0, 0, 0}, 100, 1);
      EXPECT_NEAR(below.mean.y(), 0.5 / M_PI * 100 / solid_angle / 4, 1e-3 * below.mean.y());
      EXPECT_EQ(Radiance(built, {2, 0, 1}, {1.5f, 0, 0}, 100, 1).mean.y(), 0);
    }
  }
}

TEST(LightSampling, ASpotWithoutAConeIsRefusedByName) {
  for (const double cone : {0.0, 4.0, std::nan("")}) {
    TestScene test = MakeFloor(0.5f);
    AddSpot(&test, {0, 0, 2}, {0, 0, -1}, 0, 10, cone, 0);
    test.recipe.mutable_lights(0)->set_name("stage");
    const auto scene = RenderScene::Build(test.geometry, 0);
    const auto lights = LightTable::Build(test.recipe, **scene);
    EXPECT_EQ(lights.status().code(), absl::StatusCode::kInvalidArgument);
    EXPECT_NE(std::string(lights.status().message()).find("stage"), std::string::npos);
  }
}

// Radiance of one point seen from `offset` away, by one path; each index is another path.
float OnePath(const Built& built, const Vec3f& target, const Vec3f& offset, int index) {
  Ray ray;
  ray.origin = target + offset;
  ray.direction = -offset.normalized();
  PathOptions options;
  options.max_bounces = 1;
  Sampler sampler(12, static_cast<uint32_t>(index), 0, 0);
  return PathTracer(*built.scene, built.lights, options).Trace(ray, sampler).radiance.y();
}

// Mean over the unit square z = 0 of a white surface's radiance.
double MeanOverSquare(const Built& built, float eye_height) {
  Rng rng(SceneSeed{4}, "form factor");
  double sum = 0;
  constexpr int kSide = 300;
  for (int i = 0; i < kSide * kSide; ++i) {
    const Vec3f target((static_cast<float>(i % kSide) + static_cast<float>(rng.Uniform())) / kSide,
                       (static_cast<float>(i / kSide) + static_cast<float>(rng.Uniform())) / kSide,
                       0);
    sum += OnePath(built, target, {0, 0, eye_height}, i);
  }
  return sum / (kSide * kSide);
}

TEST(LightSampling, FormFactorsOfSquaresAndOfASphereAreTheClosedForms) {
  const auto lamp_scene = [](const Vec3f& corner, const Vec3f& u, const Vec3f& v) {
    TestScene test;
    const uint32_t white = test.AddMaterial(DiffuseSample(Vec3f::Ones()));
    const uint32_t black = test.AddMaterial(DiffuseSample(Vec3f::Zero()));
    test.AddMesh(MakeQuad({0, 0, 0}, {1, 0, 0}, {0, 1, 0}), white);
    test.AddMeshLight(test.AddMesh(MakeQuad(corner, u, v), black), M_PI);  // Radiance 1 of 1 m^2.
    return Build(test);
  };
  const Vec3f x(1, 0, 0), y(0, 1, 0), z(0, 0, 1), corner = Vec3f::Zero();
  // Source: Howell, "A catalog of radiation heat transfer configuration factors", C-11 and C-14.
  const double parallel = MeanOverSquare(lamp_scene(z, y, x), 0.01f);
  EXPECT_NEAR(parallel, 0.199825, 0.001);
  const double perpendicular = MeanOverSquare(lamp_scene(corner, y, z), 0.001f);
  EXPECT_NEAR(perpendicular, 0.200044, 0.0015);

  // A sphere above the centre of a coaxial disk: 1/2 (1 - 1 / sqrt(1 + (R / h)^2)) of its light.
  // Over a disk of radius 1, here a square's points within it.
  TestScene test = MakeFloor(1.0f);
  test.AddPointLight({0, 0, 0.8}, 0.5, 100);
  const Built built = Build(test);
  Rng rng(SceneSeed{6}, "disk");
  double sum = 0;
  constexpr int kPoints = 20000;
  for (int i = 0; i < kPoints; ++i) {
    const double r = std::sqrt(rng.Uniform()), phi = rng.Uniform(0, 2 * M_PI);
    const Vec3f target(static_cast<float>(r * std::cos(phi)), static_cast<float>(r * std::sin(phi)),
                       0);
    sum += OnePath(built, target, {0, 0, 0.1f}, i);
  }
  // Irradiance is pi times a white floor's radiance; times the disk's area it is flux.
  const double flux = M_PI * (sum / kPoints) * M_PI;
  EXPECT_NEAR(flux / 100, 0.5 * (1 - 1 / std::sqrt(1 + 1 / 0.64)), 0.003);
}

TEST(LightSampling, TheSunsDiskGivesItsIrradiance) {
  TestScene test = MakeFloor(0.5f);
  v1::Sky* sky = test.recipe.mutable_sky();
  sky->set_strength(1);
  sky->set_sun_strength(0.7);
  sky->set_sun_elevation_rad(0.9);
  const Built built = Build(test);
  Rng rng(SceneSeed{7}, "sun");
  double sun = 0, solid_angle = 0;
  constexpr int kSamples = 100000;
  for (int i = 0; i < kSamples; ++i) {
    const LightSample sample =
        SampleAt(built, Vec3f::Zero(), static_cast<float>(rng.Uniform()),
                 {static_cast<float>(rng.Uniform()), static_cast<float>(rng.Uniform())});
    if (!(sample.pdf > 0) || !built.lights.sky().InSun(sample.direction)) continue;
    if (sample.pdf < 1) continue;  // The dome's samples may fall on the disk.
    sun += sample.radiance.y() / sample.pdf / kSamples;
    solid_angle += 1 / sample.pdf / kSamples;
  }
  const SkyModel& model = built.lights.sky();
  EXPECT_NEAR(solid_angle, model.sun_solid_angle(), 0.02 * model.sun_solid_angle());
  EXPECT_NEAR(sun, model.SunRadiance().y() * model.sun_solid_angle(),
              0.02 * model.SunRadiance().y() * model.sun_solid_angle());
}

}  // namespace
}  // namespace parallax
