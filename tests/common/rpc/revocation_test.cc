// The list of certificates that a coordinator refuses.
#include "common/rpc/revocation.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "common/base/system/file.h"
#include "tests/folder_test.h"

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

class RevocationTest : public FolderTest {
 protected:
  RevocationTest() { path_ = dir_ + "/revoked"; }

  const std::string ada_ = std::string(64, 'a'), bob_ = std::string(64, 'b');
  std::string path_;
  SteppedClock clock_;
};

TEST_F(RevocationTest, AListThatIsLostFreesNobody) {
  for (const char* nothing : {"", " \n\n"}) {
    ASSERT_TRUE(WriteFile(path_, nothing).ok());
    const absl::Status empty = RevokedCertificates::Open(path_, clock_).status();
    EXPECT_EQ(empty.code(), absl::StatusCode::kFailedPrecondition) << empty;
    EXPECT_THAT(std::string(empty.message()), HasSubstr("begins with '#'"));
  }
  fs::remove(path_);
  const absl::Status absent = RevokedCertificates::Open(path_, clock_).status();
  EXPECT_EQ(absent.code(), absl::StatusCode::kFailedPrecondition) << absent;
  EXPECT_THAT(std::string(absent.message()), HasSubstr(path_));

  ASSERT_TRUE(WriteFile(path_, ada_ + "\n" + bob_ + "\n").ok());
  const auto revoked = RevokedCertificates::Open(path_, clock_);
  ASSERT_TRUE(revoked.ok()) << revoked.status();
  const std::string carl(64, 'c');
  const auto both = [&] { return (*revoked)->Contains(ada_) && (*revoked)->Contains(bob_); };
  for (const std::string& left : {std::string(), std::string("# none\n"), ada_ + "\n", carl}) {
    ASSERT_TRUE(WriteFile(path_, left).ok());
    clock_.Step();
    EXPECT_TRUE(both()) << left;
    fs::remove(path_);
    clock_.Step();
    EXPECT_TRUE(both()) << "gone after " << left;
  }
  EXPECT_TRUE((*revoked)->Contains(carl)) << "and what is added counts";
}

TEST_F(RevocationTest, AFileThatGrowsIsHeard) {
  ASSERT_TRUE(WriteFile(path_, kEmptyRevokedList).ok());
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
