#include "coordinator/client/views/text.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace parallax::client {
namespace {

TEST(Text, DurationsGrowFromSecondsToDays) {
  const struct {
    double seconds;
    const char* text;
  } cases[] = {{0, "0.0 s"},        {0.44, "0.4 s"},      {9.94, "9.9 s"},
               {9.96, "10 s"},      {59.4, "59 s"},       {59.6, "1:00"},
               {65, "1:05"},        {3599.4, "59:59"},    {3600, "1:00:00"},
               {7384, "2:03:04"},   {172799, "47:59:59"}, {172800, "2 d 0 h"},
               {270000, "3 d 3 h"}, {1e19, "1e+19 s"},    {-1, "-"},
               {NAN, "-"}};
  for (const auto& c : cases) EXPECT_EQ(FormatDuration(c.seconds), c.text) << c.seconds;
}

TEST(Text, BytesAreCountedInThousands) {
  const struct {
    double bytes;
    const char* text;
  } cases[] = {{0, "0 B"},        {999, "999 B"},      {1000, "1.0 kB"}, {1234, "1.2 kB"},
               {34.2e6, "34 MB"}, {999.7e6, "1.0 GB"}, {5e15, "5000 TB"}};
  for (const auto& c : cases) EXPECT_EQ(FormatBytes(c.bytes), c.text) << c.bytes;
}

TEST(Text, NumbersKeepThreeDigits) {
  const struct {
    double value;
    const char* text;
  } cases[] = {{0, "0"},
               {0.01234, "0.0123"},
               {4.5678, "4.57"},
               {45.67, "45.7"},
               {456.7, "457"},
               {999.6, "1,000"},
               {1234567, "1,234,567"},
               {-4.5678, "-4.57"},
               {1e19, "1e+19"},
               {-3.4e38, "-3.4e+38"},
               {-1e-9, "-1e-09"},
               {9.9e14, "990,000,000,000,000"}};
  for (const auto& c : cases) EXPECT_EQ(FormatNumber(c.value), c.text) << c.value;
  EXPECT_EQ(FormatCount(-12345), "-12,345");
  EXPECT_EQ(FormatCount(999), "999");
  EXPECT_EQ(FormatCount(INT64_MIN), "-9,223,372,036,854,775,808");
}

TEST(Text, PluralsFollowTheCount) {
  EXPECT_EQ(Plural(1, "pair"), "1 pair");
  EXPECT_EQ(Plural(0, "pair"), "0 pairs");
  EXPECT_EQ(Plural(1200, "crash", "crashes"), "1,200 crashes");
}

TEST(Text, SparklineGoesFromLowestToHighest) {
  const std::vector<double> falling = {8, 7, 6, 5, 4, 3, 2, 1};
  EXPECT_EQ(Sparkline(falling, 8, false), "#+=~-,._");
  EXPECT_EQ(Sparkline(falling, 2, false), "#_");
  EXPECT_EQ(Sparkline(std::vector<double>{5, 5, 5}, 8, false), "___");
  EXPECT_EQ(Sparkline(std::vector<double>{}, 8, true), "");
  EXPECT_EQ(Sparkline(std::vector<double>{1, 2}, 8, true), "▁█");
}

TEST(Text, NamesAndLinesAreTrimmed) {
  EXPECT_EQ(LowerName("STUDY_STATE_RUNNING", "STUDY_STATE_"), "running");
  EXPECT_EQ(LowerName("RETRY_WAIT"), "retry_wait");
  EXPECT_EQ(FirstLine("one \r\ntwo"), "one");
}

TEST(Text, SeedsAreWholeNumbersFromZero) {
  for (const char* seed : {"0", "7", "18446744073709551615"}) EXPECT_EQ(WhyNotSeed(seed), "");
  for (const char* text : {"-1", "", "1.5", "0x10", "seven", "18446744073709551616", "1 "}) {
    EXPECT_EQ(WhyNotSeed(text),
              std::string(text) + ", allowed is a whole number from 0 to 2^64 - 1");
  }
}

TEST(NewLines, AreThoseBehindWhatWasSaid) {
  const struct {
    const char *before, *now;
    std::vector<std::string> want;
  } kCases[] = {
      {"", "", {}},
      {"", "a\nb", {"a", "b"}},
      {"a\nb", "a\nb", {}},
      {"a\nb", "a\nb\nc", {"c"}},
      {"a\nb\nc", "b\nc\nd", {"d"}},
      {"same\nsame", "same\nsame\nsame", {"same"}},
      {"b\nc", "a\nb\nc\nd", {"d"}},                  // The end that is kept is longer.
      {"step 1\nste", "step 1\nstep 2", {"step 2"}},  // A line that was not whole.
      {"step 1", "step 1 of 9", {"step 1 of 9"}},     // Nor was the only one.
      {"ep 1", "step 1\nstep 2", {"step 2"}},
      {"first\nsecond\nthird", "ond\nthird\nfourth", {"fourth"}},
      {"cond\nthird", "first\nsecond\nthird\nfourth", {"fourth"}},
      {"a\n\nb", "\nb\n\nc", {"", "c"}},
      {"a\nb", "x\ny", {"...", "x", "y"}},
  };
  for (const auto& one : kCases) {
    EXPECT_EQ(NewLines(one.before, one.now), one.want) << one.before << " | " << one.now;
  }
}

}  // namespace
}  // namespace parallax::client
