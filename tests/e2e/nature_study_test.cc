// `parallax run` and `parallax verify` of a landscape.
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

// Two frames of a walk. A plain is the cheapest biome.
constexpr char kStudy[] =
    "study: meadow\n"
    "base: nature.yaml\n"
    "seed: 3\n"
    "pairs: 2\n"
    "rigs_per_scene: 2\n"
    "variants:\n"
    "  - name: plain\n"
    "    set:\n"
    "      nature: {biomes: {plain: 1}}\n"
    "      rigs: {count: 2, width_px: 160, height_px: 90}\n"
    "      render: {profile: preview, samples_per_pixel: 1,\n"
    "               maps: [depth, disparity, occlusion, objects, materials, normals, masks,\n"
    "                      exact_occlusion]}\n";

class NatureRun : public FolderTest {
 protected:
  void SetUp() override {
    std::ofstream(dir_ + "/nature.yaml") << ReadText(NATURE_CONFIG);
    std::ofstream(dir_ + "/meadow.yaml") << kStudy;
  }

  // The file's bytes with one of them in the middle changed.
  static void Damage(const std::string& path) {
    std::string bytes = ReadText(path);
    bytes[bytes.size() / 2] = static_cast<char>(bytes[bytes.size() / 2] ^ 0x5a);
    fs::remove(path);  // It may be a hard link into the store.
    std::ofstream(path, std::ios::binary) << bytes;
  }
};

TEST_F(NatureRun, MakesADatasetThatVerifyAccepts) {
  const std::string out = dir_ + "/out";
  Process run({PARALLAX_BINARY, "run", dir_ + "/meadow.yaml", "--out", out, "--json"});
  ASSERT_EQ(run.Wait(), 0) << run.Err();
  const Json report = Json::parse(run.Out(), nullptr, false);
  EXPECT_EQ(report["state"], "succeeded");
  EXPECT_EQ(report["pairs_rendered"], 2);

  // Frames name what they show: the ground, which the recipe lists, and what its rules grew.
  std::set<std::string> classes;
  for (const auto& entry : fs::recursive_directory_iterator(out + "/plain/frames")) {
    if (entry.path().filename() != "frame.json") continue;
    const Json frame = Json::parse(ReadText(entry.path()), nullptr, false);
    for (const auto& [index, object] : frame["objects"].items()) classes.insert(object["class"]);
  }
  EXPECT_TRUE(classes.contains("Terrain"));
  EXPECT_GE(classes.size(), 3u);

  Process verify({PARALLAX_BINARY, "verify", out});
  EXPECT_EQ(verify.Wait(), 0) << verify.Out() << verify.Err();
  Damage(out + "/plain/frames/000000/000/depth_left.exr");
  Process again({PARALLAX_BINARY, "verify", out});
  EXPECT_NE(again.Wait(), 0);
  EXPECT_THAT(again.Out() + again.Err(), HasSubstr("depth_left.exr"));
}

}  // namespace
}  // namespace parallax::e2e
