#include "worker/evaluate/evaluation.h"

#include <gmock/gmock.h>

#include "tests/worker/dataset/synthetic_archive.h"
#include "tests/worker/evaluate/test_scores.h"
#include "tests/worker/evaluate/test_tree.h"
#include "worker/evaluate/disparity_files.h"
#include "worker/evaluate/group_errors.h"

namespace parallax {
namespace {

using ::testing::HasSubstr;

class EvaluateTest : public ::testing::Test {
 protected:
  EvaluateTest() {
    for (const char* name : {"a", "b", "c"}) {
      const std::string at = std::string("pairs/") + name + "/";
      tree_.Pictures(at + "im0.png", at + "im1.png", 6, 2);
      tree_.Pfm(at + "disp0GT.pfm", ImageF(6, 2, 10.0f));
      tree_.Pfm(std::string("predictions/") + name + ".pfm", ImageF(6, 2, 10.0f));
    }
    benchmark_ = *OpenBenchmark("folder:" + tree_.dir() + "/pairs", "");
  }

  absl::StatusOr<Evaluation> Run() {
    return Evaluate(*MakeFolderPredictor(tree_.dir() + "/predictions"), benchmark_, options_);
  }

  TestTree tree_;
  Benchmark benchmark_;
  EvaluateOptions options_{.work_dir = tree_.dir() + "/work"};
};

TEST_F(EvaluateTest, SaysWhatWasEvaluated) {
  options_.run = {.variant = "narrow", .trainer = "builtin", .seed = 4, .checkpoint = "c0ffee"};
  std::map<std::string, std::vector<int>, std::less<>> progress;
  options_.progress = [&](std::string_view stage, int done, int total) {
    progress[std::string(stage)].push_back(10 * done + total);
  };
  const auto evaluation = Run();
  ASSERT_TRUE(evaluation.ok()) << evaluation.status();
  EXPECT_EQ(evaluation->benchmark, "pairs");
  EXPECT_EQ(evaluation->run.variant, "narrow");
  EXPECT_EQ(evaluation->run.seed, 4);
  EXPECT_EQ(evaluation->images.size(), 3);
  EXPECT_EQ(FigureOf(evaluation->headline, *evaluation), 0);
  EXPECT_EQ(progress.size(), 3u) << "nothing is shrunk";
  EXPECT_EQ(progress["check"], (std::vector<int>{13, 23, 33})) << "pairs of a user";
  EXPECT_EQ(progress["predict"], (std::vector<int>{13, 23, 33}));
  EXPECT_EQ(progress["score"], (std::vector<int>{13, 23, 33}));
  EXPECT_FALSE(std::filesystem::exists(PredictionPath(options_.work_dir, "a")));
  options_.keep_predictions = true;
  ASSERT_TRUE(Run().ok());
  EXPECT_TRUE(std::filesystem::exists(PredictionPath(options_.work_dir, "a")));
}

TEST_F(EvaluateTest, EachStageStopsSoonAfterItIsCancelled) {
  for (BenchmarkPair& pair : benchmark_.pairs) pair.shrink = 2;
  for (const char* name : {"a", "b", "c"}) {
    const std::string at = std::string("pairs/") + name + "/";
    tree_.Pfm(at + "disp0GT.pfm", ImageF(3, 1, 10.0f));
    tree_.Pfm(std::string("predictions/") + name + ".pfm", ImageF(3, 1, 10.0f));
  }
  ASSERT_TRUE(Run().ok());
  for (const std::string stop_in : {"check", "predict", "score"}) {
    options_.cancel = CancelToken();
    std::string last;
    int told = 0;
    options_.progress = [&](std::string_view stage, int, int) {
      if (stage == stop_in) options_.cancel.Cancel();
      if (stage == stop_in) ++told;
      last = stage;
    };
    EXPECT_TRUE(absl::IsCancelled(Run().status())) << stop_in;
    EXPECT_EQ(last, stop_in);
    EXPECT_EQ(told, 1) << stop_in;
  }
}

TEST_F(EvaluateTest, MissingPredictionsAreAnErrorNotABetterScore) {
  tree_.Remove("predictions/b.pfm");
  tree_.Remove("predictions/c.pfm");
  const auto evaluation = Run();
  EXPECT_EQ(evaluation.status().code(), absl::StatusCode::kNotFound);
  EXPECT_THAT(Message(evaluation.status()), HasSubstr("/b.pfm"));
  EXPECT_THAT(Message(evaluation.status()), HasSubstr("1 more"));
}

// Writes some outputs and claims success.
class LazyPredictor : public Predictor {
 public:
  std::string name() const override { return "lazy"; }
  absl::Status Predict(const std::vector<PredictionTask>& tasks,
                       const PredictionContext&) override {
    return WritePfm(tasks[0].output, ImageF(6, 2, 10.0f));
  }
};

TEST_F(EvaluateTest, PredictorThatLeavesPairsOutIsCaughtEvenWithOldOutputsLyingAbout) {
  options_.keep_predictions = true;
  ASSERT_TRUE(Run().ok());  // Leaves predictions of all pairs.
  LazyPredictor lazy;
  const auto evaluation = Evaluate(lazy, benchmark_, options_);
  EXPECT_EQ(evaluation.status().code(), absl::StatusCode::kNotFound);
  EXPECT_THAT(Message(evaluation.status()), HasSubstr("lazy: left no prediction of pair b"));
  EXPECT_THAT(Message(evaluation.status()), HasSubstr("and 1 more"));
}

TEST_F(EvaluateTest, WrongSizesAreErrors) {
  tree_.Pfm("predictions/b.pfm", ImageF(3, 1, 5.0f));
  EXPECT_THAT(Message(Run().status()), HasSubstr("pair b: a prediction of 3x1 for truth of 6x2"));
  tree_.Text("predictions/b.pfm", "P5 broken");
  EXPECT_THAT(Message(Run().status()), HasSubstr("b.pfm"));
}

TEST_F(EvaluateTest, TruthWithoutAnyKnownPixelIsAnError) {
  tree_.Pfm("pairs/b/disp0GT.pfm", ImageF(6, 2, kInf));
  EXPECT_EQ(Run().status().code(), absl::StatusCode::kDataLoss);
  EXPECT_THAT(Message(Run().status()), HasSubstr("pair b has no pixel with truth"));
}

TEST_F(EvaluateTest, NotFinitePredictionsCountAsWrong) {
  ImageF holes(6, 2, 10.0f);
  holes(0, 0) = kNan;
  holes(1, 0) = kInf;
  holes(2, 0) = -1;
  tree_.Pfm("predictions/b.pfm", holes);
  const auto evaluation = Run();
  ASSERT_TRUE(evaluation.ok()) << evaluation.status();
  EXPECT_EQ(evaluation->images[1].regions.at("all").invalid, 3);
  EXPECT_DOUBLE_EQ(FigureOf(evaluation->headline, *evaluation), 25.0 / 3);
}

TEST_F(EvaluateTest, ThinningSpreadsOverAllPairsAndIsVisible) {
  options_.max_pairs = 2;
  const auto evaluation = Run();
  ASSERT_TRUE(evaluation.ok()) << evaluation.status();
  ASSERT_EQ(evaluation->images.size(), 2);
  EXPECT_EQ(evaluation->images[0].pair, "a");
  EXPECT_EQ(evaluation->images[1].pair, "c");
}

TEST(EvaluateArchive, PerfectPredictionsScoreZeroAndGroupsCoverAllLabelledPixels) {
  const TestTree tree;
  const std::string dir = tree.dir() + "/archive";
  MakeSyntheticArchive(dir, {.scenes = 2, .rigs = 1, .last_frame_dark = true});
  const auto benchmark = OpenBenchmark("heldout=archive:" + dir, "");
  ASSERT_TRUE(benchmark.ok()) << benchmark.status();
  EXPECT_EQ(benchmark->name, "heldout");
  ASSERT_EQ(benchmark->pairs.size(), 1) << "the dark frame fails a filter";
  const auto truth = benchmark->pairs[0].read_truth();
  ASSERT_TRUE(truth.ok()) << truth.status();
  // The disparity map itself, off by 1 px on every pixel.
  ImageF predicted = truth->disparity_px;
  for (float& value : predicted.values()) value += 1.5f;
  tree.Pfm("predictions/" + benchmark->pairs[0].name + ".pfm", predicted);
  const auto evaluation = Evaluate(*MakeFolderPredictor(tree.dir() + "/predictions"), *benchmark,
                                   {.work_dir = tree.dir() + "/work"});
  ASSERT_TRUE(evaluation.ok()) << evaluation.status();
  const Scores& scores = evaluation->images[0];
  EXPECT_EQ(FigureOf(BadAt(2), scores.regions.at("all")), 0);
  EXPECT_EQ(FigureOf(BadAt(1), scores.regions.at("all")), 100);
  EXPECT_LT(scores.regions.at("nocc").pixels, scores.regions.at("all").pixels);
  for (const char* group : {"class", "material"}) {
    int64_t pixels = 0;
    for (const auto& [name, tally] : scores.groups.at(group)) {
      pixels += tally.pixels;
      EXPECT_NEAR(FigureOf(kEpeMeasure, tally), 1.5, 1e-4) << name;
    }
    EXPECT_EQ(pixels, scores.regions.at("all").pixels) << group;
  }
}

TEST(EvaluateArchive, FramesOfOneSceneAreOneSetInAllVariants) {
  const TestTree tree;
  const std::string dir = tree.dir() + "/archive";
  MakeSyntheticArchive(dir, {.variants = {"a", "b"}, .scenes = 2, .rigs = 2});
  const auto benchmark = OpenBenchmark("archive:" + dir, "");
  ASSERT_TRUE(benchmark.ok()) << benchmark.status();
  std::vector<std::string> sets;
  for (const BenchmarkPair& pair : benchmark->pairs) sets.push_back(pair.group);
  const std::vector<std::string> of_one = {"scene_000000", "scene_000000", "scene_000001",
                                           "scene_000001"};
  std::vector<std::string> wanted = of_one;
  wanted.insert(wanted.end(), of_one.begin(), of_one.end());
  EXPECT_EQ(sets, wanted);
}

TEST(EvaluateArchive, WithoutMapsOfOcclusionAllPixelsAreTheHeadline) {
  const TestTree tree;
  const std::string dir = tree.dir() + "/archive";
  MakeSyntheticArchive(dir, {.scenes = 1, .rigs = 1});
  EXPECT_EQ((*OpenBenchmark("archive:" + dir, "")).headline.region, "nocc");
  std::filesystem::remove(dir + "/a/frames/000000/000/occlusion_left.png");
  EXPECT_EQ((*OpenBenchmark("archive:" + dir, "")).headline.region, "all");
}

TEST(EvaluateArchive, SkyAndExteriorAreLeftOut) {
  const TestTree tree;
  const std::string dir = tree.dir() + "/archive";
  MakeSyntheticArchive(dir, {.scenes = 1, .rigs = 1});
  const std::string frame = dir + "/a/frames/000000/000/";
  const auto before = (*OpenBenchmark("archive:" + dir, "")).pairs[0].read_truth();
  auto masks = ReadPngU8(frame + "masks_left.png");
  ASSERT_TRUE(masks.ok()) << masks.status();
  const auto known = [](const PairTruth& truth) {
    return std::count_if(truth.disparity_px.values().begin(), truth.disparity_px.values().end(),
                         [](float value) { return value > 0; });
  };
  // Two pixels that have truth: one outside of the room, one behind glass.
  std::vector<size_t> with_truth;
  for (size_t i = 0; i < masks->pixels(); ++i) {
    if (before->disparity_px.values()[i] > 0) with_truth.push_back(i);
  }
  masks->values()[with_truth[0]] = 2;
  masks->values()[with_truth[1]] = 4;
  std::filesystem::remove(frame + "masks_left.png");  // A link into the store.
  ASSERT_TRUE(WritePng(frame + "masks_left.png", *masks).ok());
  const auto after = (*OpenBenchmark("archive:" + dir, "")).pairs[0].read_truth();
  ASSERT_TRUE(after.ok()) << after.status();
  EXPECT_EQ(known(*after), known(*before) - 1);
  EXPECT_EQ(after->regions.at("transparent").values()[with_truth[1]], 1);
}

TEST(GroupErrors, RareEntriesAreLeftOutAndTheWorstComesFirst) {
  Evaluation evaluation;
  Scores& scores = evaluation.images.emplace_back();
  const auto tally = [](int64_t pixels, double error_px) {
    ErrorTally out{.pixels = pixels, .abs_error_px = error_px * static_cast<double>(pixels)};
    return out;
  };
  scores.regions["all"] = tally(100000, 1);
  scores.groups["material"] = {
      {"glass", tally(100, 9)}, {"eyeball", tally(99, 50)}, {"wood", tally(50000, 0.5)}};
  const auto errors = GroupErrors({evaluation}, "material");
  ASSERT_TRUE(errors.ok()) << errors.status();
  ASSERT_EQ(errors->size(), 2);
  EXPECT_EQ((*errors)[0].name, "glass");
  EXPECT_DOUBLE_EQ((*errors)[0].share, 0.001);
  EXPECT_THAT(GroupErrorsCsv(*errors),
              HasSubstr("glass,100,0.001000,9.0000,0.0000,0.0000,0.0000,0.0000\nwood,50000,"));
  EXPECT_FALSE(GroupErrors({evaluation}, "class").ok());
}

}  // namespace
}  // namespace parallax
