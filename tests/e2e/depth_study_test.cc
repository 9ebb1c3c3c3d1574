// `parallax run`, `verify` and `scene show` of halls, open plans, houses in a landscape and
// streets.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <string>

#include "tests/e2e/process.h"
#include "tests/folder_test.h"

namespace parallax::e2e {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using Json = nlohmann::json;

constexpr char kStudy[] =
    "study: deep\n"
    "base: indoor\n"
    "seed: 3\n"
    "pairs: 2\n"
    "rigs_per_scene: 2\n"
    "variants:\n"
    "  - name: hall\n"
    "    set:\n"
    "      room: {hall_p: 1, rooms: 3, open_plan_p: 1, open_door_p: 1}\n"
    "      solver: {steps: 20}\n"
    "      rigs: {count: 2, width_px: 160, height_px: 90}\n"
    "      render: {profile: preview, samples_per_pixel: 1}\n"
    "  - name: landscape\n"
    "    set:\n"
    "      room: {landscape_p: 1, windows: 3}\n"
    "      solver: {steps: 20}\n"
    "      rigs: {count: 2, width_px: 160, height_px: 90}\n"
    "      render: {profile: preview, samples_per_pixel: 1}\n"
    "  - name: street\n"
    "    base: street\n"
    "    set:\n"
    "      floating: {count: 40}\n"
    "      rigs: {count: 2, width_px: 160, height_px: 90}\n"
    "      render: {profile: preview, samples_per_pixel: 1}\n";

class DepthRun : public FolderTest {
 protected:
  void SetUp() override { std::ofstream(dir_ + "/deep.yaml") << kStudy; }

  // Classes of what the variant's frames show.
  static std::set<std::string> ClassesOf(const std::string& variant_dir) {
    std::set<std::string> classes;
    for (const auto& entry : fs::recursive_directory_iterator(variant_dir + "/frames")) {
      if (entry.path().filename() != "frame.json") continue;
      const Json frame = Json::parse(ReadText(entry.path()), nullptr, false);
      for (const auto& [index, object] : frame["objects"].items()) classes.insert(object["class"]);
    }
    return classes;
  }

  static std::string Show(const std::string& recipe) {
    Process show({PARALLAX_BINARY, "scene", "show", recipe});
    EXPECT_EQ(show.Wait(), 0) << show.Err();
    return show.Out();
  }
};

TEST_F(DepthRun, MakesDatasetsThatVerifyAccepts) {
  const std::string out = dir_ + "/out";
  Process run({PARALLAX_BINARY, "run", dir_ + "/deep.yaml", "--out", out, "--json"});
  ASSERT_EQ(run.Wait(), 0) << run.Err();
  const Json report = Json::parse(run.Out(), nullptr, false);
  EXPECT_EQ(report["state"], "succeeded");
  EXPECT_EQ(report["pairs_rendered"], 6);

  EXPECT_TRUE(ClassesOf(out + "/street").contains("Street"));
  EXPECT_TRUE(ClassesOf(out + "/landscape").contains("Terrain"));

  Process verify({PARALLAX_BINARY, "verify", out});
  EXPECT_EQ(verify.Wait(), 0) << verify.Out() << verify.Err();

  EXPECT_THAT(Show(out + "/hall/scenes/000000.pb"), HasSubstr("hall"));
  EXPECT_THAT(Show(out + "/landscape/scenes/000000.pb"), HasSubstr("around it: "));
  EXPECT_THAT(Show(out + "/street/scenes/000000.pb"), HasSubstr("street "));
}

}  // namespace
}  // namespace parallax::e2e
