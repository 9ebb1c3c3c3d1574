// evaluate, table and predict, as a user runs them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "common/base/system/file.h"
#include "common/image/io.h"
#include "common/image/jpeg.h"
#include "coordinator/client/exit_code.h"
#include "tests/coordinator/client/canned_coordinator.h"
#include "tests/worker/dataset/synthetic_archive.h"
#include "tests/worker/evaluate/test_scores.h"
#include "tests/worker/evaluate/test_tree.h"

namespace parallax::client {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
using Json = nlohmann::json;

class EvaluateCommandTest : public ::testing::Test {
 protected:
  EvaluateCommandTest() {
    for (const char* name : {"a", "b", "c"}) {
      const std::string at = std::string("pairs/") + name + "/";
      tree_.Pictures(at + "im0.png", at + "im1.png", 40, 20);
      tree_.Pfm(at + "disp0GT.pfm", ImageF(40, 20, 10.0f));
    }
    on_ = "folder:" + tree_.dir() + "/pairs";
    scores_ = tree_.dir() + "/scores";
  }

  // A folder of predictions that are `error_px` off on the first `columns` columns.
  std::string Predictions(const std::string& name, float error_px, int columns) {
    for (const char* pair : {"a", "b", "c"}) {
      ImageF predicted(40, 20, 10.0f);
      for (int y = 0; y < 20; ++y) {
        for (int x = 0; x < columns + (pair[0] - 'a'); ++x) predicted(x, y) += error_px;
      }
      tree_.Pfm(name + "/" + pair + ".pfm", predicted);
    }
    return tree_.dir() + "/" + name;
  }
  Json RunJson(std::vector<std::string> arguments) {
    arguments.push_back("--json");
    const Outcome outcome = RunCommand(arguments);
    EXPECT_EQ(outcome.exit_code, kExitOk) << outcome.err;
    return Json::parse(outcome.out, nullptr, false);
  }

  TestTree tree_;
  std::string on_, scores_;
};

TEST_F(EvaluateCommandTest, HelpHasExamples) {
  for (const char* command : {"evaluate", "table", "predict"}) {
    const Outcome outcome = RunCommand({command, "--help"});
    EXPECT_EQ(outcome.exit_code, kExitOk);
    EXPECT_THAT(outcome.out, HasSubstr("Examples:\n  parallax " + std::string(command)));
  }
}

TEST_F(EvaluateCommandTest, ListNamesEveryBenchmarkAndItsFiles) {
  const Json listed = RunJson({"evaluate", "--list"});
  EXPECT_GE(listed["benchmarks"].size(), 14);
  const Outcome outcome = RunCommand({"evaluate", "--list"});
  for (const char* wanted :
       {"middlebury2014-F", "kitti2015", "booster-Q", "list:PATH", "disp_occ_0", "mask_cat.png"}) {
    EXPECT_THAT(outcome.out, HasSubstr(wanted));
  }
}

TEST_F(EvaluateCommandTest, AFolderOfBenchmarksThatIsNotGivenIsAskedFor) {
  unsetenv("PARALLAX_BENCHMARKS");
  const std::vector<std::string> command = {"evaluate",  "sgbm",  "--on",
                                            "kitti2015", "--out", scores_};
  EXPECT_THAT(RunCommand(command).err,
              HasSubstr("--benchmarks or $PARALLAX_BENCHMARKS (`parallax"));
  setenv("PARALLAX_BENCHMARKS", testing::TempDir().c_str(), 1);
  EXPECT_THAT(RunCommand(command).err, HasSubstr("has none of the folders"));
  unsetenv("PARALLAX_BENCHMARKS");
}

TEST_F(EvaluateCommandTest, ScoreFilesBecomeATableWithVerdicts) {
  for (const std::string seed : {"1", "2", "3"}) {
    const int s = std::stoi(seed);
    for (const auto& [variant, columns] : {std::pair("default", 4), std::pair("narrow", 20)}) {
      const Json json =
          RunJson({"evaluate", Predictions(variant + seed, 5, columns + s % 2), "--on", on_,
                   "--out", scores_, "--variant", variant, "--trainer", "mine", "--seed", seed});
      EXPECT_EQ(json["evaluations"][0]["metric"], "bad-2 all");
      EXPECT_EQ(json["evaluations"][0]["pairs"], 3);
      EXPECT_NEAR(json["evaluations"][0]["value"], 100 * (columns + s % 2 + 1) / 40.0, 1e-9);
    }
  }
  EXPECT_TRUE(std::filesystem::exists(scores_ + "/narrow.mine.seed2.pairs.jsonl"));
  EXPECT_FALSE(std::filesystem::exists(scores_ + "/narrow.mine.seed2.pairs.predictions"));
  const Json table = RunJson({"table", scores_});
  ASSERT_EQ(table["rows"].size(), 2);
  EXPECT_EQ(table["rows"][1]["variant"], "narrow");
  EXPECT_EQ(table["rows"][1]["seeds"], 3);
  EXPECT_EQ(table["comparisons"][0]["verdict"], "worse");
  const Outcome better =
      RunCommand({"table", scores_, "--baseline", "narrow", "--format", "markdown"});
  EXPECT_THAT(better.out, HasSubstr("better by"));
  const std::string file = tree_.Path("table.tex");
  EXPECT_EQ(RunCommand({"table", scores_, "--format", "latex", "--out", file}).out, file + "\n");
  EXPECT_TRUE(std::filesystem::exists(file));
}

// Three seeds of `default` (6, 5, 6 columns of 40 are bad, on average of its pairs) and of `narrow`
// with 16 columns more in each pair.
class TableCommandTest : public EvaluateCommandTest {
 protected:
  TableCommandTest() {
    for (const std::string seed : {"1", "2", "3"}) {
      for (const auto& [variant, columns] : {std::pair("default", 4), std::pair("narrow", 20)}) {
        RunJson({"evaluate", Predictions(variant + seed, 5, columns + std::stoi(seed) % 2), "--on",
                 on_, "--out", scores_ + "/scores", "--variant", variant, "--trainer", "mine",
                 "--seed", seed});
      }
    }
  }
  // The line of the output that starts with `start`.
  std::string Line(const std::string& text, const std::string& start) {
    std::istringstream in(text);
    for (std::string line; std::getline(in, line);) {
      if (line.rfind(start, 0) == 0) return line;
    }
    return "no line " + start + " in:\n" + text;
  }
};

TEST_F(TableCommandTest, EveryFormatTellsTheSame) {
  const auto table = [&](const std::string& format) {
    const Outcome outcome = RunCommand({"table", scores_, "--format", format});
    EXPECT_EQ(outcome.exit_code, kExitOk) << outcome.err;
    return outcome.out;
  };
  EXPECT_EQ(RunCommand({"table", scores_}).out, table("text"));
  EXPECT_THAT(Line(table("text"), "  narrow"), HasSubstr("worse by 40.00 [40.00, 40.00]"));
  EXPECT_THAT(Line(table("text"), "  default"), HasSubstr("mine     3      14.17 ["));
  EXPECT_THAT(Line(table("markdown"), "| narrow | mine | 3 | 54.17 ["), HasSubstr("] ✗ |"));
  EXPECT_THAT(Line(table("markdown"), "| default | mine | 3 | 14.17 ["), Not(HasSubstr("✗")));
  EXPECT_THAT(Line(table("latex"), "narrow & mine & 3 & 54.17 ["), HasSubstr("]$^{-}$ \\\\"));
  EXPECT_THAT(Line(table("latex"), "default & mine & 3 & 14.17 ["), Not(HasSubstr("$")));
  EXPECT_THAT(Line(table("csv"), "narrow,mine,3,pairs,bad-2 all,54.1667,"), HasSubstr(",3,worse"));
  EXPECT_THAT(Line(table("csv"), "default,mine,3,pairs,bad-2 all,14.1667,"), HasSubstr(",3,"));
  EXPECT_EQ(Json::parse(table("json")), RunJson({"table", scores_}));
  EXPECT_NEAR(RunJson({"table", scores_})["comparisons"][0]["difference"], 40, 1e-9);
}

TEST_F(TableCommandTest, AStudysFolderHasItsOrderAndReferenceUnlessOthersAreGiven) {
  EXPECT_EQ(RunJson({"table", scores_})["rows"][0]["variant"], "default");
  tree_.Text("scores/study.lock.yaml",
             "study: s\npairs: 2\nvariants: [{name: narrow}, {name: default}]\ntrain: {}\n");
  const Json own = RunJson({"table", scores_});
  EXPECT_EQ(own["rows"][0]["variant"], "narrow");
  EXPECT_EQ(own["comparisons"][0]["baseline"], "narrow");
  EXPECT_EQ(own["comparisons"][0]["verdict"], "better");
  const Json given =
      RunJson({"table", scores_, "--baseline", "default", "--order", "default,narrow"});
  EXPECT_EQ(given["rows"][0]["variant"], "default");
  EXPECT_EQ(given["comparisons"][0]["variant"], "narrow");
  EXPECT_EQ(given["comparisons"][0]["verdict"], "worse");
}

TEST_F(TableCommandTest, AStudysReferenceWithoutScoresIsNotComparedWith) {
  tree_.Text("scores/study.lock.yaml",
             "study: s\npairs: 2\nvariants: [{name: late}, {name: narrow}, {name: default}]\n"
             "train: {}\nevaluate: {reference: late}\n");
  const Json early = RunJson({"table", scores_});
  ASSERT_EQ(early["rows"].size(), 2);
  EXPECT_EQ(early["comparisons"].size(), 1);
  EXPECT_EQ(RunCommand({"table", scores_, "--baseline", "late"}).exit_code, kExitUsage);
}

TEST_F(EvaluateCommandTest, AStudysMeanWeighsSetsIfItSaysSo) {
  Evaluation scores = SyntheticEvaluation("real", "a", 0, {10, 10, 10, 40});
  for (Scores& one : scores.images) one.pair_group = "many";
  scores.images[3].pair_group = "one";
  tree_.Text("s/scores/a.jsonl", EncodeEvaluation(scores));
  const auto value = [&] {
    return RunJson({"table", tree_.Path("s")})["rows"][0]["benchmarks"]["real"]["value"];
  };
  const std::string study = "study: s\npairs: 2\nvariants: [{name: a}]\ntrain: {}\n";
  tree_.Text("s/study.lock.yaml", study);
  EXPECT_NEAR(value().get<double>(), 17.5, 1e-9);
  tree_.Text("s/study.lock.yaml", study + "evaluate: {weigh_groups: true}\n");
  EXPECT_NEAR(value().get<double>(), 25, 1e-9);
}

// A program stands for the trainer: it predicts what the checkpoint holds, and keeps its words.
class NetworkCommandTest : public EvaluateCommandTest {
 protected:
  NetworkCommandTest() {
    tree_.Text("trainer",
               "#!/bin/sh\necho \"$@\" >> $0.calls\nwhile read l r o; do cp \"$3\" \"$o\"; done < "
               "\"$5\"\n");
    std::filesystem::permissions(tree_.Path("trainer"), std::filesystem::perms::owner_all);
    tree_.Pfm("network.pt", ImageF(40, 20, 11.0f));
    setenv("PARALLAX_NETWORK", tree_.Path("network.pt").c_str(), 1);
  }
  ~NetworkCommandTest() override { unsetenv("PARALLAX_NETWORK"); }
  Outcome Run(std::vector<std::string> arguments) {
    arguments.insert(arguments.end(), {"--trainer-program", tree_.Path("trainer")});
    return RunCommand(arguments);
  }
  std::string Calls() const { return *ReadFile(tree_.Path("trainer.calls")); }
};

TEST_F(NetworkCommandTest, TheTrainedNetworkIsAPredictorByItsName) {
  const Outcome outcome = Run({"evaluate", "network", "--on", on_, "--out", scores_});
  ASSERT_EQ(outcome.exit_code, kExitOk) << outcome.err;
  const auto scores = ReadEvaluation(scores_ + "/network.builtin.pairs.jsonl");
  ASSERT_TRUE(scores.ok()) << scores.status();
  EXPECT_EQ(scores->run.variant, "network");
  EXPECT_FALSE(scores->run.seed.has_value()) << "there is one of it";
  EXPECT_EQ(scores->run.looks, 0);
  EXPECT_THAT(Calls(), HasSubstr("predict --checkpoint " + tree_.Path("network.pt") + " --list"));
  EXPECT_THAT(Calls(), Not(HasSubstr("--looks")));

  setenv("PARALLAX_NETWORK", "/nowhere/network.pt", 1);
  const Outcome missing = Run({"evaluate", "network", "--on", on_, "--out", scores_});
  EXPECT_NE(missing.exit_code, kExitOk);
  EXPECT_THAT(missing.err, HasSubstr("$PARALLAX_NETWORK: /nowhere/network.pt"));
}

TEST_F(NetworkCommandTest, OneLookIsToldToTheTrainerAndKeptInTheScores) {
  const Outcome outcome =
      Run({"evaluate", tree_.Path("network.pt"), "--looks", "1", "--on", on_, "--out", scores_});
  ASSERT_EQ(outcome.exit_code, kExitOk) << outcome.err;
  EXPECT_THAT(Calls(), HasSubstr("--looks 1\n"));
  EXPECT_EQ(ReadEvaluation(scores_ + "/network.builtin.seed0.pairs.jsonl")->run.looks, 1);
  const Outcome refused = Run({"evaluate", "sgbm", "--looks", "1", "--on", on_, "--out", scores_});
  EXPECT_EQ(refused.exit_code, kExitUsage);
  EXPECT_THAT(refused.err, HasSubstr("--looks has no effect on sgbm"));
}

TEST_F(NetworkCommandTest, APairAloneIsPredictedByTheTrainedNetwork) {
  const std::string left = tree_.Path("pairs/a/im0.png"), right = tree_.Path("pairs/a/im1.png");
  const std::string out = tree_.Path("disparity.pfm");
  const Outcome outcome = Run({"predict", left, right, "--out", out});
  ASSERT_EQ(outcome.exit_code, kExitOk) << outcome.err;
  EXPECT_EQ(ReadPfm(out)->values()[0], 11);
  EXPECT_EQ(Run({"predict", "network", left, right, "--out", out}).exit_code, kExitOk);
  EXPECT_EQ(Run({"predict", left, "--out", out}).exit_code, kExitUsage);
  EXPECT_EQ(Run({"predict", "sgbm", left, right, right, "--out", out}).exit_code, kExitUsage);
  EXPECT_THAT(RunCommand({"predict", "--help"}).out,
              HasSubstr("Usage: parallax predict [PREDICTOR] LEFT RIGHT --out FILE [options]"));
}

TEST_F(NetworkCommandTest, AFileOfDisparitiesHoldsThemAllAndReplacesTheOldOneWhole) {
  const std::string left = tree_.Path("pairs/a/im0.png"), right = tree_.Path("pairs/a/im1.png");
  const std::string out = tree_.Path("d.png"), kept = tree_.Path("kept.png");
  EXPECT_EQ(Run({"predict", left, right, "--out", out}).exit_code, kExitOk);
  std::filesystem::create_hard_link(out, kept);
  const std::string before = *ReadFile(kept);
  tree_.Pfm("network.pt", ImageF(40, 20, 12.0f));
  EXPECT_EQ(Run({"predict", left, right, "--out", out}).exit_code, kExitOk);
  EXPECT_EQ(*ReadFile(kept), before) << "not written in place";
  tree_.Pfm("network.pt", ImageF(40, 20, 301.0f));
  const Outcome outcome = Run({"predict", left, right, "--out", out});
  EXPECT_NE(outcome.exit_code, kExitOk);
  EXPECT_THAT(outcome.err, HasSubstr("d.png: disparities up to 301 px, a PNG x256 holds 255.99"));
  EXPECT_EQ(Run({"predict", left, right, "--out", tree_.Path("d.pfm")}).exit_code, kExitOk);
}

TEST_F(TableCommandTest, TheMeanLogErrorDecidesIfTheStudyOrTheUserSaysSo) {
  const auto decided_by = [&](std::vector<std::string> more) {
    more.insert(more.begin(), {"table", scores_});
    return RunJson(more)["comparisons"][0]["decided_by"]["metric"];
  };
  EXPECT_EQ(decided_by({}), "bad-2 all");
  EXPECT_EQ(decided_by({"--decides", "log"}), "log all");
  tree_.Text("scores/study.lock.yaml",
             "study: s\npairs: 2\nvariants: [{name: default}, {name: narrow}]\ntrain: {}\n"
             "evaluate: {decides: log}\n");
  EXPECT_EQ(decided_by({}), "log all");
  EXPECT_EQ(decided_by({"--decides", "shown"}), "bad-2 all");
}

TEST_F(EvaluateCommandTest, CommandsPredictThroughTheList) {
  const std::string truth = tree_.dir() + "/pairs/a/disp0GT.pfm";
  const Outcome outcome = RunCommand(
      {"evaluate", "--command", "while read l r o; do cp " + truth + " \"$o\"; done < {list}",
       "--on", on_, "--out", scores_, "--variant", "copied", "--keep-predictions"});
  EXPECT_EQ(outcome.exit_code, kExitOk) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("bad-2 all 0"));
  EXPECT_TRUE(std::filesystem::exists(scores_ + "/copied.command.pairs.predictions/a.pfm"));
  const Outcome failed =
      RunCommand({"evaluate", "--command", "echo out of memory; exit 9; : {list}", "--on", on_,
                  "--out", scores_});
  EXPECT_EQ(failed.exit_code, kExitFailed);
  EXPECT_THAT(failed.err, HasSubstr("exit status 9"));
  EXPECT_THAT(failed.err, HasSubstr("out of memory"));
}

TEST_F(EvaluateCommandTest, CheckpointsAreNamedByTheirPlaceAndHaveTheSeedOfTheirCard) {
  tree_.Text("trainer", "#!/bin/sh\nwhile read l r o; do cp \"$3\" \"$o\"; done < \"$5\"\n");
  std::filesystem::permissions(tree_.Path("trainer"), std::filesystem::perms::owner_all);
  tree_.Text("runs/narrow/train.json", R"({"settings": {"seed": 2}})");
  tree_.Text("out/training/wide/builtin/seed-1/training.json", R"({"set": "wide", "seed": 1})");
  const struct {
    const char *file, *variant;
    int seed;
  } cases[] = {{"runs/narrow/final.pt", "narrow", 2},
               {"runs/narrow/checkpoint-000500.pt", "narrow", 2},
               {"runs/narrow/mine.pt", "mine", 2},
               {"out/training/wide/builtin/seed-1/final.pt", "wide", 1},
               {"nothing/final.pt", "nothing", 0}};
  for (const auto& one : cases) {
    tree_.Pfm(one.file, ImageF(40, 20, 11.5f));
    const Json json = RunJson({"evaluate", tree_.Path(one.file), "--trainer-program",
                               tree_.Path("trainer"), "--on", on_, "--out", scores_});
    EXPECT_EQ(json["variant"], one.variant) << one.file;
    EXPECT_EQ(json["seed"], one.seed) << one.file;
  }
}

TEST_F(EvaluateCommandTest, CheckpointsGoThroughTheTrainerProgram) {
  // Stands for `trainer predict --checkpoint C --list LIST`: predicts what the checkpoint holds.
  tree_.Text("trainer",
             "#!/bin/sh\n[ \"$1 $2 $4\" = 'predict --checkpoint --list' ] || exit 7\n"
             "while read l r o; do cp \"$3\" \"$o\"; done < \"$5\"\n");
  std::filesystem::permissions(tree_.Path("trainer"), std::filesystem::perms::owner_all);
  tree_.Pfm("net.pt", ImageF(40, 20, 11.5f));
  const Json json = RunJson({"evaluate", tree_.Path("net.pt"), "--trainer-program",
                             tree_.Path("trainer"), "--on", on_, "--out", scores_, "--seed", "5"});
  EXPECT_EQ(json["variant"], "net");
  EXPECT_EQ(json["trainer"], "builtin");
  EXPECT_EQ(json["seed"], 5);
  EXPECT_DOUBLE_EQ(json["evaluations"][0]["figures"]["epe all"], 1.5);
  EXPECT_DOUBLE_EQ(json["evaluations"][0]["figures"]["bad-1 all"], 100);
  const std::string left = tree_.Path("pairs/a/im0.png"), right = tree_.Path("pairs/a/im1.png");
  const std::string out = tree_.Path("d.pfm");
  const Outcome predicted = RunCommand({"predict", tree_.Path("net.pt"), left, right, "--out", out,
                                        "--trainer-program", tree_.Path("trainer")});
  EXPECT_EQ(predicted.exit_code, kExitOk) << predicted.err;
  EXPECT_EQ(*ReadPfm(out), ImageF(40, 20, 11.5f));
}

TEST_F(EvaluateCommandTest, PredictWritesPngAndColours) {
  const std::string left = tree_.Path("pairs/a/im0.png"), right = tree_.Path("pairs/a/im1.png");
  const std::string png = tree_.Path("d.png"), colours = tree_.Path("colours.png");
  const Json json = RunJson({"predict", "sgbm", left, right, "--out", png, "--picture", colours});
  EXPECT_EQ(json["width_px"], 40);
  EXPECT_EQ(ReadPngU16(png)->width(), 40);
  EXPECT_EQ(ReadPngRgb8(colours)->height(), 20);
}

TEST_F(EvaluateCommandTest, ArchivesGivePicturesOfErrorsByClassAndMaterial) {
  const std::string dir = tree_.dir() + "/archive";
  MakeSyntheticArchive(dir, {.scenes = 1, .rigs = 2});
  const Json json = RunJson(
      {"evaluate", "sgbm", "--on", "heldout=archive:" + dir, "--out", scores_, "--pictures"});
  EXPECT_EQ(json["evaluations"][0]["benchmark"], "heldout");
  for (const char* name :
       {"sgbm.opencv.heldout.png", "sgbm.opencv.heldout.by_class.png",
        "sgbm.opencv.heldout.by_class.csv", "sgbm.opencv.heldout.by_material.png"}) {
    EXPECT_TRUE(std::filesystem::exists(scores_ + "/" + name)) << name;
  }
  const std::string pictures = tree_.dir() + "/errors";
  EXPECT_EQ(RunCommand({"table", scores_, "--pictures", pictures}).exit_code, kExitOk);
  EXPECT_TRUE(std::filesystem::exists(pictures + "/sgbm.opencv.by_material.csv"));
}

TEST_F(EvaluateCommandTest, MistakesAreOneLineAndExitTwo) {
  const std::string a = tree_.Path("pairs/a/im0.png");
  tree_.Picture("small.png", 8, 8);
  const struct {
    std::vector<std::string> arguments;
    const char* wanted;
  } cases[] = {
      {{"evaluate", "sgbm"}, "--out is required"},
      {{"evaluate", "--out", scores_}, "what predicts?"},
      {{"evaluate", "sgbm", "--command", "x {list}", "--out", scores_}, "exclude each other"},
      {{"evaluate", "nothing.pt", "--out", scores_}, "nothing.pt: neither"},
      {{"evaluate", "sgbm", "--out", scores_, "--on", "sintel"}, "there is no benchmark 'sintel'"},
      {{"evaluate", "sgbm", "--out", scores_, "--on", "eth3d"}, "the folder of benchmarks"},
      {{"evaluate", "sgbm", "--out", scores_, "--on", "eth3d", "--benchmarks", tree_.dir()},
       "ETH3D/two_view_training"},
      {{"evaluate", a, "--out", scores_, "--on", on_, "--trainer-program", "/none"}, "/none"},
      {{"evaluate", "sgbm", "--out", scores_, "--on", on_, "--on", "pairs=" + on_},
       "would both write sgbm.opencv.pairs.jsonl: give one another name, NAME=KIND:PATH"},
      {{"evaluate", "sgbm", "--out", scores_, "--on", "a b=" + on_, "--on", "a_b=" + on_},
       "would both write sgbm.opencv.a_b.jsonl"},
      {{"table", tree_.dir()}, "no score file"},
      {{"table", tree_.dir(), "--format", "html"}, "html"},
      {{"predict", "sgbm", a, a, "--out", "d.jpg"}, "wanted a .pfm or a .png"},
      {{"predict", "sgbm", a, tree_.Path("small.png"), "--out", tree_.Path("d.pfm")}, "8x8"},
      {{"predict", "sgbm", a}, "--out is required"},
      {{"predict", a, "--out", tree_.Path("d.pfm")}, "RIGHT"},
  };
  for (const auto& c : cases) {
    const Outcome outcome = RunCommand(c.arguments);
    EXPECT_EQ(outcome.exit_code, kExitUsage) << outcome.out << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr(c.wanted));
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
  }
}

}  // namespace
}  // namespace parallax::client
