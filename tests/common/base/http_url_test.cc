#include "common/base/http_url.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace parallax {
namespace {

TEST(HttpUrl, TheHostIsThatOfTheRequestAndNothingElse) {
  const struct {
    const char* url;
    const char* host;
  } kCases[] = {
      {"https://hooks.example.com/T0/secret?x=y#z", "hooks.example.com"},
      {"http://Hooks.Example.com:80", "hooks.example.com"},
      {"https://host:443/", "host"},
      {"http://host:443/", "host:443"},
      {"https://ada:secret@host:8080/x?y=z", "host:8080"},
      {"http://[::1]:9/x", "[::1]:9"},
      {"http://[::1]", "[::1]"},
      {"http://host?a@evil", "host"},
      {"", ""},
      {"host", ""},
      {"ftp://host/x", ""},
      {"http://", ""},
      {"http:///x", ""},
      {"http://host:port/x", ""},
      {"http://a@b@host/", ""},
      {"http://evil\\@host/", ""},
      {"http://host /x", ""},
      {"http://host/x\r\nHost: evil", ""},
      {"http://ho%73t/", ""},
  };
  for (const auto& [url, host] : kCases) {
    EXPECT_EQ(HostOfUrl(url), host) << url;
    EXPECT_EQ(WhyNotHttpUrl(url).empty(), *host != '\0') << url;
  }
  EXPECT_EQ(HostOfUrl("http://host/" + std::string(2048, 'x')), "");
}

}  // namespace
}  // namespace parallax
