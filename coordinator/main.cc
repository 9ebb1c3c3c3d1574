// The program `coordinator`: serve, init, check, backup.
#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cerrno>
#include <cstring>
#include <exception>
#include <filesystem>
#include <iostream>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/completion.h"
#include "common/base/status.h"
#include "common/base/system/file.h"
#include "common/base/system/log.h"
#include "common/base/usage_error.h"
#include "common/base/version.h"
#include "common/store/store.h"
#include "coordinator/client/scores/page_table.h"
#include "coordinator/client/scores/score_trials.h"
#include "coordinator/client/search/search_picture.h"
#include "coordinator/init.h"
#include "coordinator/queue/database_tools.h"
#include "coordinator/queue/job_queue.h"
#include "coordinator/rpc/storage/scrubber.h"
#include "coordinator/rpc/workers/output_check.h"
#include "coordinator/serve.h"

namespace parallax {
namespace {

constexpr char kServeFooter[] = R"(Examples:
  coordinator serve --db parallax.db --store ./store
  coordinator serve --db /var/lib/parallax/queue.db --store /srv/parallax \
      --listen 127.0.0.1:7070 --listen unix:/run/parallax/coordinator.sock --http 127.0.0.1:7080

When it is ready it prints "listening on ADDRESS" for each address and "http on URL". SIGTERM stops it: workers
continue their jobs and connect again after the next start.
)";

constexpr char kInitFooter[] = R"(Examples:
  coordinator init farm-tls --host farm.example.org --issue worker pool --issue submitter ada
  coordinator init farm-tls --issue read-only dashboard      later, with the same authority
  coordinator init farm-tls --renew server --renew worker-pool     before they expire; then restart
  coordinator init farm-tls --renew server --host other.example.org   one more name; then restart
  coordinator init farm-tls --revoke submitter-ada                 at once, no restart

  coordinator serve ... --listen 0.0.0.0:7070 --tls farm-tls/server
  worker --role all --coordinator farm.example.org:7070 --tls worker-pool
  parallax submit my-study.yaml --coordinator farm.example.org:7070 --tls submitter-ada

Roles: worker does jobs; submitter submits studies and steers its own; operator steers all and reads the audit;
read-only looks and fetches. Nothing is overwritten but by --renew.
The list of revoked certificates is farm-tls/server/revoked: copy it to the coordinator's --tls folder, or to the file of
its --revoked, if that is another one. Calls are checked as they begin; what a worker has under way ends when its connection does.
)";

struct CheckOptions {
  std::string db;
  std::string store;
  bool deep = false;    // Read the files and compare their hashes.
  bool repair = false;  // Remove damaged results from studies.
  double mb_per_s = 0;  // Bound on reading; 0: none.
};

struct CommandLine {
  ServeOptions serve;
  InitOptions init;
  std::string db;
  std::string backup_file;
  CheckOptions check;
  bool log_json = false;
  std::string log_level = "info";
};

void DeclarePlaces(CLI::App& serve, ServeOptions& options) {
  serve.add_option("--db", options.db, "Database file, on a local disk; made if absent")
      ->required();
  serve
      .add_option("--store", options.store,
                  "Folder of the results, or s3://bucket/prefix (see coordinator/README.md)")
      ->required();
  serve
      .add_option("--listen", options.listen,
                  "gRPC address: HOST:PORT or unix:/path; again for more "
                  "(default 127.0.0.1:7070; port 0: any free one)")
      ->type_name("ADDRESS");
  serve
      .add_option(
          "--http", options.http,
          "The page with its API, /metrics and /healthz (default 127.0.0.1:7080; \"\": none)")
      ->type_name("ADDRESS");
}

void DeclareServeTimes(CLI::App& serve, ServeOptions& options) {
  serve
      .add_option("--lease-s", options.lease_s,
                  "Seconds without a heartbeat after which work is given to others (default 60)")
      ->check(CLI::Range(0.1, 86400.0));
  serve
      .add_option("--reconnect-s", options.reconnect_grace_s,
                  "Seconds that a worker may take to come back when its connection breaks "
                  "(default 10)")
      ->check(CLI::Range(0.0, 86400.0));
  serve
      .add_option("--backoff-s", options.backoff_s,
                  "Least seconds before a failed job is tried again (default 5); each further try "
                  "waits up to four times as long, at most 600")
      ->check(CLI::Range(0.01, 600.0));
  serve
      .add_option("--archive-days", options.archive_after_days,
                  "Days after its end that a study's jobs move to the archive (default 30; "
                  "0: never)")
      ->check(CLI::Range(0.0, 36500.0));
}

void DeclareRetention(CLI::App& serve, ServeOptions& options) {
  serve
      .add_option("--keep-days", options.keep_days,
                  "Days after its end that a study is forgotten, with the pairs, networks and "
                  "scores that no other study uses (default 0: never)")
      ->check(CLI::Range(0.0, 36500.0));
  serve
      .add_option("--keep-gb", options.keep_gb,
                  "Gigabytes (1e9 bytes) that the results of all studies may take: above, the "
                  "studies that ended first are forgotten, never an unfinished one (default 0: no "
                  "bound)")
      ->check(CLI::Range(0.0, 1e9));
}

void DeclareRules(CLI::App& serve, ServeOptions& options) {
  serve
      .add_option("--limits", options.limits,
                  "YAML file of how many jobs, studies and pairs each user may have at a time "
                  "(see coordinator/README.md; default: no limits)")
      ->type_name("FILE");
  serve
      .add_option("--samplers", options.samplers,
                  "Folder of YAML files, each a program that searches may name to propose trials "
                  "(see coordinator/search/README.md; default: only the built-in sobol)")
      ->type_name("DIR");
  serve
      .add_option("--store-access", options.store_access,
                  "How workers reach the store: direct (they see it themselves), stream (their "
                  "files come through this coordinator) or auto (default: direct where they see "
                  "it, else stream)")
      ->check(CLI::IsMember({"auto", "direct", "stream"}));
  serve.add_flag(
      "--adopt-store", options.adopt_store,
      "Accept another store than before at --store; use it once, after a disk was replaced");
  serve
      .add_option(
          "--scrub-mb-s", options.scrub_mb_s,
          "Megabytes a second to read results in search of damage; damaged results are made "
          "again (default 8; 0: never)")
      ->check(CLI::Range(0.0, 1e6));
  serve
      .add_option("--scrub-days", options.scrub_days,
                  "Days between the starts of two such passes over all results (default 7)")
      ->check(CLI::Range(0.0, 36500.0));
  serve
      .add_option(
          "--sweep-days", options.sweep_days,
          "Days without a change after which folders of attempts that the database does not "
          "know are removed from the store (default 7; 0: never)")
      ->check(CLI::Range(0.0, 36500.0));
  serve.add_flag("--trust-workers", options.trust_workers,
                 "Publish results without checking that their files exist");
}

void DeclareNotices(CLI::App& serve, ServeOptions& options) {
  serve
      .add_option("--notify", options.notify,
                  "HTTP or HTTPS address that gets a POST of JSON when a study ends, stalls, has "
                  "failed jobs or jobs that wait for a person; repeated until it answers 2xx")
      ->type_name("URL");
  serve
      .add_option("--notify-command", options.notify_command,
                  "Program that is run then, with the JSON as its argument; repeated until it ends "
                  "with status 0")
      ->type_name("PROGRAM");
  serve
      .add_option("--notify-hosts", options.notify_hosts,
                  "Hosts to which studies may have their own notices posted (`notify:` in the "
                  "file), with a comma between: HOST or HOST:PORT; * is any (default: none)")
      ->delimiter(',')
      ->type_name("HOST,...");
  serve
      .add_option("--notify-stall-min", options.notify_stall_min,
                  "Minutes after which a study with ready jobs of which none runs is stalled "
                  "(default 30; 0: never)")
      ->check(CLI::Range(0.0, 1e6));
}

void DeclareSecurity(CLI::App& serve, ServeOptions& options) {
  serve
      .add_option("--tls", options.tls_dir,
                  "Folder with ca.crt, tls.crt and tls.key, as `coordinator init` makes it: TCP "
                  "addresses are encrypted, and callers need a certificate")
      ->envname("PARALLAX_TLS")
      ->type_name("DIR");
  serve
      .add_option(
          "--revoked", options.revoked,
          "List of revoked certificates, which may change while it serves (default: revoked "
          "in the folder of --tls)")
      ->type_name("FILE");
  serve.add_flag("--insecure", options.insecure,
                 "Allow other addresses than this machine's, without encryption");
}

// In the order of --help.
CLI::App* DeclareServe(CLI::App& app, CommandLine& line) {
  CLI::App* serve = app.add_subcommand("serve", "Serve workers and clients until SIGTERM");
  line.serve.listen = {"127.0.0.1:7070"};
  line.serve.http = "127.0.0.1:7080";
  DeclarePlaces(*serve, line.serve);
  DeclareServeTimes(*serve, line.serve);
  DeclareRetention(*serve, line.serve);
  DeclareRules(*serve, line.serve);
  DeclareNotices(*serve, line.serve);
  DeclareSecurity(*serve, line.serve);
  serve->add_flag("--log-json", line.log_json, "One JSON object a log line");
  serve->add_option("--log-level", line.log_level, "debug, info, warning or error (default info)");
  serve->footer(std::string(kServeFooter) + "\n" + kExitHelp);
  return serve;
}

CLI::App* DeclareInit(CLI::App& app, InitOptions& options) {
  CLI::App* init = app.add_subcommand(
      "init", "Make a farm's certificates: authority, coordinator, workers and people");
  init->add_option("DIR", options.dir, "Where they go; made if absent")->required();
  init->add_option("--host", options.hosts,
                   "Name or address that the coordinator is reached by; again for more (this "
                   "machine's own are always in)")
      ->type_name("HOST");
  init->add_option("--issue", options.issue,
                   "A certificate: role (worker, submitter, operator, read-only) and name; again "
                   "for more")
      ->type_name("ROLE NAME");
  init->add_option("--renew", options.renew,
                   "A folder of DIR (server, worker-NAME...): its certificate is made anew for the "
                   "same party; again for more")
      ->type_name("FOLDER");
  init->add_option(
          "--revoke", options.revoke,
          "A folder of DIR: the coordinator refuses the certificate in it from now on; with "
          "--renew the old one; again for more")
      ->type_name("FOLDER");
  init->add_option("--days", options.days, "How long certificates are valid (default 398)")
      ->check(CLI::Range(0.01, 3650.0));
  init->footer(kInitFooter);
  return init;
}

ProgramError Init(const InitOptions& options) {
  const absl::Status status = InitFarm(options, Clock::System(), std::cout);
  std::cout << std::flush;
  if (status.ok()) return {};
  return {status, absl::IsInvalidArgument(status) ? kExitUsage : kExitFailed};
}

// Files that results name and the store does not have, at most `most` of them in `out`.
absl::Status CheckOutputs(const std::string& db, const std::string& uri, size_t most,
                          std::vector<std::string>& out) {
  ASSIGN_OR_RETURN(const auto store, OpenStore(uri, {.create = false, .read_only = true}));
  return VisitStoredOutputs(db, [&](const std::vector<JobKind::OutputFile>& files) -> absl::Status {
    ASSIGN_OR_RETURN(std::string why, WhyNotInStore(*store, files));
    if (!why.empty() && out.size() < most) out.push_back("a published file: " + std::move(why));
    return absl::OkStatus();
  });
}

// "study 3 (baseline), variant narrow, scene 5, rig 2"; "" if no study has the result.
std::string Pairs(JobQueue& queue, const Sha256Digest& key) {
  const auto users = queue.ListUsesOf(key);
  if (!users.ok() || users->empty()) return "";
  return "\n  of " + fmt::format("{}", fmt::join(*users, "\n  and of "));
}

// Reads all files of results. Says what is damaged and, with `repair`, has it made again.
ProgramError CheckDeeply(const CheckOptions& options) {
  JobQueueOptions queue_options;
  queue_options.db_path = options.db;
  queue_options.own_timer = false;
  // Another store than the database's has none of its files.
  absl::StatusOr<std::unique_ptr<Store>> store = Internal("not opened");
  queue_options.open_store = [&](const KnownStore& known) -> absl::StatusOr<std::string> {
    store = OpenStore(options.store, {.create = false, .id = known.id, .read_only = true});
    RETURN_IF_ERROR(store.status());
    return known.id;
  };
  auto queue = JobQueue::Open(queue_options);
  if (!queue.ok() && queue.status() == store.status()) return {store.status(), kExitFailed};
  if (!queue.ok()) return ExplainOpenError(queue.status(), options.db);
  const auto scrub = (*queue)->GetScrub();
  if (scrub.ok() && *scrub && !(*scrub)->ended_unix_s && !(*scrub)->position.empty()) {
    std::cout << "continues after " << (*scrub)->files << " files that were read before\n";
  }
  Scrubber scrubber(**queue, **store,
                    {.bytes_per_s = options.mb_per_s * 1e6, .repair = options.repair});
  const auto pass = scrubber.Pass([&](const DamagedResult& damaged) {
    std::cout << "damaged: " << damaged.why << Pairs(**queue, damaged.key) << std::endl;
  });
  if (!pass.ok()) return {WithContext(pass.status(), "store " + options.store), kExitFailed};
  std::cout << pass->files << " files of " << pass->bytes << " bytes were read, " << pass->damaged
            << " results are damaged" << std::endl;
  if (options.repair) {
    std::cout << scrubber.figures().pairs_taken_back
              << " pairs are removed; they are made again when a coordinator serves" << std::endl;
    return {};
  }
  if (pass->damaged == 0) return {};
  return {DataLoss("{}: {} results are damaged; `coordinator check --deep --repair`, or a "
                   "coordinator that serves, has them made again",
                   options.store, pass->damaged),
          kExitDatabaseDamaged};
}

ProgramError Check(const CheckOptions& options) {
  const auto& [db, store, deep, repair, mb_per_s] = options;
  if (store.empty() && (deep || repair)) {
    return {InvalidArgument("check: --deep and --repair want --store"), kExitUsage};
  }
  if (repair && !deep) return {InvalidArgument("check: --repair wants --deep"), kExitUsage};
  // Its own exit status for a coordinator that is at work.
  if (std::filesystem::exists(db)) {
    if (ProgramError error = CheckDatabasePlace(db); !error.status.ok()) return error;
  }
  auto problems = AuditDatabaseFile(db);
  if (!problems.ok()) return ExplainOpenError(problems.status(), db);
  if (!store.empty() && !deep) {
    const absl::Status looked = CheckOutputs(db, store, problems->size() + 100, *problems);
    if (!looked.ok()) return {WithContext(looked, "store " + store), kExitFailed};
  }
  for (const std::string& problem : *problems) std::cout << problem << "\n";
  if (!problems->empty()) {
    return {DataLoss("{}: {} invariants are broken", db, problems->size()), kExitDatabaseDamaged};
  }
  std::cout << db << ": every invariant holds"
            << (store.empty() || deep ? "" : ", and every published file is in the store")
            << std::endl;
  return deep ? CheckDeeply(options) : ProgramError{};
}

ProgramError Backup(const std::string& db, const std::string& file) {
  const absl::Status status = BackUpFile(db, file);
  if (!status.ok()) return {status, kExitFailed};
  std::cout << file << std::endl;
  return {};
}

int End(const ProgramError& error) {
  if (error.status.ok()) return kExitOk;
  std::cerr << "coordinator: " << ToStd(error.status.message()) << std::endl;
  return error.exit;
}

int Main(int argc, char** argv) {
  CommandLine line;
  CLI::App app(
      "Keeps the queue of a farm that makes stereo data, and gives its workers their jobs.",
      "coordinator");
  app.set_version_flag("--version", std::string("coordinator ") + kProgramVersion);
  app.require_subcommand(1);
  app.footer(kExitHelp);
  const CLI::App* serve = DeclareServe(app, line);
  const CLI::App* init = DeclareInit(app, line.init);
  CLI::App* check = app.add_subcommand(
      "check", "Re-derive every invariant of a database that no coordinator has open");
  check->add_option("--db", line.check.db, "Database file")->required();
  check->add_option("--store", line.check.store,
                    "Look for every published file in this store as well");
  check->add_flag("--deep", line.check.deep,
                  "Read every file in the store and compare its hash; resumes where it was "
                  "interrupted");
  check->add_flag("--repair", line.check.repair,
                  "Remove damaged results from all studies, so that jobs make them again");
  check
      ->add_option("--mb-per-s", line.check.mb_per_s,
                   "Megabytes a second that are read (default 0: as fast as possible)")
      ->check(CLI::Range(0.0, 1e6));
  CLI::App* backup = app.add_subcommand(
      "backup", "Copy a database consistently, also while a coordinator serves it");
  backup->add_option("--db", line.db, "Database file")->required();
  backup->add_option("FILE", line.backup_file, "The copy; must not exist")->required();
  AddCompletion(app);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);  // --help, --version
    std::cerr << "coordinator: " << ExplainUsage(app, error, {argv + 1, argv + argc}) << std::endl;
    return kExitUsage;
  }
  const auto level = ParseLogLevel(line.log_level);
  if (!level.ok()) return End({level.status(), kExitUsage});
  InitLogging({.json = line.log_json, .level = *level, .program = "coordinator"});
  line.serve.table = PageTable;
  line.serve.picture = client::SearchSvg;
  line.serve.scores = ScoreTrials;
  if (serve->parsed()) return End(Serve(line.serve));
  if (init->parsed()) return End(Init(line.init));
  if (check->parsed()) return End(Check(line.check));
  return End(Backup(line.db, line.backup_file));
}

// Libraries throw where there is no thread or memory left, from whatever thread. The database is
// safe at any moment, so the program ends there; it says why.
[[noreturn]] void EndByException() {
  try {
    if (const auto thrown = std::current_exception()) std::rethrow_exception(thrown);
    std::cerr << "coordinator: ended by std::terminate" << std::endl;
  } catch (const std::exception& error) {
    const std::string_view why = error.what();
    std::cerr << "coordinator: ends: " << why
              << (why.find(std::strerror(EAGAIN)) == why.npos
                      ? ""
                      : " (no thread can be made: more are needed than `ulimit -u`, TasksMax of a "
                        "unit or the pids limit of a container allows)")
              << std::endl;
  } catch (...) {
    std::cerr << "coordinator: ended by an exception" << std::endl;
  }
  _exit(kExitFailed);
}

}  // namespace
}  // namespace parallax

int main(int argc, char** argv) {
  parallax::HoldStandardStreams();
  std::set_terminate(parallax::EndByException);
  return parallax::Main(argc, argv);
}
