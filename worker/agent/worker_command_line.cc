#include "worker/agent/worker_command_line.h"

#include <fmt/core.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <sstream>

#include "common/base/edit_distance.h"
#include "common/base/names.h"
#include "common/base/system/clock.h"
#include "common/base/system/cores.h"
#include "common/base/system/memory_budget.h"
#include "common/base/version.h"

namespace parallax {
namespace {

constexpr char kFooter[] = R"(Examples:
  worker --role all --coordinator 127.0.0.1:7070 --slots 1
  worker --role solve --coordinator unix:/run/parallax/coordinator.sock --slots 8 --threads 8
  worker --role render --coordinator farm:7070 --tls worker-pool --tags avx512,bigmem
  worker --role train,evaluate --coordinator farm:7070 --tags gpu --trainers /etc/parallax/trainers
         --allow-trainers raft-stereo --benchmarks /data/stereo

Signals:
  SIGUSR1             long drain: take nothing new, finish running jobs within --long-grace
  SIGTERM or SIGINT   drain: take nothing new, finish running jobs within --grace, then hand back
  the second one      hand back at once
  the third one       end without a word

Exit status:
  0  drained, everything reported       1  store, outbox or machine can't be used
  2  bad arguments                      3  the coordinator refuses this worker
  4  work was handed back, or reports wait in the outbox for the next worker here
  5  the parent died (--exit-when-orphaned)
  6  a job hung (--hang-s) and was reported as failed: start the worker again)";

constexpr double kLongestS = 1e7;  // 115 days.

// This machine's name, as far as a worker's name can have it.
std::string MachineName() {
  char host[256] = "worker";
  gethostname(host, sizeof host - 1);
  std::string name = host;
  for (char& c : name) {
    if (!std::isalnum(static_cast<unsigned char>(c)) && c != '.' && c != '-') c = '-';
  }
  if (!std::isalnum(static_cast<unsigned char>(name[0]))) name = "worker" + name;
  return name.substr(0, 80);
}

std::string DefaultName() { return fmt::format("{}-{}", MachineName(), getpid()); }

// Returns a folder named in the environment; "" unless it is absolute.
std::string FolderFrom(const char* variable) {
  const char* const value = std::getenv(variable);
  return value != nullptr && value[0] == '/' ? value : "";
}

// Trainers run in folders of their own: a path that they are given must not depend on ours. ""
// stays.
std::string Absolute(const std::string& path) {
  return path.empty() ? path : std::filesystem::absolute(path).lexically_normal().string();
}

// A folder of this user that survives a crash of the machine.
std::string DefaultOutbox() {
  if (const std::string state = FolderFrom("STATE_DIRECTORY"); !state.empty()) {
    return state + "/outbox";  // systemd's.
  }
  if (const std::string state = FolderFrom("XDG_STATE_HOME"); !state.empty()) {
    return state + "/parallax/outbox";
  }
  if (const std::string home = FolderFrom("HOME"); !home.empty()) {
    return home + "/.local/state/parallax/outbox";
  }
  return fmt::format("/var/tmp/parallax-outbox-{}", getuid());
}

// A folder of this user whose files can be made again.
std::string DefaultCache() {
  if (const std::string cache = FolderFrom("XDG_CACHE_HOME"); !cache.empty()) {
    return cache + "/parallax";
  }
  if (const std::string home = FolderFrom("HOME"); !home.empty()) return home + "/.cache/parallax";
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

void DeclareWork(CLI::App& app, WorkerCommandLine& line) {
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

void DeclareFolders(CLI::App& app, WorkerCommandLine& line) {
  app.add_option("--store", line.store,
                 "Where the coordinator's store is on this machine, if not under the same path");
  app.add_option("--outbox", line.outbox,
                 "Folder for reports that are not acknowledged yet, on a local disk\n"
                 "(default: $XDG_STATE_HOME/parallax/outbox)");
  app.add_option("--picture-root", line.picture_root,
                 "Folder of own content (meshes, textures, skies, pictures, benchmarks) that\n"
                 "studies may name by a path below it (default: $PARALLAX_PICTURE_ROOT; content\n"
                 "that `submit` sends needs no folder)")
      ->envname("PARALLAX_PICTURE_ROOT")
      ->type_name("DIR")
      ->check(CLI::ExistingDirectory);
  app.add_flag("--follow-links", line.follow_links,
               "Follow links in these folders that lead out of them, too");
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
                 "Workers on one machine with the same folder share its cores: while one trains\n"
                 "on them, the others wait (default: a folder for this worker's own slots)")
      ->type_name("DIR");
  app.add_option("--cache", line.cache_dir,
                 "Folder for pairs to train on and for own content, where the store is elsewhere\n"
                 "(default: $XDG_CACHE_HOME/parallax)")
      ->type_name("DIR");
  app.add_option("--cache-gb", line.cache_gb, "Largest size of each of the two (default 20)")
      ->check(CLI::Range(1, 1 << 20));
}

void DeclareTimes(CLI::App& app, WorkerCommandLine& line) {
  app.add_option("--grace", line.grace_s,
                 "Seconds that running jobs may take after SIGTERM (default 300)")
      ->check(CLI::Range(0.0, kLongestS));
  app.add_option("--long-grace", line.long_grace_s,
                 "Seconds that running jobs may take after SIGUSR1 (default 3600)")
      ->check(CLI::Range(0.0, kLongestS));
  app.add_option("--exit-when-idle", line.idle_exit_s,
                 "Seconds without work after which it ends with status 0 (default: never)")
      ->check(CLI::Range(30.0, kLongestS));
  app.add_option(
         "--deadline", line.deadline_unix_s,
         "End by this time (seconds since 1970): drain --grace seconds before, and take no\n"
         "job that would probably last longer (default: none)")
      ->check(CLI::Range(1e9, 1e11));
  app.add_option("--hang-s", line.hang_s,
                 "Seconds without progress after which a job counts as hung: it is reported as\n"
                 "failed and the worker drains (default 1800; 0: never)")
      ->check(CLI::Range(0.0, kLongestS));
}

void DeclareConnection(CLI::App& app, WorkerCommandLine& line) {
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

}  // namespace

void DeclareWorkerOptions(CLI::App& app, WorkerCommandLine& line) {
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
      return InvalidArgument("--role: unknown kind of job '{}'{} (there are {})", word,
                             NearestHint(word, all), known);
    }
    if (std::count(kinds.begin(), kinds.end(), word) == 0) kinds.push_back(word);
  }
  if (kinds.empty()) return InvalidArgument("--role: names no kind of job");
  return kinds;
}

absl::StatusOr<AgentOptions> AgentOptionsOf(const WorkerCommandLine& line,
                                            const JobHandlers& handlers) {
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
  options.machine = MachineName();
  // Coordinators from before the versions of stages compare this and refuse.
  options.build_id =
      std::string("generator-") + kLayoutVersion + "." + kSceneVersion + "." + kFrameVersion;
  options.store_uri = line.store;
  options.outbox_root = Absolute(line.outbox.empty() ? DefaultOutbox() : line.outbox);
  options.grace_s = line.grace_s;
  options.long_grace_s = line.long_grace_s;
  options.idle_exit_s = line.idle_exit_s;
  options.deadline_unix_s = line.deadline_unix_s;
  options.hang_s = line.hang_s;
  return options;
}

WorkerSettings WorkerSettingsOf(const WorkerCommandLine& line, const AgentOptions& options) {
  WorkerSettings settings;
  settings.slots = options.slots;
  settings.threads = options.cores;
  settings.picture_root = line.picture_root;
  settings.follow_links = line.follow_links;
  settings.allowed_trainers = SplitWords(line.allowed_trainers);
  settings.trainers_dir = Absolute(line.trainers_dir);
  settings.benchmarks_dir = Absolute(line.benchmarks_dir);
  settings.cores_dir = line.cores_dir.empty()
                           ? options.outbox_root + "/" + options.name + "/staging/cores"
                           : Absolute(line.cores_dir);
  settings.cache_dir = Absolute(line.cache_dir.empty() ? DefaultCache() : line.cache_dir);
  settings.cache_bytes = line.cache_gb << 30;
  return settings;
}

}  // namespace parallax
