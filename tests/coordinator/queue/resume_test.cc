// Attempts that go on from what earlier attempts left: which folders stay, and until when; and the
// list of results.
#include <cmath>

#include "coordinator/queue/database_tools.h"
#include "tests/sqlite_by_hand.h"
#include "train_fixture.h"

namespace parallax {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

class Resume : public TrainQueueTest {
 protected:
  Resume() {
    options_.retry.max_app_failures = 2;
    options_.archive_after_s = 100'000;
  }
  StudyId OneTraining(const std::string& name = "study") {
    return SubmitRequest(Request({.name = name, .pairs = 2, .variants = {"wide"}}));
  }
  // Litter beside notes on pairs and a winner's checkpoints, litter as soon as their job is done.
  std::vector<std::string> Litter() {
    clock_.Advance(1);
    auto paths = queue_->ListLitter(0, 0);
    EXPECT_TRUE(paths.ok()) << paths.status();
    if (!paths.ok()) return {};
    std::erase_if(*paths, [](const std::string& path) {
      return path.ends_with("/finished") || path.ends_with("/resume");
    });
    return *paths;
  }
  v1::Lease LeaseAndLose(const std::string& worker) {
    const v1::Lease lease = LeaseOne(Trainer(worker));
    EXPECT_TRUE(queue_->WorkerLost(worker).ok());
    return lease;
  }
};

// Machines that may be taken away at any time: with notice, or without.
TEST_F(Resume, ATrainingIsPreemptedForEverWhileItsStepGrows) {
  const StudyId study = OneTraining();
  MakePairs();
  for (int i = 0; i < 40; ++i) ASSERT_TRUE(queue_->Adopt("w" + std::to_string(i), {}).ok());
  for (int i = 1; i <= 50; ++i) {
    const std::string name = "t" + std::to_string(i);
    const v1::Lease lease = LeaseOne(Trainer(name));
    v1::Progress progress;
    *progress.mutable_attempt() = lease.attempt();
    progress.set_fraction(0.9);
    (*progress.mutable_figures())["step"] = i;
    EXPECT_THAT(queue_->Heartbeat(name, {progress}), IsEmpty());
    clock_.Advance(1);
    if (i % 2 == 0) {
      EXPECT_EQ(*queue_->HandBack(name, lease.attempt(), "preempted"), v1::REPORT_OUTCOME_OK);
    } else {
      EXPECT_EQ(*queue_->WorkerLost(name), 1);
    }
  }
  TrainAll();
  EXPECT_EQ(State(study), v1::STUDY_STATE_SUCCEEDED);
}

TEST_F(Resume, ATrainingThatKillsItsWorkersAtTheSameStepIsQuarantined) {
  const StudyId study = OneTraining();
  MakePairs();
  for (int i = 0; i < 40; ++i) ASSERT_TRUE(queue_->Adopt("w" + std::to_string(i), {}).ok());
  int losses = 0;
  while (State(study) == v1::STUDY_STATE_RUNNING && losses < 20) {
    const std::string name = "t" + std::to_string(++losses);
    const v1::Lease lease = LeaseOne(Trainer(name));
    v1::Progress progress;
    *progress.mutable_attempt() = lease.attempt();
    (*progress.mutable_figures())["step"] = 7;
    EXPECT_THAT(queue_->Heartbeat(name, {progress}), IsEmpty());
    clock_.Advance(1);
    EXPECT_EQ(*queue_->WorkerLost(name), 1);
  }
  EXPECT_EQ(losses, 5);
  EXPECT_THAT(States(study, "train"), ElementsAre("wide, seed 0: QUARANTINED"));
}

TEST_F(Resume, FoldersOfEarlierAttemptsStayUntilTheWorkIsDone) {
  OneTraining();
  MakePairs();
  const v1::Lease lost = LeaseAndLose("a");
  EXPECT_THAT(Litter(), IsEmpty()) << "the next attempt goes on from it";
  const v1::Lease back = LeaseOne(Trainer("b"));
  ASSERT_TRUE(queue_->HandBack("b", back.attempt(), "drained").ok());
  const v1::Lease failed = LeaseOne(Trainer("c"));
  Fail(Failure(failed, "c", "bang"));
  EXPECT_THAT(Litter(), IsEmpty());
  ExpectSound();
  Reopen();
  EXPECT_THAT(Litter(), IsEmpty());
  clock_.Advance(1000);
  Tick();
  const v1::Lease winner = LeaseOne(Trainer("d"));
  EXPECT_EQ(TrainJobOf(winner).resume_folder(), lost.store_prefix());
  Complete(TrainAnswer(winner, "d"));
  EXPECT_THAT(Litter(), testing::UnorderedElementsAre(AttemptFolderOf(lost), AttemptFolderOf(back),
                                                      AttemptFolderOf(failed)));
}

TEST_F(Resume, AFailedTrainingsFoldersWaitForARetry) {
  const StudyId study = OneTraining();
  MakePairs();
  const v1::Lease first = LeaseOne(Trainer("a"));
  Fail(Failure(first, "a", "out of memory", /*retryable=*/false));
  EXPECT_EQ(State(study), v1::STUDY_STATE_FAILED);
  EXPECT_THAT(Litter(), IsEmpty());
  ASSERT_TRUE(queue_->Retry(study, "tester").ok());
  const v1::Lease second = LeaseOne(Trainer("b"));
  EXPECT_EQ(
      TrainJobOf(second).resume_folder() + "/.attempt-" + std::to_string(first.attempt().fence()),
      AttemptFolderOf(first));
  Complete(TrainAnswer(second, "b"));
  EXPECT_THAT(Litter(), ElementsAre(AttemptFolderOf(first)));
}

TEST_F(Resume, ACancelledStudysFoldersAreLitterUnlessAnotherWantsThem) {
  const StudyId one = OneTraining("one");
  const StudyId two = OneTraining("two");
  MakePairs();
  const v1::Lease first = LeaseAndLose("a");
  const v1::Lease second = LeaseOne(Trainer("b"));
  ASSERT_TRUE(queue_->Cancel(one, "", "tester").ok());
  EXPECT_THAT(Litter(), IsEmpty()) << "the other study's training goes on from them";
  ExpectSound();
  ASSERT_TRUE(queue_->Cancel(two, "", "tester").ok());
  EXPECT_THAT(Litter(),
              testing::UnorderedElementsAre(AttemptFolderOf(first), AttemptFolderOf(second)));
}

TEST_F(Resume, FoldersOfWorkThatFailedForGoodGoWithTheArchive) {
  const StudyId study = OneTraining();
  MakePairs();
  const v1::Lease lease = LeaseOne(Trainer("a"));
  Fail(Failure(lease, "a", "bang", /*retryable=*/false));
  Submit({.name = "later", .seed = 9, .pairs = 1});  // The newest job is never archived.
  clock_.Advance(200'000);
  Tick();
  EXPECT_THAT(Litter(), ElementsAre(AttemptFolderOf(lease)));
  EXPECT_EQ(State(study), v1::STUDY_STATE_FAILED);
}

TEST_F(Resume, WhatALateWorkerLeftIsKeptAsLongAsTheRest) {
  OneTraining();
  MakePairs();
  const v1::Lease lost = LeaseAndLose("a");
  EXPECT_EQ(Complete(TrainAnswer(lost, "a")), v1::REPORT_OUTCOME_STALE_FENCE);
  EXPECT_THAT(Litter(), IsEmpty());
  Complete(TrainAnswer(LeaseOne(Trainer("b")), "b"));
  ASSERT_TRUE(queue_->ForgetLitter(Litter()).ok());
  // It writes once more.
  EXPECT_EQ(Complete(TrainAnswer(lost, "a")), v1::REPORT_OUTCOME_STALE_FENCE);
  EXPECT_THAT(Litter(), ElementsAre(AttemptFolderOf(lost)));
}

TEST_F(Resume, KindsThatDoNotResumeLeaveLitterAtOnce) {
  v1::SubmitRequest request = MakeStudy({.pairs = 1});
  request.mutable_study()->mutable_evaluate()->add_benchmarks("shipped");
  request.mutable_study()->mutable_evaluate()->add_baselines("sgbm");
  SubmitRequest(request);
  const v1::Lease lease = LeaseOne(Evaluator("e"));
  ASSERT_TRUE(queue_->WorkerLost("e").ok());
  EXPECT_THAT(Litter(), ElementsAre(AttemptFolderOf(lease)));
}

// ---- What failed programs said
TEST_F(Resume, TheEndOfAFailedProgramsLogIsToldWithTheJob) {
  const StudyId study = OneTraining();
  MakePairs();
  v1::FailRequest failure = Failure(LeaseOne(Trainer("a")), "a", "exit status 3");
  failure.set_log_tail("first\nbad \x1b[31m\nlast\n");
  Fail(failure);
  std::vector<v1::JobStatus> jobs = ListJobs(study, "RETRY_WAIT");
  ASSERT_THAT(jobs, SizeIs(1));
  EXPECT_EQ(jobs[0].label(), "wide, seed 0");
  EXPECT_EQ(jobs[0].log_tail(), "first\nbad \\x1b[31m\nlast\n");
  clock_.Advance(1000);
  Tick();
  // A newer failure's takes its place; a long log loses its beginning, at the end of a line.
  failure = Failure(LeaseOne(Trainer("b")), "b", "exit status 4");
  std::string log = "gone\n";
  for (int i = 0; i < 1000; ++i) log += "line " + std::to_string(i) + " of many more lines\n";
  failure.set_log_tail(log);
  Fail(failure);
  jobs = ListJobs(study, "FAILED");
  ASSERT_THAT(jobs, SizeIs(1));
  EXPECT_LE(jobs[0].log_tail().size(), 16'000u);
  EXPECT_GT(jobs[0].log_tail().size(), 15'000u);
  EXPECT_EQ(jobs[0].log_tail().rfind("line ", 0), 0u);
  EXPECT_THAT(jobs[0].log_tail(), testing::EndsWith("line 999 of many more lines\n"));
  // In the archive too.
  Submit({.name = "later", .seed = 9, .pairs = 1});
  clock_.Advance(200'000);
  Tick();
  jobs = ListJobs(study, "FAILED");
  ASSERT_THAT(jobs, SizeIs(1));
  EXPECT_THAT(jobs[0].log_tail(), testing::EndsWith("line 999 of many more lines\n"));
}

TEST_F(Resume, FiguresOfTheNewestHeartbeatAreToldWithTheJob) {
  const StudyId study = OneTraining();
  MakePairs();
  const v1::Lease lease = LeaseOne(Trainer("a"));
  v1::Progress progress;
  *progress.mutable_attempt() = lease.attempt();
  progress.set_fraction(0.25);
  progress.set_stage("train");
  (*progress.mutable_figures())["loss"] = 1.5;
  EXPECT_THAT(queue_->Heartbeat("a", {progress}), IsEmpty());
  (*progress.mutable_figures())["loss"] = 1.25;
  (*progress.mutable_figures())["odd"] = std::nan("");
  EXPECT_THAT(queue_->Heartbeat("a", {progress}), IsEmpty());
  const std::vector<v1::JobStatus> jobs = ListJobs(study, "LEASED");
  ASSERT_THAT(jobs, SizeIs(1));
  EXPECT_EQ(jobs[0].figures().at("loss"), 1.25);
  EXPECT_THAT(jobs[0].figures(), SizeIs(1)) << "without what is no number";
  const auto running = queue_->ListRunning();
  ASSERT_TRUE(running.ok()) << running.status();
  ASSERT_THAT(*running, SizeIs(1));
  EXPECT_EQ((*running)[0].study, "study");
  EXPECT_EQ((*running)[0].kind, "train");
  EXPECT_EQ((*running)[0].label, "wide, seed 0");
  EXPECT_EQ((*running)[0].figures.at("loss"), 1.25);
  Complete(TrainAnswer(lease, "a"));
  EXPECT_THAT(*queue_->ListRunning(), IsEmpty());
}

// ---- Results
class Results : public TrainQueueTest {
 protected:
  std::vector<v1::JobResult> List(StudyId study, int64_t cursor = 0, int limit = 0) {
    v1::ListResultsRequest request;
    request.set_study_id(study.value);
    request.set_cursor(cursor);
    request.set_limit(limit);
    auto results = queue_->ListResults(request);
    EXPECT_TRUE(results.ok()) << results.status();
    return results.ok() ? *results : std::vector<v1::JobResult>();
  }
  static v1::SubmitRequest TwoSeeds(const std::string& name) {
    v1::SubmitRequest request = Request({.name = name, .pairs = 2, .variants = {"wide"}});
    request.mutable_study()->mutable_train()->set_seeds(2);
    request.mutable_study()->mutable_evaluate()->add_benchmarks("shipped");
    return request;
  }
};

TEST_F(Results, AreListedInTheOrderOfTheirEndsPageByPage) {
  const StudyId study = SubmitRequest(TwoSeeds("first"));
  EXPECT_THAT(List(study), IsEmpty());
  MakePairs();
  const auto trainings = Lease(Trainer("t"), 2);
  ASSERT_THAT(trainings, SizeIs(2));
  Complete(TrainAnswer(trainings[1], "t"));
  Complete(TrainAnswer(trainings[0], "t"));
  EvaluateAll();
  std::vector<std::string> labels;
  int64_t cursor = 0;
  for (;;) {
    const auto page = List(study, cursor, 1);
    if (page.empty()) break;
    ASSERT_THAT(page, SizeIs(1));
    EXPECT_GT(page[0].cursor(), cursor);
    cursor = page[0].cursor();
    labels.push_back(page[0].kind() + " " + page[0].label());
    EXPECT_EQ(page[0].variant(), "wide");
    EXPECT_THAT(page[0].files(), SizeIs(1));
    EXPECT_THAT(page[0].path(), HasSubstr("/.attempt-"));
  }
  EXPECT_THAT(labels,
              ElementsAre("train wide, seed 1", "train wide, seed 0",
                          "evaluate wide, seed 0 on shipped", "evaluate wide, seed 1 on shipped"));
  EXPECT_EQ(List(study)[0].path(), AttemptFolderOf(trainings[1]));
  EXPECT_EQ(List(study)[0].files(0).name(), "step-100.pt");
}

TEST_F(Results, ThatAreReusedAreListedWithTheStudyThatReusesThem) {
  const StudyId first = SubmitRequest(TwoSeeds("first"));
  MakePairs();
  TrainAll();
  EvaluateAll();
  const StudyId second = SubmitRequest(TwoSeeds("second"));
  ASSERT_THAT(List(second), SizeIs(4));
  EXPECT_EQ(List(second)[0].path(), List(first)[0].path());
  EXPECT_NE(List(second)[0].job_id(), List(first)[0].job_id());
}

TEST_F(Results, OfAnArchivedStudyAreStillListed) {
  options_.archive_after_s = 100;
  Reopen();
  const StudyId study = SubmitRequest(TwoSeeds("first"));
  MakePairs();
  TrainAll();
  EvaluateAll();
  Submit({.name = "later", .seed = 9, .pairs = 1});
  clock_.Advance(200);
  Tick();
  EXPECT_GT(queue_->Stats().archived_jobs, 0u);
  EXPECT_THAT(List(study), SizeIs(4));
}

// ---- The auditor
TEST_F(Resume, TheAuditorFindsEveryBrokenPromise) {
  v1::SubmitRequest request = Request({.pairs = 2, .variants = {"wide"}});
  request.mutable_study()->mutable_train()->set_seeds(3);
  request.mutable_study()->mutable_evaluate()->add_benchmarks("shipped");
  SubmitRequest(request);
  MakePairs();
  Complete(TrainAnswer(LeaseOne(Trainer("a")), "a"));
  LeaseAndLose("b");
  EvaluateAll();
  ExpectSound();
  queue_.reset();
  const std::string original = options_.db_path;
  const struct {
    const char* sql;
    const char* found;
  } cases[] = {
      {"UPDATE kept_folders SET work_key = (SELECT work_key FROM jobs WHERE kind = 'train'"
       " AND state = 'SUCCEEDED')",
       "a folder is kept only while its work is wanted"},
      {"UPDATE kept_folders SET work_key = x'00'", "a folder is kept only while its work is"},
      {"INSERT INTO litter SELECT path, 1 FROM kept_folders", "that is kept is not litter"},
      {"DELETE FROM study_results WHERE cursor = 1", "a study lists the results"},
      {"UPDATE study_results SET work_key = (SELECT max(work_key) FROM results)"
       " WHERE cursor = 1; UPDATE study_results SET work_key = (SELECT min(work_key) FROM"
       " results) WHERE cursor = 2",
       "a study lists the results"},
      {"UPDATE results SET stage = 'evaluate' WHERE stage = 'train'",
       "a trained network has its result"},
      {"UPDATE results SET stage = 'train' WHERE stage = 'evaluate'",
       "an evaluation has its result"},
      {"UPDATE results SET fence = fence + 1 WHERE stage = 'train'",
       "a result lies in the winner's folder"},
      {"INSERT INTO litter SELECT lower(substr(hex(work_key), 1, 2)) || '/' || lower(hex(work_key))"
       " || '/.attempt-' || fence, 1 FROM results WHERE stage = 'train'",
       "a published result is not litter"},
      {"UPDATE waits SET state = 'OPEN' WHERE on_variant IS NOT NULL",
       "a training began when its pairs were there"},
      {"UPDATE jobs SET state = 'FAILED' WHERE kind = 'train' AND state = 'SUCCEEDED'",
       "an evaluation began when its network was trained"},
  };
  for (const auto& c : cases) {
    options_.db_path = dir_ + "/planted.db";
    std::filesystem::copy_file(original, options_.db_path,
                               std::filesystem::copy_options::overwrite_existing);
    sqlite3* db = OpenByHand(options_.db_path);
    ASSERT_NE(db, nullptr);
    const std::string sql = std::string(
                                "PRAGMA ignore_check_constraints = ON; DROP TRIGGER waits_move;"
                                "DROP TRIGGER jobs_move; DROP TRIGGER results_are_final;"
                                "DROP TRIGGER study_results_are_final;") +
                            c.sql;
    char* error = nullptr;
    EXPECT_EQ(sqlite3_exec(db, sql.c_str(), nullptr, nullptr, &error), SQLITE_OK) << error;
    sqlite3_close(db);
    const auto violations = AuditDatabaseFile(options_.db_path);
    ASSERT_TRUE(violations.ok()) << violations.status();
    EXPECT_THAT(*violations, Contains(HasSubstr(c.found))) << c.sql;
  }
}

}  // namespace
}  // namespace parallax
