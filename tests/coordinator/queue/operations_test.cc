// Operators' orders and questions: workers that are drained, and how a job's attempts ended.
#include "train_fixture.h"

namespace parallax {
namespace {

using testing::ElementsAre;
using testing::EndsWith;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

// ---- Drained workers
class Told final : public JobQueueObserver {
 public:
  void OnWorkReady() override {}
  void OnStop(const std::string&, const v1::AttemptId&, const std::string&) override {}
  void OnDrains(const std::vector<v1::DrainOrder>& drains) override {
    patterns.clear();
    for (const v1::DrainOrder& drain : drains) patterns.push_back(drain.pattern());
  }
  std::vector<std::string> patterns;
};

class Drains : public QueueTest {
 protected:
  absl::Status Order(const std::string& pattern, bool undo = false) {
    v1::DrainOrder order;
    order.set_pattern(pattern);
    order.set_reason("new disks");
    order.set_actor("operator ada");
    return queue_->Drain(order, undo);
  }
  std::vector<std::string> Patterns() {
    const auto drains = queue_->Drains();
    EXPECT_TRUE(drains.ok()) << drains.status();
    std::vector<std::string> patterns;
    for (const v1::DrainOrder& drain : *drains) patterns.push_back(drain.pattern());
    return patterns;
  }
};

TEST_F(Drains, OrdersAreKeptOverARestartAndToldToTheObserver) {
  Told told;
  queue_->SetObserver(&told);
  ASSERT_TRUE(Order("node1*").ok());
  clock_.Advance(5);
  ASSERT_TRUE(Order("node2").ok());
  ASSERT_TRUE(Order("node1*").ok()) << "again: no effect";
  EXPECT_THAT(told.patterns, ElementsAre("node1*", "node2"));
  queue_->SetObserver(nullptr);
  Reopen();
  const auto drains = queue_->Drains();
  ASSERT_TRUE(drains.ok()) << drains.status();
  ASSERT_THAT(*drains, SizeIs(2));
  EXPECT_EQ((*drains)[0].actor(), "operator ada");
  EXPECT_EQ((*drains)[0].reason(), "new disks");
  EXPECT_EQ((*drains)[0].unix_s() + 5, (*drains)[1].unix_s());
}

TEST_F(Drains, AnOrderIsUndoneByItsOwnPattern) {
  ASSERT_TRUE(Order("node1*").ok());
  const absl::Status status = Order("node17", /*undo=*/true);
  EXPECT_EQ(status.code(), absl::StatusCode::kNotFound);
  EXPECT_THAT(std::string(status.message()), HasSubstr("no order to drain 'node17'"));
  EXPECT_THAT(std::string(status.message()), HasSubstr("there are 'node1*'"));
  ASSERT_TRUE(Order("node1*", /*undo=*/true).ok());
  EXPECT_THAT(Patterns(), IsEmpty());
  EXPECT_THAT(std::string(Order("node1*", true).message()), HasSubstr("there is none at all"));
  const auto audit = queue_->ListAudit({});
  ASSERT_TRUE(audit.ok()) << audit.status();
  ASSERT_THAT(*audit, SizeIs(2));
  EXPECT_EQ((*audit)[0].action(), "undrain");
  EXPECT_EQ((*audit)[1].action(), "drain");
  EXPECT_EQ((*audit)[1].detail(), "node1*: new disks");
}

TEST_F(Drains, TheAuditOfAStudyHasItsOwnEntries) {
  const StudyId first = Submit({.seed = 1}), second = Submit({.seed = 2});
  ASSERT_TRUE(queue_->Comment(first, "slow", "ada").ok());
  ASSERT_TRUE(queue_->Comment(second, "quick", "ada").ok());
  v1::ListAuditRequest request;
  request.set_study_id(first.value);
  const auto audit = queue_->ListAudit(request);
  ASSERT_TRUE(audit.ok()) << audit.status();
  ASSERT_THAT(*audit, SizeIs(2));
  EXPECT_EQ((*audit)[0].detail(), "slow");
  EXPECT_EQ((*audit)[1].action(), "submit");
  request.set_before((*audit)[0].id());
  EXPECT_THAT(*queue_->ListAudit(request), SizeIs(1));
}

// ---- Upgrades
using Upgrades = QueueTest;

TEST_F(Upgrades, AStartWithOtherVersionsEndsLeasesWhoseResultsItWouldTakeForItsOwn) {
  Submit({.pairs = 4});
  EXPECT_EQ(Complete(Answer(LeaseOne(Solver("s")), "s")), v1::REPORT_OUTCOME_OK);
  const v1::Lease solve = LeaseOne(Solver("s"));
  const v1::Lease render = LeaseOne(Renderer("r"));
  options_.versions.frame = "next";
  Reopen();
  EXPECT_EQ(Complete(Answer(render, "r")), v1::REPORT_OUTCOME_STALE_FENCE);
  EXPECT_EQ(Complete(Answer(solve, "s")), v1::REPORT_OUTCOME_OK);
  EXPECT_EQ(Complete(Answer(LeaseOne(Renderer("r")), "r")), v1::REPORT_OUTCOME_OK);
}

// ---- Attempts
class Attempts : public TrainQueueTest {
 protected:
  v1::ListAttemptsReply List(int64_t job) {
    auto reply = queue_->ListAttempts(job);
    EXPECT_TRUE(reply.ok()) << reply.status();
    return reply.ok() ? *std::move(reply) : v1::ListAttemptsReply();
  }
  static std::vector<std::string> Endings(const v1::ListAttemptsReply& reply) {
    std::vector<std::string> endings;
    for (const v1::AttemptStatus& attempt : reply.attempts()) {
      endings.push_back(attempt.ending() + " on " + attempt.worker());
    }
    return endings;
  }
  static v1::FailRequest WithLog(v1::FailRequest failure, const std::string& log) {
    failure.set_log_tail(log);
    return failure;
  }
  // A job of `worker`'s that fails at once with this log.
  int64_t FailOne(const std::string& worker, const std::string& log) {
    const v1::Lease lease = LeaseOne(Solver(worker));
    Fail(WithLog(Failure(lease, worker, "boom", /*retryable=*/false), log));
    return lease.attempt().job_id();
  }
};

TEST_F(Attempts, EachIsToldWithItsEndTheNewestFirst) {
  Submit({.pairs = 2, .rigs_per_scene = 2});
  const v1::Lease failed = LeaseOne(Solver("a"));
  const int64_t job = failed.attempt().job_id();
  EXPECT_THAT(Endings(List(job)), ElementsAre("running on a"));
  Fail(WithLog(Failure(failed, "a", "boom"), "first\nlast\n"));
  clock_.Advance(1000);
  Tick();
  LeaseOne(Solver("b"));
  ASSERT_TRUE(queue_->WorkerLost("b").ok());
  const v1::Lease back = LeaseOne(Solver("c"));
  ASSERT_TRUE(queue_->HandBack("c", back.attempt(), "drained").ok());
  const v1::Lease winner = LeaseOne(Solver("d"));
  v1::Progress progress;
  *progress.mutable_attempt() = winner.attempt();
  progress.set_fraction(0.5);
  EXPECT_THAT(queue_->Heartbeat("d", {progress}), IsEmpty());
  EXPECT_EQ(List(job).job().fraction(), 0.5);
  Complete(SolveAnswer(winner, "d"));
  const v1::ListAttemptsReply reply = List(job);
  EXPECT_THAT(Endings(reply),
              ElementsAre("succeeded on d", "returned on c", "lost on b", "failed on a"));
  EXPECT_EQ(reply.job().state(), "SUCCEEDED");
  EXPECT_EQ(reply.job().kind(), "solve");
  EXPECT_EQ(reply.attempts(3).log_tail(), "first\nlast\n");
  EXPECT_EQ(reply.attempts(3).attempt().fence(), failed.attempt().fence());
  EXPECT_THAT(reply.attempts(3).error(), HasSubstr("boom"));
  EXPECT_GT(reply.attempts(0).unix_s(), reply.attempts(3).unix_s());
}

TEST_F(Attempts, AJobThatThereIsNotAndOneThatNobodyTried) {
  EXPECT_EQ(queue_->ListAttempts(1).status().code(), absl::StatusCode::kNotFound);
  const StudyId study = Submit({.pairs = 2, .rigs_per_scene = 2});
  EXPECT_THAT(List(ListJobs(study)[0].job_id()).attempts(), IsEmpty());
  const v1::Lease held = LeaseOne(Solver("a"));
  ASSERT_TRUE(queue_->Cancel(study, "", "tester").ok());
  EXPECT_THAT(Endings(List(held.attempt().job_id())), ElementsAre("cancelled on a"));
}

TEST_F(Attempts, ATrainingsAreToldToo) {
  SubmitRequest(Request({.pairs = 2, .variants = {"wide"}}));
  MakePairs();
  const v1::Lease lease = LeaseOne(Trainer("t"));
  Fail(WithLog(Failure(lease, "t", "exit status 1"), "Traceback\n"));
  const v1::ListAttemptsReply reply = List(lease.attempt().job_id());
  EXPECT_EQ(reply.job().label(), "wide, seed 0");
  EXPECT_EQ(reply.attempts(0).log_tail(), "Traceback\n");
}

TEST_F(Attempts, OnlyTheNewestLogsAreKept) {
  options_.most_logs = 3;
  options_.archive_after_s = 1000;
  Reopen();
  Submit({.pairs = 20, .rigs_per_scene = 2});
  std::vector<int64_t> jobs;
  for (int i = 0; i < 5; ++i) jobs.push_back(FailOne("w", "log " + std::to_string(i)));
  std::vector<std::string> logs;
  for (const int64_t job : jobs) logs.push_back(List(job).attempts(0).log_tail());
  EXPECT_THAT(logs, ElementsAre("", "", "log 2\n", "log 3\n", "log 4\n"));
  // In the archive as many once more.
  WorkOff(AnyWorker("w"));
  Submit({.name = "next", .seed = 2, .pairs = 20, .rigs_per_scene = 2});
  clock_.Advance(2000);
  Tick();
  for (int i = 5; i < 7; ++i) jobs.push_back(FailOne("w", "log " + std::to_string(i)));
  WorkOff(AnyWorker("w"));
  Submit({.name = "last", .seed = 3, .pairs = 2, .rigs_per_scene = 2});
  clock_.Advance(2000);
  Tick();
  EXPECT_GT(queue_->Stats().archived_jobs, 0u);
  logs.clear();
  for (const int64_t job : jobs) logs.push_back(List(job).attempts(0).log_tail());
  EXPECT_THAT(logs, ElementsAre("", "", "", "", "log 4\n", "log 5\n", "log 6\n"));
}

}  // namespace
}  // namespace parallax
