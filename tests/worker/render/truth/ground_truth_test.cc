// Ground truth against exact geometry.
#include "worker/render/truth/ground_truth.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/worker/render/test_scenes.h"

namespace parallax {
namespace {

using test::BoxRoomRig;
using test::DiffuseSample;
using test::MakeBox;
using test::MakeBoxRoom;
using test::MakeQuad;
using test::MakeRig;
using test::MakeSphere;
using test::TestScene;

struct Truth {
  std::unique_ptr<RenderScene> scene;
  StereoCamera stereo;
  View left, right;
};

Truth Trace(const TestScene& test, const v1::Rig& rig) {
  Truth truth;
  auto scene = RenderScene::Build(test.geometry, 0);
  EXPECT_TRUE(scene.ok()) << scene.status();
  truth.scene = *std::move(scene);
  auto stereo = StereoCamera::FromRig(rig);
  EXPECT_TRUE(stereo.ok()) << stereo.status();
  truth.stereo = *stereo;
  View* views[2] = {&truth.left, &truth.right};
  for (int eye = 0; eye < 2; ++eye) {
    EXPECT_TRUE(
        TraceGroundTruth(*truth.scene, truth.stereo.eyes[eye], rig.baseline_m(), {}, views[eye])
            .ok());
  }
  MarkOcclusion(&truth.left, &truth.right);
  return truth;
}

TEST(GroundTruth, DepthOfATiltedPlaneIsExactToFloatPrecision) {
  TestScene test;
  const uint32_t grey = test.AddMaterial(DiffuseSample(Vec3f::Constant(0.5f)));
  // z = 0.25 y - 1, large.
  test.AddMesh(MakeQuad({-64, -64, -17}, {128, 0, 0}, {0, 128, 32}), grey);
  const v1::Rig rig = MakeRig({0.3, -0.2, 1}, {0.1, 1, -0.4}, 160, 120, 130, 0.15);
  const Truth truth = Trace(test, rig);
  const View* views[2] = {&truth.left, &truth.right};
  int seen = 0;
  for (int eye = 0; eye < 2; ++eye) {
    const PinholeCamera& camera = truth.stereo.eyes[eye];
    for (int y = 0; y < 120; ++y) {
      for (int x = 0; x < 160; ++x) {
        const float depth = views[eye]->depth_m(x, y);
        if (depth == 0) continue;
        ++seen;
        const Vec3d d = camera.world_from_camera * camera.DirectionAt(x + 0.5, y + 0.5);
        const Vec3d n(0, -0.25, 1);
        const double wanted = (-1 - n.dot(camera.origin)) / n.dot(d);
        ASSERT_NEAR(depth, wanted, 2e-7 * wanted) << x << " " << y;
      }
    }
  }
  EXPECT_GT(seen, 20000);
}

// Nearest hit over all triangles in double precision.
double BruteForceDepth(const RenderScene& scene, const PinholeCamera& camera, int x, int y) {
  const Vec3d d = camera.world_from_camera * camera.DirectionAt(x + 0.5, y + 0.5);
  double nearest = std::numeric_limits<double>::infinity();
  for (uint32_t p = 0; p < scene.geometry().meshes.size(); ++p) {
    for (uint32_t t = 0; t < scene.geometry().meshes[p].mesh->triangles.size(); ++t) {
      Vec3f corners[3];
      scene.Corners(p, t, corners);
      const Vec3d a = corners[0].cast<double>();
      const Vec3d e1 = corners[1].cast<double>() - a, e2 = corners[2].cast<double>() - a;
      const Vec3d q = d.cross(e2);
      const double det = e1.dot(q);
      if (det == 0) continue;
      const Vec3d s = camera.origin - a;
      const double u = s.dot(q) / det;
      const Vec3d r = s.cross(e1);
      const double v = d.dot(r) / det;
      const double z = e2.dot(r) / det;
      if (u >= -1e-9 && v >= -1e-9 && u + v <= 1 + 1e-9 && z > 0) nearest = std::min(nearest, z);
    }
  }
  return nearest;
}

TEST(GroundTruth, DepthOfABallIsExactAlsoWhenInstanced) {
  TestScene test;
  const uint32_t grey = test.AddMaterial(DiffuseSample(Vec3f::Constant(0.5f)));
  const auto ball = MakeSphere({0, 0, 0}, 0.5f, 24);
  Eigen::Affine3f left = Eigen::Affine3f::Identity(), right = left;
  left.translate(Vec3f(-0.7f, 3, 0));
  right.translate(Vec3f(0.7f, 3.4f, 0.1f))
      .rotate(Eigen::AngleAxisf(1.0f, Vec3f(1, 2, 3).normalized()))
      .scale(1.3f);
  test.AddMesh(ball, grey, left);  // Two uses: instances.
  test.AddMesh(ball, grey, right);
  test.AddMesh(MakeSphere({0, 4, 1}, 0.4f, 24), grey);
  const Truth truth = Trace(test, MakeRig({0, 0, 0.2}, {0, 1, 0}, 64, 48, 60, 0.1));
  int seen = 0;
  for (int y = 0; y < 48; ++y) {
    for (int x = 0; x < 64; ++x) {
      const double wanted = BruteForceDepth(*truth.scene, truth.stereo.eyes[0], x, y);
      const float depth = truth.left.depth_m(x, y);
      if (!std::isfinite(wanted)) {
        ASSERT_EQ(depth, 0.0f);
        continue;
      }
      ++seen;
      ASSERT_NEAR(depth, wanted, 1e-6 * wanted) << x << " " << y;
      // Normals of a ball are known too.
      const Vec3d d = truth.stereo.eyes[0].world_from_camera *
                      truth.stereo.eyes[0].DirectionAt(x + 0.5, y + 0.5);
      const Vec3d p = truth.stereo.eyes[0].origin + wanted * d;
      const uint16_t object = truth.left.objects(x, y);
      const Vec3d center = object == 1   ? Vec3d(-0.7, 3, 0)
                           : object == 2 ? Vec3d(0.7, 3.4, 0.1)
                                         : Vec3d(0, 4, 1);
      const Vec3d n =
          truth.stereo.eyes[0].world_from_camera.transpose() * (p - center).normalized();
      const float* seen_normal = truth.left.normals.At(x, y);
      EXPECT_GT(n.dot(Vec3d(seen_normal[0], seen_normal[1], seen_normal[2])), 0.995)
          << x << " " << y;
    }
  }
  EXPECT_GT(seen, 500);
}

TEST(GroundTruth, DisparityTimesDepthIsFocalLengthTimesBaseline) {
  const v1::Rig rig = BoxRoomRig(128, 96);
  const Truth truth = Trace(MakeBoxRoom(), rig);
  for (const View* view : {&truth.left, &truth.right}) {
    for (size_t i = 0; i < view->depth_m.pixels(); ++i) {
      const double product =
          static_cast<double>(view->depth_m.data()[i]) * view->disparity_px.data()[i];
      ASSERT_NEAR(product, rig.fx_px() * rig.baseline_m(), 1e-5);
    }
  }
}

TEST(GroundTruth, AllMapsAreFiniteAndNormalsFaceTheCamera) {
  const Truth truth = Trace(MakeBoxRoom(), BoxRoomRig(128, 96));
  const PinholeCamera& camera = truth.stereo.eyes[0];
  for (int y = 0; y < 96; ++y) {
    for (int x = 0; x < 128; ++x) {
      ASSERT_TRUE(std::isfinite(truth.left.depth_m(x, y)));
      const float* n = truth.left.normals.At(x, y);
      const Vec3d normal(n[0], n[1], n[2]);
      ASSERT_NEAR(normal.norm(), 1.0, 1e-5);
      ASSERT_LT(normal.dot(camera.DirectionAt(x + 0.5, y + 0.5)), 1e-5);
    }
  }
}

TEST(GroundTruth, OcclusionAgreesWithExactVisibility) {
  const Truth truth = Trace(MakeBoxRoom(), BoxRoomRig(320, 240));
  const View* views[2] = {&truth.left, &truth.right};
  for (int eye = 0; eye < 2; ++eye) {
    const View& view = *views[eye];
    const PinholeCamera& camera = truth.stereo.eyes[eye];
    const PinholeCamera& other = truth.stereo.eyes[1 - eye];
    int wrong = 0, occluded = 0, out_of_view = 0;
    for (int y = 0; y < 240; ++y) {
      for (int x = 0; x < 320; ++x) {
        const double z = view.depth_m(x, y);
        const double landing = x + 0.5 + (eye == 0 ? -1 : 1) * view.disparity_px(x, y);
        if (landing < 0 || landing >= 320) {
          ++out_of_view;
          ASSERT_EQ(view.occlusion(x, y), 255);
          continue;
        }
        const Vec3d p =
            camera.origin + camera.world_from_camera * camera.DirectionAt(x + 0.5, y + 0.5) * z;
        const Vec3d to = p - other.origin;
        Ray ray;
        ray.origin = other.origin.cast<float>();
        ray.direction = to.normalized().cast<float>();
        RawHit hit;
        const bool hidden = truth.scene->trees().Intersect(RayTrees::Tree::kRobust, ray, 0, &hit) &&
                            hit.distance < to.norm() * (1 - kOcclusionThreshold);
        occluded += hidden;
        if (hidden != (view.occlusion(x, y) == 255)) ++wrong;
      }
    }
    EXPECT_GT(occluded, 500);
    EXPECT_GT(out_of_view, 500);
    // Silhouettes fall between pixel centres: at most about a pixel a row and edge.
    EXPECT_LT(wrong, 320 * 240 / 200);
  }
}

TEST(GroundTruth, SlantedSurfacesAreNotOccludedByThemselves) {
  TestScene test;
  const uint32_t grey = test.AddMaterial(DiffuseSample(Vec3f::Constant(0.5f)));
  test.AddMesh(MakeQuad({-40, -40, 0}, {80, 0, 0}, {0, 80, 0}), grey);  // A floor seen flat,
  test.AddMesh(MakeQuad({0.6f, 0, 0}, {0, 40, 0}, {0.2f, 0, 30}),
               grey);  // a wall seen from along it.
  const Truth truth = Trace(test, MakeRig({0, 0, 0.5}, {0, 1, 0}, 320, 240, 200, 0.1));
  int occluded = 0, counted = 0;
  for (int y = 0; y < 240; ++y) {
    for (int x = 0; x < 320; ++x) {
      const double landing = x + 0.5 - truth.left.disparity_px(x, y);
      if (truth.left.depth_m(x, y) == 0 || landing < 1 || landing > 319) continue;
      ++counted;
      occluded += truth.left.occlusion(x, y) == 255;
    }
  }
  EXPECT_GT(counted, 30000);
  EXPECT_LT(occluded, counted / 500);
}

// Black and clear stripes 10 cm wide along x.
class Stripes : public PointMaterial {
 public:
  SurfaceSample EvaluatePoint(const SurfacePoint& point) const override {
    SurfaceSample s;
    s.opacity = std::fmod(point.texture_m.x(), 0.2f) < 0.1f ? 1.0f : 0.0f;
    return s;
  }
};

TEST(GroundTruth, HolesShowWhatIsBehindThem) {
  TestScene test;
  const uint32_t stripes = test.AddMaterial(std::make_shared<Stripes>());
  const uint32_t grey = test.AddMaterial(DiffuseSample(Vec3f::Constant(0.5f)));
  test.AddMesh(MakeQuad({-1, 2, -1}, {2, 0, 0}, {0, 0, 2}), stripes);
  test.AddMesh(MakeQuad({-9, 4, -9}, {18, 0, 0}, {0, 0, 18}), grey);
  const Truth truth = Trace(test, MakeRig({0, 0, 0}, {0, 1, 0}, 200, 40, 200, 0.1));
  int holes = 0, bars = 0;
  for (int x = 0; x < 200; ++x) {
    const double at = (x + 0.5 - 100) / 200 * 2 + 1;  // Along the quad.
    const double in_stripe = std::fmod(at, 0.2);
    if (std::min({std::abs(in_stripe - 0.1), in_stripe, 0.2 - in_stripe}) < 1e-3) continue;
    const bool bar = in_stripe < 0.1;
    ASSERT_NEAR(truth.left.depth_m(x, 20), bar ? 2 : 4, 1e-5) << x;
    ASSERT_EQ(truth.left.objects(x, 20), bar ? 1 : 2);
    (bar ? bars : holes) += 1;
  }
  EXPECT_GT(bars, 50);
  EXPECT_GT(holes, 50);
}

TEST(GroundTruth, MasksTellSkyExteriorGlassAndMirrors) {
  TestScene test;
  SurfaceSample glass;
  glass.transmission = 1;
  glass.roughness = 0;
  SurfaceSample mirror;
  mirror.metallic = 1;
  mirror.roughness = 0.02f;
  const uint32_t grey = test.AddMaterial(DiffuseSample(Vec3f::Constant(0.5f)));
  test.AddMesh(MakeQuad({0, 2, 0}, {1, 0, 0}, {0, 0, 1}), test.AddMaterial(glass));
  test.AddMesh(MakeQuad({1, 2, 0}, {1, 0, 0}, {0, 0, 1}), test.AddMaterial(mirror));
  test.AddMesh(MakeQuad({2, 2, 0}, {1, 0, 0}, {0, 0, 1}), grey);
  test.AddMesh(MakeQuad({3, 9, 0}, {4, 0, 0}, {0, 0, 4}), grey);  // Beyond the room.
  test.geometry.surroundings.interiors = {Box3f(Vec3f(0, 0, 0), Vec3f(4, 4, 3))};
  const Truth truth = Trace(test, MakeRig({2, 0, 0.5}, {0, 1, 0}, 200, 60, 100, 0.1));
  const auto mask = [&](double x, double depth) {
    return truth.left.masks(static_cast<int>((x - 2) / depth * 100 + 100), 30);
  };
  EXPECT_EQ(mask(0.5, 2), kMaskTransparent);
  EXPECT_EQ(mask(1.5, 2), kMaskMirror);
  EXPECT_EQ(mask(2.5, 2), 0);
  EXPECT_EQ(mask(6.8, 9), kMaskExterior);
  EXPECT_EQ(mask(-1, 9) & kMaskTransparent, 0);
  EXPECT_EQ(truth.left.masks(1, 1), kMaskSky);
  EXPECT_EQ(truth.left.depth_m(1, 1), 0.0f);
  EXPECT_EQ(truth.left.disparity_px(1, 1), 0.0f);
  EXPECT_EQ(truth.left.occlusion(1, 1), 0);
}

TEST(GroundTruth, WaterIsMarkedAsTransparentAndMirrorLikeThoughOpaque) {
  TestScene test;
  const uint32_t grey = test.AddMaterial(DiffuseSample(Vec3f::Constant(0.5f)));
  const auto water = std::make_shared<Mesh>(*MakeQuad({0, 2, 0}, {1, 0, 0}, {0, 0, 1}));
  ASSERT_EQ(water->slots.size(), 1u);
  water->slots[0].families = {"water"};
  test.AddMesh(water, grey);
  test.AddMesh(MakeQuad({1, 2, 0}, {1, 0, 0}, {0, 0, 1}), grey);
  const Truth truth = Trace(test, MakeRig({1, 0, 0.5}, {0, 1, 0}, 200, 60, 100, 0.1));
  EXPECT_EQ(truth.left.masks(75, 30), kMaskTransparent | kMaskMirror);
  EXPECT_EQ(truth.left.masks(125, 30), 0);
  EXPECT_NEAR(truth.left.depth_m(75, 30), 2, 1e-5) << "its surface, not its bed";
}

TEST(GroundTruth, BrokenRigsAreRefused) {
  const v1::Rig good = BoxRoomRig(64, 48);
  EXPECT_TRUE(StereoCamera::FromRig(good).ok());
  v1::Rig rig = good;
  rig.set_width_px(0);
  EXPECT_EQ(StereoCamera::FromRig(rig).status().code(), absl::StatusCode::kInvalidArgument);
  rig = good;
  rig.set_fx_px(std::nan(""));
  EXPECT_EQ(StereoCamera::FromRig(rig).status().code(), absl::StatusCode::kInvalidArgument);
  rig = good;
  rig.set_baseline_m(0);
  EXPECT_EQ(StereoCamera::FromRig(rig).status().code(), absl::StatusCode::kInvalidArgument);
}

}  // namespace
}  // namespace parallax
