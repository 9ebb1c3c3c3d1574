// Whole files come out of a store with the size that is known, or not at all.
#include "worker/jobs/files/store_files.h"

#include <gmock/gmock.h>

#include <filesystem>

#include "common/base/system/file.h"
#include "common/store/store.h"
#include "tests/folder_test.h"

namespace parallax {
namespace {

namespace fs = std::filesystem;

class StoreFilesTest : public FolderTest {
 protected:
  void SetUp() override {
    auto store = OpenStore(dir_ + "/store");
    ASSERT_TRUE(store.ok()) << store.status();
    store_ = *std::move(store);
  }

  // Asks for `size` bytes of a file that has `actual`.
  absl::StatusOr<std::string> Get(size_t actual, int64_t size) {
    content_.assign(actual, 'x');
    if (actual > 0) content_.back() = 'y';
    EXPECT_TRUE(store_->Put("a/file", content_).ok());
    return GetWhole(*store_, "a/file", size);
  }

  std::string content_;
  std::unique_ptr<Store> store_;
};

constexpr int64_t kPiece = 4 << 20;

TEST_F(StoreFilesTest, FilesOfAllSizesComeWhole) {
  for (const int64_t size : {int64_t{0}, int64_t{1}, kPiece - 1, kPiece, kPiece + 1, 2 * kPiece}) {
    const auto bytes = Get(static_cast<size_t>(size), size);
    ASSERT_TRUE(bytes.ok()) << size << ": " << bytes.status();
    EXPECT_TRUE(*bytes == content_) << size;
  }
}

TEST_F(StoreFilesTest, AShorterOrLongerFileIsAnError) {
  for (const int64_t size : {int64_t{0}, int64_t{99}, int64_t{101}, kPiece}) {
    const auto bytes = Get(100, size);
    EXPECT_EQ(bytes.status().code(), absl::StatusCode::kDataLoss) << size;
    EXPECT_THAT(bytes.status().message(), testing::HasSubstr("a/file")) << size;
  }
  EXPECT_EQ(Get(static_cast<size_t>(kPiece) + 1, kPiece).status().code(),
            absl::StatusCode::kDataLoss);
}

TEST_F(StoreFilesTest, FoldersAreMadeWithThoseAboveThem) {
  EXPECT_TRUE(MakeFolders(dir_ + "/one/two/three").ok());
  EXPECT_TRUE(fs::is_directory(dir_ + "/one/two/three"));
  EXPECT_TRUE(MakeFolders(dir_ + "/one/two/three").ok());
  ASSERT_TRUE(store_->Put("a/file", "x").ok());
  EXPECT_FALSE(MakeFolders(dir_ + "/store/a/file/below").ok());
}

}  // namespace
}  // namespace parallax
