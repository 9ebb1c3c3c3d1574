#include "coordinator/queue/commands/policy.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace parallax {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

TEST(BackoffSeconds, GrowsWithinItsBounds) {
  const RetryPolicy policy;
  for (int failures = 0; failures < 12; ++failures) {
    EXPECT_EQ(BackoffSeconds(policy, failures, 0), 5);
    EXPECT_LE(BackoffSeconds(policy, failures, 0.999999), 600);
  }
  EXPECT_NEAR(BackoffSeconds(policy, 1, 0.999999), 20, 0.01);
  EXPECT_NEAR(BackoffSeconds(policy, 2, 0.999999), 80, 0.01);
  EXPECT_NEAR(BackoffSeconds(policy, 10, 0.999999), 600, 0.01);
  EXPECT_NEAR(BackoffSeconds(policy, 1, 0.5), 12.5, 1e-9);
}

TEST(JudgeAppFailure, FollowsTheLedger) {
  const struct {
    FailureHistory history;
    FailureVerdict verdict;
  } cases[] = {
      {{.app_failures = 1, .workers_with_fingerprint = 1}, FailureVerdict::kRetryLater},
      {{.app_failures = 2, .workers_with_fingerprint = 1}, FailureVerdict::kRetryLater},
      {{.app_failures = 3, .workers_with_fingerprint = 1}, FailureVerdict::kFail},
      {{.app_failures = 2, .workers_with_fingerprint = 2}, FailureVerdict::kQuarantine},
      {{.app_failures = 1, .infra_losses = 9}, FailureVerdict::kRetryLater},
      {{.app_failures = 1, .retryable = false}, FailureVerdict::kFail},
  };
  for (const auto& c : cases) EXPECT_EQ(JudgeAppFailure({}, c.history), c.verdict);
}

TEST(JudgeLoss, RetriesAtOnceUntilTheJobIsSuspect) {
  const struct {
    FailureHistory history;
    FailureVerdict verdict;
  } cases[] = {
      {{.infra_losses = 1, .workers_lost = 1}, FailureVerdict::kRetryNow},
      {{.infra_losses = 9, .workers_lost = 2}, FailureVerdict::kRetryNow},
      {{.infra_losses = 3, .workers_lost = 3}, FailureVerdict::kQuarantine},
      {{.infra_losses = 9, .workers_lost = 9, .lost_without_it = true}, FailureVerdict::kRetryNow},
      {{.infra_losses = 3, .workers_lost = 3, .lost_with_another = true},
       FailureVerdict::kRetryNow},
      {{.infra_losses = 10, .workers_lost = 10, .lost_without_it = true},
       FailureVerdict::kQuarantine},
      {{.infra_losses = 10, .workers_lost = 0}, FailureVerdict::kQuarantine},
      {{.app_failures = 2, .infra_losses = 5}, FailureVerdict::kRetryNow},
  };
  for (const auto& c : cases) EXPECT_EQ(JudgeLoss({}, c.history), c.verdict);
}

TEST(OrderStudies, PriorityThenPassThenId) {
  const StudyShare studies[] = {{.study = 1, .priority = 0, .pass = 5},
                                {.study = 2, .priority = 1, .pass = 9},
                                {.study = 3, .priority = 0, .pass = 2},
                                {.study = 4, .priority = 0, .pass = 2},
                                {.study = 5, .priority = 9, .open = false}};
  EXPECT_THAT(OrderStudies(studies, {}), ElementsAre(2, 3, 4, 1));
}

TEST(OrderStudies, WaitingRaisesAStudyAboveAHigherPriority) {
  StudyShare studies[] = {{.study = 1, .priority = 0}, {.study = 2, .priority = 2}};
  studies[0].waiting_s = 2 * kAgeingStepS;
  studies[1].pass = 1;
  EXPECT_THAT(OrderStudies(studies, {}), ElementsAre(1, 2));
  studies[0].waiting_s -= 1;
  EXPECT_THAT(OrderStudies(studies, {}), ElementsAre(2, 1));
}

TEST(OrderStudies, SharesEquallyByStrides) {
  StudyShare studies[] = {{.study = 1}, {.study = 2}, {.study = 3}};
  int served[3] = {};
  for (int i = 0; i < 300; ++i) {
    const auto order = OrderStudies(studies, {});
    const size_t first = static_cast<size_t>(order.front() - 1);
    studies[first].pass += 1;
    ++served[first];
  }
  EXPECT_THAT(served, ElementsAre(100, 100, 100));
}

TEST(OrderStudies, LeavesOutWhatTheWorkerCannotDo) {
  const std::string tags[] = {"gpu"};
  const StudyShare studies[] = {{.study = 1, .needs_tags = tags},
                                {.study = 2, .needs_memory_mb = 64'000}};
  EXPECT_THAT(OrderStudies(studies, {.memory_mb = 1000}), IsEmpty());
  EXPECT_THAT(OrderStudies(studies, {.memory_mb = 1000, .tags = tags}), ElementsAre(1));
  EXPECT_THAT(OrderStudies(studies, {.memory_mb = 64'000}), ElementsAre(2));
}

TEST(PickJob, LeavesWhatOneHasJustLostToOthersForAWhile) {
  const JobCandidate mine{1, "w", 1};
  const JobCandidate old{2, "w", kElsewhereS};
  const JobCandidate fresh{3, "", 0};
  const JobCandidate theirs{4, "v", 0};
  const std::vector<JobCandidate> none;
  EXPECT_EQ(PickJob(none, "w", true), -1);
  EXPECT_EQ(PickJob(std::vector{mine}, "w", true), -1);
  EXPECT_EQ(PickJob(std::vector{mine}, "w", false), 0);
  EXPECT_EQ(PickJob(std::vector{old}, "w", true), 0);
  EXPECT_EQ(PickJob(std::vector{mine, fresh}, "w", true), 1);
  EXPECT_EQ(PickJob(std::vector{theirs, mine}, "w", true), 0);
}

}  // namespace
}  // namespace parallax
