#include "worker/dataset/export/export.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <regex>
#include <set>

#include "common/base/system/file.h"
#include "common/image/io.h"
#include "tests/folder_test.h"
#include "tests/worker/dataset/synthetic_archive.h"
#include "worker/dataset/frame/plain_formats.h"
#include "worker/dataset/sheets/variant_sheet.h"
#include "worker/dataset/verify/verify.h"

namespace parallax {
namespace {

namespace fs = std::filesystem;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;
using Json = nlohmann::json;

class ExportTest : public FolderTest {
 protected:
  void SetUp() override {
    data_ = dir_ + "/data";
    out_ = dir_ + "/out";
  }

  absl::StatusOr<ExportResult> Export(ExportOptions options = {}) {
    return ExportDataset(data_, out_, options);
  }
  std::string Frame(const std::string& rest) { return data_ + "/a/frames/" + rest; }

  std::string data_, out_;
};

ino_t InodeOf(const std::string& path) {
  struct stat info {};
  return ::stat(path.c_str(), &info) == 0 ? info.st_ino : 0;
}

TEST_F(ExportTest, FlyingThingsLinksImagesAndWritesDisparityOfBothEyes) {
  MakeSyntheticArchive(data_);
  const auto result = Export();
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_EQ(result->pairs, 6);
  EXPECT_EQ(result->pairs_test, 2);  // The last scene.
  EXPECT_EQ(result->scenes_test, 1);
  EXPECT_EQ(result->files_linked, 6 * 4);
  for (const char* pass : {"frames_cleanpass", "frames_finalpass"}) {
    EXPECT_EQ(InodeOf(out_ + "/" + pass + "/TRAIN/A/000000/left/001.png"),
              InodeOf(Frame("000000/001/left.png")));
    EXPECT_EQ(InodeOf(out_ + "/" + pass + "/TEST/A/000002/right/000.png"),
              InodeOf(Frame("000002/000/right.png")));
  }
  for (const char* eye : {"left", "right"}) {
    ImageF disparity = *ReadExrY(Frame(std::string("000001/000/disparity_") + eye + ".exr"));
    for (float& d : disparity.values()) {
      if (d == 0) d = std::numeric_limits<float>::infinity();  // Sky.
    }
    EXPECT_EQ(*ReadPfm(out_ + "/disparity/TRAIN/A/000001/" + eye + "/000.pfm"), disparity);
  }
  EXPECT_EQ(
      *ReadFile(out_ + "/test.txt"),
      "frames_finalpass/TEST/A/000002/left/000.png frames_finalpass/TEST/A/000002/right/000.png "
      "disparity/TEST/A/000002/left/000.pfm\n"
      "frames_finalpass/TEST/A/000002/left/001.png frames_finalpass/TEST/A/000002/right/001.png "
      "disparity/TEST/A/000002/left/001.pfm\n");
  EXPECT_EQ(result->below_limit.size(), 6u);
  EXPECT_GT(result->below_limit.at(192), 0.5);
  EXPECT_EQ(result->below_limit.at(1000), 1);
}

TEST_F(ExportTest, SkyAndExteriorOfRoomsAreNoTruthInAnyLayout) {
  MakeSyntheticArchive(data_, {.sequence = true});
  // The middle of the first frame is said to be seen through a window.
  const int x = 48, y = 40;
  for (const std::string eye : {"left", "right"}) {
    ASSERT_GT((*ReadExrY(Frame("000000/000/disparity_" + eye + ".exr")))(x, y), 0);
    ImageU8 masks = *ReadPngU8(Frame("000000/000/masks_" + eye + ".png"));
    masks(x, y) = 2;
    fs::remove(Frame("000000/000/masks_" + eye + ".png"));
    ASSERT_TRUE(WritePng(Frame("000000/000/masks_" + eye + ".png"), masks).ok());
  }
  const auto make = [&](const std::string& layout) {
    out_ = dir_ + "/" + layout;
    const auto result = Export({.layout = layout});
    EXPECT_TRUE(result.ok()) << result.status();
    return out_ + "/";
  };
  const std::string things = make("flyingthings"), flow = make("flyingthings-flow");
  const std::string middlebury = make("middlebury"), kitti = make("kitti");
  const std::string cre = make("crestereo"), fsd = make("fsd"), replica = make("dynamic-replica");
  EXPECT_TRUE(std::isinf((*ReadPfm(things + "disparity/TRAIN/A/000000/left/000.pfm"))(x, y)));
  EXPECT_TRUE(std::isinf((*ReadPfm(things + "disparity/TRAIN/A/000000/right/000.pfm"))(x, y)));
  EXPECT_TRUE(std::isinf((*ReadPfm(middlebury + "000000_000/disp0GT.pfm"))(x, y)));
  EXPECT_EQ((*ReadPngU8(middlebury + "000000_000/mask0nocc.png"))(x, y), 0);
  EXPECT_EQ((*ReadPngU16(kitti + "training/disp_occ_0/000000_10.png"))(x, y), 0);
  EXPECT_GT((*ReadPngU16(kitti + "training/disp_occ_0/000000_10.png"))(x + 1, y), 0);
  EXPECT_EQ((*ReadPngRgb8(fsd + "000000/dataset/data/left/disparity/0000.png"))(x, y, 2), 0);
  EXPECT_EQ((*ReadPngU16(replica + "train/000000-p1_left/depths/0000.geometric.png"))(x, y), 0);
  for (const auto& entry : fs::recursive_directory_iterator(cre)) {
    if (entry.path().filename() != "000_left.disp.png") continue;
    if (entry.path().parent_path().filename() != "000000") continue;
    EXPECT_EQ((*ReadPngU16(entry.path()))(x, y), 0);
  }
  // Readers of flow divide by the disparity.
  for (const auto& entry : fs::recursive_directory_iterator(flow + "disparity/TRAIN")) {
    if (entry.path().extension() != ".pfm") continue;
    const auto disparity = ReadPfm(entry.path());
    ASSERT_TRUE(disparity.ok()) << disparity.status();
    for (const float d : disparity->values()) ASSERT_TRUE(std::isfinite(d));
  }
}

TEST_F(ExportTest, FilteredAndUnfilteredAreTwoReadings) {
  MakeSyntheticArchive(data_, {.last_frame_dark = true});
  auto result = Export();
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_EQ(result->pairs, 5);
  EXPECT_EQ(result->pairs_filtered_out, 1);
  EXPECT_FALSE(fs::exists(out_ + "/disparity/TEST/A/000002/left/001.pfm"));
  const ExportOptions options{.unfiltered = true};
  out_ += "2";
  result = Export(options);
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_EQ(result->pairs, 6);
  EXPECT_TRUE(fs::exists(out_ + "/disparity/TEST/A/000002/left/001.pfm"));
}

TEST_F(ExportTest, WebdatasetShardsNameTheirSplitAndHoldSeedsAsStrings) {
  MakeSyntheticArchive(data_);
  // The form of older archives.
  const std::string path = Frame("000000/000/frame.json");
  const std::string older = std::regex_replace(
      *ReadFile(path), std::regex(R"re("(seed|scene)":"(\d{3,})")re"), R"re("$1":$2)re");
  ASSERT_THAT(older, HasSubstr("{\"scene\":18446744073709551557}"));
  fs::remove(path);
  ASSERT_TRUE(WriteFile(path, older).ok());
  const auto result = Export({.layout = "webdataset", .shard_pairs = 3});
  ASSERT_TRUE(result.ok()) << result.status();
  std::set<std::string> files;
  for (const auto& entry : fs::directory_iterator(out_)) files.insert(entry.path().filename());
  EXPECT_THAT(files, ElementsAre("LICENSE", "README.md", "SHA256SUMS", "croissant.json",
                                 "export.json", "test-000000.tar", "test.txt", "train-000000.tar",
                                 "train-000001.tar", "train.txt"));
  EXPECT_THAT(*ReadFile(out_ + "/README.md"), HasSubstr("path: train-*.tar"));
  EXPECT_THAT(*ReadFile(out_ + "/README.md"), Not(HasSubstr("viewer:")));
  const std::string shard = *ReadFile(out_ + "/train-000000.tar");
  EXPECT_THAT(shard, HasSubstr("\"seeds\":{\"scene\":\"18446744073709551557\"}"));
  EXPECT_THAT(shard, HasSubstr("\"seed\":\"201\""));
  EXPECT_THAT(shard, Not(HasSubstr("\"seed\":201")));
  EXPECT_THAT(shard, Not(HasSubstr("\"moving\"")));
  EXPECT_EQ(VerifyDataset(out_)->findings_total, 0);
}

TEST_F(ExportTest, WebdatasetOfSequencesHasARowForEachThingThatMoves) {
  MakeSyntheticArchive(data_, {.sequence = true});
  ASSERT_TRUE(Export({.layout = "webdataset"}).ok());
  const std::string shard = *ReadFile(out_ + "/train-000000.tar");
  EXPECT_THAT(shard, HasSubstr("\"moving\":[{\"index\":3,\"pose\":[["));
  EXPECT_THAT(shard, HasSubstr("{\"index\":4,\"pose\":[["));
}

TEST_F(ExportTest, InfraredPicturesAreThePairWhereTheDatasetHasThem) {
  MakeSyntheticArchive(data_);
  ExportOptions options{.infrared = true};
  auto result = Export(options);
  EXPECT_EQ(result.status().code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(std::string(result.status().message()), HasSubstr("no infrared pictures"));
  SyntheticArchive archive{.extras = true};
  archive.sequence = true;  // All layouts take sequences.
  MakeSyntheticArchive(data_, archive);
  EXPECT_EQ(VerifyDataset(data_)->findings_total, 0);
  for (const std::string& layout : ExportLayouts()) {
    SCOPED_TRACE(layout);
    options.layout = layout;
    fs::remove_all(out_);
    result = Export(options);
    ASSERT_TRUE(result.ok()) << result.status();
    EXPECT_EQ(VerifyDataset(out_)->findings_total, 0);
  }
}

// Finds the links to pictures among the files of an export, each by the name of what it links to.
std::set<std::string> PicturesLinked(const std::string& out, const std::string& dataset) {
  std::map<ino_t, std::string> names;
  for (const auto& entry : fs::recursive_directory_iterator(dataset)) {
    const std::string name = entry.path().filename();
    if (name.ends_with("left.png") || name.ends_with("right.png")) {
      names[InodeOf(entry.path())] = name;
    }
  }
  std::set<std::string> linked;
  for (const auto& entry : fs::recursive_directory_iterator(out)) {
    const auto found = names.find(InodeOf(entry.path()));
    if (found != names.end()) linked.insert(found->second);
  }
  return linked;
}

TEST_F(ExportTest, LayoutsThatLinkPicturesLinkTheInfraredOnes) {
  SyntheticArchive archive{.extras = true};
  archive.sequence = true;  // All layouts take sequences.
  MakeSyntheticArchive(data_, archive);
  const std::set<std::string> others = {"fsd", "crestereo", "webdataset"};  // They link nothing.
  for (const std::string& layout : ExportLayouts()) {
    if (others.contains(layout)) continue;
    SCOPED_TRACE(layout);
    for (const bool infrared : {false, true}) {
      const ExportOptions options{.layout = layout, .infrared = infrared};
      fs::remove_all(out_);
      ASSERT_TRUE(Export(options).ok());
      std::set<std::string> linked = PicturesLinked(out_, data_);
      linked.erase("objects_left.png");
      linked.erase("objects_right.png");
      if (infrared) {
        EXPECT_THAT(linked, ElementsAre("infrared_left.png", "infrared_right.png"));
      } else {
        EXPECT_THAT(linked, ElementsAre("left.png", "right.png"));
      }
    }
  }
}

TEST_F(ExportTest, ADamagedFrameJsonEndsItWithItsFolderAndNothingWritten) {
  MakeSyntheticArchive(data_, {.sequence = true});
  const std::string path = Frame("000001/001/frame.json");
  const Json whole = Json::parse(*ReadFile(path));
  const auto damage = [&](const Json& json) {
    fs::remove(path);  // A link: the store's file stays whole.
    ASSERT_TRUE(WriteFile(path, json.dump()).ok());
  };
  const auto expect_damaged = [&](const std::string& layout) {
    SCOPED_TRACE(layout);
    const auto result = Export({.layout = layout});
    EXPECT_EQ(result.status().code(), absl::StatusCode::kDataLoss) << result.status();
    EXPECT_THAT(std::string(result.status().message()), HasSubstr("000001/001/frame.json"));
    EXPECT_FALSE(fs::exists(out_));
    EXPECT_FALSE(fs::exists(dir_ + "/.out.partial"));
  };
  Json damaged = whole;
  damaged["intrinsics"]["fx"] = "wide";
  damage(damaged);
  for (const char* layout : {"fsd", "middlebury", "dynamic-replica"}) expect_damaged(layout);
  damaged = whole;
  damaged["objects"] = 7;
  damage(damaged);
  expect_damaged("webdataset");
  damaged = whole;
  damaged["sequence"] = Json::object();
  damage(damaged);
  for (const char* layout : {"flyingthings-flow", "sintel", "dynamic-replica"}) {
    expect_damaged(layout);
  }
}

TEST_F(ExportTest, DynamicReplicasTestScenesAreValidToo) {
  MakeSyntheticArchive(data_, {.sequence = true});
  ASSERT_TRUE(Export({.layout = "dynamic-replica"}).ok());
  for (const char* split : {"train", "test", "valid"}) {
    EXPECT_TRUE(fs::exists(out_ + "/" + split + "/frame_annotations_" + split + ".jgz")) << split;
  }
  EXPECT_EQ(std::distance(fs::directory_iterator(out_ + "/valid"), {}), 1) << "a list alone";
}

TEST_F(ExportTest, DynamicReplicaNotesShortTestsAndRefusesChangingBaselines) {
  MakeSyntheticArchive(data_, {.sequence = true});
  ExportOptions options{.layout = "dynamic-replica"};
  auto result = Export(options);
  ASSERT_TRUE(result.ok()) << result.status();
  ASSERT_EQ(result->notes.size(), 1u);
  EXPECT_THAT(result->notes[0], HasSubstr("no sequence for tests has 40 frames"));
  fs::remove_all(out_);
  const std::string path = Frame("000001/001/frame.json");
  Json json = Json::parse(*ReadFile(path));
  json["baseline_m"] = json["baseline_m"].get<double>() + 0.01;
  fs::remove(path);  // A link: the store's file stays whole.
  ASSERT_TRUE(WriteFile(path, json.dump()).ok());
  result = Export(options);
  EXPECT_EQ(result.status().code(), absl::StatusCode::kFailedPrecondition) << result.status();
  EXPECT_THAT(std::string(result.status().message()), HasSubstr("nature.walk.baseline_per"));
  options.layout = "flyingthings-flow";
  EXPECT_TRUE(Export(options).ok());
}

TEST_F(ExportTest, PicturesThatAreCutOffAreHoles) {
  MakeSyntheticArchive(data_, {.extras = true});
  for (const char* name : {"right.png", "infrared_left.png"}) {
    SCOPED_TRACE(name);
    const std::string path = Frame(std::string("000001/000/") + name);
    const std::string whole = *ReadFile(path);
    for (const size_t size : {whole.size() - 1, size_t{5}}) {
      fs::remove(path);  // A link: the store's file stays whole.
      ASSERT_TRUE(WriteFile(path, whole.substr(0, size)).ok());
      EXPECT_THAT(std::string(Export({.infrared = true}).status().message()),
                  HasSubstr("is cut off"));
      EXPECT_FALSE(fs::exists(out_));
    }
    fs::remove(path);
    ASSERT_TRUE(WriteFile(path, whole + "abc").ok());
    EXPECT_THAT(std::string(Export({.infrared = true}).status().message()),
                HasSubstr(std::string(name) + " has 3 bytes behind its end"));
    ASSERT_TRUE(WriteFile(path, whole).ok());
  }
}

TEST_F(ExportTest, RefusesHolesAndLeavesNothingBehind) {
  const auto expect_refused = [&](const std::string& what) {
    const auto result = Export();
    EXPECT_EQ(result.status().code(), absl::StatusCode::kFailedPrecondition) << result.status();
    EXPECT_THAT(std::string(result.status().message()), HasSubstr(what));
    EXPECT_FALSE(fs::exists(out_));
  };
  MakeSyntheticArchive(data_);
  fs::remove(Frame("000001/000/disparity_right.exr"));
  expect_refused("000001/000/disparity_right.exr is missing");
  MakeSyntheticArchive(data_);
  fs::remove_all(Frame("000001/000"));
  expect_refused("000001/000");
  MakeSyntheticArchive(data_);
  fs::copy(Frame("000001/000"), Frame("000001/007"));
  expect_refused("000001/007: not in the index");
  MakeSyntheticArchive(data_, {.variants = {"a", "b"}});
  fs::remove(data_ + "/b/index.jsonl");
  expect_refused("b/index.jsonl: missing");
  fs::remove_all(data_ + "/b");
  expect_refused("the study's variant b is not in");
  EXPECT_TRUE(Export({.variants = {"a"}}).ok());
  fs::remove_all(out_);
  EXPECT_TRUE(Export({.allow_incomplete = true}).ok());
  fs::remove_all(out_);
  MakeSyntheticArchive(data_, {.last_frame_missing = true});
  expect_refused("has 5 of 6 pairs");
  const ExportOptions options{.allow_incomplete = true};
  EXPECT_TRUE(Export(options).ok());
  // And what is there already.
  EXPECT_EQ(Export(options).status().code(), absl::StatusCode::kFailedPrecondition);
}

TEST_F(ExportTest, ADamagedPictureIsNotPacked) {
  MakeSyntheticArchive(data_);
  const std::string path = Frame("000001/000/right.png");
  std::string bytes = *ReadFile(path);
  bytes[bytes.size() / 2] ^= 1;
  fs::remove(path);  // A link: the store's file stays whole.
  ASSERT_TRUE(WriteFile(path, bytes).ok());
  const auto result = Export({.layout = "webdataset"});
  EXPECT_EQ(result.status().code(), absl::StatusCode::kDataLoss) << result.status();
  EXPECT_THAT(std::string(result.status().message()), HasSubstr("000001/000/right.png"));
  EXPECT_FALSE(fs::exists(out_));
}

TEST_F(ExportTest, ALinkToAnEmptyFolderIsRefusedAndAnEmptyFolderIsNot) {
  MakeSyntheticArchive(data_);
  fs::create_directory(dir_ + "/elsewhere");
  fs::create_directory_symlink(dir_ + "/elsewhere", out_);
  const auto result = Export();
  EXPECT_EQ(result.status().code(), absl::StatusCode::kFailedPrecondition) << result.status();
  EXPECT_THAT(std::string(result.status().message()), HasSubstr("is a link or a mount point"));
  EXPECT_TRUE(fs::is_symlink(out_));
  fs::remove(out_);
  fs::create_directory(out_);
  EXPECT_TRUE(Export().ok());
}

TEST_F(ExportTest, AllPairsOfALargeSceneComeInOrder) {
  MakeSyntheticArchive(data_, {.scenes = 1, .rigs = 40, .width_px = 48, .height_px = 27});
  ASSERT_TRUE(Export({.layout = "webdataset", .unfiltered = true}).ok());
  const std::string shards =
      *ReadFile(out_ + "/train-000000.tar") + *ReadFile(out_ + "/test-000000.tar");
  std::string keys;
  size_t at = 0;
  for (int rig = 0; rig < 40; ++rig) {
    const std::string key = (rig < 10 ? "000000_00" : "000000_0") + std::to_string(rig);
    at = shards.find(key + ".left.png", at);
    ASSERT_NE(at, std::string::npos) << key;
    keys += key + "\n";
  }
  EXPECT_EQ(*ReadFile(out_ + "/train.txt") + *ReadFile(out_ + "/test.txt"), keys);
}

TEST_F(ExportTest, ABrokenMapEndsItWithNothingWritten) {
  MakeSyntheticArchive(data_);
  fs::remove(Frame("000000/000/disparity_left.exr"));  // A link: the store's file stays whole.
  std::ofstream(Frame("000000/000/disparity_left.exr")) << "not EXR";
  const auto result = Export();
  EXPECT_FALSE(result.ok());
  EXPECT_THAT(std::string(result.status().message()), HasSubstr("000000/000"));
  EXPECT_FALSE(fs::exists(out_));
  EXPECT_FALSE(fs::exists(dir_ + "/.out.partial"));
}

TEST_F(ExportTest, VariantsOfOneSceneFallIntoOneSplitAndHaveSafeNames) {
  MakeSyntheticArchive(data_, {.variants = {"left-handed", "plain"}});
  ExportOptions options;
  auto result = Export(options);
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_EQ(result->pairs, 12);
  EXPECT_EQ(result->scenes_test, 2);
  EXPECT_TRUE(fs::exists(out_ + "/disparity/TEST/A/lft-handed-000002/left/000.pfm"));
  EXPECT_TRUE(fs::exists(out_ + "/disparity/TEST/A/plain-000002/left/000.pfm"));
  for (const auto& entry : fs::recursive_directory_iterator(out_)) {
    const std::string path = fs::relative(entry.path(), out_);
    EXPECT_EQ(path.find(' '), std::string::npos);
    EXPECT_EQ(path.find("left-"), std::string::npos) << path;
  }
  options.variants = {"pl*"};
  out_ += "2";
  result = Export(options);
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_EQ(result->pairs, 6);
  options.variants = {"huge"};
  EXPECT_EQ(Export(options).status().code(), absl::StatusCode::kInvalidArgument);
}

TEST_F(ExportTest, HeldoutPairsAreExportedOnlyWhereTheyAreNamed) {
  MakeSyntheticArchive(data_, {.variants = {"a", "heldout"}});
  auto result = Export();
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_EQ(result->pairs, 6);
  EXPECT_TRUE(fs::exists(out_ + "/disparity/TEST/A/000002/left/000.pfm"));
  ASSERT_EQ(result->notes.size(), 1u);
  EXPECT_THAT(result->notes[0], HasSubstr("heldout are left out"));
  for (const std::string name : {"heldout", "*"}) {
    const ExportOptions options{.variants = {name}};
    fs::remove_all(out_);
    result = Export(options);
    ASSERT_TRUE(result.ok()) << result.status();
    EXPECT_EQ(result->pairs, name == "*" ? 12 : 6);
    EXPECT_TRUE(result->notes.empty());
  }
  fs::remove_all(out_);
  result = ExportDataset(data_ + "/heldout", out_, {});
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_EQ(result->pairs, 6);
  EXPECT_EQ(VerifyDataset(data_)->frames, 12) << "verify looks at all";
}

TEST_F(ExportTest, OneSceneGivesItsLastPairToTestAndSaysSo) {
  MakeSyntheticArchive(data_, {.scenes = 1});
  const auto result = Export();
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_EQ(result->pairs_test, 1);
  ASSERT_EQ(result->notes.size(), 1u);
  EXPECT_THAT(result->notes[0], HasSubstr("one scene"));
}

TEST_F(ExportTest, TestSequencesAreChosenAmongThoseThatAreExported) {
  SyntheticArchive archive{.last_frame_dark = true, .sequence = true};
  MakeSyntheticArchive(data_, archive);  // The last scene has one frame left.
  auto result = Export({.layout = "sintel"});
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_EQ(result->pairs, 4);
  EXPECT_EQ(result->pairs_test, 2);
  EXPECT_EQ(result->scenes_test, 1);
  archive.scenes = 2;
  MakeSyntheticArchive(data_, archive);
  fs::remove_all(out_);
  result = Export({.layout = "sintel"});
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_EQ(result->pairs_test, 0);
  EXPECT_THAT(result->notes, Contains(HasSubstr("one sequence only")));
  EXPECT_THAT(result->notes, Not(Contains(HasSubstr("TEST is its last one"))));
}

TEST_F(ExportTest, EveryLayoutIsWholeAndAChangedFileIsFound) {
  SyntheticArchive archive;
  archive.sequence = true;  // All layouts take sequences.
  MakeSyntheticArchive(data_, archive);
  for (const std::string& layout : ExportLayouts()) {
    const ExportOptions options{.layout = layout};
    out_ = dir_ + "/" + layout;
    ASSERT_TRUE(Export(options).ok()) << layout;
    auto verified = VerifyDataset(out_);
    ASSERT_TRUE(verified.ok()) << verified.status();
    EXPECT_EQ(verified->findings_total, 0) << layout;
    EXPECT_GT(verified->files, 4) << layout;
    std::ofstream(out_ + "/train.txt", std::ios::app) << "x";
    std::ofstream(out_ + "/more.txt") << "x";
    verified = VerifyDataset(out_);
    EXPECT_EQ(verified->findings_total, 2) << layout;
  }
  EXPECT_EQ(Export({.layout = "tfrecord"}).status().code(), absl::StatusCode::kInvalidArgument);
}

TEST_F(ExportTest, VariantSheetShowsEachVariantOnceForEachPair) {
  MakeSyntheticArchive(data_, {.variants = {"a", "b", "c"}, .scenes = 1});
  const auto result = MakeVariantSheet(data_, dir_ + "/sheet.png", {.tile_width_px = 96});
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_EQ(result->pairs, 2);
  EXPECT_EQ(result->variants, (std::vector<std::string>{"a", "b", "c"}));
  EXPECT_GT(ReadPngRgb8(dir_ + "/sheet.png")->width(), 3 * 96);
  EXPECT_FALSE(MakeVariantSheet(data_ + "/a", dir_ + "/x.png").ok());
}

TEST(PlainFormats, NpyHeaderIsAMultipleOf64AndTellsTheShape) {
  ImageF image(3, 2);
  image(2, 1) = 7.5f;
  const std::string bytes = EncodeNpy(image);
  EXPECT_EQ(bytes.size() % 64, 24u);
  EXPECT_THAT(bytes, HasSubstr("'shape': (2, 3)"));
  EXPECT_FALSE(TarMember(std::string(101, 'x'), "").ok());
}

}  // namespace
}  // namespace parallax
