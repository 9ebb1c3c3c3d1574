// Fixture of the queue's tests: a clock that they own, a database in a fresh folder, studies, and
// workers' answers.
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "common/base/status.h"
#include "common/config/frame_files.h"
#include "coordinator/queue/database/database_file.h"
#include "coordinator/queue/job_queue.h"
#include "coordinator/queue/tables/ready_board.h"
#include "tests/folder_test.h"
#include "tests/job_messages.h"

namespace parallax {

class FakeClock final : public Clock {
 public:
  double UnixSeconds() override { return unix_s_; }
  SteadyTime Steady() override {
    return SteadyTime(std::chrono::duration_cast<SteadyTime::duration>(
        std::chrono::duration<double>(steady_s_.load())));
  }
  void Advance(double seconds) {
    unix_s_ = unix_s_ + seconds;
    steady_s_ = steady_s_ + seconds;
  }
  void JumpWall(double seconds) { unix_s_ = unix_s_ + seconds; }

 private:
  std::atomic<double> unix_s_{1.8e9};
  std::atomic<double> steady_s_{1000};
};

// Makes a command of a queue fail at each of its steps, or at one.
class FailingCommand {
 public:
  // Queues that are opened with these options from now on ask it.
  explicit FailingCommand(JobQueueOptions& options) {
    options.fail_point = [at = at_](const std::string& command, int step) {
      const bool fails = command == at->command.load() && (at->step == 0 || at->step == step);
      return fails ? Internal("fail point") : absl::OkStatus();
    };
  }
  // A literal; "none": all are let through. `step` 0: each.
  void Set(const char* command, int step = 0) {
    at_->step = step;
    at_->command = command;
  }
  void Clear() { Set("none"); }

 private:
  struct Place {  // The writer's thread reads it.
    std::atomic<const char*> command{"none"};
    std::atomic<int> step{0};
  };
  std::shared_ptr<Place> at_ = std::make_shared<Place>();
};

inline WorkerFacts AnyWorker(const std::string& name) {
  return {.name = name, .kinds = {"solve", "render"}, .memory_mb = 8000};
}
inline WorkerFacts Solver(const std::string& name) { return {.name = name, .kinds = {"solve"}}; }
inline WorkerFacts Renderer(const std::string& name) { return {.name = name, .kinds = {"render"}}; }

struct StudyOptions {
  std::string name = "study";
  uint64_t seed = 1;
  int64_t pairs = 4;
  int rigs_per_scene = 2;
  // Variants share the layout and differ in their baseline.
  std::vector<std::string> variants = {"only"};
  int priority = 0;
  std::string key;
};

inline v1::SubmitRequest MakeStudy(const StudyOptions& options = {}) {
  v1::SubmitRequest request;
  v1::StudySpec* spec = request.mutable_study();
  spec->set_name(options.name);
  spec->set_seed(options.seed);
  spec->set_pairs(options.pairs);
  spec->set_rigs_per_scene(options.rigs_per_scene);
  spec->set_priority(options.priority);
  double baseline = 0.1;
  for (const std::string& name : options.variants) {
    v1::VariantSpec* variant = spec->add_variants();
    variant->set_name(name);
    v1::SceneConfig* config = variant->mutable_config();
    config->set_type(v1::SCENE_TYPE_INDOOR);
    config->mutable_rigs()->set_count(options.rigs_per_scene);
    config->mutable_rigs()->mutable_baseline_m()->set_constant(baseline);
    config->mutable_render()->set_samples_per_pixel(4);
    baseline += 0.1;
  }
  request.set_idempotency_key(options.key);
  return request;
}

// The answer of a worker that has solved the scene.
inline v1::CompleteRequest SolveAnswer(const v1::Lease& lease, const std::string& worker) {
  v1::CompleteRequest request;
  *request.mutable_attempt() = lease.attempt();
  request.set_worker(worker);
  v1::SolveResult result;
  const v1::SolveJob job = SolveOf(lease);
  v1::Scene* scene = result.mutable_scene();
  scene->set_scene_seed(job.scene_seed());
  for (int i = 0; i < job.config().rigs().count(); ++i) {
    v1::Rig* rig = scene->add_rigs();
    rig->set_index(static_cast<uint32_t>(i));
    rig->set_baseline_m(job.config().rigs().baseline_m().constant());
  }
  if (!job.has_layout()) {
    result.mutable_layout()->mutable_place()->mutable_house()->add_rooms()->set_width_m(
        static_cast<double>(job.scene_seed() % 1000));
  }
  SetResult(result, request);
  return request;
}
inline v1::CompleteRequest RejectAnswer(const v1::Lease& lease, const std::string& worker,
                                        bool with_layout) {
  v1::CompleteRequest request;
  *request.mutable_attempt() = lease.attempt();
  request.set_worker(worker);
  v1::SolveResult result;
  result.mutable_rejected()->set_reason("no room for a rig");
  if (with_layout)
    result.mutable_layout()->mutable_place()->mutable_house()->add_rooms()->set_width_m(3);
  SetResult(result, request);
  return request;
}
inline v1::CompleteRequest RenderAnswer(const v1::Lease& lease, const std::string& worker) {
  v1::CompleteRequest request;
  *request.mutable_attempt() = lease.attempt();
  request.set_worker(worker);
  v1::RenderResult result;
  const v1::RenderJob job = RenderOf(lease);
  for (const uint32_t rig : job.rigs()) {
    v1::FrameResult* frame = result.add_frames();
    frame->set_rig(rig);
    char name[16];
    std::snprintf(name, sizeof(name), "%03u", rig);
    frame->set_path(lease.store_prefix() + "/.attempt-" + std::to_string(lease.attempt().fence()) +
                    "/" + name);
    for (const std::string& file_name : FrameFileNames(job.render())) {
      v1::FileEntry* file = frame->add_files();
      file->set_name(file_name);
      file->set_size(100);
      file->set_sha256(std::string(64, 'a'));
    }
  }
  SetResult(result, request);
  return request;
}
inline v1::CompleteRequest Answer(const v1::Lease& lease, const std::string& worker) {
  return lease.kind() == "solve" ? SolveAnswer(lease, worker) : RenderAnswer(lease, worker);
}
inline v1::FailRequest Failure(const v1::Lease& lease, const std::string& worker,
                               const std::string& fingerprint, bool retryable = true) {
  v1::FailRequest request;
  *request.mutable_attempt() = lease.attempt();
  request.set_worker(worker);
  request.set_error(fingerprint + " at line 7");
  request.set_fingerprint(fingerprint);
  request.set_retryable(retryable);
  return request;
}

class QueueTest : public FolderTest {
 protected:
  QueueTest() {
    options_.db_path = dir_ + "/queue.db";
    options_.clock = &clock_;
    options_.lease_s = 30;
    options_.own_timer = false;
    options_.linger_s = 0;
  }
  ~QueueTest() override { queue_.reset(); }
  void SetUp() override { Reopen(); }
  void TearDown() override {
    if (queue_) ExpectSound();
  }

  void Reopen() {
    queue_.reset();
    auto queue = JobQueue::Open(options_);
    ASSERT_TRUE(queue.ok()) << queue.status();
    queue_ = *std::move(queue);
  }
  void ExpectSound() {
    const auto violations = queue_->Check();
    ASSERT_TRUE(violations.ok()) << violations.status();
    EXPECT_THAT(*violations, testing::IsEmpty());
    const auto db = OpenReader(options_.db_path, options_.vfs);
    ASSERT_TRUE(db.ok()) << db.status();
    ReadyBoard counted;
    ASSERT_TRUE(counted.Load(**db, *options_.kinds).ok());
    EXPECT_EQ(queue_->ReadyGroups(), counted.Groups());
  }

  StudyId Submit(const StudyOptions& options = {}) {
    const auto reply = queue_->Submit(MakeStudy(options), "tester");
    EXPECT_TRUE(reply.ok()) << reply.status();
    return StudyId{reply.ok() ? reply->study_id() : 0};
  }
  std::vector<v1::Lease> Lease(const WorkerFacts& worker, int n = 1) {
    auto leases = queue_->Lease(worker, n);
    EXPECT_TRUE(leases.ok()) << leases.status();
    return leases.ok() ? *std::move(leases) : std::vector<v1::Lease>();
  }
  // The one lease there must be.
  v1::Lease LeaseOne(const WorkerFacts& worker) {
    const auto leases = Lease(worker, 1);
    EXPECT_EQ(leases.size(), 1u);
    return leases.empty() ? v1::Lease() : leases[0];
  }
  v1::ReportOutcome Complete(const v1::CompleteRequest& request) {
    const auto outcome = queue_->Complete(request);
    EXPECT_TRUE(outcome.ok()) << outcome.status();
    return outcome.ok() ? *outcome : v1::REPORT_OUTCOME_UNSPECIFIED;
  }
  v1::ReportOutcome Fail(const v1::FailRequest& request) {
    const auto outcome = queue_->Fail(request);
    EXPECT_TRUE(outcome.ok()) << outcome.status();
    return outcome.ok() ? *outcome : v1::REPORT_OUTCOME_UNSPECIFIED;
  }
  // Does all there is to do; returns how many jobs that were.
  int WorkOff(const WorkerFacts& worker) {
    int jobs = 0;
    for (;;) {
      const auto leases = Lease(worker, 8);
      if (leases.empty()) return jobs;
      for (const v1::Lease& lease : leases) {
        EXPECT_EQ(Complete(Answer(lease, worker.name)), v1::REPORT_OUTCOME_OK);
        ++jobs;
      }
    }
  }
  v1::StudyStatus Status(StudyId study) {
    auto status = queue_->GetStudy(study);
    EXPECT_TRUE(status.ok()) << status.status();
    return status.ok() ? *std::move(status) : v1::StudyStatus();
  }
  int64_t Jobs(StudyId study, const std::string& kind, const std::string& state) {
    int64_t n = 0;
    const v1::StudyStatus status = Status(study);
    for (const v1::VariantStatus& variant : status.variants()) {
      n += JobsOf(variant, kind, state);
    }
    return n;
  }
  std::vector<v1::JobStatus> ListJobs(StudyId study, const std::string& state = "") {
    v1::ListJobsRequest request;
    request.set_study_id(study.value);
    request.set_state(state);
    auto jobs = queue_->ListJobs(request);
    EXPECT_TRUE(jobs.ok()) << jobs.status();
    return jobs.ok() ? *std::move(jobs) : std::vector<v1::JobStatus>();
  }
  std::vector<v1::PublishedFrame> Frames(StudyId study, int64_t cursor = 0, int limit = 0) {
    v1::ListFramesRequest request;
    request.set_study_id(study.value);
    request.set_cursor(cursor);
    request.set_limit(limit);
    auto frames = queue_->ListFrames(request);
    EXPECT_TRUE(frames.ok()) << frames.status();
    return frames.ok() ? *std::move(frames) : std::vector<v1::PublishedFrame>();
  }
  void Tick() {
    const auto next = queue_->Tick();
    EXPECT_TRUE(next.ok()) << next.status();
  }

  FakeClock clock_;
  JobQueueOptions options_;
  std::unique_ptr<JobQueue> queue_;
};

}  // namespace parallax
