#include "coordinator/client/preview/watch_loop.h"

#include <gtest/gtest.h>

#include <atomic>
#include <filesystem>
#include <thread>

#include "common/base/system/file.h"
#include "tests/folder_test.h"

namespace parallax::client {
namespace {

namespace fs = std::filesystem;
using std::chrono::milliseconds;

class WatchLoopTest : public FolderTest {
 protected:
  void Write(const std::string& name, const std::string& text) {
    ASSERT_TRUE(WriteFile(dir_ + "/" + name, text).ok());
  }
  // Asks until the change has kept still.
  static bool ChangedAndStill(WatchedFiles& files) { return files.Changed() || files.Changed(); }
};

TEST_F(WatchLoopTest, AChangeIsToldOnceItKeepsStill) {
  Write("a", "1");
  WatchedFiles files;
  files.Watch({dir_ + "/a", dir_ + "/none"});
  EXPECT_EQ(files.size(), 2u);
  EXPECT_FALSE(ChangedAndStill(files));
  Write("a", "12");
  EXPECT_FALSE(files.Changed()) << "it may be half written";
  Write("a", "123");
  EXPECT_FALSE(files.Changed());
  EXPECT_TRUE(files.Changed());
  EXPECT_FALSE(ChangedAndStill(files));
}

TEST_F(WatchLoopTest, FilesThatComeGoOrAreReplacedHaveChanged) {
  Write("a", "1");
  WatchedFiles files;
  files.Watch({dir_ + "/a", dir_ + "/b"});
  Write("b", "1");
  EXPECT_TRUE(ChangedAndStill(files));
  fs::remove(dir_ + "/b");
  EXPECT_TRUE(ChangedAndStill(files));
  // As editors save: another file of the same size and time takes the name.
  Write("c", "2");
  fs::last_write_time(dir_ + "/c", fs::last_write_time(dir_ + "/a"));
  fs::rename(dir_ + "/c", dir_ + "/a");
  EXPECT_TRUE(ChangedAndStill(files));
}

TEST_F(WatchLoopTest, AFolderChangesWithWhatIsInItExceptForWhatTheWorkWrites) {
  fs::create_directories(dir_ + "/pictures/more");
  WatchedFiles files({dir_ + "/pictures/sheet.png"});
  files.Watch({dir_ + "/pictures"});
  EXPECT_FALSE(ChangedAndStill(files));
  Write("pictures/sheet.png", "png");
  EXPECT_FALSE(ChangedAndStill(files));
  Write("pictures/more/one.jpg", "1");
  EXPECT_TRUE(ChangedAndStill(files));
  Write("pictures/more/one.jpg", "22");
  EXPECT_TRUE(ChangedAndStill(files));
  fs::rename(dir_ + "/pictures/more/one.jpg", dir_ + "/pictures/more/two.jpg");
  EXPECT_TRUE(ChangedAndStill(files));
}

TEST_F(WatchLoopTest, AChangeBeforeItsPathIsNamedAgainStillCounts) {
  Write("a", "1");
  WatchedFiles files;
  files.Watch({dir_ + "/a"});
  Write("a", "22");
  files.Watch({dir_ + "/a", dir_ + "/b"});
  EXPECT_TRUE(ChangedAndStill(files));
}

// Runs the loop; `look` is called at each wait and says whether to end. Time does not pass.
class ScriptedLoop {
 public:
  std::function<void(const CancelToken&)> work = [](const CancelToken&) {};
  std::function<bool()> look = [] { return false; };

  bool Run(bool again, WatchedFiles& files) {
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(60);
    return RunWatchLoop({.work =
                             [this](const CancelToken& cancel) {
                               ++begun;
                               work(cancel);
                               ++done;
                             },
                         .wait =
                             [&](milliseconds) {
                               EXPECT_LT(std::chrono::steady_clock::now(), deadline);
                               std::this_thread::yield();
                               return look() || std::chrono::steady_clock::now() > deadline;
                             },
                         .again = again},
                        files);
  }

  std::atomic<int> begun = 0, done = 0;
};

TEST_F(WatchLoopTest, WorkIsDoneAgainAfterEachSaveUntilTheUserEndsIt) {
  Write("a", "");
  WatchedFiles files;
  files.Watch({dir_ + "/a"});
  ScriptedLoop loop;
  std::string text;
  loop.look = [&] {
    if (loop.done == 4) return true;
    // A save each time that all saves are answered.
    if (loop.done == static_cast<int>(text.size()) + 1) Write("a", text += "x");
    return false;
  };
  EXPECT_TRUE(loop.Run(/*again=*/true, files));
  EXPECT_EQ(loop.begun, 4);
  EXPECT_EQ(text, "xxx");
}

TEST_F(WatchLoopTest, ASaveDuringTheWorkCancelsItAndBeginsAnew) {
  Write("a", "");
  WatchedFiles files;
  files.Watch({dir_ + "/a"});
  ScriptedLoop loop;
  std::atomic<bool> saved = false, cancelled = false;
  loop.work = [&](const CancelToken& cancel) {
    if (loop.begun > 1) return;
    while (!cancel.cancelled()) std::this_thread::yield();
    cancelled = true;
  };
  loop.look = [&] {
    if (loop.begun == 1 && !saved.exchange(true)) Write("a", "x");
    return loop.done == 2;
  };
  EXPECT_TRUE(loop.Run(/*again=*/true, files));
  EXPECT_TRUE(cancelled);
  EXPECT_EQ(loop.begun, 2);
}

TEST_F(WatchLoopTest, WorkThatIsDoneOnceEndsTheLoopAndFollowsNoSave) {
  Write("a", "");
  WatchedFiles files;
  files.Watch({dir_ + "/a"});
  ScriptedLoop loop;
  loop.work = [&](const CancelToken&) { Write("a", "x"); };
  EXPECT_FALSE(loop.Run(/*again=*/false, files));
  EXPECT_EQ(loop.begun, 1);
}

TEST_F(WatchLoopTest, TheUsersEndCancelsTheWork) {
  WatchedFiles files;
  for (const bool again : {false, true}) {
    ScriptedLoop loop;
    loop.work = [](const CancelToken& cancel) {
      while (!cancel.cancelled()) std::this_thread::yield();
    };
    loop.look = [&] { return loop.begun == 1; };
    EXPECT_TRUE(loop.Run(again, files)) << again;
    EXPECT_EQ(loop.done, 1) << again;
  }
}

}  // namespace
}  // namespace parallax::client
