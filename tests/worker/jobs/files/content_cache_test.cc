// Own content on its way from a store to a worker's cache.
#include "worker/jobs/files/content_cache.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <future>
#include <mutex>
#include <thread>

#include "common/base/hash.h"
#include "common/base/system/file.h"
#include "common/store/store.h"
#include "tests/folder_test.h"
#include "tests/worker/jobs/job_fixture.h"
#include "worker/jobs/job_options.h"
#include "worker/materials/pictures/user_picture.h"

namespace parallax {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

class ContentCacheTest : public FolderTest {
 protected:
  void SetUp() override {
    store_ = *OpenStore(dir_ + "/store");
    SetPictureRoot(dir_ + "/root");
    SetContentRoot(dir_ + "/cache");
    list_ = {Stored("one.png", "first"), Stored("deep/two.png", "second")};
    sha256_ = Sha256Hex(ContentListText(list_));
    ASSERT_TRUE(store_->Put(ContentPath(sha256_), ContentListText(list_)).ok());
  }
  void TearDown() override {
    SetPictureRoot("");
    SetContentRoot("");
  }

  ContentFile Stored(const std::string& name, const std::string& bytes) {
    const ContentFile file{name, static_cast<int64_t>(bytes.size()), Sha256Hex(bytes)};
    EXPECT_TRUE(store_->Put(ContentPath(file.sha256), bytes).ok());
    return file;
  }
  absl::StatusOr<std::string> Bring(const std::string& path = "mine/pictures",
                                    int64_t max_bytes = 1000) const {
    return ContentCache({dir_ + "/cache", max_bytes})
        .Bring(*store_, ContentReferenceText({sha256_, path}), {});
  }

  std::string sha256_;
  std::unique_ptr<Store> store_;
  std::vector<ContentFile> list_;
};

TEST_F(ContentCacheTest, BringsAFolderOnceAndItCanBeReadAsBelowThePictureRoot) {
  const auto folder = Bring();
  ASSERT_TRUE(folder.ok()) << folder.status();
  EXPECT_EQ(*ReadFile(*folder + "/one.png"), "first");
  EXPECT_EQ(*ReadFile(*folder + "/deep/two.png"), "second");
  EXPECT_EQ(fs::path(*folder).filename(), "pictures") << "the name of a class of meshes";
  EXPECT_EQ(*BelowPictureRoot(*folder), fs::canonical(*folder).string());
  ASSERT_TRUE(store_->RemoveTree("content").ok());
  EXPECT_EQ(*Bring(), *folder) << "without the store";
  EXPECT_EQ(*ContentCache({dir_ + "/cache", 9}).Bring(*store_, "plain/path", {}), "plain/path");
}

TEST_F(ContentCacheTest, AnOwnCopyIsTakenWhenItIsTheSame) {
  fs::create_directories(dir_ + "/root/mine/pictures/deep");
  ASSERT_TRUE(WriteFile(dir_ + "/root/mine/pictures/one.png", "first").ok());
  ASSERT_TRUE(WriteFile(dir_ + "/root/mine/pictures/deep/two.png", "second").ok());
  EXPECT_EQ(*Bring(), "mine/pictures");
  EXPECT_FALSE(fs::exists(dir_ + "/cache"));
  ASSERT_TRUE(WriteFile(dir_ + "/root/mine/pictures/deep/two.png", "sec0nd").ok());
  EXPECT_THAT(*Bring(), HasSubstr(dir_ + "/cache/"));
}

TEST_F(ContentCacheTest, ADamagedFileIsBroughtAgain) {
  const std::string folder = *Bring();
  ASSERT_TRUE(WriteFile(folder + "/one.png", "f1rst").ok());
  EXPECT_EQ(*Bring(), folder);
  EXPECT_EQ(*ReadFile(folder + "/one.png"), "first");
}

TEST_F(ContentCacheTest, WhatIsNotAsItsHashSaysIsRefusedAndLeavesNothing) {
  const std::string file = dir_ + "/store/" + ContentPath(list_[0].sha256);
  for (const char* bytes : {"f1rst", "firs", "first and more"}) {
    fs::remove(file);
    ASSERT_TRUE(WriteFile(file, bytes).ok());
    const auto folder = Bring();
    EXPECT_EQ(folder.status().code(), absl::StatusCode::kDataLoss) << bytes;
    EXPECT_THAT(std::string(ToStd(folder.status().message())), HasSubstr("one.png"));
    EXPECT_TRUE(fs::is_empty(dir_ + "/cache"));
  }
  const std::string list = dir_ + "/store/" + ContentPath(sha256_);
  fs::remove(list);
  ASSERT_TRUE(WriteFile(list, ContentListText({list_[1]})).ok());
  EXPECT_EQ(Bring().status().code(), absl::StatusCode::kDataLoss);
}

TEST_F(ContentCacheTest, AJobThatWaitsForAnothersFetchTellsThatItLives) {
  DistantStore far(std::move(store_));
  std::promise<void> fetching, waits;
  std::once_flag began, waited;
  far.on_piece = [&] {
    std::call_once(began, [&] {
      fetching.set_value();
      waits.get_future().wait_for(std::chrono::seconds(20));
    });
  };
  const ContentCache cache({dir_ + "/cache", 1000});
  const std::string name = ContentReferenceText({sha256_, "mine/pictures"});
  std::thread first([&] { EXPECT_TRUE(cache.Bring(far, name, {}).ok()); });
  fetching.get_future().wait();
  FetchContext context;
  context.progress = [&] { std::call_once(waited, [&] { waits.set_value(); }); };
  const auto second = cache.Bring(far, name, context);
  first.join();
  EXPECT_TRUE(second.ok()) << second.status();
}

TEST_F(ContentCacheTest, NamesDoNotLeaveTheCache) {
  const std::string text = "parallax-content 1\n" + list_[0].sha256 + " 5 ../../out.png\n";
  sha256_ = Sha256Hex(text);
  ASSERT_TRUE(store_->Put(ContentPath(sha256_), text).ok());
  EXPECT_EQ(Bring().status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_FALSE(fs::exists(dir_ + "/out.png"));
  EXPECT_FALSE(BelowPictureRoot(dir_ + "/cache/../store").ok());
  EXPECT_FALSE(BelowPictureRoot("/etc").ok());
}

TEST_F(ContentCacheTest, AListThatTheStoreLacksLeavesThePath) {
  sha256_ = std::string(64, 'b');
  EXPECT_EQ(*Bring("srv/mine"), "srv/mine");
}

TEST_F(ContentCacheTest, TheOldestGivesWayAndWhatIsTooLargeIsRefused) {
  const auto large = Bring("mine/pictures", 10);
  EXPECT_EQ(large.status().code(), absl::StatusCode::kResourceExhausted);
  EXPECT_THAT(std::string(ToStd(large.status().message())), HasSubstr("--cache-gb"));
  const std::string first = *Bring("mine/pictures", 30);
  const std::string recent = *Bring("mine/others", 30);
  EXPECT_TRUE(fs::exists(first)) << "used in the last hour";
  fs::last_write_time(fs::path(first).parent_path(),
                      fs::file_time_type::clock::now() - std::chrono::hours(2));
  ASSERT_TRUE(Bring("mine/third", 30).ok());
  EXPECT_FALSE(fs::exists(first));
  EXPECT_TRUE(fs::exists(recent));
}

// The default folder of a worker's cache also holds the user's shared store.
TEST_F(ContentCacheTest, CachesLieInsideOfTheirFolderAndLeaveTheRestOfItAlone) {
  JobOptions options;
  options.SetCaches(dir_ + "/mount/", 10);
  EXPECT_EQ(options.frame_cache.dir, dir_ + "/mount/frames");
  EXPECT_EQ(options.content_cache.dir, dir_ + "/mount/content");
  for (const char* file : {"frames/a/left.png", "content/b/wood.png", "store/c/left.png"}) {
    fs::create_directories(fs::path(dir_ + "/mount/" + file).parent_path());
    ASSERT_TRUE(WriteFile(dir_ + "/mount/" + file, std::string(100, 'x')).ok());
  }
  FrameCache(options.frame_cache).Trim();
  EXPECT_FALSE(fs::exists(dir_ + "/mount/frames/a/left.png"));
  EXPECT_TRUE(fs::exists(dir_ + "/mount/content/b/wood.png"));
  EXPECT_TRUE(fs::exists(dir_ + "/mount/store/c/left.png"));
}

}  // namespace
}  // namespace parallax
