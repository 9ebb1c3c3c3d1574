#include "worker/render/surface/relief.h"

#include <gtest/gtest.h>

#include <cmath>

namespace parallax {
namespace {

constexpr float kWave_m = 0.01f;  // 2 pi / its length.
constexpr float kHeight_m = 5e-4f;

// Waves along the texture's x; footprints wider than a limit do not see them.
class Waves final : public PointMaterial {
 public:
  explicit Waves(float widest_m = 0.1f) : widest_m_(widest_m) {}
  float widest_relief_m() const override { return widest_m_; }

 protected:
  SurfaceSample EvaluatePoint(const SurfacePoint&) const override { return {}; }
  float HeightOfPoint(const SurfacePoint& point) const override {
    return kHeight_m * std::sin(point.texture_m.x() / kWave_m);
  }

 private:
  float widest_m_;
};

// Points on the plane z = 0, on triangles of which none is like another; texture as the world, but
// turned: its x runs along the world's y.
struct Eight {
  SurfacePoint8 points;
  Faces8 faces;
  Vec3x8 normals = Vec3f(0, 0, 1);

  Eight() {
    SurfacePoint point[kLanes];
    for (int lane = 0; lane < kLanes; ++lane) {
      const auto k = static_cast<float>(lane);
      point[lane].texture_m = Vec3f(0.004f * k, 0.1f, 0);
      point[lane].footprint_m = 2e-4f;
      const Vec3f edges[2] = {Vec3f(0.3f, 0.02f * k, 0), Vec3f(-0.1f, 0.2f + 0.1f * k, 0)};
      for (int e = 0; e < 2; ++e) SetEdge(lane, e, edges[e]);
    }
    points = SurfacePoint8(point);
  }
  void SetEdge(int lane, int which, const Vec3f& edge) {
    faces.edge[which].Set(lane, edge);
    faces.texture_edge[which].Set(lane, Vec3f(edge.y(), -edge.x(), 0));
    faces.u_edge[which][lane] = faces.v_edge[which][lane] = 0;
  }
};

TEST(Relief, NormalsFollowTheSlopeOfTheHeights) {
  const Eight eight;
  const Vec3x8 bent = BendNormals(Waves(), eight.points, eight.faces, eight.normals);
  for (int lane = 0; lane < kLanes; ++lane) {
    const float slope = kHeight_m / kWave_m * std::cos(eight.points.texture_m.x[lane] / kWave_m);
    const Vec3f expected = Vec3f(0, -slope, 1).normalized();
    EXPECT_LT((bent.Get(lane) - expected).norm(), 1e-3f) << "lane " << lane;
    EXPECT_NEAR(bent.Get(lane).norm(), 1.0f, 1e-6f);
  }
}

TEST(Relief, SliversAndWideFootprintsKeepTheirNormals) {
  Eight eight;
  eight.SetEdge(2, 1, 2.0f * eight.faces.edge[0].Get(2));
  eight.points.footprint_m[5] = 0.11f;
  const Vec3x8 bent = BendNormals(Waves(), eight.points, eight.faces, eight.normals);
  for (int lane = 0; lane < kLanes; ++lane) {
    EXPECT_EQ(bent.Get(lane) == Vec3f(0, 0, 1), lane == 2 || lane == 5) << "lane " << lane;
  }
}

// Ledges of a mountain are seen from far away; threads of a cloth are not.
TEST(Relief, EachMaterialSaysHowFarItsReliefIsSeen) {
  Eight eight;
  eight.points.footprint_m[5] = 0.11f;
  const Vec3x8 bent = BendNormals(Waves(0.2f), eight.points, eight.faces, eight.normals);
  EXPECT_NE(bent.Get(5), Vec3f(0, 0, 1));
  eight.points.footprint_m[5] = 0.21f;
  const Vec3x8 flat = BendNormals(Waves(0.2f), eight.points, eight.faces, eight.normals);
  EXPECT_EQ(flat.Get(5), Vec3f(0, 0, 1));
}

}  // namespace
}  // namespace parallax
