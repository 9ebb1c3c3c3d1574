#include "coordinator/study/notify_hosts.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace parallax {
namespace {

using testing::HasSubstr;
using testing::Not;

TEST(NotifyHosts, AHostIsAllowedAtItsPortOnly) {
  const auto hosts = NotifyHosts::Of({"Hooks.example.com", "ci:8080"});
  ASSERT_TRUE(hosts.ok()) << hosts.status();
  EXPECT_TRUE(hosts->Allows("https://hooks.example.com/x"));
  EXPECT_TRUE(hosts->Allows("http://HOOKS.example.com:80/x"));
  EXPECT_TRUE(hosts->Allows("http://ada:secret@ci:8080"));
  EXPECT_FALSE(hosts->Allows("http://hooks.example.com:8080/x"));
  EXPECT_FALSE(hosts->Allows("http://ci/x"));
  EXPECT_FALSE(hosts->Allows("http://ci:8080@evil/x"));
  EXPECT_FALSE(hosts->Allows("http://evil.hooks.example.com/x"));
  EXPECT_FALSE(NotifyHosts().Allows("http://hooks.example.com/x"));
  EXPECT_TRUE(NotifyHosts::Of({"*"})->Allows("http://any:1/x"));
}

TEST(NotifyHosts, ARefusedStudyHearsTheRemedyWithoutItsSecret) {
  v1::StudySpec study;
  study.set_name("baseline");
  EXPECT_TRUE(NotifyHosts().Check(study).ok());
  study.mutable_notify()->set_url("https://ci:8443/hook/secret");
  const absl::Status status = NotifyHosts().Check(study);
  EXPECT_TRUE(absl::IsFailedPrecondition(status));
  EXPECT_THAT(std::string(status.message()),
              HasSubstr("study 'baseline': notify.url: this coordinator posts no notices to "
                        "ci:8443: leave notify out, or have its operator allow the host "
                        "(coordinator serve --notify-hosts ci:8443)"));
  EXPECT_THAT(std::string(status.message()), Not(HasSubstr("secret")));
  EXPECT_TRUE(NotifyHosts::Of({"ci:8443"})->Check(study).ok());
}

TEST(NotifyHosts, WhatIsNoHostIsRefused) {
  for (const char* entry : {"", "http://ci", "ci/x", "ada@ci", "ci:port", "a b"}) {
    EXPECT_THAT(std::string(NotifyHosts::Of({entry}).status().message()),
                HasSubstr("--notify-hosts \"" + std::string(entry) + "\": wanted HOST or"))
        << entry;
  }
}

}  // namespace
}  // namespace parallax
