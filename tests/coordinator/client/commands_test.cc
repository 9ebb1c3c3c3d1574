#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <sstream>

#include "common/base/system/cores.h"
#include "common/config/config.h"
#include "common/image/io.h"
#include "tests/coordinator/client/command_test.h"
#include "worker/assets/asset.h"
#include "worker/materials/kernel/material.h"

namespace parallax::client {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;
using Json = nlohmann::json;

// ---- Catalogue

TEST_F(CommandTest, CatalogueListsEveryClassAndMaterialWithWhatTheyCost) {
  const Outcome outcome = RunCommand({"catalogue", "--json", "--seeds", "1"});
  ASSERT_EQ(outcome.exit_code, kExitOk) << outcome.err;
  const Json listed = Json::parse(outcome.out);
  EXPECT_EQ(listed["classes"].size(), AssetCatalogue().size());
  EXPECT_EQ(listed["materials"].size(), MaterialCatalogue().size());
  for (const Json& c : listed["classes"]) {
    EXPECT_NE(FindAssetClass(c["name"].get<std::string>()), nullptr);
    EXPECT_GT(c["triangles"], 0) << c;
    EXPECT_GT(c["ms"], 0) << c;
    for (int axis = 0; axis < 3; ++axis) EXPECT_GT(c["size_max_m"][axis], c["size_min_m"][axis]);
  }
  const Outcome one = RunCommand({"catalogue", "Chair", "--seeds", "1"});
  EXPECT_THAT(one.out, HasSubstr("Chair"));
  EXPECT_THAT(one.out, Not(HasSubstr("Sofa")));
  const Outcome unknown = RunCommand({"catalogue", "Unicorn"});
  EXPECT_NE(unknown.exit_code, kExitOk);
  EXPECT_THAT(unknown.err, HasSubstr("'Unicorn'"));
  // Names are those of studies, which may write them in any case.
  const Outcome any_case = RunCommand({"catalogue", "chair", "--seeds", "1"});
  EXPECT_THAT(any_case.out, HasSubstr("Chair "));
  EXPECT_THAT(any_case.out, Not(HasSubstr("Sofa")));
}

TEST_F(CommandTest, SheetsNeedAFolderBeforeAnythingIsDrawn) {
  const std::string file = WriteText("file", "x");
  const Outcome outcome = RunCommand({"catalogue", "Chair", "--sheet", file + "/sheets"});
  EXPECT_NE(outcome.exit_code, kExitOk);
  EXPECT_THAT(outcome.err, HasSubstr("can't make the folder " + file + "/sheets: "));
}

// ---- Usage

TEST_F(CommandTest, EveryCommandHasHelpWithAnExample) {
  for (const char* command :
       {"run", "submit", "status", "watch", "cancel", "pause", "resume", "retry", "forget",
        "workers", "jobs", "logs", "fetch", "view", "catalogue"}) {
    const Outcome outcome = RunCommand({command, "--help"});
    EXPECT_EQ(outcome.exit_code, kExitOk) << command;
    EXPECT_THAT(outcome.out, HasSubstr("Usage: parallax " + std::string(command)));
    EXPECT_THAT(outcome.out, HasSubstr("Example")) << command;
    EXPECT_EQ(outcome.err, "") << command;
  }
  const Outcome outcome = RunCommand({"--help"});
  EXPECT_EQ(outcome.exit_code, kExitOk);
  for (const char* wanted : {"run", "watch", "Exit codes", "130"}) {
    EXPECT_THAT(outcome.out, HasSubstr(wanted));
  }
}

TEST_F(CommandTest, UsageErrorsAreOneLineAndExitTwo) {
  const struct {
    std::vector<std::string> arguments;
    std::string wanted;
  } cases[] = {
      {{"statsu"}, "did you mean `parallax status`?"},
      {{"check"}, "did you mean `parallax config check`?"},
      {{"scene", "shwo"}, "did you mean `parallax scene show`?"},
      {{"cancel"}, "STUDY is required"},
      {{"run", "quickstart"}, "--out is required"},
      {{"submit", "quickstart", "--pears", "3"},
       "`parallax submit` has no option --pears; did you mean --pairs?"},
      {{"submit", "quickstart", "twice"}, "`parallax submit` takes no more arguments: twice"},
      {{"run", "quickstart", "--ot", "o"},
       "`parallax run` has no option --ot; did you mean --out?"},
      {{"table", "out", "--format", "markdwn"}, "; did you mean markdown?"},
      {{"config", "check", "indor"}, "indor: no such file, did you mean indoor?"},
      {{"evaluate", "sgm", "--on", "shipped", "--out", dir_ + "/o"}, "did you mean sgbm?"},
      {{"evaluate", "sgbm", "--on", "shiped", "--out", dir_ + "/o"}, "did you mean shipped?"},
      {{"export", "x", "--layout", "kiti", "--out", dir_ + "/o"}, "did you mean kitti?"},
      {{"completion", "fissh"}, "did you mean fish?"},
      {{"submit", "quikstart"}, "quikstart: no such file, did you mean quickstart?"},
      {{"catalogue", "Chiar"}, "family is called 'Chiar', did you mean Chair?"},
      {{"table", dir_ + "/none"}, "/none: no such folder"},
      {{"page", "--http", "https://127.0.0.1:7080"}, "wanted is HOST:PORT without a scheme"},
      {{"submit", "quickstart", "--width", "320"},
       "--width 320 alone makes pictures of 320 x 720 out of 1280 x 720: give --height 180"},
      {{"submit", "quickstart", "--pairs", "many"}, "many"},
      {{"submit", "quickstart", "--pairs", "0"}, "--pairs: 0 was given, at least 1 is needed"},
      {{"submit", "quickstart", "--scenes", "4611686018427387905", "--rigs", "4"},
       "--scenes: 4611686018427387905 was given, at most 100000000 is allowed"},
      {{"submit", "quickstart", "--pairs", "4", "--scenes", "1"}, "--pairs and --scenes"},
      {{"submit", "quickstart", "--profile", "ultra"}, "preview"},
      {{"submit", "quickstart", "--seed", "-1"},
       "--seed: -1, allowed is a whole number from 0 to 2^64 - 1"},
      {{"submit", "controls", "--seed", "2"},
       "--seed: 2 is the seed of variant 'drawn-anew', which draws other scenes"},
      {{"plan", "quickstart", "--seed=-1"}, "--seed: -1, allowed is a whole number"},
      {{"run", "quickstart", "--out", "o", "--seed", "18446744073709551616"}, "--seed: 18446744"},
      {{"catalogue", "--first-seed", "-1"}, "--first-seed: -1, allowed is a whole number"},
      {{"catalogue", "Vase", "nosuch", "--seeds", "1"}, "family is called 'nosuch'"},
      {{"catalogue", "--sheet", dir_, "nosuch"}, "family is called 'nosuch'"},
      {{"export", dir_, "--out", dir_ + "/o", "--flat"}, "--flat is for the layout crestereo"},
      {{"scene", "show", dir_}, dir_ + ": a folder, wanted a recipe's file or, of a dataset, "},
      {{"config", "camera", "nosuch"},
       "error: nosuch: no such file; as a preset: \"nosuch\" is not known (allowed: "
       "zed_2i"},
      {{"config", "camera", "kitti", "--width", "640"}, "--height"},
      {{"submit", "baseline", "--width", "3"},
       "error: with these options variants[0].config.rigs.width_px: 3 is out of range"},
      {{"jobs", "3", "--state", "lazy"}, "lazy"},
      {{"status", "--coordinator", "nonsense"}, "nonsense"},
      {{"logs", "last"}, "JOB"},
      {{"logs", "0"}, "JOB"},
      {{"workers", "drian"}, "did you mean `parallax workers drain`?"},
      {{"workers", "drain"}, "NAME is required"},
      {{"view", "/nowhere"}, "/nowhere: no such folder"},
      {{"scene", "show", "/nowhere.pb"}, "/nowhere.pb: no such file"},
      {{"scene", "show", "a", "b"}, "STUDY VARIANT SCENE"},
      {{"config", "check", "/nowhere.yaml"}, "/nowhere.yaml: no such file"},
  };
  for (const auto& c : cases) {
    const Outcome outcome = RunCommand(c.arguments);
    EXPECT_EQ(outcome.exit_code, kExitUsage) << c.wanted << "\n" << outcome.err;
    EXPECT_THAT(outcome.err, StartsWith("error: "));
    EXPECT_THAT(outcome.err, HasSubstr(c.wanted));
    EXPECT_EQ(Lines(outcome.err), 1) << outcome.err;
    EXPECT_EQ(outcome.out, "");
  }
}

TEST_F(CommandTest, OutputThatDoesNotArriveIsADiskError) {
  const int full = open("/dev/full", O_WRONLY);
  ASSERT_GE(full, 0);
  for (const std::vector<std::string>& arguments : std::vector<std::vector<std::string>>{
           {"config", "show", "indoor"}, {"config", "list", "--json"}, {"--help"}, {"--version"}}) {
    std::ostringstream err;
    Environment environment;
    environment.out = Terminal::OnDescriptor(full);
    environment.err.stream = &err;
    EXPECT_EQ(RunClient(arguments, environment), kExitDisk) << arguments[0];
    EXPECT_EQ(err.str(), "error: standard output: No space left on device\n") << arguments[0];
  }
  close(full);
}

TEST_F(CommandTest, AnAbsentCoordinatorIsOneLineAndExitThree) {
  for (const std::vector<std::string>& command :
       std::vector<std::vector<std::string>>{{"status"},
                                             {"watch", "3"},
                                             {"cancel", "3"},
                                             {"workers"},
                                             {"submit", "quickstart"},
                                             {"jobs", "3"},
                                             {"fetch", "3", "--out", dir_ + "/out"},
                                             {"scene", "show", "a", "b", "0"}}) {
    std::vector<std::string> arguments = command;
    // A socket that nobody listens on, and that nobody else could come to listen on.
    arguments.insert(arguments.end(), {"--coordinator", "unix:" + dir_ + "/socket"});
    const Outcome outcome = RunCommand(arguments);
    EXPECT_EQ(outcome.exit_code, kExitUnreachable) << command[0] << "\n" << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr("no coordinator at unix:" + dir_ + "/socket: "));
    EXPECT_THAT(outcome.err, HasSubstr("start one with `coordinator serve"));
    EXPECT_EQ(Lines(outcome.err), 1) << outcome.err;
  }
}

TEST_F(CommandTest, TheEnvironmentNamesTheCoordinatorAndTheOptionWins) {
  coordinator_.studies = {Baseline()};
  setenv("PARALLAX_COORDINATOR", coordinator_.address().c_str(), 1);
  EXPECT_EQ(RunCommand({"status"}).exit_code, kExitOk);
  setenv("PARALLAX_COORDINATOR", ("unix:" + dir_ + "/socket").c_str(), 1);
  EXPECT_EQ(RunCommand({"status"}).exit_code, kExitUnreachable);
  EXPECT_EQ(Run({"status"}).exit_code, kExitOk);
  unsetenv("PARALLAX_COORDINATOR");
}

// ---- plan, config

TEST_F(CommandTest, PlanTellsTheTimeOnSomeCores) {
  const auto plan = [](std::vector<std::string> more) {
    std::vector<std::string> arguments = {"plan", "quickstart", "--json"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return Json::parse(RunCommand(arguments).out);
  };
  const Json four = plan({"--cores", "4"});
  EXPECT_EQ(four["cores"], 4);
  EXPECT_NEAR(four["wall_clock_s"].get<double>(), four["core_hours"].get<double>() * 900, 1e-6);
  EXPECT_EQ(plan({})["cores"], UsableCores());
  EXPECT_THAT(RunCommand({"plan", "quickstart", "--cores", "2"}).out,
              ::testing::ContainsRegex("Time: about .+ on 2 cores\n"));
  const Outcome none = RunCommand({"plan", "quickstart", "--cores", "0"});
  EXPECT_EQ(none.exit_code, kExitUsage);
  EXPECT_THAT(none.err, HasSubstr("not in range 1 to 10000000"));
}

TEST_F(CommandTest, ConfigCheckAndShow) {
  EXPECT_THAT(RunCommand({"config", "check", "quickstart"}).out,
              HasSubstr("quickstart: ok, study quickstart: 1 variant x 8 pairs"));
  EXPECT_THAT(RunCommand({"config", "check", "indoor"}).out, HasSubstr("a scene config"));
  EXPECT_THAT(RunCommand({"config", "list"}).out, HasSubstr("baseline"));
  // `show` prints a study that resolves to the same text.
  const std::string shown = RunCommand({"config", "show", "baseline"}).out;
  const std::string file = WriteText("shown.yaml", shown);
  EXPECT_EQ(RunCommand({"config", "show", file}).out, shown);
  const std::string bad = WriteText("scene.yaml", "rigs: {count: 0}\n");
  const Outcome outcome = RunCommand({"config", "check", bad});
  EXPECT_EQ(outcome.exit_code, kExitUsage);
  EXPECT_THAT(outcome.err, HasSubstr(bad + ":1"));
}

TEST_F(CommandTest, CheckAndPlanShowTheCameraAndWhatRunWouldMiss) {
  const std::string file = WriteText("s.json",
                                     "{\"study\": \"s\", \"pairs\": 2, \"variants\": [{\"name\": "
                                     "\"a\"}], \"evaluate\": {\"benchmarks\": [\"kitti2015\"]}}");
  for (const std::vector<std::string>& command :
       std::vector<std::vector<std::string>>{{"config", "check", file}, {"plan", file}}) {
    const Outcome outcome = RunCommand(command);
    EXPECT_EQ(outcome.exit_code, kExitOk) << outcome.err;
    EXPECT_THAT(outcome.out,
                HasSubstr("Camera: 1280x720 px, K fx 698.4 to 1229 fy 698.4 to 1229 cx "
                          "640 cy 360 px, field of view 55 to 85 x "));
    EXPECT_THAT(outcome.err, HasSubstr("note: `parallax run` would refuse this here: " + file +
                                       ":1: evaluate.benchmarks: \"kitti2015\": "));
  }
  EXPECT_THAT(RunCommand({"config", "show", file}).out, HasSubstr("benchmarks: [kitti2015]"));
  EXPECT_EQ(RunCommand({"run", file, "--out", dir_ + "/out"}).exit_code, kExitUsage);
  EXPECT_FALSE(fs::exists(dir_ + "/out"));
}

TEST_F(CommandTest, AFileWithNothingInItGetsOneVerdict) {
  for (const char* text : {"", "# nothing\n\n  # yet\n"}) {
    const std::string file = WriteText("empty.yaml", text);
    for (const std::vector<std::string>& command :
         std::vector<std::vector<std::string>>{{"config", "check", file},
                                               {"config", "show", file},
                                               {"plan", file},
                                               {"run", file, "--out", dir_ + "/out"}}) {
      const Outcome outcome = RunCommand(command);
      EXPECT_EQ(outcome.exit_code, kExitUsage) << command[0];
      EXPECT_EQ(outcome.err, "error: " + file +
                                 ": nothing, allowed is a map of fields: those of a study (study, "
                                 "pairs, variants) or of a scene config\n");
    }
  }
}

// ---- run: what is refused before anything starts

TEST_F(CommandTest, RunRefusesATrainerThatItsWorkersMayNotRun) {
  const std::string study = WriteText(
      "s.yaml", "study: s\npairs: 2\nvariants: [{name: a}]\ntrain:\n  steps: 3\n  trainer: nope\n");
  const auto run = [&](std::vector<std::string> more) {
    std::vector<std::string> arguments = {"run", study, "--out", dir_ + "/out"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const Outcome outcome = RunCommand(arguments);
    EXPECT_EQ(outcome.exit_code, kExitUsage);
    EXPECT_FALSE(fs::exists(dir_ + "/out"));
    return outcome.err;
  };
  const std::string where = "error: " + study + ":6: train.trainer: \"nope\"";
  EXPECT_EQ(run({}), where + " may not run here, allowed by --allow-trainers: builtin\n");
  EXPECT_THAT(run({"--allow-trainers", "builtin,nope"}), StartsWith(where + ": name the folder"));
  EXPECT_THAT(run({"--allow-trainers", "nope", "--trainers", dir_}),
              StartsWith(where + ": no such file " + dir_ + "/nope.yaml"));
  WriteText("nope.yaml",
            "trainer: nope\nlayout: archive\ntrain: [/bin/true, '{data}', '{seed}', '{steps}']\n"
            "predict: [/bin/true, '{checkpoint}', '{list}']\nprogress: json\nsteps: 3\n"
            "leaves: {checkpoints: c-*.pt, final: final.pt}\n");
  setenv("PARALLAX_WORKER", (dir_ + "/gone").c_str(), 1);
  EXPECT_THAT(run({"--allow-trainers", "nope", "--trainers", dir_}), HasSubstr(dir_ + "/gone"))
      << "the trainer may run";
  unsetenv("PARALLAX_WORKER");
}

TEST_F(CommandTest, RunRefusesAFolderInsideOfADataset) {
  fs::create_directories(dir_ + "/tiny/.parallax");
  WriteText("tiny/study.lock.yaml", "x");
  setenv("PARALLAX_WORKER", "/bin/false", 1);
  const Outcome outcome = RunCommand({"run", "quickstart", "--out", dir_ + "/tiny/new", "--yes"});
  unsetenv("PARALLAX_WORKER");
  EXPECT_EQ(outcome.exit_code, kExitUsage);
  EXPECT_THAT(outcome.err, HasSubstr("/tiny/new lies in the dataset "));
  EXPECT_FALSE(fs::exists(dir_ + "/tiny/new"));
}

TEST_F(CommandTest, FoldersThatAreNowhereAreRefused) {
  const std::string study = WriteText("s.yaml",
                                      "study: s\npairs: 2\nvariants:\n  - name: a\n"
                                      "    set: {materials: {picture_dir: nowhere/posters}}\n");
  const Outcome run = RunCommand({"run", study, "--out", dir_ + "/out"});
  EXPECT_EQ(run.exit_code, kExitUsage);
  EXPECT_EQ(run.err,
            "error: variant a: materials.picture_dir: no such folder /nowhere/posters, and none of "
            "this path beside the study's file\n");
  EXPECT_FALSE(fs::exists(dir_ + "/out"));
  const Outcome submitted = Run({"submit", study});
  EXPECT_EQ(submitted.exit_code, kExitUsage);
  EXPECT_THAT(submitted.err, HasSubstr("no such folder /nowhere/posters, as seen from here; "));
  const Outcome planned = Run({"plan", study});
  EXPECT_EQ(planned.exit_code, kExitUsage);
  EXPECT_EQ(planned.err, submitted.err);
  EXPECT_EQ(planned.out, "");
}

TEST_F(CommandTest, PlanSubmitsWhatSubmitSubmits) {
  coordinator_.studies = {Baseline()};
  EXPECT_EQ(RunJson({"plan", "quickstart", "--yes"})["study_id"], 3);
  Run({"submit", "quickstart"});
  ASSERT_EQ(coordinator_.submitted.size(), 2u);
  EXPECT_EQ(coordinator_.submitted[0].SerializeAsString(),
            coordinator_.submitted[1].SerializeAsString());
  // Own content comes first; this coordinator takes none.
  fs::create_directories(dir_ + "/own");
  WriteText("own/a.png", *EncodePng(ImageRgb8(40, 30)));
  const std::string study = WriteText(
      "s.yaml", "study: s\npairs: 2\nvariants:\n  - name: a\n    set: {materials: {picture_dir: '" +
                    dir_.substr(1) + "/own'}}\n");
  const Outcome submitted = Run({"submit", study}), planned = Run({"plan", study, "--yes"});
  EXPECT_NE(submitted.exit_code, kExitOk);
  EXPECT_EQ(planned.err, submitted.err);
  EXPECT_EQ(coordinator_.submitted.size(), 2u);
}

TEST_F(CommandTest, RunAsksBeforeItMovesInWithOtherFiles) {
  fs::create_directories(dir_ + "/home");
  std::ofstream(dir_ + "/home/thesis.doc") << "x";
  setenv("PARALLAX_WORKER", "/bin/false", 1);
  const Outcome outcome = RunCommand({"run", "quickstart", "--out", dir_ + "/home"});
  unsetenv("PARALLAX_WORKER");
  EXPECT_EQ(outcome.exit_code, kExitUsage);
  EXPECT_THAT(outcome.err, HasSubstr("holds files that are no dataset; --yes"));
  EXPECT_FALSE(fs::exists(dir_ + "/home/.parallax"));
}

TEST_F(CommandTest, RunNeedsAFolderThatCanBeWritten) {
  setenv("PARALLAX_WORKER", "/bin/false", 1);
  const Outcome outcome = RunCommand({"run", "quickstart", "--out", "/proc/parallax"});
  unsetenv("PARALLAX_WORKER");
  EXPECT_EQ(outcome.exit_code, kExitDisk);
  EXPECT_THAT(outcome.err, HasSubstr("/proc/parallax"));
  EXPECT_EQ(Lines(outcome.err), 1);
}

TEST_F(CommandTest, RunWithoutAWorkerProgramSaysWhereItLooked) {
  setenv("PARALLAX_WORKER", (dir_ + "/gone").c_str(), 1);
  const Outcome outcome = RunCommand({"run", "quickstart", "--out", dir_ + "/out"});
  unsetenv("PARALLAX_WORKER");
  EXPECT_EQ(outcome.exit_code, kExitUsage);
  EXPECT_THAT(outcome.err, HasSubstr(dir_ + "/gone"));
  EXPECT_FALSE(fs::exists(dir_ + "/out"));
}

// ---- Streams

TEST_F(CommandTest, ThePlanOfAStreamSaysWhatTheDiskHolds) {
  const Outcome plan = RunCommand({"plan", "endless"});
  EXPECT_EQ(plan.exit_code, kExitOk) << plan.err;
  EXPECT_THAT(plan.out,
              HasSubstr("Endless: that is its first chunk; at most 4 chunks (960 pairs, "));
  const Outcome json = RunCommand({"plan", "endless", "--json"});
  EXPECT_EQ(nlohmann::json::parse(json.out)["stream"]["chunks_kept"], 4);
}

TEST_F(CommandTest, AStreamWithoutACoordinatorIsRefusedBeforeAFolderIsMade) {
  const std::string out = dir_ + "/farm";
  const Outcome finite = RunCommand({"stream", "quickstart", "--workers", "1", "--out", out});
  EXPECT_EQ(finite.exit_code, kExitUsage);
  EXPECT_THAT(finite.err, HasSubstr("pairs: 8, allowed in a stream is `pairs: endless`"));
  setenv("PARALLAX_WORKER", (dir_ + "/gone").c_str(), 1);
  const Outcome gone = RunCommand({"stream", "endless", "--workers", "1", "--out", out});
  unsetenv("PARALLAX_WORKER");
  EXPECT_EQ(gone.exit_code, kExitUsage);
  EXPECT_THAT(gone.err, HasSubstr(dir_ + "/gone"));
  EXPECT_FALSE(fs::exists(out));
  for (const std::vector<std::string>& arguments :
       {std::vector<std::string>{"stream", "--workers", "1"},
        {"stream", "endless", "--out", out},
        {"stream", "endless", "--pid", "1"},
        {"stream", "endless", "--workers", "1", "--close"}}) {
    EXPECT_EQ(RunCommand(arguments).exit_code, kExitUsage) << arguments.back();
  }
  const Outcome alone =
      RunCommand({"stream", "endless", "--coordinator", "unix:" + dir_ + "/none"});
  EXPECT_EQ(alone.exit_code, kExitUnreachable);
  EXPECT_THAT(alone.err, HasSubstr(", or let this machine be the farm: --workers 2"));
}

// ---- Remedies

TEST_F(CommandTest, CommandsInMessagesHaveFilesWithSpacesInQuotes) {
  const std::string file = WriteText("my drive.yaml", *BuiltinConfigText("studies/endless.yaml"));
  const Outcome submit = Run({"submit", file});
  EXPECT_EQ(submit.exit_code, kExitUsage);
  EXPECT_THAT(submit.err, HasSubstr("`parallax stream '" + file + "'` begins it"));
  EXPECT_THAT(Run({"plan", file, "--yes"}).err, HasSubstr("`parallax stream '" + file + "'`"));
  EXPECT_THAT(RunCommand({"status", "--coordinator", "unix:" + dir_ + "/no one"}).err,
              HasSubstr("--listen 'unix:" + dir_ + "/no one'`"));
}

}  // namespace
}  // namespace parallax::client
