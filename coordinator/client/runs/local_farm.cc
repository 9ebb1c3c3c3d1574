#include "coordinator/client/runs/local_farm.h"

#include <fmt/core.h>

#include <chrono>
#include <filesystem>

#include "common/base/system/installation.h"
#include "common/base/system/log.h"
#include "coordinator/client/views/study_view.h"
#include "worker/materials/pictures/picture_folder.h"

namespace parallax::client {
namespace {

constexpr auto kLookEvery = std::chrono::milliseconds(500);
constexpr int kMostStudies = 1000;

std::vector<std::string> ArgumentsOf(const LocalWorkers& workers, int worker) {
  std::vector<std::string> arguments = {"--coordinator",
                                        workers.coordinator,
                                        "--role",
                                        "all",
                                        "--slots",
                                        "1",
                                        "--grace",
                                        std::to_string(static_cast<int>(kDrainGrace_s)),
                                        "--exit-when-orphaned",
                                        "--name",
                                        fmt::format("local-{}", worker),
                                        "--picture-root",
                                        "/",  // They work for the user who started them.
                                        "--cores-dir",
                                        workers.store_dir + "/cores",
                                        "--outbox",
                                        workers.store_dir + "/outbox"};
  const auto add = [&](const char* option, const std::string& value) {
    if (!value.empty()) arguments.insert(arguments.end(), {option, value});
  };
  add("--allow-trainers", workers.machine.allow_trainers);
  add("--trainers", workers.machine.trainers_dir);
  add("--benchmarks", workers.machine.benchmarks_dir);
  if (FollowsLinks()) arguments.push_back("--follow-links");
  // One worker takes the jobs that need the GPU, so that they do not share its memory.
  std::error_code error;
  if (worker == 0 && std::filesystem::exists(kGpuDevice, error)) add("--tags", "gpu");
  return arguments;
}

}  // namespace

absl::StatusOr<WorkerPoolOptions> PoolOf(const LocalWorkers& workers) {
  WorkerPoolOptions pool;
  ASSIGN_OR_RETURN(pool.binary, FindProgram("worker"));
  pool.workers = workers.workers;
  pool.log_dir = workers.log_dir;
  pool.clock = workers.clock;
  pool.arguments = [workers](int index) { return ArgumentsOf(workers, index); };
  return pool;
}

void LogCoordinatorTo(const std::string& log_dir) {
  std::error_code error;
  std::filesystem::create_directories(log_dir, error);
  InitLogging({.program = "coordinator", .file = log_dir + "/coordinator.log"});
}

absl::StatusOr<std::unique_ptr<LocalFarm>> LocalFarm::Start(const std::string& dir, int workers,
                                                            Clock* clock) {
  RETURN_IF_ERROR(FindProgram("worker").status());  // Before a folder is made.
  ASSIGN_OR_RETURN(auto folder, OutDir::Open(dir));
  std::unique_ptr<LocalFarm> farm(new LocalFarm(std::move(folder)));
  const std::string work_dir = farm->dir_->work_dir(), log_dir = work_dir + "/logs";
  LogCoordinatorTo(log_dir);
  ASSIGN_OR_RETURN(farm->coordinator_, EmbeddedCoordinator::Start(work_dir));
  farm->coordinator_->RemoveLitter();
  ASSIGN_OR_RETURN(farm->connection_, Connection::Open(farm->address()));
  ASSIGN_OR_RETURN(farm->pool_, PoolOf({.coordinator = farm->address(),
                                        .store_dir = work_dir,
                                        .log_dir = log_dir,
                                        .workers = workers,
                                        .clock = clock}));
  RETURN_IF_ERROR(farm->RetryFailed());
  farm->thread_ = std::thread([it = farm.get()] { it->Loop(); });
  return farm;
}

LocalFarm::~LocalFarm() {
  {
    const std::lock_guard lock(mu_);
    stopping_ = true;
  }
  stop_.notify_all();
  if (thread_.joinable()) thread_.join();
}

absl::Status LocalFarm::status() const {
  const std::lock_guard lock(mu_);
  return status_;
}

absl::Status LocalFarm::RetryFailed() {
  ASSIGN_OR_RETURN(const v1::ListStudiesReply list, connection_->ListStudies(kMostStudies));
  for (const v1::StudyStatus& study : list.studies()) {
    if (CountsOf(study).failed == 0 && study.state() != v1::STUDY_STATE_FAILED) continue;
    RETURN_IF_ERROR(connection_->Retry(study.study_id()).status());
  }
  return absl::OkStatus();
}

void LocalFarm::Loop() {
  WorkerPool pool(pool_);
  absl::Status status = pool.Start();
  std::unique_lock lock(mu_);
  while (status.ok() && !stopping_) {
    lock.unlock();
    status = Look(pool);
    lock.lock();
    stop_.wait_for(lock, kLookEvery, [this] { return stopping_; });
  }
  status_ = status;
  lock.unlock();
  pool.Drain(0, [] { return true; });
}

absl::Status LocalFarm::Look(WorkerPool& pool) {
  RETURN_IF_ERROR(dir_->CheckFreeSpace());
  ASSIGN_OR_RETURN(const v1::ListStudiesReply list, connection_->ListStudies(kMostStudies));
  // Studies may be forgotten meanwhile, so that the sum also falls.
  int64_t done = 0;
  for (const v1::StudyStatus& study : list.studies()) {
    done += JobsInState(study, "SUCCEEDED") + CountsOf(study).done + CountsOf(study).rejected;
  }
  if (done > jobs_done_) ++results_;
  jobs_done_ = done;
  return pool.Poll(results_);
}

}  // namespace parallax::client
