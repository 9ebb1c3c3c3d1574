// Callers that send too much, too slowly, nonsense, or by a name that is not ours: each gets a
// refusal or is hung up on, and others are served.
#include <fcntl.h>
#include <unistd.h>

#include <chrono>
#include <fstream>

#include "common/base/seconds.h"
#include "tests/coordinator/http/http_fixture.h"

namespace parallax {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

class StrangersTest : public HttpTest {
 protected:
  std::string Ask(const std::string& bytes) const { return Exchange(Port(), bytes); }
};

const std::string kHost = "Host: localhost\r\n";

TEST_F(StrangersTest, EachBoundHasItsRefusal) {
  Serve();
  const std::string long_line(kMostHeaderBytes, 'x');
  std::string many_lines;
  for (int i = 0; i < 1000; ++i) many_lines += "X-" + std::to_string(i) + ": 0123456789012345\r\n";
  std::string chunks =
      "POST /api/v1/session HTTP/1.1\r\n" + kHost + "Transfer-Encoding: chunked\r\n\r\n";
  for (int i = 0; i < 20; ++i) chunks += "3e8\r\n" + std::string(1000, 'x') + "\r\n";
  const struct {
    std::string request;
    const char* status;
  } cases[] = {
      {"GET / HTTP/1.1\r\n" + kHost + "X: " + long_line, "431"},
      {"GET / HTTP/1.1\r\n" + kHost + many_lines, "431"},
      {"GET /" + long_line, "431"},
      {"GET /" + std::string(kMostTargetBytes, 'x') + " HTTP/1.1\r\n" + kHost + "\r\n", "414"},
      {chunks, "413"},
      {"POST /api/v1/session HTTP/1.1\r\n" + kHost + "Content-Length: 8193\r\n\r\n", "413"},
      {"POST /api/v1/session HTTP/1.1\r\n" + kHost + "Content-Length: 99999999999999999999\r\n\r\n",
       "400"},
      {"POST /api/v1/session HTTP/1.1\r\n" + kHost +
           "Content-Length: 4\r\nTransfer-Encoding: chunked\r\n\r\n0\r\n\r\n",
       "400"},
      {"GET / HTTP/1.1\r\n\r\n", "400"},
      {"GET / HTTP/1.1\r\n" + kHost + kHost + "\r\n", "400"},
      {"GET /%zz HTTP/1.1\r\n" + kHost + "\r\n", "400"},
      {"GET /%00 HTTP/1.1\r\n" + kHost + "\r\n", "400"},
      {"GET http://localhost/ HTTP/1.1\r\n" + kHost + "\r\n", "400"},
      {"PUT / HTTP/1.1\r\n" + kHost + "\r\n", "405"},
      {"nonsense\r\n\r\n", "400"},
  };
  for (const auto& c : cases) {
    const std::string answer = Ask(c.request);
    EXPECT_THAT(answer, StartsWith(std::string("HTTP/1.1 ") + c.status))
        << c.request.substr(0, 200);
    EXPECT_THAT(answer, HasSubstr("\"error\"")) << c.request.substr(0, 200);
  }
  EXPECT_EQ(Client()->Get("/healthz")->status, 200);
}

// Another site's page comes here by a name that its owner points at us (DNS rebinding).
constexpr const char* kForeignHosts[] = {
    "evil.example",      "127.evil.com",    "127.0.0.1.evil.com", "localhost.evil.com",
    "[::1]evil.com",     "127.0.0.1:80:80", "127.evil.com:7080",  "[::1].evil.com:80",
    "[::1]:80.evil.com", "127.1.evil.com",  "127.0.0.1x",         "2130706433.evil.co",
    "0x7f.1.evil.com"};

void ExpectOwnHostsOnly(const Browser& client, const std::string& own) {
  for (const char* path : {"/", "/js/app.js", "/healthz", "/metrics", "/api/v1/me", "/nowhere"}) {
    for (const char* host : kForeignHosts) {
      EXPECT_EQ(client.Get(path, {{"Host", host}})->status, 403) << path << " " << host;
    }
    EXPECT_NE(client.Get(path, {{"Host", own}})->status, 403) << path;
  }
  for (const char* host : kForeignHosts) {
    EXPECT_EQ(client.Post("/api/v1/session", "{}", {{"Host", host}})->status, 403) << host;
  }
}

TEST_F(StrangersTest, ForeignNamesForThisMachineAreRefused) {
  Serve();
  for (const char* own : {"localhost:1", "127.0.0.1", "127.8.8.8:1", "[::1]:1", "LocalHost"}) {
    ExpectOwnHostsOnly(*Client(), own);
  }
  EXPECT_EQ(Client()->Get("/", {{"Host", "10.1.2.3"}})->status, 403);
}

TEST_F(StrangersTest, ForeignNamesForAFarmWithCertificatesAreRefused) {
  ServeTls();
  for (const char* own : {"localhost:1", "127.0.0.1", "10.1.2.3:7080"}) {
    ExpectOwnHostsOnly(*TlsClient("operator-olga"), own);
    ExpectOwnHostsOnly(*TlsClient(""), own);
  }
}

TEST_F(StrangersTest, ForeignNamesForAPortWithoutTlsAreRefused) {
  options_.listen = "0.0.0.0:0";
  options_.security.insecure = true;
  Serve();
  for (const char* own : {"10.1.2.3:7080", "farm", "localhost:1"})
    ExpectOwnHostsOnly(*Client(), own);
}

TEST_F(StrangersTest, ARangeGetsTheWholeOnce) {
  Serve();
  const auto whole = Client()->Get("/app.css");
  std::string ranges = "bytes=0-";
  for (int i = 0; i < 1000; ++i) ranges += ",0-";
  for (const std::string& range : {std::string("bytes=0-9"), ranges}) {
    const auto answer = Client()->Get("/app.css", {{"Range", range}});
    EXPECT_EQ(answer->status, 200);
    EXPECT_EQ(answer->body, whole->body);
  }
}

TEST_F(StrangersTest, AHeadHasNoBodyAndOneCacheControl) {
  Serve();
  const std::string head =
      Ask("HEAD /api/v1/me HTTP/1.1\r\n" + kHost + "Connection: close\r\n\r\n");
  EXPECT_THAT(head, StartsWith("HTTP/1.1 200 "));
  EXPECT_THAT(head, testing::EndsWith("\r\n\r\n"));
  EXPECT_THAT(head, HasSubstr("Content-Length: "));
  const size_t first = head.find("Cache-Control:");
  EXPECT_NE(first, std::string::npos);
  EXPECT_EQ(head.find("Cache-Control:", first + 1), std::string::npos) << head;
}

TEST_F(StrangersTest, RequestsFollowEachOtherOnOneConnection) {
  Serve();
  const std::string one = "GET /api/v1/me HTTP/1.1\r\n" + kHost;
  const std::string answers = Ask(one + "\r\n" + one + "\r\n" + one + "Connection: close\r\n\r\n");
  size_t count = 0;
  for (size_t at = 0; (at = answers.find("HTTP/1.1 200", at)) != std::string::npos; ++at) ++count;
  EXPECT_EQ(count, 3u) << answers;
}

TEST_F(StrangersTest, SlowCallersKeepNobodyOut) {
  Serve();
  std::vector<int> slow;
  for (int i = 0; i < 200; ++i) {
    slow.push_back(ConnectTo(Port()));
    ASSERT_GE(slow.back(), 0);
    (void)!send(slow.back(), "GET / HT", 8, MSG_NOSIGNAL);
  }
  for (const char* path : {"/healthz", "/", "/metrics", "/healthz"}) {
    const auto begin = std::chrono::steady_clock::now();
    const auto answer = Client()->Get(path);
    ASSERT_TRUE(answer) << path;
    EXPECT_EQ(answer->status, 200) << path;
    EXPECT_LT(SecondsSince(begin), 5) << path;
    for (const int fd : slow) (void)!send(fd, "T", 1, MSG_NOSIGNAL);
  }
  for (const int fd : slow) close(fd);
}

TEST_F(StrangersTest, ARequestHasATimeHoweverItsBytesCome) {
  Serve();
  const int fd = ConnectTo(Port());
  const std::string request = "GET / HTTP/1.1\r\n" + kHost + "X: " + std::string(500, 'x');
  const auto begin = std::chrono::steady_clock::now();
  const timeval look{0, 200'000};
  setsockopt(fd, SOL_SOCKET, SO_RCVTIMEO, &look, sizeof look);
  char byte;
  ssize_t got = -1;
  for (size_t i = 0; i < request.size() && got != 0 && SecondsSince(begin) < 30; ++i) {
    if (send(fd, &request[i], 1, MSG_NOSIGNAL) < 0) break;
    got = recv(fd, &byte, 1, 0);
    if (got < 0 && errno != EAGAIN) break;
  }
  EXPECT_LT(SecondsSince(begin), 2 * WebServerLimits().request_s);
  close(fd);
}

// Resident memory of this process in megabytes.
double Memory() {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);) {
    if (line.rfind("VmRSS", 0) == 0) return std::atof(line.c_str() + line.find(':') + 1) / 1000;
  }
  return 0;
}

TEST_F(StrangersTest, EndlessRequestsTakeNoMemory) {
  Serve();
  const double before = Memory();
  const std::string begins[] = {
      "GET / HTTP/1.1\r\n" + kHost, "GET / HTTP/1.1\r\n" + kHost + "X: ",
      "POST /api/v1/session HTTP/1.1\r\n" + kHost + "Transfer-Encoding: chunked\r\n\r\n"};
  const std::string pieces[] = {"X-Header: " + std::string(1000, 'x') + "\r\n",
                                std::string(4000, 'x'),
                                "3e8\r\n" + std::string(1000, 'x') + "\r\n"};
  for (int round = 0; round < 10; ++round) {
    std::vector<int> fds;
    for (size_t kind = 0; kind < 3; ++kind) {
      fds.push_back(ConnectTo(Port()));
      const timeval patience{2, 0};
      setsockopt(fds.back(), SOL_SOCKET, SO_SNDTIMEO, &patience, sizeof patience);
      bool open = send(fds.back(), begins[kind].data(), begins[kind].size(), MSG_NOSIGNAL) > 0;
      for (int i = 0; open && i < 3000; ++i) {
        open = send(fds.back(), pieces[kind].data(), pieces[kind].size(), MSG_NOSIGNAL) > 0;
      }
    }
    for (const int fd : fds) close(fd);
  }
  EXPECT_LT(Memory() - before, 32);
  EXPECT_EQ(Client()->Get("/healthz")->status, 200);
}

TEST_F(StrangersTest, RepliesThatNobodyReadsTakeAtMostTheirBudget) {
  const int64_t study = Submit();
  Work();
  options_.reply_bytes = 40 << 20;
  Serve();
  const auto client = Client();
  const nlohmann::json pair =
      Json(*client, "/api/v1/studies/" + std::to_string(study) + "/pairs")["pairs"].at(0);
  const std::string path = "/api/v1/pairs/" + pair["id"].dump();
  const std::string folder = Json(*client, path)["path"];
  // More than the sockets' own buffers take.
  ASSERT_TRUE(store_->Put(folder + "/left.png", std::string(16 << 20, 'x')).ok());
  const std::string request = "GET " + path + "/file/left.png HTTP/1.1\r\n" + kHost + "\r\n";
  const auto begin = [&](int fd) {
    char head[12] = {};
    (void)!send(fd, request.data(), request.size(), MSG_NOSIGNAL);
    (void)!recv(fd, head, sizeof head, MSG_WAITALL);
    return std::string(head, sizeof head);
  };
  const int fds[] = {ConnectTo(Port()), ConnectTo(Port())};
  for (const int fd : fds) ASSERT_EQ(begin(fd), "HTTP/1.1 200");
  for (int i = 0; i < 2; ++i) {
    const auto refused = client->Get(path + "/file/left.png");
    ASSERT_EQ(refused->status, 503);
    EXPECT_THAT(refused->body, HasSubstr("too many large replies are being sent (at most 40 MB)"));
  }
  EXPECT_EQ(client->Get("/healthz")->status, 200);
  EXPECT_EQ(client->Get(path)->status, 200);
  for (const int fd : fds) close(fd);
  const auto closed = std::chrono::steady_clock::now();
  int status = 0;
  while (status != 200 && SecondsSince(closed) < 10) {
    status = client->Get(path + "/file/left.png")->status;
  }
  EXPECT_EQ(status, 200);
  // It is counted no more once it is read.
  for (int i = 0; i < 3; ++i) EXPECT_EQ(client->Get(path + "/file/left.png")->status, 200);
}

TEST_F(StrangersTest, HealthTellsOfADeafPort) {
  Serve();
  EXPECT_EQ(Client()->Get("/healthz")->status, 200);
  server_->Shutdown();
  std::this_thread::sleep_for(std::chrono::milliseconds(1100));  // An answer counts for a second.
  const auto deaf = Client()->Get("/healthz");
  EXPECT_EQ(deaf->status, 503);
  EXPECT_THAT(deaf->body, HasSubstr("gRPC at unix:"));
}

}  // namespace
}  // namespace parallax
