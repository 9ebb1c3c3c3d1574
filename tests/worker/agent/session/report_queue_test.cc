// Which report is sent next, and when one leaves.
#include "worker/agent/session/report_queue.h"

#include <gtest/gtest.h>

#include "common/base/status.h"

namespace parallax {
namespace {

Report ReportOn(int64_t job, const std::string& coordinator) {
  v1::CompleteRequest body;
  body.mutable_attempt()->set_job_id(job);
  body.set_coordinator_id(coordinator);
  return {std::move(body)};
}

TEST(ReportQueue, AReportThatIsNotAnsweredWaitsAndDelaysNoOther) {
  ReportQueue queue({.backoff_base_s = 1000, .backoff_cap_s = 1000}, Clock::System(),
                    Rng(SceneSeed{1}, "test"));
  queue.Add(ReportOn(1, "a"), /*leftover=*/true);
  queue.Add(ReportOn(2, "a"), /*leftover=*/false);
  queue.Add(ReportOn(3, "b"), /*leftover=*/false);
  EXPECT_EQ(queue.Next(), nullptr) << "no coordinator is reached";
  queue.SetCoordinator("a");
  EXPECT_TRUE(queue.HasUntriedLeftovers("a"));
  ReportQueue::Entry* const first = queue.Next();
  ASSERT_EQ(first->report.attempt().job_id(), 1);
  queue.Answered(first, Unavailable("not now"));
  EXPECT_FALSE(queue.HasUntriedLeftovers("a"));
  EXPECT_GT(first->due, Clock::System().Steady());
  ReportQueue::Entry* const second = queue.Next();
  ASSERT_EQ(second->report.attempt().job_id(), 2);
  queue.Answered(second, absl::OkStatus());
  EXPECT_EQ(queue.Next(), first) << "the other coordinator's waits";
  queue.Answered(first, InvalidArgument("not so"));
  EXPECT_EQ(queue.Next(), nullptr);
  EXPECT_TRUE(queue.Pending("a").empty());
  EXPECT_EQ(queue.Pending("b").size(), 1u);
  EXPECT_EQ(queue.size(), 1u);
}

}  // namespace
}  // namespace parallax
