#include "coordinator/queue/commands/policy.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

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
      {{.app_failures = 1, .retryable = false}, FailureVerdict::kFail},
  };
  for (const auto& c : cases) EXPECT_EQ(JudgeAppFailure({}, c.history), c.verdict);
}

// Losses, all losses, the job's share of the workers' time, its machines and the farm's.
TEST(JudgeLoss, BlamesAJobOnlyWhereChanceCantHaveLostTheWorkers) {
  const auto retry = FailureVerdict::kRetryNow, blame = FailureVerdict::kQuarantine;
  const struct {
    const char* what;
    LossHistory history;
    FailureVerdict verdict;
  } cases[] = {
      {"its first loss", {}, retry},
      {"once more among a hundred workers",
       {.losses = 1, .all = 1, .share = 0.01, .machines = 2, .machines_all = 9},
       retry},
      {"three times more among a hundred workers, and no other was lost",
       {.losses = 3, .all = 3, .share = 0.01, .machines = 4, .machines_all = 9},
       blame},
      {"on two machines of nine",
       {.losses = 3, .all = 3, .share = 0.01, .machines = 2, .machines_all = 9},
       retry},
      {"on both machines of two",
       {.losses = 12, .all = 12, .share = 0.3, .machines = 2, .machines_all = 2},
       blame},
      {"a third of the losses where it is a third of the work",
       {.losses = 40, .all = 120, .share = 0.34, .machines = 3, .machines_all = 3},
       retry},
      {"every loss of three workers, a few times",
       {.losses = 6, .all = 6, .share = 0.34, .machines = 3, .machines_all = 3},
       retry},
      {"every loss of three workers, again and again",
       {.losses = 11, .all = 11, .share = 0.34, .machines = 3, .machines_all = 3},
       blame},
      {"machines are killed all the time, this job's more often than others'",
       {.losses = 8, .all = 58, .share = 0.01, .machines = 5, .machines_all = 100},
       blame},
      {"machines are killed all the time, and the job was among them",
       {.losses = 3, .all = 56, .share = 0.03, .machines = 4, .machines_all = 100},
       retry},
      {"the one worker does nothing else",
       {.losses = 500, .all = 500, .share = 1, .machines = 1, .machines_all = 1},
       retry},
      {"the one worker lives with all others' jobs",
       {.losses = 4, .all = 4, .share = 0.02, .machines = 1, .machines_all = 1},
       blame},
      {"always lost with the same other job",
       {.losses = 9,
        .all = 9,
        .share = 0.01,
        .machines = 9,
        .machines_all = 9,
        .with_another = true},
       retry},
  };
  for (const auto& c : cases) EXPECT_EQ(JudgeLoss({}, c.history), c.verdict) << c.what;
}

// Against the sum of the binomial distribution's tail.
TEST(ChanceOfLosses, IsNeverBelowTheChanceItself) {
  for (const double share : {0.01, 0.2, 0.5, 0.9}) {
    for (const int all : {1, 4, 20}) {
      double tail = 0;
      for (int losses = all; losses >= 1; --losses) {
        tail += std::exp(std::lgamma(all + 1.0) - std::lgamma(losses + 1.0) -
                         std::lgamma(all - losses + 1.0)) *
                std::pow(share, losses) * std::pow(1 - share, all - losses);
        const double bound = ChanceOfLosses({.losses = losses, .all = all, .share = share});
        EXPECT_GE(bound, tail * (1 - 1e-9)) << losses << " of " << all << ", " << share;
        EXPECT_LE(bound, 1);
      }
      EXPECT_NEAR(ChanceOfLosses({.losses = all, .all = all, .share = share}), std::pow(share, all),
                  1e-9);
    }
  }
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

TEST(Memory, LackOfTheMachinesMemoryIsToldFromAllElse) {
  const struct {
    const char* fingerprint;
    bool says;
  } cases[] = {
      {"RESOURCE_EXHAUSTED@solve: out of memory", true},
      {"RESOURCE_EXHAUSTED@train: memory is exhausted", true},
      {"RESOURCE_EXHAUSTED@render: render: images of rig #: needs about # MB beside # MB in use; "
       "the limit is # MB",
       true},
      {"RESOURCE_EXHAUSTED@render: render: rig # does not fit in memory", true},
      {"RESOURCE_EXHAUSTED@render: not enough memory to render the scene", true},
      {"RESOURCE_EXHAUSTED@render: render: the acceleration structure needs more than # MB", true},
      {"RESOURCE_EXHAUSTED@train: CUDA out of memory", false},
      {"RESOURCE_EXHAUSTED@render: write /store/x: No space left on device", false},
      {"", false},
  };
  for (const auto& c : cases) EXPECT_EQ(SaysOutOfMemory(c.fingerprint), c.says) << c.fingerprint;
}

TEST(Memory, AJobAsksForHalfAsMuchAgainWhereAWorkerHasIt) {
  EXPECT_EQ(MoreMemory(4000, 64000), 6000);
  EXPECT_EQ(MoreMemory(4000, 5000), 5000);
  EXPECT_EQ(MoreMemory(4000, 4000), 0);
  EXPECT_EQ(MoreMemory(4000, 0), 0);
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
  EXPECT_EQ(PickJob(std::vector{mine, fresh}, "w", false), 1);
  EXPECT_EQ(PickJob(std::vector{old, fresh}, "w", true), 1);
}

}  // namespace
}  // namespace parallax
