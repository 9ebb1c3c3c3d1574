// Light transport against closed forms, and estimators against one another.
#include "worker/render/lights/light_table.h"

#include <gtest/gtest.h>

#include <cmath>

#include "common/math/proto.h"
#include "tests/worker/render/radiance.h"
#include "worker/scene/types/indoor/house.h"

namespace parallax {
namespace {

using test::Build;
using test::Built;
using test::DiffuseSample;
using test::Estimate;
using test::MakeBox;
using test::MakeFloor;
using test::MakeQuad;
using test::MakeSphere;
using test::Radiance;
using test::TestScene;

const Vec3f kEye(0.4f, -0.3f, 1.5f);
const Vec3f kTarget(0, 0, 0);

TEST(Lights, PointLightGivesInverseSquareTimesCosine) {
  for (const double radius : {0.0, 0.2}) {
    TestScene test = MakeFloor(0.5f);
    test.AddPointLight({1, 0.5, 2}, radius, 100);
    const double d2 = 1 + 0.25 + 4;
    const double irradiance = 100 / (4 * M_PI * d2) * (2 / std::sqrt(d2));
    const Estimate seen = Radiance(Build(test), kEye, kTarget, 4000, 1);
    EXPECT_NEAR(seen.mean.y(), 0.5 / M_PI * irradiance, 4 * seen.error + 2e-4 * irradiance)
        << radius;
  }
}

// Irradiance below the corner of a rectangle a x b at height c, over pi times its radiance.
double CornerFormFactor(double a, double b, double c) {
  const double x = a / c, y = b / c;
  return (x / std::sqrt(1 + x * x) * std::atan(y / std::sqrt(1 + x * x)) +
          y / std::sqrt(1 + y * y) * std::atan(x / std::sqrt(1 + y * y))) /
         (2 * M_PI);
}

TEST(Lights, RectangleGivesTheClosedFormWithEachStrategy) {
  TestScene test = MakeFloor(0.5f);
  const uint32_t black = test.AddMaterial(DiffuseSample(Vec3f::Zero()));
  // Above the quarter x, y > 0; faces down.
  const uint32_t lamp = test.AddMesh(MakeQuad({0, 0, 1.2f}, {0, 0.8f, 0}, {1.5f, 0, 0}), black);
  test.AddMeshLight(lamp, 60);
  const Built built = Build(test);
  const double radiance = 60 / (M_PI * 1.2);
  const double wanted = 0.5 * radiance * CornerFormFactor(1.5, 0.8, 1.2);
  // The eye is to the side: the lamp must not be between eye and floor.
  const Vec3f eye(-0.5f, -0.4f, 1.5f);
  for (const DirectLight direct :
       {DirectLight::kBoth, DirectLight::kLightSampling, DirectLight::kBsdfSampling}) {
    const Estimate seen = Radiance(built, eye, kTarget, 20000, 1, direct);
    EXPECT_NEAR(seen.mean.x(), wanted, 4 * seen.error + 1e-3 * wanted) << static_cast<int>(direct);
    EXPECT_LT(seen.error, 0.05 * wanted);
  }
}

// A lamp in a shade is so near that the clearance of shadow rays matters.
TEST(Lights, ALampAFewCentimetresAwayDoesNotShadeItself) {
  const Vec3f place(4, 3, 2);  // Far from the origin, as in a room.
  for (const float height : {0.3f, 0.1f, 0.03f, 0.01f}) {
    TestScene test;
    const uint32_t grey = test.AddMaterial(DiffuseSample(Vec3f::Constant(0.5f)));
    const uint32_t black = test.AddMaterial(DiffuseSample(Vec3f::Zero()));
    test.AddMesh(MakeQuad(place - Vec3f(5, 5, 0), {10, 0, 0}, {0, 10, 0}), grey);
    const uint32_t lamp = test.AddMesh(
        MakeQuad(place + Vec3f(0, 0, height), {0, 0.8f * height, 0}, {1.5f * height, 0, 0}), black);
    test.AddMeshLight(lamp, 60);
    const Built built = Build(test);
    const double radiance = 60 / (M_PI * 1.2 * height * height);
    const double wanted = 0.5 * radiance * CornerFormFactor(1.5, 0.8, 1);
    const Vec3f eye = place + Vec3f(-0.5f, -0.4f, 1.5f);
    const Estimate seen = Radiance(built, eye, place, 4000, 1, DirectLight::kLightSampling);
    EXPECT_NEAR(seen.mean.x(), wanted, 4 * seen.error + 3e-3 * wanted) << height;
  }
}

// A face whose smooth normals lean by 10 degrees, lit from well above and from near its horizon.
TEST(Lights, SmoothNormalsTakeLightOnlyNearTheHorizonOfTheFace) {
  const auto lean = static_cast<float>(10 * M_PI / 180);
  const auto seen_from = [&](float elevation) {
    TestScene test;
    Mesh leaning = *MakeQuad({-1, -1, 0}, {2, 0, 0}, {0, 2, 0});
    for (Vec3f& n : leaning.normals) n = Vec3f(std::sin(lean), 0, std::cos(lean));
    test.AddMesh(std::make_shared<const Mesh>(leaning),
                 test.AddMaterial(DiffuseSample(Vec3f::Constant(0.5f))));
    test.AddPointLight({3 * std::cos(elevation), 0, 3 * std::sin(elevation)}, 0, 100);
    const double plain = 0.5 / M_PI * 100 / (4 * M_PI * 9) * std::sin(elevation + lean);
    return Radiance(Build(test), kEye, kTarget, 16, 1).mean.x() / plain;
  };
  EXPECT_NEAR(seen_from(0.8f), 1, 1e-3);
  EXPECT_NEAR(seen_from(0.1f), 1, 1e-3);
  EXPECT_GT(seen_from(0.05f), 0.3);
  EXPECT_LT(seen_from(0.05f), 0.9);
  EXPECT_LT(seen_from(0.004f), 0.05);  // No hard edge.
}

TEST(Lights, MeshLightShinesFromItsFrontOnly) {
  TestScene test = MakeFloor(0.5f);
  const uint32_t black = test.AddMaterial(DiffuseSample(Vec3f::Zero()));
  const uint32_t lamp = test.AddMesh(MakeQuad({0, 0, 1.2f}, {1.5f, 0, 0}, {0, 0.8f, 0}), black);
  test.AddMeshLight(lamp, 60);
  EXPECT_EQ(Radiance(Build(test), {-0.5f, -0.4f, 1.5f}, kTarget, 500, 1).mean.x(), 0.0f);
}

TEST(Lights, FurnaceShowsNothing) {
  // In a closed box of constant radiance, a white body can't be distinguished from the wall behind.
  TestScene test;
  SurfaceSample white = DiffuseSample(Vec3f::Ones());
  SurfaceSample metal;
  metal.base_color.setOnes();
  metal.metallic = 1;
  metal.roughness = 0.6f;
  SurfaceSample glass;
  glass.base_color.setOnes();
  glass.transmission = 1;
  glass.roughness = 0.0f;
  SurfaceSample pane = glass;
  pane.thin_walled = true;
  const uint32_t black = test.AddMaterial(DiffuseSample(Vec3f::Zero()));
  test.AddMesh(MakeSphere({0, 0, 1}, 0.5f), test.AddMaterial(white));
  test.AddMesh(MakeSphere({2, 0, 1}, 0.5f), test.AddMaterial(metal));
  test.AddMesh(MakeSphere({-2, 0, 1}, 0.5f), test.AddMaterial(glass));
  test.AddMesh(MakeQuad({0, 2, 0}, {1, 0, 0}, {0, 0, 1}), test.AddMaterial(pane));
  const uint32_t walls = test.AddMesh(MakeBox({-4, -4, -2}, {4, 4, 4}, true), black);
  test.AddMeshLight(walls, M_PI * (2 * 64 + 4 * 48));  // Radiance 1.
  const Built built = Build(test);
  const Vec3f eye(0, -3, 1);
  // Glass keeps a path inside for a while: bounces enough that the rest is small.
  for (const Vec3f& target :
       {Vec3f(0, 0, 1), Vec3f(0.3f, 0, 1.2f), Vec3f(2, 0, 1), Vec3f(2.2f, 0, 1.2f), Vec3f(-2, 0, 1),
        Vec3f(-2.2f, 0, 1.1f), Vec3f(0.8f, 2, 0.3f), Vec3f(1, 4, 3)}) {
    const Estimate seen = Radiance(built, eye, target, 6000, 24);
    EXPECT_NEAR(seen.mean.x(), 1.0f, 0.012f + 4 * seen.error) << target.transpose();
  }
}

TestScene WindowRoom(bool ceiling, double sun) {
  TestScene test;
  const uint32_t grey = test.AddMaterial(DiffuseSample(Vec3f::Constant(0.6f)));
  // 4 x 4 x 3 m, walls of 0.2 m, a window of 1.6 x 1.2 m in the south wall.
  const auto box = [&](const Vec3f& low, const Vec3f& high) {
    test.AddMesh(MakeBox(low, high), grey);
  };
  box({-0.2f, -0.2f, -0.2f}, {4.2f, 4.2f, 0});
  if (ceiling) box({-0.2f, -0.2f, 3}, {4.2f, 4.2f, 3.2f});
  box({-0.2f, 4, 0}, {4.2f, 4.2f, 3});
  box({-0.2f, 0, 0}, {0, 4, 3});
  box({4, 0, 0}, {4.2f, 4, 3});
  box({-0.2f, -0.2f, 0}, {1.2f, 0, 3});
  box({2.8f, -0.2f, 0}, {4.2f, 0, 3});
  box({1.2f, -0.2f, 0}, {2.8f, 0, 0.9f});
  box({1.2f, -0.2f, 2.1f}, {2.8f, 0, 3});
  v1::House* house = test.recipe.mutable_place()->mutable_house();
  v1::Room* room = house->add_rooms();
  room->set_width_m(4);
  room->set_depth_m(4);
  room->set_height_m(3);
  room->set_wall_thickness_m(0.2);
  v1::Opening* opening = room->add_openings();
  opening->set_kind(v1::Opening::KIND_WINDOW);
  opening->set_wall(0);
  opening->set_center_m(2);
  opening->set_width_m(1.6);
  opening->set_sill_m(0.9);
  opening->set_height_m(1.2);
  house->set_ceiling_removed(!ceiling);
  test.geometry.surroundings = HouseSurroundings(test.recipe.place());
  v1::Sky* sky = test.recipe.mutable_sky();
  sky->set_strength(1);
  *sky->mutable_tint() = ToProto(Vec3d::Ones());
  sky->set_sun_strength(sun);
  sky->set_sun_elevation_rad(0.7);
  sky->set_sun_azimuth_rad(-1.5);
  return test;
}

TEST(Lights, PortalsAgreeWithBruteForceAndBeatIt) {
  for (const bool ceiling : {true, false}) {
    const Built built = Build(WindowRoom(ceiling, 0));
    EXPECT_EQ(built.lights.portals(), ceiling ? 1u : 2u);
    for (const Vec3f& target : {Vec3f(2, 2, 0), Vec3f(1, 4, 1.5f), Vec3f(2, -0.1f, 0.9f)}) {
      const Vec3f eye(2, 1.8f, 1.6f);
      const Estimate both = Radiance(built, eye, target, 20000, 1);
      const Estimate brute = Radiance(built, eye, target, 60000, 1, DirectLight::kBsdfSampling);
      EXPECT_NEAR(both.mean.y(), brute.mean.y(), 4 * (both.error + brute.error))
          << target.transpose();
      EXPECT_GT(both.mean.y(), 0.0f);
      if (ceiling && target.x() != 2.0f) {
        EXPECT_LT(both.error, 0.7f * brute.error);
      }
    }
  }
}

TEST(Lights, EveryRoomOfAHouseHasItsPortals) {
  TestScene test = WindowRoom(true, 0);
  v1::House* house = test.recipe.mutable_place()->mutable_house();
  *house->add_rooms() = house->rooms(0);
  house->mutable_rooms(0)->clear_openings();
  house->mutable_rooms(0)->set_origin_x_m(-10);  // The first room stands apart and is closed.
  test.geometry.surroundings = HouseSurroundings(test.recipe.place());
  const Built built = Build(test);
  EXPECT_EQ(built.lights.portals(), 1u);
  const Vec3f eye(2, 1.8f, 1.6f), target(2.5f, 2, 0);
  const Estimate both = Radiance(built, eye, target, 20000, 1);
  const Estimate brute = Radiance(built, eye, target, 60000, 1, DirectLight::kBsdfSampling);
  EXPECT_NEAR(both.mean.y(), brute.mean.y(), 4 * (both.error + brute.error));
  EXPECT_LT(both.error, 0.7f * brute.error);
}

// Hills and trees stand before windows: the sky above them shines in.
TEST(Lights, AWindowBeforeAHillIsOpenAndOneBeforeAWallIsNot) {
  for (const bool wall : {false, true}) {
    TestScene test = WindowRoom(true, 0);
    const uint32_t grey = test.AddMaterial(DiffuseSample(Vec3f::Constant(0.3f)));
    const float distance = wall ? 0.3f : 60.0f;
    test.AddMesh(MakeBox({-500, -distance - 1, -1}, {500, -distance, 30}), grey);
    EXPECT_EQ(Build(test).lights.portals(), wall ? 0u : 1u);
  }
}

TEST(Lights, AnEnclosureEndsAtItsHalfSpaces) {
  TestScene test = WindowRoom(true, 0);
  const Vec3f askew = Vec3f(1, 1, 0).normalized();
  test.geometry.surroundings.enclosures[0].within = {{askew, askew.dot(Vec3f(2, 2, 0))}};
  const Built built = Build(test);
  EXPECT_EQ(test::Seek(built.lights, {1, 1, 1}).at().room, 0);
  EXPECT_EQ(test::Seek(built.lights, {3, 3, 1}).at().room, -1);
}

TEST(Lights, SunThroughTheWindowAgreesWithBruteForce) {
  const Built built = Build(WindowRoom(true, 1));
  // Points on the floor inside the patch of sunlight, and beside it.
  const Vec3f eye(2, 3, 1.6f);
  const Estimate lit = Radiance(built, eye, {2, 1.7f, 0}, 4000, 1);
  const Estimate shade = Radiance(built, eye, {0.5f, 3.5f, 0}, 4000, 1);
  EXPECT_GT(lit.mean.y(), 5 * shade.mean.y());
  // The disk's irradiance in closed form, plus the sky's share by the other estimator.
  const SkyModel& sky = built.lights.sky();
  const float sun =
      0.6f * kInvPi * sky.SunRadiance().y() * sky.sun_solid_angle() * sky.sun_direction().z();
  const Estimate without = Radiance(Build(WindowRoom(true, 1e-9)), eye, {2, 1.7f, 0}, 4000, 1);
  EXPECT_NEAR(lit.mean.y(), sun + without.mean.y(), 0.1f * lit.mean.y());
}

// A little light is no error beside the patch; none within it would be.
TEST(Lights, TheSunCountsWhereItsWayOutIsTheWindow) {
  const Built built = Build(WindowRoom(true, 1));
  const Vec3f sun = built.lights.sky().sun_direction();
  int lit = 0, dark = 0;
  for (int i = 0; i < 40 * 40 * 30; ++i) {
    const Vec3f p = 0.1f * Vec3f(static_cast<float>(i % 40), static_cast<float>(i / 40 % 40),
                                 static_cast<float>(i / 1600)) +
                    Vec3f::Constant(0.05f);
    // The point at which the way to the sun crosses the window's plane, in windows.
    const Vec3f q = p + sun * ((-0.2f - p.y()) / sun.y());
    const float a = (q.x() - 1.2f) / 1.6f, b = (q.z() - 0.9f) / 1.2f;
    const float inside = std::min({a, 1 - a, b, 1 - b});
    if (std::abs(inside + 0.03f) < 0.03f) continue;  // The rim.
    const LightReceiver at = test::Seek(built.lights, p).at();
    ASSERT_EQ(LightSampler(built.lights).Chance(at, 1) > 0, inside > 0) << p.transpose();
    ASSERT_GT(LightSampler(built.lights).Chance(at, 0), 0) << p.transpose();
    ++(inside > 0 ? lit : dark);
  }
  EXPECT_GT(lit, 1000);
  EXPECT_GT(dark, 10000);

  TestScene north = WindowRoom(true, 1);  // The sun stands behind the room.
  north.recipe.mutable_sky()->set_sun_azimuth_rad(1.5);
  const Built behind = Build(north);
  for (int i = 0; i < 1600; ++i) {
    const Vec3f p = 0.1f * Vec3f(static_cast<float>(i % 40), static_cast<float>(i / 40), 20);
    ASSERT_EQ(LightSampler(behind.lights).Chance(test::Seek(behind.lights, p).at(), 1), 0)
        << p.transpose();
  }
}

TEST(Lights, PlacesWithAGroundOfTheirOwnSeeTheHorizonsLightBelowIt) {
  v1::Sky sky;
  sky.set_strength(1);
  *sky.mutable_tint() = ToProto(Vec3d::Ones());
  const Vec3f level = Vec3f(1, 0, 0.04f).normalized(), down(0.6f, 0, -0.8f);
  const SkyModel grounded(sky), open(sky, /*ground=*/false);
  EXPECT_LT(grounded.Radiance(down).y(), 0.7f * grounded.Radiance(level).y());
  EXPECT_NEAR(open.Radiance(down).y(), open.Radiance(level).y(), 0.1f * open.Radiance(level).y());
  EXPECT_EQ(open.Radiance(level), grounded.Radiance(level));

  TestScene test;
  *test.recipe.mutable_sky() = sky;
  EXPECT_EQ(Build(test).lights.sky().Radiance(down), grounded.Radiance(down));
  test.geometry.surroundings.ground_below_horizon = false;
  EXPECT_EQ(Build(test).lights.sky().Radiance(down), open.Radiance(down));
}

TEST(Lights, OpenSkyAgreesWithBruteForce) {
  TestScene test = MakeFloor(0.5f);
  v1::Sky* sky = test.recipe.mutable_sky();
  sky->set_strength(0.8);
  sky->set_sun_strength(0.5);
  sky->set_sun_elevation_rad(
      -0.2);  // Below the horizon: glow but no disk, which brute force would miss.
  const Built built = Build(test);
  const Estimate both = Radiance(built, kEye, kTarget, 10000, 1);
  const Estimate brute = Radiance(built, kEye, kTarget, 40000, 1, DirectLight::kBsdfSampling);
  EXPECT_NEAR(both.mean.y(), brute.mean.y(), 4 * (both.error + brute.error));
}

TEST(Lights, GlossyReflectionsAgreeAcrossStrategies) {
  for (const float roughness : {0.2f, 0.5f}) {
    TestScene test;
    SurfaceSample gloss;
    gloss.base_color = Vec3f(0.7f, 0.5f, 0.3f);
    gloss.roughness = roughness;
    gloss.clearcoat = 0.5f;
    test.AddMesh(MakeQuad({-5, -5, 0}, {10, 0, 0}, {0, 10, 0}), test.AddMaterial(gloss));
    test.AddPointLight({-0.6, 0.5, 2}, 0.3, 50);
    const uint32_t black = test.AddMaterial(DiffuseSample(Vec3f::Zero()));
    test.AddMeshLight(test.AddMesh(MakeQuad({0, 0.3f, 1.2f}, {0, 0.8f, 0}, {1.5f, 0, 0}), black),
                      60);
    const Built built = Build(test);
    const Estimate both = Radiance(built, kEye, kTarget, 20000, 1);
    for (const DirectLight direct : {DirectLight::kLightSampling, DirectLight::kBsdfSampling}) {
      const Estimate one = Radiance(built, kEye, kTarget, 60000, 1, direct);
      EXPECT_NEAR(both.mean.y(), one.mean.y(), 4 * (both.error + one.error))
          << "roughness " << roughness << " strategy " << static_cast<int>(direct);
    }
  }
}

TEST(Lights, HalfOpenAndThinGlassWeakenLightAlikeForAllStrategies) {
  SurfaceSample gauze = DiffuseSample(Vec3f::Zero());
  gauze.opacity = 0.3f;
  SurfaceSample pane;
  pane.base_color = Vec3f(0.9f, 0.8f, 0.7f);
  pane.transmission = 1;
  pane.thin_walled = true;
  pane.roughness = 0;
  for (const SurfaceSample& sheet : {gauze, pane}) {
    TestScene test = MakeFloor(0.5f);
    const uint32_t black = test.AddMaterial(DiffuseSample(Vec3f::Zero()));
    test.AddMeshLight(test.AddMesh(MakeQuad({-0.5f, -0.5f, 1.2f}, {0, 1, 0}, {1, 0, 0}), black),
                      60);
    const float bare = Radiance(Build(test), {3, 3, 0.5f}, kTarget, 8000, 1).mean.x();
    test.AddMesh(MakeQuad({-0.7f, -0.7f, 0.9f}, {1.4f, 0, 0}, {0, 1.4f, 0}),
                 test.AddMaterial(sheet));
    const Built built = Build(test);
    const Estimate both = Radiance(built, {3, 3, 0.5f}, kTarget, 20000, 1);
    const Estimate brute =
        Radiance(built, {3, 3, 0.5f}, kTarget, 80000, 1, DirectLight::kBsdfSampling);
    EXPECT_NEAR(both.mean.x(), brute.mean.x(), 4 * (both.error + brute.error));
    EXPECT_NEAR(both.mean.x() / bare, sheet.opacity < 1 ? 0.7f : 0.9f * 0.92f, 0.03f);
  }
}

TEST(Lights, InterreflectionInAClosedBoxSumsTheSeries) {
  // Every wall sends out E and reflects half: radiance E (1 + 1/2 + 1/4 + ...) = 2 E.
  TestScene test;
  const uint32_t grey = test.AddMaterial(DiffuseSample(Vec3f::Constant(0.5f)));
  const uint32_t walls = test.AddMesh(MakeBox({-1, -1, -1}, {1, 1, 1}, true), grey);
  test.AddMeshLight(walls, M_PI * 24);
  const Estimate seen = Radiance(Build(test), {0, 0, 0}, {0.3f, 0.2f, -1}, 8000, 20);
  EXPECT_NEAR(seen.mean.x(), 2.0f, 4 * seen.error + 1e-3f);
}

TEST(Lights, UnknownKindIsRefusedByName) {
  TestScene test = MakeFloor(0.5f);
  v1::Light* light = test.recipe.add_lights();
  light->set_name("odd");
  *light->mutable_power_w() = ToProto(Vec3d::Ones());
  const auto scene = RenderScene::Build(test.geometry, 0);
  const auto lights = LightTable::Build(test.recipe, **scene);
  EXPECT_EQ(lights.status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_NE(std::string(lights.status().message()).find("odd"), std::string::npos);
}

}  // namespace
}  // namespace parallax
