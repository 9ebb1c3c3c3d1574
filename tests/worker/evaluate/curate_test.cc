#include "worker/evaluate/curate.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "common/base/status.h"
#include "common/base/system/file.h"
#include "tests/worker/dataset/synthetic_archive.h"
#include "tests/worker/evaluate/test_tree.h"
#include "worker/evaluate/benchmarks/frame_truth.h"

namespace parallax {
namespace {

using ::testing::HasSubstr;

// Predicts the truth, but misses the first `columns` columns of scene s by 2 px + s.
class SkewedPredictor final : public Predictor {
 public:
  explicit SkewedPredictor(int columns) : columns_(columns) {}
  std::string name() const override { return "skewed"; }
  absl::Status Predict(const std::vector<PredictionTask>& tasks,
                       const PredictionContext& context) override {
    for (const PredictionTask& task : tasks) {
      if (context.cancel.cancelled()) return Cancelled("stopped");
      if (task.name == fails_at) return Internal("out of memory");
      if (task.name == leaves_out) continue;
      ImageF disparity = ReadFrameTruth(task.left.substr(0, task.left.rfind('/')))->disparity_px;
      const float error = 2 + static_cast<float>(task.name[5] - '0');
      for (int y = 0; y < disparity.height(); ++y) {
        for (int x = 0; x < columns_; ++x) disparity(x, y) += error;
      }
      RETURN_IF_ERROR(WritePfm(task.output, disparity));
      predicted.push_back(task.name);
    }
    return absl::OkStatus();
  }

  std::string fails_at, leaves_out;
  std::vector<std::string> predicted;

 private:
  const int columns_;
};

class CurateTest : public ::testing::Test {
 protected:
  CurateTest() {
    MakeSyntheticArchive(tree_.dir() + "/data", {.scenes = 2, .rigs = 1});
    Read();
  }
  void Read() { variant_ = ReadDataset(tree_.dir() + "/data")->variants[0]; }
  CurationLog Log() { return *CurationLog::Open(variant_.dir); }
  absl::StatusOr<int64_t> Score(Predictor& predictor, const std::string& id) {
    CurationLog log = Log();
    return ScoreFrames(variant_, {.id = id, .predictor = &predictor},
                       {.work_dir = tree_.dir(), .cancel = cancel_}, log);
  }
  // The share of scene 1, by hand: pixels with truth in the first columns over all with truth.
  double Expected(int columns) {
    const ImageF truth = ReadFrameTruth(variant_.frames[1].dir)->disparity_px;
    double bad = 0, all = 0;
    for (int y = 0; y < truth.height(); ++y) {
      for (int x = 0; x < truth.width(); ++x) {
        all += truth(x, y) > 0;
        bad += truth(x, y) > 0 && x < columns;
      }
    }
    return bad / all;
  }

  TestTree tree_;
  DatasetVariant variant_;
  CancelToken cancel_;
};

TEST_F(CurateTest, SharesAreMeansOverNetworksOfPixelsMissedByMoreThanTwo) {
  SkewedPredictor few(10), many(30);
  EXPECT_EQ(*Score(few, "few"), 2);
  EXPECT_EQ(*Score(many, "many"), 2);
  const auto one = AmbiguousShares(variant_, {"few"}, Log());
  // Two pixels are not more than two.
  EXPECT_EQ(one.at({0, 0}), 0);
  EXPECT_DOUBLE_EQ(one.at({1, 0}), Expected(10));
  EXPECT_GT(Expected(10), 0.05);
  const auto both = AmbiguousShares(variant_, {"few", "many"}, Log());
  EXPECT_DOUBLE_EQ(both.at({1, 0}), (Expected(10) + Expected(30)) / 2);
  EXPECT_TRUE(AmbiguousShares(variant_, {"few", "another"}, Log()).empty());
}

TEST_F(CurateTest, AnInterruptedCurationGoesOn) {
  SkewedPredictor network(10);
  EXPECT_EQ(*Score(network, "n"), 2);
  std::string text = *ReadFile(variant_.dir + "/curation.jsonl");
  // The disk kept one line and a half.
  text.resize(text.find('\n') + 20);
  ASSERT_TRUE(WriteFile(variant_.dir + "/curation.jsonl", text).ok());
  network.predicted.clear();
  EXPECT_EQ(*Score(network, "n"), 1);
  EXPECT_THAT(network.predicted, ::testing::ElementsAre("000001_000"));
  EXPECT_EQ(AmbiguousShares(variant_, {"n"}, Log()).size(), 2);
  EXPECT_EQ(*Score(network, "n"), 0);
  EXPECT_EQ(*Score(network, "other"), 2);
}

TEST_F(CurateTest, OtherFilesAndOtherVersionsAreScoredAnew) {
  SkewedPredictor network(10);
  EXPECT_EQ(*Score(network, "n"), 2);
  variant_.frames[0].files["right.png"] = std::string(64, '0');
  EXPECT_EQ(*Score(network, "n"), 1);
  std::string text = *ReadFile(variant_.dir + "/curation.jsonl");
  const size_t at = text.find("\"versions\":\"") + 12;
  text[at] = 'x';
  ASSERT_TRUE(WriteFile(variant_.dir + "/curation.jsonl", text).ok());
  Read();
  EXPECT_EQ(*Score(network, "n"), 1);
}

TEST_F(CurateTest, FailuresAreNamedAndNothingIsScored) {
  SkewedPredictor network(10);
  network.fails_at = "000001_000";
  EXPECT_EQ(Score(network, "n").status().code(), absl::StatusCode::kInternal);
  network.fails_at = "";
  network.leaves_out = "000001_000";
  const absl::Status missing = Score(network, "n").status();
  EXPECT_EQ(missing.code(), absl::StatusCode::kNotFound);
  EXPECT_THAT(std::string(missing.message()), HasSubstr("frames/000001/000"));
  EXPECT_TRUE(AmbiguousShares(variant_, {"n"}, Log()).empty());
  cancel_.Cancel();
  EXPECT_EQ(Score(network, "n").status().code(), absl::StatusCode::kCancelled);
}

}  // namespace
}  // namespace parallax
