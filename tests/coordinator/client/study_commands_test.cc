#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "common/base/names.h"
#include "coordinator/client/views/study_view.h"
#include "tests/coordinator/client/command_test.h"

namespace parallax::client {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using Json = nlohmann::json;

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
  EXPECT_EQ(coordinator_.submitted[0].max_running(), 0);
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

v1::WaitingJobs WaitingFor(const std::string& reason, const std::string& text, int64_t jobs) {
  v1::WaitingJobs waiting;
  waiting.set_kind("train");
  waiting.set_jobs(jobs);
  waiting.set_reason(reason);
  waiting.set_text(text);
  return waiting;
}

TEST_F(CommandTest, SubmitNotesTheJobsThatNoKnownWorkerCouldRun) {
  coordinator_.unservable = {WaitingFor("trainer", "no connected worker has it", 0)};
  const Outcome outcome = Run({"submit", "quickstart"});
  EXPECT_EQ(outcome.exit_code, kExitOk);
  EXPECT_EQ(outcome.out, "1\n") << "the id alone, for scripts";
  EXPECT_THAT(outcome.err, HasSubstr("its train jobs will wait: no connected worker has it"));
  coordinator_.unservable = {WaitingFor("no_worker", "no worker is connected", 0)};
  EXPECT_THAT(Run({"submit", "quickstart"}).err,
              HasSubstr("its jobs will wait: no worker is connected"));
  EXPECT_EQ(RunJson({"submit", "quickstart"})["unservable"][0]["reason"], "no_worker");
}

TEST_F(CommandTest, StatusAndJobsSayWhyReadyJobsDoNotRun) {
  coordinator_.studies = {Baseline()};
  *coordinator_.studies[0].add_waiting() =
      WaitingFor("trainer", "no connected worker has the trainer x", 4);
  EXPECT_THAT(Run({"status", "baseline"}).out,
              HasSubstr("4 train jobs wait: no connected worker has the trainer x\n"));
  EXPECT_THAT(Run({"status"}).out, HasSubstr("4 trainer"));
  const Json waiting = RunJson({"status", "baseline"})["waiting"][0];
  EXPECT_EQ(waiting["kind"], "train");
  EXPECT_EQ(waiting["jobs"], 4);
  EXPECT_EQ(waiting["reason"], "trainer");
  v1::JobStatus job;
  job.set_job_id(7);
  job.set_kind("train");
  job.set_state("READY");
  job.set_label("narrow, seed 0");
  job.set_waits_reason("trainer");
  job.set_waits_text("no connected worker has the trainer x");
  coordinator_.jobs = {job};
  EXPECT_THAT(Run({"jobs", "baseline"}).out,
              HasSubstr("narrow, seed 0: no connected worker has the trainer x"));
  EXPECT_EQ(RunJson({"jobs", "baseline"})["jobs"][0]["waits_reason"], "trainer");
}

TEST_F(CommandTest, ASucceededStudySaysThatItsFailuresWereMadeGood) {
  v1::StudyStatus study = Baseline();
  AddJobCount(*study.mutable_variants(0), "train", "SUCCEEDED", 4);
  AddJobCount(*study.mutable_variants(0), "train", "FAILED", 2);
  AddJobCount(*study.mutable_variants(0), "evaluate", "CANCELLED", 8);
  coordinator_.studies = {study};
  Outcome shown = Run({"status", "baseline"});
  EXPECT_THAT(shown.out, HasSubstr("train: 4 done, 2 failed\n"));
  EXPECT_THAT(shown.out, HasSubstr("`parallax retry 3` tries failed jobs again"));
  study.set_state(v1::STUDY_STATE_SUCCEEDED);
  coordinator_.studies = {study};
  shown = Run({"status", "baseline"});
  EXPECT_THAT(shown.out, HasSubstr("train: 4 done, 2 failed before\n"));
  EXPECT_THAT(shown.out, HasSubstr("evaluate: 8 cancelled before\n"));
  EXPECT_THAT(shown.out, Not(HasSubstr("tries failed jobs again")));
}

TEST_F(CommandTest, APageLinkNamesAnAddressThatThisMachineReaches) {
  const std::string host = coordinator_.address().substr(0, coordinator_.address().find(':'));
  EXPECT_EQ(Run({"page"}).out, "http://" + host + ":7080/#code=abc\n");
  EXPECT_EQ(Run({"page", "--http", "farm.example.org:443"}).out,
            "http://farm.example.org:443/#code=abc\n");
  coordinator_.page_url = "http://127.0.0.1:7080/#code=abc";
  EXPECT_EQ(RunJson({"page"})["link"], "http://127.0.0.1:7080/#code=abc");
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
  EXPECT_FALSE(std::filesystem::exists(dir_ + "/out"))
      << "nothing is made for a study that can't run";
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

TEST_F(CommandTest, ProblemsWithoutASceneNameNone) {
  constexpr uint32_t kNoScene = UINT32_MAX;  // As coordinators send it.
  v1::StudyStatus study = Baseline();
  v1::JobProblem* training = study.mutable_variants(0)->add_problems();
  training->set_job_id(18);
  training->set_state("FAILED");
  training->set_scene(kNoScene);
  training->set_error("train narrow, seed 1: exit status 3");
  v1::JobProblem* gave_up = study.mutable_variants(0)->add_problems();
  gave_up->set_state("GAVE_UP");
  gave_up->set_error("nothing works");
  coordinator_.studies = {study};
  const std::string out = Run({"status", "3"}).out;
  EXPECT_THAT(out, HasSubstr("failed  narrow job 18: train narrow, seed 1: exit status 3\n"));
  EXPECT_THAT(out, HasSubstr("gave_up  narrow: nothing works\n"));
  EXPECT_THAT(out, Not(HasSubstr("4294967295")));
  const Json problems = RunJson({"status", "3"})["variants"][0]["problems"];
  EXPECT_EQ(problems[0]["scene"], 1);
  EXPECT_EQ(problems[1]["scene"], nullptr);
  EXPECT_EQ(problems[2]["scene"], nullptr);
  // The notes of `run`.
  EXPECT_EQ(PlaceOf("narrow", study.variants(0).problems(0)), "narrow scene 1");
  EXPECT_EQ(PlaceOf("narrow", *training), "narrow");
  EXPECT_EQ(PlaceOf("narrow", *gave_up), "narrow");
  v1::JobStatus job;
  job.set_variant("narrow");
  job.set_scene(4);
  EXPECT_EQ(PlaceOf(job), "narrow scene 4");
  job.set_scene(kNoScene);
  EXPECT_EQ(PlaceOf(job), "narrow");
  job.set_label("narrow, seed 1");
  EXPECT_EQ(PlaceOf(job), "narrow, seed 1");
  job.set_state("RETRY_WAIT");
  coordinator_.jobs = {job};
  EXPECT_EQ(RunJson({"jobs", "3"})["jobs"][0]["scene"], nullptr);
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

TEST_F(CommandTest, AStudyIsFoundByItsNameHoweverManyAreNewer) {
  for (int64_t id = 9; id >= 3; --id) {
    coordinator_.studies.push_back(Baseline(id));
    if (id > 3) coordinator_.studies.back().set_name("newer");
  }
  coordinator_.studies_in_a_reply = 2;
  EXPECT_EQ(RunJson({"status", "baseline"})["study_id"], 3);
  EXPECT_EQ(RunJson({"status", "newer"})["study_id"], 9);
  EXPECT_THAT(
      Run({"status", "none"}).err,
      HasSubstr("no study 'none' at " + coordinator_.address() + "; there are 9 (newer), 8"));
}

TEST_F(CommandTest, TheAuditOfAForgottenStudyIsFoundByItsNumber) {
  v1::AuditEntry entry;
  entry.set_id(1);
  entry.set_study_id(7);
  entry.set_action("forget");
  coordinator_.audit = {entry};
  EXPECT_EQ(RunJson({"audit", "7"})["entries"][0]["action"], "forget");
  EXPECT_EQ(RunJson({"audit", "8"})["entries"].size(), 0u);
}

// ---- Steering

TEST_F(CommandTest, OrdersReachTheStudyWithTheirReason) {
  coordinator_.studies = {Baseline()};
  Outcome outcome = Run({"pause", "baseline", "--reason", "lunch"});
  EXPECT_EQ(outcome.out, "study 3 (baseline) is now paused: 60 of 80 pairs done\n");
  EXPECT_EQ(RunJson({"resume", "3"})["state"], "running");
  EXPECT_THAT(Run({"cancel", "3"}).out, HasSubstr("is now cancelled"));
  EXPECT_THAT(Run({"cancel", "3"}).out, HasSubstr("was and is cancelled"));
  const Outcome resumed = Run({"resume", "3"});
  EXPECT_EQ(resumed.exit_code, kExitUsage);
  EXPECT_EQ(resumed.err, "error: study 3 is cancelled: submit it again instead\n");
  EXPECT_THAT(coordinator_.orders,
              ElementsAre("pause 3 lunch", "resume 3 ", "cancel 3 ", "cancel 3 "));
}

TEST_F(CommandTest, ATextThatIsNotUtf8IsRefusedBeforeItIsSent) {
  coordinator_.studies = {Baseline()};
  Outcome outcome = Run({"pause", "3", "--reason", "gr\xfc\xdf"});
  EXPECT_EQ(outcome.exit_code, kExitUsage);
  EXPECT_EQ(outcome.err, "error: reason \"gr\\xfc\\xdf\" is not UTF-8\n");
  outcome = Run({"workers", "drain", "n\xfc"});
  EXPECT_EQ(outcome.exit_code, kExitUsage);
  EXPECT_EQ(outcome.err, "error: pattern \"n\\xfc\" is not UTF-8\n");
  EXPECT_THAT(coordinator_.orders, IsEmpty());
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

TEST_F(CommandTest, JobsComeInAsManyRepliesAsTheyNeed) {
  coordinator_.studies = {Baseline()};
  for (int i = 1; i <= 23; ++i) {
    v1::JobStatus& job = coordinator_.jobs.emplace_back();
    job.set_job_id(i);
    job.set_kind("render");
    job.set_state(i < 9 ? "LEASED" : "READY");
  }
  coordinator_.jobs_in_a_reply = 5;
  const Json all = RunJson({"jobs", "3", "--all"})["jobs"];
  ASSERT_EQ(all.size(), 23u);
  for (int i = 0; i < 23; ++i) EXPECT_EQ(all[i]["job_id"], i + 1);
  EXPECT_EQ(coordinator_.job_lists, 5);
  EXPECT_EQ(RunJson({"jobs", "3", "--limit", "12"})["jobs"].size(), 12u);
  EXPECT_THAT(Run({"jobs", "3", "--limit", "12"}).err, HasSubstr("the first 12; --limit shows"));
  EXPECT_THAT(Run({"jobs", "3", "--all"}).err, Not(HasSubstr("the first")));
}

TEST_F(CommandTest, LimitsAreShownAndSet) {
  coordinator_.studies = {Baseline()};
  EXPECT_EQ(Run({"submit", "quickstart", "--max-running", "7"}).exit_code, kExitOk);
  EXPECT_EQ(coordinator_.submitted.back().max_running(), 7);
  EXPECT_EQ(Run({"submit", "quickstart", "--max-running", "-7"}).exit_code, kExitUsage);
  EXPECT_THAT(Run({"limits"}).out, HasSubstr("no user has an unfinished study"));
  v1::UserStatus ada;
  ada.set_user("submitter ada");
  ada.set_running(64);
  ada.set_max_running(64);
  ada.set_studies(2);
  ada.set_waiting_pairs(12345);
  ada.set_max_waiting_pairs(20000);
  ada.set_rule("submitter *");
  ada.set_priority(20);
  v1::UserStatus local;
  local.set_user("local");
  coordinator_.users = {local, ada};
  const std::string table = Run({"limits"}).out;
  EXPECT_THAT(table,
              HasSubstr("submitter ada  64 / 64        2  12,345 / 20,000        20  submitter *"));
  EXPECT_THAT(table, HasSubstr("none"));
  EXPECT_EQ(RunJson({"limits"})["users"][1]["max_running"], 64);
  EXPECT_EQ(RunJson({"limits"})["users"][1]["priority"], 20);
  EXPECT_THAT(Run({"limits", "baseline", "--max-running", "8", "--reason", "room"}).out,
              HasSubstr("at most 8"));
  EXPECT_THAT(coordinator_.orders, ElementsAre("limit 3 8 room"));
  EXPECT_EQ(RunJson({"limits", "3"})["max_running"], 8);
  EXPECT_EQ(Run({"limits", "--max-running", "8"}).exit_code, kExitUsage);
  EXPECT_EQ(Run({"limits", "3", "--max-running", "-1"}).exit_code, kExitUsage);

  v1::StudyStatus& study = coordinator_.studies[0];
  study.set_at_limit("max_running 8");
  study.set_held_jobs(30);
  EXPECT_THAT(Run({"status", "3"}).out,
              HasSubstr("at most 8 jobs at a time (max_running)\n"
                        "at its limit: max_running 8; 30 jobs wait for it\n"));
  EXPECT_EQ(RunJson({"status", "3"})["at_limit"], "max_running 8");
}

TEST_F(CommandTest, LogsTellHowEachAttemptEnded) {
  v1::JobStatus& job = *coordinator_.attempts.mutable_job();
  job.set_job_id(17);
  job.set_kind("render");
  job.set_state("SUCCEEDED");
  job.set_variant("narrow");
  job.set_scene(4);
  EXPECT_EQ(Run({"logs", "17"}).out,
            "job 17 (render narrow, scene 4) is succeeded; no attempt yet\n");
  const double now = Clock::System().UnixSeconds();
  const auto add = [&](const char* ending, const char* worker, double ago_s, const char* error,
                       const char* log) {
    v1::AttemptStatus& attempt = *coordinator_.attempts.add_attempts();
    attempt.mutable_attempt()->set_job_id(17);
    attempt.mutable_attempt()->set_fence(18443116268015309785u);
    attempt.set_ending(ending);
    attempt.set_worker(worker);
    attempt.set_unix_s(now - ago_s);
    attempt.set_error(error);
    attempt.set_log_tail(log);
  };
  add("succeeded", "w3", 100, "", "");
  add("returned", "w2", 3600, "handed back by w2: drained", "");
  add("failed", "w1", 7200, "INTERNAL: it burns", "first\nbang \x1b[2J\n");
  const std::string out = Run({"logs", "17"}).out;
  EXPECT_THAT(out, HasSubstr("is succeeded; 3 attempts\n\nfailed on w1, 2:00:0"));
  EXPECT_THAT(out,
              HasSubstr(" ago: INTERNAL: it burns\n  first\n  bang \\x1b[2J\n\nhanded back on"));
  EXPECT_THAT(out, HasSubstr("\n\nsucceeded on w3, 1:40 ago\n"));
  const Json json = RunJson({"logs", "17"});
  EXPECT_EQ(json["attempts"][2]["log_tail"], "first\nbang \\x1b[2J");
  EXPECT_EQ(json["attempts"][0]["fence"], "18443116268015309785") << "no number of JavaScript's";
  coordinator_.attempts.mutable_attempts(2)->clear_log_tail();
  EXPECT_THAT(Run({"logs", "17"}).out, HasSubstr("it burns\n  (its log is gone)\n"));
  EXPECT_EQ(Run({"logs", "18"}).exit_code, kExitUsage);
}

TEST_F(CommandTest, WorkersAreDrainedByNameAndSeenAsDrained) {
  coordinator_.drained_workers = {"node1-1", "node1-2"};
  EXPECT_EQ(Run({"workers", "drain", "node1-*", "--reason", "new disk"}).out,
            "node1-1 finishes what it has and gets nothing new\n"
            "node1-2 finishes what it has and gets nothing new\n");
  EXPECT_EQ(RunJson({"workers", "drain", "node1-*", "--undo"})["workers"],
            Json({"node1-1", "node1-2"}));
  EXPECT_EQ(coordinator_.orders,
            (std::vector<std::string>{"drain node1-* new disk", "undrain node1-* "}));
  coordinator_.drained_workers.clear();
  EXPECT_THAT(Run({"workers", "drain", "x"}).out, HasSubstr("those that come get no work"));
  v1::WorkerStatus worker;
  worker.set_name("node1-1");
  worker.set_state("drained");
  worker.set_drained_by("node1-*");
  coordinator_.workers = {worker};
  v1::DrainOrder order;
  order.set_pattern("node1-*");
  order.set_reason("new disk");
  order.set_actor("operator ada");
  order.set_unix_s(1.7e9);
  coordinator_.drains = {order};
  const std::string out = Run({"workers"}).out;
  EXPECT_THAT(out, HasSubstr("node1-1  drained"));
  EXPECT_THAT(out, HasSubstr("drained: 'node1-*', since 2023-11-1"));
  EXPECT_THAT(out, HasSubstr("by operator ada: new disk\n"));
  EXPECT_EQ(RunJson({"workers"})["drains"][0]["pattern"], "node1-*");
  EXPECT_EQ(RunJson({"workers"})["workers"][0]["drained_by"], "node1-*");
}

TEST_F(CommandTest, ForgettingAStudyAsksFirst) {
  coordinator_.studies = {Baseline()};
  coordinator_.forgotten.set_jobs(4);
  coordinator_.forgotten.set_pairs(60);
  coordinator_.forgotten.set_results(1);
  const Outcome asked = Run({"forget", "baseline"});
  EXPECT_EQ(asked.exit_code, kExitUsage);
  EXPECT_THAT(asked.err, HasSubstr("study 3 (baseline) with its 60 pairs"));
  EXPECT_THAT(asked.err, HasSubstr("--yes continues anyway"));
  EXPECT_TRUE(coordinator_.orders.empty());
  const Outcome done = Run({"forget", "baseline", "--yes", "--reason", "old"});
  EXPECT_EQ(done.exit_code, kExitOk) << done.err;
  EXPECT_THAT(done.out, HasSubstr("study 3 (baseline) is forgotten: it had 4 jobs, 60 pairs and 1 "
                                  "network or score; "));
  EXPECT_EQ(coordinator_.orders, std::vector<std::string>{"forget 3 old"});
  EXPECT_EQ(RunJson({"forget", "3", "--yes"})["pairs"], 60);
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

}  // namespace
}  // namespace parallax::client
