#include "common/base/system/log.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <thread>
#include <vector>

#include "common/base/names.h"
#include "common/base/system/file.h"
#include "common/base/system/log_capture.h"

namespace parallax {
namespace {

using ::testing::MatchesRegex;

class LogTest : public ::testing::Test {
 protected:
  void TearDown() override { InitLogging({}); }
  static std::string Captured(const auto& write) {
    ::testing::internal::CaptureStderr();
    write();
    return ::testing::internal::GetCapturedStderr();
  }
};

LogContext Job() {
  LogContext context;
  context.job = 42;
  context.attempt = (uint64_t{3} << 32) | 7;
  context.study = "baseline";
  context.variant = "wide";
  context.scene = 5;
  context.worker = "host-1";
  return context;
}

TEST_F(LogTest, TextLineCarriesProgramContextAndFields) {
  InitLogging({.program = "worker"});
  const std::string line = Captured([] {
    ScopedLogContext scope(Job());
    LogInfo("frame written", {{"rig", 3}, {"seconds", 1.25}, {"path", "a b"}, {"reused", false}});
  });
  EXPECT_THAT(line, MatchesRegex("....-..-..T..:..:......Z I worker: frame written job=42 "
                                 "attempt=12884901895 study=baseline variant=wide scene=5 "
                                 "worker=host-1 rig=3 seconds=1.25 path=\"a b\" reused=false\n"));
}

TEST_F(LogTest, ACaptureKeepsTheLastLinesOfItsAttemptAndOfNoOther) {
  InitLogging({.json = true, .level = LogLevel::kError, .program = "worker"});
  const LogContext job = Job();
  LogContext other = job;
  other.attempt = 8;
  std::string text;
  Captured([&] {
    const LogCapture capture(*job.attempt);
    LogInfo("of nobody");
    {
      ScopedLogContext scope(other);
      LogInfo("of another");
    }
    std::thread([&] {
      ScopedLogContext scope(job);
      for (int i = 0; i < 250; ++i) LogInfo("line", {{"i", i}});
      LogDebug("too fine");
      LogWarning("a\x1b[2J", {{"path", "b c"}});
    }).join();
    text = capture.Text();
  });
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 200);
  EXPECT_THAT(text.substr(0, text.find('\n')),
              MatchesRegex("....-..-..T..:..:......Z I line i=51"));
  EXPECT_THAT(text, testing::EndsWith("Z W a\\x1b[2J path=\"b c\"\n"));
  const LogCapture later(*job.attempt);
  EXPECT_EQ(later.Text(), "");
}

TEST_F(LogTest, NothingThatATerminalActsOnReachesALine) {
  const std::string evil = "a\x1b[2J\u202e\x9b" + std::string(1, '\0') + "\nb";
  for (const bool json : {false, true}) {
    InitLogging({.json = json, .program = "p"});
    const std::string line = Captured([&] {
      LogContext context;
      context.study = evil;
      ScopedLogContext scope(context);
      LogInfo("hello " + evil, {{"worker", evil}});
    });
    ASSERT_EQ(std::count(line.begin(), line.end(), '\n'), 1) << line;
    EXPECT_TRUE(IsPlainText(line.substr(0, line.size() - 1))) << Printable(line);
    if (json) {
      const auto object = nlohmann::json::parse(line);
      EXPECT_EQ(object["worker"], "a\x1b[2J\\u{202e}\\x9b" + std::string(1, '\0') + "\nb");
    }
  }
}

TEST_F(LogTest, LinesGoToTheFileThatIsNamed) {
  const std::string path =
      (std::filesystem::temp_directory_path() / ("log_test_" + std::to_string(getpid()))).string();
  EXPECT_EQ(Captured([&] {
              InitLogging({.program = "run", .file = path});
              LogInfo("first");
              InitLogging({.program = "run", .file = path});
              LogInfo("second");
            }),
            "");
  const auto text = ReadFile(path);
  std::filesystem::remove(path);
  ASSERT_TRUE(text.ok()) << text.status();
  EXPECT_THAT(*text, MatchesRegex(".* I run: first\n.* I run: second\n"));
  InitLogging({.file = "/proc/not/writable"});
  EXPECT_THAT(Captured([] { LogInfo("third"); }), MatchesRegex(".* I third\n"));
}

TEST_F(LogTest, JsonLineIsOneObjectWithTypes) {
  InitLogging({.json = true, .program = "worker"});
  const std::string line = Captured([] {
    ScopedLogContext scope(Job());
    LogError("line\nbreak \"quoted\" \x01 %v", {{"rig", 3},
                                                {"ok", true},
                                                {"rate", 0.5},
                                                {"bad", std::numeric_limits<double>::infinity()}});
  });
  EXPECT_EQ(std::count(line.begin(), line.end(), '\n'), 1);
  const auto json = nlohmann::json::parse(line);
  EXPECT_EQ(json["level"], "error");
  EXPECT_EQ(json["program"], "worker");
  EXPECT_EQ(json["message"], "line\nbreak \"quoted\" \x01 %v");
  EXPECT_EQ(json["job"], 42);
  EXPECT_EQ(json["attempt"], 12884901895u);
  EXPECT_EQ(json["scene"], 5);
  EXPECT_EQ(json["variant"], "wide");
  EXPECT_EQ(json["rig"], 3);
  EXPECT_EQ(json["ok"], true);
  EXPECT_EQ(json["rate"], 0.5);
  EXPECT_EQ(json["bad"], "inf");
}

TEST_F(LogTest, InnerContextAddsToTheOuterAndEndsWithItsScope) {
  InitLogging({});
  const std::string lines = Captured([] {
    LogContext outer;
    outer.worker = "w";
    ScopedLogContext outer_scope(outer);
    {
      LogContext inner;
      inner.job = 1;
      ScopedLogContext inner_scope(inner);
      LogInfo("a");
    }
    LogInfo("b");
  });
  EXPECT_THAT(lines, MatchesRegex(".* a job=1 worker=w\n.* b worker=w\n"));
}

TEST_F(LogTest, ContextBelongsToItsThreadAndCanBeHandedOn) {
  InitLogging({});
  const std::string lines = Captured([] {
    LogContext context;
    context.job = 9;
    ScopedLogContext scope(context);
    const LogContext here = CurrentLogContext();
    std::thread([&] {
      LogInfo("bare");
      ScopedLogContext handed(here);
      LogInfo("handed");
    }).join();
  });
  EXPECT_THAT(lines, MatchesRegex(".* bare\n.* handed job=9\n"));
}

TEST_F(LogTest, LinesBelowTheLevelAreDropped) {
  InitLogging({.level = *ParseLogLevel("warning")});
  EXPECT_EQ(Captured([] { LogInfo("no"); }), "");
  EXPECT_THAT(Captured([] { LogWarning("yes"); }), MatchesRegex(".* W yes\n"));
  EXPECT_FALSE(ParseLogLevel("loud").ok());
}

TEST_F(LogTest, LinesOfManyThreadsStayWhole) {
  InitLogging({.json = true});
  const std::string lines = Captured([] {
    std::vector<std::thread> threads;
    for (int t = 0; t < 4; ++t) {
      threads.emplace_back([t] {
        for (int i = 0; i < 50; ++i) LogInfo("line", {{"t", t}, {"i", i}});
      });
    }
    for (std::thread& thread : threads) thread.join();
  });
  std::istringstream in(lines);
  int count = 0;
  for (std::string line; std::getline(in, line); ++count) {
    EXPECT_TRUE(nlohmann::json::accept(line)) << line;
  }
  EXPECT_EQ(count, 200);
}

}  // namespace
}  // namespace parallax
