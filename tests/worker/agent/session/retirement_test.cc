// Workers that leave by themselves.
#include "worker/agent/session/retirement.h"

#include <gtest/gtest.h>

#include "tests/worker/agent/agent_fixture.h"

namespace parallax {
namespace {

using std::chrono::seconds;
using Seen = FakeCoordinator::Seen;

constexpr SteadyTime kRetirementStart{seconds(1000)};

TEST(Retirement, LeavesAfterIdlingAndNotWhileItWorks) {
  Retirement retirement({.idle_s = 60}, kRetirementStart);
  EXPECT_EQ(retirement.WhyLeave(kRetirementStart + seconds(59)), nullptr);
  EXPECT_EQ(retirement.NextLook(kRetirementStart + seconds(500)), kRetirementStart + seconds(60));
  retirement.Observe(/*busy=*/true, kRetirementStart + seconds(59));
  EXPECT_EQ(retirement.WhyLeave(kRetirementStart + seconds(1000)), nullptr);
  retirement.Observe(/*busy=*/false, kRetirementStart + seconds(1000));
  retirement.Observe(/*busy=*/false, kRetirementStart + seconds(1030));
  EXPECT_EQ(retirement.WhyLeave(kRetirementStart + seconds(1059)), nullptr);
  EXPECT_STREQ(retirement.WhyLeave(kRetirementStart + seconds(1060)), "idle");
}

TEST(Retirement, WithoutOptionsItStaysForEver) {
  Retirement retirement({}, kRetirementStart);
  EXPECT_EQ(retirement.WhyLeave(kRetirementStart + seconds(10'000'000)), nullptr);
  EXPECT_TRUE(retirement.TakesWork(kRetirementStart + seconds(10'000'000)));
}

TEST(Retirement, TakesNoJobThatTheDeadlineWouldCutOff) {
  Retirement retirement({.deadline = kRetirementStart + seconds(600), .margin_s = 20},
                        kRetirementStart);
  EXPECT_TRUE(retirement.TakesWork(kRetirementStart + seconds(579)));
  EXPECT_FALSE(retirement.TakesWork(kRetirementStart + seconds(580)));
  retirement.Began({1, 11}, kRetirementStart);
  retirement.Observe(/*busy=*/true, kRetirementStart);
  retirement.Ended({1, 11}, kRetirementStart + seconds(100));
  EXPECT_TRUE(retirement.TakesWork(kRetirementStart + seconds(499)));
  EXPECT_FALSE(retirement.TakesWork(kRetirementStart + seconds(500))) << "its last job took 100 s";
  EXPECT_EQ(retirement.WhyLeave(kRetirementStart + seconds(500)), nullptr)
      << "something still runs";
  retirement.Observe(/*busy=*/false, kRetirementStart + seconds(510));
  EXPECT_STREQ(retirement.WhyLeave(kRetirementStart + seconds(510)),
               "no further job would end before the deadline");
  retirement.Observe(/*busy=*/true, kRetirementStart + seconds(520));
  EXPECT_STREQ(retirement.WhyLeave(kRetirementStart + seconds(580)), "the deadline is near");
}

TEST_F(AgentTest, AnIdleWorkerEndsByItself) {
  options_.idle_exit_s = 1;  // Counted from the start: more than it takes to connect.
  runner_.Hold(1, started_, finish_, cancelled_);
  StartAgent();
  coordinator_.Offer(SolveLease(1, 11, 1));
  ASSERT_TRUE(started_.Wait());
  std::this_thread::sleep_for(std::chrono::milliseconds(1500));
  EXPECT_TRUE(coordinator_.seen().hand_backs.empty()) << "it works, so it stays";
  finish_.Open();
  JoinAgent();
  ASSERT_TRUE(summary_.ok());
  EXPECT_EQ(summary_->succeeded, 1);
  EXPECT_EQ(summary_->handed_back, 0);
}

TEST_F(AgentTest, BeforeItsDeadlineAWorkerHandsBackWhatRuns) {
  options_.grace_s = 0.2;
  options_.deadline_unix_s = Clock::System().UnixSeconds() + 0.8;
  runner_.Hold(1, started_, finish_, cancelled_);
  StartAgent();
  coordinator_.Offer(SolveLease(1, 11, 1));
  ASSERT_TRUE(started_.Wait());
  JoinAgent();
  EXPECT_TRUE(cancelled_.Wait());
  ASSERT_TRUE(summary_.ok());
  EXPECT_EQ(summary_->handed_back, 1);
}

TEST_F(AgentTest, ALongDrainWaitsAndADrainShortensIt) {
  options_.long_grace_s = 1000;
  options_.grace_s = 0.05;
  runner_.Hold(1, started_, finish_, cancelled_);
  StartAgent();
  coordinator_.Offer(SolveLease(1, 11, 1));
  ASSERT_TRUE(started_.Wait());
  agent_->DrainLong();
  ASSERT_TRUE(coordinator_.WaitFor([](const Seen& seen) {
    return !seen.heartbeats.empty() && seen.heartbeats.back().draining();
  }));
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  EXPECT_TRUE(coordinator_.seen().hand_backs.empty()) << "the long grace is not over";
  agent_->Drain();
  JoinAgent();
  ASSERT_TRUE(summary_.ok());
  EXPECT_EQ(summary_->handed_back, 1);
}

}  // namespace
}  // namespace parallax
