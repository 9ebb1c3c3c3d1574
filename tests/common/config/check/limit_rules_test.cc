#include "common/config/check/limit_rules.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace parallax {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

TEST(LimitRules, TheNearestRowHoldsAndTakesTheRestFromTheDefault) {
  const auto rules = LimitRules::Parse(
      "default: {max_running: 200, max_studies: 20}\n"
      "users:\n"
      "  submitter ada: {max_running: 64}\n"
      "  submitter *: {max_studies: 4, max_running: 0}\n"
      "  \"*\": {max_waiting_pairs: 1000}\n",
      "limits.yaml");
  ASSERT_TRUE(rules.ok()) << rules.status();
  const struct {
    const char* user;
    UserLimits want;
  } kCases[] = {
      {"submitter ada", {64, 20, 0, "submitter ada"}},
      {"submitter bob", {0, 4, 0, "submitter *"}},
      {"operator ada", {200, 20, 1000, "*"}},
      {"local", {200, 20, 1000, "*"}},
  };
  for (const auto& one : kCases) {
    const UserLimits limits = rules->Of(one.user);
    EXPECT_EQ(limits.max_running, one.want.max_running) << one.user;
    EXPECT_EQ(limits.max_studies, one.want.max_studies) << one.user;
    EXPECT_EQ(limits.max_waiting_pairs, one.want.max_waiting_pairs) << one.user;
    EXPECT_EQ(limits.rule, one.want.rule) << one.user;
  }
  EXPECT_THAT(rules->NamedUsers(), ElementsAre("submitter ada"));
  EXPECT_EQ(rules->Describe(),
            "default: max_running 200, max_studies 20; *: max_running 200, max_studies 20, "
            "max_waiting_pairs 1000; submitter *: max_studies 4; submitter ada: max_running 64, "
            "max_studies 20");
}

TEST(LimitRules, PrioritiesMayBeNegative) {
  const auto rules = LimitRules::Parse(
      "default: {priority: -3}\nusers: {local: {priority: 7}, submitter ada: {max_studies: 1}}\n",
      "limits.yaml");
  ASSERT_TRUE(rules.ok()) << rules.status();
  EXPECT_EQ(rules->Of("operator olga").priority, -3);
  EXPECT_EQ(rules->Of("local").priority, 7);
  EXPECT_EQ(rules->Of("submitter ada").priority, -3);
  EXPECT_EQ(rules->Describe(),
            "default: priority -3; local: priority 7; submitter ada: max_studies 1, priority -3");
}

TEST(LimitRules, AnEmptyFileLimitsNobody) {
  for (const char* yaml : {"", "{}", "# nothing\n"}) {
    const auto rules = LimitRules::Parse(yaml, "limits.yaml");
    ASSERT_TRUE(rules.ok()) << rules.status();
    EXPECT_EQ(rules->Describe(), "none");
    EXPECT_EQ(rules->Of("submitter ada").max_running, 0);
  }
}

TEST(LimitRules, WhatIsWrongIsToldWithItsLine) {
  const struct {
    const char* yaml;
    const char* error;
  } kCases[] = {
      {"default:\n  max_runing: 3\n", "limits.yaml:2: default.max_runing: no such field"},
      {"default: {max_running: -1}\n", "limits.yaml:1: default.max_running: -1"},
      {"default: {max_running: many}\n", "default.max_running"},
      {"default: {priority: 1001}\n", "limits.yaml:1: default.priority: 1001"},
      {"default: {priority: -1001}\n", "limits.yaml:1: default.priority: -1001"},
      {"users:\n  ada: {max_running: 3}\n", "limits.yaml:2: users.ada: not a user"},
      {"users:\n  worker pool: {max_running: 3}\n", "users.worker pool: not a user"},
      {"users: [1]\n", "users: "},
      {"limits: {}\n", "limits: no such field"},
      {"users: {submitter ada: {max_studies: 1}, submitter ada: {}}\n", "given twice"},
      {"default: {max_running: 3\n", "limits.yaml:"},
  };
  for (const auto& one : kCases) {
    const auto rules = LimitRules::Parse(one.yaml, "limits.yaml");
    ASSERT_FALSE(rules.ok()) << one.yaml;
    EXPECT_THAT(std::string(rules.status().message()), HasSubstr(one.error));
  }
  EXPECT_TRUE(absl::IsNotFound(LimitRules::Load("/no/such/file").status()));
}

TEST(LimitRules, AUserIsRoleAndNameOfItsCertificate) {
  EXPECT_EQ(UserOfActor("submitter ada ipv4:10.0.0.7:4711"), "submitter ada");
  EXPECT_EQ(UserOfActor("operator root https:10.0.0.7"), "operator root");
  EXPECT_EQ(UserOfActor("ipv4:127.0.0.1:4711"), kLocalUser);
  EXPECT_EQ(UserOfActor("unix:"), kLocalUser);
  EXPECT_EQ(UserOfActor(""), kLocalUser);
}

}  // namespace
}  // namespace parallax
