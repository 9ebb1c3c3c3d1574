// An agent's life and end: orders to stop, lost coordinators, hung jobs, drains and signals.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include "agent_fixture.h"

namespace parallax {
namespace {

using Seen = FakeCoordinator::Seen;

TEST_F(AgentTest, AStopOrderEndsTheAttemptWithoutAReport) {
  runner_.Hold(1, started_, finish_, cancelled_);
  StartAgent();
  const v1::Lease lease = SolveLease(1, 11, 1);
  coordinator_.Offer(lease);
  ASSERT_TRUE(started_.Wait());
  v1::AttemptId other = lease.attempt();
  other.set_fence(10);
  coordinator_.SendStop(other);  // Another attempt's fence: nothing happens.
  coordinator_.Offer(SolveLease(2, 12, 2));
  ASSERT_TRUE(coordinator_.WaitFor([](const Seen& seen) { return seen.completes.size() == 1; }));
  EXPECT_FALSE(cancelled_.Wait(std::chrono::seconds(0)));
  coordinator_.SendStop(lease.attempt());
  EXPECT_TRUE(cancelled_.Wait());
  agent_->Drain();
  JoinAgent();
  EXPECT_EQ(coordinator_.seen().fails.size(), 0u);
  EXPECT_EQ(coordinator_.seen().completes.size(), 1u);
  EXPECT_EQ(coordinator_.seen().hand_backs.size(), 0u);
}

TEST_F(AgentTest, RunningWorkIsAdoptedByARestartedCoordinator) {
  runner_.Hold(1, started_, finish_, cancelled_);
  StartAgent();
  coordinator_.Offer(SolveLease(1, 11, 1));
  ASSERT_TRUE(started_.Wait());
  coordinator_.Stop();
  coordinator_.Start();
  ASSERT_TRUE(coordinator_.WaitFor([](const Seen& seen) { return seen.hellos.size() == 2; }));
  ASSERT_EQ(coordinator_.seen().hellos[1].holding_size(), 1);
  EXPECT_EQ(coordinator_.seen().hellos[1].holding(0).fence(), 11u);
  finish_.Open();
  ASSERT_TRUE(coordinator_.WaitFor([](const Seen& seen) { return seen.completes.size() == 1; }));
  EXPECT_FALSE(cancelled_.Wait(std::chrono::seconds(0)));
}

TEST_F(AgentTest, WorkThatIsNotAdoptedStops) {
  runner_.Hold(1, started_, finish_, cancelled_);
  StartAgent();
  coordinator_.Offer(SolveLease(1, 11, 1));
  ASSERT_TRUE(started_.Wait());
  coordinator_.Stop();
  coordinator_.Change([](auto& how) { how.adopt = false; });
  coordinator_.Start();
  EXPECT_TRUE(cancelled_.Wait());
  agent_->Drain();
  JoinAgent();
  EXPECT_TRUE(coordinator_.seen().fails.empty());
}

TEST_F(AgentTest, WorkStopsWhenTheCoordinatorIsGoneForLongerThanTheLease) {
  coordinator_.Change([](auto& how) { how.lease_s = 0.4; });
  runner_.Hold(1, started_, finish_, cancelled_);
  StartAgent();
  coordinator_.Offer(SolveLease(1, 11, 1));
  ASSERT_TRUE(started_.Wait());
  // Answered heartbeats carry the work over several leases.
  ASSERT_TRUE(coordinator_.WaitFor([](const Seen& seen) { return seen.heartbeats.size() >= 12; }));
  EXPECT_FALSE(cancelled_.Wait(std::chrono::seconds(0)));
  coordinator_.Stop();
  EXPECT_TRUE(cancelled_.Wait());
}

TEST_F(AgentTest, WorkStopsWhenHeartbeatsAreNotAnsweredThoughTheStreamIsOpen) {
  coordinator_.Change([](auto& how) {
    how.lease_s = 0.4;
    how.answer_heartbeats = false;
  });
  runner_.Hold(1, started_, finish_, cancelled_);
  StartAgent();
  coordinator_.Offer(SolveLease(1, 11, 1));
  ASSERT_TRUE(started_.Wait());
  EXPECT_TRUE(cancelled_.Wait());
  EXPECT_TRUE(coordinator_.WaitFor([](const Seen& seen) { return seen.hellos.size() >= 2; }))
      << "and it connects anew";
}

// An answer that was long under way says that the coordinator lived when the heartbeat came: the
// lease is counted from when that was sent.
TEST_F(AgentTest, ALateAnswerToAnEarlyHeartbeatCarriesTheWorkNoFurther) {
  using Seconds = std::chrono::duration<double>;
  constexpr Seconds kLease(3), kLate(1.8);
  coordinator_.Change([&](auto& how) {
    how.lease_s = kLease.count();
    how.answer_heartbeats = false;
  });
  runner_.Hold(1, started_, finish_, cancelled_);
  StartAgent();
  coordinator_.Offer(SolveLease(1, 11, 1));
  ASSERT_TRUE(started_.Wait());
  ASSERT_TRUE(coordinator_.WaitFor([](const Seen& seen) { return !seen.heartbeats.empty(); }));
  std::this_thread::sleep_for(kLate);
  coordinator_.SendAck(coordinator_.seen().heartbeats[0].sequence());
  const auto answered = std::chrono::steady_clock::now();
  ASSERT_TRUE(cancelled_.Wait());
  const Seconds more = std::chrono::steady_clock::now() - answered;
  EXPECT_LT(more, kLease - kLate / 2);
  EXPECT_GT(more, (kLease - kLate) / 2) << "the answer counts";
}

TEST_F(AgentTest, HeartbeatsCarryProgressAndReportsThatWait) {
  coordinator_.Change([](auto& how) {
    how.lease_s = 2;
    how.report_status = grpc::StatusCode::INTERNAL;
  });
  runner_.Hold(1, started_, finish_, cancelled_);
  StartAgent();
  coordinator_.Offer(SolveLease(1, 11, 1));
  coordinator_.Offer(SolveLease(2, 12, 2));
  EXPECT_TRUE(coordinator_.WaitFor([](const Seen& seen) {
    if (seen.heartbeats.empty() || seen.heartbeats.back().running_size() != 2) return false;
    const auto& running = seen.heartbeats.back().running();
    return running[0].stage() == "anneal" && running[0].fraction() == 0.5 &&
           running[1].stage() == "report" && running[1].attempt().fence() == 12;
  }));
}

TEST_F(AgentTest, AStoreThatDoesNotAnswerSilencesNoHeartbeat) {
  coordinator_.Change([](auto& how) { how.lease_s = 0.4; });
  options_.store_look_s = 0.01;
  runner_.Hold(1, started_, finish_, cancelled_);
  StartAgent();
  coordinator_.Offer(SolveLease(1, 11, 1));
  ASSERT_TRUE(started_.Wait());
  const std::string marker = dir_ + "/store/.parallax-store";
  fs::rename(marker, dir_ + "/marker");
  ASSERT_EQ(::mkfifo(marker.c_str(), 0600), 0);
  // Opens as soon as a look waits at the other end, which then lasts until it is closed.
  int look = -1;
  while ((look = ::open(marker.c_str(), O_WRONLY | O_NONBLOCK)) < 0) std::this_thread::yield();
  const size_t before = coordinator_.seen().heartbeats.size();
  EXPECT_TRUE(coordinator_.WaitFor(
      [before](const Seen& seen) { return seen.heartbeats.size() >= before + 12; }));
  EXPECT_FALSE(cancelled_.Wait(std::chrono::seconds(0)));
  fs::rename(dir_ + "/marker", marker);
  ::close(look);
  finish_.Open();
  EXPECT_TRUE(coordinator_.WaitFor([](const Seen& seen) { return seen.completes.size() == 1; }));
}

TEST_F(AgentTest, AStoreThatGoesTakesNoWorkUntilItIsBack) {
  options_.store_look_s = 0.01;
  StartAgent();
  coordinator_.Offer(RenderLease(1, 11, {0}));
  ASSERT_TRUE(coordinator_.WaitFor([](const Seen& seen) { return seen.completes.size() == 1; }));
  fs::rename(dir_ + "/store", dir_ + "/disk");
  fs::create_directory(dir_ + "/store");
  coordinator_.Offer(RenderLease(2, 12, {0}));  // Uses credit given before.
  ASSERT_TRUE(coordinator_.WaitFor([](const Seen& seen) { return seen.hand_backs.size() == 1; }));
  EXPECT_TRUE(fs::is_empty(dir_ + "/store")) << "nothing is written below a bare mount point";
  fs::remove(dir_ + "/store");
  fs::rename(dir_ + "/disk", dir_ + "/store");
  // Until the next look it hands jobs back.
  for (size_t ended = 3; coordinator_.seen().completes.size() < 2; ++ended) {
    coordinator_.Offer(RenderLease(static_cast<int64_t>(ended), 10 + ended, {0}));
    ASSERT_TRUE(coordinator_.WaitFor([ended](const Seen& seen) {
      return seen.completes.size() + seen.hand_backs.size() == ended;
    }));
  }
  EXPECT_EQ(coordinator_.seen().fails.size(), 0u);
}

TEST_F(AgentTest, AHungJobIsReportedAsFailedAndTheWorkerDrains) {
  // Deaf to its cancellation, as a loop without end is.
  runner_.On(1, [this](const CancelToken&) -> absl::StatusOr<v1::SolveResult> {
    started_.Open();
    finish_.Wait();
    return v1::SolveResult();
  });
  options_.hang_s = 0.1;
  StartAgent();
  coordinator_.Offer(SolveLease(5, 50, 1));
  ASSERT_TRUE(started_.Wait());
  JoinAgent();
  ASSERT_TRUE(summary_.ok()) << summary_.status();
  EXPECT_EQ(summary_->hung, 1);
  EXPECT_EQ(summary_->stuck, 1);
  EXPECT_EQ(summary_->handed_back, 0);
  const Seen seen = coordinator_.seen();
  ASSERT_EQ(seen.fails.size(), 1u);
  EXPECT_EQ(seen.fails[0].attempt().job_id(), 5);
  EXPECT_EQ(seen.fails[0].fingerprint(), "DEADLINE_EXCEEDED@solve/anneal: no progress for # s");
  EXPECT_TRUE(seen.fails[0].retryable());
  EXPECT_TRUE(seen.completes.empty());
  finish_.Open();
}

TEST_F(AgentTest, DrainFinishesWhatRunsAndTakesNothingNew) {
  runner_.Hold(1, started_, finish_, cancelled_);
  StartAgent();
  coordinator_.Offer(SolveLease(1, 11, 1));
  ASSERT_TRUE(started_.Wait());
  agent_->Drain();
  ASSERT_TRUE(coordinator_.WaitFor([](const Seen& seen) {
    return !seen.heartbeats.empty() && seen.heartbeats.back().draining();
  }));
  coordinator_.Offer(SolveLease(2, 12, 2));  // Uses credit given before.
  ASSERT_TRUE(coordinator_.WaitFor([](const Seen& seen) { return seen.hand_backs.size() == 1; }));
  EXPECT_EQ(coordinator_.seen().hand_backs[0].attempt().fence(), 12u);
  finish_.Open();
  JoinAgent();
  ASSERT_TRUE(summary_.ok());
  EXPECT_EQ(summary_->succeeded, 1);
  ASSERT_EQ(coordinator_.seen().completes.size(), 1u);
  EXPECT_EQ(coordinator_.seen().completes[0].attempt().fence(), 11u);
}

TEST_F(AgentTest, AfterTheGraceRunningWorkIsHandedBack) {
  options_.grace_s = 0.05;
  runner_.Hold(1, started_, finish_, cancelled_);
  StartAgent();
  coordinator_.Offer(SolveLease(1, 11, 1));
  ASSERT_TRUE(started_.Wait());
  agent_->Drain();
  JoinAgent();
  EXPECT_TRUE(cancelled_.Wait());
  ASSERT_TRUE(summary_.ok());
  EXPECT_EQ(summary_->handed_back, 1);
  const Seen seen = coordinator_.seen();
  ASSERT_EQ(seen.hand_backs.size(), 1u) << "read before Run() returned";
  EXPECT_EQ(seen.hand_backs[0].attempt().fence(), 11u);
  EXPECT_TRUE(seen.fails.empty());
}

TEST_F(AgentTest, ASecondSignalHandsBackAtOnceEvenWhatDoesNotStop) {
  options_.hand_back_s = 0.05;
  runner_.On(1, [&](const CancelToken&) -> absl::StatusOr<v1::SolveResult> {
    started_.Open();
    finish_.Wait();
    return v1::SolveResult();
  });
  StartAgent();
  coordinator_.Offer(SolveLease(1, 11, 1));
  ASSERT_TRUE(started_.Wait());
  agent_->Drain();
  agent_->HandBack();
  JoinAgent();
  EXPECT_EQ(summary_->stuck, 1);
  EXPECT_EQ(coordinator_.seen().hand_backs.size(), 1u);
  finish_.Open();
}

TEST_F(AgentTest, ACoordinatorThatRefusesTheWorkerEndsIt) {
  coordinator_.Change([](auto& how) { how.hello_status = grpc::StatusCode::ALREADY_EXISTS; });
  StartAgent();
  JoinAgent();
  EXPECT_EQ(summary_.status().code(), absl::StatusCode::kAlreadyExists);
  EXPECT_NE(summary_.status().ToString().find("go away"), std::string::npos);
}

TEST_F(AgentTest, ACoordinatorOfAnotherProtocolEndsTheWorkerWithOneLine) {
  coordinator_.Change([](auto& how) { how.protocol = 0; });  // A release that does not send it.
  StartAgent();
  JoinAgent();
  EXPECT_EQ(summary_.status().code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_NE(summary_.status().ToString().find("speaks work protocol 0"), std::string::npos);
  EXPECT_NE(summary_.status().ToString().find("give both the same release"), std::string::npos);
}

TEST_F(AgentTest, ALeaseOfAKindThatItDoesNotDoIsReportedAsFailed) {
  StartAgent();
  v1::Lease lease = SolveLease(1, 11, 1);
  lease.set_kind("bake");
  coordinator_.Offer(lease);
  ASSERT_TRUE(coordinator_.WaitFor([](const Seen& seen) { return seen.fails.size() == 1; }));
  EXPECT_NE(coordinator_.seen().fails[0].error().find("no jobs of kind 'bake'"), std::string::npos);
}

TEST_F(AgentTest, ACoordinatorThatComesLateIsWaitedFor) {
  coordinator_.Stop();
  StartAgent();
  coordinator_.Start();
  coordinator_.Offer(SolveLease(1, 11, 1));
  EXPECT_TRUE(coordinator_.WaitFor([](const Seen& seen) { return seen.completes.size() == 1; }));
}

TEST_F(AgentTest, BadOptionsAreRefused) {
  AgentOptions bad = options_;
  bad.slots = 0;
  EXPECT_EQ(Agent::Create(bad, handlers_, Clock::System()).status().code(),
            absl::StatusCode::kInvalidArgument);
  bad = options_;
  bad.kinds = {"bake"};
  EXPECT_EQ(Agent::Create(bad, handlers_, Clock::System()).status().code(),
            absl::StatusCode::kInvalidArgument);
  bad = options_;
  bad.name = "../worker";
  EXPECT_EQ(Agent::Create(bad, handlers_, Clock::System()).status().code(),
            absl::StatusCode::kInvalidArgument);
}

}  // namespace
}  // namespace parallax
