#include "worker/agent/agent.h"

#include <gtest/gtest.h>

#include "agent_fixture.h"

namespace parallax {
namespace {

using Seen = FakeCoordinator::Seen;

TEST_F(AgentTest, RunsWhatItLeasesAndReportsIt) {
  StartAgent();
  for (int job = 1; job <= 5; ++job) coordinator_.Offer(SolveLease(job, 100 + job, job));
  ASSERT_TRUE(coordinator_.WaitFor([](const Seen& seen) { return seen.completes.size() == 5; }));
  const v1::CompleteRequest complete = coordinator_.seen().completes[0];
  EXPECT_EQ(complete.worker(), "worker-1");
  EXPECT_EQ(complete.coordinator_id(), "database-1");
  EXPECT_EQ(complete.attempt().fence(), 100u + complete.attempt().job_id());
  EXPECT_EQ(complete.kind(), "solve");
  agent_->Drain();
  JoinAgent();
  ASSERT_TRUE(summary_.ok()) << summary_.status();
  EXPECT_EQ(summary_->succeeded, 5);
  EXPECT_EQ(summary_->reports_left, 0u);
  EXPECT_EQ(ReportsOnDisk(), 0);
}

TEST_F(AgentTest, TakesNoMoreJobsThanItHasSlots) {
  options_.ahead_s = 0;
  coordinator_.Change([](auto& how) { how.lease_s = 1; });
  runner_.Hold(1, started_, finish_, cancelled_);
  StartAgent();
  for (int job = 1; job <= 3; ++job) coordinator_.Offer(SolveLease(job, job, 1));
  ASSERT_TRUE(started_.Wait());
  ASSERT_TRUE(coordinator_.WaitFor([](const Seen& seen) { return !seen.heartbeats.empty(); }));
  EXPECT_EQ(coordinator_.seen().leases_sent, 2);
  finish_.Open();
  EXPECT_TRUE(coordinator_.WaitFor([](const Seen& seen) { return seen.completes.size() == 3; }));
}

TEST_F(AgentTest, LeasesTheNextJobBeforeTheOneAtHandEnds) {
  options_.slots = 1;
  options_.ahead_s = 60;  // The job is half done when it begins: it ends soon.
  runner_.Hold(1, started_, finish_, cancelled_);
  StartAgent();
  coordinator_.Offer(SolveLease(1, 11, 1));
  coordinator_.Offer(SolveLease(2, 12, 2));
  coordinator_.Offer(SolveLease(3, 13, 2));
  ASSERT_TRUE(coordinator_.WaitFor([](const Seen& seen) { return seen.leases_sent == 2; }));
  EXPECT_TRUE(coordinator_.seen().completes.empty());
  EXPECT_EQ(coordinator_.seen().credit_ahead, 1) << "the coordinator must not see a free slot";
  EXPECT_TRUE(started_.Wait());
  finish_.Open();
  EXPECT_TRUE(coordinator_.WaitFor([](const Seen& seen) { return seen.completes.size() == 3; }));
}

TEST_F(AgentTest, ADrainingWorkerHandsBackWhatWaitsAtOnce) {
  options_.slots = 1;
  options_.ahead_s = 60;
  coordinator_.Change([](auto& how) { how.lease_s = 0.4; });
  runner_.Hold(1, started_, finish_, cancelled_);
  StartAgent();
  coordinator_.Offer(SolveLease(1, 11, 1));
  coordinator_.Offer(SolveLease(2, 12, 2));
  ASSERT_TRUE(coordinator_.WaitFor([](const Seen& seen) { return seen.leases_sent == 2; }));
  ASSERT_TRUE(started_.Wait());
  ASSERT_TRUE(coordinator_.WaitFor([](const Seen& seen) {
    return !seen.heartbeats.empty() && seen.heartbeats.back().running_size() == 2;
  })) << "it has the second lease";
  agent_->Drain();
  ASSERT_TRUE(coordinator_.WaitFor([](const Seen& seen) { return seen.hand_backs.size() == 1; }));
  EXPECT_EQ(coordinator_.seen().hand_backs[0].attempt().job_id(), 2);
  finish_.Open();
  JoinAgent();
  ASSERT_TRUE(summary_.ok()) << summary_.status();
  EXPECT_EQ(summary_->succeeded, 1);
}

TEST_F(AgentTest, AFailedJobIsReportedWithACauseThatHasNoNumbers) {
  StartAgent();
  coordinator_.Offer(RenderLease(7, 42, {}));
  ASSERT_TRUE(coordinator_.WaitFor([](const Seen& seen) { return seen.fails.size() == 1; }));
  const v1::FailRequest fail = coordinator_.seen().fails[0];
  EXPECT_EQ(fail.fingerprint(), "RESOURCE_EXHAUSTED@render: disk of # GB is full");
  EXPECT_TRUE(fail.retryable());
  EXPECT_FALSE(fs::exists(dir_ + "/store/renders/ab12/.attempt-42"))
      << "a failed attempt's files are never published";
}

TEST_F(AgentTest, ARenderWritesIntoItsAttemptsFolder) {
  StartAgent();
  coordinator_.Offer(RenderLease(7, 42, {0}));
  ASSERT_TRUE(coordinator_.WaitFor([](const Seen& seen) { return seen.completes.size() == 1; }));
  EXPECT_EQ(RenderOf(coordinator_.seen().completes[0]).frames(0).path(),
            "renders/ab12/.attempt-42/000");
  EXPECT_TRUE(fs::exists(dir_ + "/store/renders/ab12/.attempt-42/left.png"));
}

TEST_F(AgentTest, AFolderOutsideTheStoreIsRefused) {
  StartAgent();
  v1::Lease lease = RenderLease(7, 42, {0});
  lease.set_store_prefix("../elsewhere");
  coordinator_.Offer(lease);
  ASSERT_TRUE(coordinator_.WaitFor([](const Seen& seen) { return seen.fails.size() == 1; }));
  EXPECT_FALSE(fs::exists(dir_ + "/elsewhere"));
  EXPECT_FALSE(coordinator_.seen().fails[0].retryable());
}

TEST_F(AgentTest, AnExceptionFailsItsJobOnly) {
  runner_.On(1, [](const CancelToken&) -> absl::StatusOr<v1::SolveResult> {
    throw std::runtime_error("vertex 17 is odd");
  });
  StartAgent();
  coordinator_.Offer(SolveLease(1, 11, 1));
  coordinator_.Offer(SolveLease(2, 12, 2));
  ASSERT_TRUE(coordinator_.WaitFor(
      [](const Seen& seen) { return seen.fails.size() == 1 && seen.completes.size() == 1; }));
  EXPECT_NE(coordinator_.seen().fails[0].error().find("vertex 17 is odd"), std::string::npos);
}

TEST_F(AgentTest, ADroppedReplyIsAnsweredByRepeatingTheReport) {
  coordinator_.Change([](auto& how) { how.drop_replies = 2; });
  StartAgent();
  coordinator_.Offer(SolveLease(1, 11, 1));
  ASSERT_TRUE(coordinator_.WaitFor([](const Seen& seen) { return seen.completes.size() == 3; }));
  agent_->Drain();
  JoinAgent();
  EXPECT_EQ(coordinator_.seen().completes.size(), 3u) << "answered, so not sent again";
  EXPECT_EQ(ReportsOnDisk(), 0);
}

TEST_F(AgentTest, EveryDefinitiveAnswerEndsAReportAndNoOtherDoes) {
  const struct {
    v1::ReportOutcome outcome;
    grpc::StatusCode status;
    bool definitive;
  } cases[] = {
      {v1::REPORT_OUTCOME_OK, grpc::StatusCode::OK, true},
      {v1::REPORT_OUTCOME_ALREADY_DONE, grpc::StatusCode::OK, true},
      {v1::REPORT_OUTCOME_STALE_FENCE, grpc::StatusCode::OK, true},
      {v1::REPORT_OUTCOME_CANCELLED, grpc::StatusCode::OK, true},
      {v1::REPORT_OUTCOME_OK, grpc::StatusCode::INVALID_ARGUMENT, true},
      {v1::REPORT_OUTCOME_OK, grpc::StatusCode::INTERNAL, false},
      {v1::REPORT_OUTCOME_OK, grpc::StatusCode::RESOURCE_EXHAUSTED, false},
      {v1::REPORT_OUTCOME_OK, grpc::StatusCode::NOT_FOUND, false},
      {v1::REPORT_OUTCOME_OK, grpc::StatusCode::UNIMPLEMENTED, false},
  };
  StartAgent();
  int64_t job = 0;
  for (const auto& row : cases) {
    coordinator_.Change([&](auto& how) {
      how.outcome = row.outcome;
      how.report_status = row.status;
    });
    const size_t before = coordinator_.seen().completes.size();
    ++job;
    coordinator_.Offer(SolveLease(job, 10 + job, job));
    const size_t wanted = before + (row.definitive ? 1 : 3);
    ASSERT_TRUE(coordinator_.WaitFor([&](const Seen& seen) {
      return seen.completes.size() >= wanted;
    })) << "case "
        << job;
    if (row.definitive) {
      ASSERT_TRUE(WaitForEmptyOutbox()) << "case " << job;
      EXPECT_EQ(coordinator_.seen().completes.size(), wanted) << "case " << job;
    }
    coordinator_.Change([](auto& how) { how.report_status = grpc::StatusCode::OK; });
    ASSERT_TRUE(WaitForEmptyOutbox()) << "case " << job;
  }
  agent_->Drain();
  JoinAgent();
  EXPECT_EQ(ReportsOnDisk(), 0);
}

TEST_F(AgentTest, TakesNoNewWorkWhileTooManyReportsWait) {
  options_.max_pending_reports = 3;
  coordinator_.Change([](auto& how) {
    how.lease_s = 0.5;  // A heartbeat each 125 ms.
    how.report_status = grpc::StatusCode::INTERNAL;
  });
  StartAgent();
  for (int job = 1; job <= 12; ++job) coordinator_.Offer(SolveLease(job, job, job));
  const int most = options_.slots + options_.max_pending_reports;
  // Two heartbeats with as many: no more came in between.
  ASSERT_TRUE(coordinator_.WaitFor([&](const Seen& seen) {
    return std::count_if(seen.heartbeats.begin(), seen.heartbeats.end(),
                         [&](const auto& beat) { return beat.running_size() >= most; }) >= 2;
  }));
  EXPECT_EQ(coordinator_.seen().leases_sent, most);
  coordinator_.Change([](auto& how) { how.report_status = grpc::StatusCode::OK; });
  ASSERT_TRUE(coordinator_.WaitFor([](const Seen& seen) { return seen.leases_sent == 12; }));
  EXPECT_TRUE(WaitForEmptyOutbox());
}

TEST_F(AgentTest, ReportsLeftByADeadWorkerAreSentBeforeNewWorkIsTaken) {
  options_.name = "worker-dead";
  coordinator_.Change([](auto& how) { how.report_status = grpc::StatusCode::INTERNAL; });
  StartAgent();
  coordinator_.Offer(SolveLease(1, 11, 1));
  ASSERT_TRUE(coordinator_.WaitFor([](const Seen& seen) { return !seen.completes.empty(); }));
  agent_->HandBack();
  JoinAgent();
  EXPECT_EQ(summary_->reports_left, 1u);
  agent_.reset();
  EXPECT_EQ(ReportsOnDisk(), 1);

  options_.name = "worker-2";
  const size_t before = coordinator_.seen().completes.size();
  coordinator_.Change([](auto& how) {
    how.report_status = grpc::StatusCode::OK;
    how.hold_reports = true;
    how.lease_s = 0.4;
  });
  coordinator_.Offer(SolveLease(2, 12, 2));
  StartAgent();
  const size_t beats = coordinator_.seen().heartbeats.size();
  ASSERT_TRUE(
      coordinator_.WaitFor([&](const Seen& seen) { return seen.heartbeats.size() >= beats + 2; }));
  EXPECT_EQ(coordinator_.seen().leases_sent, 1) << "no credit before the old report was tried";
  coordinator_.Change([](auto& how) { how.hold_reports = false; });
  ASSERT_TRUE(
      coordinator_.WaitFor([&](const Seen& seen) { return seen.completes.size() == before + 2; }));
  EXPECT_EQ(coordinator_.seen().completes[before].attempt().job_id(), 1) << "the old report first";
  EXPECT_EQ(coordinator_.seen().completes[before + 1].attempt().job_id(), 2);
}

TEST_F(AgentTest, AReportIsNeverSentToAnotherDatabase) {
  coordinator_.Change([](auto& how) { how.report_status = grpc::StatusCode::INTERNAL; });
  StartAgent();
  coordinator_.Offer(SolveLease(1, 11, 1));
  ASSERT_TRUE(coordinator_.WaitFor([](const Seen& seen) { return !seen.completes.empty(); }));
  StopAgent();
  const size_t before = coordinator_.seen().completes.size();
  coordinator_.Change([](auto& how) {
    how.id = "database-2";
    how.report_status = grpc::StatusCode::OK;
  });
  StartAgent();
  coordinator_.Offer(SolveLease(2, 12, 2));
  ASSERT_TRUE(
      coordinator_.WaitFor([&](const Seen& seen) { return seen.completes.size() == before + 1; }));
  EXPECT_EQ(coordinator_.seen().completes.back().attempt().job_id(), 2);
  EXPECT_EQ(coordinator_.seen().hellos.back().holding_size(), 0);
  StopAgent();
  EXPECT_EQ(ReportsOnDisk(), 1) << "kept for its own coordinator";
}

}  // namespace
}  // namespace parallax
