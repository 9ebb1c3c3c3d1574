#include "worker/agent/worker_program.h"

#include <fmt/core.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <iostream>
#include <mutex>
#include <sstream>

#include "common/base/clock.h"
#include "common/base/cores.h"
#include "common/base/log.h"
#include "common/base/memory_budget.h"
#include "common/base/names.h"
#include "common/base/status.h"
#include "common/base/version.h"
#include "worker/agent/agent.h"
#include "worker/agent/health.h"
#include "worker/agent/outbox.h"
#include "worker/agent/signal_watch.h"

namespace parallax {
namespace {

constexpr char kFooter[] = R"(Examples:
  worker --role all --coordinator 127.0.0.1:7070 --slots 1
  worker --role solve --coordinator unix:/run/parallax/coordinator.sock --slots 8 --threads 8
  worker --role render --coordinator farm:7070 --tls worker-pool --tags avx512,bigmem
  worker --role train,evaluate --coordinator farm:7070 --tags gpu --trainers /etc/parallax/trainers
         --allow-trainers raft-stereo --benchmarks /data/stereo

Signals:
  SIGUSR1             long drain: take nothing new, finish what runs within --long-grace
  SIGTERM or SIGINT   drain: take nothing new, finish what runs within --grace, then hand it back
  the second one      hand back at once
  the third one       end without a word

Exit status:
  0  drained, everything reported       1  store, outbox or machine can't be used
  2  bad arguments                      3  the coordinator refuses this worker
  4  work was handed back, or reports wait in the outbox for the next worker here
  5  the parent died (--exit-when-orphaned)
  6  a job hung (--hang-s) and was reported as failed: start the worker again)";

constexpr double kLongestS = 1e7;  // 115 days.

struct CommandLine {
  std::string role;
  std::string coordinator;
  int slots = 1;
  std::string name;
  std::string tags;
  std::string store;
  int threads = 0;
  int64_t memory_mb = 0;
  double grace_s = 300;
  double long_grace_s = 3600;
  double idle_exit_s = 0;
  double deadline_unix_s = 0;
  double hang_s = 1800;
  std::string outbox;
  std::string picture_root;
  std::string allowed_trainers = "builtin";
  std::string trainers_dir;
  std::string benchmarks_dir;
  std::string cores_dir;
  std::string cache_dir;
  int64_t cache_gb = 20;
  bool insecure = false;
  std::string tls_dir;
  std::string health;
  bool exit_when_orphaned = false;
  bool log_json = false;
  std::string log_level = "info";
};

std::string DefaultName() {
  char host[256] = "worker";
  gethostname(host, sizeof host - 1);
  std::string name = host;
  for (char& c : name) {
    if (!std::isalnum(static_cast<unsigned char>(c)) && c != '.' && c != '-') c = '-';
  }
  if (!std::isalnum(static_cast<unsigned char>(name[0]))) name = "worker" + name;
  return fmt::format("{}-{}", name.substr(0, 80), getpid());
}

// A folder of this user that survives a crash of the machine.
std::string DefaultOutbox() {
  const auto variable = [](const char* name) {
    const char* value = std::getenv(name);
    return std::string(value != nullptr && value[0] == '/' ? value : "");
  };
  if (const std::string state = variable("STATE_DIRECTORY"); !state.empty()) {
    return state + "/outbox";  // systemd's.
  }
  if (const std::string state = variable("XDG_STATE_HOME"); !state.empty()) {
    return state + "/parallax/outbox";
  }
  if (const std::string home = variable("HOME"); !home.empty()) {
    return home + "/.local/state/parallax/outbox";
  }
  return fmt::format("/var/tmp/parallax-outbox-{}", getuid());
}

void DeclareWork(CLI::App& app, CommandLine& line) {
  app.add_option("--role", line.role,
                 "Kinds of jobs it takes, for example solve (scenes) or solve,render; or all")
      ->required();
  app.add_option("--coordinator", line.coordinator,
                 "HOST:PORT or unix:/path of the coordinator (default: $PARALLAX_COORDINATOR)")
      ->envname("PARALLAX_COORDINATOR")
      ->required();
  app.add_option("--slots", line.slots, "Jobs at a time; they share the threads (default 1)")
      ->check(CLI::Range(1, 1024));
  app.add_option("--threads", line.threads, "Threads of all jobs together (default: all cores)")
      ->check(CLI::Range(1, 4096));
  app.add_option("--memory-mb", line.memory_mb,
                 "Memory it may use: a scene that needs more fails its job\n"
                 "(default: what the machine, container or batch job has)")
      ->envname("PARALLAX_MEMORY_MB")  // For the workers that `parallax run` starts.
      ->check(CLI::Range(1, 1 << 30));
  app.add_option("--tags", line.tags, "Words that studies may ask for, for example a,b");
  app.add_option("--name", line.name,
                 "Its name among the coordinator's workers (default: <host>-<pid>)");
}

void DeclareFolders(CLI::App& app, CommandLine& line) {
  app.add_option("--store", line.store,
                 "Where the coordinator's store is on this machine, if not under the same path");
  app.add_option("--outbox", line.outbox,
                 "Folder for reports that are not acknowledged yet, on a local disk\n"
                 "(default: $XDG_STATE_HOME/parallax/outbox)");
  app.add_option("--picture-root", line.picture_root,
                 "Folder of pictures that studies may use: their picture_dir is a path below it\n"
                 "(default: $PARALLAX_PICTURE_ROOT; without it such studies fail here)")
      ->envname("PARALLAX_PICTURE_ROOT")
      ->type_name("DIR")
      ->check(CLI::ExistingDirectory);
  app.add_option(
         "--allow-trainers", line.allowed_trainers,
         "Trainers that jobs may name here, for example builtin,raft-stereo (default builtin)")
      ->type_name("NAMES");
  app.add_option(
         "--trainers", line.trainers_dir,
         "Folder with NAME.yaml of each trainer beside the built-in one, and its code in NAME")
      ->type_name("DIR")
      ->check(CLI::ExistingDirectory);
  app.add_option("--benchmarks", line.benchmarks_dir,
                 "Folder of the real sets that evaluations name (default: $PARALLAX_BENCHMARKS;\n"
                 "the pairs that Parallax installs are always there)")
      ->envname("PARALLAX_BENCHMARKS")
      ->type_name("DIR")
      ->check(CLI::ExistingDirectory);
  app.add_option("--cores-dir", line.cores_dir,
                 "Workers of a machine with the same folder don't train beside other work\n"
                 "(default: one for this worker's own slots)")
      ->type_name("DIR");
  app.add_option("--cache", line.cache_dir,
                 "Folder for pairs to train on, where the store is elsewhere\n"
                 "(default: $XDG_CACHE_HOME/parallax)")
      ->type_name("DIR");
  app.add_option("--cache-gb", line.cache_gb, "Its size (default 20)")
      ->check(CLI::Range(1, 1 << 20));
}

void DeclareTimes(CLI::App& app, CommandLine& line) {
  app.add_option("--grace", line.grace_s,
                 "Seconds that running jobs may take after SIGTERM (default 300)")
      ->check(CLI::Range(0.0, kLongestS));
  app.add_option("--long-grace", line.long_grace_s,
                 "Seconds that running jobs may take after SIGUSR1 (default 3600)")
      ->check(CLI::Range(0.0, kLongestS));
  app.add_option("--exit-when-idle", line.idle_exit_s,
                 "End with status 0 after so many seconds without work (default: never)")
      ->check(CLI::Range(30.0, kLongestS));
  app.add_option(
         "--deadline", line.deadline_unix_s,
         "Be gone by then, in seconds since 1970: drain --grace before, and take no job that\n"
         "is likely to last longer (default: none)")
      ->check(CLI::Range(1e9, 1e11));
  app.add_option("--hang-s", line.hang_s,
                 "Seconds without progress after which a job counts as hung: it is reported as\n"
                 "failed and the worker drains (default 1800; 0: never)")
      ->check(CLI::Range(0.0, kLongestS));
}

void DeclareConnection(CLI::App& app, CommandLine& line) {
  app.add_option("--tls", line.tls_dir,
                 "Folder with ca.crt, tls.crt and tls.key, as `coordinator init --issue worker "
                 "NAME` makes it\n(default: $PARALLAX_TLS)")
      ->envname("PARALLAX_TLS")
      ->type_name("DIR");
  app.add_flag("--insecure", line.insecure, "Allow an unencrypted connection to another machine");
  app.add_option("--health", line.health,
                 "HOST:PORT or unix:/path where probes ask by gRPC's health protocol whether the\n"
                 "worker is `alive` and `ready`, for example 0.0.0.0:7090 (default: nowhere)")
      ->type_name("ADDRESS");
}

// In the order of --help.
void Declare(CLI::App& app, CommandLine& line) {
  DeclareWork(app, line);
  DeclareFolders(app, line);
  DeclareTimes(app, line);
  DeclareConnection(app, line);
  app.add_flag("--exit-when-orphaned", line.exit_when_orphaned, "End when the parent process dies");
  app.add_flag("--log-json", line.log_json, "One JSON object a log line");
  app.add_option("--log-level", line.log_level, "debug, info, warning or error (default info)");
  app.set_version_flag("--version",
                       std::string("worker ") + kProgramVersion + " (" + DescribeVersions() + ")");
  app.footer(kFooter);
}

// A folder of this user whose files can be made again.
std::string DefaultCache() {
  const char* named = std::getenv("XDG_CACHE_HOME");
  const char* home = std::getenv("HOME");
  if (named != nullptr && named[0] == '/') return std::string(named) + "/parallax";
  if (home != nullptr && home[0] == '/') return std::string(home) + "/.cache/parallax";
  return fmt::format("/var/tmp/parallax-cache-{}", getuid());
}

std::vector<std::string> SplitWords(const std::string& text) {
  std::vector<std::string> words;
  std::stringstream stream(text);
  for (std::string word; std::getline(stream, word, ',');) {
    if (!word.empty()) words.push_back(word);
  }
  return words;
}

absl::StatusOr<AgentOptions> OptionsOf(const CommandLine& line, const JobHandlers& handlers) {
  AgentOptions options;
  ASSIGN_OR_RETURN(options.coordinator, ParseRpcAddress(line.coordinator));
  ASSIGN_OR_RETURN(options.security, MakeRpcSecurity(line.insecure, line.tls_dir, Clock::System()));
  options.name = line.name.empty() ? DefaultName() : line.name;
  RETURN_IF_ERROR(CheckWorkerName(options.name));
  ASSIGN_OR_RETURN(options.kinds, KindsOfRole(line.role, handlers));
  options.slots = line.slots;
  options.cores = line.threads > 0 ? line.threads : UsableCores();
  SetMemoryLimit(line.memory_mb << 20);
  options.memory_mb = MemoryLimit() >> 20;
  options.tags = SplitWords(line.tags);
  for (const std::string& tag : options.tags) RETURN_IF_ERROR(CheckName("tag", tag));
  options.version = kProgramVersion;
  options.instance =
      fmt::format("{}-{}", getpid(), Clock::System().Steady().time_since_epoch().count());
  // Coordinators from before the versions of stages compare this and refuse.
  options.build_id =
      std::string("generator-") + kLayoutVersion + "." + kSceneVersion + "." + kFrameVersion;
  options.store_uri = line.store;
  options.outbox_root = line.outbox.empty() ? DefaultOutbox() : line.outbox;
  options.grace_s = line.grace_s;
  options.long_grace_s = line.long_grace_s;
  options.idle_exit_s = line.idle_exit_s;
  options.deadline_unix_s = line.deadline_unix_s;
  options.hang_s = line.hang_s;
  return options;
}

WorkerSettings SettingsOf(const CommandLine& line, const AgentOptions& options) {
  WorkerSettings settings;
  settings.slots = options.slots;
  settings.threads = options.cores;
  settings.picture_root = line.picture_root;
  settings.allowed_trainers = SplitWords(line.allowed_trainers);
  settings.trainers_dir = line.trainers_dir;
  settings.benchmarks_dir = line.benchmarks_dir;
  settings.cores_dir = line.cores_dir.empty()
                           ? options.outbox_root + "/" + options.name + "/staging/cores"
                           : line.cores_dir;
  settings.cache_dir = line.cache_dir.empty() ? DefaultCache() : line.cache_dir;
  settings.cache_bytes = line.cache_gb << 30;
  return settings;
}

int Complain(const absl::Status& status, int exit_status) {
  std::cerr << "worker: " << ToStd(status.message()) << std::endl;
  return exit_status;
}

int ExitFor(const absl::Status& status) {
  switch (status.code()) {
    case absl::StatusCode::kInvalidArgument:
    case absl::StatusCode::kUnimplemented:
    case absl::StatusCode::kUnauthenticated:
    case absl::StatusCode::kAlreadyExists:
    case absl::StatusCode::kFailedPrecondition:
      return kWorkerRefused;
    default:
      return kWorkerFailed;
  }
}

// Passes signals on to the agent, also those that came before there was one. Thread-safe.
class SignalRelay {
 public:
  void Raise(int count) {
    if (count > 2) std::_Exit(kWorkerIncomplete);
    std::lock_guard lock(mu_);
    wanted_ = std::max(wanted_, count);
    if (agent_ != nullptr) PassOn();
  }
  void DrainLong() {
    std::lock_guard lock(mu_);
    long_drain_ = true;
    if (agent_ != nullptr) agent_->DrainLong();
  }
  void Orphan() {
    orphaned_ = true;
    Raise(2);
  }

  // `agent` must live until Detach.
  void Attach(Agent* agent) {
    std::lock_guard lock(mu_);
    agent_ = agent;
    if (long_drain_) agent_->DrainLong();
    if (wanted_ > 0) PassOn();
  }
  void Detach() {
    std::lock_guard lock(mu_);
    agent_ = nullptr;
  }

  bool orphaned() const { return orphaned_; }

 private:
  void PassOn() { wanted_ == 1 ? agent_->Drain() : agent_->HandBack(); }

  std::mutex mu_;
  Agent* agent_ = nullptr;              // Guarded by mu_, as are the next two.
  int wanted_ = 0;                      // SIGTERMs and SIGINTs so far.
  bool long_drain_ = false;             // Whether there was a SIGUSR1.
  std::atomic<bool> orphaned_ = false;  // Set by the watch's thread, read at the end.
};

SignalWatch::Handlers HandlersFor(SignalRelay& relay, bool exit_when_orphaned) {
  SignalWatch::Handlers handlers;
  handlers.on_signal = [&relay](int count) { relay.Raise(count); };
  handlers.on_long_drain = [&relay] { relay.DrainLong(); };
  if (exit_when_orphaned) handlers.on_orphaned = [&relay] { relay.Orphan(); };
  return handlers;
}

int ExitAfter(const AgentSummary& summary, bool orphaned) {
  const bool complete = summary.handed_back == 0 && summary.reports_left == 0;
  return orphaned           ? kWorkerOrphaned
         : summary.hung > 0 ? kWorkerHung
         : complete         ? kWorkerDrained
                            : kWorkerIncomplete;
}

// Runs the agent to its end. Returns the exit status, unless a job hinders the process from ending:
// then ends it.
int RunAgent(Agent& agent, const AgentOptions& options, const CommandLine& line,
             const SignalRelay& relay) {
  LogInfo("worker starts", {{"coordinator", line.coordinator},
                            {"role", line.role},
                            {"slots", options.slots},
                            {"threads", options.cores},
                            {"version", kProgramVersion}});
  const absl::StatusOr<AgentSummary> summary = agent.Run();
  // A job that ignores its cancellation must not keep the process: its data is durable or
  // worthless.
  if (!summary.ok()) std::_Exit(Complain(summary.status(), ExitFor(summary.status())));
  LogInfo("worker ends", {{"succeeded", summary->succeeded},
                          {"failed", summary->failed},
                          {"handed_back", summary->handed_back},
                          {"reports_left", summary->reports_left}});
  const int status = ExitAfter(*summary, relay.orphaned());
  if (summary->stuck > 0) std::_Exit(status);
  return status;
}

int Work(const AgentOptions& options, const CommandLine& line, const JobHandlers& handlers) {
  SignalRelay relay;
  const SignalWatch watch(HandlersFor(relay, line.exit_when_orphaned));
  LogContext names;
  names.worker = options.name;
  const ScopedLogContext scope(names);
  auto created = Agent::Create(options, handlers, Clock::System());
  if (!created.ok()) return Complain(created.status(), kWorkerFailed);
  Agent& agent = **created;
  relay.Attach(&agent);

  std::unique_ptr<HealthServer> health;
  if (!line.health.empty()) {
    auto started = HealthServer::Start(line.health, [&agent] { return agent.Health(); });
    if (!started.ok()) {
      relay.Detach();
      const bool bad_address = absl::IsInvalidArgument(started.status());
      return Complain(started.status(), bad_address ? kWorkerUsage : kWorkerFailed);
    }
    health = *std::move(started);
  }
  const int status = RunAgent(agent, options, line, relay);
  relay.Detach();
  return status;
}

}  // namespace

absl::StatusOr<std::vector<std::string>> KindsOfRole(std::string_view role,
                                                     const JobHandlers& handlers) {
  std::vector<std::string> all;
  for (const auto& handler : handlers) all.push_back(handler->kind());
  if (role == "all") return all;
  std::vector<std::string> kinds;
  for (const std::string& word : SplitWords(std::string(role))) {
    if (FindHandler(handlers, word) == nullptr) {
      std::string known = "all";
      for (const std::string& kind : all) known += ", " + kind;
      return InvalidArgument("--role: unknown kind of job '{}'; there are {}", word, known);
    }
    if (std::count(kinds.begin(), kinds.end(), word) == 0) kinds.push_back(word);
  }
  if (kinds.empty()) return InvalidArgument("--role: names no kind of job");
  return kinds;
}

int RunWorkerProgram(int argc, char** argv, JobHandlers handlers,
                     const std::function<absl::Status(const WorkerSettings&)>& before_work) {
  CommandLine line;
  CLI::App app(
      "Leases jobs from a coordinator and does them: solves scenes, renders stereo pairs,\n"
      "trains networks and evaluates them.",
      "worker");
  Declare(app, line);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);  // --help, --version
    std::cerr << "worker: " << error.what() << " (see worker --help)" << std::endl;
    return kWorkerUsage;
  }
  const auto level = ParseLogLevel(line.log_level);
  if (!level.ok()) return Complain(level.status(), kWorkerUsage);
  InitLogging({.json = line.log_json, .level = *level, .program = "worker"});
  const auto options = OptionsOf(line, handlers);
  if (!options.ok()) return Complain(options.status(), kWorkerUsage);
  const absl::Status allowed = CheckRpcSecurity(options->coordinator, options->security);
  if (!allowed.ok()) return Complain(allowed, kWorkerUsage);
  if (before_work) {
    const absl::Status ready = before_work(SettingsOf(line, *options));
    if (!ready.ok()) return Complain(ready, kWorkerUsage);
  }
  return Work(*options, line, handlers);
}

}  // namespace parallax
