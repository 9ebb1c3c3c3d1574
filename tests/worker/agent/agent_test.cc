#include "worker/agent/agent.h"

#include <gtest/gtest.h>
#include <stdlib.h>

#include <filesystem>
#include <fstream>
#include <thread>

#include "fake_coordinator.h"

namespace parallax {
namespace {

namespace fs = std::filesystem;
using Seen = FakeCoordinator::Seen;

// Set once, waited for by many.
class Gate {
 public:
  void Open() {
    std::lock_guard lock(mu_);
    open_ = true;
    changed_.notify_all();
  }
  bool Wait(std::chrono::duration<double> limit = std::chrono::seconds(20)) {
    std::unique_lock lock(mu_);
    return changed_.wait_for(lock, limit, [this] { return open_; });
  }

 private:
  std::mutex mu_;
  std::condition_variable changed_;
  bool open_ = false;
};

// Jobs do what the test says by seed; others succeed at once.
class ScriptedRunner final : public JobRunner {
 public:
  using Solver = std::function<absl::StatusOr<v1::SolveResult>(const CancelToken&)>;

  void On(uint64_t seed, Solver solver) { solvers_[seed] = std::move(solver); }
  // Starts (opens `started`), then ends when `finish` opens or when cancelled (opens `cancelled`).
  void Hold(uint64_t seed, Gate& started, Gate& finish, Gate& cancelled) {
    On(seed, [&](const CancelToken& cancel) -> absl::StatusOr<v1::SolveResult> {
      started.Open();
      while (!finish.Wait(std::chrono::milliseconds(1))) {
        if (!cancel.cancelled()) continue;
        cancelled.Open();
        return absl::CancelledError("told to");
      }
      return v1::SolveResult();
    });
  }

  absl::StatusOr<v1::SolveResult> Solve(const v1::SolveJob& job, const CancelToken& cancel,
                                        const JobProgressFn& progress) override {
    progress(0.5, "anneal");
    const auto solver = solvers_.find(job.scene_seed());
    return solver == solvers_.end() ? v1::SolveResult() : solver->second(cancel);
  }
  absl::StatusOr<v1::RenderResult> Render(const v1::RenderJob& job, const AttemptFolder& folder,
                                          const CancelToken&, const JobProgressFn&) override {
    fs::create_directories(folder.dir);
    std::ofstream(folder.dir + "/left.png") << "pixels";
    if (job.rigs_size() == 0) return absl::ResourceExhaustedError("disk of 80 GB is full");
    v1::RenderResult result;
    result.add_frames()->set_path(folder.path + "/000");
    return result;
  }

 private:
  std::map<uint64_t, Solver> solvers_;
};

v1::Lease SolveLease(int64_t job, uint64_t fence, uint64_t seed) {
  v1::Lease lease;
  lease.mutable_attempt()->set_job_id(job);
  lease.mutable_attempt()->set_fence(fence);
  lease.set_kind(v1::JOB_KIND_SOLVE);
  lease.set_attempt_number(1);
  lease.mutable_solve()->set_scene_seed(seed);
  return lease;
}

v1::Lease RenderLease(int64_t job, uint64_t fence, std::vector<uint32_t> rigs) {
  v1::Lease lease;
  lease.mutable_attempt()->set_job_id(job);
  lease.mutable_attempt()->set_fence(fence);
  lease.set_kind(v1::JOB_KIND_RENDER);
  lease.mutable_render()->set_store_prefix("renders/ab12");
  for (uint32_t rig : rigs) lease.mutable_render()->add_rigs(rig);
  return lease;
}

class AgentTest : public testing::Test {
 protected:
  AgentTest()
      : directory_(MakeDirectory()),
        coordinator_(*ParseRpcAddress("unix:" + directory_ + "/coordinator.sock")) {
    options_.coordinator = *ParseRpcAddress("unix:" + directory_ + "/coordinator.sock");
    options_.name = "worker-1";
    options_.kinds = {v1::JOB_KIND_SOLVE, v1::JOB_KIND_RENDER};
    options_.slots = 2;
    options_.outbox_root = directory_ + "/outbox";
    options_.hand_back_s = 0.2;
    options_.backoff_base_s = 0.01;
    options_.backoff_cap_s = 0.05;
    options_.reports.backoff_base_s = 0.01;
    options_.reports.backoff_cap_s = 0.05;
    coordinator_.Change([this](auto& how) { how.store_uri = "file://" + directory_ + "/store"; });
    coordinator_.Start();
  }
  ~AgentTest() override {
    StopAgent();
    coordinator_.Stop();
    fs::remove_all(directory_);
  }

  static std::string MakeDirectory() {
    char name[] = "/tmp/parallax-agent-XXXXXX";
    return mkdtemp(name);
  }

  void StartAgent() {
    auto agent = Agent::Create(options_, runner_, Clock::System());
    ASSERT_TRUE(agent.ok()) << agent.status();
    agent_ = *std::move(agent);
    thread_ = std::thread([this] { summary_ = agent_->Run(); });
  }
  // Waits for Run().
  void JoinAgent() {
    if (thread_.joinable()) thread_.join();
  }
  void StopAgent() {
    if (agent_ != nullptr) agent_->HandBack();
    JoinAgent();
    agent_.reset();
  }
  int ReportsOnDisk() {
    int count = 0;
    std::error_code error;  // Files vanish while we look.
    for (fs::recursive_directory_iterator it(options_.outbox_root, error), end; it != end && !error;
         it.increment(error)) {
      const std::string extension = it->path().extension().string();
      count += extension == ".complete" || extension == ".fail";
    }
    return count;
  }

  bool WaitForEmptyOutbox() {
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(20);
    while (ReportsOnDisk() > 0) {
      if (std::chrono::steady_clock::now() > deadline) return false;
      std::this_thread::yield();
    }
    return true;
  }

  const std::string directory_;
  FakeCoordinator coordinator_;
  Gate started_, finish_, cancelled_;  // Outlive the agent's jobs.
  ScriptedRunner runner_;
  AgentOptions options_;
  std::unique_ptr<Agent> agent_;
  std::thread thread_;
  absl::StatusOr<AgentSummary> summary_ = absl::UnknownError("Run() has not returned");
};

TEST_F(AgentTest, RunsWhatItLeasesAndReportsIt) {
  StartAgent();
  for (int job = 1; job <= 5; ++job) coordinator_.Offer(SolveLease(job, 100 + job, job));
  ASSERT_TRUE(coordinator_.WaitFor([](const Seen& seen) { return seen.completes.size() == 5; }));
  const v1::CompleteRequest complete = coordinator_.seen().completes[0];
  EXPECT_EQ(complete.worker(), "worker-1");
  EXPECT_EQ(complete.coordinator_id(), "database-1");
  EXPECT_EQ(complete.attempt().fence(), 100u + complete.attempt().job_id());
  EXPECT_TRUE(complete.has_solve());
  agent_->Drain();
  JoinAgent();
  ASSERT_TRUE(summary_.ok()) << summary_.status();
  EXPECT_EQ(summary_->succeeded, 5);
  EXPECT_EQ(summary_->reports_left, 0u);
  EXPECT_EQ(ReportsOnDisk(), 0);
}

TEST_F(AgentTest, TakesNoMoreJobsThanItHasSlots) {
  options_.ahead_s = 0;
  coordinator_.Change([](auto& how) { how.lease_s = 1; });
  runner_.Hold(1, started_, finish_, cancelled_);
  StartAgent();
  for (int job = 1; job <= 3; ++job) coordinator_.Offer(SolveLease(job, job, 1));
  ASSERT_TRUE(started_.Wait());
  ASSERT_TRUE(coordinator_.WaitFor([](const Seen& seen) { return !seen.heartbeats.empty(); }));
  EXPECT_EQ(coordinator_.seen().leases_sent, 2);
  finish_.Open();
  EXPECT_TRUE(coordinator_.WaitFor([](const Seen& seen) { return seen.completes.size() == 3; }));
}

TEST_F(AgentTest, LeasesTheNextJobBeforeTheOneAtHandEnds) {
  options_.slots = 1;
  options_.ahead_s = 60;  // The job is half done when it begins: it ends soon.
  runner_.Hold(1, started_, finish_, cancelled_);
  StartAgent();
  coordinator_.Offer(SolveLease(1, 11, 1));
  coordinator_.Offer(SolveLease(2, 12, 2));
  coordinator_.Offer(SolveLease(3, 13, 2));
  ASSERT_TRUE(coordinator_.WaitFor([](const Seen& seen) { return seen.leases_sent == 2; }));
  EXPECT_TRUE(coordinator_.seen().completes.empty());
  EXPECT_TRUE(started_.Wait());
  finish_.Open();
  EXPECT_TRUE(coordinator_.WaitFor([](const Seen& seen) { return seen.completes.size() == 3; }));
}

TEST_F(AgentTest, ADrainingWorkerHandsBackWhatWaitsAtOnce) {
  options_.slots = 1;
  options_.ahead_s = 60;
  runner_.Hold(1, started_, finish_, cancelled_);
  StartAgent();
  coordinator_.Offer(SolveLease(1, 11, 1));
  coordinator_.Offer(SolveLease(2, 12, 2));
  ASSERT_TRUE(coordinator_.WaitFor([](const Seen& seen) { return seen.leases_sent == 2; }));
  ASSERT_TRUE(started_.Wait());
  agent_->Drain();
  ASSERT_TRUE(coordinator_.WaitFor([](const Seen& seen) { return seen.hand_backs.size() == 1; }));
  EXPECT_EQ(coordinator_.seen().hand_backs[0].attempt().job_id(), 2);
  finish_.Open();
  JoinAgent();
  ASSERT_TRUE(summary_.ok()) << summary_.status();
  EXPECT_EQ(summary_->succeeded, 1);
}

TEST_F(AgentTest, AFailedJobIsReportedWithACauseThatHasNoNumbers) {
  StartAgent();
  coordinator_.Offer(RenderLease(7, 42, {}));
  ASSERT_TRUE(coordinator_.WaitFor([](const Seen& seen) { return seen.fails.size() == 1; }));
  const v1::FailRequest fail = coordinator_.seen().fails[0];
  EXPECT_EQ(fail.fingerprint(), "RESOURCE_EXHAUSTED@render: disk of # GB is full");
  EXPECT_TRUE(fail.retryable());
  EXPECT_FALSE(fs::exists(directory_ + "/store/renders/ab12/.attempt-42"))
      << "a failed attempt's files are never published";
}

TEST_F(AgentTest, ARenderWritesIntoItsAttemptsFolder) {
  StartAgent();
  coordinator_.Offer(RenderLease(7, 42, {0}));
  ASSERT_TRUE(coordinator_.WaitFor([](const Seen& seen) { return seen.completes.size() == 1; }));
  EXPECT_EQ(coordinator_.seen().completes[0].render().frames(0).path(),
            "renders/ab12/.attempt-42/000");
  EXPECT_TRUE(fs::exists(directory_ + "/store/renders/ab12/.attempt-42/left.png"));
}

TEST_F(AgentTest, AFolderOutsideTheStoreIsRefused) {
  StartAgent();
  v1::Lease lease = RenderLease(7, 42, {0});
  lease.mutable_render()->set_store_prefix("../elsewhere");
  coordinator_.Offer(lease);
  ASSERT_TRUE(coordinator_.WaitFor([](const Seen& seen) { return seen.fails.size() == 1; }));
  EXPECT_FALSE(fs::exists(directory_ + "/elsewhere"));
  EXPECT_FALSE(coordinator_.seen().fails[0].retryable());
}

TEST_F(AgentTest, AnExceptionFailsItsJobOnly) {
  runner_.On(1, [](const CancelToken&) -> absl::StatusOr<v1::SolveResult> {
    throw std::runtime_error("vertex 17 is odd");
  });
  StartAgent();
  coordinator_.Offer(SolveLease(1, 11, 1));
  coordinator_.Offer(SolveLease(2, 12, 2));
  ASSERT_TRUE(coordinator_.WaitFor(
      [](const Seen& seen) { return seen.fails.size() == 1 && seen.completes.size() == 1; }));
  EXPECT_NE(coordinator_.seen().fails[0].error().find("vertex 17 is odd"), std::string::npos);
}

TEST_F(AgentTest, ADroppedReplyIsAnsweredByRepeatingTheReport) {
  coordinator_.Change([](auto& how) { how.drop_replies = 2; });
  StartAgent();
  coordinator_.Offer(SolveLease(1, 11, 1));
  ASSERT_TRUE(coordinator_.WaitFor([](const Seen& seen) { return seen.completes.size() == 3; }));
  agent_->Drain();
  JoinAgent();
  EXPECT_EQ(coordinator_.seen().completes.size(), 3u) << "answered, so not sent again";
  EXPECT_EQ(ReportsOnDisk(), 0);
}

TEST_F(AgentTest, EveryDefinitiveAnswerEndsAReportAndNoOtherDoes) {
  const struct {
    v1::ReportOutcome outcome;
    grpc::StatusCode status;
    bool definitive;
  } cases[] = {
      {v1::REPORT_OUTCOME_OK, grpc::StatusCode::OK, true},
      {v1::REPORT_OUTCOME_ALREADY_DONE, grpc::StatusCode::OK, true},
      {v1::REPORT_OUTCOME_STALE_FENCE, grpc::StatusCode::OK, true},
      {v1::REPORT_OUTCOME_CANCELLED, grpc::StatusCode::OK, true},
      {v1::REPORT_OUTCOME_OK, grpc::StatusCode::INVALID_ARGUMENT, true},
      {v1::REPORT_OUTCOME_OK, grpc::StatusCode::INTERNAL, false},
      {v1::REPORT_OUTCOME_OK, grpc::StatusCode::RESOURCE_EXHAUSTED, false},
      {v1::REPORT_OUTCOME_OK, grpc::StatusCode::NOT_FOUND, false},
  };
  StartAgent();
  int64_t job = 0;
  for (const auto& row : cases) {
    coordinator_.Change([&](auto& how) {
      how.outcome = row.outcome;
      how.report_status = row.status;
    });
    const size_t before = coordinator_.seen().completes.size();
    ++job;
    coordinator_.Offer(SolveLease(job, 10 + job, job));
    const size_t wanted = before + (row.definitive ? 1 : 3);
    ASSERT_TRUE(coordinator_.WaitFor([&](const Seen& seen) {
      return seen.completes.size() >= wanted;
    })) << "case "
        << job;
    if (row.definitive) {
      ASSERT_TRUE(WaitForEmptyOutbox()) << "case " << job;
      EXPECT_EQ(coordinator_.seen().completes.size(), wanted) << "case " << job;
    }
    coordinator_.Change([](auto& how) { how.report_status = grpc::StatusCode::OK; });
    ASSERT_TRUE(WaitForEmptyOutbox()) << "case " << job;
  }
  agent_->Drain();
  JoinAgent();
  EXPECT_EQ(ReportsOnDisk(), 0);
}

TEST_F(AgentTest, TakesNoNewWorkWhileTooManyReportsWait) {
  options_.max_pending_reports = 3;
  coordinator_.Change([](auto& how) {
    how.lease_s = 0.5;  // A heartbeat each 125 ms.
    how.report_status = grpc::StatusCode::INTERNAL;
  });
  StartAgent();
  for (int job = 1; job <= 12; ++job) coordinator_.Offer(SolveLease(job, job, job));
  const int most = options_.slots + options_.max_pending_reports;
  // Two heartbeats with as many: no more came in between.
  ASSERT_TRUE(coordinator_.WaitFor([&](const Seen& seen) {
    return std::count_if(seen.heartbeats.begin(), seen.heartbeats.end(),
                         [&](const auto& beat) { return beat.running_size() >= most; }) >= 2;
  }));
  EXPECT_EQ(coordinator_.seen().leases_sent, most);
  coordinator_.Change([](auto& how) { how.report_status = grpc::StatusCode::OK; });
  ASSERT_TRUE(coordinator_.WaitFor([](const Seen& seen) { return seen.leases_sent == 12; }));
  EXPECT_TRUE(WaitForEmptyOutbox());
}

TEST_F(AgentTest, ReportsLeftByADeadWorkerAreSentBeforeNewWorkIsTaken) {
  options_.name = "worker-dead";
  coordinator_.Change([](auto& how) { how.report_status = grpc::StatusCode::INTERNAL; });
  StartAgent();
  coordinator_.Offer(SolveLease(1, 11, 1));
  ASSERT_TRUE(coordinator_.WaitFor([](const Seen& seen) { return !seen.completes.empty(); }));
  agent_->HandBack();
  JoinAgent();
  EXPECT_EQ(summary_->reports_left, 1u);
  agent_.reset();
  EXPECT_EQ(ReportsOnDisk(), 1);

  options_.name = "worker-2";
  const size_t before = coordinator_.seen().completes.size();
  coordinator_.Change([](auto& how) {
    how.report_status = grpc::StatusCode::OK;
    how.hold_reports = true;
    how.lease_s = 0.4;
  });
  coordinator_.Offer(SolveLease(2, 12, 2));
  StartAgent();
  const size_t beats = coordinator_.seen().heartbeats.size();
  ASSERT_TRUE(
      coordinator_.WaitFor([&](const Seen& seen) { return seen.heartbeats.size() >= beats + 2; }));
  EXPECT_EQ(coordinator_.seen().leases_sent, 1) << "no credit before the old report was tried";
  coordinator_.Change([](auto& how) { how.hold_reports = false; });
  ASSERT_TRUE(
      coordinator_.WaitFor([&](const Seen& seen) { return seen.completes.size() == before + 2; }));
  EXPECT_EQ(coordinator_.seen().completes[before].attempt().job_id(), 1) << "the old report first";
  EXPECT_EQ(coordinator_.seen().completes[before + 1].attempt().job_id(), 2);
}

TEST_F(AgentTest, AReportIsNeverSentToAnotherDatabase) {
  coordinator_.Change([](auto& how) { how.report_status = grpc::StatusCode::INTERNAL; });
  StartAgent();
  coordinator_.Offer(SolveLease(1, 11, 1));
  ASSERT_TRUE(coordinator_.WaitFor([](const Seen& seen) { return !seen.completes.empty(); }));
  StopAgent();
  const size_t before = coordinator_.seen().completes.size();
  coordinator_.Change([](auto& how) {
    how.id = "database-2";
    how.report_status = grpc::StatusCode::OK;
  });
  StartAgent();
  coordinator_.Offer(SolveLease(2, 12, 2));
  ASSERT_TRUE(
      coordinator_.WaitFor([&](const Seen& seen) { return seen.completes.size() == before + 1; }));
  EXPECT_EQ(coordinator_.seen().completes.back().attempt().job_id(), 2);
  EXPECT_EQ(coordinator_.seen().hellos.back().holding_size(), 0);
  StopAgent();
  EXPECT_EQ(ReportsOnDisk(), 1) << "kept for its own coordinator";
}

TEST_F(AgentTest, AStopOrderEndsTheAttemptWithoutAReport) {
  runner_.Hold(1, started_, finish_, cancelled_);
  StartAgent();
  const v1::Lease lease = SolveLease(1, 11, 1);
  coordinator_.Offer(lease);
  ASSERT_TRUE(started_.Wait());
  v1::AttemptId other = lease.attempt();
  other.set_fence(10);
  coordinator_.SendStop(other);  // Another attempt's fence: nothing happens.
  coordinator_.Offer(SolveLease(2, 12, 2));
  ASSERT_TRUE(coordinator_.WaitFor([](const Seen& seen) { return seen.completes.size() == 1; }));
  EXPECT_FALSE(cancelled_.Wait(std::chrono::seconds(0)));
  coordinator_.SendStop(lease.attempt());
  EXPECT_TRUE(cancelled_.Wait());
  agent_->Drain();
  JoinAgent();
  EXPECT_EQ(coordinator_.seen().fails.size(), 0u);
  EXPECT_EQ(coordinator_.seen().completes.size(), 1u);
  EXPECT_EQ(coordinator_.seen().hand_backs.size(), 0u);
}

TEST_F(AgentTest, RunningWorkIsAdoptedByARestartedCoordinator) {
  runner_.Hold(1, started_, finish_, cancelled_);
  StartAgent();
  coordinator_.Offer(SolveLease(1, 11, 1));
  ASSERT_TRUE(started_.Wait());
  coordinator_.Stop();
  coordinator_.Start();
  ASSERT_TRUE(coordinator_.WaitFor([](const Seen& seen) { return seen.hellos.size() == 2; }));
  ASSERT_EQ(coordinator_.seen().hellos[1].holding_size(), 1);
  EXPECT_EQ(coordinator_.seen().hellos[1].holding(0).fence(), 11u);
  finish_.Open();
  ASSERT_TRUE(coordinator_.WaitFor([](const Seen& seen) { return seen.completes.size() == 1; }));
  EXPECT_FALSE(cancelled_.Wait(std::chrono::seconds(0)));
}

TEST_F(AgentTest, WorkThatIsNotAdoptedStops) {
  runner_.Hold(1, started_, finish_, cancelled_);
  StartAgent();
  coordinator_.Offer(SolveLease(1, 11, 1));
  ASSERT_TRUE(started_.Wait());
  coordinator_.Stop();
  coordinator_.Change([](auto& how) { how.adopt = false; });
  coordinator_.Start();
  EXPECT_TRUE(cancelled_.Wait());
  agent_->Drain();
  JoinAgent();
  EXPECT_TRUE(coordinator_.seen().fails.empty());
}

TEST_F(AgentTest, WorkStopsWhenTheCoordinatorIsGoneForLongerThanTheLease) {
  coordinator_.Change([](auto& how) { how.lease_s = 0.4; });
  runner_.Hold(1, started_, finish_, cancelled_);
  StartAgent();
  coordinator_.Offer(SolveLease(1, 11, 1));
  ASSERT_TRUE(started_.Wait());
  // Answered heartbeats carry the work over several leases.
  ASSERT_TRUE(coordinator_.WaitFor([](const Seen& seen) { return seen.heartbeats.size() >= 12; }));
  EXPECT_FALSE(cancelled_.Wait(std::chrono::seconds(0)));
  coordinator_.Stop();
  EXPECT_TRUE(cancelled_.Wait());
}

TEST_F(AgentTest, WorkStopsWhenHeartbeatsAreNotAnsweredThoughTheStreamIsOpen) {
  coordinator_.Change([](auto& how) {
    how.lease_s = 0.4;
    how.answer_heartbeats = false;
  });
  runner_.Hold(1, started_, finish_, cancelled_);
  StartAgent();
  coordinator_.Offer(SolveLease(1, 11, 1));
  ASSERT_TRUE(started_.Wait());
  EXPECT_TRUE(cancelled_.Wait());
  EXPECT_TRUE(coordinator_.WaitFor([](const Seen& seen) { return seen.hellos.size() >= 2; }))
      << "and it connects anew";
}

TEST_F(AgentTest, HeartbeatsCarryProgressAndReportsThatWait) {
  coordinator_.Change([](auto& how) {
    how.lease_s = 0.4;
    how.report_status = grpc::StatusCode::INTERNAL;
  });
  runner_.Hold(1, started_, finish_, cancelled_);
  StartAgent();
  coordinator_.Offer(SolveLease(1, 11, 1));
  coordinator_.Offer(SolveLease(2, 12, 2));
  EXPECT_TRUE(coordinator_.WaitFor([](const Seen& seen) {
    if (seen.heartbeats.empty() || seen.heartbeats.back().running_size() != 2) return false;
    const auto& running = seen.heartbeats.back().running();
    return running[0].stage() == "anneal" && running[0].fraction() == 0.5 &&
           running[1].stage() == "report" && running[1].attempt().fence() == 12;
  }));
}

TEST_F(AgentTest, AHungJobIsReportedAsFailedAndTheWorkerDrains) {
  // Deaf to its cancellation, as a loop without end is.
  runner_.On(1, [this](const CancelToken&) -> absl::StatusOr<v1::SolveResult> {
    started_.Open();
    finish_.Wait();
    return v1::SolveResult();
  });
  options_.hang_s = 0.1;
  StartAgent();
  coordinator_.Offer(SolveLease(5, 50, 1));
  ASSERT_TRUE(started_.Wait());
  JoinAgent();
  ASSERT_TRUE(summary_.ok()) << summary_.status();
  EXPECT_EQ(summary_->hung, 1);
  EXPECT_EQ(summary_->stuck, 1);
  EXPECT_EQ(summary_->handed_back, 0);
  const Seen seen = coordinator_.seen();
  ASSERT_EQ(seen.fails.size(), 1u);
  EXPECT_EQ(seen.fails[0].attempt().job_id(), 5);
  EXPECT_EQ(seen.fails[0].fingerprint(), "DEADLINE_EXCEEDED@solve/anneal: no progress for # s");
  EXPECT_TRUE(seen.fails[0].retryable());
  EXPECT_TRUE(seen.completes.empty());
  finish_.Open();
}

TEST_F(AgentTest, DrainFinishesWhatRunsAndTakesNothingNew) {
  runner_.Hold(1, started_, finish_, cancelled_);
  StartAgent();
  coordinator_.Offer(SolveLease(1, 11, 1));
  ASSERT_TRUE(started_.Wait());
  agent_->Drain();
  ASSERT_TRUE(coordinator_.WaitFor([](const Seen& seen) {
    return !seen.heartbeats.empty() && seen.heartbeats.back().draining();
  }));
  coordinator_.Offer(SolveLease(2, 12, 2));  // Uses credit given before.
  ASSERT_TRUE(coordinator_.WaitFor([](const Seen& seen) { return seen.hand_backs.size() == 1; }));
  EXPECT_EQ(coordinator_.seen().hand_backs[0].attempt().fence(), 12u);
  finish_.Open();
  JoinAgent();
  ASSERT_TRUE(summary_.ok());
  EXPECT_EQ(summary_->succeeded, 1);
  ASSERT_EQ(coordinator_.seen().completes.size(), 1u);
  EXPECT_EQ(coordinator_.seen().completes[0].attempt().fence(), 11u);
}

TEST_F(AgentTest, AfterTheGraceRunningWorkIsHandedBack) {
  options_.grace_s = 0.05;
  runner_.Hold(1, started_, finish_, cancelled_);
  StartAgent();
  coordinator_.Offer(SolveLease(1, 11, 1));
  ASSERT_TRUE(started_.Wait());
  agent_->Drain();
  JoinAgent();
  EXPECT_TRUE(cancelled_.Wait());
  ASSERT_TRUE(summary_.ok());
  EXPECT_EQ(summary_->handed_back, 1);
  const Seen seen = coordinator_.seen();
  ASSERT_EQ(seen.hand_backs.size(), 1u) << "read before Run() returned";
  EXPECT_EQ(seen.hand_backs[0].attempt().fence(), 11u);
  EXPECT_TRUE(seen.fails.empty());
}

TEST_F(AgentTest, ASecondSignalHandsBackAtOnceEvenWhatDoesNotStop) {
  options_.hand_back_s = 0.05;
  runner_.On(1, [&](const CancelToken&) -> absl::StatusOr<v1::SolveResult> {
    started_.Open();
    finish_.Wait();
    return v1::SolveResult();
  });
  StartAgent();
  coordinator_.Offer(SolveLease(1, 11, 1));
  ASSERT_TRUE(started_.Wait());
  agent_->Drain();
  agent_->HandBack();
  JoinAgent();
  EXPECT_EQ(summary_->stuck, 1);
  EXPECT_EQ(coordinator_.seen().hand_backs.size(), 1u);
  finish_.Open();
}

TEST_F(AgentTest, ACoordinatorThatRefusesTheWorkerEndsIt) {
  coordinator_.Change([](auto& how) { how.hello_status = grpc::StatusCode::ALREADY_EXISTS; });
  StartAgent();
  JoinAgent();
  EXPECT_EQ(summary_.status().code(), absl::StatusCode::kAlreadyExists);
  EXPECT_NE(summary_.status().ToString().find("go away"), std::string::npos);
}

TEST_F(AgentTest, ACoordinatorThatComesLateIsWaitedFor) {
  coordinator_.Stop();
  StartAgent();
  coordinator_.Start();
  coordinator_.Offer(SolveLease(1, 11, 1));
  EXPECT_TRUE(coordinator_.WaitFor([](const Seen& seen) { return seen.completes.size() == 1; }));
}

TEST_F(AgentTest, BadOptionsAreRefused) {
  AgentOptions bad = options_;
  bad.slots = 0;
  EXPECT_EQ(Agent::Create(bad, runner_, Clock::System()).status().code(),
            absl::StatusCode::kInvalidArgument);
  bad = options_;
  bad.name = "../worker";
  EXPECT_EQ(Agent::Create(bad, runner_, Clock::System()).status().code(),
            absl::StatusCode::kInvalidArgument);
}

}  // namespace
}  // namespace parallax
