// An agent on a thread of its own, a coordinator that answers as the test says, and jobs that do.
#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <condition_variable>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "common/base/status.h"
#include "common/rpc/endpoint.h"
#include "fake_coordinator.h"
#include "test_runner.h"
#include "tests/first_call.h"
#include "tests/folder_test.h"
#include "tests/job_messages.h"
#include "worker/agent/agent.h"

namespace parallax {

namespace fs = std::filesystem;

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
class ScriptedRunner final : public TestRunner {
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
        return Cancelled("told to");
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
    if (job.rigs_size() == 0) return ResourceExhausted("disk of 80 GB is full");
    v1::RenderResult result;
    result.add_frames()->set_path(folder.path + "/000");
    return result;
  }

 private:
  std::map<uint64_t, Solver> solvers_;
};

inline v1::Lease SolveLease(int64_t job, uint64_t fence, uint64_t seed) {
  v1::Lease lease;
  lease.mutable_attempt()->set_job_id(job);
  lease.mutable_attempt()->set_fence(fence);
  lease.set_kind("solve");
  lease.set_attempt_number(1);
  v1::SolveJob job_spec;
  job_spec.set_scene_seed(seed);
  lease.set_spec(job_spec.SerializeAsString());
  return lease;
}

inline v1::Lease RenderLease(int64_t job, uint64_t fence, std::vector<uint32_t> rigs) {
  v1::Lease lease;
  lease.mutable_attempt()->set_job_id(job);
  lease.mutable_attempt()->set_fence(fence);
  lease.set_kind("render");
  lease.set_store_prefix("renders/ab12");
  v1::RenderJob spec;
  for (uint32_t rig : rigs) spec.add_rigs(rig);
  lease.set_spec(spec.SerializeAsString());
  return lease;
}

class AgentTest : public FolderTest {
 protected:
  AgentTest() : coordinator_(*ParseRpcAddress("unix:" + dir_ + "/coordinator.sock")) {
    options_.coordinator = *ParseRpcAddress("unix:" + dir_ + "/coordinator.sock");
    options_.name = "worker-1";
    options_.kinds = {"solve", "render"};
    options_.slots = 2;
    options_.outbox_root = dir_ + "/outbox";
    options_.hand_back_s = 0.2;
    options_.backoff_base_s = 0.01;
    options_.backoff_cap_s = 0.05;
    options_.reports.backoff_base_s = 0.01;
    options_.reports.backoff_cap_s = 0.05;
    coordinator_.Change([this](auto& how) { how.store_uri = "file://" + dir_ + "/store"; });
    coordinator_.Start();
    MakeFirstCall(*v1::Coordinator::NewStub(*ConnectRpc(options_.coordinator, {})));
  }
  ~AgentTest() override {
    StopAgent();
    coordinator_.Stop();
  }

  void StartAgent() {
    auto agent = Agent::Create(options_, handlers_, Clock::System());
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

  FakeCoordinator coordinator_;
  Gate started_, finish_, cancelled_;  // Outlive the agent's jobs.
  ScriptedRunner runner_;
  const JobHandlers handlers_ = HandlersOf(runner_);
  AgentOptions options_;
  std::unique_ptr<Agent> agent_;
  std::thread thread_;
  absl::StatusOr<AgentSummary> summary_ = Unknown("Run() has not returned");
};

}  // namespace parallax
