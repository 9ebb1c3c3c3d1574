#include "coordinator/rpc/validation.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <limits>

#include "common/base/names.h"
#include "common/base/version.h"

namespace parallax {
namespace {

v1::Hello GoodHello() {
  v1::Hello hello;
  hello.set_name("host-1.example-42");
  hello.add_kinds("solve");
  hello.set_protocol(kWorkProtocol);
  hello.set_slots(4);
  hello.set_cores(8);
  hello.set_memory_mb(32000);
  hello.add_tags("avx512");
  hello.add_tags("trainer:raft-stereo");
  return hello;
}

const StageVersions kOurs = {.layout = "5", .scene = "6", .frame = "7"};

v1::Hello HelloOf(const StageVersions& versions) {
  v1::Hello hello = GoodHello();
  hello.add_kinds("render");
  hello.set_build_id("generator-x");
  (*hello.mutable_stage_versions())["layout"] = versions.layout;
  (*hello.mutable_stage_versions())["scene"] = versions.scene;
  (*hello.mutable_stage_versions())["frame"] = versions.frame;
  hello.add_holding()->set_job_id(1);
  return hello;
}

TEST(Validation, AWorkerGetsTheKindsOfJobsWhoseStagesHaveOurVersions) {
  const struct {
    const char* what;
    StageVersions theirs;
    std::vector<std::string> kinds;
    std::string note;
  } cases[] = {
      {"all alike", kOurs, {"solve", "render"}, ""},
      {"another frame", {"5", "6", "8"}, {"solve"}, "no render jobs: its stage frame"},
      {"another scene", {"5", "8", "7"}, {"render"}, "no solve jobs: its stage scene"},
      {"another layout", {"8", "6", "7"}, {"render"}, "no solve jobs: its stage layout"},
  };
  for (const auto& row : cases) {
    SCOPED_TRACE(row.what);
    v1::Hello hello = HelloOf(row.theirs);
    const auto notes = DropKindsOfOtherVersions(kOurs, KindRegistry::Builtin(), hello);
    ASSERT_TRUE(notes.ok()) << notes.status();
    EXPECT_THAT(hello.kinds(), testing::ElementsAreArray(row.kinds));
    EXPECT_EQ(hello.holding_size(), row.note.empty() ? 1 : 0);
    ASSERT_EQ(notes->size(), row.note.empty() ? 0u : 1u);
    if (row.note.empty()) continue;
    EXPECT_THAT(notes->front(), testing::HasSubstr(row.note));
  }
}

TEST(Validation, AWorkerThatCanDoNothingForUsIsRefusedInOneLine) {
  v1::Hello other = HelloOf({"4", "6", "8"});
  v1::Hello old = GoodHello();  // A release before stages had versions.
  old.set_build_id("generator-17");
  for (v1::Hello* hello : {&other, &old}) {
    const auto notes = DropKindsOfOtherVersions(kOurs, KindRegistry::Builtin(), *hello);
    EXPECT_EQ(notes.status().code(), absl::StatusCode::kFailedPrecondition);
    const std::string line(notes.status().message());
    EXPECT_THAT(line, testing::HasSubstr("its stage layout has version"));
    EXPECT_THAT(line, testing::HasSubstr("give both the same release"));
    EXPECT_EQ(line.find('\n'), std::string::npos);
  }
}

TEST(Validation, ASimulatorMakesNoDataAndNeedsNoVersions) {
  v1::Hello hello = GoodHello();
  hello.set_build_id("a simulator");
  EXPECT_TRUE(DropKindsOfOtherVersions(kOurs, KindRegistry::Builtin(), hello).ok());
  EXPECT_EQ(hello.kinds_size(), 1);
}

TEST(Validation, AHelloNamesItsWorkerAndStaysWithinBounds) {
  EXPECT_TRUE(CheckHello(GoodHello(), KindRegistry::Builtin()).ok())
      << CheckHello(GoodHello(), KindRegistry::Builtin());
  const struct {
    const char* what;
    std::function<void(v1::Hello&)> spoil;
  } cases[] = {
      {"name", [](v1::Hello& hello) { hello.set_name(""); }},
      {"name", [](v1::Hello& hello) { hello.set_name("../etc"); }},
      {"name", [](v1::Hello& hello) { hello.set_name(std::string(101, 'x')); }},
      {"kinds", [](v1::Hello& hello) { hello.clear_kinds(); }},
      {"kind", [](v1::Hello& hello) { hello.add_kinds("bake"); }},
      {"kinds",
       [](v1::Hello& hello) {
         for (int i = 0; i < 100; ++i) hello.add_kinds("solve");
       }},
      {"slots", [](v1::Hello& hello) { hello.set_slots(0); }},
      {"slots", [](v1::Hello& hello) { hello.set_slots(100'000); }},
      {"memory_mb", [](v1::Hello& hello) { hello.set_memory_mb(-1); }},
      {"tag", [](v1::Hello& hello) { hello.add_tags("a\nb"); }},
      {"tag", [](v1::Hello& hello) { hello.add_tags(":a"); }},
      {"tag", [](v1::Hello& hello) { hello.add_tags("a:"); }},
      {"tag", [](v1::Hello& hello) { hello.add_tags("a:b:c"); }},
      {"tags",
       [](v1::Hello& hello) {
         for (int i = 0; i < 100; ++i) hello.add_tags("t");
       }},
      {"stage_versions",
       [](v1::Hello& hello) {
         for (int i = 0; i < 100; ++i) {
           (*hello.mutable_stage_versions())["s" + std::to_string(i)] = "1";
         }
       }},
      {"version", [](v1::Hello& hello) { hello.set_version(std::string(1000, 'v')); }},
      {"attempt", [](v1::Hello& hello) { hello.add_holding(); }},
  };
  for (const auto& row : cases) {
    v1::Hello hello = GoodHello();
    row.spoil(hello);
    const absl::Status status = CheckHello(hello, KindRegistry::Builtin());
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument) << row.what;
    EXPECT_NE(status.ToString().find(row.what), std::string::npos) << status;
  }
}

TEST(Validation, ProgressIsAFractionOfANamedAttempt) {
  v1::Heartbeat heartbeat;
  EXPECT_TRUE(CheckHeartbeat(heartbeat).ok());
  v1::Progress& progress = *heartbeat.add_running();
  EXPECT_FALSE(CheckHeartbeat(heartbeat).ok()) << "no attempt";
  progress.mutable_attempt()->set_job_id(1);
  progress.mutable_attempt()->set_fence(1);
  EXPECT_TRUE(CheckHeartbeat(heartbeat).ok());
  for (double bad : {-0.1, 1.1, std::numeric_limits<double>::quiet_NaN()}) {
    progress.set_fraction(bad);
    EXPECT_FALSE(CheckHeartbeat(heartbeat).ok()) << bad;
  }
}

TEST(Validation, ProgressTellsAtMostEightFigures) {
  v1::Heartbeat heartbeat;
  v1::Progress& progress = *heartbeat.add_running();
  progress.mutable_attempt()->set_job_id(1);
  progress.mutable_attempt()->set_fence(1);
  auto& figures = *progress.mutable_figures();
  for (int i = 0; i < 8; ++i) figures["figure" + std::to_string(i)] = i;
  // A loss that is not finite ends the training, and not the stream.
  figures["figure7"] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(CheckHeartbeat(heartbeat).ok()) << CheckHeartbeat(heartbeat);
  figures["figure8"] = 8;
  EXPECT_FALSE(CheckHeartbeat(heartbeat).ok());
  figures.clear();
  figures["a\nb"] = 1;
  EXPECT_FALSE(CheckHeartbeat(heartbeat).ok());
}

TEST(Validation, ReportsNameAttemptWorkerAndResult) {
  v1::CompleteRequest complete;
  complete.set_worker("w");
  complete.mutable_attempt()->set_job_id(1);
  complete.mutable_attempt()->set_fence(1);
  EXPECT_FALSE(CheckComplete(complete).ok()) << "no result";
  complete.set_kind("solve");
  EXPECT_TRUE(CheckComplete(complete).ok()) << CheckComplete(complete);
  complete.set_wall_s(-1);
  EXPECT_FALSE(CheckComplete(complete).ok());

  v1::FailRequest fail;
  fail.set_worker("w");
  *fail.mutable_attempt() = complete.attempt();
  EXPECT_TRUE(CheckFail(fail).ok());
  fail.set_worker("a b");
  EXPECT_FALSE(CheckFail(fail).ok());
}

TEST(Validation, AFailureIsKeptInAPrintableFormRatherThanRefused) {
  v1::FailRequest fail;
  fail.set_worker("w");
  fail.mutable_attempt()->set_job_id(1);
  fail.mutable_attempt()->set_fence(1);
  fail.set_error("bad\x1b[31m\n" + std::string(100'000, 'x'));
  fail.set_fingerprint(std::string(100'000, '\x1b'));
  EXPECT_TRUE(CheckFail(fail).ok()) << CheckFail(fail);
  const v1::FailRequest clean = CleanFail(fail);
  EXPECT_EQ(clean.error().substr(0, 17), "bad\\x1b[31m\\nxxxx");
  EXPECT_LE(clean.error().size(), kMaxErrorBytes);
  EXPECT_LE(clean.fingerprint().size(), kMaxErrorBytes);
  EXPECT_TRUE(IsPlainText(clean.error()));
  EXPECT_EQ(clean.worker(), "w");
}

TEST(Validation, CreditAndLimitsAreBounded) {
  v1::Credit credit;
  EXPECT_FALSE(CheckCredit(credit).ok());
  credit.set_jobs(1);
  EXPECT_TRUE(CheckCredit(credit).ok());
  credit.set_jobs(1 << 30);
  EXPECT_FALSE(CheckCredit(credit).ok());
  EXPECT_TRUE(CheckLimit(0, 10).ok());
  EXPECT_TRUE(CheckLimit(10, 10).ok());
  EXPECT_FALSE(CheckLimit(11, 10).ok());
  EXPECT_FALSE(CheckLimit(-1, 10).ok());
  EXPECT_FALSE(CheckStudyId(0).ok());
}

}  // namespace
}  // namespace parallax
