#include "common/base/system/child_process.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <thread>

#include "common/base/system/file.h"
#include "tests/folder_test.h"

namespace parallax {
namespace {

using testing::HasSubstr;

// Starts a shell in the background, writes its number to "pid", and waits.
constexpr char kWithGrandchild[] = "sleep 300 & echo $! >pid.new; mv pid.new pid; wait";

class ChildProcessTest : public FolderTest {
 protected:
  ChildOptions Shell(const std::string& line) const {
    return {.command = {"sh", "-c", line}, .directory = dir_, .log = dir_ + "/log"};
  }
  static bool Within10s(const std::function<bool()>& condition) {
    for (int i = 0; i < 1000 && !condition(); ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    return condition();
  }
  int EndOf(ChildProcess& child) const {
    EXPECT_TRUE(Within10s([&] { return child.Poll().has_value(); }));
    return child.Poll().value_or(-1);
  }
  std::string Log() const { return ReadFile(dir_ + "/log").value_or(""); }
  // The grandchild, once there is one.
  pid_t Grandchild() const {
    EXPECT_TRUE(Within10s([&] { return std::filesystem::exists(dir_ + "/pid"); }));
    return std::stoi(ReadFile(dir_ + "/pid").value_or("0"));
  }
  // Gone, or waiting for its new parent to take its status.
  static bool IsGone(pid_t pid) {
    const std::string stat = ReadFile("/proc/" + std::to_string(pid) + "/stat").value_or("");
    return stat.empty() || stat.find(") Z") != std::string::npos;
  }
};

TEST_F(ChildProcessTest, GivesExitStatusOutputEnvironmentAndFolder) {
  ChildOptions options = Shell("echo $A; pwd; exit 3");
  options.environment = {"A=set"};
  auto child = ChildProcess::Start(options);
  ASSERT_TRUE(child.ok()) << child.status();
  EXPECT_EQ(DescribeExit(EndOf(**child)), "exit status 3");
  EXPECT_EQ(Log(), "set\n" + dir_ + "\n");
}

TEST_F(ChildProcessTest, TellsTheSignalThatEndedTheProgram) {
  auto child = ChildProcess::Start(Shell("kill -KILL $$"));
  EXPECT_EQ(DescribeExit(EndOf(**child)), "killed by signal 9 (Killed)");
}

TEST_F(ChildProcessTest, SaysWhatCannotBeRun) {
  auto child = ChildProcess::Start({.command = {"/no/such/program"}, .log = dir_ + "/log"});
  ASSERT_TRUE(child.ok());
  EXPECT_EQ(WEXITSTATUS(EndOf(**child)), 127);
  EXPECT_THAT(Log(), HasSubstr("can't run the program /no/such/program"));
}

TEST_F(ChildProcessTest, TerminateLetsTheProgramFinish) {
  auto child = ChildProcess::Start(
      Shell("trap 'echo bye; exit 5' TERM; touch pid; while :; do sleep 0.05; done"));
  ASSERT_TRUE(Within10s([&] { return std::filesystem::exists(dir_ + "/pid"); }));
  (*child)->Terminate();
  EXPECT_EQ(DescribeExit(EndOf(**child)), "exit status 5");
  // A shell may tell first that its `sleep` was terminated, which got the signal as well.
  EXPECT_THAT(Log(), testing::EndsWith("bye\n"));
}

TEST_F(ChildProcessTest, KillTakesItsChildrenAlong) {
  auto child = ChildProcess::Start(Shell(kWithGrandchild));
  const pid_t grandchild = Grandchild();
  (*child)->Kill();
  EXPECT_TRUE(Within10s([&] { return IsGone(grandchild); }));
}

TEST_F(ChildProcessTest, NothingSurvivesWhoeverKillsUs) {
  const pid_t owner = fork();
  if (owner == 0) {
    auto child = ChildProcess::Start(Shell(kWithGrandchild));
    while (true) pause();
  }
  const pid_t grandchild = Grandchild();
  ASSERT_FALSE(IsGone(grandchild));
  kill(owner, SIGKILL);
  waitpid(owner, nullptr, 0);
  EXPECT_TRUE(Within10s([&] { return IsGone(grandchild); }));
}

}  // namespace
}  // namespace parallax
