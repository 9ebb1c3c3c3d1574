// What happens to studies is kept for those who are to be told, until they have been.
#include "tests/coordinator/queue/queue_fixture.h"

namespace parallax {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;
using testing::SizeIs;

class NoticesTest : public QueueTest {
 protected:
  NoticesTest() {
    options_.notice_targets = {"webhook"};
    Reopen();
  }
  std::vector<Notice> Due() {
    const auto due = queue_->ListNotices(100);
    EXPECT_TRUE(due.ok()) << due.status();
    return due.value_or(std::vector<Notice>());
  }
  std::vector<std::string> Events() {
    std::vector<std::string> events;
    for (const Notice& notice : Due()) events.push_back(notice.event);
    return events;
  }
  void FailOne() { Fail(Failure(LeaseOne(Solver("w")), "w", "no such file", /*retryable=*/false)); }
};

TEST_F(NoticesTest, TheEndOfAStudyIsKeptForEachReceiverUntilItHasIt) {
  options_.notice_targets = {"webhook", "command"};
  Reopen();
  const StudyId study = Submit({.pairs = 2, .rigs_per_scene = 2});
  EXPECT_THAT(Due(), IsEmpty());
  WorkOff(AnyWorker("w"));
  Reopen();
  const std::vector<Notice> due = Due();
  ASSERT_THAT(due, SizeIs(2));
  EXPECT_EQ(due[0].event, "done");
  EXPECT_EQ(due[0].study, study.value);
  EXPECT_EQ(due[0].since_unix_s, clock_.UnixSeconds());
  EXPECT_EQ(due[1].target, "command");
  ASSERT_TRUE(queue_->EndNotice(due[0]).ok());
  ASSERT_TRUE(queue_->DelayNotice(due[1], 30).ok());
  EXPECT_THAT(Due(), IsEmpty());
  clock_.Advance(30);
  ASSERT_THAT(Due(), SizeIs(1));
  EXPECT_EQ(Due()[0].target, "command");
  EXPECT_EQ(Due()[0].tries, 1);
}

TEST_F(NoticesTest, FailuresOfAMinuteAreOneAndLaterOnesAnother) {
  Submit({.pairs = 40});
  FailOne();
  FailOne();
  EXPECT_THAT(Due(), IsEmpty()) << "more may follow";
  clock_.Advance(60);
  ASSERT_THAT(Events(), ElementsAre("failed"));
  const Notice first = Due()[0];
  FailOne();  // While it is on its way.
  ASSERT_TRUE(queue_->EndNotice(first).ok());
  EXPECT_THAT(Due(), IsEmpty());
  clock_.Advance(60);
  ASSERT_THAT(Events(), ElementsAre("failed"));
  ASSERT_TRUE(queue_->EndNotice(Due()[0]).ok());
  clock_.Advance(3600);
  EXPECT_THAT(Due(), IsEmpty());
}

TEST_F(NoticesTest, AJobThatIsTriedAgainIsNoFailure) {
  Submit({.pairs = 4});
  Fail(Failure(LeaseOne(Solver("w")), "w", "boom"));
  clock_.Advance(3600);
  EXPECT_THAT(Due(), IsEmpty());
}

TEST_F(NoticesTest, WithoutReceiversNothingIsKept) {
  options_.notice_targets.clear();
  Reopen();
  const StudyId study = Submit({.pairs = 2, .rigs_per_scene = 2});
  WorkOff(AnyWorker("w"));
  ASSERT_TRUE(queue_->RaiseNotice(study, kNoticeStalled).ok());
  EXPECT_THAT(Due(), IsEmpty());
}

TEST_F(NoticesTest, AClockThatWasSetBackHoldsNothingUp) {
  const StudyId study = Submit({.pairs = 4});
  ASSERT_TRUE(queue_->RaiseNotice(study, kNoticeStalled).ok());
  clock_.JumpWall(-86400);
  EXPECT_THAT(Events(), ElementsAre("stalled"));
}

}  // namespace
}  // namespace parallax
