#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "common/base/cores.h"
#include "common/base/names.h"
#include "coordinator/client/exit_code.h"
#include "tests/coordinator/client/fake_coordinator.h"
#include "tests/job_messages.h"
#include "worker/assets/asset.h"
#include "worker/materials/material.h"

namespace parallax::client {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;
using Json = nlohmann::json;

v1::StudyStatus Baseline(int64_t id = 3) {
  v1::StudyStatus study;
  study.set_study_id(id);
  study.set_name("baseline");
  study.set_state(v1::STUDY_STATE_RUNNING);
  study.set_submitted_unix_s(1000000);
  v1::VariantStatus* narrow = study.add_variants();
  narrow->set_name("narrow");
  narrow->set_pairs_wanted(40);
  narrow->set_pairs_done(20);
  AddJobCount(*narrow, "solve", "SUCCEEDED", 2);
  AddJobCount(*narrow, "render", "SUCCEEDED", 1);
  AddJobCount(*narrow, "render", "FAILED", 1);
  narrow->set_scenes_rejected(1);
  v1::JobProblem* problem = narrow->add_problems();
  problem->set_job_id(17);
  problem->set_state("FAILED");
  problem->set_scene(1);
  problem->set_error("it burns\nand more");
  v1::VariantStatus* wide = study.add_variants();
  wide->set_name("wide");
  wide->set_pairs_wanted(40);
  wide->set_pairs_done(40);
  wide->set_layouts_reused(2);
  wide->set_frames_reused(5);
  return study;
}

class CommandTest : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string name = fs::temp_directory_path() / "client_XXXXXX";
    ASSERT_NE(mkdtemp(name.data()), nullptr);
    dir_ = name;
  }
  void TearDown() override { fs::remove_all(dir_); }

  Outcome Run(std::vector<std::string> arguments) {
    arguments.insert(arguments.end(), {"--coordinator", coordinator_.address()});
    return RunCommand(arguments);
  }
  Json RunJson(std::vector<std::string> arguments) {
    arguments.push_back("--json");
    const Outcome outcome = Run(arguments);
    EXPECT_EQ(outcome.exit_code, kExitOk) << outcome.err;
    return Json::parse(outcome.out);
  }
  std::string WriteText(const std::string& name, const std::string& text) {
    std::ofstream(dir_ + "/" + name) << text;
    return dir_ + "/" + name;
  }

  FakeCoordinator coordinator_;
  std::string dir_;
};

int Lines(const std::string& text) {
  return static_cast<int>(std::count(text.begin(), text.end(), '\n'));
}

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
}

// ---- Usage

TEST_F(CommandTest, EveryCommandHasHelpWithAnExample) {
  for (const char* command : {"run", "submit", "status", "watch", "cancel", "pause", "resume",
                              "retry", "workers", "jobs", "fetch", "view", "catalogue"}) {
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
    const char* wanted;
  } cases[] = {
      {{"statsu"}, "did you mean `parallax status`?"},
      {{"scene", "shwo"}, "did you mean `parallax scene show`?"},
      {{"cancel"}, "STUDY is required"},
      {{"run", "quickstart"}, "--out is required"},
      {{"submit", "quickstart", "--pears", "3"}, "--pears"},
      {{"submit", "quickstart", "--pairs", "many"}, "many"},
      {{"submit", "quickstart", "--pairs", "0"}, "--pairs: 0 was given, at least 1 is needed"},
      {{"submit", "quickstart", "--pairs", "4", "--scenes", "1"}, "--pairs and --scenes"},
      {{"submit", "quickstart", "--profile", "ultra"}, "preview"},
      {{"submit", "baseline", "--width", "3"},
       "error: with these options variants[0].config.rigs.width_px: 3 is out of range"},
      {{"jobs", "3", "--state", "lazy"}, "lazy"},
      {{"status", "--coordinator", "nonsense"}, "nonsense"},
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

// ---- submit

TEST_F(CommandTest, SubmitPrintsTheIdAloneAndSendsTheResolvedStudy) {
  coordinator_.studies = {Baseline(12)};
  const Outcome outcome =
      Run({"submit",    "quickstart", "--pairs",    "6",        "--rigs", "3",         "--seed",
           "9",         "--width",    "64",         "--height", "48",     "--samples", "2",
           "--profile", "preview",    "--priority", "5",        "--name", "tiny"});
  EXPECT_EQ(outcome.exit_code, kExitOk) << outcome.err;
  EXPECT_EQ(outcome.out, "12\n");
  EXPECT_THAT(outcome.err, HasSubstr("parallax watch 12"));
  ASSERT_EQ(coordinator_.submitted.size(), 1u);
  const v1::StudySpec& study = coordinator_.submitted[0].study();
  EXPECT_EQ(study.name(), "tiny");
  EXPECT_EQ(study.pairs(), 6);
  EXPECT_EQ(study.rigs_per_scene(), 3);
  EXPECT_EQ(study.seed(), 9u);
  EXPECT_EQ(study.priority(), 5);
  EXPECT_EQ(study.variants(0).config().rigs().width_px(), 64);
  EXPECT_EQ(study.variants(0).config().rigs().height_px(), 48);
  EXPECT_EQ(study.variants(0).config().render().samples_per_pixel(), 2);
  EXPECT_EQ(study.variants(0).config().render().profile(), "preview");
}

TEST_F(CommandTest, ScenesAreCountedInPairs) {
  EXPECT_EQ(Run({"submit", "quickstart", "--scenes", "5"}).exit_code, kExitOk);
  const v1::StudySpec& study = coordinator_.submitted.at(0).study();
  EXPECT_EQ(study.pairs(), 5 * study.rigs_per_scene());
}

TEST_F(CommandTest, TheKeyIsThatOfTheResolvedStudy) {
  const auto key = [&](std::vector<std::string> more) {
    std::vector<std::string> arguments = {"submit", "quickstart"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    EXPECT_EQ(Run(arguments).exit_code, kExitOk);
    return coordinator_.submitted.back().idempotency_key();
  };
  const std::string plain = key({});
  EXPECT_EQ(key({}), plain);
  EXPECT_EQ(key({"--pairs", "8"}), plain) << "what the file says anyway";
  EXPECT_EQ(key({"--priority", "7"}), plain) << "does not change what is made";
  EXPECT_NE(key({"--pairs", "9"}), plain);
  EXPECT_NE(key({"--seed", "2"}), plain);
  EXPECT_NE(key({"--again"}), plain);
}

TEST_F(CommandTest, SubmittingTheSameStudyAgainSaysSo) {
  coordinator_.studies = {Baseline()};
  coordinator_.submit_existed = true;
  const Outcome outcome = Run({"submit", "baseline"});
  EXPECT_EQ(outcome.exit_code, kExitOk);
  EXPECT_EQ(outcome.out, "3\n");
  EXPECT_THAT(outcome.err, HasSubstr("there already as study 3 (running)"));
  const Json json = RunJson({"submit", "baseline"});
  EXPECT_EQ(json["study_id"], 3);
  EXPECT_EQ(json["existed"], true);
  EXPECT_EQ(json["state"], "running");
}

TEST_F(CommandTest, BadStudiesNameFileAndLine) {
  const std::string unknown = WriteText(
      "unknown.yaml", "study: s\npairs: 2\nvariants:\n  - name: a\n    set: {rigs: {colour: 1}}\n");
  Outcome outcome = Run({"submit", unknown});
  EXPECT_EQ(outcome.exit_code, kExitUsage);
  EXPECT_THAT(outcome.err, HasSubstr(unknown + ":5"));
  EXPECT_THAT(outcome.err, HasSubstr("colour"));
  const std::string broken = WriteText("broken.yaml", "study: s\npairs: [\n");
  outcome = Run({"submit", broken});
  EXPECT_EQ(outcome.exit_code, kExitUsage);
  EXPECT_THAT(outcome.err, HasSubstr(broken + ":"));
  outcome = RunCommand({"run", broken, "--out", dir_ + "/out"});
  EXPECT_EQ(outcome.exit_code, kExitUsage);
  EXPECT_FALSE(fs::exists(dir_ + "/out")) << "nothing is made for a study that can't run";
  EXPECT_TRUE(coordinator_.submitted.empty());
}

// ---- status, watch

TEST_F(CommandTest, StatusListsStudies) {
  EXPECT_THAT(Run({"status"}).out, HasSubstr("no studies yet"));
  coordinator_.studies = {Baseline(3)};
  const Outcome outcome = Run({"status"});
  EXPECT_THAT(outcome.out, HasSubstr("ID  NAME      STATE    VARIANTS  PAIRS"));
  EXPECT_THAT(outcome.out, HasSubstr(" 3  baseline  running         2  60/80  75%"));
  const Json json = RunJson({"status"});
  EXPECT_EQ(json["studies"][0]["pairs_done"], 60);
}

TEST_F(CommandTest, StatusOfAStudyShowsVariantsAndProblems) {
  coordinator_.studies = {Baseline()};
  const Outcome outcome = Run({"status", "baseline"});
  EXPECT_EQ(outcome.exit_code, kExitOk);
  for (const char* wanted : {"baseline  study 3  running", "narrow   20/40   50%",
                             "wide     40/40  100%", "total    60/80   75%", "LAYOUTS REUSED",
                             "failed  narrow scene 1 job 17: it burns\n", "parallax retry 3"}) {
    EXPECT_THAT(outcome.out, HasSubstr(wanted));
  }
  EXPECT_THAT(outcome.out, Not(HasSubstr("and more")));
}

TEST_F(CommandTest, StatusJsonHasTheDocumentedFields) {
  coordinator_.studies = {Baseline()};
  const Json json = RunJson({"status", "3"});
  EXPECT_EQ(json["study_id"], 3);
  EXPECT_EQ(json["name"], "baseline");
  EXPECT_EQ(json["state"], "running");
  EXPECT_EQ(json["pairs_wanted"], 80);
  EXPECT_EQ(json["frames_reused"], 5);
  EXPECT_EQ(json["layouts_reused"], 2);
  EXPECT_EQ(json["solves_done"], 2);
  EXPECT_EQ(json["scenes_rejected"], 1);
  EXPECT_EQ(json["jobs_failed"], 1);
  EXPECT_EQ(json["variants"][0]["render_jobs"]["failed"], 1);
  EXPECT_EQ(json["variants"][0]["problems"][0]["error"], "it burns\nand more");
}

TEST_F(CommandTest, UnknownStudiesAreAnsweredWithThoseThereAre) {
  coordinator_.studies = {Baseline()};
  for (const char* name : {"99", "nothing"}) {
    const Outcome outcome = Run({"status", name});
    EXPECT_EQ(outcome.exit_code, kExitUsage);
    EXPECT_THAT(outcome.err, HasSubstr("no study '" + std::string(name) + "'"));
    EXPECT_THAT(outcome.err, HasSubstr("there are 3 (baseline)"));
    EXPECT_EQ(Lines(outcome.err), 1);
  }
}

TEST_F(CommandTest, ANameMeansItsNewestStudy) {
  coordinator_.studies = {Baseline(3), Baseline(8), Baseline(5)};
  EXPECT_EQ(RunJson({"status", "baseline"})["study_id"], 8);
}

TEST_F(CommandTest, WatchEndsWithTheStudyAndTellsItsEnd) {
  const struct {
    v1::StudyState end;
    int exit_code;
  } cases[] = {{v1::STUDY_STATE_SUCCEEDED, kExitOk},
               {v1::STUDY_STATE_FAILED, kExitFailed},
               {v1::STUDY_STATE_CANCELLED, kExitFailed}};
  for (const auto& c : cases) {
    coordinator_.studies = {Baseline()};
    int looks = 0;
    coordinator_.on_get_study = [&](FakeCoordinator& self) {
      if (++looks == 4) self.studies[0].set_state(c.end);
    };
    const Outcome outcome = Run({"watch", "3"});
    EXPECT_EQ(outcome.exit_code, c.exit_code) << outcome.err;
    EXPECT_EQ(Lines(outcome.out), 3) << outcome.out;
    EXPECT_THAT(outcome.out, HasSubstr("60/80 pairs (75%)"));
    EXPECT_THAT(outcome.err, HasSubstr("it burns"));
  }
}

TEST_F(CommandTest, WatchJsonIsAnObjectALine) {
  coordinator_.studies = {Baseline()};
  coordinator_.studies[0].set_state(v1::STUDY_STATE_SUCCEEDED);
  const Outcome outcome = Run({"watch", "3", "--json"});
  EXPECT_EQ(Lines(outcome.out), 1);
  const Json json = Json::parse(outcome.out);
  EXPECT_EQ(json["state"], "succeeded");
  EXPECT_EQ(json["pairs_done"], 60);
  EXPECT_EQ(json["variants"][1]["name"], "wide");
}

// ---- Steering

TEST_F(CommandTest, OrdersReachTheStudyWithTheirReason) {
  coordinator_.studies = {Baseline()};
  Outcome outcome = Run({"pause", "baseline", "--reason", "lunch"});
  EXPECT_EQ(outcome.out, "study 3 (baseline) is now paused: 60 of 80 pairs done\n");
  EXPECT_EQ(RunJson({"resume", "3"})["state"], "running");
  EXPECT_THAT(Run({"cancel", "3"}).out, HasSubstr("is now cancelled"));
  EXPECT_THAT(Run({"cancel", "3"}).out, HasSubstr("was and is cancelled"));
  EXPECT_THAT(coordinator_.orders,
              ElementsAre("pause 3 lunch", "resume 3 ", "cancel 3 ", "cancel 3 "));
}

TEST_F(CommandTest, RetryCountsJobs) {
  coordinator_.studies = {Baseline()};
  EXPECT_THAT(Run({"retry", "3"}).out, HasSubstr("no failed jobs"));
  coordinator_.retried_jobs = 2;
  EXPECT_THAT(Run({"retry", "3"}).out, HasSubstr("2 jobs of study 3"));
  EXPECT_EQ(RunJson({"retry", "3"})["jobs"], 2);
}

TEST_F(CommandTest, JobsAndWorkersAreTables) {
  coordinator_.studies = {Baseline()};
  v1::JobStatus job;
  job.set_job_id(17);
  job.set_kind("render");
  job.set_state("LEASED");
  job.set_variant("narrow");
  job.set_scene(4);
  for (const uint32_t rig : {0u, 1u, 2u, 7u}) job.add_rigs(rig);
  job.set_attempts(1);
  job.set_worker("w1");
  job.set_fraction(0.5);
  job.set_stage("trace");
  coordinator_.jobs = {job};
  EXPECT_THAT(Run({"jobs", "3"}).out,
              HasSubstr(" 17  render  leased  narrow       4  0-2,7      1  w1      trace 50%"));
  EXPECT_THAT(Run({"jobs", "3", "--state", "failed"}).out, HasSubstr("no failed jobs"));
  EXPECT_EQ(coordinator_.listed_jobs.state(), "FAILED");
  EXPECT_EQ(RunJson({"jobs", "3"})["jobs"][0]["rigs"], Json({0, 1, 2, 7}));

  v1::JobStatus training;
  training.set_job_id(18);
  training.set_kind("train");
  training.set_state("RETRY_WAIT");
  training.set_variant("narrow");
  training.set_scene(4);
  training.set_label("narrow, seed 1");
  training.set_attempts(1);
  training.set_error("exit status 3");
  training.set_log_tail("step 1\nbang \x1b[2J\n");
  coordinator_.jobs = {training};
  const std::string jobs = Run({"jobs", "3"}).out;
  EXPECT_THAT(jobs,
              HasSubstr("narrow       -            1          narrow, seed 1: exit status 3"));
  EXPECT_THAT(jobs, HasSubstr("\nThe end of the log of job 18 (narrow, seed 1):\n  step 1\n"
                              "  bang \\x1b[2J\n"));
  EXPECT_EQ(RunJson({"jobs", "3"})["jobs"][0]["label"], "narrow, seed 1");
  training.set_state("LEASED");
  (*training.mutable_figures())["step"] = 7;
  coordinator_.jobs = {training};
  EXPECT_THAT(Run({"jobs", "3"}).out, HasSubstr("narrow, seed 1: step 7"));

  EXPECT_THAT(Run({"workers"}).out, HasSubstr("no workers: `worker --coordinator "));
  v1::WorkerStatus worker;
  worker.set_name("w1");
  worker.set_state("ACTIVE");
  worker.add_kinds("solve");
  worker.add_kinds("render");
  worker.set_slots(2);
  worker.set_running(1);
  coordinator_.workers = {worker};
  EXPECT_THAT(Run({"workers"}).out, HasSubstr("w1      active  solve,render        1      2"));
  EXPECT_EQ(RunJson({"workers"})["workers"][0]["kinds"], Json({"solve", "render"}));
}

TEST_F(CommandTest, NothingThatATerminalActsOnIsPrinted) {
  const std::string evil = "a\x1b[2J\u202e\u009b" + std::string(1, '\0') + "z";
  v1::StudyStatus study = Baseline();
  study.set_name(evil);
  study.mutable_variants(0)->set_name(evil);
  study.mutable_variants(0)->mutable_problems(0)->set_error(evil);
  coordinator_.studies = {study};
  v1::WorkerStatus worker;
  worker.set_name(evil);
  worker.set_state(evil);
  worker.set_version(evil);
  coordinator_.workers = {worker};
  v1::JobStatus job;
  job.set_state("FAILED");
  job.set_variant(evil);
  job.set_worker(evil);
  job.set_error(evil);
  coordinator_.jobs = {job};
  v1::AuditEntry entry;
  entry.set_id(1);
  entry.set_actor(evil);
  entry.set_action(evil);
  entry.set_detail(evil);
  coordinator_.audit = {entry};
  for (const std::vector<std::string>& command :
       std::vector<std::vector<std::string>>{{"status"},
                                             {"status", "3"},
                                             {"status", "no such study"},
                                             {"workers"},
                                             {"jobs", "3"},
                                             {"audit"},
                                             {"status", "--json"},
                                             {"watch", "3"}}) {
    if (command[0] == "watch") coordinator_.studies[0].set_state(v1::STUDY_STATE_CANCELLED);
    const Outcome outcome = Run(command);
    std::string all = outcome.out + outcome.err;
    EXPECT_NE(all.find("a"), std::string::npos);
    std::replace(all.begin(), all.end(), '\n', ' ');
    EXPECT_TRUE(IsPlainText(all)) << command[0] << ": " << Printable(all);
  }
}

// ---- Data

TEST_F(CommandTest, FetchFromAStoreThatNobodySendsIsClear) {
  coordinator_.studies = {Baseline()};
  coordinator_.studies[0].mutable_spec()->add_variants()->set_name("narrow");
  v1::PublishedFrame frame;
  frame.set_cursor(1);
  frame.set_variant("narrow");
  frame.mutable_frame()->set_path("key/.attempt-1/000");
  v1::FileEntry& file = *frame.mutable_frame()->add_files();
  file.set_name("left.png");
  file.set_size(1);
  file.set_sha256(std::string(64, '0'));
  (*frame.mutable_frame()->mutable_statistics())["mean_intensity"] = 90;
  (*frame.mutable_frame()->mutable_statistics())["min_depth_m"] = 1;
  coordinator_.frames = {frame};
  // A coordinator of an older version, and neither an object store nor a folder that is here.
  for (const std::string& store :
       {std::string("s3://somewhere"), "file://" + dir_ + "/elsewhere"}) {
    coordinator_.store_uri = store;
    const Outcome outcome = Run({"fetch", "3", "--out", dir_ + "/out-" + store.substr(0, 2)});
    EXPECT_EQ(outcome.exit_code, kExitUsage) << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr("can't be seen from here"));
  }
  EXPECT_FALSE(fs::exists(dir_ + "/elsewhere")) << "a store is never made by reading it";
}

TEST_F(CommandTest, AuditTellsWhoDidWhat) {
  v1::AuditEntry entry;
  entry.set_id(7);
  entry.set_unix_s(1795000000);
  entry.set_actor("submitter ada ipv4:10.0.0.7:4711");
  entry.set_action("cancel");
  entry.set_study_id(3);
  entry.set_detail("enough");
  coordinator_.audit = {entry};
  const Json json = RunJson({"audit"});
  EXPECT_EQ(json["entries"][0]["actor"], "submitter ada ipv4:10.0.0.7:4711");
  EXPECT_EQ(json["entries"][0]["action"], "cancel");
  EXPECT_EQ(json["entries"][0]["study_id"], 3);
  EXPECT_THAT(Run({"audit"}).out, HasSubstr("2026-11-18 11:06:40"));
  coordinator_.audit.clear();
  EXPECT_THAT(Run({"audit"}).out, HasSubstr("nothing has been done yet"));
}

TEST_F(CommandTest, SceneShowReadsFilesAndCoordinators) {
  coordinator_.studies = {Baseline()};
  v1::Scene scene;
  scene.set_generator_version("1");
  scene.set_scene_seed(255);
  scene.set_type(v1::SCENE_TYPE_DENSE);
  coordinator_.scene = scene;
  EXPECT_THAT(Run({"scene", "show", "3", "narrow", "0"}).out, HasSubstr("scene 00000000000000ff"));
  const std::string file = WriteText("000000.pb", scene.SerializeAsString());
  EXPECT_THAT(RunCommand({"scene", "show", file}).out, HasSubstr("scene 00000000000000ff"));
  EXPECT_EQ(Json::parse(RunCommand({"scene", "show", file, "--json"}).out)["scene_seed"], "255");
  EXPECT_THAT(RunCommand({"scene", "show", file, "--textproto"}).out, HasSubstr("scene_seed: 255"));
  // A dataset's folder, with no coordinator at hand.
  for (const char* variant : {"narrow", "wide"}) {
    fs::create_directories(dir_ + "/data/" + variant + "/scenes");
    std::ofstream(dir_ + "/data/" + variant + "/scenes/000012.pb") << scene.SerializeAsString();
  }
  const auto from_folder = [&](const char* variant, const char* number) {
    return RunCommand({"scene", "show", dir_ + "/data", variant, number});
  };
  EXPECT_THAT(from_folder("wide", "12").out, HasSubstr("scene 00000000000000ff"));
  EXPECT_THAT(from_folder("huge", "12").err,
              HasSubstr("data has no variant 'huge'; it has narrow, wide"));
  EXPECT_THAT(from_folder("wide", "3").err,
              HasSubstr("has no scene 3; it has 1, from 000012 to 000012"));
  EXPECT_THAT(from_folder("wide", "x").err, HasSubstr("'x' is not a scene's number"));
  EXPECT_THAT(RunCommand({"scene", "show", dir_, "wide", "0"}).err, HasSubstr("no dataset"));
  Outcome outcome = Run({"scene", "show", "3", "huge", "0"});
  EXPECT_EQ(outcome.exit_code, kExitUsage);
  EXPECT_THAT(outcome.err, HasSubstr("has no variant 'huge'; it has narrow, wide"));
  outcome = RunCommand({"scene", "show", WriteText("x.pb", "hello")});
  EXPECT_EQ(outcome.exit_code, kExitUsage);
  EXPECT_THAT(outcome.err, HasSubstr("not a scene recipe"));
}

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
  // What `show` prints is a study that resolves to the same.
  const std::string shown = RunCommand({"config", "show", "baseline"}).out;
  const std::string file = WriteText("shown.yaml", shown);
  EXPECT_EQ(RunCommand({"config", "show", file}).out, shown);
  const std::string bad = WriteText("scene.yaml", "rigs: {count: 0}\n");
  const Outcome outcome = RunCommand({"config", "check", bad});
  EXPECT_EQ(outcome.exit_code, kExitUsage);
  EXPECT_THAT(outcome.err, HasSubstr(bad + ":1"));
}

// ---- run: what is refused before anything starts

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

}  // namespace
}  // namespace parallax::client
