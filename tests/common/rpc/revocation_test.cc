// The list of certificates that a coordinator refuses.
#include "common/rpc/revocation.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stdlib.h>

#include <filesystem>

#include "common/base/system/file.h"

namespace parallax {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

class SteppedClock final : public Clock {
 public:
  SteadyTime Steady() override { return now_; }
  double UnixSeconds() override { return 1.7e9; }
  void Step() { now_ += std::chrono::seconds(2); }

 private:
  SteadyTime now_ = SteadyTime() + std::chrono::hours(1);
};

class RevocationTest : public testing::Test {
 protected:
  RevocationTest() {
    char name[] = "/tmp/parallax-revocation-XXXXXX";
    dir_ = mkdtemp(name);
    path_ = dir_ + "/revoked";
  }
  ~RevocationTest() override { fs::remove_all(dir_); }

  const std::string ada_ = std::string(64, 'a'), bob_ = std::string(64, 'b');
  std::string dir_, path_;
  SteppedClock clock_;
};

TEST_F(RevocationTest, AFileThatComesAndGrowsIsHeard) {
  const auto revoked = RevokedCertificates::Open(path_, clock_);
  ASSERT_TRUE(revoked.ok()) << revoked.status();
  EXPECT_FALSE((*revoked)->Contains(ada_));
  ASSERT_TRUE(WriteFile(path_, ada_ + "  # submitter-ada\n").ok());
  clock_.Step();
  EXPECT_TRUE((*revoked)->Contains(ada_));
  EXPECT_FALSE((*revoked)->Contains(bob_));
  ASSERT_TRUE(WriteFile(path_, ada_ + "\n" + bob_).ok());
  clock_.Step();
  EXPECT_TRUE((*revoked)->Contains(ada_));
  EXPECT_TRUE((*revoked)->Contains(bob_));
}

TEST_F(RevocationTest, ASpoiledFileIsAnErrorAtStartAndFreesNobodyLater) {
  ASSERT_TRUE(WriteFile(path_, "# ours\n\n" + ada_ + "\n").ok());
  const auto revoked = RevokedCertificates::Open(path_, clock_);
  ASSERT_TRUE(revoked.ok()) << revoked.status();
  ASSERT_TRUE(WriteFile(path_, "# ours\nAB:CD\n").ok());
  clock_.Step();
  EXPECT_TRUE((*revoked)->Contains(ada_));
  const absl::Status bad = RevokedCertificates::Open(path_, clock_).status();
  EXPECT_EQ(bad.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(bad.message()), HasSubstr("/revoked:2: 'AB:CD' is no SHA-256"));
}

}  // namespace
}  // namespace parallax
