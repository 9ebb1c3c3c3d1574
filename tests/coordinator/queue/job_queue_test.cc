// A study's way through the queue: leases, results, fences.
#include "coordinator/queue/job_queue.h"

#include <map>
#include <set>

#include "queue_fixture.h"

namespace parallax {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

class JobQueueTest : public QueueTest {};

TEST_F(JobQueueTest, AStudyIsSolvedRenderedAndPublished) {
  const StudyId study = Submit({.pairs = 5, .rigs_per_scene = 2});
  EXPECT_EQ(Status(study).state(), v1::STUDY_STATE_RUNNING);
  EXPECT_EQ(WorkOff(AnyWorker("w")), 6);  // Three solves, three renders.
  const v1::StudyStatus status = Status(study);
  EXPECT_EQ(status.state(), v1::STUDY_STATE_SUCCEEDED);
  EXPECT_GT(status.finished_unix_s(), 0);
  EXPECT_EQ(status.spec().pairs(), 5);
  ASSERT_THAT(status.variants(), SizeIs(1));
  EXPECT_EQ(status.variants(0).pairs_done(), 5);
  EXPECT_EQ(JobsOf(status.variants(0), "solve", "SUCCEEDED"), 3);
  EXPECT_EQ(JobsOf(status.variants(0), "render", "SUCCEEDED"), 3);

  const auto frames = Frames(study);
  std::set<std::pair<uint32_t, uint32_t>> pairs;
  for (const v1::PublishedFrame& frame : frames) {
    pairs.insert({frame.scene(), frame.frame().rig()});
    EXPECT_FALSE(frame.reused());
    EXPECT_EQ(frame.frame().files(1).name(), "left.png");
  }
  EXPECT_EQ(pairs,
            (std::set<std::pair<uint32_t, uint32_t>>{{0, 0}, {0, 1}, {1, 0}, {1, 1}, {2, 0}}));
}

TEST_F(JobQueueTest, ASolvedSceneHasItsRenderJobAtOnce) {
  const StudyId study = Submit({.pairs = 2, .rigs_per_scene = 2});
  const v1::Lease solve = LeaseOne(AnyWorker("w"));
  EXPECT_EQ(solve.kind(), "solve");
  EXPECT_EQ(solve.attempt_number(), 1);
  EXPECT_EQ(Complete(SolveAnswer(solve, "w")), v1::REPORT_OUTCOME_OK);
  EXPECT_EQ(Jobs(study, "render", "READY"), 1);
  const v1::Lease render = LeaseOne(AnyWorker("w"));
  EXPECT_EQ(render.kind(), "render");
  EXPECT_EQ(RenderOf(render).scene().SerializeAsString(),
            SolveOf(SolveAnswer(solve, "w")).scene().SerializeAsString());
  EXPECT_THAT(RenderOf(render).rigs(), testing::ElementsAre(0, 1));
  EXPECT_EQ(RenderOf(render).render().samples_per_pixel(), 4);

  v1::GetSceneRequest request;
  request.set_study_id(study.value);
  request.set_variant("only");
  request.set_scene(0);
  const auto scene = queue_->GetScene(request);
  ASSERT_TRUE(scene.ok()) << scene.status();
  EXPECT_EQ(scene->scene_seed(), SolveOf(solve).scene_seed());
  request.set_scene(1);
  EXPECT_EQ(queue_->GetScene(request).status().code(), absl::StatusCode::kNotFound);
}

TEST_F(JobQueueTest, VariantsOfAStudyHaveTheSameSceneSeeds) {
  Submit({.pairs = 4, .variants = {"a", "b"}});
  std::map<uint32_t, std::set<uint64_t>> seeds;
  // The second variant's scenes wait for the first's layouts.
  for (int round = 0; round < 2; ++round) {
    for (const v1::Lease& lease : Lease(Solver("w"), 100)) {
      seeds[lease.scene()].insert(SolveOf(lease).scene_seed());
      Complete(SolveAnswer(lease, "w"));
    }
  }
  EXPECT_THAT(seeds, SizeIs(2));
  for (const auto& [scene, values] : seeds) EXPECT_THAT(values, SizeIs(1)) << scene;
}

// ---- Fences
TEST_F(JobQueueTest, ARepeatedReportIsAlreadyDone) {
  Submit();
  const v1::Lease lease = LeaseOne(AnyWorker("w"));
  EXPECT_EQ(Complete(Answer(lease, "w")), v1::REPORT_OUTCOME_OK);
  EXPECT_EQ(Complete(Answer(lease, "w")), v1::REPORT_OUTCOME_ALREADY_DONE);
  const v1::Lease other = LeaseOne(AnyWorker("w"));
  EXPECT_EQ(Fail(Failure(other, "w", "boom")), v1::REPORT_OUTCOME_OK);
  EXPECT_EQ(Fail(Failure(other, "w", "boom")), v1::REPORT_OUTCOME_ALREADY_DONE);
}

TEST_F(JobQueueTest, ALateReportIsFenced) {
  Submit({.pairs = 2});
  const v1::Lease zombie = LeaseOne(AnyWorker("zombie"));
  clock_.Advance(31);
  Tick();
  const v1::Lease second = LeaseOne(AnyWorker("w"));
  EXPECT_EQ(second.attempt().job_id(), zombie.attempt().job_id());
  EXPECT_GT(second.attempt().fence(), zombie.attempt().fence());
  EXPECT_EQ(second.attempt_number(), 2);
  EXPECT_EQ(Complete(Answer(zombie, "zombie")), v1::REPORT_OUTCOME_STALE_FENCE);
  EXPECT_EQ(Complete(Answer(second, "w")), v1::REPORT_OUTCOME_OK);
  EXPECT_EQ(Complete(Answer(zombie, "zombie")), v1::REPORT_OUTCOME_STALE_FENCE);
  EXPECT_EQ(Fail(Failure(zombie, "zombie", "x")), v1::REPORT_OUTCOME_STALE_FENCE);
  EXPECT_EQ(queue_->Stats().stale_reports, 3u);
}

TEST_F(JobQueueTest, AnUnknownJobIsFenced) {
  v1::FailRequest request;
  request.mutable_attempt()->set_job_id(4711);
  request.mutable_attempt()->set_fence(1);
  EXPECT_EQ(Fail(request), v1::REPORT_OUTCOME_STALE_FENCE);
  v1::CompleteRequest complete;
  *complete.mutable_attempt() = request.attempt();
  EXPECT_EQ(Complete(complete), v1::REPORT_OUTCOME_STALE_FENCE);
}

TEST_F(JobQueueTest, EachStartHasAHigherEpoch) {
  const uint64_t first = queue_->epoch();
  Submit({.pairs = 10});
  EXPECT_EQ(LeaseOne(AnyWorker("w")).attempt().fence() >> 32, first);
  Reopen();
  EXPECT_GT(queue_->epoch(), first);
  EXPECT_EQ(LeaseOne(AnyWorker("v")).attempt().fence() >> 32, queue_->epoch());
}

TEST_F(JobQueueTest, ARestoredBackupStartsAboveTheEpochsItDoesNotKnow) {
  const std::string backup = dir_ + "/backup.db";
  ASSERT_TRUE(queue_->Backup(backup).ok());
  clock_.Advance(60);
  Reopen();
  const uint64_t later = queue_->epoch();
  clock_.Advance(60);
  options_.db_path = backup;
  Reopen();
  EXPECT_GT(queue_->epoch(), later);
}

// ---- Leases
TEST_F(JobQueueTest, ExpiredLeaseReturnsJobToReady) {
  const StudyId study = Submit({.pairs = 2});
  LeaseOne(AnyWorker("w"));
  clock_.Advance(29);
  Tick();
  EXPECT_EQ(Jobs(study, "solve", "LEASED"), 1);
  clock_.Advance(1);
  Tick();
  EXPECT_EQ(Jobs(study, "solve", "READY"), 1);
}

TEST_F(JobQueueTest, HeartbeatsKeepALeaseAndNameWhatMustStop) {
  const StudyId study = Submit({.pairs = 2});
  const v1::Lease lease = LeaseOne(AnyWorker("w"));
  v1::Progress progress;
  *progress.mutable_attempt() = lease.attempt();
  progress.set_fraction(0.25);
  progress.set_stage("layout");
  for (int i = 0; i < 5; ++i) {
    clock_.Advance(20);
    EXPECT_THAT(queue_->Heartbeat("w", {progress}), IsEmpty());
    Tick();
  }
  EXPECT_EQ(Jobs(study, "solve", "LEASED"), 1);
  const auto jobs = ListJobs(study, "LEASED");
  ASSERT_THAT(jobs, SizeIs(1));
  EXPECT_EQ(jobs[0].fraction(), 0.25);
  EXPECT_EQ(jobs[0].stage(), "layout");
  EXPECT_EQ(jobs[0].worker(), "w");
  EXPECT_THAT(queue_->Heartbeat("v", {progress}), SizeIs(1));
  clock_.Advance(31);
  Tick();
  EXPECT_THAT(queue_->Heartbeat("w", {progress}), SizeIs(1));
}

TEST_F(JobQueueTest, ARestartAdoptsWhatAWorkerStillRuns) {
  const StudyId study = Submit({.pairs = 6});
  const auto leases = Lease(AnyWorker("w"), 3);
  ASSERT_THAT(leases, SizeIs(3));
  Reopen();
  clock_.Advance(20);
  v1::AttemptId stranger = leases[1].attempt();
  stranger.set_fence(stranger.fence() + 100);
  const auto adopted = queue_->Adopt("w", {leases[0].attempt(), stranger});
  ASSERT_TRUE(adopted.ok());
  ASSERT_THAT(*adopted, SizeIs(1));
  EXPECT_EQ((*adopted)[0].job_id(), leases[0].attempt().job_id());
  EXPECT_EQ(Jobs(study, "solve", "LEASED"), 1);
  EXPECT_EQ(Jobs(study, "solve", "READY"), 2);
  clock_.Advance(20);  // The adopted one counts from the adoption.
  Tick();
  EXPECT_EQ(Complete(Answer(leases[0], "w")), v1::REPORT_OUTCOME_OK);
  EXPECT_EQ(Complete(Answer(leases[1], "w")), v1::REPORT_OUTCOME_STALE_FENCE);
}

TEST_F(JobQueueTest, StartsInQuickSuccessionProlongNoLeaseOfADeadWorker) {
  Submit({.pairs = 4});
  const v1::Lease dead = LeaseOne(AnyWorker("dead"));
  const v1::Lease alive = LeaseOne(AnyWorker("alive"));
  for (int start = 0; start < 6; ++start) {
    clock_.Advance(9);
    Reopen();
    ASSERT_TRUE(queue_->Adopt("alive", {alive.attempt()}).ok());
    Tick();
    // A lease has 30 s from the first start on.
    EXPECT_EQ(queue_->IsHeldBy("dead", dead.attempt()), start * 9 < 30) << start;
    EXPECT_TRUE(queue_->IsHeldBy("alive", alive.attempt())) << start;
  }
  EXPECT_EQ(Complete(Answer(dead, "dead")), v1::REPORT_OUTCOME_STALE_FENCE);
}

TEST_F(JobQueueTest, AClockThatWasSetBackProlongsNoLeaseOfADeadWorker) {
  Submit({.pairs = 4});
  const v1::Lease dead = LeaseOne(AnyWorker("dead"));
  Reopen();
  clock_.JumpWall(-1e6);
  for (int start = 0; start < 6; ++start) {
    Reopen();
    clock_.Advance(9);
    Tick();
  }
  EXPECT_FALSE(queue_->IsHeldBy("dead", dead.attempt()));
}

TEST_F(JobQueueTest, LeasesThatNeverReachedTheirWorkersSayNothingAgainstTheJob) {
  const StudyId study = Submit({.pairs = 2});
  for (const bool same_process : {true, false}) {
    for (int i = 0; i < 3; ++i) {
      const std::string worker = std::string(same_process ? "same" : "new") + std::to_string(i);
      LeaseOne(Solver(worker));
      ASSERT_TRUE(queue_->Adopt(worker, {}, same_process).ok());
      clock_.Advance(31);  // Past the time for which it is left to others.
    }
    // Three workers lost while they held it: quarantined.
    EXPECT_EQ(Jobs(study, "solve", "QUARANTINED"), same_process ? 0 : 1);
  }
}

TEST_F(JobQueueTest, LeasesThatWereOnTheirWayInARestartSayNothingAgainstTheJob) {
  const StudyId study = Submit({.pairs = 2});
  for (int i = 0; i < 4; ++i) {
    const std::string worker = "w" + std::to_string(i);
    LeaseOne(Solver(worker));
    Reopen();
    ASSERT_TRUE(queue_->Adopt(worker, {}, /*same_process=*/false).ok());
    EXPECT_EQ(Jobs(study, "solve", "QUARANTINED"), 0) << i;
  }
}

TEST_F(JobQueueTest, WorkersGetOnlyKindsTheyDo) {
  Submit({.pairs = 2});
  EXPECT_THAT(Lease(Renderer("r")), IsEmpty());
  Complete(Answer(LeaseOne(Solver("s")), "s"));
  EXPECT_THAT(Lease(Solver("s")), IsEmpty());
  EXPECT_THAT(Lease(Renderer("r")), SizeIs(1));
}

TEST_F(JobQueueTest, StudiesThatAskForTagsOrMemoryGetFittingWorkers) {
  v1::SubmitRequest request = MakeStudy({.pairs = 2});
  request.mutable_study()->add_tags("avx512");
  request.mutable_study()->add_tags("fast");
  request.mutable_study()->set_memory_mb(4000);
  ASSERT_TRUE(queue_->Submit(request, "t").ok());
  WorkerFacts worker = AnyWorker("w");
  EXPECT_THAT(Lease(worker), IsEmpty());
  worker.tags = {"fast", "avx512", "x"};
  worker.memory_mb = 3999;
  EXPECT_THAT(Lease(worker), IsEmpty());
  worker.memory_mb = 4000;
  EXPECT_THAT(Lease(worker), SizeIs(1));
}

// ---- Rejections
TEST_F(JobQueueTest, ARejectedSeedIsReplacedSoThatThePairsAskedForAreMade) {
  const StudyId study = Submit({.pairs = 6, .rigs_per_scene = 2});
  int solves = 0;
  for (;;) {
    const auto leases = Lease(AnyWorker("w"), 1);
    if (leases.empty()) break;
    const bool solve = leases[0].kind() == "solve";
    const bool reject = solve && ++solves % 2 == 1;
    Complete(reject ? RejectAnswer(leases[0], "w", false) : Answer(leases[0], "w"));
  }
  const v1::StudyStatus status = Status(study);
  EXPECT_EQ(status.state(), v1::STUDY_STATE_SUCCEEDED);
  EXPECT_EQ(status.variants(0).pairs_done(), 6);
  EXPECT_EQ(status.variants(0).scenes_rejected(), 3);
  EXPECT_THAT(Frames(study), SizeIs(6));
}

TEST_F(JobQueueTest, AVariantWithoutValidScenesEndsWithAClearProblem) {
  const StudyId study = Submit({.pairs = 1000, .rigs_per_scene = 1});
  int rejected = 0;
  for (;;) {
    const auto leases = Lease(AnyWorker("w"), 1);
    if (leases.empty()) break;
    EXPECT_EQ(Complete(RejectAnswer(leases[0], "w", true)), v1::REPORT_OUTCOME_OK);
    ++rejected;
  }
  EXPECT_EQ(rejected, 50);
  const v1::StudyStatus status = Status(study);
  EXPECT_EQ(status.state(), v1::STUDY_STATE_FAILED);
  ASSERT_FALSE(status.variants(0).problems().empty());
  EXPECT_THAT(status.variants(0).problems(0).error(), HasSubstr("first 50 seeds"));
}

// ---- Studies
TEST_F(JobQueueTest, TheSameIdempotencyKeyIsTheSameStudy) {
  const auto first = queue_->Submit(MakeStudy({.key = "k"}), "t");
  const auto second = queue_->Submit(MakeStudy({.key = "k"}), "t");
  ASSERT_TRUE(first.ok() && second.ok());
  EXPECT_FALSE(first->existed());
  EXPECT_TRUE(second->existed());
  EXPECT_EQ(first->study_id(), second->study_id());
  EXPECT_EQ(queue_->Submit(MakeStudy({.pairs = 99, .key = "k"}), "t").status().code(),
            absl::StatusCode::kAlreadyExists);
  EXPECT_THAT(*queue_->ListStudies(10), SizeIs(1));
}

TEST_F(JobQueueTest, AnIdempotencyKeyIsItsUsersOwn) {
  const char* const ada = "submitter ada ipv4:10.0.0.7:1";
  const auto adas = queue_->Submit(MakeStudy({.key = "k"}), ada);
  const auto bobs = queue_->Submit(MakeStudy({.key = "k"}), "submitter bob ipv4:10.0.0.8:1");
  ASSERT_TRUE(adas.ok() && bobs.ok()) << adas.status() << bobs.status();
  EXPECT_FALSE(bobs->existed());
  EXPECT_NE(adas->study_id(), bobs->study_id());
  const auto again = queue_->Submit(MakeStudy({.key = "k"}), "submitter ada ipv4:10.0.0.9:2");
  EXPECT_TRUE(again->existed());
  EXPECT_EQ(again->study_id(), adas->study_id());
}

TEST_F(JobQueueTest, ABadSpecIsRefused) {
  EXPECT_EQ(queue_->Submit(MakeStudy({.variants = {"a", "a"}}), "t").status().code(),
            absl::StatusCode::kInvalidArgument);
}

class Stops final : public JobQueueObserver {
 public:
  void OnWorkReady() override { ++ready; }
  void OnStop(const std::string& worker, const v1::AttemptId& attempt,
              const std::string& reason) override {
    stopped.push_back(worker + " " + std::to_string(attempt.job_id()) + " " + reason);
  }
  std::atomic<int> ready{0};
  std::vector<std::string> stopped;
};

TEST_F(JobQueueTest, CancelEndsEverythingAndStopsWhatRuns) {
  Stops stops;
  queue_->SetObserver(&stops);
  const StudyId study = Submit({.pairs = 20});
  EXPECT_GT(stops.ready, 0);
  const auto leases = Lease(AnyWorker("w"), 2);
  ASSERT_TRUE(queue_->Cancel(study, "wrong seed", "tester").ok());
  ASSERT_TRUE(queue_->Cancel(study, "again", "tester").ok());
  EXPECT_THAT(stops.stopped, SizeIs(2));
  EXPECT_THAT(stops.stopped[0], HasSubstr("cancelled: wrong seed"));
  EXPECT_EQ(Status(study).state(), v1::STUDY_STATE_CANCELLED);
  EXPECT_EQ(Jobs(study, "solve", "CANCELLED"), 10);
  EXPECT_THAT(Lease(AnyWorker("w")), IsEmpty());
  EXPECT_EQ(Complete(Answer(leases[0], "w")), v1::REPORT_OUTCOME_CANCELLED);
  EXPECT_EQ(queue_->Retry(study, "t").status().code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_EQ(queue_->Cancel(StudyId{99}, "", "t").code(), absl::StatusCode::kNotFound);
  queue_->SetObserver(nullptr);
}

TEST_F(JobQueueTest, AStudyThatHasEndedIsNotCancelledAfterwards) {
  const StudyId study = Submit({.pairs = 2});
  WorkOff(AnyWorker("w"));
  ASSERT_EQ(Status(study).state(), v1::STUDY_STATE_SUCCEEDED);
  const absl::Status late = queue_->Cancel(study, "too late", "tester");
  EXPECT_EQ(late.code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(std::string(late.message()), HasSubstr("has ended already"));
  EXPECT_EQ(Status(study).state(), v1::STUDY_STATE_SUCCEEDED);
}

TEST_F(JobQueueTest, APausedStudyGetsNoLeasesButKeepsItsResults) {
  const StudyId study = Submit({.pairs = 4});
  const v1::Lease lease = LeaseOne(AnyWorker("w"));
  ASSERT_TRUE(queue_->Pause(study, "", "t").ok());
  EXPECT_EQ(Status(study).state(), v1::STUDY_STATE_PAUSED);
  EXPECT_THAT(Lease(AnyWorker("w")), IsEmpty());
  EXPECT_EQ(Complete(Answer(lease, "w")), v1::REPORT_OUTCOME_OK);
  EXPECT_THAT(Lease(AnyWorker("w")), IsEmpty());
  Reopen();
  EXPECT_THAT(Lease(AnyWorker("w")), IsEmpty());
  ASSERT_TRUE(queue_->Resume(study, "", "t").ok());
  WorkOff(AnyWorker("w"));
  EXPECT_EQ(Status(study).state(), v1::STUDY_STATE_SUCCEEDED);
}

TEST_F(JobQueueTest, WhoChangedAStudyAndHowStandsInTheAudit) {
  const StudyId study = Submit();
  ASSERT_TRUE(queue_->Pause(study, "lunch", "ada").ok());
  ASSERT_TRUE(queue_->Pause(study, "again", "bob").ok());  // Changes nothing.
  ASSERT_TRUE(queue_->Resume(study, "", "ada").ok());
  ASSERT_TRUE(queue_->Retry(study, "eve").ok());
  ASSERT_TRUE(queue_->Cancel(study, "a mistake", "olga").ok());
  const auto entries = queue_->ListAudit({});
  ASSERT_TRUE(entries.ok()) << entries.status();
  std::string told;
  for (const v1::AuditEntry& entry : *entries) told += entry.actor() + ":" + entry.action() + " ";
  EXPECT_EQ(told, "olga:cancel eve:retry ada:resume ada:pause tester:submit ");
}

TEST_F(JobQueueTest, OneJobIsRetriedAndItsAttemptsCountAnew) {
  const StudyId study = Submit({.pairs = 4, .rigs_per_scene = 2});
  for (int i = 0; i < 10; ++i) {
    Fail(Failure(LeaseOne(AnyWorker("w")), "w", "bad build", /*retryable=*/false));
  }
  ASSERT_EQ(Status(study).state(), v1::STUDY_STATE_FAILED);
  const int64_t job = ListJobs(study)[0].job_id();
  const size_t before = ListJobs(study).size();
  ASSERT_TRUE(queue_->RetryJob(study, job, "new build", "olga").ok());
  EXPECT_EQ(ListJobs(study).size(), before + 1);
  EXPECT_EQ(Status(study).state(), v1::STUDY_STATE_RUNNING);
  const absl::Status again = queue_->RetryJob(study, job, "", "olga");
  EXPECT_TRUE(absl::IsFailedPrecondition(again)) << again;
  EXPECT_THAT(std::string(again.message()), HasSubstr("was retried before, as job"));
  // It has all of its tries again, from other workers too.
  for (const char* worker : {"u", "v"}) {
    Fail(Failure(LeaseOne(AnyWorker(worker)), worker, std::string("boom on ") + worker));
    clock_.Advance(3600);
    Tick();
  }
  const v1::Lease last = LeaseOne(AnyWorker("x"));
  EXPECT_EQ(last.attempt_number(), 3);
  Complete(SolveAnswer(last, "x"));
  WorkOff(AnyWorker("x"));
  EXPECT_EQ(Status(study).variants(0).pairs_done(), 2) << "its own pairs; the variant gave up";
  EXPECT_EQ(Status(study).state(), v1::STUDY_STATE_FAILED);
  EXPECT_EQ(queue_->ListAudit({})->at(0).detail(), "job " + std::to_string(job) + ": new build");
}

TEST_F(JobQueueTest, OnlyAJobThatFailedOrWaitsIsRetried) {
  const StudyId study = Submit({.pairs = 4, .rigs_per_scene = 2});
  const v1::Lease first = LeaseOne(AnyWorker("w"));
  const int64_t job = first.attempt().job_id();
  const auto why = [&](StudyId of, int64_t which) {
    return std::string(queue_->RetryJob(of, which, "", "olga").message());
  };
  EXPECT_THAT(why(study, job), HasSubstr("is LEASED: there is nothing to retry"));
  Fail(Failure(first, "w", "boom"));
  EXPECT_EQ(Jobs(study, "solve", "RETRY_WAIT"), 1);
  ASSERT_TRUE(queue_->RetryJob(study, job, "", "olga").ok());  // Without its back-off.
  EXPECT_EQ(Jobs(study, "solve", "RETRY_WAIT"), 0);
  Fail(Failure(LeaseOne(AnyWorker("v")), "v", "no such file", /*retryable=*/false));
  EXPECT_THAT(why(study, job), HasSubstr("another scene has taken the place"));
  EXPECT_TRUE(absl::IsNotFound(queue_->RetryJob(study, 4711, "", "olga")));
  const StudyId other = Submit({.name = "other", .seed = 9});
  EXPECT_THAT(why(other, job), HasSubstr("study 2 has no job 1"));
  ASSERT_TRUE(queue_->Cancel(study, "", "olga").ok());
  EXPECT_THAT(why(study, job), HasSubstr("is cancelled"));
}

TEST_F(JobQueueTest, RetryGivesWhatIsMissingANewGeneration) {
  const StudyId study = Submit({.pairs = 4, .rigs_per_scene = 2});
  for (int i = 0; i < 10; ++i) {
    Fail(Failure(LeaseOne(AnyWorker("w")), "w", "bad build", /*retryable=*/false));
  }
  EXPECT_EQ(Status(study).state(), v1::STUDY_STATE_FAILED);
  EXPECT_THAT(Status(study).variants(0).problems(0).error(), HasSubstr("all failed"));
  const auto before = ListJobs(study);
  EXPECT_EQ(*queue_->Retry(study, "operator"), 2);  // Two scenes are missing.
  EXPECT_EQ(Status(study).state(), v1::STUDY_STATE_RUNNING);
  EXPECT_EQ(ListJobs(study).size(), before.size() + 2);
  EXPECT_EQ(LeaseOne(AnyWorker("v")).scene(), 0u);
  EXPECT_EQ(*queue_->WorkerLost("v"), 1);
  WorkOff(AnyWorker("u"));
  EXPECT_EQ(Status(study).state(), v1::STUDY_STATE_SUCCEEDED);
  EXPECT_EQ(*queue_->Retry(study, "operator"), 0);
}

TEST_F(JobQueueTest, AMillionPairsAreSubmittedInMillisecondsAndExpandedAsTheyAreNeeded) {
  const auto begin = std::chrono::steady_clock::now();
  const StudyId study = Submit({.pairs = 1'000'000, .rigs_per_scene = 20, .variants = {"a", "b"}});
  const double ms =
      std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();
  EXPECT_LT(ms, 500);
  for (int i = 0; i < 50; ++i) {
    for (const v1::Lease& lease : Lease(AnyWorker("w"), 20)) Complete(Answer(lease, "w"));
  }
  int64_t jobs = 0;
  const v1::StudyStatus status = Status(study);
  for (const v1::VariantStatus& variant : status.variants()) {
    for (const v1::JobCount& count : variant.jobs()) {
      if (count.kind() == "solve") jobs += count.jobs();
    }
  }
  EXPECT_GE(jobs, 1000);
  EXPECT_LT(jobs, 3000);
}

TEST_F(JobQueueTest, FramesAreListedInOrderFromACursor) {
  const StudyId study = Submit({.pairs = 10, .rigs_per_scene = 2});
  WorkOff(AnyWorker("w"));
  int64_t cursor = 0;
  int seen = 0;
  for (;;) {
    const auto frames = Frames(study, cursor, 3);
    if (frames.empty()) break;
    for (const auto& frame : frames) {
      EXPECT_GT(frame.cursor(), cursor);
      cursor = frame.cursor();
      ++seen;
    }
  }
  EXPECT_EQ(seen, 10);
}

// A larger study could not be read back, and the writer would end the program.
TEST_F(JobQueueTest, AStudyThatIsTooLargeIsRefusedAndTheQueueGoesOn) {
  v1::SubmitRequest huge = MakeStudy();
  for (int i = 0; i < 70; ++i) {
    huge.mutable_study()->mutable_variants(0)->mutable_config()->mutable_floating()->add_classes(
        std::string(1 << 20, 'c'));
  }
  const absl::Status status = queue_->Submit(huge, "tester").status();
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument) << status;
  EXPECT_THAT(std::string(status.message()), HasSubstr("bytes, wanted at most 2097152"));
  EXPECT_THAT(*queue_->ListStudies(10), IsEmpty());
  Submit();
  EXPECT_EQ(WorkOff(AnyWorker("w")), 4);
}

TEST_F(JobQueueTest, AResultThatIsTooLargeFailsItsAttempt) {
  const StudyId study = Submit();
  v1::CompleteRequest huge = SolveAnswer(LeaseOne(Solver("w")), "w");
  v1::SolveResult solved;
  ASSERT_TRUE(solved.ParseFromString(huge.result()));
  solved.mutable_scene()->set_generator_version(std::string(65 << 20, 'v'));
  SetResult(solved, huge);
  const absl::Status status = queue_->Complete(huge).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument) << status;
  EXPECT_THAT(std::string(status.message()), HasSubstr("bytes, wanted at most 67108864"));
  EXPECT_EQ(Jobs(study, "solve", "RETRY_WAIT"), 1);
}

TEST_F(JobQueueTest, JobsAreListedByState) {
  const StudyId study = Submit({.pairs = 6, .rigs_per_scene = 2});
  Complete(Answer(LeaseOne(Solver("w")), "w"));
  LeaseOne(Solver("w"));
  EXPECT_THAT(ListJobs(study, "SUCCEEDED"), SizeIs(1));
  EXPECT_THAT(ListJobs(study, "LEASED"), SizeIs(1));
  EXPECT_THAT(ListJobs(study, "READY"), SizeIs(2));
  EXPECT_THAT(ListJobs(study), SizeIs(4));
  v1::ListJobsRequest request;
  request.set_study_id(study.value);
  request.set_state("DONE");
  EXPECT_EQ(queue_->ListJobs(request).status().code(), absl::StatusCode::kInvalidArgument);
}

}  // namespace
}  // namespace parallax
