#include "common/store/local_store.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sched.h>
#include <sys/mount.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <filesystem>
#include <thread>

#include "common/base/system/file.h"
#include "tests/common/store/store_conformance.h"

namespace parallax {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

std::string FreshFolder() {
  static std::atomic<int> counter{0};
  const std::string folder = ::testing::TempDir() + "local_store_" + std::to_string(::getpid()) +
                             "_" + std::to_string(++counter);
  fs::remove_all(folder);
  return folder;
}

std::unique_ptr<Store> MakeLocalStore() {
  auto store = OpenStore("file://" + FreshFolder());
  EXPECT_TRUE(store.ok()) << store.status();
  return std::move(*store);
}

INSTANTIATE_TEST_SUITE_P(Local, StoreConformance, ::testing::Values(&MakeLocalStore));

TEST(LocalStore, LivesInItsFolderUnderItsUri) {
  const std::string folder = FreshFolder() + "/deep/er";
  const auto store = OpenStore(folder + "/");
  ASSERT_TRUE(store.ok()) << store.status();
  EXPECT_EQ((*store)->Uri(), "file://" + folder);
  ASSERT_TRUE((*store)->Put("k/a", "x").ok());
  EXPECT_EQ(*(*store)->LocalPath("k/a"), folder + "/k/a");
  EXPECT_EQ(*ReadFile(folder + "/k/a"), "x");
  const auto again = OpenStore("file://" + folder);
  EXPECT_EQ(*(*again)->Get("k/a"), "x");
}

TEST(LocalStore, SymbolicLinksLeadNowhere) {
  const std::string folder = FreshFolder(), outside = FreshFolder();
  fs::create_directories(outside);
  ASSERT_TRUE(WriteFile(outside + "/secret", "s").ok());
  const auto store = OpenStore(folder);
  fs::create_directory_symlink(outside, folder + "/link");
  fs::create_symlink(outside + "/secret", folder + "/file");
  EXPECT_EQ((*store)->Get("link/secret").status().code(), absl::StatusCode::kPermissionDenied);
  EXPECT_FALSE((*store)->Get("file").ok());
  EXPECT_FALSE((*store)->Put("link/new", "x").ok());
  EXPECT_TRUE((*store)->List("")->empty());
  ASSERT_TRUE((*store)->Put("file", "mine").ok());  // Replaces the link itself.
  EXPECT_EQ(*ReadFile(outside + "/secret"), "s");
  ASSERT_TRUE((*store)->RemoveTree("link").ok());
  EXPECT_TRUE(fs::exists(outside + "/secret"));
  EXPECT_FALSE(fs::exists(outside + "/new"));
}

TEST(LocalStore, AMarkerTellsTheStoreFromADiskThatIsNotMounted) {
  const std::string folder = FreshFolder();
  const StoreOptions seen = {.create = false};
  EXPECT_THAT(std::string(OpenStore(folder, seen).status().message()),
              HasSubstr("there is no such folder on this machine; mount"));
  EXPECT_FALSE(fs::exists(folder)) << "made by who was only to look";
  fs::create_directories(folder);  // The mount point.
  const absl::Status empty = OpenStore(folder, seen).status();
  EXPECT_EQ(empty.code(), absl::StatusCode::kNotFound);
  EXPECT_THAT(std::string(empty.message()), HasSubstr("is the shared disk mounted here?"));

  const auto store = OpenStore(folder);
  ASSERT_TRUE(store.ok()) << store.status();
  const std::string id = (*store)->Id();
  EXPECT_EQ(id.size(), 32u);
  EXPECT_TRUE((*store)->List("")->empty()) << "the marker is not a result";
  EXPECT_EQ((*OpenStore(folder))->Id(), id) << "a store keeps its id";
  EXPECT_TRUE(OpenStore(folder, {.create = false, .id = id}).ok());
  const absl::Status other = OpenStore(folder, {.create = false, .id = "other"}).status();
  EXPECT_EQ(other.code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(std::string(other.message()), HasSubstr("is the right disk mounted here?"));
  EXPECT_NE((*OpenStore(FreshFolder()))->Id(), id);

  ASSERT_TRUE(WriteFile(folder + "/.parallax-store", "nonsense").ok());
  EXPECT_EQ(OpenStore(folder).status().code(), absl::StatusCode::kDataLoss);
}

TEST(LocalStore, AllWhoMakeAStoreAtTheSameTimeMakeTheSameOne) {
  for (int round = 0; round < 50; ++round) {
    const std::string folder = FreshFolder();
    std::vector<std::string> ids(4);
    {
      std::vector<std::jthread> threads;
      for (std::string& id : ids) {
        threads.emplace_back([&id, &folder] {
          const auto store = OpenStore(folder);
          id = store.ok() ? (*store)->Id() : std::string(ToStd(store.status().message()));
        });
      }
    }
    EXPECT_THAT(ids, testing::Each((*OpenStore(folder))->Id())) << round;
  }
}

TEST(LocalStore, TemporaryFilesAreNotResults) {
  const std::string folder = FreshFolder();
  const auto store = OpenStore(folder);
  ASSERT_TRUE(WriteFile(folder + "/.tmp-1-1", "half").ok());
  EXPECT_TRUE((*store)->List("")->empty());
}

TEST(LocalStore, ClashesAreToldWithPathAndCause) {
  const std::string folder = FreshFolder();
  const auto store = OpenStore(folder);
  ASSERT_TRUE((*store)->Put("a", "x").ok());
  const absl::Status status = (*store)->Put("a/b", "x");
  EXPECT_EQ(std::string(status.message()), "open " + folder + "/a: Not a directory");
  ASSERT_TRUE((*store)->Put("d/e", "x").ok());
  EXPECT_FALSE((*store)->Put("d", "x").ok());
  EXPECT_EQ((*store)->List("")->size(), 2u);  // Nothing half-written is left.
}

TEST(OpenStore, RefusesWhatIsNoFolder) {
  const std::string file = FreshFolder();
  ASSERT_TRUE(WriteFile(file, "x").ok());
  EXPECT_THAT(std::string(OpenStore(file).status().message()), HasSubstr("store " + file + ": "));
  EXPECT_THAT(std::string(OpenStore(file + "/sub").status().message()),
              HasSubstr("Not a directory"));
  EXPECT_THAT(std::string(OpenStore("gs://bucket/x").status().message()),
              HasSubstr("allowed is a folder, file:///a/folder or s3://bucket/prefix"));
  EXPECT_FALSE(OpenStore("file://relative").ok());
  EXPECT_FALSE(OpenStore("").ok());
}

// Runs `body` with a tiny file system mounted on `folder`, in a mount namespace of its own. `body`
// returns "" or what went wrong. Empty when the machine does not allow mounting.
std::optional<std::string> WithMount(const std::string& folder, unsigned long flags,
                                     const char* options, const auto& body) {
  int pipe_fds[2];
  if (::pipe(pipe_fds) != 0) return std::nullopt;
  const pid_t child = ::fork();
  if (child == 0) {
    std::string report = "\1";  // Not allowed.
    const bool isolated =
        ::unshare(CLONE_NEWNS) == 0 || ::unshare(CLONE_NEWUSER | CLONE_NEWNS) == 0;
    if (isolated && ::mount(nullptr, "/", nullptr, MS_REC | MS_PRIVATE, nullptr) == 0 &&
        ::mount("tmpfs", folder.c_str(), "tmpfs", flags, options) == 0) {
      report = body();
    }
    (void)!::write(pipe_fds[1], report.data(), report.size());
    ::_exit(0);
  }
  ::close(pipe_fds[1]);
  std::string report;
  char buffer[4096];
  for (ssize_t count; (count = ::read(pipe_fds[0], buffer, sizeof(buffer))) > 0;) {
    report.append(buffer, static_cast<size_t>(count));
  }
  ::close(pipe_fds[0]);
  ::waitpid(child, nullptr, 0);
  if (report == "\1") return std::nullopt;
  return report;
}

TEST(LocalStore, AFullDiskIsToldAndLeavesNothingHalfWritten) {
  const std::string folder = FreshFolder();
  fs::create_directories(folder);
  const auto report = WithMount(folder, 0, "size=64k", [&]() -> std::string {
    auto store = OpenStore(folder);
    if (!store.ok()) return store.status().ToString();
    const absl::Status status = (*store)->Put("a", std::string(200000, 'x'));
    if (!(*store)->List("")->empty()) return "something is left";
    if (!(*store)->Put("b", "small").ok()) return "no room after the failure";
    const absl::Status atomic = WriteFileAtomically(folder + "/c", std::string(200000, 'x'));
    return status.ToString() + "\n" + atomic.ToString();
  });
  if (!report) GTEST_SKIP() << "no permission to mount";
  EXPECT_EQ(*report, "RESOURCE_EXHAUSTED: write " + folder + "/a: No space left on device\n" +
                         "RESOURCE_EXHAUSTED: write " + folder + "/c: No space left on device");
}

TEST(OpenStore, AReadOnlyDiskIsToldAtOnce) {
  const std::string folder = FreshFolder();
  fs::create_directories(folder);
  const auto report = WithMount(folder, MS_RDONLY, "size=64k", [&]() -> std::string {
    return OpenStore(folder).status().ToString() + "\n" +
           WriteFileAtomically(folder + "/c", "x").ToString();
  });
  if (!report) GTEST_SKIP() << "no permission to mount";
  EXPECT_EQ(*report, "PERMISSION_DENIED: store: write " + folder + ": Read-only file system\n" +
                         "PERMISSION_DENIED: open " + folder + "/c: Read-only file system");
}

TEST(WriteFileAtomically, ReplacesTheFileAndLeavesNoTemporary) {
  const std::string folder = FreshFolder();
  fs::create_directories(folder);
  ASSERT_TRUE(WriteFileAtomically(folder + "/a", "one").ok());
  ASSERT_TRUE(WriteFileAtomically(folder + "/a", "two").ok());
  EXPECT_EQ(*ReadFile(folder + "/a"), "two");
  EXPECT_EQ(std::distance(fs::directory_iterator(folder), fs::directory_iterator()), 1);
  EXPECT_EQ(std::string(WriteFileAtomically(folder + "/no/a", "x").message()),
            "open " + folder + "/no/a: No such file or directory");
  EXPECT_TRUE(SyncPath(folder).ok());
  EXPECT_FALSE(SyncPath(folder + "/no").ok());
}

}  // namespace
}  // namespace parallax
