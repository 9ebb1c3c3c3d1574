// Attempts that end without a result: by results that are not the job's, failures and losses.
#include <functional>
#include <set>

#include "common/base/names.h"
#include "common/base/rng.h"
#include "queue_fixture.h"

namespace parallax {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

class JobFailuresTest : public QueueTest {};

// ---- Results that are not the job's
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
      {"statistics depth_m of nan",
       [](auto& r) {
         EditRender(r, [](auto& x) {
           (*x.mutable_frames(0)->mutable_statistics())["depth_m"] = std::nan("");
         });
       }},
      {"statistics with a name that is none",
       [](auto& r) {
         EditRender(r, [](auto& x) {
           (*x.mutable_frames(0)->mutable_statistics())[std::string(100'000, 'a')] = 1;
         });
       }},
      {"2000 statistics, allowed are at most 64",
       [](auto& r) {
         EditRender(r, [](auto& x) {
           for (int i = 0; i < 2000; ++i) {
             (*x.mutable_frames(0)->mutable_statistics())["s" + std::to_string(i)] = i;
           }
         });
       }},
      {"seconds of stages trace of -1",
       [](auto& r) {
         EditRender(r, [](auto& x) { (*x.mutable_frames(0)->mutable_stage_s())["trace"] = -1; });
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

// ---- Failures
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

// ---- Out of memory
TEST_F(JobFailuresTest, ASceneThatRanOutOfMemoryGoesToAWorkerWithMore) {
  const StudyId study = Submit({.pairs = 4, .rigs_per_scene = 4});
  WorkerFacts small = AnyWorker("small"), big = AnyWorker("big");
  small.memory_mb = 2000;
  big.memory_mb = 64000;
  for (const std::string kind : {"solve", "render"}) {
    v1::FailRequest failure =
        Failure(LeaseOne(small), "small",
                "RESOURCE_EXHAUSTED@" + kind +
                    ": render: images of rig #: needs about # MB beside # MB in use; the limit is "
                    "# MB");
    failure.set_error("RESOURCE_EXHAUSTED: needs about 900 MB beside 1500 MB in use");
    EXPECT_THAT(Lease(big, 1), IsEmpty());  // It is known from now on.
    Fail(failure);
    clock_.Advance(3600);
    Tick();
    EXPECT_THAT(Lease(small, 1), IsEmpty()) << kind;
    const auto ready = ListJobs(study, "READY");
    ASSERT_THAT(ready, SizeIs(1)) << kind;
    EXPECT_EQ(ready[0].needs_memory_mb(), 3000);
    EXPECT_THAT(ready[0].error(), HasSubstr("in use; it needs a worker with 3000 MB now"));
    const std::map<ReadyKey, int64_t> groups = {{ReadyKey{study.value, kind, 3000, {}}, 1}};
    EXPECT_EQ(queue_->ReadyGroups(study.value), groups);
    Reopen();
    EXPECT_EQ(queue_->ReadyGroups(study.value), groups) << kind << ", after a restart";
    EXPECT_THAT(Lease(small, 1), IsEmpty()) << kind << ", after a restart";
    if (kind == "solve") Complete(Answer(LeaseOne(big), "big"));
  }
  // Parts of the job need as much as the whole.
  big.farm["render"] = {.idle = 2, .all = 2};
  const v1::Lease half = LeaseOne(big);
  EXPECT_EQ(ListJobs(study, "READY").at(0).needs_memory_mb(), 3000);
  EXPECT_THAT(Lease(small, 1), IsEmpty());
  Complete(Answer(half, "big"));
  big.farm.clear();
  Complete(Answer(LeaseOne(big), "big"));
  EXPECT_EQ(Status(study).state(), v1::STUDY_STATE_SUCCEEDED);
}

TEST_F(JobFailuresTest, ARetryOfASceneNeedsWhatItsLastAttemptDid) {
  const StudyId study = Submit({.pairs = 2});
  WorkerFacts small = AnyWorker("small"), big = AnyWorker("big");
  small.memory_mb = 2000;
  const v1::Lease lease = LeaseOne(small);
  EXPECT_THAT(Lease(big, 1), IsEmpty());
  Fail(Failure(lease, "small", "out of memory"));
  clock_.Advance(3600);
  Tick();
  for (int i = 0; i < 10; ++i) {
    Fail(Failure(LeaseOne(big), "big", "bad build", /*retryable=*/false));
  }
  ASSERT_EQ(Status(study).state(), v1::STUDY_STATE_FAILED);
  ASSERT_TRUE(queue_->RetryJob(study, lease.attempt().job_id(), "", "tester").ok());
  ASSERT_THAT(ListJobs(study, "READY"), SizeIs(1));
  EXPECT_EQ(ListJobs(study, "READY")[0].needs_memory_mb(), 3000);
}

// Leases to `others` workers, which live on, while each worker that takes `job` is lost with it.
// Returns after how many losses the job was blamed; -1 if it was not after `most`.
class LossesTest : public JobFailuresTest {
 protected:
  static WorkerFacts On(const std::string& machine, const std::string& name) {
    WorkerFacts worker = AnyWorker(name);
    worker.machine = machine;
    return worker;
  }
  int LossesUntilBlamed(StudyId study, int others, int most) {
    int64_t job = 0;
    for (int loss = 0; loss < most; ++loss) {
      const std::string victim = "victim-" + std::to_string(loss);
      const v1::Lease lease = LeaseOne(Solver(victim));
      if (job == 0) job = lease.attempt().job_id();
      EXPECT_EQ(lease.attempt().job_id(), job);
      for (int i = 0; i < others; ++i) {
        const WorkerFacts worker = Solver("other-" + std::to_string(i));
        for (const v1::Lease& own : Lease(worker)) Complete(Answer(own, worker.name));
      }
      clock_.Advance(1);
      if (before_loss_) before_loss_(victim);
      EXPECT_EQ(*queue_->WorkerLost(victim), 1);
      if (Jobs(study, "solve", "QUARANTINED") == 1) return loss + 1;
    }
    return -1;
  }

  std::function<void(const std::string& victim)> before_loss_;
};

TEST_F(LossesTest, ALossThatWasUndoneIsNoEvidence) {
  FailingCommand failing(options_);
  Reopen();
  before_loss_ = [&](const std::string& victim) {
    failing.Set("settle");
    EXPECT_FALSE(queue_->WorkerLost(victim).ok());
    failing.Clear();
  };
  const StudyId study = Submit({.pairs = 400});
  EXPECT_EQ(LossesUntilBlamed(study, 40, 20), 5) << "as without the errors";
}

TEST_F(JobFailuresTest, ALossIsTakenBackAlsoWhenTheFirstHelloFails) {
  FailingCommand failing(options_);
  Reopen();
  Submit({.pairs = 2});
  const v1::Lease lease = LeaseOne(AnyWorker("w"));
  EXPECT_EQ(*queue_->WorkerLost("w"), 1);
  failing.Set("adopt", 3);
  EXPECT_FALSE(queue_->Adopt("w", {}, /*same_process=*/true).ok());
  failing.Clear();
  ASSERT_TRUE(queue_->Adopt("w", {}, /*same_process=*/true).ok());
  EXPECT_EQ(queue_->ListAttempts(lease.attempt().job_id())->attempts(0).ending(), "returned");
}

TEST_F(LossesTest, AJobThatLosesWorkerAfterWorkerWhileManyLiveIsQuarantined) {
  const StudyId study = Submit({.pairs = 400});
  EXPECT_EQ(LossesUntilBlamed(study, 40, 20), 5);
  EXPECT_EQ(Jobs(study, "solve", "QUARANTINED"), 1);
  const std::string error = ListJobs(study, "QUARANTINED").front().error();
  EXPECT_THAT(error, HasSubstr("worker victim-4 was lost; it is the job: 5 workers were lost"));
}

TEST_F(LossesTest, TheFewerLiveTheMoreLossesItTakes) {
  const StudyId study = Submit({.pairs = 400});
  const int losses = LossesUntilBlamed(study, 3, 50);
  EXPECT_GE(losses, 9);
  EXPECT_LE(losses, 14);
}

TEST_F(LossesTest, WhereNobodyElseLivesNothingIsProved) {
  const StudyId study = Submit({.pairs = 4});
  EXPECT_EQ(LossesUntilBlamed(study, 0, 60), -1);
}

TEST_F(LossesTest, OneMachineOfManyProvesNothingAgainstAJob) {
  const StudyId study = Submit({.pairs = 400});
  for (int i = 0; i < 40; ++i) Lease(On("host-" + std::to_string(i), "w" + std::to_string(i)));
  for (int loss = 0; loss < 30; ++loss) {
    const std::string name = "bad-" + std::to_string(loss);
    LeaseOne(On("bad-host", name));
    clock_.Advance(1);
    EXPECT_EQ(*queue_->WorkerLost(name), 1);
  }
  EXPECT_EQ(Jobs(study, "solve", "QUARANTINED"), 0);
}

TEST_F(LossesTest, WhereWorkersAreKilledAllTheTimeNoJobIsBlamed) {
  const StudyId study = Submit({.pairs = 40});
  Rng rng(SceneSeed{7}, "test/losses");
  for (int i = 0; i < 4; ++i) Lease(AnyWorker("w" + std::to_string(i)));
  for (int kill = 0; kill < 400; ++kill) {
    clock_.Advance(rng.Uniform(0.1, 2));
    const std::string name = "w" + std::to_string(rng.UniformInt(0, 3));
    ASSERT_TRUE(queue_->WorkerLost(name).ok());
    clock_.Advance(31);  // Past the time for which its job is left to others.
    Lease(AnyWorker(name));
    EXPECT_EQ(Jobs(study, "solve", "QUARANTINED"), 0) << kill;
  }
}

TEST_F(LossesTest, OfTwoJobsThatAreAlwaysLostTogetherNoneIsBlamed) {
  const StudyId study = Submit({.pairs = 400});
  for (int i = 0; i < 40; ++i) Lease(AnyWorker("other-" + std::to_string(i)));
  v1::Lease guilty, innocent;
  for (int loss = 0; loss < 8; ++loss) {
    const std::string name = "victim-" + std::to_string(loss);
    guilty = LeaseOne(AnyWorker(name));
    innocent = LeaseOne(AnyWorker(name));
    clock_.Advance(1);
    EXPECT_EQ(*queue_->WorkerLost(name), 2);
    EXPECT_EQ(Jobs(study, "solve", "QUARANTINED"), 0) << name;
  }
  // Apart, it is known which of them it is.
  EXPECT_EQ(LeaseOne(AnyWorker("t")).attempt().job_id(), guilty.attempt().job_id());
  EXPECT_EQ(LeaseOne(AnyWorker("s")).attempt().job_id(), innocent.attempt().job_id());
  clock_.Advance(1);
  EXPECT_EQ(*queue_->WorkerLost("t"), 1);
  EXPECT_EQ(Jobs(study, "solve", "QUARANTINED"), 1);
}

TEST_F(LossesTest, DeathsOfTheCoordinatorStartTheCountAnew) {
  const StudyId study = Submit({.pairs = 400});
  for (int start = 0; start < 6; ++start) {
    EXPECT_EQ(LossesUntilBlamed(study, 40, 4), -1);
    Reopen();
  }
}

TEST_F(LossesTest, WhatNobodyFailedIsInNoLedger) {
  const StudyId study = Submit({.pairs = 4});
  const auto hand_back = [&] {
    ASSERT_EQ(*queue_->HandBack("w", LeaseOne(AnyWorker("w")).attempt(), "draining"),
              v1::REPORT_OUTCOME_OK);
  };
  const auto leave = [&] {
    LeaseOne(AnyWorker("w"));
    EXPECT_EQ(*queue_->WorkerLeft("w"), 1);
  };
  const auto never_arrive = [&] {
    LeaseOne(AnyWorker("w"));
    ASSERT_TRUE(queue_->Adopt("w", {}, /*same_process=*/true).ok());
  };
  const auto die = [&] {
    LeaseOne(AnyWorker("w"));
    Reopen();
    ASSERT_TRUE(queue_->Adopt("w", {}, /*same_process=*/false).ok());
  };
  for (int i = 0; i < 15; ++i) {
    hand_back();
    leave();
    never_arrive();
    die();
  }
  EXPECT_EQ(Jobs(study, "solve", "READY"), 2);
  const v1::JobStatus job = ListJobs(study, "READY").front();
  EXPECT_EQ(job.scene(), 0u);
  WorkOff(AnyWorker("w"));
  EXPECT_EQ(Status(study).state(), v1::STUDY_STATE_SUCCEEDED);
}

TEST_F(JobFailuresTest, AWorkerThatWasAwayAndComesBackWasNotLostWithItsJob) {
  const StudyId study = Submit({.pairs = 400});
  for (int i = 0; i < 40; ++i) Lease(AnyWorker("other-" + std::to_string(i)));
  for (int i = 0; i < 20; ++i) {
    const std::string name = "w" + std::to_string(i);
    LeaseOne(AnyWorker(name));
    clock_.Advance(1);
    EXPECT_EQ(*queue_->WorkerLost(name), 1);
    ASSERT_TRUE(queue_->Adopt(name, {}, /*same_process=*/true).ok());
    EXPECT_EQ(Jobs(study, "solve", "QUARANTINED"), 0) << i;
  }
}

// The job is at work elsewhere when the worker that was away comes back.
TEST_F(JobFailuresTest, ALossIsTakenBackWhateverBecameOfTheJob) {
  Submit({.pairs = 2});
  LeaseOne(AnyWorker("w"));
  EXPECT_EQ(*queue_->WorkerLost("w"), 1);
  const v1::Lease elsewhere = LeaseOne(AnyWorker("v"));
  ASSERT_TRUE(queue_->Adopt("w", {}, /*same_process=*/true).ok());
  ExpectSound();
  EXPECT_EQ(*queue_->WorkerLost("v"), 1);
  Fail(Failure(LeaseOne(AnyWorker("u")), "u", "boom"));
  ASSERT_TRUE(queue_->Adopt("v", {}, /*same_process=*/true).ok());
  ExpectSound();
  clock_.Advance(600);
  Tick();
  LeaseOne(AnyWorker("w"));
  EXPECT_EQ(*queue_->WorkerLost("w"), 1);
  WorkOff(AnyWorker("u"));
  ASSERT_TRUE(queue_->Adopt("w", {}, /*same_process=*/true).ok());
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
