// The farm's figures outlive a restart, and are bounded.
#include <sqlite3.h>

#include "tests/coordinator/queue/queue_fixture.h"

namespace parallax {
namespace {

using testing::Each;
using testing::Field;
using testing::Ge;
using testing::SizeIs;

class FarmHistory : public QueueTest {
 protected:
  void Keep(double unix_s, int64_t ready) {
    queue_->KeepSample({.unix_s = unix_s, .pairs_per_hour = 120.5, .ready = ready, .slots = 8});
  }
  std::vector<HistorySample> Samples(double since = 0) {
    Tick();  // Behind the samples.
    auto samples = queue_->ListSamples(since);
    EXPECT_TRUE(samples.ok()) << samples.status();
    return samples.ok() ? *std::move(samples) : std::vector<HistorySample>();
  }
};

TEST_F(FarmHistory, ARestartFindsTheSamplesOfTheDay) {
  const double now = clock_.UnixSeconds();
  for (int i = 0; i < 3; ++i) Keep(now + 60 * i, i);
  ASSERT_THAT(Samples(), SizeIs(3));
  Reopen();
  const auto samples = Samples(now + 60);
  ASSERT_THAT(samples, SizeIs(2));
  EXPECT_EQ(samples[0].ready, 1);
  EXPECT_EQ(samples[1].ready, 2);
  EXPECT_EQ(samples[1].pairs_per_hour, 120.5);
  EXPECT_EQ(samples[1].slots, 8);
}

TEST_F(FarmHistory, TwoDaysAreKeptAndNoFutureThatTheClockWasSetBackFrom) {
  const double begin = clock_.UnixSeconds();
  for (int minute = 0; minute < 3000; ++minute) Keep(begin + 60 * minute, minute);
  const auto samples = Samples();
  EXPECT_THAT(samples, SizeIs(2 * 24 * 60 + 1));
  EXPECT_THAT(samples, Each(Field(&HistorySample::ready, Ge(119))));
  Keep(begin, 7);
  EXPECT_THAT(Samples(), Each(Field(&HistorySample::unix_s, testing::Le(begin + 3600))));
}

}  // namespace
}  // namespace parallax
