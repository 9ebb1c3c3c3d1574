// curate, as a user runs it: a program that stands for the trainer predicts.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <sstream>

#include "common/base/system/file.h"
#include "coordinator/client/exit_code.h"
#include "tests/coordinator/client/canned_coordinator.h"
#include "tests/worker/dataset/synthetic_archive.h"
#include "tests/worker/evaluate/test_tree.h"
#include "worker/evaluate/benchmarks/frame_truth.h"

namespace parallax::client {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
using Json = nlohmann::json;

class CurateCommandTest : public ::testing::Test {
 protected:
  CurateCommandTest() {
    dir_ = tree_.dir() + "/data";
    MakeSyntheticArchive(dir_, {.variants = {"a", "b"}, .scenes = 2, .rigs = 2});
    // Stands for `trainer predict --checkpoint C --list LIST`: predicts what the checkpoint holds.
    tree_.Text("trainer",
               "#!/bin/sh\n[ \"$1 $2 $4\" = 'predict --checkpoint --list' ] || exit 7\n"
               "echo \"$6 $7\" >> $0.calls\n"
               "while read l r o; do cp \"$3\" \"$o\"; done < \"$5\"\n");
    std::filesystem::permissions(tree_.Path("trainer"), std::filesystem::perms::owner_all);
    truth_ = ReadFrameTruth(dir_ + "/a/frames/000001/001")->disparity_px;
  }

  // A network that predicts the truth of a/000001/001 plus `error_px`.
  std::string Network(const std::string& name, float error_px) {
    ImageF predicted = truth_;
    for (float& value : predicted.values()) value += error_px;
    tree_.Pfm(name, predicted);
    return tree_.Path(name);
  }
  Outcome Curate(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), "curate");
    arguments.insert(arguments.end(), {"--trainer-program", tree_.Path("trainer")});
    return RunCommand(arguments);
  }
  Json CurateJson(std::vector<std::string> arguments) {
    arguments.push_back("--json");
    const Outcome outcome = Curate(arguments);
    EXPECT_EQ(outcome.exit_code, kExitOk) << outcome.err;
    return Json::parse(outcome.out, nullptr, false);
  }
  std::vector<Json> Index(const std::string& variant) {
    std::vector<Json> lines;
    std::istringstream in(*ReadFile(dir_ + "/" + variant + "/index.jsonl"));
    for (std::string line; std::getline(in, line);) lines.push_back(Json::parse(line));
    return lines;
  }
  int Calls() {
    const auto text = ReadFile(tree_.Path("trainer.calls"));
    return text.ok() ? static_cast<int>(std::count(text->begin(), text->end(), '\n')) : 0;
  }

  TestTree tree_;
  std::string dir_;
  ImageF truth_;
};

TEST_F(CurateCommandTest, AmbiguousPairsAreFilteredOutAndVerifyAgrees) {
  // Rig 1's prediction is perfect for rig 1; the other rig has other disparities.
  const Json json = CurateJson({dir_, "--variant", "a", "--checkpoint", Network("net.pt", 0),
                                "--max-share", "0.5", "--threads", "3"});
  EXPECT_EQ(json["variants"].size(), 1);
  EXPECT_EQ(json["variants"][0]["scored_now"], 4);
  EXPECT_EQ(json["networks"][0]["file"], tree_.Path("net.pt"));
  EXPECT_EQ(*ReadFile(tree_.Path("trainer.calls")), "--threads 3\n");
  const std::vector<Json> lines = Index("a");
  int ambiguous = 0;
  for (const Json& line : lines) {
    const double share = line["statistics"]["ambiguous_share"];
    EXPECT_EQ(line["filters"]["ambiguous"]["value"], share);
    EXPECT_EQ(line["filters"]["ambiguous"]["threshold"], 0.5);
    EXPECT_EQ(line["filters"]["ambiguous"]["passed"], share <= 0.5);
    if (line["rig"] == 1) {
      EXPECT_EQ(share, 0);
    }
    ambiguous += !line["passed"].get<bool>();
  }
  EXPECT_EQ(ambiguous, json["variants"][0]["ambiguous"]);
  EXPECT_EQ(Json::parse(*ReadFile(dir_ + "/a/dataset.json"))["filters_failed"]["ambiguous"],
            ambiguous);
  EXPECT_FALSE(Index("b")[0]["statistics"].contains("ambiguous_share"));
  EXPECT_EQ(RunCommand({"verify", dir_}).exit_code, kExitOk) << RunCommand({"verify", dir_}).out;
}

TEST_F(CurateCommandTest, OtherThresholdsJudgeWithoutPredicting) {
  const std::string network = Network("net.pt", 3);
  CurateJson({dir_ + "/a", "--checkpoint", network, "--max-share", "0.9"});
  EXPECT_EQ(Calls(), 1);
  for (const Json& line : Index("a")) {
    EXPECT_FALSE(line["passed"].get<bool>() && line["rig"] == 1) << line;
  }
  // The study's own filter takes all.
  const Outcome all = Curate({dir_ + "/a", "--checkpoint", network});
  EXPECT_THAT(all.out, HasSubstr("0 of 4 pairs ambiguous"));
  EXPECT_THAT(all.err, HasSubstr("max_ambiguous_share is 1"));
  EXPECT_EQ(Calls(), 1);
  for (const Json& line : Index("a")) {
    EXPECT_TRUE(line["passed"].get<bool>());
    EXPECT_FALSE(line["filters"].contains("ambiguous"));
    EXPECT_TRUE(line["statistics"].contains("ambiguous_share"));
  }
}

TEST_F(CurateCommandTest, TheStudysOwnNetworksAreTheDefault) {
  for (const char* at : {"training/a/builtin/seed-0/final.pt", "training/a/builtin/seed-1/final.pt",
                         "training/b/builtin/seed-0/final.pt"}) {
    Network(std::string("data/") + at, at[24] == '0' || at[9] == 'b' ? 0 : 3);
  }
  tree_.Text("data/training/a/builtin/seed-0/checkpoint-5.pt", "no network");
  const Json json = CurateJson({dir_});
  EXPECT_EQ(json["networks"].size(), 3);
  // One network misses rig 1 wholly, the other not at all.
  EXPECT_EQ(Index("a")[1]["statistics"]["ambiguous_share"], 0.5);
  EXPECT_EQ(Index("b")[1]["statistics"]["ambiguous_share"], 0);
}

TEST_F(CurateCommandTest, MistakesAreOneLine) {
  const struct {
    std::vector<std::string> arguments;
    const char* wanted;
  } cases[] = {
      {{dir_, "--checkpoint", "nothing.pt"}, "nothing.pt: no such file"},
      {{dir_, "--checkpoint", dir_}, "no such file"},
      {{dir_, "--variant", "c", "--checkpoint", Network("n.pt", 0)}, "no variant \"c\""},
      {{dir_, "--max-share", "2"}, "--max-share"},
      {{tree_.dir()}, "no dataset"},
  };
  for (const auto& c : cases) {
    const Outcome outcome = Curate(c.arguments);
    EXPECT_EQ(outcome.exit_code, kExitUsage) << outcome.out << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr(c.wanted));
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
  }
}

TEST_F(CurateCommandTest, AFailedNetworkLeavesTheDatasetAsItWas) {
  const std::string before = *ReadFile(dir_ + "/a/index.jsonl");
  tree_.Text("trainer", "#!/bin/sh\necho out of memory\nexit 9\n");
  const Outcome outcome = Curate({dir_, "--variant", "a", "--checkpoint", Network("n.pt", 0)});
  EXPECT_EQ(outcome.exit_code, kExitFailed);
  EXPECT_THAT(outcome.err, HasSubstr("exit status 9"));
  EXPECT_EQ(*ReadFile(dir_ + "/a/index.jsonl"), before);
}

TEST_F(CurateCommandTest, TheTrainedNetworkScoresWhereTheStudyHasNoneOfItsOwn) {
  setenv("PARALLAX_NETWORK", "/nowhere/network.pt", 1);
  const Outcome missing = Curate({dir_, "--variant", "a"});
  EXPECT_EQ(missing.exit_code, kExitUsage);
  EXPECT_THAT(missing.err, HasSubstr("name one with --checkpoint FILE"));
  EXPECT_THAT(missing.err, HasSubstr("$PARALLAX_NETWORK: /nowhere/network.pt"));
  const std::string network = Network("mine.pt", 0);
  setenv("PARALLAX_NETWORK", network.c_str(), 1);
  const Outcome noted = Curate({dir_, "--variant", "a"});
  EXPECT_EQ(noted.exit_code, kExitOk) << noted.err;
  EXPECT_THAT(noted.err, HasSubstr("a: " + dir_ + "/training has no network that was trained"));
  const Json named = CurateJson({dir_, "--variant", "a", "--checkpoint", "network"});
  EXPECT_EQ(named["networks"][0]["file"], network);
  EXPECT_EQ(named["variants"][0]["scored_now"], 0) << "the same network";
  unsetenv("PARALLAX_NETWORK");
}

}  // namespace
}  // namespace parallax::client
