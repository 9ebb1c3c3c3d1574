// `parallax run`, `verify` and `export` of ways through a room with things that move.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "tests/e2e/process.h"
#include "tests/folder_test.h"

namespace parallax::e2e {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

// Two left eyes with two right ones each.
constexpr char kStudy[] =
    "study: ways\n"
    "base: indoor.yaml\n"
    "seed: 5\n"
    "pairs: 4\n"
    "variants:\n"
    "  - name: a\n"
    "    set:\n"
    "      solver: {steps: 12}\n"
    "      floating: {count: 6, motion: {p: 1}}\n"
    "      rigs: {count: 2, width_px: 128, height_px: 72, path: {paths: 1, fps: 5},\n"
    "             baselines_m: [0.06, 0.2]}\n"
    "      render:\n"
    "        profile: preview\n"
    "        samples_per_pixel: 1\n"
    "        keep_hdr: true\n"
    "        maps: [depth, disparity, occlusion, objects, flow]\n"
    "      sensor: {preset: ideal, exposure_ms: 50}\n";

using SequencesRun = FolderTest;

TEST_F(SequencesRun, MakesFlowThatVerifyAcceptsAndTrainersRead) {
  std::ofstream(dir_ + "/indoor.yaml") << ReadText(INDOOR_CONFIG);
  std::ofstream(dir_ + "/ways.yaml") << kStudy;
  const std::string out = dir_ + "/out";
  Process run({PARALLAX_BINARY, "run", dir_ + "/ways.yaml", "--out", out, "--json"});
  ASSERT_EQ(run.Wait(), 0) << run.Err();
  EXPECT_EQ(Json::parse(run.Out(), nullptr, false)["pairs_rendered"], 4);

  const std::string frames = out + "/a/frames/000000/";
  EXPECT_EQ(ReadText(frames + "000/left.png"), ReadText(frames + "001/left.png"));
  EXPECT_NE(ReadText(frames + "000/right.png"), ReadText(frames + "001/right.png"));
  const Json second = Json::parse(ReadText(frames + "003/frame.json"), nullptr, false);
  EXPECT_EQ(second["left_rig"], 2);
  EXPECT_EQ(second["baseline_m"], 0.2);
  EXPECT_EQ(second["sequence"]["previous"], 1);
  EXPECT_EQ(second["sensor"]["exposure_ms"], 50.0);
  EXPECT_GE(second["moving"].size(), 1u);

  Process verify({PARALLAX_BINARY, "verify", out});
  EXPECT_EQ(verify.Wait(), 0) << verify.Out() << verify.Err();
  Process to_sintel({PARALLAX_BINARY, "export", out, "--layout", "sintel", "--unfiltered", "--out",
                     dir_ + "/sintel"});
  EXPECT_EQ(to_sintel.Wait(), 0) << to_sintel.Err();
  EXPECT_TRUE(fs::exists(dir_ + "/sintel/Sintel/training/flow/000000-p1-b0/frame_0001.flo"));
}

}  // namespace
}  // namespace parallax::e2e
