#include "library_load.h"

#include <atomic>
#include <thread>
#include <vector>

#include "coordinator/queue/job_queue.h"
#include "measure.h"
#include "no_op.h"
#include "samples.h"

namespace parallax {
namespace {

struct Tally {
  std::atomic<int64_t> jobs_left{0};
  std::atomic<int64_t> transitions{0};
  std::atomic<bool> wrong{false};
  Samples lease_ms;
};

void Work(JobQueue& queue, const std::string& name, int per_lease, Tally& tally) {
  const WorkerFacts worker{.name = name, .kinds = {"solve", "render"}};
  std::vector<double> lease_ms;
  while (tally.jobs_left > 0 && !tally.wrong) {
    const auto begin = BenchClock::now();
    const auto leases = queue.Lease(worker, per_lease);
    if (!leases.ok()) {
      tally.wrong = true;
      break;
    }
    if (leases->empty()) {
      // The last jobs are in other hands.
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
      continue;
    }
    lease_ms.push_back(1000 * SecondsSince(begin));
    std::atomic<int> open{static_cast<int>(leases->size())};
    for (const v1::Lease& lease : *leases) {
      queue.CompleteAsync(NoOpAnswer(lease, name), "",
                          [&](absl::StatusOr<v1::ReportOutcome> outcome) {
                            if (!outcome.ok() || *outcome != v1::REPORT_OUTCOME_OK)
                              tally.wrong = true;
                            if (open.fetch_sub(1) == 1) open.notify_one();
                          });
    }
    for (int left = open.load(); left != 0; left = open.load()) open.wait(left);
    tally.transitions += 2 * static_cast<int64_t>(leases->size());
    tally.jobs_left -= static_cast<int64_t>(leases->size());
  }
  tally.lease_ms.Add(lease_ms);
}

}  // namespace

absl::StatusOr<LibraryFigures> RunLibraryLoad(const LibraryLoad& load) {
  JobQueueOptions options;
  options.db_path = load.db_path;
  ASSIGN_OR_RETURN(const std::unique_ptr<JobQueue> queue, JobQueue::Open(options));
  Tally tally;
  tally.jobs_left = load.jobs;
  const double cpu_before = ProcessCpuSeconds();
  const auto begin = BenchClock::now();
  std::vector<std::thread> threads;
  for (int i = 0; i < load.threads; ++i) {
    threads.emplace_back([&, i] { Work(*queue, "w" + std::to_string(i), load.per_lease, tally); });
  }
  for (std::thread& thread : threads) thread.join();
  LibraryFigures figures;
  figures.seconds = SecondsSince(begin);
  figures.cpu_s = ProcessCpuSeconds() - cpu_before;
  if (tally.wrong) return Internal("the queue refused a lease or a report");
  figures.transitions = tally.transitions;
  figures.lease_p99_ms = tally.lease_ms.Percentile(0.99);
  const JobQueueStats stats = queue->Stats();
  const double commits = std::max(1.0, static_cast<double>(stats.commits));
  figures.commands_per_commit = static_cast<double>(stats.commands) / commits;
  figures.commit_ms = 1000 * stats.commit_seconds / commits;
  figures.checkpoints = static_cast<double>(stats.checkpoints);
  figures.checkpoint_ms = 1000 * stats.checkpoint_seconds / std::max(1.0, figures.checkpoints);
  figures.checkpoint_max_ms = 1000 * stats.checkpoint_seconds_max;
  return figures;
}

}  // namespace parallax
