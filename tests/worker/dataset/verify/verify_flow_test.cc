// Faults that `verify` finds in flow maps and in frame.json's facts on sequences.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>

#include "common/base/system/file.h"
#include "common/image/io.h"
#include "parallax/v1/scene.pb.h"
#include "tests/folder_test.h"
#include "tests/worker/dataset/synthetic_archive.h"
#include "worker/dataset/export/export.h"
#include "worker/dataset/verify/verify.h"

namespace parallax {
namespace {

namespace fs = std::filesystem;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::StartsWith;
using Json = nlohmann::ordered_json;

class VerifyFlowTest : public FolderTest {
 protected:
  void SetUp() override { MakeSyntheticArchive(data_, {.scenes = 2, .rigs = 4, .sequence = true}); }

  std::vector<std::string> Messages() {
    const auto result = VerifyDataset(data_);
    EXPECT_TRUE(result.ok()) << result.status();
    std::vector<std::string> messages;
    for (const Finding& finding : result->findings) {
      messages.push_back(finding.check + " " + fs::path(finding.path).filename().string() + ": " +
                         finding.message);
    }
    return messages;
  }

  const std::string data_ = dir_ + "/data", frame_ = data_ + "/a/frames/000000/001";
};

TEST_F(VerifyFlowTest, ASequenceAsItWasWrittenIsInOrder) { EXPECT_THAT(Messages(), IsEmpty()); }

TEST_F(VerifyFlowTest, AFlowThatIsOffAHundredthOfAPixelIsFound) {
  for (const char* name : {"flow_forward_left.exr", "flow_backward_right.exr"}) {
    for (const int channel : {0, 1, 2}) {
      const std::string whole = *ReadFile(frame_ + "/" + name);
      ImageF3 flow = *DecodeExrRgb(whole);
      flow(40, 30, channel) += 0.01f;
      ForgeFile(data_, name, *EncodeExrRgb(flow));
      EXPECT_THAT(Messages(), Contains(HasSubstr(std::string("flow ") + name + ": (40, 30)")))
          << channel;
      ForgeFile(data_, name, whole);
    }
  }
  EXPECT_THAT(Messages(), IsEmpty());
}

TEST_F(VerifyFlowTest, OcclusionThatTheNeighbourDoesNotShowIsFound) {
  const std::string name = "flow_occlusion_forward_left.png";
  ImageU8 mask = *ReadPngU8(frame_ + "/" + name);
  for (int y = 5; y < 30; ++y) {
    for (int x = 20; x < 50; ++x) mask(x, y) = static_cast<uint8_t>(255 - mask(x, y));
  }
  ForgeFile(data_, name, *EncodePng(mask));
  EXPECT_THAT(Messages(), Contains(HasSubstr("judged otherwise by the neighbour's depth")));
  mask(3, 4) = 7;
  ForgeFile(data_, name, *EncodePng(mask));
  EXPECT_THAT(Messages(), Contains(HasSubstr("(3, 4): 7, wanted 0, 128 or 255")));
}

// At so small a size, edges are a large part of all pixels.
TEST_F(VerifyFlowTest, OcclusionOfASmallSequenceIsInOrder) {
  SyntheticArchive archive{.rigs = 4, .sequence = true};
  for (const int width_px : {24, 40, 64}) {
    archive.width_px = width_px;
    archive.height_px = width_px * 9 / 16;
    MakeSyntheticArchive(data_, archive);
    EXPECT_THAT(Messages(), Not(Contains(StartsWith("flow ")))) << width_px;
  }
}

TEST_F(VerifyFlowTest, AMotionThatIsNotThatOfThePosesIsFound) {
  for (const char* field : {"velocity_m_s", "turn_rad_s"}) {
    Json json = Json::parse(*ReadFile(frame_ + "/frame.json"));
    const std::string whole = json.dump();
    json["motion"][field][1] = json["motion"][field][1].get<double>() + 1e-3;
    ForgeFile(data_, "frame.json", json.dump());
    EXPECT_THAT(Messages(), Contains(HasSubstr("not that of the recipe's poses"))) << field;
    ForgeFile(data_, "frame.json", whole);
  }
  EXPECT_THAT(Messages(), IsEmpty());
}

TEST_F(VerifyFlowTest, ARecipeWhoseThingsMoveOtherwiseIsFound) {
  const std::string path = data_ + "/a/scenes/000000.pb";
  v1::Scene scene;
  ASSERT_TRUE(scene.ParseFromString(*ReadFile(path)));
  scene.mutable_objects(3)->mutable_motion()->mutable_velocity_mps()->set_y(0.4);
  fs::remove(path);
  ASSERT_TRUE(WriteFile(path, scene.SerializeAsString()).ok());
  EXPECT_THAT(Messages(), Contains(HasSubstr("object 4 is not where the recipe's motion puts it")));
  EXPECT_THAT(Messages(), Contains(HasSubstr("depth and motion give")));
}

TEST_F(VerifyFlowTest, FrameJsonThatNamesAnotherNeighbourIsFound) {
  Json json = Json::parse(*ReadFile(frame_ + "/frame.json"));
  EXPECT_EQ(json["sequence"]["next"], 2);
  json["sequence"]["next"] = 3;
  ForgeFile(data_, "frame.json", json.dump());
  EXPECT_THAT(Messages(), Contains(HasSubstr("sequence is")));
}

TEST_F(VerifyFlowTest, AnExportCutsASequenceWhereAFrameIsFilteredOut) {
  ChangeIndex(data_, [](Json& line) {
    if (line["scene"] == 0 && line["rig"] == 1) line["passed"] = false;
  });
  const auto result = ExportDataset(data_, dir_ + "/out", {.layout = "sintel"});
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_EQ(result->pairs, 2 + 4);  // Frame 0 has no neighbour any more.
  EXPECT_THAT(result->notes, Contains(HasSubstr("1 pairs of a have no neighbour")));
  EXPECT_TRUE(fs::exists(dir_ + "/out/Sintel/training/flow/000000-p1-r1/frame_0001.flo"));
  EXPECT_FALSE(fs::exists(dir_ + "/out/Sintel/training/flow/000000-p1-r1/frame_0002.flo"));
}

TEST_F(VerifyFlowTest, ADatasetWithoutSequencesIsRefusedByTheirLayouts) {
  MakeSyntheticArchive(dir_ + "/single");
  for (const char* layout : {"flyingthings-flow", "sintel", "dynamic-replica"}) {
    const auto result = ExportDataset(dir_ + "/single", dir_ + "/out", {.layout = layout});
    EXPECT_EQ(result.status().code(), absl::StatusCode::kFailedPrecondition);
    EXPECT_THAT(std::string(result.status().message()), HasSubstr("belongs to no sequence"));
  }
}

}  // namespace
}  // namespace parallax
