#include "common/base/system/clock.h"

#include <gtest/gtest.h>

#include <ctime>

namespace parallax {
namespace {

TEST(SystemClock, AgreesWithTheMachineAndNeverRunsBack) {
  Clock& clock = Clock::System();
  EXPECT_NEAR(clock.UnixSeconds(), static_cast<double>(std::time(nullptr)), 2.0);
  SteadyTime last = clock.Steady();
  for (int i = 0; i < 1000; ++i) {
    const SteadyTime now = clock.Steady();
    ASSERT_GE(now, last);
    last = now;
  }
}

}  // namespace
}  // namespace parallax
