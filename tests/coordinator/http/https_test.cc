// The page on other addresses than loopback.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <openssl/evp.h>

#include <filesystem>
#include <sstream>

#include "common/base/system/file.h"
#include "coordinator/http/http_server.h"
#include "coordinator/init.h"
#include "coordinator/queue/job_queue.h"
#include "coordinator/rpc/coordinator_server.h"
#include "tests/coordinator/http/browser.h"
#include "tests/folder_test.h"

namespace parallax {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::Not;

std::string Base64(const std::string& text) {
  std::string code(4 * ((text.size() + 2) / 3) + 1, '\0');
  EVP_EncodeBlock(reinterpret_cast<unsigned char*>(code.data()),
                  reinterpret_cast<const unsigned char*>(text.data()),
                  static_cast<int>(text.size()));
  code.pop_back();
  return code;
}

class HttpsTest : public FolderTest {
 protected:
  HttpsTest() {
    JobQueueOptions queue;
    queue.db_path = dir_ + "/queue.db";
    queue_ = *JobQueue::Open(queue);
    CoordinatorServerOptions server;
    server.listen = {"unix:" + dir_ + "/s"};
    server_ = *CoordinatorServer::Start(server, *queue_);
    std::ostringstream said;
    EXPECT_TRUE(InitFarm({.dir = dir_ + "/tls"}, Clock::System(), said).ok());
    options_.listen = "0.0.0.0:0";
    options_.db_path = queue.db_path;
    options_.security = *MakeRpcSecurity(false, dir_ + "/tls/server", Clock::System());
  }
  ~HttpsTest() override {
    server_.reset();
    queue_.reset();
  }

  std::unique_ptr<JobQueue> queue_;
  std::unique_ptr<CoordinatorServer> server_;
  HttpServerOptions options_;
};

TEST_F(HttpsTest, OtherMachinesNeedTheTokenForAllButABareHealthAndThePagesFiles) {
  const auto http = HttpServer::Start(options_, *queue_, *server_);
  ASSERT_TRUE(http.ok()) << http.status();
  EXPECT_EQ((*http)->url().rfind("https://0.0.0.0:", 0), 0u);
  const std::string address = (*http)->address();
  const Browser client("https://127.0.0.1" + address.substr(address.rfind(':')),
                       {.ca_file = dir_ + "/tls/server/ca.crt"});
  for (const char* page : {"/metrics", "/nowhere"}) {
    const auto refused = client.Get(page);
    ASSERT_TRUE(refused) << page;
    EXPECT_EQ(refused->status, 401) << page;
    EXPECT_THAT(refused->get_header_value("WWW-Authenticate"), HasSubstr("Basic"));
    EXPECT_THAT(refused->body, HasSubstr("http.token"));
  }
  const auto health = client.Get("/healthz");
  ASSERT_TRUE(health);
  EXPECT_EQ(health->status, 200);
  EXPECT_EQ(health->body, "{\"status\":\"ok\"}\n");

  std::string token = *ReadFile(dir_ + "/tls/server/http.token");
  token.pop_back();  // The line's end.
  const auto get = [&client](const char* page, const Browser::Headers& headers) {
    const auto answer = client.Get(page, headers);
    return answer ? answer->status : -1;
  };
  EXPECT_EQ(get("/metrics", {{"Authorization", "Bearer " + token}}), 200);
  EXPECT_EQ(get("/", {}), 200);
  EXPECT_EQ(get("/api/v1/farm", {}), 401);
  EXPECT_EQ(get("/api/v1/farm", {{"Authorization", "Basic " + Base64("me:" + token)}}), 200);
  EXPECT_EQ(get("/metrics", {{"Authorization", "Bearer " + token + "x"}}), 401);
  EXPECT_EQ(get("/metrics", {{"Authorization", "Bearer "}}), 401);
  EXPECT_EQ(get("/metrics", {{"Authorization", "Basic ####"}}), 401);
  EXPECT_THAT(client.Get("/healthz", {{"Authorization", "Bearer " + token}})->body,
              HasSubstr("\"epoch\""));
}

TEST_F(HttpsTest, WithoutATokenNoOtherMachineIsServed) {
  fs::remove(dir_ + "/tls/server/http.token");
  const auto absent = HttpServer::Start(options_, *queue_, *server_);
  EXPECT_EQ(absent.status().code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(std::string(absent.status().message()), HasSubstr("http.token"));
  ASSERT_TRUE(WriteFile(dir_ + "/tls/server/http.token", "short\n").ok());
  EXPECT_THAT(std::string(HttpServer::Start(options_, *queue_, *server_).status().message()),
              HasSubstr("shorter than 16 characters"));
  options_.security = {};
  EXPECT_THAT(std::string(HttpServer::Start(options_, *queue_, *server_).status().message()),
              HasSubstr("--tls DIR"));
}

TEST_F(HttpsTest, LoopbackStaysPlain) {
  options_.listen = "127.0.0.1:0";
  const auto http = HttpServer::Start(options_, *queue_, *server_);
  ASSERT_TRUE(http.ok()) << http.status();
  EXPECT_EQ((*http)->url(), "http://" + (*http)->address() + "/");
}

}  // namespace
}  // namespace parallax
