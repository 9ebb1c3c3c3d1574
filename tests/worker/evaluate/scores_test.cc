#include "worker/evaluate/scores.h"

#include <gmock/gmock.h>

#include "tests/worker/evaluate/test_scores.h"
#include "tests/worker/evaluate/test_tree.h"

namespace parallax {
namespace {

using ::testing::HasSubstr;

std::string ErrorOf(const std::string& text) {
  const auto read = DecodeEvaluation(text);
  EXPECT_FALSE(read.ok());
  return std::string(ToStd(read.status().message()));
}

TEST(Scores, ReadBackAsWritten) {
  Evaluation evaluation = SyntheticEvaluation("eth3d", "default", 7, {5, 10});
  evaluation.images[0].groups["class"]["Chair"] = evaluation.images[0].regions["all"];
  const std::string text = EncodeEvaluation(evaluation);
  const auto read = DecodeEvaluation(text);
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_EQ(EncodeEvaluation(*read), text);
  EXPECT_EQ(read->run.seed, 7);
  EXPECT_EQ(read->images[0].groups.at("class").at("Chair").pixels,
            evaluation.images[0].regions["all"].pixels);
  EXPECT_THAT(text, testing::Not(HasSubstr("looks"))) << "as older versions wrote it";
  evaluation.run.looks = 1;
  EXPECT_EQ(DecodeEvaluation(EncodeEvaluation(evaluation))->run.looks, 1);
  evaluation.run.seed.reset();
  EXPECT_EQ(DecodeEvaluation(EncodeEvaluation(evaluation))->run.seed, std::nullopt);
}

TEST(Scores, FileThatEndsEarlyOrIsNotOneIsRefused) {
  const std::string text = EncodeEvaluation(SyntheticEvaluation("eth3d", "a", 1, {5, 10}));
  EXPECT_THAT(ErrorOf(text.substr(0, text.find('\n') + 1)), HasSubstr("after 0 of 2 pairs"));
  const size_t second = text.find('\n', text.find('\n') + 1);
  EXPECT_THAT(ErrorOf(text.substr(0, second + 1)), HasSubstr("after 1 of 2 pairs"));
  EXPECT_THAT(ErrorOf(text.substr(0, text.size() - 20)), HasSubstr("line 3"));
  EXPECT_THAT(ErrorOf("{}\n"), HasSubstr("parallax-scores-1"));
  EXPECT_THAT(ErrorOf(""), HasSubstr("parallax-scores-1"));
}

TEST(Scores, MeanOverImagesAndPoolDiffer) {
  // 100 px: one image of 1 % wrong; a second one ten times as large with 10 %.
  Evaluation evaluation = SyntheticEvaluation("eth3d", "a", 1, {1, 10});
  ErrorTally& large = evaluation.images[1].regions["all"];
  large.pixels *= 10;
  for (int64_t& bad : large.bad) bad *= 10;
  EXPECT_DOUBLE_EQ(FigureOf({.measure = BadAt(2)}, evaluation), 5.5);
  EXPECT_DOUBLE_EQ(FigureOf({.measure = BadAt(2), .pooled = true}, evaluation), 101.0 / 11);
  EXPECT_TRUE(std::isnan(FigureOf({.measure = BadAt(2), .region = "nocc"}, evaluation)));
}

TEST(Scores, FolderIsReadWholeAndConflictsAreRefused) {
  const TestTree tree;
  ASSERT_FALSE(ReadEvaluations(tree.dir()).ok());
  ASSERT_TRUE(
      WriteEvaluation(tree.Path("x/one.jsonl"), SyntheticEvaluation("eth3d", "a", 1, {5})).ok());
  ASSERT_TRUE(
      WriteEvaluation(tree.Path("two.jsonl"), SyntheticEvaluation("eth3d", "a", 2, {6})).ok());
  tree.Text("index.jsonl", "{\"scene\": 1}\n");  // A dataset's: not ours to judge.
  EXPECT_EQ(ReadEvaluations(tree.dir())->size(), 2);
  // The same scores again are the same run; others are a conflict.
  std::filesystem::copy(tree.Path("two.jsonl"), tree.Path("copy.jsonl"));
  EXPECT_EQ(ReadEvaluations(tree.dir())->size(), 2);
  ASSERT_TRUE(
      WriteEvaluation(tree.Path("copy.jsonl"), SyntheticEvaluation("eth3d", "a", 2, {7})).ok());
  const auto conflict = ReadEvaluations(tree.dir());
  EXPECT_EQ(conflict.status().code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(std::string(ToStd(conflict.status().message())),
              HasSubstr("variant a, trainer builtin, seed 2 on eth3d"));
}

TEST(Scores, FilesAreReplacedWholeAndCutOnesAreNotOverlooked) {
  const TestTree tree;
  const std::string path = tree.Path("one.jsonl"), kept = tree.Path("kept");
  ASSERT_TRUE(WriteEvaluation(path, SyntheticEvaluation("eth3d", "a", 1, {5})).ok());
  std::filesystem::create_hard_link(path, kept);
  ASSERT_TRUE(WriteEvaluation(path, SyntheticEvaluation("eth3d", "b", 1, {5})).ok());
  EXPECT_EQ(ReadEvaluation(kept)->run.variant, "a") << "not written in place";
  tree.Text("cut.jsonl", EncodeEvaluation(SyntheticEvaluation("eth3d", "c", 1, {5})).substr(0, 60));
  const auto cut = ReadEvaluations(tree.dir());
  EXPECT_EQ(cut.status().code(), absl::StatusCode::kDataLoss);
  EXPECT_THAT(std::string(ToStd(cut.status().message())), HasSubstr("cut.jsonl: line 1: "));
}

}  // namespace
}  // namespace parallax
