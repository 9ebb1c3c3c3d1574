#include "worker/dataset/frame/sensor_stage.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "common/base/hash.h"
#include "common/base/system/file.h"
#include "common/config/config.h"
#include "common/config/sensor_presets.h"
#include "common/image/io.h"
#include "tests/folder_test.h"
#include "tests/worker/dataset/synthetic_archive.h"
#include "tests/worker/dataset/synthetic_scene.h"
#include "worker/dataset/archive/archive.h"
#include "worker/dataset/frame/frame_writer.h"
#include "worker/dataset/verify/verify.h"

namespace parallax {
namespace {

namespace fs = std::filesystem;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Not;
using Json = nlohmann::ordered_json;

class SensorStageTest : public FolderTest {
 protected:
  void SetUp() override {
    study_ = *ParseStudy(
        "study: s\npairs: 2\nrigs_per_scene: 2\n"
        "variants: [{name: a, set: {rigs: {count: 2}, render: {keep_hdr: true}}}]\n",
        "s.yaml");
    // Frames in the form of a render job's result; no test renders again.
    for (uint32_t rig = 0; rig < 2; ++rig) frames_.push_back(Publish(rig));
  }

  v1::PublishedFrame Publish(uint32_t rig) {
    StereoFrame frame = RenderSyntheticFrame(scene_, scene_.rigs(static_cast<int>(rig)));
    GiveLight(frame);
    const std::string path = "aa/.attempt-7/00" + std::to_string(rig);
    v1::PublishedFrame published;
    published.set_variant("a");
    *published.mutable_frame() = *WriteFrame({.scene = scene_,
                                              .rig = scene_.rigs(static_cast<int>(rig)),
                                              .frame = frame,
                                              .render = study_.variants(0).config().render(),
                                              .dir = dir_ + "/store/" + path,
                                              .store_path = path});
    return published;
  }

  // One run that ends in `out` with this sensor.
  ArchiveWriter::Totals Run(const std::string& preset) {
    TakeSensorPreset(preset, study_.mutable_variants(0)->mutable_config()->mutable_sensor());
    auto archive = ArchiveWriter::Open(dir_ + "/out", study_);
    EXPECT_TRUE(archive.ok()) << archive.status();
    for (const auto& frame : frames_) {
      const absl::Status status = (*archive)->AddFrame(frame, dir_ + "/store");
      EXPECT_TRUE(status.ok()) << status;
    }
    EXPECT_TRUE((*archive)->Finish().ok());
    return (*archive)->totals();
  }
  std::string Bytes(const std::string& name) const {
    return *ReadFile(dir_ + "/out/a/frames/000000/000/" + name);
  }
  std::string Stored(const std::string& name) const {
    return *ReadFile(dir_ + "/store/aa/.attempt-7/000/" + name);
  }

  v1::Scene scene_ = MakeSyntheticScene(2, 96, 54);
  v1::StudySpec study_;
  std::vector<v1::PublishedFrame> frames_;
};

TEST_F(SensorStageTest, OffLeavesEveryByteAsRendered) {
  const ArchiveWriter::Totals totals = Run("off");
  EXPECT_EQ(totals.files_linked, 2 * 19);
  EXPECT_EQ(Bytes("left.png"), Stored("left.png"));
  EXPECT_EQ(Bytes("frame.json"), Stored("frame.json"));
}

TEST_F(SensorStageTest, MakesPicturesOfKeptLightAndLeavesTheTruth) {
  const ArchiveWriter::Totals totals = Run("webcam");
  EXPECT_EQ(totals.frames_added, 2);
  EXPECT_NE(Bytes("left.png"), Stored("left.png"));
  EXPECT_NE(Bytes("right.png"), Stored("right.png"));
  for (const char* name : {"disparity_left.exr", "occlusion_right.png", "hdr_left.exr"}) {
    EXPECT_EQ(Bytes(name), Stored(name)) << name;
  }
  const Json json = Json::parse(Bytes("frame.json"));
  EXPECT_EQ(json["sensor"]["preset"], "webcam");
  EXPECT_NE(json["sensor"]["exposure_ev"][0], json["sensor"]["exposure_ev"][1]);
  EXPECT_EQ(json["statistics"], Json::parse(Stored("frame.json"))["statistics"]);
  const auto verified = VerifyDataset(dir_ + "/out", {});
  ASSERT_TRUE(verified.ok()) << verified.status();
  for (const Finding& f : verified->findings) {
    if (f.check != "recipe" && f.check != "occlusion")
      ADD_FAILURE() << f.check << f.path << f.message;
  }
}

double MeanDifference(const ImageRgb8& a, const ImageRgb8& b) {
  double sum = 0;
  for (size_t i = 0; i < a.values().size(); ++i) {
    sum += std::abs(static_cast<double>(a.values()[i]) - static_cast<double>(b.values()[i]));
  }
  return sum / static_cast<double>(a.values().size());
}

// Kept light is rounded to half floats, so that a step of a pixel may differ.
TEST_F(SensorStageTest, AFrameInMemoryGivesTheSamePicturesAndASmallOneLessBlur) {
  Run("webcam");
  const v1::SensorConfig sensor = study_.variants(0).config().sensor();
  const v1::Rig& rig = scene_.rigs(0);
  StereoFrame frame = RenderSyntheticFrame(scene_, rig);
  GiveLight(frame);
  const auto taken = TakeSensor(sensor, scene_, rig, frame);
  ASSERT_TRUE(taken.ok()) << taken.status();
  EXPECT_LT(MeanDifference(taken->right, *DecodePngRgb8(Bytes("right.png"))), 0.5);
  v1::SensorConfig blurred;
  TakeSensorPreset("ideal", &blurred);
  blurred.mutable_psf_sigma_px()->set_constant(4);
  const auto sharp = TakeSensor(blurred, scene_, rig, frame, 0.01);
  const auto soft = TakeSensor(blurred, scene_, rig, frame, 1);
  ASSERT_TRUE(sharp.ok() && soft.ok()) << sharp.status() << soft.status();
  EXPECT_LT(MeanDifference(sharp->left, frame.left.color), 1);
  EXPECT_GT(MeanDifference(soft->left, frame.left.color), 2);
}

TEST_F(SensorStageTest, ShakenRigsBlurTheirPicturesAndSayTheirMotion) {
  Run("ideal");
  const std::string sharp = Bytes("left.png");
  v1::SensorConfig sensor;
  TakeSensorPreset("ideal", &sensor);
  sensor.mutable_exposure_ms()->set_constant(40);
  sensor.mutable_shake_deg_s()->set_constant(200);
  const auto made = MakeSensorFiles(sensor, "key", [&](const std::string& name) {
    return dir_ + "/store/aa/.attempt-7/000/" + name;
  });
  ASSERT_TRUE(made.ok()) << made.status();
  EXPECT_NE(made->at("left.png"), sharp);
  const Json told = Json::parse(made->at("frame.json"))["sensor"];
  EXPECT_EQ(told["exposure_ms"], 40);
  const auto turn = told["shake_rad_s"].get<std::array<double, 3>>();
  EXPECT_NEAR(std::hypot(turn[0], turn[1], turn[2]), 3.4907, 1e-4);
  fs::create_directories(dir_ + "/again");
  for (const char* name : {"hdr_left.exr", "hdr_right.exr", "depth_left.exr", "depth_right.exr"}) {
    fs::copy(dir_ + "/store/aa/.attempt-7/000/" + name, dir_ + "/again/" + name);
  }
  const auto repeated = RepeatSensor(Json::parse(made->at("frame.json")), dir_ + "/again");
  ASSERT_TRUE(repeated.ok()) << repeated.status();
  EXPECT_EQ(*EncodePng(repeated->left), made->at("left.png"));
}

// Pairs with one left eye have one left picture.
TEST_F(SensorStageTest, PairsThatShareALeftEyeHaveOneLeftPicture) {
  const std::string stored = dir_ + "/store/aa/.attempt-7/000/";
  v1::SensorConfig sensor;
  TakeSensorPreset("webcam", &sensor);
  std::vector<std::map<std::string, std::string>> made;
  for (const uint32_t rig : {4u, 5u}) {
    Json json = Json::parse(Stored("frame.json"));
    json["rig"] = rig;
    json["left_rig"] = 4;
    ASSERT_TRUE(WriteFile(dir_ + "/frame.json", json.dump()).ok());
    const auto files = MakeSensorFiles(sensor, "key", [&](const std::string& name) {
      return name == "frame.json" ? dir_ + "/frame.json" : stored + name;
    });
    ASSERT_TRUE(files.ok()) << files.status();
    made.push_back(*files);
  }
  EXPECT_EQ(made[0].at("left.png"), made[1].at("left.png"));
  EXPECT_NE(made[0].at("right.png"), made[1].at("right.png"));
}

// The stage's key: the same sensor is not asked again, another one costs no rendering, and none
// gives the rendered pictures back.
TEST_F(SensorStageTest, AnotherSensorOnAFinishedDatasetReplacesOnlyPictures) {
  Run("webcam");
  const std::string webcam = Bytes("left.png");
  ArchiveWriter::Totals totals = Run("webcam");
  EXPECT_EQ(totals.frames_present, 2);
  totals = Run("industrial");
  EXPECT_EQ(totals.frames_replaced, 2);
  EXPECT_NE(Bytes("left.png"), webcam);
  totals = Run("off");
  EXPECT_EQ(totals.frames_replaced, 2);
  EXPECT_EQ(Bytes("left.png"), Stored("left.png"));
  EXPECT_EQ(Bytes("frame.json"), Stored("frame.json"));
  Run("webcam");
  EXPECT_EQ(Bytes("left.png"), webcam) << "the same bytes as the first time";
}

TEST_F(SensorStageTest, PicturesThatWereDamagedAreMadeAnew) {
  Run("phone");
  const std::string before = Bytes("right.png");
  const std::string path = dir_ + "/out/a/frames/000000/000/right.png";
  ASSERT_TRUE(WriteFile(path, before.substr(0, before.size() - 1) + "x").ok());
  const ArchiveWriter::Totals totals = Run("phone");
  EXPECT_EQ(totals.frames_replaced, 1);
  EXPECT_EQ(Bytes("right.png"), before);
}

TEST_F(SensorStageTest, AFrameWithoutKeptLightSaysWhatIsMissing) {
  fs::remove(dir_ + "/store/aa/.attempt-7/000/hdr_left.exr");
  v1::SensorConfig sensor;
  TakeSensorPreset("industrial", &sensor);
  const auto made = MakeSensorFiles(sensor, "key", [&](const std::string& name) {
    return dir_ + "/store/aa/.attempt-7/000/" + name;
  });
  EXPECT_EQ(made.status().code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(std::string(made.status().message()), HasSubstr("render.keep_hdr"));
}

TEST_F(SensorStageTest, TheKeyFollowsSensorAndLight) {
  v1::SensorConfig sensor;
  TakeSensorPreset("webcam", &sensor);
  auto files = frames_[0].frame().files();
  const std::string key = SensorKey(sensor, files);
  for (v1::FileEntry& file : files) {
    if (file.name() == "normals_left.exr") file.set_sha256(std::string(64, '0'));
  }
  EXPECT_EQ(SensorKey(sensor, files), key) << "it does not read normals";
  for (v1::FileEntry& file : files) {
    if (file.name() == "hdr_right.exr") file.set_sha256(std::string(64, '0'));
  }
  EXPECT_NE(SensorKey(sensor, files), key);
  sensor.mutable_focus_m()->set_constant(1);
  EXPECT_NE(SensorKey(sensor, frames_[0].frame().files()), key);
}

class VerifyLightTest : public FolderTest {
 protected:
  void Make(const std::string& sensor) {
    MakeSyntheticArchive(data_, {.scenes = 1, .rigs = 1, .keep_hdr = true, .sensor = sensor});
  }
  std::vector<std::string> Checks() {
    std::vector<std::string> checks;
    const auto result = VerifyDataset(data_, {.hashes = false});
    EXPECT_TRUE(result.ok()) << result.status();
    for (const Finding& f : result->findings) checks.push_back(f.check);
    return checks;
  }
  void Replace(const std::string& name, const std::string& bytes) {
    fs::remove(frame_ + "/" + name);  // Not through a hard link.
    ASSERT_TRUE(WriteFile(frame_ + "/" + name, bytes).ok());
  }
  const std::string data_ = dir_ + "/data", frame_ = data_ + "/a/frames/000000/000";
};

TEST_F(VerifyLightTest, RenderedPicturesAreComparedWithTheirLight) {
  Make("off");
  EXPECT_THAT(Checks(), ::testing::IsEmpty());
  ImageRgb8 left = *ReadPngRgb8(frame_ + "/left.png");
  left(7, 7, 1) = static_cast<uint8_t>(left(7, 7, 1) ^ 16);
  Replace("left.png", *EncodePng(left));
  EXPECT_THAT(Checks(), Contains("hdr"));
}

TEST_F(VerifyLightTest, ASensorsPicturesAreMadeOnceMore) {
  Make("stereo_module");
  EXPECT_THAT(Checks(), ::testing::IsEmpty());
  Json json = Json::parse(*ReadFile(frame_ + "/frame.json"));
  json["sensor"]["exposure_ev"][1] = 2.5;
  Replace("frame.json", json.dump());
  EXPECT_THAT(Checks(), Contains("sensor"));
  json["sensor"].erase("white_e");
  Replace("frame.json", json.dump());
  EXPECT_THAT(Checks(), Contains("sensor"));
}

TEST_F(VerifyLightTest, FramesOfVersion020TellNoMotion) {
  Make("stereo_module");
  Json json = Json::parse(*ReadFile(frame_ + "/frame.json"));
  for (const char* key : {"exposure_ms", "shake_m_s", "shake_rad_s"}) json["sensor"].erase(key);
  Replace("frame.json", json.dump());
  EXPECT_THAT(Checks(), Not(Contains("sensor")));
  json["sequence"] = {{"path", 1}, {"time_s", 0}, {"previous", nullptr}, {"next", nullptr}};
  EXPECT_TRUE(RepeatSensor(json, frame_).ok());
  json["sensor"]["exposure_ms"] = 5;
  EXPECT_THAT(std::string(RepeatSensor(json, frame_).status().message()),
              HasSubstr("says no motion of its path"));
}

TEST_F(VerifyLightTest, LightIsAFiniteNumber) {
  Make("off");
  ImageF3 light = *ReadExrRgb(frame_ + "/hdr_right.exr");
  light(3, 3) = -0.5f;
  Replace("hdr_right.exr", *EncodeExrHalfRgb(light));
  EXPECT_THAT(Checks(), Contains("finite"));
}

}  // namespace
}  // namespace parallax
