#include "worker/jobs/files/core_share.h"

#include <gtest/gtest.h>

#include "tests/folder_test.h"

namespace parallax {
namespace {

class CoreShareTest : public FolderTest {
 protected:
  // Takes cores by `take`; cancels it if they are not free at once.
  template <typename Take>
  static absl::StatusOr<CoreShare::Hold> Try(Take take) {
    CancelToken cancel;
    int waits = 0;
    return take(cancel, [&] {
      if (++waits == 2) cancel.Cancel();
    });
  }
  static absl::StatusOr<CoreShare::Hold> TryAlone(const CoreShare& share, int threads) {
    return Try([&](const CancelToken& c, const CoreShare::Waiting& w) {
      return share.TakeAlone(threads, c, w);
    });
  }
  static absl::StatusOr<CoreShare::Hold> TryShared(const CoreShare& share) {
    return Try(
        [&](const CancelToken& c, const CoreShare::Waiting& w) { return share.TakeShared(c, w); });
  }
};

TEST_F(CoreShareTest, TrainingsHaveTheirCoresAlone) {
  const CoreShare one(dir_, 4), other(dir_, 4);
  const auto first = TryAlone(one, 2), second = TryAlone(other, 2);
  EXPECT_TRUE(first.ok() && second.ok());
  EXPECT_FALSE(TryAlone(one, 1).ok());
  EXPECT_FALSE(TryShared(other).ok()) << "no core is left";
}

TEST_F(CoreShareTest, OthersShareACoreAndTrainingsTakeTheRest) {
  const CoreShare share(dir_, 4);
  const auto first = TryShared(share), second = TryShared(share);
  EXPECT_TRUE(first.ok() && second.ok());
  EXPECT_FALSE(TryAlone(share, 4).ok());
  EXPECT_TRUE(TryAlone(share, 3).ok());
}

TEST_F(CoreShareTest, WhoWantsMoreThanThereIsGetsAll) {
  const CoreShare share(dir_, 2);
  auto hold = TryAlone(share, 64);
  ASSERT_TRUE(hold.ok());
  EXPECT_FALSE(TryShared(share).ok());
  *hold = CoreShare::Hold();
  EXPECT_TRUE(TryShared(share).ok());
}

}  // namespace
}  // namespace parallax
