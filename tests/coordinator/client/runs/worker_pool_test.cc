#include "coordinator/client/runs/worker_pool.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <fstream>
#include <functional>
#include <sstream>
#include <thread>

#include "tests/folder_test.h"

namespace parallax::client {
namespace {

using ::testing::HasSubstr;

// Time that passes only when told: back-off without waiting.
class ManualClock : public Clock {
 public:
  double UnixSeconds() override { return 0; }
  SteadyTime Steady() override {
    return SteadyTime(std::chrono::duration_cast<SteadyTime::duration>(
        std::chrono::duration<double>(now_s.load())));
  }
  std::atomic<double> now_s{1000};
};

class WorkerPoolTest : public FolderTest {
 protected:
  // Workers are shell scripts.
  WorkerPoolOptions Options(const std::string& script, int workers = 1) {
    WorkerPoolOptions options;
    options.binary = "/bin/sh";
    options.arguments = [script](int index) -> std::vector<std::string> {
      return {"-c", script, "worker", std::to_string(index)};
    };
    options.workers = workers;
    options.log_dir = dir_ + "/logs";
    options.clock = &clock_;
    return options;
  }

  // Calls `step` until it is true; each test has its own limit of time, so this ends.
  static void Until(const std::function<bool()>& step) {
    while (!step()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }

  std::string Read(const std::string& path) {
    std::ifstream file(path);
    std::stringstream text;
    text << file.rdbuf();
    return text.str();
  }

  ManualClock clock_;
};

TEST_F(WorkerPoolTest, EachWorkerGetsItsArgumentsAndALog) {
  WorkerPool pool(Options("echo I am $1; sleep 100", 2));
  ASSERT_TRUE(pool.Start().ok());
  EXPECT_EQ(pool.running(), 2);
  Until([&] { return Read(dir_ + "/logs/worker-1.log") == "I am 1\n"; });
  Until([&] { return Read(dir_ + "/logs/worker-0.log") == "I am 0\n"; });
}

TEST_F(WorkerPoolTest, AKilledWorkerComesBackAfterAPause) {
  WorkerPool pool(Options("sleep 100"));
  ASSERT_TRUE(pool.Start().ok());
  const pid_t first = pool.pids().at(0);
  kill(first, SIGKILL);
  Until([&] { return pool.Poll(0).ok() && pool.running() == 0; });
  EXPECT_EQ(pool.crashes(), 1);
  ASSERT_TRUE(pool.Poll(0).ok());
  EXPECT_EQ(pool.running(), 0) << "the pause is not over";
  clock_.now_s = clock_.now_s + 10;
  ASSERT_TRUE(pool.Poll(0).ok());
  EXPECT_EQ(pool.running(), 1);
  EXPECT_NE(pool.pids().at(0), first);
}

TEST_F(WorkerPoolTest, ACrashLoopEndsWithTheLogsTail) {
  WorkerPoolOptions options = Options("echo the reason; exit 7");
  options.most_crashes = 3;
  WorkerPool pool(options);
  ASSERT_TRUE(pool.Start().ok());
  absl::Status status;
  Until([&] {
    clock_.now_s = clock_.now_s + 10;
    status = pool.Poll(0);
    return !status.ok();
  });
  EXPECT_EQ(pool.crashes(), 3);
  EXPECT_THAT(std::string(status.message()), HasSubstr("3 times without a result"));
  EXPECT_THAT(std::string(status.message()), HasSubstr("exit status 7"));
  EXPECT_THAT(std::string(status.message()), HasSubstr("| the reason"));
}

TEST_F(WorkerPoolTest, ResultsBetweenCrashesEndTheRow) {
  WorkerPoolOptions options = Options("exit 7");
  options.most_crashes = 3;
  WorkerPool pool(options);
  ASSERT_TRUE(pool.Start().ok());
  int64_t results = 0;
  Until([&] {
    clock_.now_s = clock_.now_s + 10;
    EXPECT_TRUE(pool.Poll(++results).ok());
    return pool.crashes() >= 6;
  });
}

TEST_F(WorkerPoolTest, AWorkerThatRefusesItsArgumentsIsHopelessAtOnce) {
  WorkerPool pool(Options("echo unknown option; exit 2"));
  ASSERT_TRUE(pool.Start().ok());
  absl::Status status;
  Until([&] { return !(status = pool.Poll(0)).ok(); });
  EXPECT_THAT(std::string(status.message()), HasSubstr("can't start"));
  EXPECT_THAT(std::string(status.message()), HasSubstr("unknown option"));
}

TEST_F(WorkerPoolTest, AMissingProgramIsNamed) {
  WorkerPoolOptions options = Options("");
  options.binary = dir_ + "/nothing";
  const absl::Status status = WorkerPool(options).Start();
  EXPECT_TRUE(absl::IsNotFound(status));
  EXPECT_THAT(std::string(status.message()), HasSubstr(dir_ + "/nothing"));
}

TEST_F(WorkerPoolTest, DrainLetsWorkersFinish) {
  WorkerPool pool(
      Options("trap 'echo finished; exit 0' TERM; echo ready; while true; do sleep 0.01; done"));
  ASSERT_TRUE(pool.Start().ok());
  Until([&] { return Read(dir_ + "/logs/worker-0.log") == "ready\n"; });
  pool.Drain(1e9, [] { return false; });
  EXPECT_EQ(pool.running(), 0);
  EXPECT_EQ(Read(dir_ + "/logs/worker-0.log"), "ready\nfinished\n");
  EXPECT_GT(pool.cpu_seconds(), 0);
}

TEST_F(WorkerPoolTest, HurryIsASecondSignalAndThenDeath) {
  WorkerPool pool(Options("trap 'echo told' TERM; echo ready; while true; do sleep 0.01; done"));
  ASSERT_TRUE(pool.Start().ok());
  Until([&] { return Read(dir_ + "/logs/worker-0.log") == "ready\n"; });
  // Waits for the first signal's effect, hurries, and then lets the last grace pass.
  pool.Drain(1e9, [&] {
    const std::string log = Read(dir_ + "/logs/worker-0.log");
    if (log == "ready\n") return false;
    std::thread([this] {
      while (Read(dir_ + "/logs/worker-0.log") != "ready\ntold\ntold\n") {
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
      }
      clock_.now_s = clock_.now_s + 100;
    }).detach();
    return true;
  });
  EXPECT_EQ(pool.running(), 0);
  EXPECT_EQ(Read(dir_ + "/logs/worker-0.log"), "ready\ntold\ntold\n");
}

TEST_F(WorkerPoolTest, ThePoolTakesItsWorkersAlong) {
  pid_t pid = 0;
  {
    WorkerPool pool(Options("trap '' TERM; echo ready; while true; do sleep 0.01; done"));
    ASSERT_TRUE(pool.Start().ok());
    pid = pool.pids().at(0);
  }
  EXPECT_NE(kill(pid, 0), 0);
}

TEST_F(WorkerPoolTest, CtrlCAtTheTerminalIsNotForWorkers) {
  WorkerPool pool(Options("sleep 100"));
  ASSERT_TRUE(pool.Start().ok());
  const pid_t pid = pool.pids().at(0);
  // The child makes the group itself, a moment after the fork.
  Until([&] { return getpgid(pid) == pid; });
  EXPECT_NE(getpgid(pid), getpgrp());
}

}  // namespace
}  // namespace parallax::client
