#include "worker/agent/attempts/job_slots.h"

#include <gtest/gtest.h>

#include <condition_variable>
#include <filesystem>
#include <fstream>
#include <mutex>

#include "common/base/status.h"
#include "common/base/system/log.h"
#include "tests/folder_test.h"
#include "tests/worker/agent/attempts/scripted_store.h"
#include "worker/agent/attempts/failure.h"
#include "worker/agent/attempts/running.h"

namespace parallax {
namespace {

namespace fs = std::filesystem;

// Leaves a file, tells figures and ends as it is told.
class LongJob final : public JobHandler {
 public:
  explicit LongJob(bool resumes) : JobHandler("long", /*writes_output=*/true, resumes) {}
  absl::StatusOr<JobOutcome> Run(std::string_view spec, const AttemptFolder& folder,
                                 const CancelToken&, const JobProgressFn& progress) override {
    for (const std::string& dir : {folder.dir, folder.scratch}) {
      fs::create_directories(dir);
      std::ofstream(dir + "/checkpoint") << "weights";
    }
    progress(0.5, "train", {{"loss", 0.25}, {"step", 7}});
    if (spec == "program") {
      std::ofstream(folder.scratch + "/log.txt") << std::string(9000, 'x') << "\nstep 7\rstep 8\n";
      progress.FollowLog(folder.scratch + "/log.txt");
    }
    at_work(folder);
    if (spec == "log") {
      for (int i = 0; i < 300; ++i) LogInfo("at work", {{"step", i}});
      return Internal("lost");
    }
    if (spec == "fail") return WithLogTail(Internal("lost"), "first\nlast\n");
    return JobOutcome{"result", {}, /*children_cpu_s=*/1000};
  }
  std::function<void(const AttemptFolder&)> at_work = [](const AttemptFolder&) {};
};

class JobSlotsTest : public FolderTest {
 protected:
  // The report of one job.
  Report Do(bool resumes, const std::string& spec) {
    JobHandlers handlers;
    handlers.push_back(std::make_unique<LongJob>(resumes));
    auto& job = static_cast<LongJob&>(*handlers[0]);
    Report report;
    bool ended = false;
    std::mutex mu;
    std::condition_variable changed;
    JobSlots slots(
        1, "worker-1", handlers, Clock::System(), [&](Report one) { report = std::move(one); },
        [&] {
          std::lock_guard lock(mu);
          ended = true;
          changed.notify_all();
        });
    job.at_work = [&](const AttemptFolder&) {
      seen_ = slots.Running().at(0);
      live_log_ = ProgressOf({seen_}, {}).at(0).log_tail();
    };
    v1::Lease lease;
    lease.mutable_attempt()->set_job_id(1);
    lease.mutable_attempt()->set_fence(2);
    lease.set_kind("long");
    lease.set_spec(spec);
    EXPECT_TRUE(slots.Start(lease,
                            {.dir = dir_ + "/store/.attempt-2",
                             .path = ".attempt-2",
                             .store = store_,
                             .scratch = dir_ + "/work"},
                            "c"));
    std::unique_lock lock(mu);
    EXPECT_TRUE(changed.wait_for(lock, std::chrono::seconds(10), [&] { return ended; }));
    return report;
  }
  bool Exists(const std::string& path) const { return fs::exists(dir_ + "/" + path); }

  std::shared_ptr<Store> store_;
  RunningAttempt seen_;
  std::string live_log_;  // A heartbeat at that moment has it.
};

TEST_F(JobSlotsTest, HeartbeatsCarryTheEndOfTheLogOfAJobThatRuns) {
  Do(false, "program");
  const std::string log = live_log_;
  EXPECT_LE(log.size(), 2048u);
  EXPECT_TRUE(log.ends_with("x\nstep 7\nstep 8")) << log;
  Do(false, "");
  EXPECT_EQ(live_log_.find("step"), std::string::npos) << "our own log: " << live_log_;
  EXPECT_NE(live_log_.find("job started"), std::string::npos) << live_log_;
}

TEST_F(JobSlotsTest, FiguresOfALongJobAreToldWhileItRuns) {
  Do(false, "");
  EXPECT_EQ(seen_.figures, (JobFigures{{"loss", 0.25}, {"step", 7}}));
  EXPECT_EQ(seen_.stage, "train");
}

TEST_F(JobSlotsTest, TimeOfProgramsThatAJobRanIsItsTime) {
  const Report report = Do(false, "");
  EXPECT_GE(std::get<v1::CompleteRequest>(report.body).cpu_s(), 1000);
  EXPECT_TRUE(Exists("store/.attempt-2/checkpoint"));
  EXPECT_FALSE(Exists("work"));
}

TEST_F(JobSlotsTest, FinishedWorkIsReportedUnlessTheStoreIsCertainlyGone) {
  const auto scripted = std::make_shared<ScriptedStore>();
  store_ = scripted;
  scripted->marker = Unavailable("no answer");
  EXPECT_EQ(std::get<v1::CompleteRequest>(Do(false, "").body).result(), "result");
  EXPECT_TRUE(Exists("store/.attempt-2/checkpoint"));
  for (const absl::Status& gone : {NotFound("no marker"), FailedPrecondition("another store")}) {
    scripted->marker = gone;
    EXPECT_EQ(std::get<v1::CompleteRequest>(Do(false, "").body).result(), "") << gone;
    EXPECT_FALSE(Exists("store/.attempt-2"));
  }
  scripted->marker = Unavailable("no answer");
  const Report report = Do(false, "fail");
  EXPECT_TRUE(std::holds_alternative<v1::CompleteRequest>(report.body)) << "none: handed back";
}

TEST_F(JobSlotsTest, OnlyKindsThatResumeKeepWhatAFailedAttemptLeft) {
  Do(false, "fail");
  EXPECT_FALSE(Exists("store/.attempt-2"));
  const Report report = Do(true, "fail");
  EXPECT_TRUE(Exists("store/.attempt-2/checkpoint"));
  EXPECT_FALSE(Exists("work"));
  const auto& fail = std::get<v1::FailRequest>(report.body);
  EXPECT_EQ(fail.log_tail(), "first\nlast");
  EXPECT_EQ(fail.error(), "INTERNAL: lost");
}

TEST_F(JobSlotsTest, AFailedAttemptTellsTheEndOfItsOwnLog) {
  testing::internal::CaptureStderr();
  const Report report = Do(true, "log");
  testing::internal::GetCapturedStderr();
  const std::string log = std::get<v1::FailRequest>(report.body).log_tail();
  EXPECT_LE(std::count(log.begin(), log.end(), '\n'), 200);
  EXPECT_EQ(log.find("step=98\n"), std::string::npos) << log.substr(0, 300);
  EXPECT_NE(log.find(" I at work step=150\n"), std::string::npos) << log.substr(0, 300);
  EXPECT_NE(log.find("step=299\n"), std::string::npos);
  EXPECT_NE(log.find(" W job failed "), std::string::npos) << "its last line";
}

}  // namespace
}  // namespace parallax
