// Jobs that wait for other jobs or for a variant's pairs, by the kind `noop`.
#include "coordinator/queue/database_tools.h"
#include "tests/coordinator/queue/queue_fixture.h"
#include "tests/noop/noop_kind.h"
#include "tests/sqlite_by_hand.h"

namespace parallax {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

// The plan of the study at hand.
NoopKind::Plan plan;

class WaitsTest : public QueueTest {
 protected:
  WaitsTest()
      : kind_([](WorkDesk& desk, const v1::StudySpec& study, std::span<const int64_t> variants) {
          return plan ? plan(desk, study, variants) : absl::OkStatus();
        }),
        kinds_(KindRegistry::Builtin().With(kind_)) {
    options_.kinds = &kinds_;
    options_.retry.max_app_failures = 1;
    plan = NoopKind::AfterPairs;
  }
  ~WaitsTest() override { queue_.reset(); }

  static WorkerFacts Everything(const std::string& name) {
    return {.name = name, .kinds = {"solve", "render", "noop"}, .memory_mb = 8000};
  }
  static WorkerFacts Idler(const std::string& name) { return {.name = name, .kinds = {"noop"}}; }
  static v1::CompleteRequest NoopAnswer(const v1::Lease& lease, const std::string& worker,
                                        const std::string& result = "done") {
    v1::CompleteRequest request;
    *request.mutable_attempt() = lease.attempt();
    request.set_worker(worker);
    request.set_kind("noop");
    request.set_result(result);
    return request;
  }
  // Does everything but noop jobs.
  void MakePairs() { WorkOff(AnyWorker("w")); }
  std::vector<std::string> Noops(StudyId study) {
    std::vector<std::string> states;
    std::vector<v1::JobStatus> jobs = ListJobs(study);
    std::sort(jobs.begin(), jobs.end(),
              [](const auto& a, const auto& b) { return a.job_id() < b.job_id(); });
    for (const v1::JobStatus& job : jobs) {
      if (job.kind() == "noop") states.push_back(job.state());
    }
    return states;
  }
  std::string ErrorOf(StudyId study, const std::string& state) {
    for (const v1::JobStatus& job : ListJobs(study, state)) {
      if (job.kind() == "noop") return job.error();
    }
    return "no such";
  }
  v1::StudyState State(StudyId study) { return Status(study).state(); }

  const NoopKind kind_;
  const KindRegistry kinds_;
};

TEST_F(WaitsTest, AJobThatNoWorkerCanBeToldOfFails) {
  plan = [](WorkDesk& desk, const v1::StudySpec&, std::span<const int64_t> variants) {
    return desk.AddJob({.kind = "noop", .variant = variants[0], .input = "?"}).status();
  };
  const StudyId study = Submit();
  EXPECT_THAT(Lease(Idler("w")), testing::IsEmpty());
  Tick();
  EXPECT_THAT(Noops(study), ElementsAre("FAILED"));
  EXPECT_EQ(ErrorOf(study, "FAILED"),
            "its worker can't be told what to do: an input without meaning");
}

TEST_F(WaitsTest, AJobIsReadyWhenTheVariantHasItsPairsAndNotBefore) {
  const StudyId study = Submit({.pairs = 4, .rigs_per_scene = 2});
  EXPECT_THAT(Noops(study), ElementsAre("BLOCKED", "BLOCKED"));
  // All but the last scene's pairs.
  std::vector<v1::Lease> renders;
  for (const v1::Lease& solve : Lease(Solver("w"), 8)) Complete(Answer(solve, "w"));
  renders = Lease(Renderer("w"), 8);
  ASSERT_EQ(renders.size(), 2u);
  Complete(Answer(renders[0], "w"));
  EXPECT_THAT(Noops(study), ElementsAre("BLOCKED", "BLOCKED"));
  EXPECT_TRUE(Lease(Idler("i"), 4).empty());
  ExpectSound();
  Complete(Answer(renders[1], "w"));
  EXPECT_THAT(Noops(study), ElementsAre("READY", "BLOCKED"));
  EXPECT_EQ(State(study), v1::STUDY_STATE_RUNNING) << "its noop jobs are still to be done";
  const v1::Lease first = LeaseOne(Idler("i"));
  EXPECT_EQ(first.kind(), "noop");
  EXPECT_EQ(first.spec(), "study/only of 4") << "all pairs are published when it starts";
  EXPECT_EQ(first.store_prefix(), "");
  EXPECT_EQ(Complete(NoopAnswer(first, "i")), v1::REPORT_OUTCOME_OK);
  EXPECT_THAT(Noops(study), ElementsAre("SUCCEEDED", "READY"));
  Complete(NoopAnswer(LeaseOne(Idler("i")), "i"));
  EXPECT_EQ(State(study), v1::STUDY_STATE_SUCCEEDED);
}

TEST_F(WaitsTest, EachWaitsForAsManyPairsAsItAsksAndForTheLastOfItsJobs) {
  plan = [](WorkDesk& desk, const v1::StudySpec&, std::span<const int64_t> own) -> absl::Status {
    ASSIGN_OR_RETURN(const int64_t early, desk.AddJob({.kind = "noop",
                                                       .variant = own[0],
                                                       .ordinal = 0,
                                                       .input = "early",
                                                       .waits = {JobWait::OnPairs(own[0], 2)}}));
    ASSIGN_OR_RETURN(const int64_t late, desk.AddJob({.kind = "noop",
                                                      .variant = own[0],
                                                      .ordinal = 1,
                                                      .input = "late",
                                                      .waits = {JobWait::OnPairs(own[0], 4)}}));
    return desk
        .AddJob({.kind = "noop",
                 .variant = own[0],
                 .ordinal = 2,
                 .input = "both",
                 .waits = {JobWait::OnJob(early), JobWait::OnJob(late)}})
        .status();
  };
  const StudyId study = Submit({.pairs = 4, .rigs_per_scene = 2});
  for (const v1::Lease& solve : Lease(Solver("w"), 8)) Complete(Answer(solve, "w"));
  const std::vector<v1::Lease> renders = Lease(Renderer("w"), 8);
  ASSERT_EQ(renders.size(), 2u);
  Complete(Answer(renders[0], "w"));
  EXPECT_THAT(Noops(study), ElementsAre("READY", "BLOCKED", "BLOCKED"));
  ExpectSound();
  Complete(NoopAnswer(LeaseOne(Idler("i")), "i"));
  EXPECT_THAT(Noops(study), ElementsAre("SUCCEEDED", "BLOCKED", "BLOCKED"));
  ExpectSound();
  Complete(Answer(renders[1], "w"));
  EXPECT_THAT(Noops(study), ElementsAre("SUCCEEDED", "READY", "BLOCKED"));
  Complete(NoopAnswer(LeaseOne(Idler("i")), "i"));
  EXPECT_THAT(Noops(study), ElementsAre("SUCCEEDED", "SUCCEEDED", "READY"));
}

TEST_F(WaitsTest, WaitsOutliveARestart) {
  const StudyId study = Submit({.pairs = 2, .rigs_per_scene = 1});
  Reopen();
  MakePairs();
  EXPECT_THAT(Noops(study), ElementsAre("READY", "BLOCKED"));
  Reopen();
  Complete(NoopAnswer(LeaseOne(Idler("i")), "i"));
  EXPECT_THAT(Noops(study), ElementsAre("SUCCEEDED", "READY"));
}

TEST_F(WaitsTest, WhatIsThereAlreadyIsNotWaitedFor) {
  plan = nullptr;
  Submit({.name = "first", .pairs = 2});
  MakePairs();
  // The same pairs: reused at once, in the command that makes the scenes.
  plan = NoopKind::AfterPairs;
  const StudyId study = Submit({.name = "second", .pairs = 2});
  EXPECT_THAT(Noops(study), ElementsAre("READY", "BLOCKED"));
}

TEST_F(WaitsTest, ARejectedOrFailedJobCancelsItsWaitersAndTheStudyFails) {
  const struct {
    const char* state;
    std::function<void(const v1::Lease&)> end;
  } cases[] = {
      {"REJECTED", [&](const v1::Lease& lease) { Complete(NoopAnswer(lease, "i", "")); }},
      {"FAILED", [&](const v1::Lease& lease) { Fail(Failure(lease, "i", "bang", false)); }},
      {"FAILED",  // By a result that is none.
       [&](const v1::Lease& lease) {
         EXPECT_EQ(queue_->Complete(NoopAnswer(lease, "i", "!")).status().code(),
                   absl::StatusCode::kInvalidArgument);
       }},
  };
  for (const auto& c : cases) {
    static int number = 0;
    const StudyId study = Submit({.name = "s" + std::to_string(number++), .pairs = 2});
    MakePairs();
    c.end(LeaseOne(Idler("i")));
    EXPECT_THAT(Noops(study), ElementsAre(c.state, "CANCELLED"));
    EXPECT_THAT(ErrorOf(study, "CANCELLED"), HasSubstr(std::string("is ") + c.state));
    EXPECT_EQ(State(study), v1::STUDY_STATE_FAILED) << "although it has all its pairs";
    ExpectSound();
  }
}

TEST_F(WaitsTest, AQuarantinedJobCancelsItsWaiters) {
  options_.retry.max_app_failures = 5;
  Reopen();
  const StudyId study = Submit({.pairs = 2});
  MakePairs();
  Fail(Failure(LeaseOne(Idler("i")), "i", "bang"));
  clock_.Advance(700);
  Tick();
  Fail(Failure(LeaseOne(Idler("j")), "j", "bang"));
  EXPECT_THAT(Noops(study), ElementsAre("QUARANTINED", "CANCELLED"));
}

TEST_F(WaitsTest, AnAttemptThatIsLostKeepsItsWaiters) {
  const StudyId study = Submit({.pairs = 2});
  MakePairs();
  LeaseOne(Idler("i"));
  EXPECT_EQ(*queue_->WorkerLost("i"), 1);
  EXPECT_THAT(Noops(study), ElementsAre("READY", "BLOCKED"));
  Complete(NoopAnswer(LeaseOne(Idler("j")), "j"));
  EXPECT_THAT(Noops(study), ElementsAre("SUCCEEDED", "READY"));
}

TEST_F(WaitsTest, AReusedResultReleasesItsWaiters) {
  // Two studies with one name ask for equal noop work.
  const StudyId first = Submit({.pairs = 2, .key = "a"});
  const StudyId second = Submit({.pairs = 2, .key = "b"});
  MakePairs();
  const v1::Lease lease = LeaseOne(Idler("i"));
  EXPECT_TRUE(Lease(Idler("j"), 4).empty()) << "equal work is done once";
  Complete(NoopAnswer(lease, "i"));
  EXPECT_EQ(Jobs(first, "noop", "SUCCEEDED") + Jobs(second, "noop", "SUCCEEDED"), 2);
  Complete(NoopAnswer(LeaseOne(Idler("i")), "i"));
  EXPECT_EQ(State(first), v1::STUDY_STATE_SUCCEEDED);
  EXPECT_EQ(State(second), v1::STUDY_STATE_SUCCEEDED);
}

TEST_F(WaitsTest, AVariantThatGivesUpOrIsCancelledCancelsWhoWaitsForItsPairs) {
  // The waiter belongs to another study, because jobs of the variant's own study end with it.
  const StudyId source = Submit({.name = "source", .pairs = 8, .rigs_per_scene = 1});
  int64_t variant = 0;
  plan = [&](WorkDesk& desk, const v1::StudySpec&, std::span<const int64_t> own) -> absl::Status {
    variant = own[0] - 1;
    return desk
        .AddJob({.kind = "noop",
                 .variant = own[0],
                 .input = "x",
                 .waits = {JobWait::OnPairs(variant, 3), JobWait::OnPairs(own[0], 1)}})
        .status();
  };
  const StudyId study = Submit({.name = "waiter", .seed = 2, .pairs = 1, .rigs_per_scene = 1});
  ASSERT_TRUE(queue_->Cancel(source, "enough", "tester").ok());
  EXPECT_THAT(Noops(study), ElementsAre("CANCELLED"));
  EXPECT_THAT(ErrorOf(study, "CANCELLED"), HasSubstr("source"));
}

TEST_F(WaitsTest, AVariantThatFindsNoSceneCancelsWhoWaitsForItsPairs) {
  plan = nullptr;
  const StudyId source = Submit({.name = "source", .pairs = 8, .rigs_per_scene = 1, .priority = 1});
  plan = [](WorkDesk& desk, const v1::StudySpec&, std::span<const int64_t> own) {
    return desk
        .AddJob({.kind = "noop",
                 .variant = own[0],
                 .input = "x",
                 .waits = {JobWait::OnPairs(own[0] - 1, 3)}})
        .status();
  };
  const StudyId study = Submit({.name = "waiter", .seed = 2, .pairs = 1, .rigs_per_scene = 1});
  for (int i = 0; i < 200 && State(source) == v1::STUDY_STATE_RUNNING; ++i) {
    EXPECT_THAT(Noops(study), ElementsAre("BLOCKED"));
    Complete(RejectAnswer(LeaseOne(Solver("w")), "w", /*with_layout=*/false));
  }
  EXPECT_EQ(State(source), v1::STUDY_STATE_FAILED);
  EXPECT_THAT(Noops(study), ElementsAre("CANCELLED"));
  EXPECT_THAT(ErrorOf(study, "CANCELLED"), HasSubstr("gave up"));
}

TEST_F(WaitsTest, ARetryWaitsAnewForTheNewestGenerations) {
  const StudyId study = Submit({.pairs = 2});
  MakePairs();
  Fail(Failure(LeaseOne(Idler("i")), "i", "bang", false));
  EXPECT_THAT(Noops(study), ElementsAre("FAILED", "CANCELLED"));
  EXPECT_EQ(*queue_->Retry(study, "tester"), 2);
  EXPECT_THAT(Noops(study), ElementsAre("FAILED", "CANCELLED", "READY", "BLOCKED"));
  ExpectSound();
  Complete(NoopAnswer(LeaseOne(Idler("j")), "j"));
  Complete(NoopAnswer(LeaseOne(Idler("j")), "j"));
  EXPECT_THAT(Noops(study), ElementsAre("FAILED", "CANCELLED", "SUCCEEDED", "SUCCEEDED"));
  EXPECT_EQ(State(study), v1::STUDY_STATE_SUCCEEDED);
}

TEST_F(WaitsTest, ACancelledStudyLeavesNoWaits) {
  const StudyId study = Submit({.pairs = 2});
  ASSERT_TRUE(queue_->Cancel(study, "", "tester").ok());
  EXPECT_THAT(Noops(study), ElementsAre("CANCELLED", "CANCELLED"));
}

TEST_F(WaitsTest, AWaitThatCanNeverEndIsRefusedWithItsStudy) {
  plan = [](WorkDesk& desk, const v1::StudySpec&, std::span<const int64_t> variants) {
    return desk
        .AddJob({.kind = "noop",
                 .variant = variants[0],
                 .waits = {JobWait::OnPairs(variants[0], 1000)}})
        .status();
  };
  const auto reply = queue_->Submit(MakeStudy({.pairs = 2}), "tester");
  EXPECT_EQ(reply.status().code(), absl::StatusCode::kInvalidArgument) << reply.status();
  EXPECT_THAT(std::string(reply.status().message()), HasSubstr("which is to have 2"));
  EXPECT_TRUE(queue_->ListStudies(10)->empty()) << "the whole command is undone";
}

TEST_F(WaitsTest, AnUnknownKindIsAnErrorEverywhere) {
  plan = nullptr;
  const StudyId study = Submit({.pairs = 2});
  EXPECT_EQ(queue_->Lease({.name = "w", .kinds = {"bake"}}, 1).status().code(),
            absl::StatusCode::kNotFound);
  v1::CompleteRequest report = Answer(LeaseOne(Solver("w")), "w");
  report.set_kind("bake");
  const auto outcome = queue_->Complete(report);
  EXPECT_EQ(outcome.status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(
      std::string(outcome.status().message()),
      HasSubstr("unknown kind of job 'bake'; there are: solve, render, train, evaluate, noop"));
  plan = [](WorkDesk& desk, const v1::StudySpec&, std::span<const int64_t> variants) {
    return desk.AddJob({.kind = "bake", .variant = variants[0]}).status();
  };
  EXPECT_EQ(queue_->Submit(MakeStudy({.name = "b"}), "t").status().code(),
            absl::StatusCode::kNotFound);
  (void)study;
}

TEST_F(WaitsTest, ADatabaseWithJobsOfAnotherProgramsKindIsRefused) {
  Submit({.pairs = 2});
  queue_.reset();
  options_.kinds = &KindRegistry::Builtin();
  const auto queue = JobQueue::Open(options_);
  EXPECT_EQ(queue.status().code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(std::string(queue.status().message()), HasSubstr("jobs of kind 'noop'"));
}

// Each broken in the file, behind the queue's back.
TEST_F(WaitsTest, TheAuditorFindsEveryBrokenWait) {
  const StudyId study = Submit({.pairs = 2});
  MakePairs();
  Submit({.name = "other", .seed = 5, .pairs = 2});
  Complete(NoopAnswer(LeaseOne(Idler("i")), "i"));
  (void)study;
  ExpectSound();
  queue_.reset();
  const std::string original = options_.db_path;
  const struct {
    const char* sql;
    const char* found;
  } cases[] = {
      {"UPDATE waits SET state = 'OPEN' WHERE on_job IS NOT NULL", "is over when the job"},
      {"UPDATE waits SET state = 'OPEN' WHERE on_variant = 1", "is over when the variant"},
      {"UPDATE waits SET state = 'MET' WHERE state = 'OPEN'", "a job counts its open waits"},
      {"UPDATE waits SET state = 'MET' WHERE on_variant = 2", "was for what has happened"},
      {"DELETE FROM waits WHERE state = 'OPEN'", "a job counts its open waits"},
      {"UPDATE jobs SET waits_open = 0 WHERE waits_open > 0", "a job counts its open waits"},
      {"UPDATE jobs SET waits_open = 1, state = 'READY' WHERE waits_open = 1",
       "only blocked jobs wait"},
      {"UPDATE waits SET state = 'DROPPED' WHERE on_variant = 1", "waited in vain was never"},
      {"UPDATE variants SET others_lost = 3", "lost jobs outside of scenes"},
  };
  for (const auto& c : cases) {
    options_.db_path = dir_ + "/planted.db";
    std::filesystem::copy_file(original, options_.db_path,
                               std::filesystem::copy_options::overwrite_existing);
    sqlite3* db = OpenByHand(options_.db_path);
    ASSERT_NE(db, nullptr);
    const std::string sql = std::string(
                                "PRAGMA ignore_check_constraints = ON;"
                                "DROP TRIGGER waits_move; DROP TRIGGER jobs_move;") +
                            c.sql;
    char* error = nullptr;
    EXPECT_EQ(sqlite3_exec(db, sql.c_str(), nullptr, nullptr, &error), SQLITE_OK) << error;
    sqlite3_close(db);
    const auto violations = AuditDatabaseFile(options_.db_path);
    ASSERT_TRUE(violations.ok()) << violations.status();
    EXPECT_THAT(*violations, testing::Contains(HasSubstr(c.found))) << c.sql;
  }
}

TEST_F(WaitsTest, AJobThatNoWorkerCanBeToldOfFailsAlsoWhenATickIsUndone) {
  FailingCommand failing(options_);
  Reopen();
  plan = [](WorkDesk& desk, const v1::StudySpec&, std::span<const int64_t> variants) {
    return desk.AddJob({.kind = "noop", .variant = variants[0], .input = "?"}).status();
  };
  const StudyId study = Submit();
  EXPECT_THAT(Lease(Idler("w")), testing::IsEmpty());
  for (const char* command : {"tick", "settle"}) {  // The command alone, and its whole group.
    failing.Set(command);
    EXPECT_FALSE(queue_->Tick().ok());
  }
  failing.Clear();
  Tick();
  EXPECT_THAT(Noops(study), ElementsAre("FAILED"));
  Tick();
  EXPECT_EQ(queue_->Stats().failures, 1u);
}

}  // namespace
}  // namespace parallax
