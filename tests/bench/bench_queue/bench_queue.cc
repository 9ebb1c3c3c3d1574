// Experiment 8: what the queue carries, at synchronous=FULL. One study of no-op jobs is worked off
// in one database: first by threads in the queue's own process (the library alone), then by
// simulated workers over gRPC against the program `coordinator`; then the coordinator is killed and
// started again; then real agents measure the gap between two jobs; the auditor ends it. Prints one
// JSON line; exits with 1 when anything was refused or the auditor finds something.
//
//   bench_queue [--jobs 1000000] [--library-jobs 500000] [--workers 256] [--slots 1] [--rigs 1]
//               [--seconds 0] [--threads 128] [--per-lease 8] [--gap-workers 200]
//               [--gap-seconds 15] [--max-running 0] [--dir /tmp]
//
// A transition is one durable lease or one durable completion. `--seconds` bounds the part over
// gRPC. All parts run on this machine at the same time as their load: figures are of both.
#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <thread>

#include "common/base/status.h"
#include "common/base/system/file.h"
#include "common/base/system/log.h"
#include "coordinator/queue/database_tools.h"
#include "coordinator/queue/job_queue.h"
#include "coordinator_process.h"
#include "gap_farm.h"
#include "library_load.h"
#include "measure.h"
#include "nlohmann/json.hpp"
#include "no_op.h"
#include "simulated_farm.h"

namespace parallax {
namespace {

namespace fs = std::filesystem;

constexpr double kFdatasync_s = 2;
constexpr double kProbeEvery_s = 0.5;
constexpr double kRestartTimeout_s = 60;

struct Arguments {
  int64_t jobs = 1'000'000;
  int64_t library_jobs = -1;  // Half.
  int workers = 256;
  int slots = 1;
  int rigs = 1;
  double seconds = 0;
  int threads = 128;
  int per_lease = 8;
  int gap_workers = 200;
  double gap_seconds = 15;
  int max_running = 0;
  std::string dir = "/tmp";
  std::string command;
};

// Figures of the coordinator while it works.
struct Watched {
  double rss_mb = 0;
  double wal_mb = 0;
  Samples status_page_ms;
  int64_t failed_gets = 0;

  void Look(const CoordinatorProcess& coordinator, const std::string& db) {
    rss_mb = std::max(rss_mb, PeakRssMb(coordinator.pid()));
    wal_mb = std::max(wal_mb, FileMb(db + "-wal"));
    const auto page = TimeGet(coordinator.http_address(), "/api/v1/farm");
    if (page.ok()) {
      status_page_ms.Add(1000 * *page);
    } else {
      ++failed_gets;
    }
  }
};

struct Bench {
  Arguments arguments;
  std::string folder;
  nlohmann::ordered_json out;
  Watched watched;

  std::string db() const { return folder + "/queue.db"; }
  std::string limits() const { return folder + "/limits.yaml"; }
  CoordinatorProcess::Options Coordinator() const {
    const std::string own = fs::read_symlink("/proc/self/exe").parent_path().string();
    return {.program = own + "/coordinator",
            .db = db(),
            .store = folder + "/store",
            .log = folder + "/coordinator.log",
            .limits = arguments.max_running > 0 ? limits() : ""};
  }

  absl::Status Submit() {
    JobQueueOptions options;
    options.db_path = db();
    ASSIGN_OR_RETURN(const auto queue, JobQueue::Open(options));
    // More than is worked off, so that the end finds the farm at full load.
    const int64_t spare = 8192 + 100 * arguments.gap_workers;
    return queue->Submit(NoOpStudy("no-op", 1, arguments.jobs / 2 + spare, arguments.rigs), "bench")
        .status();
  }

  absl::Status Library() {
    if (arguments.library_jobs <= 0) return absl::OkStatus();
    LibraryLoad load{.db_path = db(),
                     .jobs = arguments.library_jobs,
                     .threads = arguments.threads,
                     .per_lease = arguments.per_lease};
    ASSIGN_OR_RETURN(const LibraryFigures figures, RunLibraryLoad(load));
    out["library_transitions_per_s"] = std::round(figures.transitions / figures.seconds);
    out["library_transitions"] = figures.transitions;
    out["library_seconds"] = figures.seconds;
    out["library_cpu_us_per_transition"] =
        1e6 * figures.cpu_s / static_cast<double>(figures.transitions);
    out["library_lease_p99_ms"] = figures.lease_p99_ms;
    out["library_commands_per_commit"] = figures.commands_per_commit;
    out["library_commit_ms"] = figures.commit_ms;
    out["library_checkpoints"] = figures.checkpoints;
    out["library_checkpoint_ms"] = figures.checkpoint_ms;
    out["library_checkpoint_max_ms"] = figures.checkpoint_max_ms;
    return absl::OkStatus();
  }

  absl::Status OverGrpc() {
    const int64_t jobs = arguments.jobs - std::max<int64_t>(0, arguments.library_jobs);
    if (jobs <= 0) return absl::OkStatus();
    ASSIGN_OR_RETURN(auto coordinator, CoordinatorProcess::Start(Coordinator()));
    FarmTally tally;
    const double cpu_before = CpuSecondsOf(coordinator->pid());
    const double own_cpu_before = ProcessCpuSeconds();
    const auto begin = BenchClock::now();
    ASSIGN_OR_RETURN(auto farm, SimulatedFarm::Start({.address = coordinator->address(),
                                                      .workers = arguments.workers,
                                                      .slots = arguments.slots},
                                                     tally));
    while (tally.completions < jobs &&
           (arguments.seconds <= 0 || SecondsSince(begin) < arguments.seconds)) {
      std::this_thread::sleep_for(std::chrono::duration<double>(kProbeEvery_s));
      watched.Look(*coordinator, db());
      if (tally.broken > 0) return Unavailable("a stream or call broke");
    }
    const double seconds = SecondsSince(begin);
    const int64_t transitions = tally.leases + tally.completions;
    const double per = 1e6 / static_cast<double>(std::max<int64_t>(1, transitions));
    out["transitions_per_s"] = std::round(static_cast<double>(transitions) / seconds);
    out["transitions"] = transitions;
    out["seconds"] = seconds;
    out["pairs_per_s"] = std::round(static_cast<double>(tally.pairs) / seconds);
    out["coordinator_cpu_us_per_transition"] =
        per * (CpuSecondsOf(coordinator->pid()) - cpu_before);
    out["workers_cpu_us_per_transition"] = per * (ProcessCpuSeconds() - own_cpu_before);
    // Killed at full load: the streams break, leases stay.
    farm->StopAsking();
    const int64_t refused = tally.refused;
    coordinator->Kill();
    farm.reset();
    out["lease_p50_ms"] = tally.lease_ms.Percentile(0.5);
    out["lease_p99_ms"] = tally.lease_ms.Percentile(0.99);
    out["report_p99_ms"] = tally.report_ms.Percentile(0.99);
    if (refused > 0) return Internal("reports were refused");
    return absl::OkStatus();
  }

  // Measures the time from the start of the program to the first lease of a worker, then the gaps.
  absl::Status Restart() {
    const auto begin = BenchClock::now();
    ASSIGN_OR_RETURN(auto coordinator, CoordinatorProcess::Start(Coordinator()));
    FarmTally tally;
    {
      ASSIGN_OR_RETURN(
          auto farm,
          SimulatedFarm::Start({.address = coordinator->address(), .name = "first", .workers = 1},
                               tally));
      while (tally.leases == 0 && SecondsSince(begin) < kRestartTimeout_s) {
        std::this_thread::sleep_for(std::chrono::microseconds(200));
      }
      out["restart_s"] = SecondsSince(begin);
      if (tally.leases == 0) return DeadlineExceeded("no lease after the restart");
    }
    if (arguments.gap_workers > 0) {
      ASSIGN_OR_RETURN(const GapFigures gaps, MeasureGaps({.address = coordinator->address(),
                                                           .outbox_root = folder + "/outbox",
                                                           .workers = arguments.gap_workers,
                                                           .seconds = arguments.gap_seconds}));
      out["gap_p50_ms"] = gaps.p50_ms;
      out["gap_p99_ms"] = gaps.p99_ms;
      out["gaps"] = gaps.gaps;
    }
    watched.Look(*coordinator, db());
    return coordinator->Terminate();
  }

  absl::Status Run() {
    out["bench"] = "queue";
    if (arguments.max_running > 0) {
      RETURN_IF_ERROR(WriteFile(
          limits(), fmt::format("default: {{max_running: {}}}\n", arguments.max_running)));
    }
    RETURN_IF_ERROR(Submit());
    ASSIGN_OR_RETURN(const double fdatasyncs, FdatasyncPerSecond(folder, kFdatasync_s));
    RETURN_IF_ERROR(Library());
    RETURN_IF_ERROR(OverGrpc());
    RETURN_IF_ERROR(Restart());
    out["fdatasync_per_s"] = std::round(fdatasyncs);
    out["rss_mb"] = watched.rss_mb;
    out["wal_mb"] = watched.wal_mb;
    out["status_page_ms"] = watched.status_page_ms.Percentile(0.99);
    out["failed_gets"] = watched.failed_gets;
    out["db_mb"] = FileMb(db());
    out["jobs"] = arguments.jobs;
    out["workers"] = arguments.workers;
    out["slots"] = arguments.slots;
    out["rigs"] = arguments.rigs;
    ASSIGN_OR_RETURN(const std::vector<std::string> violations, AuditDatabaseFile(db()));
    out["audit"] = violations.empty() ? "sound" : violations.front();
    out["machine"] = MachineText();
    out["commit"] = FirstLineOf("git rev-parse --short HEAD");
    out["command"] = arguments.command;
    if (!violations.empty()) return Internal("{}", violations.front());
    return absl::OkStatus();
  }
};

int Main(int argc, char** argv) {
  Bench bench;
  Arguments& arguments = bench.arguments;
  CLI::App app("Durable transitions a second of the job queue; one JSON line.", "bench_queue");
  app.add_option("--jobs", arguments.jobs, "Jobs in all (default 1,000,000)");
  app.add_option("--library-jobs", arguments.library_jobs,
                 "Of these, without gRPC (default: half; 0: none)");
  app.add_option("--workers", arguments.workers, "Simulated workers over gRPC (default 256)");
  app.add_option("--slots", arguments.slots, "Jobs at a time of each (default 1)");
  app.add_option("--rigs", arguments.rigs, "Pairs that each render job publishes (default 1)");
  app.add_option("--seconds", arguments.seconds, "Bound of the part over gRPC (default none)");
  app.add_option("--threads", arguments.threads, "Of the part without gRPC (default 128)");
  app.add_option("--per-lease", arguments.per_lease, "Leases in one call there (default 8)");
  app.add_option("--gap-workers", arguments.gap_workers, "Real agents (default 200; 0: none)");
  app.add_option("--gap-seconds", arguments.gap_seconds, "How long (default 15)");
  app.add_option("--max-running", arguments.max_running,
                 "The coordinator has limits: jobs of each user at a time (default 0: no limits)");
  app.add_option("--dir", arguments.dir, "Where the database is (default /tmp)");
  CLI11_PARSE(app, argc, argv);
  // Thousands of jobs a second would be told otherwise, in stderr.
  InitLogging({.level = LogLevel::kWarning, .program = "bench_queue"});
  for (int i = 0; i < argc; ++i) arguments.command += (i > 0 ? " " : "") + std::string(argv[i]);
  if (arguments.library_jobs < 0) arguments.library_jobs = arguments.jobs / 2;

  bench.folder = arguments.dir + "/bench-queue-XXXXXX";
  if (mkdtemp(bench.folder.data()) == nullptr) {
    std::perror(bench.folder.c_str());
    return 1;
  }
  const absl::Status status = bench.Run();
  std::printf("%s\n", bench.out.dump().c_str());
  if (!status.ok()) {
    std::fprintf(stderr, "bench_queue: %s\n", status.ToString().c_str());
    std::fprintf(stderr, "%s\n",
                 FirstLineOf("tail -n 1 " + bench.folder + "/coordinator.log").c_str());
  }
  std::error_code ignored;
  fs::remove_all(bench.folder, ignored);
  return status.ok() ? 0 : 1;
}

}  // namespace
}  // namespace parallax

int main(int argc, char** argv) { return parallax::Main(argc, argv); }
