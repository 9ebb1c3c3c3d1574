#include "common/config/verdicts.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace parallax {
namespace {

v1::FilterConfig Filters(double intensity, double depth_m, double distance_m = 0) {
  v1::FilterConfig filters;
  filters.set_min_mean_intensity(intensity);
  filters.set_min_depth_m(depth_m);
  filters.set_min_distance_m(distance_m);
  return filters;
}

TEST(Verdicts, FollowTheThresholds) {
  const struct {
    double mean_intensity, min_depth_m;
    v1::FilterConfig filters;
    std::vector<std::pair<std::string, bool>> verdicts;
  } cases[] = {
      {90, 0.5, Filters(10, 0.125), {{"dark", true}, {"near", true}}},
      {9.9, 0.5, Filters(10, 0.125), {{"dark", false}, {"near", true}}},
      {10, 0.125, Filters(10, 0.125), {{"dark", true}, {"near", true}}},
      {90, 0.1249, Filters(10, 0.125), {{"dark", true}, {"near", false}}},
      {90, 0.5, Filters(10, 0.125, 5), {{"dark", true}, {"near", true}, {"close", false}}},
      {90, 5, Filters(10, 0.125, 5), {{"dark", true}, {"near", true}, {"close", true}}},
      // Only sky.
      {90, 0, Filters(10, 0.125, 5), {{"dark", true}, {"near", true}, {"close", true}}},
  };
  for (const auto& row : cases) {
    const FrameFacts frame{
        {{"mean_intensity", row.mean_intensity}, {"min_depth_m", row.min_depth_m}}};
    const auto verdicts = Judge(frame, row.filters);
    ASSERT_TRUE(verdicts.ok()) << verdicts.status();
    std::vector<std::pair<std::string, bool>> seen;
    for (const Verdict& verdict : *verdicts) seen.emplace_back(verdict.name, verdict.passed);
    EXPECT_EQ(seen, row.verdicts);
    EXPECT_EQ((*verdicts)[0].value, row.mean_intensity);
    EXPECT_EQ((*verdicts)[0].threshold, row.filters.min_mean_intensity());
    EXPECT_EQ((*verdicts)[1].value, row.min_depth_m);
    EXPECT_EQ((*verdicts)[1].threshold, row.filters.min_depth_m());
  }
}

TEST(Verdicts, ViewsOfTheSkyAreEmptyOnlyWhenAsked) {
  v1::FilterConfig filters = Filters(10, 0.125);
  const FrameFacts frame{{{"mean_intensity", 90}, {"min_depth_m", 1}, {"sky_fraction", 0.95}}};
  EXPECT_EQ(Judge(frame, filters)->size(), 2);
  for (const auto& [most, passed] : {std::pair(0.95, true), std::pair(0.94, false)}) {
    filters.set_max_empty_share(most);
    const auto verdicts = Judge(frame, filters);
    ASSERT_EQ(verdicts->size(), 3);
    EXPECT_EQ(verdicts->back().name, "empty");
    EXPECT_EQ(verdicts->back().passed, passed);
    EXPECT_EQ(verdicts->back().threshold, most);
  }
}

TEST(Verdicts, OnlyCuratedFramesAreAmbiguousAndOnlyWhenAsked) {
  v1::FilterConfig filters = Filters(10, 0.125);
  FrameFacts frame{{{"mean_intensity", 90}, {"min_depth_m", 1}, {"ambiguous_share", 0.5}}};
  EXPECT_EQ(Judge(frame, filters)->size(), 2);
  filters.set_max_ambiguous_share(1);
  EXPECT_EQ(Judge(frame, filters)->size(), 2);
  const struct {
    double most;
    bool passed;
  } cases[] = {{0.6, true}, {0.5, true}, {0.49, false}, {0, false}};
  for (const auto& row : cases) {
    filters.set_max_ambiguous_share(row.most);
    const auto verdicts = Judge(frame, filters);
    ASSERT_EQ(verdicts->size(), 3);
    EXPECT_EQ((*verdicts)[2].name, "ambiguous");
    EXPECT_EQ((*verdicts)[2].passed, row.passed) << row.most;
    EXPECT_EQ((*verdicts)[2].value, 0.5);
    EXPECT_EQ((*verdicts)[2].threshold, row.most);
  }
  frame.statistics.erase("ambiguous_share");
  EXPECT_EQ(Judge(frame, filters)->size(), 2);
}

TEST(Verdicts, FramesWithoutTextureFailWhereTheFilterAsks) {
  v1::FilterConfig filters = Filters(10, 0.125);
  FrameFacts frame{{{"mean_intensity", 90}, {"min_depth_m", 1}, {"textured_fraction", 0.2}}};
  EXPECT_EQ(Judge(frame, filters)->size(), 2);
  const struct {
    double least;
    bool passed;
  } cases[] = {{0.1, true}, {0.2, true}, {0.21, false}, {1, false}};
  for (const auto& row : cases) {
    filters.set_min_textured_fraction(row.least);
    const auto verdicts = Judge(frame, filters);
    ASSERT_EQ(verdicts->size(), 3);
    EXPECT_EQ((*verdicts)[2].name, "textureless");
    EXPECT_EQ((*verdicts)[2].passed, row.passed) << row.least;
    EXPECT_EQ((*verdicts)[2].value, 0.2);
    EXPECT_EQ((*verdicts)[2].threshold, row.least);
  }
  frame.statistics.erase("textured_fraction");
  EXPECT_EQ(Judge(frame, filters).status().code(), absl::StatusCode::kFailedPrecondition);
}

TEST(Verdicts, AMissingStatisticIsNoVerdict) {
  const auto verdicts = Judge({{{"mean_intensity", 90}}}, Filters(10, 0.125));
  EXPECT_EQ(verdicts.status().code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(std::string(verdicts.status().message()),
              testing::HasSubstr("filter near: there is no statistic \"min_depth_m\""));
}

}  // namespace
}  // namespace parallax
