#include "coordinator/init.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <filesystem>
#include <sstream>

#include "common/base/system/file.h"
#include "common/rpc/certificate.h"
#include "common/rpc/revocation.h"
#include "tests/folder_test.h"

namespace parallax {
namespace {

namespace fs = std::filesystem;
using ::testing::Contains;
using ::testing::HasSubstr;

class InitTest : public FolderTest {
 protected:
  InitTest() { options_.dir = dir_ + "/farm"; }

  absl::Status Init() { return InitFarm(options_, Clock::System(), said_); }
  mode_t ModeOf(const std::string& path) const {
    struct stat info {};
    EXPECT_EQ(stat((options_.dir + "/" + path).c_str(), &info), 0) << path;
    return info.st_mode & 0777;
  }
  auto Load(const std::string& folder) const {
    return LoadTlsIdentity(options_.dir + "/" + folder, Clock::System());
  }

  InitOptions options_;
  std::ostringstream said_;
};

TEST_F(InitTest, AFarmGetsAuthorityServerAndParties) {
  options_.hosts = {"farm.example.org", "10.0.0.7"};
  options_.issue = {{"worker", "pool"}, {"read-only", "board"}};
  ASSERT_TRUE(Init().ok());
  const auto server = Load("server");
  ASSERT_TRUE(server.ok()) << server.status();
  for (const char* host : {"farm.example.org", "10.0.0.7", "localhost", "127.0.0.1", "::1"}) {
    EXPECT_THAT((*server)->facts.hosts, Contains(host));
  }
  EXPECT_EQ((*Load("worker-pool"))->facts.role, Role::kWorker);
  EXPECT_EQ((*Load("read-only-board"))->facts.role, Role::kReadOnly);
  EXPECT_EQ((*Load("read-only-board"))->facts.name, "board");
  for (const char* key :
       {"ca/ca.key", "server/tls.key", "server/http.token", "worker-pool/tls.key"}) {
    EXPECT_EQ(ModeOf(key), 0600u) << key;
  }
  for (const char* folder : {"ca", "server", "worker-pool"}) EXPECT_EQ(ModeOf(folder), 0700u);
  EXPECT_FALSE(fs::exists(options_.dir + "/worker-pool/ca.key"));
  EXPECT_THAT(said_.str(), HasSubstr("coordinator serve --tls " + options_.dir + "/server"));
}

TEST_F(InitTest, LaterPartiesComeFromTheSameAuthority) {
  ASSERT_TRUE(Init().ok());
  const std::string ca = *ReadFile(options_.dir + "/ca/ca.crt");
  const std::string server = *ReadFile(options_.dir + "/server/tls.crt");
  options_.issue = {{"submitter", "ada"}};
  ASSERT_TRUE(Init().ok());
  EXPECT_EQ(*ReadFile(options_.dir + "/submitter-ada/ca.crt"), ca);
  EXPECT_EQ(*ReadFile(options_.dir + "/server/tls.crt"), server);
  EXPECT_TRUE(Load("submitter-ada").ok()) << Load("submitter-ada").status();
}

TEST_F(InitTest, NothingIsEverOverwritten) {
  options_.issue = {{"worker", "pool"}};
  ASSERT_TRUE(Init().ok());
  const std::string key = *ReadFile(options_.dir + "/worker-pool/tls.key");
  options_.issue = {{"submitter", "ada"}, {"worker", "pool"}};
  EXPECT_THAT(std::string(Init().message()), HasSubstr("worker-pool is there already"));
  EXPECT_FALSE(fs::exists(options_.dir + "/submitter-ada")) << "all or nothing";
  EXPECT_EQ(*ReadFile(options_.dir + "/worker-pool/tls.key"), key);
  options_.issue.clear();
  EXPECT_THAT(std::string(Init().message()), HasSubstr("--issue ROLE NAME"));
  options_.hosts = {"other"};
  EXPECT_THAT(std::string(Init().message()), HasSubstr("server is there already; --renew server"));
}

TEST_F(InitTest, RenewedPartiesStayWhoTheyAre) {
  options_.hosts = {"farm.example.org"};
  options_.issue = {{"worker", "pool"}};
  options_.days = 1;
  ASSERT_TRUE(Init().ok());
  const auto server = *Load("server"), pool = *Load("worker-pool");
  const std::string token = *ReadFile(options_.dir + "/server/http.token");
  options_.hosts = {};
  options_.issue = {};
  options_.days = 100;
  options_.renew = {"server", "worker-pool"};
  ASSERT_TRUE(Init().ok()) << Init();
  const auto new_server = *Load("server"), new_pool = *Load("worker-pool");
  EXPECT_EQ(new_server->facts.hosts, server->facts.hosts);
  EXPECT_EQ(new_pool->facts.name, "pool");
  EXPECT_EQ(new_pool->facts.role, Role::kWorker);
  EXPECT_EQ(new_pool->ca_pem, pool->ca_pem);
  EXPECT_GT(new_pool->facts.not_after_unix_s, pool->facts.not_after_unix_s + 90 * 86400);
  EXPECT_NE(new_pool->facts.sha256, pool->facts.sha256);
  EXPECT_NE(new_pool->own.key_pem, pool->own.key_pem);
  EXPECT_EQ(*ReadFile(options_.dir + "/server/http.token"), token);
  EXPECT_EQ(ModeOf("worker-pool"), 0700u);
  EXPECT_FALSE(fs::exists(options_.dir + "/.new-worker-pool")) << "old keys stay nowhere";
}

TEST_F(InitTest, ARenewedServerGetsMoreHostsAndKeepsItsRevokedCertificates) {
  options_.hosts = {"farm.example.org"};
  options_.issue = {{"submitter", "ada"}};
  ASSERT_TRUE(Init().ok());
  options_ = {.dir = options_.dir, .revoke = {"submitter-ada"}};
  ASSERT_TRUE(Init().ok());
  const std::string revoked = *ReadFile(options_.dir + "/server/revoked");
  options_ = {.dir = options_.dir, .hosts = {"other"}, .renew = {"server"}};
  ASSERT_TRUE(Init().ok()) << Init();
  for (const char* host : {"farm.example.org", "other", "localhost"}) {
    EXPECT_THAT((*Load("server"))->facts.hosts, Contains(host));
  }
  EXPECT_EQ(*ReadFile(options_.dir + "/server/revoked"), revoked);
}

TEST_F(InitTest, ARevokedCertificateIsListedAndOutlivesTheServersRenewal) {
  options_.issue = {{"submitter", "ada"}};
  ASSERT_TRUE(Init().ok());
  const std::string old = (*Load("submitter-ada"))->facts.sha256;
  options_.issue = {};
  options_.revoke = {"submitter-ada"};
  options_.renew = {"submitter-ada", "server"};
  ASSERT_TRUE(Init().ok());
  const auto revoked = RevokedCertificates::Open(options_.dir + "/server/revoked", Clock::System());
  ASSERT_TRUE(revoked.ok()) << revoked.status();
  EXPECT_TRUE((*revoked)->Contains(old));
  EXPECT_FALSE((*revoked)->Contains((*Load("submitter-ada"))->facts.sha256));
  EXPECT_EQ(*ReadFile(options_.dir + "/server/revoked"),
            kEmptyRevokedList + old + "  # submitter-ada\n");
  options_.revoke = {"submitter-eve"};
  EXPECT_THAT(std::string(Init().message()), HasSubstr("has no folder 'submitter-eve'"));
}

TEST_F(InitTest, MistakesLeaveNothingBehind) {
  options_.issue = {{"king", "ada"}};
  EXPECT_THAT(std::string(Init().message()),
              HasSubstr("allowed are worker, submitter, operator, read-only"));
  options_.issue = {{"worker", "../../etc"}};
  EXPECT_EQ(Init().code(), absl::StatusCode::kInvalidArgument);
  options_.issue = {};
  options_.hosts = {"a b"};
  EXPECT_EQ(Init().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_FALSE(fs::exists(options_.dir + "/ca"));
}

}  // namespace
}  // namespace parallax
