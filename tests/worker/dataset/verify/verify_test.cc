#include "worker/dataset/verify/verify.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <functional>
#include <limits>
#include <nlohmann/json.hpp>

#include "common/base/system/file.h"
#include "common/config/config.h"
#include "common/image/io.h"
#include "parallax/v1/scene.pb.h"
#include "tests/folder_test.h"
#include "tests/worker/dataset/synthetic_archive.h"

namespace parallax {
namespace {

namespace fs = std::filesystem;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using Json = nlohmann::ordered_json;

class VerifyTest : public FolderTest {
 protected:
  void SetUp() override { MakeSyntheticArchive(data_, {.scenes = 1}); }

  std::vector<std::string> Checks(VerifyOptions options = {}) {
    const auto result = VerifyDataset(data_, options);
    EXPECT_TRUE(result.ok()) << result.status();
    std::vector<std::string> checks;
    for (const Finding& finding : result->findings) {
      checks.push_back(finding.check);
      EXPECT_THAT(finding.path, HasSubstr(dir_));
      EXPECT_FALSE(finding.message.empty());
    }
    return checks;
  }
  void ForgeDepth(const std::string& name, const std::function<void(ImageF&)>& change) {
    ImageF image = *ReadExrY(frame_ + "/" + name);
    change(image);
    ForgeFile(data_, name, *EncodeExrY(image));
  }
  void ForgeJson(const std::function<void(Json&)>& change) {
    Json json = Json::parse(*ReadFile(frame_ + "/frame.json"));
    change(json);
    ForgeFile(data_, "frame.json", json.dump());
  }

  const std::string data_ = dir_ + "/data", frame_ = data_ + "/a/frames/000000/001";
  double fx_px_ = 0;
};

TEST_F(VerifyTest, AWholeDatasetHasNoFindings) {
  const auto result = VerifyDataset(data_);
  ASSERT_TRUE(result.ok()) << result.status();
  for (const Finding& f : result->findings) ADD_FAILURE() << f.check << " " << f.path << f.message;
  EXPECT_EQ(result->kind, "archive");
  EXPECT_EQ(result->frames, 2);
  EXPECT_EQ(result->files, 34);
  EXPECT_GT(result->bytes, 10000);
  EXPECT_EQ(VerifyDataset(data_ + "/a")->findings_total, 0);
  EXPECT_EQ(VerifyDataset(dir_).status().code(), absl::StatusCode::kNotFound);
}

TEST_F(VerifyTest, CamerasAreThoseOfTheStudy) {
  const std::string lock = data_ + "/study.lock.yaml";
  v1::StudySpec study = *LoadStudy(lock);
  const auto wants = [&](double cx, double low_m, double high_m) {
    v1::RigConfig& rigs = *study.mutable_variants(0)->mutable_config()->mutable_rigs();
    rigs.clear_horizontal_fov_deg();
    rigs.set_width_px(96);
    rigs.set_height_px(54);
    rigs.mutable_baseline_m()->mutable_uniform()->set_low(low_m);
    rigs.mutable_baseline_m()->mutable_uniform()->set_high(high_m);
    // Twice the size, so that K is scaled.
    v1::CameraConfig& camera = *rigs.mutable_camera();
    camera.set_width_px(192);
    camera.set_height_px(108);
    camera.mutable_fx_px()->set_constant(2 * fx_px_);
    camera.mutable_cx_px()->set_constant(cx);
    fs::remove(lock);
    ASSERT_TRUE(WriteFile(lock, StudyToYaml(study)).ok());
  };
  const Json json = Json::parse(*ReadFile(frame_ + "/frame.json"));
  fx_px_ = json["intrinsics"]["fx"];
  wants(96, 0.001, 2);
  EXPECT_THAT(Checks(), IsEmpty());
  wants(96 + 1e-3, 0.001, 2);
  EXPECT_THAT(Checks(), Contains("camera"));
  wants(96, 0.001, 0.002);
  EXPECT_THAT(Checks(), Contains("camera"));
  fx_px_ *= 1 + 3e-6;
  wants(96, 0.001, 2);
  EXPECT_THAT(Checks(), Contains("camera"));
  EXPECT_THAT(Checks({.geometry = false}), IsEmpty());
}

TEST_F(VerifyTest, SeedsOfOlderArchivesAreNumbers) {
  ForgeJson([](Json& json) {
    for (const char* table : {"objects", "materials"}) {
      for (auto& [index, entry] : json[table].items()) entry["seed"] = 18446744073709551557u;
    }
  });
  EXPECT_THAT(Checks(), IsEmpty());
}

TEST_F(VerifyTest, FindsChangedMissingAndStrayFiles) {
  std::string bytes = *ReadFile(frame_ + "/right.png");
  bytes[bytes.size() / 2] ^= 1;
  fs::remove(frame_ + "/right.png");
  ASSERT_TRUE(WriteFile(frame_ + "/right.png", bytes).ok());
  EXPECT_THAT(Checks(), Contains("hash"));
  EXPECT_TRUE(Checks({.hashes = false, .geometry = false}).empty());
  fs::remove(frame_ + "/masks_left.png");
  EXPECT_THAT(Checks(), Contains("missing"));
  ASSERT_TRUE(WriteFile(frame_ + "/notes.txt", "x").ok());
  EXPECT_THAT(Checks(), Contains("stray"));
  fs::remove(data_ + "/a/scenes/000000.pb");
  EXPECT_THAT(Checks(), Contains("recipe"));
  fs::remove_all(data_ + "/a/frames/000000/000");
  fs::copy(frame_, data_ + "/a/frames/000000/005");
  EXPECT_THAT(Checks(), Contains("index"));
}

TEST_F(VerifyTest, AVariantWithoutItsIndexIsAFinding) {
  MakeSyntheticArchive(data_, {.variants = {"a", "b"}, .scenes = 1});
  fs::remove(data_ + "/b/index.jsonl");
  const auto result = VerifyDataset(data_);
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_EQ(result->variants, 2);
  ASSERT_EQ(result->findings_total, 4);  // The index, the card, both frames.
  EXPECT_EQ(result->findings[0].path, data_ + "/b/index.jsonl");
  EXPECT_EQ(result->findings[0].message, "missing");
}

TEST_F(VerifyTest, RecipesAreThoseOfTheirFrames) {
  const std::string path = data_ + "/a/scenes/000000.pb";
  v1::Scene scene;
  ASSERT_TRUE(scene.ParseFromString(*ReadFile(path)));
  const std::function<void(v1::Scene&)> changes[] = {
      [](v1::Scene& s) { s.set_scene_seed(7); },
      [](v1::Scene& s) { s.mutable_rigs(1)->set_fx_px(50); },
      [](v1::Scene& s) { s.mutable_rigs(1)->set_baseline_m(0.3); },
      [](v1::Scene& s) { s.mutable_rigs(1)->mutable_world_from_left()->set_tx(9); },
  };
  for (const auto& change : changes) {
    v1::Scene other = scene;
    change(other);
    ASSERT_TRUE(WriteFile(path, other.SerializeAsString()).ok());
    EXPECT_THAT(Checks(), Contains("recipe")) << &change - changes;
  }
}

TEST_F(VerifyTest, VerdictsOfCurationFitTheirScores) {
  const auto forge = [&](double share, double value, bool passed) {
    ChangeIndex(data_, [&](Json& json) {
      json["statistics"]["ambiguous_share"] = share;
      json["filters"]["ambiguous"] = {{"passed", passed}, {"value", value}, {"threshold", 0.6}};
      json["passed"] = passed;
    });
  };
  for (const auto& [share, passed] : {std::pair(0.5, true), {0.6, true}, {0.7, false}}) {
    forge(share, share, passed);
    EXPECT_THAT(Checks(), IsEmpty()) << share;
    forge(share, share, !passed);
    EXPECT_THAT(Checks(), Contains("filters")) << share;
  }
  forge(0.5, 0.4, true);
  EXPECT_THAT(Checks(), Contains("filters"));
  forge(1.5, 1.5, false);
  EXPECT_THAT(Checks(), Contains("filters"));
}

TEST_F(VerifyTest, VerdictsOfTextureFitTheMaps) {
  const auto forge = [&](double error) {
    ChangeIndex(data_, [&](Json& json) {
      const double share = json["statistics"]["textured_fraction"];
      json["filters"]["textureless"] = {
          {"passed", true}, {"value", share + error}, {"threshold", 0.0}};
    });
  };
  forge(0);
  EXPECT_THAT(Checks(), IsEmpty());
  forge(1e-6);
  EXPECT_THAT(Checks(), Contains("filters"));
}

TEST_F(VerifyTest, FindsGeometryThatContradictsItselfThoughAllHashesAgree) {
  const struct {
    const char* check;
    std::function<void()> forge;
  } cases[] = {
      {"disparity",
       [&] { ForgeDepth("disparity_left.exr", [](ImageF& d) { d(5, 5) *= 1.00001f; }); }},
      {"finite", [&] { ForgeDepth("depth_right.exr", [](ImageF& d) { d(5, 5) = NAN; }); }},
      {"finite", [&] { ForgeDepth("disparity_right.exr", [](ImageF& d) { d(5, 5) = INFINITY; }); }},
      {"finite", [&] { ForgeDepth("depth_left.exr", [](ImageF& d) { d(5, 5) = -1; }); }},
      {"masks", [&] { ForgeFile(data_, "masks_left.png", *EncodePng(ImageU8(96, 54, 1))); }},
      {"tables", [&] { ForgeFile(data_, "objects_right.png", *EncodePng(ImageU16(96, 54, 999))); }},
      {"tables",
       [&] { ForgeFile(data_, "materials_left.png", *EncodePng(ImageU16(96, 54, 999))); }},
      {"normals",
       [&] { ForgeFile(data_, "normals_left.exr", *EncodeExrHalfRgb(ImageF3(96, 54, 0.9f))); }},
      {"occlusion",
       [&] { ForgeFile(data_, "occlusion_left.png", *EncodePng(ImageU8(96, 54, 0))); }},
      {"occlusion",
       [&] { ForgeFile(data_, "occlusion_right.png", *EncodePng(ImageU8(96, 54, 7))); }},
      {"size", [&] { ForgeFile(data_, "occlusion_right.png", *EncodePng(ImageU8(95, 54, 0))); }},
      {"image", [&] { ForgeFile(data_, "left.png", "no PNG at all"); }},
      {"filters", [&] { ForgeFile(data_, "left.png", *EncodePng(ImageRgb8(96, 54, 1))); }},
      {"pose", [&] { ForgeJson([](Json& j) { j["world_from_right"][0][3] = 99.0; }); }},
      {"pose", [&] { ForgeJson([](Json& j) { j["world_from_left"][0][0] = 3.0; }); }},
      {"pose", [&] { ForgeJson([](Json& j) { j["baseline_m"] = 1.5; }); }},
      {"disparity", [&] { ForgeJson([](Json& j) { j["intrinsics"]["fx"] = 50.0; }); }},
      {"tables", [&] { ForgeJson([](Json& j) { j["objects"].erase("1"); }); }},
      {"tables", [&] { ForgeJson([](Json& j) { j["objects"]["1"]["seed"] = "red"; }); }},
      {"tables", [&] { ForgeJson([](Json& j) { j["objects"]["1"]["seed"] = -1; }); }},
      {"frame.json", [&] { ForgeJson([](Json& j) { j.erase("intrinsics"); }); }},
  };
  const SyntheticArchive archive{.scenes = 1};
  for (const auto& c : cases) {
    MakeSyntheticArchive(data_, archive);
    c.forge();
    const std::vector<std::string> checks = Checks();
    EXPECT_THAT(checks, Contains(c.check)) << &c - cases;
    EXPECT_EQ(std::count(checks.begin(), checks.end(), "hash"), 0);
  }
}

}  // namespace
}  // namespace parallax
