// Attempts that end without a result: by results that are not the job's, failures and losses.
#include <set>

#include "common/base/names.h"
#include "queue_fixture.h"

namespace parallax {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

class JobFailuresTest : public QueueTest {};

// ---- Results that are not the job's -------------------------------------------------------------
TEST_F(JobFailuresTest, AResultThatIsNotTheJobsIsRefusedAndCountsAsAFailure) {
  Submit({.pairs = 2, .rigs_per_scene = 2});
  Complete(SolveAnswer(LeaseOne(AnyWorker("w")), "w"));
  const struct {
    const char* message;
    void (*spoil)(v1::CompleteRequest&);
  } cases[] = {
      {"a solve result for a render job",
       [](auto& r) {
         v1::SolveResult other;
         other.mutable_rejected()->set_reason("x");
         SetResult(other, r);
       }},
      {"unknown kind of job ''", [](auto& r) { r.clear_kind(); }},
      {"no RenderResult", [](auto& r) { r.set_result("\xff\xff"); }},
      {"wanted exactly '0-1'", [](auto& r) { r.clear_result(); }},
      {"wanted exactly '0-1'",
       [](auto& r) { EditRender(r, [](auto& x) { x.mutable_frames()->RemoveLast(); }); }},
      {"wanted exactly '0-1'",
       [](auto& r) {
         EditRender(r, [](auto& x) { *x.add_frames() = v1::FrameResult(x.frames(0)); });
       }},
      {"wanted a folder under",
       [](auto& r) {
         EditRender(r, [](auto& x) { x.mutable_frames(0)->set_path("elsewhere/000"); });
       }},
      {"leaves the store",
       [](auto& r) {
         EditRender(r, [](auto& x) {
           x.mutable_frames(0)->set_path(x.frames(0).path() + "/../../../../etc");
         });
       }},
      {"leaves its folder",
       [](auto& r) {
         EditRender(r, [](auto& x) { x.mutable_frames(0)->mutable_files(0)->set_name("/x"); });
       }},
      {"no SHA-256",
       [](auto& r) {
         EditRender(r, [](auto& x) { x.mutable_frames(0)->mutable_files(0)->set_sha256("ab"); });
       }},
      {"negative size",
       [](auto& r) {
         EditRender(r, [](auto& x) { x.mutable_frames(0)->mutable_files(0)->set_size(-1); });
       }},
  };
  options_.retry.max_app_failures = 1000;
  options_.retry.quarantine_workers = 1000;
  Reopen();
  for (const auto& c : cases) {
    queue_->WorkerLost("w").IgnoreError();
    const v1::Lease lease = LeaseOne(AnyWorker("w"));
    v1::CompleteRequest request = RenderAnswer(lease, "w");
    c.spoil(request);
    const auto outcome = queue_->Complete(request);
    EXPECT_EQ(outcome.status().code(), absl::StatusCode::kInvalidArgument) << c.message;
    EXPECT_THAT(std::string(outcome.status().message()), HasSubstr(c.message));
    EXPECT_EQ(Complete(RenderAnswer(lease, "w")), v1::REPORT_OUTCOME_STALE_FENCE);
    clock_.Advance(600);
    Tick();
  }
}

TEST_F(JobFailuresTest, ASceneWithTooFewRigsOrAnotherSeedIsRefused) {
  Submit({.pairs = 2, .rigs_per_scene = 2});
  v1::Lease lease = LeaseOne(AnyWorker("w"));
  v1::CompleteRequest request = SolveAnswer(lease, "w");
  EditSolve(request, [](auto& result) { result.mutable_scene()->mutable_rigs()->RemoveLast(); });
  EXPECT_THAT(std::string(queue_->Complete(request).status().message()),
              HasSubstr("1 rigs, wanted 2"));
  clock_.Advance(600);
  Tick();
  lease = LeaseOne(AnyWorker("w"));
  request = SolveAnswer(lease, "w");
  EditSolve(request, [](auto& result) { result.mutable_scene()->set_scene_seed(5); });
  EXPECT_THAT(std::string(queue_->Complete(request).status().message()),
              HasSubstr("a scene of seed 5"));
}

// ---- Failures -----------------------------------------------------------------------------------
TEST_F(JobFailuresTest, AFailedJobComesBackAfterAGrowingWaitAndFailsTheThirdTime) {
  const StudyId study = Submit({.pairs = 2});
  for (int attempt = 1; attempt <= 3; ++attempt) {
    const v1::Lease lease = LeaseOne(AnyWorker("w"));
    EXPECT_EQ(lease.attempt_number(), attempt);
    EXPECT_EQ(lease.scene(), 0u);
    EXPECT_EQ(Fail(Failure(lease, "w", "boom")), v1::REPORT_OUTCOME_OK);
    if (attempt == 3) break;
    EXPECT_EQ(Jobs(study, "solve", "RETRY_WAIT"), 1);
    clock_.Advance(4.9);
    Tick();
    EXPECT_THAT(Lease(AnyWorker("w")), IsEmpty());
    clock_.Advance(5 * std::pow(4, attempt));
    Tick();
  }
  EXPECT_EQ(Jobs(study, "solve", "FAILED"), 1);
  const v1::StudyStatus status = Status(study);
  const auto& problems = status.variants(0).problems();
  ASSERT_THAT(problems, SizeIs(1));
  EXPECT_EQ(problems[0].state(), "FAILED");
  EXPECT_EQ(problems[0].error(), "boom at line 7");
  // The next seed takes its place.
  EXPECT_EQ(LeaseOne(AnyWorker("w")).scene(), 1u);
}

// Every scene is solved, every render fails, and a scene has one render job.
TEST_F(JobFailuresTest, AStudyWhoseRendersAllFailEndsAndSaysWhy) {
  const StudyId study = Submit({.pairs = 40, .rigs_per_scene = 1});
  int renders = 0;
  const auto fail_renders = [&] {
    for (int i = 0; i < 200 && Status(study).finished_unix_s() == 0; ++i) {
      const v1::Lease lease = LeaseOne(AnyWorker("w"));
      if (lease.kind() == "solve") {
        Complete(SolveAnswer(lease, "w"));
      } else {
        ++renders;
        Fail(Failure(lease, "w", "a.png: broken PNG", /*retryable=*/false));
      }
    }
  };
  fail_renders();
  ASSERT_EQ(Status(study).state(), v1::STUDY_STATE_FAILED);
  EXPECT_EQ(renders, 10);
  const v1::StudyStatus status = Status(study);
  std::string problems;
  for (const auto& problem : status.variants(0).problems()) problems += problem.error() + "\n";
  EXPECT_THAT(problems,
              HasSubstr("10 scenes failed and no pair was made; the last: a.png: broken"));
  // Another try has the same patience, and no more.
  ASSERT_TRUE(queue_->Retry(study, "tester").ok());
  fail_renders();
  EXPECT_EQ(Status(study).state(), v1::STUDY_STATE_FAILED);
  EXPECT_LE(renders, 21);
}

TEST_F(JobFailuresTest, JobsThatFailTogetherDoNotReturnTogether) {
  Submit({.pairs = 20, .rigs_per_scene = 1});
  for (const v1::Lease& lease : Lease(AnyWorker("w"), 20)) Fail(Failure(lease, "w", "boom"));
  std::set<size_t> returned;
  size_t total = 0;
  for (int second = 0; second < 21; ++second) {
    clock_.Advance(1);
    Tick();
    const size_t n = Lease(AnyWorker("w"), 100).size();
    total += n;
    if (n > 0) returned.insert(static_cast<size_t>(second));
  }
  EXPECT_EQ(total, 20u);
  EXPECT_GE(returned.size(), 5u);
}

TEST_F(JobFailuresTest, ABackOffSurvivesAClockSetBack) {
  Submit({.pairs = 2});
  Fail(Failure(LeaseOne(AnyWorker("w")), "w", "boom"));
  clock_.JumpWall(-3600);
  Tick();
  EXPECT_THAT(Lease(AnyWorker("w")), SizeIs(1));
}

TEST_F(JobFailuresTest, WhatCannotSucceedFailsAtOnce) {
  const StudyId study = Submit({.pairs = 2});
  Fail(Failure(LeaseOne(AnyWorker("w")), "w", "unknown class", /*retryable=*/false));
  EXPECT_EQ(Jobs(study, "solve", "FAILED"), 1);
}

TEST_F(JobFailuresTest, OneFingerprintFromTwoWorkersQuarantines) {
  const StudyId study = Submit({.pairs = 2});
  Fail(Failure(LeaseOne(AnyWorker("w")), "w", "segfault in mesh"));
  clock_.Advance(60);
  Tick();
  Fail(Failure(LeaseOne(AnyWorker("v")), "v", "segfault in mesh"));
  EXPECT_EQ(Jobs(study, "solve", "QUARANTINED"), 1);
  EXPECT_EQ(Status(study).state(), v1::STUDY_STATE_RUNNING);
  WorkOff(AnyWorker("u"));
  EXPECT_EQ(Status(study).state(), v1::STUDY_STATE_SUCCEEDED);
}

TEST_F(JobFailuresTest, AnErrorIsStoredAsUtf8WhereverItIsCut) {
  const StudyId study = Submit({.pairs = 2});
  std::string error = "x";
  while (error.size() < 2000) error += "\u00fc";
  Fail(Failure(LeaseOne(AnyWorker("w")), "w", error));
  const std::string stored = ListJobs(study).front().error();
  EXPECT_TRUE(IsUtf8(stored)) << stored;
  EXPECT_LE(stored.size(), 1000u);
  EXPECT_GT(stored.size(), 900u);
}

TEST_F(JobFailuresTest, DifferentFingerprintsDoNotQuarantine) {
  const StudyId study = Submit({.pairs = 2});
  Fail(Failure(LeaseOne(AnyWorker("w")), "w", "disk full"));
  clock_.Advance(60);
  Tick();
  Fail(Failure(LeaseOne(AnyWorker("v")), "v", "out of memory"));
  EXPECT_EQ(Jobs(study, "solve", "RETRY_WAIT"), 1);
}

TEST_F(JobFailuresTest, ThreeWorkersLostWhileTheyHeldItQuarantine) {
  const StudyId study = Submit({.pairs = 2});
  for (const char* name : {"w", "v", "u"}) {
    EXPECT_EQ(Jobs(study, "solve", "QUARANTINED"), 0);
    LeaseOne(AnyWorker(name));
    EXPECT_EQ(*queue_->WorkerLost(name), 1);
  }
  EXPECT_EQ(Jobs(study, "solve", "QUARANTINED"), 1);
  EXPECT_EQ(Jobs(study, "solve", "READY"), 1);  // The next seed.
}

TEST_F(JobFailuresTest, WhereWorkersAreLostWithoutItTooThreeSayNothingAgainstAJob) {
  const StudyId study = Submit({.pairs = 4});
  const v1::Lease first = LeaseOne(AnyWorker("w"));
  LeaseOne(AnyWorker("bystander"));
  EXPECT_EQ(*queue_->WorkerLost("w"), 1);
  clock_.Advance(1);
  EXPECT_EQ(*queue_->WorkerLost("bystander"), 1);
  for (int i = 1; i < 10; ++i) {
    clock_.Advance(1);
    EXPECT_EQ(Jobs(study, "solve", "QUARANTINED"), 0) << i;
    const std::string name = "v" + std::to_string(i);
    EXPECT_EQ(LeaseOne(AnyWorker(name)).attempt().job_id(), first.attempt().job_id());
    EXPECT_EQ(*queue_->WorkerLost(name), 1);
  }
  EXPECT_EQ(Jobs(study, "solve", "QUARANTINED"), 1) << "the cap of ten losses holds";
}

TEST_F(JobFailuresTest, OfTwoJobsThatLoseWorkersTogetherTheOneThatGoesOnIsQuarantined) {
  const StudyId study = Submit({.pairs = 4});
  v1::Lease guilty, innocent;
  for (const char* name : {"w", "v", "u"}) {
    guilty = LeaseOne(AnyWorker(name));
    innocent = LeaseOne(AnyWorker(name));
    EXPECT_EQ(*queue_->WorkerLost(name), 2);
    EXPECT_EQ(Jobs(study, "solve", "QUARANTINED"), 0) << name;
    clock_.Advance(1);
  }
  const v1::Lease alone = LeaseOne(AnyWorker("t"));
  const v1::Lease apart = LeaseOne(AnyWorker("s"));
  EXPECT_EQ(alone.attempt().job_id(), guilty.attempt().job_id());
  EXPECT_EQ(apart.attempt().job_id(), innocent.attempt().job_id());
  EXPECT_EQ(*queue_->WorkerLost("t"), 1);
  EXPECT_EQ(Jobs(study, "solve", "QUARANTINED"), 1);
  clock_.Advance(1);
  EXPECT_EQ(*queue_->WorkerLost("s"), 1);  // One was lost without it.
  EXPECT_EQ(Jobs(study, "solve", "QUARANTINED"), 1);
}

TEST_F(JobFailuresTest, CompanyNowAndThenDoesNotClearAJob) {
  const StudyId study = Submit({.pairs = 4});
  LeaseOne(AnyWorker("w"));  // Guilty.
  LeaseOne(AnyWorker("w"));
  EXPECT_EQ(*queue_->WorkerLost("w"), 2);
  clock_.Advance(1);
  LeaseOne(AnyWorker("v"));
  const v1::Lease innocent = LeaseOne(AnyWorker("elsewhere"));
  EXPECT_EQ(*queue_->WorkerLost("v"), 1);
  EXPECT_EQ(*queue_->HandBack("elsewhere", innocent.attempt(), "draining"), v1::REPORT_OUTCOME_OK);
  clock_.Advance(1);
  LeaseOne(AnyWorker("u"));
  LeaseOne(AnyWorker("u"));
  EXPECT_EQ(*queue_->WorkerLost("u"), 2);
  EXPECT_EQ(Jobs(study, "solve", "QUARANTINED"), 1);
}

TEST_F(JobFailuresTest, AWorkerThatWasAwayAndComesBackWasNotLostWithItsJob) {
  const StudyId study = Submit({.pairs = 2});
  for (int i = 0; i < 9; ++i) {
    const std::string name = "w" + std::to_string(i);
    LeaseOne(AnyWorker(name));
    EXPECT_EQ(*queue_->WorkerLost(name), 1);
    ASSERT_TRUE(queue_->Adopt(name, {}, /*same_process=*/true).ok());
    EXPECT_EQ(Jobs(study, "solve", "QUARANTINED"), 0) << i;
    clock_.Advance(31);  // Past the time for which it is left to others.
  }
}

TEST_F(JobFailuresTest, LossesAreRetriedAtOnceAndNeverFailAJob) {
  const StudyId study = Submit({.pairs = 2});
  for (int i = 0; i < 9; ++i) {
    const v1::Lease lease = LeaseOne(AnyWorker("w"));
    EXPECT_EQ(lease.scene(), 0u);
    const auto outcome = queue_->HandBack("w", lease.attempt(), "draining");
    EXPECT_EQ(*outcome, v1::REPORT_OUTCOME_OK);
    EXPECT_EQ(*queue_->HandBack("w", lease.attempt(), "draining"), v1::REPORT_OUTCOME_ALREADY_DONE);
  }
  EXPECT_EQ(Jobs(study, "solve", "READY"), 1);
  *queue_->HandBack("w", LeaseOne(AnyWorker("w")).attempt(), "draining");
  EXPECT_EQ(Jobs(study, "solve", "FAILED"), 0);
  EXPECT_EQ(Jobs(study, "solve", "QUARANTINED"), 1);
}

TEST_F(JobFailuresTest, AJobThatLostItsWorkerGoesElsewhereWhileThereIsAnElsewhere) {
  Submit({.pairs = 2});
  LeaseOne(AnyWorker("w"));
  Lease(AnyWorker("v"));  // Known to be there.
  EXPECT_EQ(*queue_->WorkerLost("w"), 1);
  EXPECT_THAT(Lease(AnyWorker("w")), IsEmpty());
  EXPECT_THAT(Lease(AnyWorker("v")), SizeIs(1));
}

}  // namespace
}  // namespace parallax
