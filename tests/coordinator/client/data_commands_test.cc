#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "tests/coordinator/client/command_test.h"

namespace parallax::client {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
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

}  // namespace
}  // namespace parallax::client
