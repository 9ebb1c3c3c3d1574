#include "worker/agent/attempts/failure.h"

#include <gtest/gtest.h>

#include "common/base/names.h"
#include "common/base/status.h"
#include "worker/agent/attempts/attempt_report.h"
#include "worker/agent/session/backoff.h"

namespace parallax {
namespace {

TEST(Failure, EqualCausesHaveEqualFingerprintsWhateverTheNumbers) {
  const Failure a = DescribeFailure(Internal("object 17 of seed 42 at 1.5"), "solve");
  const Failure b = DescribeFailure(Internal("object 3 of seed 9000 at 2.25"), "solve");
  EXPECT_EQ(a.fingerprint, b.fingerprint);
  EXPECT_EQ(a.fingerprint, "INTERNAL@solve: object # of seed # at #.#");
  EXPECT_NE(a.error, b.error) << "people are told the numbers";
  EXPECT_NE(DescribeFailure(Internal("x"), "solve").fingerprint,
            DescribeFailure(Internal("x"), "render/trace").fingerprint);
  EXPECT_NE(DescribeFailure(Internal("x"), "solve").fingerprint,
            DescribeFailure(DataLoss("x"), "solve").fingerprint);
}

TEST(Failure, IsOneBoundedLine) {
  const Failure failure =
      DescribeFailure(Internal("first\nsecond\r\t{}", std::string(100'000, 'x')), "solve");
  EXPECT_EQ(failure.error.find_first_of("\n\r\t"), std::string::npos);
  EXPECT_LE(failure.error.size(), 1000u);
  EXPECT_LE(failure.fingerprint.size(), 200u);
}

TEST(Failure, IsUtf8WhateverAProgramPrintsAndWhereverItIsCut) {
  std::string umlauts;
  while (umlauts.size() < 2000) umlauts += "\u00fc";
  for (const std::string& text : {std::string("gr\xfc\xdf"), umlauts, "x" + umlauts}) {
    const Failure failure = DescribeFailure(MakeError(absl::StatusCode::kInternal, text), "train");
    EXPECT_TRUE(IsUtf8(failure.error)) << failure.error;
    EXPECT_TRUE(IsUtf8(failure.fingerprint)) << failure.fingerprint;
    EXPECT_LE(failure.error.size(), 1000u);
    EXPECT_LE(failure.fingerprint.size(), 200u);
    const Report report =
        UnusableReport({}, {"w", "c"}, MakeError(absl::StatusCode::kInternal, text));
    EXPECT_TRUE(IsUtf8(std::get<v1::FailRequest>(report.body).error()));
  }
}

TEST(Failure, CarriesTheEndOfALog) {
  std::string log = "\xff first\n";
  for (int i = 0; i < 300; ++i) log += "line " + std::to_string(i) + "\n";
  const std::string tail = LogTailOf(WithLogTail(Internal("x"), log));
  EXPECT_EQ(tail.substr(0, 9), "line 100\n");
  EXPECT_EQ(tail.substr(tail.size() - 8), "line 299");
  const std::string wide(100'000, '\xc3');
  const std::string cut = LogTailOf(WithLogTail(Internal("x"), wide));
  EXPECT_EQ(cut, std::string(16 << 10, '?')) << "bounded, and fit for messages";
  EXPECT_EQ(LogTailOf(WithLogTail(Internal("x"), "\n\n")), "");
  EXPECT_EQ(LogTailOf(Internal("x")), "");
}

TEST(Failure, WhatIsWrongWithTheJobItselfIsNotTriedAgain) {
  EXPECT_FALSE(IsRetryable(absl::StatusCode::kInvalidArgument));
  EXPECT_FALSE(IsRetryable(absl::StatusCode::kUnimplemented));
  EXPECT_TRUE(IsRetryable(absl::StatusCode::kResourceExhausted));
  EXPECT_TRUE(IsRetryable(absl::StatusCode::kInternal));
  EXPECT_TRUE(IsRetryable(absl::StatusCode::kPermissionDenied));
}

TEST(Backoff, WaitsAreDrawnBelowACeilingThatDoublesUpToTheCap) {
  using Seconds = Backoff::Seconds;
  Backoff backoff(Rng(SceneSeed{1}, "backoff"), Seconds(1), Seconds(8));
  double longest = 0;
  for (int round = 0; round < 200; ++round) {
    for (double ceiling : {1.0, 2.0, 4.0, 8.0, 8.0}) {
      const double wait = backoff.Next().count();
      EXPECT_GE(wait, 0);
      EXPECT_LT(wait, ceiling);
      longest = std::max(longest, wait);
    }
    backoff.Reset();
  }
  EXPECT_GT(longest, 7) << "full jitter uses the whole range";
}

}  // namespace
}  // namespace parallax
