#include "coordinator/client/runs/study_results.h"

#include <fmt/core.h>
#include <gmock/gmock.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "common/base/hash.h"
#include "common/base/system/file.h"
#include "common/config/config.h"
#include "coordinator/client/exit_code.h"
#include "coordinator/client/views/study_table.h"
#include "tests/coordinator/client/canned_coordinator.h"
#include "tests/folder_test.h"
#include "tests/worker/evaluate/test_scores.h"

namespace parallax::client {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::HasSubstr;
using Json = nlohmann::json;

TEST(ResultLabel, SaysSetSeedBenchmarkAndCheckpoint) {
  const auto training = ParseResultLabel("narrow-2, seed 1");
  ASSERT_TRUE(training.has_value());
  EXPECT_EQ(training->set, "narrow-2");
  EXPECT_EQ(training->seed, 1);
  EXPECT_EQ(training->benchmark, "");
  const auto scores = ParseResultLabel("on, seed 0 on kitti2015, checkpoint 2 of 5");
  ASSERT_TRUE(scores.has_value());
  EXPECT_EQ(scores->set, "on");
  EXPECT_EQ(scores->benchmark, "kitti2015");
  EXPECT_EQ(scores->checkpoint, 2);
  EXPECT_EQ(scores->checkpoints, 5);
  EXPECT_FALSE(ParseResultLabel("sgbm on heldout")->seed.has_value());
  for (const char* bad : {"", "a b", "../x, seed 1", "a, seed 1 on ..", "a, seed x"}) {
    EXPECT_FALSE(ParseResultLabel(bad).has_value()) << bad;
  }
}

// Two sets with equal data share a training; each has its folder and its row.
class StudyResultsTest : public FolderTest {
 protected:
  void SetUp() override {
    coordinator_.store_uri = "file://" + dir_ + "/store";
    auto study = ParseStudy(
        "study: s\npairs: 2\nvariants:\n  - name: zebra\n  - name: again\n"
        "train: {seeds: 2}\nevaluate: {checkpoints: 2}\n",
        "s.yaml");
    ASSERT_TRUE(study.ok()) << study.status();
    study_ = *study;
    v1::StudyStatus& status = coordinator_.studies.emplace_back();
    status.set_study_id(1);
    status.set_name("s");
    *status.mutable_spec() = study_;
    for (int seed = 0; seed < 2; ++seed) AddTraining(seed);
    AddScores("sgbm on toy", "sgbm", std::nullopt, "", 9);
  }

  void Add(const std::string& kind, const std::string& label, const std::string& folder,
           const std::map<std::string, std::string>& files) {
    v1::JobResult& result = coordinator_.results.emplace_back();
    result.set_kind(kind);
    result.set_label(label);
    result.set_path(folder);
    result.set_cursor(static_cast<int64_t>(coordinator_.results.size()));
    fs::create_directories(dir_ + "/store/" + folder);
    for (const auto& [name, bytes] : files) {
      ASSERT_TRUE(WriteFile(dir_ + "/store/" + folder + "/" + name, bytes).ok());
      v1::FileEntry& file = *result.add_files();
      file.set_name(name);
      file.set_size(static_cast<int64_t>(bytes.size()));
      file.set_sha256(Sha256Hex(bytes));
    }
  }
  void AddTraining(int seed) {
    const std::string s = std::to_string(seed);
    const std::string half = Sha256Hex("half" + s), whole = Sha256Hex("whole" + s);
    const Json card = {
        {"set", "zebra"},
        {"checkpoints", {{{"step", 5}, {"sha256", half}}, {{"step", 10}, {"sha256", whole}}}}};
    for (const std::string set : {"zebra", "again"}) {
      Add("train", set + ", seed " + s, "t" + s,
          {{"final.pt", "whole" + s}, {"training.json", card.dump()}});
      AddScores(set + ", seed " + s + " on toy, checkpoint 1 of 2", "zebra", seed, half, 20);
      AddScores(set + ", seed " + s + " on toy, checkpoint 2 of 2", "zebra", seed, whole, 5 + seed);
    }
  }
  void AddScores(const std::string& label, const std::string& variant, std::optional<int64_t> seed,
                 const std::string& checkpoint, double bad) {
    Evaluation scores =
        SyntheticEvaluation("toy", variant, seed, {bad, bad + 1}, seed ? "builtin" : "opencv");
    scores.run.checkpoint = checkpoint;
    Add("evaluate", label, fmt::format("e{}", coordinator_.results.size()),
        {{"scores.jsonl", EncodeEvaluation(scores)}, {"sheet.png", "pixels"}});
  }

  v1::StudySpec study_;
  FakeCoordinator coordinator_;
};

TEST_F(StudyResultsTest, HaveTheirPlacesAndTheirTable) {
  const auto connection = Connection::Open(coordinator_.address());
  ASSERT_TRUE(connection.ok());
  const std::string out = dir_ + "/out";
  std::set<std::string> score_files;
  for (int again = 0; again < 2; ++again) {
    const auto results = StudyResults::Open(out, study_);
    ASSERT_TRUE(results.ok()) << results.status();
    const absl::Status caught_up = (*results)->CatchUp(**connection, 1);
    ASSERT_TRUE(caught_up.ok()) << caught_up;
    EXPECT_EQ((*results)->trainings(), 4);
    EXPECT_EQ((*results)->evaluations(), 9);
    score_files = (*results)->score_files();
  }
  EXPECT_EQ(ReadFile(out + "/training/again/builtin/seed-1/final.pt").value_or(""), "whole1");
  const Json card =
      Json::parse(ReadFile(out + "/training/again/builtin/seed-1/training.json").value_or(""));
  EXPECT_EQ(card["set"], "again") << "not as the shared training was called first";
  EXPECT_TRUE(fs::exists(out + "/sheets/toy.zebra.builtin.seed-0.png"));
  EXPECT_TRUE(fs::exists(out + "/scores/toy.sgbm.opencv.jsonl"));
  EXPECT_TRUE(fs::exists(out + "/curves/toy.again.builtin.seed-0.1-of-2.jsonl"));

  const auto text = WriteStudyTable(out, study_, score_files);
  ASSERT_TRUE(text.ok()) << text.status();
  EXPECT_LT(text->find("\n  zebra"), text->find("\n  again ")) << "in the study's order: " << *text;
  const Json table = Json::parse(ReadFile(out + "/table.json").value_or(""));
  EXPECT_EQ(table["rows"].size(), 3u);
  for (const Json& row : table["comparisons"]) EXPECT_EQ(row["baseline"], "zebra");
  const std::string curves = ReadFile(out + "/curves/learning_curves.csv").value_or("");
  EXPECT_THAT(curves, AllOf(HasSubstr("toy,bad-2 all,again,builtin,1,5,20.5\n"),
                            HasSubstr("toy,bad-2 all,again,builtin,1,10,6.5\n")));
  EXPECT_TRUE(fs::exists(out + "/curves/toy.png"));
}

TEST_F(StudyResultsTest, TheTableLeavesOutScoresOfAnotherStudyInTheFolder) {
  const std::string out = dir_ + "/out";
  const std::vector<std::string> fetch = {
      "fetch", "s", "--out", out, "--coordinator", coordinator_.address()};
  ASSERT_EQ(RunCommand(fetch).exit_code, kExitOk);
  // Seed 1 is no longer among its results.
  const auto of_seed_1 = [](const v1::JobResult& result) {
    return result.label().find("seed 1") != std::string::npos;
  };
  coordinator_.results.erase(
      std::remove_if(coordinator_.results.begin(), coordinator_.results.end(), of_seed_1),
      coordinator_.results.end());
  ASSERT_EQ(RunCommand(fetch).exit_code, kExitOk);
  const Json table = Json::parse(ReadFile(out + "/table.json").value_or(""));
  EXPECT_EQ(table["rows"][0]["variant"], "zebra");
  EXPECT_EQ(table["rows"][0]["seeds"], 1);
  EXPECT_EQ(table["rows"][0]["benchmarks"]["toy"]["value"], 5.5);
  const std::string curves = ReadFile(out + "/curves/learning_curves.csv").value_or("");
  EXPECT_THAT(curves, HasSubstr("toy,bad-2 all,zebra,builtin,0,10,"));
  EXPECT_THAT(curves, testing::Not(HasSubstr(",builtin,1,")));
}

TEST_F(StudyResultsTest, TheTableOfAStudyComesFromItsCoordinator) {
  const Outcome outcome =
      RunCommand({"table", "s", "--json", "--coordinator", coordinator_.address()});
  ASSERT_EQ(outcome.exit_code, kExitOk) << outcome.err;
  const Json table = Json::parse(outcome.out);
  EXPECT_EQ(table["rows"][0]["variant"], "zebra");
  EXPECT_EQ(table["rows"][0]["benchmarks"]["toy"]["value"], 6);
}

TEST_F(StudyResultsTest, ATableOfACoordinatorsStudyIsAFileInAnyFormat) {
  const std::string csv = dir_ + "/table.csv";
  const std::vector<std::string> command = {
      "table", "s", "--coordinator", coordinator_.address(), "--format", "csv", "--out", csv};
  const Outcome outcome = RunCommand(command);
  ASSERT_EQ(outcome.exit_code, kExitOk) << outcome.err;
  EXPECT_EQ(outcome.out, csv + "\n");
  const std::string text = ReadFile(csv).value_or("");
  EXPECT_EQ(text.find("variant,trainer,seeds,benchmark,metric,value,low,high,pairs,verdict,"
                      "benchmark_seeds\n"),
            0u);
  EXPECT_LT(text.find("\nzebra,builtin,2,toy,bad-2 all,6,"), text.find("\nagain,builtin,2,toy,"));
  const Outcome unknown = RunCommand({"table", "nothing", "--coordinator", coordinator_.address()});
  EXPECT_NE(unknown.exit_code, kExitOk);
  EXPECT_THAT(unknown.err, HasSubstr("nothing"));
}

TEST_F(StudyResultsTest, ATableNeedsScoresAndVariantsThatHaveSome) {
  const std::vector<std::string> command = {"table", "s", "--coordinator", coordinator_.address()};
  std::vector<std::string> ordered = command;
  ordered.insert(ordered.end(), {"--order", "zebra,nope"});
  Outcome outcome = RunCommand(ordered);
  EXPECT_EQ(outcome.exit_code, kExitUsage);
  EXPECT_THAT(outcome.err, HasSubstr("--order: no variant 'nope' has scores (there are again, "));
  coordinator_.results.clear();
  outcome = RunCommand(command);
  EXPECT_EQ(outcome.exit_code, kExitUsage);
  EXPECT_EQ(outcome.err, "error: study s has no scores yet\n");
}

TEST_F(StudyResultsTest, AVariantDoesNotTakeTheirPlace) {
  study_.mutable_variants(0)->set_name("scores");
  const auto results = StudyResults::Open(dir_, study_);
  EXPECT_THAT(std::string(results.status().message()), HasSubstr("give the variant another name"));
}

}  // namespace
}  // namespace parallax::client
