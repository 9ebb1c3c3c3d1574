#include "common/store/http_client.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <stdlib.h>
#include <sys/socket.h>
#include <unistd.h>

#include "common/base/system/file.h"
#include "tests/folder_test.h"

namespace parallax {
namespace {

using HttpClientTest = FolderTest;

TEST_F(HttpClientTest, AuthoritiesAreThoseOfTheVariableOrTheFirstFileThatExists) {
  const std::string rocky = dir_ + "/ca-bundle.crt", suse = dir_ + "/ca-bundle.pem";
  ASSERT_TRUE(WriteFile(rocky, "x").ok());
  ASSERT_TRUE(WriteFile(suse, "x").ok());
  const std::vector<std::string> candidates = {dir_ + "/none.crt", rocky, suse};
  EXPECT_EQ(ChooseCaFile("", candidates), rocky);
  EXPECT_EQ(ChooseCaFile("/mine.pem", candidates), "/mine.pem");
  EXPECT_EQ(ChooseCaFile("", {dir_ + "/none.crt"}), "");
}

TEST_F(HttpClientTest, ReadsTheAuthoritiesThatTheVariableNames) {
  // Connections to it are made, and never answered.
  const int listener = socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t length = sizeof address;
  ASSERT_EQ(bind(listener, reinterpret_cast<sockaddr*>(&address), length), 0);
  ASSERT_EQ(listen(listener, 4), 0);
  ASSERT_EQ(getsockname(listener, reinterpret_cast<sockaddr*>(&address), &length), 0);
  setenv("no_proxy", "127.0.0.1", 1);
  setenv("SSL_CERT_FILE", (dir_ + "/none.pem").c_str(), 1);
  const HttpAnswer answer = HttpClient().Send(
      {.method = "GET",
       .url = "https://127.0.0.1:" + std::to_string(ntohs(address.sin_port)) + "/",
       .most_s = 5});
  unsetenv("SSL_CERT_FILE");
  unsetenv("no_proxy");
  close(listener);
  EXPECT_EQ(answer.code, 0);
  EXPECT_THAT(answer.error, testing::HasSubstr(dir_ + "/none.pem"));
}

}  // namespace
}  // namespace parallax
