// The steps of a worker that is told to leave.
#include "worker/agent/session/departure.h"

#include <gtest/gtest.h>

namespace parallax {
namespace {

using std::chrono::seconds;

constexpr SteadyTime kStart{seconds(1000)};
constexpr DepartureOptions kOptions{.grace_s = 60, .long_grace_s = 600, .hand_back_s = 3};

TEST(Departure, StaysWithoutAnOrder) {
  Departure departure(kOptions);
  const Departure::Step step = departure.Advance(LeaveOrder::kStay, kStart + seconds(100'000));
  EXPECT_FALSE(step.begins || step.grace_s || step.hands_back || departure.leaving());
  EXPECT_EQ(departure.deadline(), SteadyTime::max());
}

TEST(Departure, FinishesWorkForTheGraceThenHandsItBack) {
  Departure departure(kOptions);
  Departure::Step step = departure.Advance(LeaveOrder::kDrain, kStart);
  EXPECT_TRUE(step.begins);
  EXPECT_EQ(step.grace_s, 60);
  EXPECT_FALSE(step.hands_back);
  step = departure.Advance(LeaveOrder::kDrain, kStart + seconds(59));
  EXPECT_FALSE(step.begins || step.grace_s || step.hands_back) << "each is told once";
  EXPECT_FALSE(departure.IsOver(kStart + seconds(1000))) << "nothing was stopped yet";
  step = departure.Advance(LeaveOrder::kDrain, kStart + seconds(60));
  EXPECT_TRUE(step.hands_back);
  EXPECT_FALSE(departure.IsOver(kStart + seconds(62)));
  EXPECT_TRUE(departure.IsOver(kStart + seconds(63)));
  EXPECT_FALSE(departure.Advance(LeaveOrder::kDrain, kStart + seconds(64)).hands_back);
}

TEST(Departure, ASharperOrderBringsTheEndNearerAndABlunterOneChangesNothing) {
  Departure departure(kOptions);
  EXPECT_EQ(departure.Advance(LeaveOrder::kDrainLong, kStart).grace_s, 600);
  EXPECT_EQ(departure.deadline(), kStart + seconds(600));
  EXPECT_EQ(departure.Advance(LeaveOrder::kDrain, kStart + seconds(10)).grace_s, 60);
  EXPECT_EQ(departure.deadline(), kStart + seconds(70));
  EXPECT_FALSE(departure.Advance(LeaveOrder::kDrainLong, kStart + seconds(20)).grace_s);
  EXPECT_EQ(departure.deadline(), kStart + seconds(70));
  // Near the end of the long grace, the short one does not put it off.
  Departure late(kOptions);
  late.Advance(LeaveOrder::kDrainLong, kStart);
  late.Advance(LeaveOrder::kDrain, kStart + seconds(590));
  EXPECT_EQ(late.deadline(), kStart + seconds(600));
}

TEST(Departure, AnOrderToHandBackSkipsTheGrace) {
  Departure departure(kOptions);
  const Departure::Step step = departure.Advance(LeaveOrder::kHandBack, kStart);
  EXPECT_TRUE(step.begins && step.hands_back);
  EXPECT_EQ(departure.deadline(), kStart + seconds(3));
}

}  // namespace
}  // namespace parallax
