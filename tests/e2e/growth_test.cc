// `parallax run` of a study that grows or changes: what is there already is not made again.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/e2e/run_fixture.h"

namespace parallax::e2e {
namespace {

using ::testing::HasSubstr;
using GrowthTest = RunTest;

TEST_F(GrowthTest, AnotherStudyDoesNotMoveIntoADataset) {
  const std::string out = dir_ + "/out";
  Run(out);
  const auto other = Start(out, {"--seed", "6"});
  EXPECT_EQ(other->Wait(), 2);
  EXPECT_THAT(other->Err(), HasSubstr("seed"));
  ExpectComplete(out, 2);
}

TEST_F(GrowthTest, AStudyThatGrowsOrChangesRendersOnlyWhatIsNew) {
  const std::string out = dir_ + "/out";
  EXPECT_EQ(Run(out)["pairs_rendered"], 4);
  const std::string third =
      "  - name: third\n"
      "    set:\n"
      "      floating: {count: 1}\n"
      "      rigs: {count: 4, width_px: 64, height_px: 48}\n"
      "      render: {profile: preview, samples_per_pixel: 2}\n";
  std::ofstream(study_) << kStudy << third;
  Json report = Run(out);
  EXPECT_EQ(report["pairs_rendered"], 2) << "the third variant's";
  EXPECT_EQ(report["set_aside"], Json::array());
  EXPECT_EQ(Index(out, "third").size(), 2u);
  ExpectComplete(out, 2);

  // Other settings of one variant: its old pairs stay, elsewhere.
  std::string changed = third;
  changed.replace(changed.find("samples_per_pixel: 2"), 20, "samples_per_pixel: 3");
  std::ofstream(study_) << kStudy << changed;
  report = Run(out);
  EXPECT_EQ(report["pairs_rendered"], 2);
  ASSERT_EQ(report["set_aside"].size(), 1u) << report;
  EXPECT_THAT(report["set_aside"][0].get<std::string>(),
              HasSubstr("variant third: other settings"));
  const std::string aside = out + "/.parallax/aside/001";
  EXPECT_EQ(Index(aside, "third").size(), 2u);
  EXPECT_TRUE(fs::exists(aside + "/third/frames/000000/000/left.png"));
  EXPECT_EQ(Index(out, "third").size(), 2u);
  ExpectComplete(out, 2);

  // Back to the first form: all of it is known.
  std::ofstream(study_) << kStudy;
  report = Run(out);
  EXPECT_EQ(report["pairs_rendered"], 0);
  EXPECT_FALSE(fs::exists(out + "/third"));
  ExpectComplete(out, 2);
  Process verify({PARALLAX_BINARY, "verify", out});
  EXPECT_EQ(verify.Wait(), 0) << verify.Out() << verify.Err();
}

TEST_F(GrowthTest, DatasetsThatShareAStoreUseEachOthersPairs) {
  const std::string store = dir_ + "/shared";
  EXPECT_EQ(Run(dir_ + "/one", {"--store", store})["pairs_rendered"], 4);
  EXPECT_FALSE(fs::exists(dir_ + "/one/.parallax/store"));
  const Json report = Run(dir_ + "/two", {"--store", store, "--pairs", "3"});
  EXPECT_EQ(report["pairs_rendered"], 2) << "one pair more of each variant";
  EXPECT_EQ(report["frames_in_dataset"], 6);
  // The folder knows its store.
  EXPECT_EQ(Run(dir_ + "/one")["pairs_rendered"], 0);
  EXPECT_FALSE(fs::exists(dir_ + "/one/.parallax/queue.db"));
  // A dataset stays whole without its store.
  fs::remove_all(store);
  Process verify({PARALLAX_BINARY, "verify", dir_ + "/two"});
  EXPECT_EQ(verify.Wait(), 0) << verify.Out() << verify.Err();
}

TEST_F(GrowthTest, OwnPairsAreABenchmarkOfAStudy) {
  fs::create_directories(dir_ + "/pairs");
  ASSERT_EQ(Run(dir_ + "/out")["pairs_rendered"], 4);
  const std::string frame = dir_ + "/out/narrow/frames/000000/000/";
  fs::copy_file(frame + "left.png", dir_ + "/pairs/l.png");
  fs::copy_file(frame + "right.png", dir_ + "/pairs/r.png");
  fs::copy_file(frame + "disparity_left.exr", dir_ + "/pairs/d.exr");
  std::ofstream(dir_ + "/pairs/list.txt") << "l.png r.png d.exr\n";
  std::ofstream(study_) << kStudy
                        << "evaluate:\n  benchmarks: [{name: mine, list: pairs/list.txt}]\n";
  const Json report = Run(dir_ + "/out");
  EXPECT_EQ(report["pairs_rendered"], 0);
  EXPECT_EQ(report["evaluations"], 1);
  const std::string scores = dir_ + "/out/scores/mine.sgbm.opencv.jsonl";
  EXPECT_TRUE(fs::exists(scores));
  // Other content is another benchmark: scored anew, the old scores are kept.
  fs::copy_file(frame + "left.png", dir_ + "/pairs/r.png", fs::copy_options::overwrite_existing);
  const Json again = Run(dir_ + "/out");
  EXPECT_EQ(again["set_aside"].size(), 1u) << again;
  EXPECT_NE(ReadText(scores),
            ReadText(dir_ + "/out/.parallax/aside/001/scores/mine.sgbm.opencv.jsonl"));
}

TEST_F(GrowthTest, OtherFiltersRenderNothingAndRewriteTheVerdicts) {
  const std::string out = dir_ + "/out";
  EXPECT_EQ(Run(out)["pairs_rendered"], 4);
  const auto before = Content(out);
  for (const Json& line : Index(out, "narrow")) EXPECT_EQ(line["filters"]["near"]["passed"], true);

  // No surface of a room is 50 m away.
  std::string strict = kStudy;
  const std::string render = "      render: {profile: preview, samples_per_pixel: 1}\n";
  const size_t narrow = strict.find(render);
  strict.insert(narrow, "      filters: {min_depth_m: 50, min_distance_m: 60}\n");
  std::ofstream(study_) << strict;
  const Json report = Run(out);
  EXPECT_EQ(report["state"], "succeeded");
  EXPECT_EQ(report["pairs_rendered"], 0);
  EXPECT_LT(report["elapsed_s"].get<double>(), 30);
  EXPECT_EQ(Content(out), before);
  ExpectComplete(out, 2);
  for (const Json& line : Index(out, "narrow")) {
    EXPECT_EQ(line["passed"], false);
    EXPECT_EQ(line["filters"]["near"]["passed"], false);
    EXPECT_EQ(line["filters"]["near"]["threshold"], 50);
    EXPECT_EQ(line["filters"]["close"]["threshold"], 60);
  }
  for (const Json& line : Index(out, "wide")) {
    EXPECT_EQ(line["passed"], true);
    EXPECT_EQ(line["filters"].count("close"), 0u);
  }
  const Json card = Json::parse(ReadText(out + "/narrow/dataset.json"));
  EXPECT_EQ(card["pairs_passing_filters"], 0);
  EXPECT_EQ(card["filters_failed"]["close"], 2);
  EXPECT_THAT(ReadText(out + "/narrow/README.md"), HasSubstr("| passing all | 0 |"));
  EXPECT_EQ(ReadText(out + "/study.yaml"), strict);
  // Exports follow the verdicts.
  Process exported({PARALLAX_BINARY, "export", out + "/narrow", "--layout", "middlebury", "--out",
                    dir_ + "/exported"});
  EXPECT_NE(exported.Wait(), 0);
  EXPECT_THAT(exported.Err(), HasSubstr("no pair is left (2 fail a filter"));
}

TEST_F(GrowthTest, AnotherSensorRendersNothingAndMakesOtherPictures) {
  const std::string out = dir_ + "/out";
  const auto with_sensor = [&](const std::string& preset) {
    std::string text = kStudy;
    const std::string render = "render: {profile: preview, samples_per_pixel: 1}";
    for (size_t at = text.find(render); at != std::string::npos; at = text.find(render, at + 1)) {
      text.replace(at, render.size(),
                   "sensor: {preset: " + preset + "}\n" +
                       "      render: {profile: preview, samples_per_pixel: 1, keep_hdr: true}");
    }
    std::ofstream(study_) << text;
  };
  const auto picture = [&] { return ReadText(out + "/narrow/frames/000000/000/left.png"); };
  with_sensor("'off'");
  EXPECT_EQ(Run(out)["pairs_rendered"], 4);
  const auto truth = Content(out);
  const std::string rendered = picture();
  with_sensor("webcam");
  Json report = Run(out);
  EXPECT_EQ(report["state"], "succeeded");
  EXPECT_EQ(report["pairs_rendered"], 0);
  EXPECT_EQ(Content(out), truth);
  const std::string webcam = picture();
  EXPECT_NE(webcam, rendered);
  Process verified({PARALLAX_BINARY, "verify", out});
  EXPECT_EQ(verified.Wait(), 0) << verified.Out() << verified.Err();
  // A new folder has no earlier results, and still gets the same pictures.
  const std::string fresh = dir_ + "/fresh";
  EXPECT_EQ(Run(fresh)["pairs_rendered"], 4);
  EXPECT_EQ(ReadText(fresh + "/narrow/frames/000000/000/left.png"), webcam);
  with_sensor("'off'");
  EXPECT_EQ(Run(out)["pairs_rendered"], 0);
  EXPECT_EQ(picture(), rendered);
}

}  // namespace
}  // namespace parallax::e2e
