// Rates of a farm whose list of studies changes while it works.
#include "coordinator/http/status_sampler.h"

#include "tests/coordinator/http/http_fixture.h"

namespace parallax {
namespace {

// As many as the snapshot's list of studies has.
constexpr int kListed = 50;

class StatusSamplerTest : public HttpTest {
 protected:
  // Its jobs are leased before those of other studies.
  int64_t SubmitUrgent() {
    return Submit({.name = "urgent", .seed = 999, .pairs = 60, .priority = 10});
  }
  void SubmitOthers(int studies) {
    for (; studies > 0; --studies) Submit({.seed = ++seed_, .pairs = 2});
  }
  std::shared_ptr<const StatusSnapshot> TakeAfter(double seconds) {
    clock_.Advance(seconds);
    const auto snapshot = sampler_.Take();
    EXPECT_TRUE(snapshot.ok()) << snapshot.status();
    return *snapshot;
  }
  // Returns the last of several snapshots, between which a worker does some jobs.
  std::shared_ptr<const StatusSnapshot> TakeWhileItWorks() {
    TakeAfter(1);
    for (int i = 0; i < 6; ++i) {
      Work(9);
      TakeAfter(60);
    }
    return TakeAfter(1);
  }

  uint64_t seed_ = 1;
  FakeClock clock_;
  StatusSampler sampler_{"", clock_, *queue_, *server_};
};

TEST_F(StatusSamplerTest, AStudyThatIsOlderThanTheListCounts) {
  const int64_t oldest = SubmitUrgent();
  SubmitOthers(kListed);
  const auto snapshot = TakeWhileItWorks();
  ASSERT_EQ(snapshot->older_unfinished.size(), 1u);
  EXPECT_GT(snapshot->pairs_per_hour, 0);
  EXPECT_EQ(snapshot->eta_s.count(oldest), 1u);
}

TEST_F(StatusSamplerTest, TheRateOutlivesStudiesThatLeaveTheList) {
  const int64_t first = Submit({.pairs = 4});
  const int64_t second = Submit({.seed = 2, .pairs = 4});
  Work();
  seed_ = 2;
  SubmitOthers(kListed - 3);
  SubmitUrgent();
  const double rate = TakeWhileItWorks()->pairs_per_hour;
  ASSERT_GT(rate, 0);
  SubmitOthers(1);  // `first` has no place in the list any more.
  EXPECT_NEAR(TakeAfter(1)->pairs_per_hour, rate, 0.05 * rate);
  ASSERT_TRUE(queue_->Forget(StudyId{second}, "", "tester").ok());  // It has again.
  const auto snapshot = TakeAfter(1);
  EXPECT_EQ(snapshot->studies.back().study_id(), first);
  EXPECT_NEAR(snapshot->pairs_per_hour, rate, 0.05 * rate);
}

}  // namespace
}  // namespace parallax
