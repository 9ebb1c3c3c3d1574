// Measures the page's requests on a farm with a million jobs and a thousand workers: a real
// coordinator, a synthetic database, connected workers that idle. Prints one JSON line.
#include <stdlib.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iostream>
#include <map>
#include <nlohmann/json.hpp>
#include <thread>

#include "common/base/status.h"
#include "coordinator/queue/job_queue.h"
#include "coordinator_process.h"
#include "measure.h"
#include "no_op.h"
#include "samples.h"
#include "simulated_farm.h"
#include "tests/bench/program_main.h"
#include "tests/sqlite_by_hand.h"

namespace parallax {
namespace {

constexpr double kJoin_s = 60;
constexpr double kAllowed_ms = 200;
constexpr int kRealJobs = 200;

struct Arguments {
  int64_t jobs = 1'000'000;
  int workers = 1000;
  int rounds = 30;
  std::string coordinator, folder, command;
};

// A paused study with a few jobs done in earnest, and their copies: rows that readers can't tell
// from others.
class Database {
 public:
  explicit Database(std::string path) : path_(std::move(path)) {}

  absl::Status Make(int64_t jobs) {
    RETURN_IF_ERROR(MakeStudy());
    sqlite3* db = OpenByHand(path_);
    if (db == nullptr) return Internal("no database");
    const absl::Status copied = Copy(db, jobs);
    sqlite3_close(db);
    return copied;
  }

 private:
  absl::Status MakeStudy() {
    JobQueueOptions options;
    options.db_path = path_;
    ASSIGN_OR_RETURN(const auto queue, JobQueue::Open(options));
    ASSIGN_OR_RETURN(const v1::SubmitReply study,
                     queue->Submit(NoOpStudy("million", 1, 10'000'000), "bench"));
    const WorkerFacts worker = {.name = "w", .kinds = {"solve", "render"}, .memory_mb = 1024};
    for (int done = 0; done < kRealJobs;) {
      ASSIGN_OR_RETURN(const auto leases, queue->Lease(worker, 20));
      for (const v1::Lease& lease : leases) {
        RETURN_IF_ERROR(queue->Complete(NoOpAnswer(lease, "w")).status());
      }
      done += static_cast<int>(leases.size());
    }
    return queue->Pause(StudyId{study.study_id()}, "", "bench");
  }

  // Columns of a table, each as itself or as `changed` says.
  static std::string Columns(sqlite3* db, const std::string& table,
                             const std::map<std::string, std::string>& changed) {
    std::string list;
    sqlite3_stmt* statement = nullptr;
    const std::string sql = "SELECT name FROM pragma_table_info('" + table + "')";
    sqlite3_prepare_v2(db, sql.c_str(), -1, &statement, nullptr);
    while (sqlite3_step(statement) == SQLITE_ROW) {
      const std::string name = reinterpret_cast<const char*>(sqlite3_column_text(statement, 0));
      const auto other = changed.find(name);
      list += (list.empty() ? "" : ", ") + (other == changed.end() ? "t." + name : other->second);
    }
    sqlite3_finalize(statement);
    return list;
  }

  absl::Status Copy(sqlite3* db, int64_t jobs) {
    const std::string count = std::to_string(jobs);
    const std::string numbers =
        "WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n WHERE i < " + count + ") ";
    const std::string sql =
        "BEGIN;"
        "CREATE TEMP TABLE one_job AS SELECT * FROM jobs WHERE kind = 'render' AND state ="
        " 'SUCCEEDED' LIMIT 1;"
        "CREATE TEMP TABLE one_frame AS SELECT * FROM frames LIMIT 1;" +
        numbers + "INSERT INTO jobs SELECT " +
        Columns(db, "jobs", {{"id", "1000000 + n.i"}, {"ordinal", "1000000 + n.i"}}) +
        " FROM one_job AS t, n;" + numbers + "INSERT INTO frames SELECT " +
        Columns(db, "frames", {{"cursor", "1000000 + n.i"}, {"ordinal", "1000000 + n.i"}}) +
        " FROM one_frame AS t, n;"
        "UPDATE job_counts SET jobs = jobs + " +
        count + " WHERE kind = 'render' AND state = 'SUCCEEDED'; COMMIT;";
    char* error = nullptr;
    if (sqlite3_exec(db, sql.c_str(), nullptr, nullptr, &error) == SQLITE_OK) {
      return absl::OkStatus();
    }
    const std::string why = error == nullptr ? "no rows" : error;
    sqlite3_free(error);
    return Internal("synthetic rows: {}", why);
  }

  const std::string path_;
};

struct Bench {
  Arguments arguments;
  nlohmann::ordered_json out;

  absl::Status Run() {
    const std::string db = arguments.folder + "/queue.db";
    RETURN_IF_ERROR(Database(db).Make(arguments.jobs));
    ASSIGN_OR_RETURN(const auto coordinator,
                     CoordinatorProcess::Start({.program = arguments.coordinator,
                                                .db = db,
                                                .store = arguments.folder + "/store",
                                                .log = arguments.folder + "/coordinator.log"}));
    FarmTally tally;
    ASSIGN_OR_RETURN(auto farm,
                     SimulatedFarm::Start(
                         {.address = coordinator->address(), .workers = arguments.workers}, tally));
    const absl::Status measured = Measure(*coordinator);
    farm->StopAsking();
    coordinator->Kill();
    farm.reset();
    RETURN_IF_ERROR(measured);
    out["db_mb"] = FileMb(db);
    out["machine"] = MachineText();
    out["commit"] = FirstLineOf("git rev-parse --short HEAD");
    out["command"] = arguments.command;
    return absl::OkStatus();
  }

  absl::Status Measure(const CoordinatorProcess& coordinator) {
    std::this_thread::sleep_for(std::chrono::duration<double>(
        std::min(kJoin_s, 2 + 0.01 * static_cast<double>(arguments.workers))));
    const std::string job = std::to_string(1'000'000 + arguments.jobs / 2);
    const std::vector<std::string> paths = {"/",
                                            "/api/v1/farm",
                                            "/api/v1/history",
                                            "/api/v1/workers",
                                            "/api/v1/studies",
                                            "/api/v1/studies/1",
                                            "/api/v1/studies/1/pairs?limit=56",
                                            "/api/v1/studies/1/pairs?limit=56&variant=only",
                                            "/api/v1/studies/1/jobs?limit=300",
                                            "/api/v1/studies/1/jobs?limit=300&state=SUCCEEDED",
                                            "/api/v1/studies/1/jobs?limit=300&state=REJECTED",
                                            "/api/v1/studies/1/scores",
                                            "/api/v1/jobs/" + job,
                                            "/api/v1/pairs/" + job,
                                            "/metrics"};
    out = {{"bench", "page"}, {"jobs", arguments.jobs}, {"workers", arguments.workers}};
    double worst = 0;
    for (const std::string& path : paths) {
      Samples ms;
      for (int round = 0; round < arguments.rounds; ++round) {
        ASSIGN_OR_RETURN(const double seconds, TimeGet(coordinator.http_address(), path));
        ms.Add(1000 * seconds);
      }
      const auto rounded = [&](double p) { return std::round(10 * ms.Percentile(p)) / 10; };
      out["ms"][path] = {{"p50", rounded(0.5)}, {"max", rounded(1)}};
      worst = std::max(worst, rounded(0.5));
    }
    out["slowest_p50_ms"] = worst;
    out["rss_mb"] = PeakRssMb(coordinator.pid());
    if (worst < kAllowed_ms) return absl::OkStatus();
    std::cout << out.dump() << std::endl;
    return DeadlineExceeded("a request took {:f} ms", worst);
  }
};

absl::Status Main(int argc, char** argv, int*) {
  Bench bench;
  Arguments& arguments = bench.arguments;
  CLI::App app("Milliseconds of the page's requests on a large farm; one JSON line.", "bench_page");
  app.add_option("--jobs", arguments.jobs, "Jobs that are done (default 1,000,000)")
      ->check(CLI::Range(int64_t{1}, int64_t{100'000'000}));
  app.add_option("--workers", arguments.workers, "Connected workers (default 1,000)");
  app.add_option("--rounds", arguments.rounds, "Requests of each kind (default 30)")
      ->check(CLI::Range(1, 10'000));
  app.add_option("--coordinator", arguments.coordinator, "The program (default: beside this one)");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    app.exit(error);
    if (error.get_exit_code() == 0) return absl::OkStatus();
    return InvalidArgument("{}", error.what());
  }
  for (int i = 0; i < argc; ++i) arguments.command += (i == 0 ? "" : " ") + std::string(argv[i]);
  if (arguments.coordinator.empty()) {
    arguments.coordinator =
        (std::filesystem::canonical("/proc/self/exe").parent_path() / "coordinator").string();
  }
  char name[] = "/tmp/bench-page-XXXXXX";
  if (mkdtemp(name) == nullptr) return Internal("no temporary folder");
  arguments.folder = name;
  const absl::Status status = bench.Run();
  std::filesystem::remove_all(name);
  RETURN_IF_ERROR(status);
  std::cout << bench.out.dump() << std::endl;
  return absl::OkStatus();
}

}  // namespace
}  // namespace parallax

int main(int argc, char** argv) {
  return parallax::ProgramMain("bench_page", parallax::Main, argc, argv);
}
