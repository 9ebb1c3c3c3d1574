#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "common/image/io.h"
#include "common/image/jpeg.h"
#include "tests/coordinator/client/command_test.h"
#include "tests/worker/dataset/synthetic_archive.h"

namespace parallax::client {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::Not;
using Json = nlohmann::json;

TEST_F(CommandTest, FetchFromAStoreThatNobodySendsIsClear) {
  coordinator_.studies = {Baseline()};
  coordinator_.studies[0].mutable_spec()->add_variants()->set_name("narrow");
  v1::PublishedFrame frame;
  frame.set_cursor(1);
  frame.set_variant("narrow");
  frame.mutable_frame()->set_path("key/.attempt-1/000");
  v1::FileEntry& file = *frame.mutable_frame()->add_files();
  file.set_name("left.png");
  file.set_size(1);
  file.set_sha256(std::string(64, '0'));
  (*frame.mutable_frame()->mutable_statistics())["mean_intensity"] = 90;
  (*frame.mutable_frame()->mutable_statistics())["min_depth_m"] = 1;
  coordinator_.frames = {frame};
  // A coordinator of an older version, and neither an object store nor a folder that is here.
  for (const std::string& store :
       {std::string("s3://somewhere"), "file://" + dir_ + "/elsewhere"}) {
    coordinator_.store_uri = store;
    const Outcome outcome = Run({"fetch", "3", "--out", dir_ + "/out-" + store.substr(0, 2)});
    EXPECT_EQ(outcome.exit_code, kExitUsage) << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr("can't be seen from here"));
  }
  EXPECT_FALSE(fs::exists(dir_ + "/elsewhere")) << "a store is never made by reading it";
}

TEST_F(CommandTest, ARoomSaysWhichOfItsClassesAreOff) {
  const std::string file = WriteText("yard.yaml",
                                     "furniture:\n"
                                     "  - {group: green, classes: [Cactus, Bush], count: [1, 2]}\n"
                                     "  - {group: desk, classes: [SimpleDesk]}\n"
                                     "things:\n"
                                     "  - {bearer: desk, classes: [Urchin, Book]}\n");
  const Outcome outcome = RunCommand({"config", "room", file});
  EXPECT_EQ(outcome.exit_code, kExitOk) << outcome.err;
  EXPECT_THAT(outcome.err, HasSubstr("group green: Cactus is off in rooms"));
  EXPECT_THAT(outcome.err, HasSubstr("group desk: Urchin is off in rooms"));
  EXPECT_THAT(outcome.err, Not(HasSubstr("Bush")));
  EXPECT_EQ(RunCommand({"config", "room", "office"}).err, "");
}

TEST_F(CommandTest, AuditTellsWhoDidWhat) {
  v1::AuditEntry entry;
  entry.set_id(7);
  entry.set_unix_s(1795000000);
  entry.set_actor("submitter ada ipv4:10.0.0.7:4711");
  entry.set_action("cancel");
  entry.set_study_id(3);
  entry.set_detail("enough");
  coordinator_.audit = {entry};
  const Json json = RunJson({"audit"});
  EXPECT_EQ(json["entries"][0]["actor"], "submitter ada ipv4:10.0.0.7:4711");
  EXPECT_EQ(json["entries"][0]["action"], "cancel");
  EXPECT_EQ(json["entries"][0]["study_id"], 3);
  EXPECT_THAT(Run({"audit"}).out, HasSubstr("2026-11-18 11:06:40"));
  coordinator_.audit.clear();
  EXPECT_THAT(Run({"audit"}).out, HasSubstr("nothing has been done yet"));
}

TEST_F(CommandTest, SceneShowReadsFilesAndCoordinators) {
  coordinator_.studies = {Baseline()};
  v1::Scene scene;
  scene.set_generator_version("1");
  scene.set_scene_seed(255);
  scene.set_type(v1::SCENE_TYPE_DENSE);
  coordinator_.scene = scene;
  EXPECT_THAT(Run({"scene", "show", "3", "narrow", "0"}).out, HasSubstr("scene 00000000000000ff"));
  const std::string file = WriteText("000000.pb", scene.SerializeAsString());
  EXPECT_THAT(RunCommand({"scene", "show", file}).out, HasSubstr("scene 00000000000000ff"));
  EXPECT_EQ(Json::parse(RunCommand({"scene", "show", file, "--json"}).out)["scene_seed"], "255");
  EXPECT_THAT(RunCommand({"scene", "show", file, "--textproto"}).out, HasSubstr("scene_seed: 255"));
  // A dataset's folder, with no coordinator at hand.
  for (const char* variant : {"narrow", "wide"}) {
    fs::create_directories(dir_ + "/data/" + variant + "/scenes");
    std::ofstream(dir_ + "/data/" + variant + "/scenes/000012.pb") << scene.SerializeAsString();
  }
  const auto from_folder = [&](const char* variant, const char* number) {
    return RunCommand({"scene", "show", dir_ + "/data", variant, number});
  };
  EXPECT_THAT(from_folder("wide", "12").out, HasSubstr("scene 00000000000000ff"));
  EXPECT_THAT(from_folder("huge", "12").err,
              HasSubstr("data has no variant 'huge'; it has narrow, wide"));
  EXPECT_THAT(from_folder("wide", "3").err,
              HasSubstr("has no scene 3; it has 1, from 000012 to 000012"));
  EXPECT_THAT(from_folder("wide", "x").err, HasSubstr("'x' is not a scene's number"));
  EXPECT_THAT(RunCommand({"scene", "show", dir_, "wide", "0"}).err, HasSubstr("no dataset"));
  Outcome outcome = Run({"scene", "show", "3", "huge", "0"});
  EXPECT_EQ(outcome.exit_code, kExitUsage);
  EXPECT_THAT(outcome.err, HasSubstr("has no variant 'huge'; it has narrow, wide"));
  outcome = RunCommand({"scene", "show", WriteText("x.pb", "hello")});
  EXPECT_EQ(outcome.exit_code, kExitUsage);
  EXPECT_THAT(outcome.err, HasSubstr("not a scene recipe"));
}

TEST_F(CommandTest, ScenesOfAMistypedFolderSayThatThereIsNone) {
  const Outcome path = RunCommand({"scene", "show", dir_ + "/nosuch", "narrow", "0"});
  EXPECT_EQ(path.exit_code, kExitUsage);
  EXPECT_THAT(path.err, HasSubstr("/nosuch: no such folder\n"));
  const std::vector<std::string> mistyped = {"scene", "show", "nosuch", "narrow", "0"};
  std::vector<std::string> alone = mistyped;
  alone.insert(alone.end(), {"--coordinator", "unix:" + dir_ + "/socket"});
  Outcome outcome = RunCommand(alone);
  EXPECT_EQ(outcome.exit_code, kExitUnreachable);
  EXPECT_THAT(outcome.err, HasSubstr("nosuch: no such folder here, and no coordinator at "));
  coordinator_.studies = {Baseline()};
  outcome = Run(mistyped);
  EXPECT_EQ(outcome.exit_code, kExitUsage);
  EXPECT_THAT(outcome.err, HasSubstr("nosuch: no such folder here, and no study '"));
  fs::create_directories(dir_ + "/data/narrow/scenes");
  outcome = RunCommand({"scene", "show", dir_ + "/data"});
  EXPECT_THAT(outcome.err, HasSubstr("/data VARIANT SCENE with a variant of narrow"));
}

TEST_F(CommandTest, VerifySaysHowManyPairsAreStillToCome) {
  const std::string dir = dir_ + "/data";
  MakeSyntheticArchive(dir, {.variants = {"a", "b"}, .scenes = 1, .last_frame_missing = true});
  Outcome outcome = RunCommand({"verify", dir, "--no-geometry"});
  EXPECT_EQ(outcome.exit_code, kExitOk) << outcome.out << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("data: 2 of 4 pairs asked for, "));
  EXPECT_THAT(outcome.out, HasSubstr("all as it should be"));
  EXPECT_THAT(RunCommand({"verify", dir + "/a", "--no-geometry"}).out,
              HasSubstr("a: 1 of 2 pairs asked for, "));
  Json json = Json::parse(RunCommand({"verify", dir, "--no-geometry", "--json"}).out);
  EXPECT_EQ(json["frames"], 2);
  EXPECT_EQ(json["pairs_wanted"], 4);
  MakeSyntheticArchive(dir, {.scenes = 1, .rigs = 1, .last_frame_missing = true});
  outcome = RunCommand({"verify", dir});
  EXPECT_EQ(outcome.exit_code, kExitOk) << outcome.out;
  EXPECT_THAT(outcome.out, HasSubstr("0 of 1 pair asked for, 0 files (0 B), nothing to check yet"));
  MakeSyntheticArchive(dir, {.scenes = 1, .rigs = 1});
  EXPECT_THAT(RunCommand({"verify", dir, "--no-geometry"}).out, HasSubstr("data: 1 pair, "));
}

TEST_F(CommandTest, ViewTellsTheColumnsOfItsSheet) {
  const std::string help = RunCommand({"view", "--help"}).out;
  for (const char* column :
       {"left", "right", "disparity", "occlusion", "objects", "materials", "normals"}) {
    EXPECT_THAT(help, HasSubstr(column));
  }
  EXPECT_THAT(help, Not(HasSubstr("depth")));
}

TEST_F(CommandTest, PredictRefusesWhatIsNoCheckpoint) {
  const std::string yaml = WriteText("tiny.yaml", "study: tiny\n");
  const Outcome outcome =
      RunCommand({"predict", yaml, "left.png", "right.png", "--out", dir_ + "/d.pfm"});
  EXPECT_EQ(outcome.exit_code, kExitUsage);
  EXPECT_THAT(outcome.err, HasSubstr(yaml + ": no checkpoint of the built-in trainer"));
}

// ---- Own pictures

TEST_F(CommandTest, PicturesThatAreNoneAreNamed) {
  fs::create_directories(dir_ + "/own/sub");
  const ImageRgb8 image(40, 30);
  const std::string png = *EncodePng(image), jpeg = *EncodeJpeg(image, 90);
  WriteText("own/a.png", png);
  WriteText("own/sub/b.jpg", jpeg);
  WriteText("own/c.png", jpeg);  // Content counts, not the name.
  const Outcome good = RunCommand({"config", "pictures", dir_ + "/own"});
  EXPECT_EQ(good.exit_code, kExitOk) << good.err;
  EXPECT_THAT(good.out, testing::MatchesRegex("a.png: [^\n]*\nc.png: [^\n]*\nsub/b.jpg: [^\n]*\n"
                                              "[0-9a-f]*\n"));
  const struct {
    std::string bytes;
    const char* wanted;
  } cases[] = {
      {"just text", "neither a PNG nor a JPEG"},
      {"", "neither a PNG nor a JPEG"},
      {png.substr(0, png.size() / 2), "broken PNG: ends early"},
      {png.substr(0, png.size() - 1), "broken PNG: ends early"},
      {png.substr(0, 8) + "nonsense that is long enough", "broken PNG: "},
      {png.substr(0, 16) + std::string(4, '\0') + png.substr(20), "broken PNG: "},
      {jpeg.substr(0, jpeg.size() / 2), "broken JPEG: "},
      {jpeg.substr(0, 30), "broken JPEG: "},
      {"\xff\xd8 and text", "broken JPEG: "},
  };
  const std::string study =
      WriteText("s.yaml",
                "study: s\npairs: 2\nvariants:\n  - name: a\n    set: {materials: "
                "{picture_dir: '" +
                    dir_.substr(1) + "/own'}}\n");
  for (const auto& c : cases) {
    const std::string bad = WriteText("own/sub/bad.png", c.bytes);
    for (const std::vector<std::string>& command : std::vector<std::vector<std::string>>{
             {"config", "pictures", dir_ + "/own"}, {"run", study, "--out", dir_ + "/out"}}) {
      const Outcome outcome = RunCommand(command);
      EXPECT_EQ(outcome.exit_code, kExitUsage) << c.wanted;
      EXPECT_THAT(outcome.err, HasSubstr(bad + ": " + c.wanted));
    }
    EXPECT_THAT(Run({"submit", study}).err, HasSubstr(bad));
  }
  EXPECT_FALSE(fs::exists(dir_ + "/out"));
  EXPECT_TRUE(coordinator_.submitted.empty());
}

}  // namespace
}  // namespace parallax::client
