#include "worker/render/truth/layers.h"

#include <gtest/gtest.h>

#include "tests/worker/render/render_frame.h"

namespace parallax {
namespace {

SurfaceSample Glass(bool thin) {
  SurfaceSample glass;
  glass.transmission = 1;
  glass.thin_walled = thin;
  glass.roughness = 0;
  return glass;
}

// A camera at the origin that looks along +y at upright squares, far from each other or not.
class LayersTest : public ::testing::Test {
 protected:
  static constexpr int kSize = 16;

  LayersTest()
      : thin_(scene_.AddMaterial(Glass(true))),
        solid_(scene_.AddMaterial(Glass(false))),
        opaque_(scene_.AddMaterial(DiffuseOf())),
        rig_(test::MakeRig(Vec3d::Zero(), Vec3d::UnitY(), kSize, kSize, kSize, 0.1)) {
    scene_.AddPointLight({0, 0, 0.5}, 0, 10);
  }

  // Adds a square at distance `y_m`; returns its object.
  uint32_t AddSquare(float y_m, uint32_t material, float half_m = 20) {
    return scene_.AddMesh(
        test::MakeQuad({-half_m, y_m, -half_m}, {2 * half_m, 0, 0}, {0, 0, 2 * half_m}), material);
  }

  LayerMaps Trace() {
    auto built = RenderScene::Build(scene_.geometry, 0);
    EXPECT_TRUE(built.ok()) << built.status();
    auto maps = TraceLayers(**built, StereoCamera::FromRig(rig_)->eyes[0], 0.1, {});
    EXPECT_TRUE(maps.ok()) << maps.status();
    return *std::move(maps);
  }

  static SurfaceSample DiffuseOf() { return test::DiffuseSample(Vec3f::Constant(0.5f)); }

  test::TestScene scene_;
  const uint32_t thin_, solid_, opaque_;
  const v1::Rig rig_;
};

TEST_F(LayersTest, AreAllSurfacesUpToTheFirstOpaqueOne) {
  AddSquare(1, thin_);
  const uint32_t second = AddSquare(2, solid_);
  const uint32_t third = AddSquare(4, opaque_);
  AddSquare(5, opaque_);
  const LayerMaps maps = Trace();
  for (int y = 0; y < kSize; ++y) {
    for (int x = 0; x < kSize; ++x) {
      ASSERT_EQ(maps.count(x, y), 3);
      EXPECT_FLOAT_EQ(maps.behind[0].depth_m(x, y), 2);
      EXPECT_FLOAT_EQ(maps.behind[1].depth_m(x, y), 4);
      EXPECT_FLOAT_EQ(maps.behind[1].disparity_px(x, y), kSize * 0.1f / 4);
      EXPECT_EQ(maps.behind[0].objects(x, y), second);
      EXPECT_EQ(maps.behind[1].objects(x, y), third);
      EXPECT_EQ(maps.behind[0].materials(x, y), solid_);
      EXPECT_EQ(maps.behind[1].materials(x, y), opaque_);
    }
  }
  EXPECT_TRUE(maps.behind[2].depth_m.empty());
  const std::map<uint32_t, Clearness> clear = {{thin_, Clearness::kThinGlass},
                                               {solid_, Clearness::kSolidGlass}};
  EXPECT_EQ(maps.clear, clear);
}

TEST_F(LayersTest, AreOneWithoutGlass) {
  AddSquare(2, opaque_);
  AddSquare(3, opaque_);
  const LayerMaps maps = Trace();
  EXPECT_EQ(maps.count(3, 4), 1);
  EXPECT_TRUE(maps.behind[0].depth_m.empty());
  EXPECT_TRUE(maps.clear.empty());
}

TEST_F(LayersTest, EndWhereNothingIsBehindGlass) {
  AddSquare(1, thin_);
  const LayerMaps maps = Trace();
  EXPECT_EQ(maps.count(3, 4), 1);
}

TEST_F(LayersTest, AreNoneInTheSky) {
  AddSquare(1, thin_, 0.05f);
  EXPECT_EQ(Trace().count(0, 0), 0);
}

TEST_F(LayersTest, SayWhereThereAreMoreThanFour) {
  for (int i = 1; i <= 5; ++i) AddSquare(static_cast<float>(i), thin_);
  const LayerMaps maps = Trace();
  EXPECT_EQ(maps.count(3, 4), kMostLayers | kMoreLayers);
  EXPECT_FLOAT_EQ(maps.behind[2].depth_m(3, 4), 4);
}

TEST_F(LayersTest, FourWithNothingBehindAreNotMore) {
  for (int i = 1; i <= 4; ++i) AddSquare(static_cast<float>(i), thin_);
  EXPECT_EQ(Trace().count(3, 4), kMostLayers);
}

TEST_F(LayersTest, CountFrontAndBackOfAThinPaneOnce) {
  for (const float thickness : {0.001f, 0.01f}) {
    scene_.geometry.meshes.clear();
    scene_.AddMesh(test::MakeBox({-9, 1, -9}, {9, 1 + thickness, 9}), thin_);
    AddSquare(3, opaque_);
    const LayerMaps maps = Trace();
    EXPECT_EQ(maps.count(8, 8), thickness < kSamePlace_m ? 2 : 3) << thickness;
  }
}

TEST_F(LayersTest, OfAFrameBeginWithItsGroundTruth) {
  AddSquare(1, thin_);
  AddSquare(4, opaque_);
  v1::RenderConfig config = test::MakeConfig(1, 1, false);
  const StereoFrame without = test::RenderFrame(scene_, config, rig_);
  EXPECT_TRUE(without.more.empty());
  config.add_maps("layers");
  const StereoFrame frame = test::RenderFrame(scene_, config, rig_);
  EXPECT_EQ(frame.left.depth_m, without.left.depth_m);
  EXPECT_EQ(frame.left.color, without.left.color);
  for (const std::string eye : {"left", "right"}) {
    const auto& count = std::get<ImageU8>(frame.more.at("layers_" + eye + ".png"));
    const auto& depth = std::get<ImageF>(frame.more.at("depth2_" + eye + ".exr"));
    EXPECT_EQ(count(5, 5), 2);
    EXPECT_FLOAT_EQ(depth(5, 5), 4);
  }
  EXPECT_EQ(frame.more.count("depth3_left.exr"), 0u);
  EXPECT_EQ(frame.clear_materials.at(thin_), Clearness::kThinGlass);
}

}  // namespace
}  // namespace parallax
