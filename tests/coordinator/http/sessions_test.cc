#include "coordinator/http/sessions.h"

#include <gtest/gtest.h>

#include "coordinator/http/server/credentials.h"
#include "coordinator/queue/reads/farm_history.h"
#include "tests/coordinator/queue/queue_fixture.h"

namespace parallax {
namespace {

RpcCaller Olga() { return {.has_certificate = true, .name = "olga", .role = Role::kOperator}; }

TEST(Sessions, CodeOpensOneSessionOnce) {
  FakeClock clock;
  Sessions sessions(clock);
  const std::string code = *sessions.NewCode(Olga(), 60);
  const auto session = sessions.Redeem(code);
  ASSERT_TRUE(session.ok()) << session.status();
  EXPECT_NE(*session, code);
  ASSERT_TRUE(sessions.Find(*session));
  EXPECT_EQ(sessions.Find(*session)->name, "olga");
  EXPECT_EQ(sessions.Redeem(code).status().code(), absl::StatusCode::kUnauthenticated);
  EXPECT_FALSE(sessions.Find(code)) << "a code is no session";
  sessions.End(*session);
  EXPECT_FALSE(sessions.Find(*session));
}

TEST(Sessions, CodesAndSessionsEndByThemselves) {
  FakeClock clock;
  Sessions sessions(clock);
  const std::string code = *sessions.NewCode(Olga(), 60);
  clock.Advance(61);
  EXPECT_FALSE(sessions.Redeem(code).ok());
  const std::string session = *sessions.Open(Olga());
  clock.Advance(11 * 3600);
  EXPECT_TRUE(sessions.Find(session));
  clock.Advance(2 * 3600);
  EXPECT_FALSE(sessions.Find(session));
}

TEST(Sessions, OneCallersSessionsEndOnlyItsOwn) {
  FakeClock clock;
  Sessions sessions(clock);
  const std::string olgas = *sessions.Open(Olga());
  const std::string link = *sessions.NewCode(Olga(), 600);
  const RpcCaller viewer{.has_certificate = true, .name = "http.token", .role = Role::kReadOnly};
  std::string newest, oldest = *sessions.Open(viewer);
  for (int i = 0; i < 1500; ++i) {
    clock.Advance(0.01);
    newest = *sessions.Open(viewer);
    ASSERT_TRUE(sessions.NewCode(viewer, 600).ok());
  }
  EXPECT_TRUE(sessions.Find(olgas));
  EXPECT_TRUE(sessions.Find(newest));
  EXPECT_FALSE(sessions.Find(oldest));
  EXPECT_TRUE(sessions.Redeem(link).ok());
}

TEST(Sessions, CallersTogetherAreBounded) {
  FakeClock clock;
  Sessions sessions(clock);
  std::string first;
  for (int i = 0; i < 1200; ++i) {
    const auto opened = sessions.Open({.has_certificate = true, .name = std::to_string(i % 400)});
    if (i == 0) first = *opened;
    clock.Advance(0.01);
  }
  EXPECT_FALSE(sessions.Find(first));
}

TEST(Sessions, ThousandsOfThemPushTheOldestOut) {
  FakeClock clock;
  Sessions sessions(clock);
  const std::string oldest = *sessions.Open(Olga());
  clock.Advance(1);
  std::string newest;
  for (int i = 0; i < 1000; ++i) newest = *sessions.Open(Olga());
  EXPECT_FALSE(sessions.Find(oldest));
  EXPECT_TRUE(sessions.Find(newest));
}

TEST(Credentials, AreReadFromHeaders) {
  EXPECT_EQ(TokenIn("Bearer abc"), "abc");
  EXPECT_EQ(TokenIn("Basic bWU6YWJj"), "abc");
  EXPECT_EQ(TokenIn("Basic ####"), "");
  EXPECT_EQ(TokenIn("Digest abc"), "");
  EXPECT_EQ(CookieIn("a=1; parallax_7080=xyz; b=2", "parallax_7080"), "xyz");
  EXPECT_EQ(CookieIn("a=1; parallax_7080=xyz", "parallax_708"), "");
  EXPECT_EQ(CookieIn("; ;  ", "a"), "");
  EXPECT_EQ(CookieIn("", "a"), "");
}

TEST(Credentials, HostsAreParsedWhole) {
  const struct {
    const char* header;
    const char* host;  // Null: no host.
  } cases[] = {{"localhost", "localhost"},
               {"127.0.0.1:7080", "127.0.0.1"},
               {"[::1]", "::1"},
               {"[::1]:7080", "::1"},
               {"[::1].evil.com", nullptr},
               {"[::1]evil.com:80", nullptr},
               {"::1", nullptr},
               {"127.evil.com:80", "127.evil.com"},
               {"", nullptr},
               {":80", nullptr},
               {"a:", nullptr},
               {"a:b", nullptr},
               {"a:99999", nullptr},
               {"a,b:80", nullptr},
               {"a b", nullptr}};
  for (const auto& c : cases) {
    const auto host = HostIn(c.header);
    EXPECT_EQ(host.has_value(), c.host != nullptr) << c.header;
    if (host) {
      EXPECT_STREQ(host->c_str(), c.host) << c.header;
    }
  }
  EXPECT_TRUE(IsOwnName("farm"));
  EXPECT_FALSE(IsOwnName("farm.evil.com"));
  EXPECT_FALSE(IsOwnName("::2"));
}

TEST(History, KeepsOneSampleAMinuteOfTheLastDay) {
  History history;
  for (int i = 0; i < 2000 * 6; ++i) history.Add({.unix_s = 1000 + 10.0 * i, .ready = i});
  const auto& samples = history.samples();
  ASSERT_EQ(samples.size(), 1440u);
  EXPECT_DOUBLE_EQ(samples.back().unix_s - samples.front().unix_s, 1439 * 60.0);
  EXPECT_DOUBLE_EQ(samples.back().unix_s, 1000 + 1999 * 60.0);
}

}  // namespace
}  // namespace parallax
