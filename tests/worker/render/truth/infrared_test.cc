// A projector's dots and infrared pictures: closed forms of geometry and energy.
#include "worker/render/truth/infrared.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <numbers>

#include "tests/worker/render/render_frame.h"
#include "worker/render/truth/ground_truth.h"

namespace parallax {
namespace {

using test::BoxRoomRig;
using test::DiffuseSample;
using test::MakeBoxRoom;
using test::MakeConfig;
using test::MakeQuad;
using test::MakeRig;
using test::RenderFrame;
using test::TestScene;

constexpr float kAlbedo = 0.8f;

v1::Projector MakeProjector(double power_w, int dots, double fov_deg, double dot_deg,
                            double place_m = 0) {
  v1::Projector projector;
  projector.set_power_w(power_w);
  projector.set_dots(dots);
  projector.set_horizontal_fov_rad(fov_deg * std::numbers::pi / 180);
  projector.set_vertical_fov_rad(fov_deg * std::numbers::pi / 180);
  projector.set_dot_rad(dot_deg * std::numbers::pi / 180);
  projector.set_place_m(place_m);
  projector.set_seed(7);
  return projector;
}

// A wall at y = `distance`, which a rig at the origin looks at.
TestScene WallScene(float distance) {
  TestScene scene;
  const uint32_t grey = scene.AddMaterial(DiffuseSample(Vec3f::Constant(kAlbedo)));
  scene.AddMesh(MakeQuad({-20, distance, -20}, {40, 0, 0}, {0, 0, 40}), grey);
  return scene;
}

struct Lit {
  StereoCamera stereo;
  DotPattern pattern;
  Vec3d origin;
  ImageF eyes[2];
};

Lit Trace(const TestScene& scene, const v1::Rig& rig) {
  const auto built = *RenderScene::Build(scene.geometry, 0);
  const StereoCamera stereo = *StereoCamera::FromRig(rig);
  Lit lit{stereo, *DotPattern::Make(rig.projector()), {}, {}};
  const PinholeCamera& left = stereo.eyes[0];
  lit.origin = left.origin + rig.projector().place_m() * left.world_from_camera.col(0);
  for (int eye = 0; eye < 2; ++eye) {
    lit.eyes[eye] = *TraceProjector(*built, stereo.eyes[eye], lit.pattern, lit.origin,
                                    {1, 0, static_cast<uint32_t>(eye), 5}, {});
  }
  return lit;
}

Vec2d PixelOf(const PinholeCamera& camera, const Vec3d& point) {
  const Vec3d at = camera.world_from_camera.transpose() * (point - camera.origin);
  return {at.x() / at.z() * camera.fx_px + camera.cx_px,
          at.y() / at.z() * camera.fy_px + camera.cy_px};
}

// Where a dot meets the wall at y = `distance`; the rig looks along y.
Vec3d OnWall(const Lit& lit, const Vec2f& dot, double distance) {
  const Vec3d way = lit.stereo.eyes[0].world_from_camera * Vec3d(dot.x(), dot.y(), 1);
  return lit.origin + way * (distance / way.y());
}

// Middle of the light within 3 px of `at`; false near the border, or where other dots are near.
bool Centroid(const ImageF& image, const Vec2d& at, const std::vector<Vec2d>& dots, Vec2d* middle) {
  constexpr int kReach = 3;
  const int cx = static_cast<int>(std::floor(at.x())), cy = static_cast<int>(std::floor(at.y()));
  if (cx < kReach || cy < kReach || cx + kReach >= image.width() || cy + kReach >= image.height()) {
    return false;
  }
  int near = 0;
  for (const Vec2d& dot : dots) near += (dot - at).cwiseAbs().maxCoeff() < 2 * kReach + 2;
  if (near > 1) return false;
  Vec2d sum = Vec2d::Zero();
  double light = 0;
  for (int y = cy - kReach; y <= cy + kReach; ++y) {
    for (int x = cx - kReach; x <= cx + kReach; ++x) {
      const double value = double{image(x, y)};
      sum += value * Vec2d(x + 0.5, y + 0.5);
      light += value;
    }
  }
  if (!(light > 0)) return false;
  *middle = sum / light;
  return true;
}

TEST(Infrared, DotsOnAWallStandWhereGeometrySaysInBothEyes) {
  constexpr double kDistance = 2;
  v1::Rig rig = MakeRig({0, 0, 0}, {0, 1, 0}, 320, 240, 250, 0.1);
  // Dots of 0.6 px (1 sigma): the middles of smaller ones can't be told from pixels.
  *rig.mutable_projector() = MakeProjector(1, 400, 60, 0.55, 0.06);
  const Lit lit = Trace(WallScene(kDistance), rig);
  std::vector<Vec2d> places[2];
  for (const Vec2f& dot : lit.pattern.dots()) {
    for (int eye = 0; eye < 2; ++eye) {
      places[eye].push_back(PixelOf(lit.stereo.eyes[eye], OnWall(lit, dot, kDistance)));
    }
  }
  int seen = 0;
  for (size_t i = 0; i < places[0].size(); ++i) {
    Vec2d middles[2];
    if (!Centroid(lit.eyes[0], places[0][i], places[0], &middles[0]) ||
        !Centroid(lit.eyes[1], places[1][i], places[1], &middles[1])) {
      continue;
    }
    ++seen;
    EXPECT_LT((middles[0] - places[0][i]).norm(), 0.01) << i;
    EXPECT_LT((middles[1] - places[1][i]).norm(), 0.01) << i;
    EXPECT_NEAR(middles[0].x() - middles[1].x(), 250 * 0.1 / kDistance, 0.01) << i;
  }
  EXPECT_GT(seen, 60);
}

TEST(Infrared, EveryDotOfThePatternIsOnTheWall) {
  v1::Rig rig = MakeRig({0, 0, 0}, {0, 1, 0}, 640, 640, 500, 0.1);
  *rig.mutable_projector() = MakeProjector(1, 300, 50, 0.2);
  const Lit lit = Trace(WallScene(2), rig);
  EXPECT_EQ(lit.pattern.dots().size(), 300u);
  const ImageF& image = lit.eyes[0];
  int dots = 0;
  for (int y = 1; y + 1 < image.height(); ++y) {
    for (int x = 1; x + 1 < image.width(); ++x) {
      bool top = image(x, y) > 0;
      for (int k = 0; k < 9; ++k) {
        top = top && (k == 4 || image(x, y) > image(x + k % 3 - 1, y + k / 3 - 1));
      }
      dots += top;
    }
  }
  // Two that lie together count once, and so does one that falls between pixels.
  EXPECT_LE(dots, 300);
  EXPECT_GE(dots, 290);
}

// The light of all dots that a grey wall sends back, seen from where the projector stands.
double PowerFrom(float distance) {
  v1::Rig rig = MakeRig({0, 0, 0}, {0, 1, 0}, 320, 320, 250, 0.1);
  *rig.mutable_projector() = MakeProjector(0.36, 500, 55, 0.12);
  const Lit lit = Trace(WallScene(distance), rig);
  double sum = 0;
  for (const float radiance : lit.eyes[0].values()) sum += double{radiance};
  const double pixel_m2 = Square(distance / 250);
  return sum * pixel_m2 * std::numbers::pi / double{kAlbedo};
}

TEST(Infrared, LightOfDotsFallsWithTheSquareOfDistanceAndKeepsItsPower) {
  for (const float distance : {0.5f, 1.0f, 2.0f, 4.0f}) {
    EXPECT_NEAR(PowerFrom(distance), 0.36, 0.36 * 0.01) << distance << " m";
  }
}

TEST(Infrared, ThingsCastTheProjectorsShadow) {
  v1::Rig rig = MakeRig({0, 0, 0}, {0, 1, 0}, 160, 120, 120, 0.2);
  *rig.mutable_projector() = MakeProjector(1, 60, 80, 12, 0.1);  // Dots so wide that all is lit.
  TestScene with = WallScene(3);
  const Lit open = Trace(with, rig);
  const uint32_t grey = with.AddMaterial(DiffuseSample(Vec3f::Constant(kAlbedo)));
  with.AddMesh(MakeQuad({-0.3f, 1.5f, -0.2f}, {0.4f, 0, 0}, {0, 0, 0.4f}), grey);
  const Lit behind = Trace(with, rig);
  const PinholeCamera& eye = open.stereo.eyes[0];
  int dark = 0, lit = 0;
  for (int y = 0; y < 120; ++y) {
    for (int x = 0; x < 160; ++x) {
      int shadowed = 0, hidden = 0;
      for (int corner = 0; corner < 4; ++corner) {
        const auto crosses = [](const Vec3d& p) {
          return p.x() >= -0.3 && p.x() <= 0.1 && p.z() >= -0.2 && p.z() <= 0.2;
        };
        const Vec3d way = eye.world_from_camera * eye.DirectionAt(x + corner % 2, y + corner / 2);
        const Vec3d wall = eye.origin + way * (3 / way.y());
        hidden += crosses(eye.origin + way * (1.5 / way.y()));
        shadowed += crosses((wall + open.origin) / 2);
      }
      if (hidden > 0) continue;
      if (shadowed == 4) {
        EXPECT_EQ(behind.eyes[0](x, y), 0) << x << ", " << y;
        ++dark;
      } else if (shadowed == 0) {
        EXPECT_EQ(behind.eyes[0](x, y), open.eyes[0](x, y)) << x << ", " << y;
        ++lit;
      }
    }
  }
  EXPECT_GT(dark, 100);
  EXPECT_GT(lit, 10000);
}

TEST(Infrared, MirrorsShowTheDotsOfWhatTheyShow) {
  constexpr double kDistance = 3;
  TestScene scene = WallScene(kDistance);
  SurfaceSample silver;
  silver.base_color = Vec3f::Constant(0.95f);
  silver.metallic = 1;
  silver.roughness = 0.001f;
  // At x = 1, from 1.2 m on: its image of the wall lies behind it.
  scene.AddMesh(MakeQuad({1, 3, -2}, {0, -1.8f, 0}, {0, 0, 4}), scene.AddMaterial(silver));
  v1::Rig rig = MakeRig({0, 0, 0}, {0, 1, 0}, 400, 300, 250, 0.1);
  *rig.mutable_projector() = MakeProjector(1, 300, 60, 0.9, 0.05);
  const Lit lit = Trace(scene, rig);
  std::vector<Vec2d> places;
  for (const Vec2f& dot : lit.pattern.dots()) {
    Vec3d point = OnWall(lit, dot, kDistance);
    if (point.x() > 0.99) continue;  // It meets the mirror before.
    point.x() = 2 - point.x();
    places.push_back(PixelOf(lit.stereo.eyes[0], point));
  }
  int seen = 0;
  for (const Vec2d& place : places) {
    Vec2d middle;
    // The mirror ends where it meets the wall.
    if (place.x() < 200 + 250 / kDistance + 6 || !Centroid(lit.eyes[0], place, places, &middle)) {
      continue;
    }
    // The mirror is a little rough, and a pixel has nine samples of it.
    EXPECT_LT((middle - place).norm(), 0.12);
    ++seen;
  }
  EXPECT_GT(seen, 5);
}

TEST(Infrared, PanesWeakenDotsOnBothWays) {
  v1::Rig rig = MakeRig({0, 0, 0}, {0, 1, 0}, 96, 96, 80, 0.1);
  *rig.mutable_projector() = MakeProjector(1, 60, 70, 15, 0.05);
  TestScene scene = WallScene(3);
  const Lit open = Trace(scene, rig);
  SurfaceSample glass;
  glass.base_color = Vec3f::Ones();
  glass.transmission = 1;
  glass.thin_walled = true;
  glass.roughness = 0;
  glass.ior = 1.5f;
  // Aslant, so that it does not mirror the projector into the eye.
  scene.AddMesh(MakeQuad({-5, -0.2f, -1.2f}, {10, 0, 0}, {0, 3.4f, 3.4f}),
                scene.AddMaterial(glass));
  const Lit pane = Trace(scene, rig);
  double without = 0, with = 0;
  for (const float value : open.eyes[0].values()) without += double{value};
  for (const float value : pane.eyes[0].values()) with += double{value};
  // A pane lets 92 % through at a right angle, 90 % at 45 degrees and 65 % at 75: what the corners
  // of the picture see.
  EXPECT_GT(with / without, 0.70);
  EXPECT_LT(with / without, 0.90 * 0.90);
}

TEST(Infrared, ColourAndTruthAreThoseOfFramesWithoutIt) {
  const TestScene room = MakeBoxRoom();
  v1::RenderConfig config = MakeConfig(4, 3, /*denoise=*/true, "preview");
  v1::Rig rig = BoxRoomRig(96, 64);
  const StereoFrame plain = RenderFrame(room, config, rig);
  EXPECT_TRUE(plain.left.infrared.empty());
  config.add_maps("infrared");
  const StereoFrame ambient = RenderFrame(room, config, rig);
  *rig.mutable_projector() = MakeProjector(2, 2000, 80, 0.3, 0.05);
  const StereoFrame dots = RenderFrame(room, config, rig);
  for (const StereoFrame* frame : {&ambient, &dots}) {
    for (const auto view : {&StereoFrame::left, &StereoFrame::right}) {
      const View &seen = frame->*view, &wanted = plain.*view;
      EXPECT_EQ(seen.color, wanted.color);
      EXPECT_EQ(seen.radiance, wanted.radiance);
      EXPECT_EQ(seen.depth_m, wanted.depth_m);
      EXPECT_EQ(seen.disparity_px, wanted.disparity_px);
      EXPECT_EQ(seen.occlusion, wanted.occlusion);
      EXPECT_EQ(seen.objects, wanted.objects);
      EXPECT_EQ(seen.materials, wanted.materials);
      EXPECT_EQ(seen.normals, wanted.normals);
      EXPECT_EQ(seen.masks, wanted.masks);
    }
    EXPECT_EQ(frame->exposure, plain.exposure);
  }
  EXPECT_FALSE(ambient.left.infrared == dots.left.infrared);
  EXPECT_GT(ambient.left.infrared(48, 32), 10) << "without a projector it shows the room";
}

TEST(Infrared, PicturesDoNotDependOnThreads) {
  const TestScene room = MakeBoxRoom();
  v1::RenderConfig config = MakeConfig(2, 2, /*denoise=*/false);
  config.add_maps("infrared");
  v1::Rig rig = BoxRoomRig(96, 64);
  *rig.mutable_projector() = MakeProjector(2, 2000, 80, 0.3, 0.05);
  const StereoFrame many = RenderFrame(room, config, rig);
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const StereoFrame alone = RenderFrame(room, config, rig);
  EXPECT_EQ(many.left.infrared, alone.left.infrared);
  EXPECT_EQ(many.right.infrared, alone.right.infrared);
}

TEST(DotPattern, SendsOutItsPower) {
  const DotPattern pattern = *DotPattern::Make(MakeProjector(0.5, 40, 60, 1.5));
  constexpr int kSteps = 1400;
  const double half = std::tan(40 * std::numbers::pi / 180);
  double sum = 0;
  for (int i = 0; i < kSteps * kSteps; ++i) {
    const double u = half * (2.0 * (i % kSteps + 0.5) / kSteps - 1);
    const double v = half * (2.0 * (i / kSteps + 0.5) / kSteps - 1);
    const double solid_angle = Square(2 * half / kSteps) / std::pow(1 + u * u + v * v, 1.5);
    sum += double{pattern.Intensity(Vec3d(u, v, 1).cast<float>(), {})} * solid_angle;
  }
  EXPECT_NEAR(sum, 0.5, 0.5 * 0.005);
}

TEST(DotPattern, ADeviceKeepsItsPattern) {
  v1::Projector projector = MakeProjector(0.5, 5000, 70, 0.1);
  const DotPattern one = *DotPattern::Make(projector), same = *DotPattern::Make(projector);
  EXPECT_EQ(one.dots(), same.dots());
  projector.set_seed(8);
  EXPECT_NE(one.dots(), DotPattern::Make(projector)->dots());
  const float edge = std::tan(35 * kPi / 180);
  for (const Vec2f& dot : one.dots()) EXPECT_LE(dot.cwiseAbs().maxCoeff(), edge);
}

TEST(DotPattern, RefusesNumbersThatAreNone) {
  const v1::Projector good = MakeProjector(1, 10, 60, 1);
  EXPECT_TRUE(DotPattern::Make(good).ok());
  v1::Projector bad[4] = {good, good, good, good};
  bad[0].set_power_w(NAN);
  bad[1].set_dot_rad(0);
  bad[2].set_vertical_fov_rad(3.2);
  bad[3].set_dots(-1);
  for (const v1::Projector& projector : bad) {
    EXPECT_EQ(DotPattern::Make(projector).status().code(), absl::StatusCode::kInvalidArgument)
        << projector.ShortDebugString();
  }
}

}  // namespace
}  // namespace parallax
