#include "common/store/s3_credentials.h"

#include <fmt/core.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/base/system/file.h"
#include "common/base/system/temporary_folder.h"

namespace parallax {
namespace {

using testing::HasSubstr;
using testing::Not;

TEST(S3Credentials, AreReadAsCredentialProcessPrintsThem) {
  const auto all = ParseS3Credentials(
      R"({"Version": 1, "AccessKeyId": "id", "SecretAccessKey": "key", "SessionToken": "token",
          "Expiration": "2026-11-28T22:10:00Z"})");
  ASSERT_TRUE(all.ok()) << all.status();
  EXPECT_EQ(all->access_key, "id");
  EXPECT_EQ(all->secret_key, "key");
  EXPECT_EQ(all->session_token, "token");
  EXPECT_EQ(all->ends_unix_s, 1795903800);
  const char* fixed = R"({"AccessKeyId": "id", "SecretAccessKey": "key"})";
  EXPECT_EQ(ParseS3Credentials(fixed)->ends_unix_s, 0);
  const std::pair<const char*, const char*> bad[] = {
      {"", "not a JSON object"},
      {"[\"hidden\"]", "not a JSON object"},
      {R"({"SecretAccessKey": "hidden"})", "no AccessKeyId"},
      {R"({"AccessKeyId": "id", "SecretAccessKey": 7})", "no SecretAccessKey"},
      {R"({"AccessKeyId": "id", "SecretAccessKey": "hidden", "Expiration": "soon"})",
       "Expiration: \"soon\""},
      {R"({"AccessKeyId": "id", "SecretAccessKey": "hidden", "Expiration":
           "2026-11-28T22:10:00+01:00"})",
       "wanted is a time"},
  };
  for (const auto& [printed, wanted] : bad) {
    const std::string said(ToStd(ParseS3Credentials(printed).status().message()));
    EXPECT_THAT(said, HasSubstr(wanted));
    EXPECT_THAT(said, Not(HasSubstr("hidden")));
  }
}

class SetClock final : public Clock {
 public:
  double UnixSeconds() override { return unix_s; }
  SteadyTime Steady() override { return {}; }
  double unix_s = 1795903800 - 3600;  // An hour before 22:10.
};

TEST(S3Credentials, AreAskedForOnceAndAgainBeforeTheyEnd) {
  const auto folder = TemporaryFolder::Make("credentials");
  ASSERT_TRUE(folder.ok()) << folder.status();
  const std::string file = folder->path() + "/file";
  const auto give = [&](const char* key, const char* end) {
    ASSERT_TRUE(WriteFile(file, fmt::format(R"({{"AccessKeyId": "{}", "SecretAccessKey": "key",
                                                "Expiration": "{}"}})",
                                            key, end))
                    .ok());
  };
  SetClock clock;
  S3CredentialSource source("cat " + file, clock);
  give("first", "2026-11-28T22:10:00Z");
  EXPECT_EQ(source.Get()->access_key, "first");
  give("second", "2026-11-28T23:10:00+00:00");
  EXPECT_EQ(source.Get()->access_key, "first");
  clock.unix_s += 3600 - 301;
  EXPECT_EQ(source.Get()->access_key, "first");
  clock.unix_s += 2;
  EXPECT_EQ(source.Get()->access_key, "second");

  // A command that fails is no harm while the credentials of before are valid.
  ASSERT_TRUE(WriteFile(file, "no").ok());
  clock.unix_s += 3400;
  EXPECT_EQ(source.Get()->access_key, "second");
  clock.unix_s += 600;
  const absl::Status ended = source.Get().status();
  EXPECT_TRUE(absl::IsPermissionDenied(ended));
  EXPECT_THAT(std::string(ToStd(ended.message())), HasSubstr("by `cat " + file + "`: what it"));
  give("third", "2026-11-29T23:10:00Z");
  EXPECT_EQ(source.Get()->access_key, "third");

  // A refusal counts for those that were refused, not for fresher ones.
  give("fourth", "2026-11-29T23:10:00Z");
  EXPECT_TRUE(source.Renew({.access_key = "second"}));
  EXPECT_EQ(source.Get()->access_key, "third");
  EXPECT_TRUE(source.Renew({.access_key = "third"}));
  EXPECT_EQ(source.Get()->access_key, "fourth");
  EXPECT_FALSE(S3CredentialSource(S3Credentials{.access_key = "id"}).Renew({.access_key = "id"}));
}

}  // namespace
}  // namespace parallax
