#include "worker/dataset/frame/frame_writer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "common/base/hash.h"
#include "common/base/system/file.h"
#include "common/config/config.h"
#include "common/config/frame_files.h"
#include "common/image/io.h"
#include "common/math/proto.h"
#include "tests/folder_test.h"
#include "tests/worker/dataset/synthetic_scene.h"
#include "worker/dataset/frame/frame_json.h"

namespace parallax {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using Json = nlohmann::json;

class FrameWriterTest : public FolderTest {
 protected:
  void SetUp() override { frame_ = RenderSyntheticFrame(scene_, scene_.rigs(1)); }

  absl::StatusOr<v1::FrameResult> Write(const std::string& dir, CancelToken cancel = {}) {
    return WriteFrame({.scene = scene_,
                       .rig = scene_.rigs(1),
                       .frame = frame_,
                       .render = config_.render(),
                       .dir = dir,
                       .store_path = "key/.attempt-7/001",
                       .cancel = cancel});
  }
  Json ReadJson() { return Json::parse(*ReadFile(dir_ + "/frame.json")); }

  v1::SceneConfig config_ = DefaultSceneConfig();
  v1::Scene scene_ = MakeSyntheticScene();
  StereoFrame frame_;
};

std::vector<std::string> NamesIn(const std::string& dir) {
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(dir)) names.push_back(entry.path().filename());
  std::sort(names.begin(), names.end());
  return names;
}

TEST_F(FrameWriterTest, WritesEveryMapAsDatasetFormatNamesIt) {
  const auto result = Write(dir_);
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_EQ(NamesIn(dir_), FrameFileNames(config_.render())) << "what the coordinator asks for";
  EXPECT_THAT(
      NamesIn(dir_),
      ElementsAre("depth_left.exr", "depth_right.exr", "disparity_left.exr", "disparity_right.exr",
                  "frame.json", "left.png", "masks_left.png", "masks_right.png",
                  "materials_left.png", "materials_right.png", "normals_left.exr",
                  "normals_right.exr", "objects_left.png", "objects_right.png",
                  "occlusion_left.png", "occlusion_right.png", "right.png"));
  for (const auto& [eye, view] : {std::pair{std::string("left"), &frame_.left},
                                  std::pair{std::string("right"), &frame_.right}}) {
    EXPECT_EQ(*ReadPngRgb8(dir_ + "/" + eye + ".png"), view->color);
    EXPECT_EQ(*ReadExrY(dir_ + "/depth_" + eye + ".exr"), view->depth_m);
    EXPECT_EQ(*ReadExrY(dir_ + "/disparity_" + eye + ".exr"), view->disparity_px);
    EXPECT_EQ(*ReadPngU8(dir_ + "/occlusion_" + eye + ".png"), view->occlusion);
    EXPECT_EQ(*ReadPngU16(dir_ + "/objects_" + eye + ".png"), view->objects);
    EXPECT_EQ(*ReadPngU16(dir_ + "/materials_" + eye + ".png"), view->materials);
    EXPECT_EQ(*ReadPngU8(dir_ + "/masks_" + eye + ".png"), view->masks);
    const ImageF3 normals = *ReadExrRgb(dir_ + "/normals_" + eye + ".exr");
    for (size_t i = 0; i < normals.values().size(); ++i) {
      ASSERT_NEAR(normals.values()[i], view->normals.values()[i], 0.0005);
    }
  }
}

TEST_F(FrameWriterTest, ManifestNamesEveryFileWithSizeAndHash) {
  const auto result = Write(dir_);
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_EQ(result->rig(), 1u);
  EXPECT_EQ(result->path(), "key/.attempt-7/001");
  std::vector<std::string> names;
  for (const v1::FileEntry& file : result->files()) {
    names.push_back(file.name());
    EXPECT_EQ(file.sha256(), *Sha256HexOfFile(dir_ + "/" + file.name()));
    EXPECT_EQ(file.size(), static_cast<int64_t>(fs::file_size(dir_ + "/" + file.name())));
  }
  EXPECT_EQ(names, NamesIn(dir_));
  EXPECT_EQ(result->stage_s().at("trace"), 0.5);
  EXPECT_EQ(result->stage_s().at("denoise"), 0.25);
  EXPECT_EQ(result->stage_s().at("truth"), 0.125);
  EXPECT_GT(result->stage_s().at("write"), 0);
  EXPECT_GT(result->statistics().at("mean_intensity"), 10);
}

TEST_F(FrameWriterTest, WritingTwiceGivesTheSameBytes) {
  const auto first = Write(dir_ + "/a"), second = Write(dir_ + "/b");
  ASSERT_TRUE(first.ok() && second.ok());
  ASSERT_EQ(first->files_size(), 17);
  for (int i = 0; i < first->files_size(); ++i) {
    EXPECT_EQ(first->files(i).sha256(), second->files(i).sha256()) << first->files(i).name();
  }
}

TEST_F(FrameWriterTest, WritesOnlyTheMapsAskedForAndRemovesWhatWasThere) {
  ASSERT_TRUE(Write(dir_).ok());
  config_.mutable_render()->clear_maps();
  config_.mutable_render()->add_maps("disparity");
  ASSERT_TRUE(Write(dir_).ok());
  EXPECT_THAT(NamesIn(dir_), ElementsAre("disparity_left.exr", "disparity_right.exr", "frame.json",
                                         "left.png", "right.png"));
  EXPECT_EQ(NamesIn(dir_), FrameFileNames(config_.render())) << "what the coordinator asks for";
  EXPECT_EQ(ReadJson()["maps"], Json({"disparity"}));
}

TEST_F(FrameWriterTest, TheRawPairHasFilesAndCamerasOfItsOwn) {
  config_.mutable_render()->add_maps("raw");
  EXPECT_EQ(Write(dir_).status().code(), absl::StatusCode::kInvalidArgument) << "no raw pictures";
  v1::RawCamera& left = *scene_.mutable_rigs(1)->mutable_raw_left();
  left.set_fx_px(110);
  left.set_fy_px(111);
  left.set_cx_px(60);
  left.set_cy_px(40);
  left.set_width_px(120);
  left.set_height_px(80);
  left.set_lens(v1::LensConfig::MODEL_BROWN_CONRADY);
  for (const double k : {-0.2, 0.05, 1e-3, 2e-3, 0.01}) left.add_distortion(k);
  left.set_qw(std::cos(0.1));
  left.set_qz(std::sin(0.1));
  *scene_.mutable_rigs(1)->mutable_raw_right() = left;
  for (RawView* view : {&frame_.raw_left, &frame_.raw_right}) {
    view->color = ImageRgb8(120, 80, 7);
    view->flow = ImageF3(120, 80, -3.25f);
    view->occlusion = ImageU8(120, 80, 255);
  }
  ASSERT_TRUE(Write(dir_).ok()) << Write(dir_).status();
  EXPECT_EQ(NamesIn(dir_), FrameFileNames(config_.render())) << "what the coordinator asks for";
  EXPECT_EQ(*ReadPngRgb8(dir_ + "/raw_left.png"), frame_.raw_left.color);
  EXPECT_EQ(*ReadExrRgb(dir_ + "/raw_flow_right.exr"), frame_.raw_right.flow);
  EXPECT_EQ(*ReadPngU8(dir_ + "/raw_occlusion_left.png"), frame_.raw_left.occlusion);
  const Json raw = ReadJson()["raw"]["left"];
  EXPECT_EQ(raw["fy"], 111);
  EXPECT_EQ(raw["width"], 120);
  EXPECT_EQ(raw["lens"], "brown_conrady");
  EXPECT_EQ(raw["distortion"], Json({-0.2, 0.05, 1e-3, 2e-3, 0.01}));
  EXPECT_NEAR(raw["rectified_from_raw"][1][0].get<double>(), std::sin(0.2), 1e-12);
}

TEST_F(FrameWriterTest, FrameJsonHoldsCamerasAndTables) {
  ASSERT_TRUE(Write(dir_).ok());
  const Json json = ReadJson();
  EXPECT_EQ(json["intrinsics"], Json({{"fx", 112.0},
                                      {"fy", 112.0},
                                      {"cx", 80.0},
                                      {"cy", 45.0},
                                      {"width", 160},
                                      {"height", 90}}));
  EXPECT_EQ(json["baseline_m"], 0.2);
  EXPECT_EQ(json["exposure"], 0.75);
  EXPECT_EQ(json["seeds"]["scene"], "18446744073709551557");
  EXPECT_EQ(json["versions"]["generator"], "1");
  EXPECT_EQ(json["objects"]["1"], Json({{"class", "Floor"}, {"name", "floor"}, {"seed", "201"}}));
  EXPECT_EQ(json["objects"]["2"]["class"], "Wall");
  EXPECT_EQ(json["objects"]["3"], Json({{"class", "Ball"}, {"name", "Ball_3"}, {"seed", "203"}}));
  EXPECT_EQ(json["objects"].size(), 6u);
  EXPECT_EQ(json["materials"]["2"],
            Json({{"class", "Brick"}, {"name", "Brick_2"}, {"seed", "102"}}));
  EXPECT_GT(json["object_pixels"]["Ball"], 100);
  EXPECT_LT(json["near_m"], json["far_m"]);
  // Every index of the maps stands in its table.
  for (const View* view : {&frame_.left, &frame_.right}) {
    for (const uint16_t index : view->objects.values()) {
      ASSERT_TRUE(index == 0 || json["objects"].contains(std::to_string(index)));
    }
    for (const uint16_t index : view->materials.values()) {
      ASSERT_TRUE(index == 0 || json["materials"].contains(std::to_string(index)));
    }
  }
}

// A pixel of the left image, lifted by depth and the matrices of frame.json, falls on the right
// image where the disparity says.
TEST_F(FrameWriterTest, CamerasDepthAndDisparityAgree) {
  // A turned rig, so that every entry of the matrices counts.
  auto* rig = scene_.mutable_rigs(1);
  Pose pose = FromProto(rig->world_from_left());
  pose.rotation = Eigen::AngleAxisd(0.3, Vec3d(1, 2, 3).normalized()) * pose.rotation;
  *rig->mutable_world_from_left() = ToProto(pose);
  frame_ = RenderSyntheticFrame(scene_, *rig);
  ASSERT_TRUE(Write(dir_).ok());
  const Json json = ReadJson();
  const auto matrix = [&](const char* key) {
    Eigen::Matrix4d m;
    for (int i = 0; i < 4; ++i) {
      for (int j = 0; j < 4; ++j)
        m(i, j) = json[key][static_cast<size_t>(i)][static_cast<size_t>(j)];
    }
    return m;
  };
  const Eigen::Matrix4d world_from_left = matrix("world_from_left");
  const Eigen::Matrix4d right_from_world = matrix("world_from_right").inverse();
  const Json& k = json["intrinsics"];
  const ImageF depth = *ReadExrY(dir_ + "/depth_left.exr");
  const ImageF disparity = *ReadExrY(dir_ + "/disparity_left.exr");
  int checked = 0;
  for (int y = 3; y < 90; y += 9) {
    for (int x = 3; x < 160; x += 9) {
      const double z = depth(x, y);
      if (z == 0) continue;
      const Eigen::Vector4d left(z * (x + 0.5 - k["cx"].get<double>()) / k["fx"].get<double>(),
                                 z * (y + 0.5 - k["cy"].get<double>()) / k["fy"].get<double>(), z,
                                 1);
      const Eigen::Vector4d right = right_from_world * world_from_left * left;
      const double u = k["fx"].get<double>() * right.x() / right.z() + k["cx"].get<double>();
      const double v = k["fy"].get<double>() * right.y() / right.z() + k["cy"].get<double>();
      EXPECT_NEAR(u, x + 0.5 - disparity(x, y), 1e-4);
      EXPECT_NEAR(v, y + 0.5, 1e-6);
      ++checked;
    }
  }
  EXPECT_GT(checked, 50);
}

TEST_F(FrameWriterTest, ErrorsSayWhatIsWrong) {
  CancelToken cancel;
  cancel.Cancel();
  EXPECT_EQ(Write(dir_, cancel).status().code(), absl::StatusCode::kCancelled);
  EXPECT_THAT(std::string(Write("/proc/no/such").status().message()), HasSubstr("/proc/no/such"));
  frame_.right.depth_m = ImageF(10, 10);
  EXPECT_EQ(std::string(Write(dir_).status().message()), "rig 1: depth_right.exr is not 160 x 90");
}

TEST(Statistics, WarpFindsTheSyntheticFrameInAgreementAndAShiftNot) {
  const v1::Scene scene = MakeSyntheticScene(2, 480, 270);
  const StereoFrame frame = RenderSyntheticFrame(scene, scene.rigs(1));
  const View& left = frame.left;
  const WarpDifference good =
      WarpCheck(left.color, frame.right.color, left.disparity_px, left.occlusion);
  EXPECT_GE(good.median, 0);
  EXPECT_LT(good.median, 0.7);  // Rounding to 8 bits alone.
  EXPECT_LT(good.p90, 2);
  EXPECT_GT(good.pixels, 480 * 270 / 2);
  ImageF shifted = left.disparity_px;
  for (float& disparity : shifted.values()) disparity += disparity > 0 ? 3 : 0;
  EXPECT_GT(WarpCheck(left.color, frame.right.color, shifted, left.occlusion).median, 1.2);
  const ImageU8 all_occluded(480, 270, 255);
  EXPECT_EQ(WarpCheck(left.color, frame.right.color, left.disparity_px, all_occluded).median, -1);
}

TEST(Statistics, CountsOnlyPixelsThatSeeASurface) {
  v1::Scene scene = MakeSyntheticScene(1, 4, 2);
  StereoFrame frame = RenderSyntheticFrame(scene, scene.rigs(0));
  for (View* view : {&frame.left, &frame.right}) {
    view->depth_m = ImageF(4, 2);
    view->disparity_px = ImageF(4, 2);
    view->objects = ImageU16(4, 2);
    view->occlusion = ImageU8(4, 2);
  }
  const FrameStatistics none = ComputeStatistics(scene, frame);
  EXPECT_EQ(none.sky_fraction, 1);
  EXPECT_EQ(none.min_depth_m, 0);
  EXPECT_EQ(none.disparity.Total(), 0);
  frame.left.depth_m(1, 1) = 2;
  frame.left.disparity_px(1, 1) = 6;
  frame.left.objects(1, 1) = 3;
  frame.left.occlusion(0, 0) = 255;
  frame.right.depth_m(0, 0) = 0.5;
  const FrameStatistics one = ComputeStatistics(scene, frame);
  EXPECT_EQ(one.sky_fraction, 7.0 / 8);
  EXPECT_EQ(one.occluded_fraction, 1.0 / 8);
  EXPECT_EQ(one.min_depth_m, 0.5);
  EXPECT_EQ(one.max_depth_m, 2);
  EXPECT_EQ(one.max_disparity_px, 6);
  EXPECT_EQ(one.median_disparity_px, 6);  // Middle of the bin [4, 8).
  EXPECT_EQ(one.object_pixels, (std::map<std::string, int64_t>{{"Ball", 1}}));
}

// Left half: steps of `contrast` between columns; right half: a slow ramp from top to bottom.
TEST(Statistics, TextureIsWhatChangesAlongARow) {
  const auto picture = [](int contrast) {
    ImageRgb8 image(80, 60);
    for (int y = 0; y < 60; ++y) {
      for (int x = 0; x < 80; ++x) {
        const int value = x < 40 ? 100 + contrast * (x % 2) : 2 * y;
        for (int c = 0; c < 3; ++c) image(x, y, c) = static_cast<uint8_t>(value);
      }
    }
    return image;
  };
  ImageF near(80, 60, 5.0f);
  EXPECT_NEAR(TexturedFraction(picture(3), near), 0.5, 0.06);
  EXPECT_LT(TexturedFraction(picture(1), near), 0.12);  // Only where the halves meet.
  for (int y = 0; y < 60; ++y) {
    for (int x = 0; x < 20; ++x) near(x, y) = 0;  // Sky.
  }
  EXPECT_NEAR(TexturedFraction(picture(3), near), 0.25, 0.06);
  EXPECT_EQ(TexturedFraction(picture(3), ImageF(80, 60)), 0);
  EXPECT_EQ(TexturedFraction(ImageRgb8(), ImageF()), 0);
}

TEST(Histogram, LimitsOfTrainingCodeFallOnEdges) {
  Histogram histogram = DisparityHistogram();
  for (const int limit : kDisparityLimitsPx) {
    EXPECT_EQ(std::fmod(limit, histogram.bin_width), 0) << limit;
    histogram.Add(limit - 0.001);
    histogram.Add(limit);
  }
  histogram.Add(1e9);
  EXPECT_EQ(histogram.Total(), 13);
  EXPECT_DOUBLE_EQ(histogram.FractionBelow(192), 1.0 / 13);
  EXPECT_DOUBLE_EQ(histogram.FractionBelow(1000), 11.0 / 13);
  EXPECT_EQ(Histogram(1, 3).FractionBelow(2), 0);
}

TEST(ClassOf, IsTheAssetsOrUnknown) {
  v1::SceneObject object;
  object.set_part("floor");
  EXPECT_EQ(ClassOf(object), "Unknown");
  object.set_asset_class("Chair");
  EXPECT_EQ(ClassOf(object), "Chair");
}

}  // namespace
}  // namespace parallax
