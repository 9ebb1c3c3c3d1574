#include "coordinator/search/samplers.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "common/base/system/file.h"
#include "coordinator/search/rung_study.h"
#include "coordinator/search/sampler_talk.h"
#include "tests/coordinator/search/search_study.h"
#include "tests/folder_test.h"

namespace parallax {
namespace {

using testing::HasSubstr;

class SamplersTest : public FolderTest {
 protected:
  // Puts a sampler's file into the folder and loads all of them.
  absl::StatusOr<std::map<std::string, Sampler>> Load(const std::string& name,
                                                      const std::string& text) {
    EXPECT_TRUE(WriteFile(dir_ + "/" + name + ".yaml", text).ok());
    return LoadSamplers(dir_);
  }
  Sampler ShellSampler(const std::string& script) {
    return {.name = "sh",
            .command = {"sh", "-c", script, "sh", "{ask}", "{answer}"},
            .directory = dir_,
            .timeout_s = 20};
  }
  absl::StatusOr<std::string> AnswerOf(const Sampler& sampler, const std::string& ask = "{}") {
    auto run = SamplerRun::Start(sampler, ask, clock_);
    if (!run.ok()) return run.status();
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(30);
    while (std::chrono::steady_clock::now() < deadline) {
      if (auto answer = (*run)->Poll()) return *answer;
      std::this_thread::yield();
    }
    return Internal("no end");
  }

  FakeClock clock_;
};

TEST_F(SamplersTest, AreFilesOfTheOperators) {
  EXPECT_TRUE(LoadSamplers("")->empty());
  const auto loaded = Load("tpe", "sampler: tpe\ncommand: [run, '{ask}', '--out={answer}']\n");
  ASSERT_TRUE(loaded.ok()) << loaded.status();
  EXPECT_EQ(loaded->at("tpe").directory, dir_);
  EXPECT_EQ(loaded->at("tpe").timeout_s, 60);
  const struct {
    const char *name, *text, *says;
  } bad[] = {
      {"a", "sampler: b\ncommand: ['{ask}', '{answer}']\n",
       "a.yaml:1: sampler: \"b\", expected the"},
      {"a", "sampler: a\ncommand: [run, '{ask}']\n", "a.yaml:2: command: has no {answer}"},
      {"a", "sampler: a\ncommand: ['{ask}', '{answer}']\nshell: yes\n",
       "a.yaml:3: shell: no such field"},
      {"a", "sampler: a\n", "a.yaml:1: command: is missing, expected a list"},
      {"a", "sampler: [\n", "a.yaml:2: not YAML"},
      {"a", "", "a.yaml: nothing, allowed is a map of fields"},
      {"a", "- sampler: a\n", "a.yaml:1: a list, allowed is a map of fields"},
      {"a", "sampler: a\nsampler: a\n", "a.yaml:2: sampler: given twice, allowed once"},
      {"a", "sampler: a\ncommand: run\n", "a.yaml:2: command: run, expected a list of words"},
      {"a", "sampler: a\ncommand: ['', '{ask}', '{answer}']\n", "a.yaml:2: command[0]: \"\", exp"},
      {"b c", "sampler: b c\n", "b c.yaml:1: sampler: \"b c\" is not a name, allowed are letters"},
      {"a", "timeout_s: soon\n",
       "a.yaml:1: timeout_s: soon is not a number, allowed 0.1 to 3600 s"},
      {"a", "sampler: a\ncommand: ['{ask}', '{answer}']\ntimeout_s: 0\n", "allowed 0.1 to 3600 s"},
      {"sobol", "sampler: sobol\ncommand: ['{ask}', '{answer}']\n", "\"sobol\" is built in"},
  };
  for (const auto& row : bad) {
    const absl::Status refused = Load(row.name, row.text).status();
    EXPECT_TRUE(absl::IsInvalidArgument(refused)) << refused;
    EXPECT_THAT(std::string(refused.message()), HasSubstr(row.says));
    std::filesystem::remove(dir_ + "/" + row.name + ".yaml");
  }
  EXPECT_FALSE(LoadSamplers(dir_ + "/none").ok());
}

TEST_F(SamplersTest, TheOneThatComesWithParallaxIsRead) {
  const auto loaded = LoadSamplers(PARALLAX_SAMPLERS);
  ASSERT_TRUE(loaded.ok()) << loaded.status();
  EXPECT_EQ(loaded->count("optuna"), 1u);
}

TEST_F(SamplersTest, GiveTheirAnswersToWhatTheyAreAsked) {
  EXPECT_EQ(*AnswerOf(ShellSampler("tr a-z A-Z < $1 > $2"), "question"), "QUESTION");
}

TEST_F(SamplersTest, ThatFailSayWhy) {
  const struct {
    const char *script, *says;
  } cases[] = {
      {"echo first; echo no module named optuna >&2; exit 3",
       "sampler sh: exit status 3: no module named optuna"},
      {"kill -9 $$", "sampler sh: killed by signal 9"},
      {"true", "sampler sh: ended without an answer"},
      {"head -c 2000000 /dev/zero > $2", "an answer of 2000000 bytes, allowed are 1048576"},
      {"exec /no/such/program", "sampler sh: exit status 127"},
  };
  for (const auto& row : cases) {
    const absl::Status status = AnswerOf(ShellSampler(row.script)).status();
    EXPECT_THAT(std::string(status.message()), HasSubstr(row.says));
  }
}

TEST_F(SamplersTest, ThatHangAreEnded) {
  auto run = SamplerRun::Start(ShellSampler("echo $$ > pid; sleep 1000"), "", clock_);
  ASSERT_TRUE(run.ok());
  std::string pid;
  while (pid.empty()) pid = ReadFile(dir_ + "/pid").value_or("");
  clock_.Advance(19);
  EXPECT_FALSE((*run)->Poll().has_value());
  clock_.Advance(2);
  const auto answer = (*run)->Poll();
  ASSERT_TRUE(answer.has_value());
  EXPECT_EQ(std::string(answer->status().message()), "sampler sh: no answer within 20 s");
  // It is gone, or nobody has asked yet how it ended.
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  const auto runs = [&] {
    const auto stat = ReadFile("/proc/" + std::to_string(std::stoi(pid)) + "/stat");
    return stat.ok() && stat->find(") Z ") == std::string::npos;
  };
  while (runs() && std::chrono::steady_clock::now() < deadline) std::this_thread::yield();
  EXPECT_FALSE(runs());
}

v1::SearchRecord RecordWithTrials() {
  v1::SearchRecord record;
  *record.mutable_study() = SmallSearch();
  const auto trials = ProposeTrials(record.study(), 3);
  EXPECT_TRUE(trials.ok());
  record.mutable_trials()->Assign(trials->begin(), trials->end());
  return record;
}

TEST(SamplerTalk, AsksWithSpaceAndHistory) {
  const v1::SearchRecord record = RecordWithTrials();
  TrialScore score{.variant = "trial-001"};
  score.objective.set_value(12.5);
  const auto ask = nlohmann::json::parse(AskText(record, {score}, {{"trial-002", "no scene"}}, 4));
  EXPECT_EQ(ask["count"], 4);
  ASSERT_EQ(ask["space"].size(), 3u);
  EXPECT_EQ(ask["space"][0]["path"], "floating.count");
  EXPECT_EQ(ask["space"][0]["integer"], true);
  EXPECT_EQ(ask["space"][2]["choices"][1], "all");
  ASSERT_EQ(ask["history"].size(), 3u);
  EXPECT_EQ(ask["history"][0]["objective"], 12.5);
  EXPECT_TRUE(ask["history"][0]["values"]["floating.count"].is_number());
  EXPECT_EQ(ask["history"][1]["failed"], "no scene");
  EXPECT_FALSE(ask["history"][2].contains("objective"));
}

TEST(SamplerTalk, AsksWithTheSmallestNumbersAndAnyBytes) {
  v1::SearchRecord record = RecordWithTrials();
  record.mutable_trials(1)->mutable_values(0)->set_yaml("4e-320");
  const std::string ask = AskText(record, {}, {{"trial-001", "no scene: \xff"}}, 4);
  EXPECT_GT(nlohmann::json::parse(ask)["history"][0]["values"]["floating.count"], 0);
}

TEST(SamplerTalk, TakesNewTrialsOfTheSpaceAndNothingElse) {
  const v1::SearchRecord record = RecordWithTrials();
  const auto answer = [](const std::string& trials) { return "{\"trials\": [" + trials + "]}"; };
  const std::string one =
      R"({"floating.count": 7, "rigs.baseline_m": 0.25, "materials.mode": "all"})";
  const std::string two =
      R"({"materials.mode": "none", "floating.count": 8.0, "rigs.baseline_m": 0.5})";
  const auto taken = AnsweredTrials(record, answer(one + "," + one + "," + two), 4);
  ASSERT_TRUE(taken.ok()) << taken.status();
  ASSERT_EQ(taken->size(), 2u);  // The repeated one is left out.
  EXPECT_EQ((*taken)[0].number(), 4);
  EXPECT_EQ((*taken)[1].number(), 5);
  EXPECT_EQ(*ValueOf((*taken)[1].values(), "floating.count"), "8");
  EXPECT_EQ((*taken)[1].values(0).path(), "floating.count");  // In the order of the space.
  EXPECT_EQ(AnsweredTrials(record, answer(one + "," + two), 1)->size(), 1u);
  EXPECT_TRUE(AnsweredTrials(record, answer(""), 4)->empty());

  const auto with = [&](const std::string& count, const std::string& baseline,
                        const std::string& mode, const std::string& more = "") {
    return answer("{\"floating.count\": " + count + ", \"rigs.baseline_m\": " + baseline +
                  ", \"materials.mode\": " + mode + more + "}");
  };
  const struct {
    std::string answer, says;
  } bad[] = {
      {"nonsense", "the answer is not {\"trials\": [...]}"},
      {"{\"trials\": 5}", "the answer is not"},
      {answer(std::string(400'000, '[') + std::string(400'000, ']')), "more than 8 levels deep"},
      {answer("5"), "trial 1 of the answer: is 5, wanted {PATH: VALUE}"},
      {answer(one + ", {}"), "trial 2 of the answer: floating.count is missing"},
      {with("41", "0.1", "\"all\""), "floating.count is 41, allowed is a whole number in [0, 40]"},
      {with("1.5", "0.1", "\"all\""), "floating.count is 1.5, allowed is a whole number"},
      {with("1", "\"x\"", "\"all\""),
       "rigs.baseline_m is \"x\", allowed is a number in [0.05, 0.5]"},
      {with("1", "null", "\"all\""), "rigs.baseline_m is null"},
      {with("1", "0.1", "\"wood\""), "materials.mode is \"wood\", allowed are: none, all"},
      {with("1", "0.1", "\"all\"", ", \"solver.steps\": 3"),
       "\"solver.steps\" is no field of the space"},
  };
  for (const auto& row : bad) {
    const absl::Status refused = AnsweredTrials(record, row.answer, 4).status();
    EXPECT_TRUE(absl::IsInvalidArgument(refused)) << row.answer;
    EXPECT_THAT(std::string(refused.message()), HasSubstr(row.says));
  }
}

}  // namespace
}  // namespace parallax
