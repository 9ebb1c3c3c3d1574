// Durable transitions a second of the queue library alone: threads that lease and complete jobs
// without doing them, at synchronous=FULL. A transition is one lease or one completion. Prints one
// JSON line; ends with the auditor.
//
//   bench_queue_library [--jobs 100000] [--threads 64] [--per-lease 4] [--dir /tmp]
#include <sys/resource.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "coordinator/queue/job_queue.h"

namespace parallax {
namespace {

using SteadyClock = std::chrono::steady_clock;

double SecondsSince(SteadyClock::time_point begin) {
  return std::chrono::duration<double>(SteadyClock::now() - begin).count();
}

struct Arguments {
  int64_t jobs = 100'000;
  int threads = 64;
  int per_lease = 4;
  std::string dir = "/tmp";
};

Arguments Parse(int argc, char** argv) {
  Arguments arguments;
  for (int i = 1; i + 1 < argc; i += 2) {
    const std::string name = argv[i];
    if (name == "--jobs") arguments.jobs = std::atoll(argv[i + 1]);
    if (name == "--threads") arguments.threads = std::atoi(argv[i + 1]);
    if (name == "--per-lease") arguments.per_lease = std::atoi(argv[i + 1]);
    if (name == "--dir") arguments.dir = argv[i + 1];
  }
  return arguments;
}

v1::SubmitRequest NoOpStudy(int64_t scenes) {
  v1::SubmitRequest request;
  v1::StudySpec* spec = request.mutable_study();
  spec->set_name("no-op");
  spec->set_seed(1);
  spec->set_pairs(scenes);
  spec->set_rigs_per_scene(1);
  v1::VariantSpec* variant = spec->add_variants();
  variant->set_name("only");
  variant->mutable_config()->mutable_rigs()->set_count(1);
  return request;
}

v1::CompleteRequest Answer(const v1::Lease& lease, const std::string& worker) {
  v1::CompleteRequest request;
  *request.mutable_attempt() = lease.attempt();
  request.set_worker(worker);
  if (lease.kind() == v1::JOB_KIND_SOLVE) {
    v1::Scene* scene = request.mutable_solve()->mutable_scene();
    scene->set_scene_seed(lease.solve().scene_seed());
    scene->add_rigs();
    request.mutable_solve()->mutable_layout()->mutable_room()->set_width_m(3);
    return request;
  }
  for (const uint32_t rig : lease.render().rigs()) {
    v1::FrameResult* frame = request.mutable_render()->add_frames();
    frame->set_rig(rig);
    frame->set_path(lease.render().store_prefix() + "/.attempt-" +
                    std::to_string(lease.attempt().fence()) + "/000");
  }
  return request;
}

struct Tally {
  std::atomic<int64_t> transitions{0};
  std::mutex mutex;
  std::vector<double> lease_ms;  // Guarded by mutex.
};

void Work(JobQueue& queue, const std::string& name, int per_lease, Tally& tally) {
  const WorkerFacts worker{.name = name, .solves = true, .renders = true};
  std::vector<double> lease_ms;
  int dry = 0;
  while (dry < 20) {
    const auto begin = SteadyClock::now();
    const auto leases = queue.Lease(worker, per_lease);
    if (!leases.ok()) break;
    if (leases->empty()) {
      // The last jobs are in other hands.
      ++dry;
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
      continue;
    }
    dry = 0;
    lease_ms.push_back(1000 * SecondsSince(begin));
    std::atomic<int> open{static_cast<int>(leases->size())};
    for (const v1::Lease& lease : *leases) {
      queue.CompleteAsync(Answer(lease, name), [&](absl::StatusOr<v1::ReportOutcome> outcome) {
        if (!outcome.ok() || *outcome != v1::REPORT_OUTCOME_OK) std::abort();
        if (open.fetch_sub(1) == 1) open.notify_one();
      });
    }
    for (int left = open.load(); left != 0; left = open.load()) open.wait(left);
    tally.transitions += 2 * static_cast<int64_t>(leases->size());
  }
  const std::lock_guard lock(tally.mutex);
  tally.lease_ms.insert(tally.lease_ms.end(), lease_ms.begin(), lease_ms.end());
}

int Main(int argc, char** argv) {
  const Arguments arguments = Parse(argc, argv);
  std::string folder = arguments.dir + "/bench-queue-XXXXXX";
  if (mkdtemp(folder.data()) == nullptr) return 1;
  JobQueueOptions options;
  options.db_path = folder + "/queue.db";
  auto opened = JobQueue::Open(options);
  if (!opened.ok()) {
    std::fprintf(stderr, "%s\n", opened.status().ToString().c_str());
    return 1;
  }
  JobQueue& queue = **opened;
  if (!queue.Submit(NoOpStudy(arguments.jobs / 2), "bench").ok()) return 1;

  Tally tally;
  const auto begin = SteadyClock::now();
  std::vector<std::thread> threads;
  for (int i = 0; i < arguments.threads; ++i) {
    threads.emplace_back(
        [&, i] { Work(queue, "w" + std::to_string(i), arguments.per_lease, tally); });
  }
  for (std::thread& thread : threads) thread.join();
  const double seconds = SecondsSince(begin);

  std::sort(tally.lease_ms.begin(), tally.lease_ms.end());
  const auto percentile = [&](double p) {
    return tally.lease_ms.empty()
               ? 0
               : tally.lease_ms[static_cast<size_t>(p * (tally.lease_ms.size() - 1.0))];
  };
  const JobQueueStats stats = queue.Stats();
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto violations = queue.Check();
  opened->reset();
  const auto reopen = SteadyClock::now();
  const bool reopened = JobQueue::Open(options).ok();
  const double reopen_s = SecondsSince(reopen);
  std::printf(
      "{\"bench\": \"queue_library\", \"transitions_per_s\": %.0f, \"transitions\": %lld,"
      " \"seconds\": %.2f, \"lease_ms_p50\": %.2f, \"lease_ms_p99\": %.2f, \"commits\": %llu,"
      " \"commands_per_commit\": %.1f, \"commit_ms_mean\": %.3f, \"max_rss_mb\": %ld,"
      " \"reopen_s\": %.3f, \"db_mb\": %.1f, \"threads\": %d, \"per_lease\": %d, \"audit\": "
      "\"%s\"}\n",
      static_cast<double>(tally.transitions) / seconds,
      static_cast<long long>(tally.transitions.load()), seconds, percentile(0.5), percentile(0.99),
      static_cast<unsigned long long>(stats.commits),
      static_cast<double>(stats.commands) / std::max<double>(1, static_cast<double>(stats.commits)),
      1000 * stats.commit_seconds / std::max<double>(1, static_cast<double>(stats.commits)),
      usage.ru_maxrss / 1024, reopen_s,
      static_cast<double>(std::filesystem::file_size(options.db_path)) / 1e6, arguments.threads,
      arguments.per_lease,
      violations.ok() && violations->empty() && reopened ? "sound" : "VIOLATED");
  std::filesystem::remove_all(folder);
  return violations.ok() && violations->empty() ? 0 : 1;
}

}  // namespace
}  // namespace parallax

int main(int argc, char** argv) { return parallax::Main(argc, argv); }
