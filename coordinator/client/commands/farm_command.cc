// farm: workers that come and go with the work, as a batch system gives them.
#include "coordinator/client/commands/farm_command.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>

#include "common/base/status.h"
#include "common/base/system/installation.h"
#include "common/config/files/engine_files.h"
#include "common/rpc/address.h"
#include "coordinator/client/farm/engine.h"
#include "coordinator/client/farm/keeper.h"
#include "coordinator/client/interrupt.h"
#include "coordinator/client/views/text.h"

namespace parallax::client {
namespace {

struct FarmOptions {
  FarmLimits limits{.max = 0};
  double interval_s = 30;
  int idle_s = 300;
  std::string engine;
  std::string script;
  std::string worker_tls;
  std::string job_name = "parallax";
  std::vector<std::string> submit;
  std::vector<std::string> worker_arguments;
  // What pilots get, by the placeholder of engine.proto; empty: as the script says.
  std::map<std::string, std::string> resources;
  bool dry_run = false;
  bool until_done = false;
  std::string at_end = "leave";
};

// Pilots start in folders of their own. "" stays so.
std::string PathForPilots(const std::string& path) {
  return path.empty() ? path : std::filesystem::absolute(path).lexically_normal().string();
}

std::string FarmVariable(const char* name) {
  const char* const value = std::getenv(name);
  return value == nullptr ? "" : value;
}

// Shortens what a signal leaves, so that the worker has ended before it is killed.
std::string GraceOf(int seconds) {
  return seconds == 0 ? "" : std::to_string(seconds - std::clamp(seconds / 3, 1, 30));
}

absl::Status SetResources(const FarmOptions& options, const v1::Engine& engine,
                          std::map<std::string, std::string>& values) {
  const v1::EngineSubmit& submit = engine.submit();
  const std::pair<std::string, int> words[] = {{"cores", submit.cores_size()},
                                               {"memory_mb", submit.memory_size()},
                                               {"wall_minutes", submit.wall_time_size()},
                                               {"log", submit.log_size()}};
  for (const auto& [name, count] : words) {
    const std::string& given = options.resources.at(name);
    if (given.empty()) continue;
    std::string option = name;
    std::replace(option.begin(), option.end(), '_', '-');
    if (count == 0) {
      return InvalidArgument("--{}: engine {} has no words for it", option, engine.name());
    }
    values[name] = given;
    if (name == "wall_minutes") values["wall_s"] = std::to_string(60 * std::stoll(given));
  }
  return absl::OkStatus();
}

absl::StatusOr<PilotOptions> PilotOptionsOf(const FarmOptions& options, const v1::Engine& engine,
                                            const Session& session) {
  if (!std::filesystem::is_regular_file(options.script)) {
    return InvalidArgument(
        "--script: there is no file {}; deploy/slurm/workers.sbatch and, for others, "
        "deploy/batch/workers.sh are the ones to start from",
        options.script);
  }
  if (options.limits.min > options.limits.max) {
    return InvalidArgument("--min {} is more than --max {}", options.limits.min,
                           options.limits.max);
  }
  if (!session.options.tls_dir.empty() && options.worker_tls.empty()) {
    return InvalidArgument(
        "--worker-tls: workers need a certificate of their own (`coordinator init DIR --issue "
        "worker pool` makes DIR/worker-pool)");
  }
  std::error_code error;
  if (!options.worker_tls.empty() && !std::filesystem::is_directory(options.worker_tls, error)) {
    return InvalidArgument("--worker-tls: there is no folder {}", options.worker_tls);
  }
  const int longest = engine.list().name_length();
  if (longest > 0 && std::ssize(options.job_name) > longest) {
    return InvalidArgument("--name {} is longer than the {} characters that {} shows",
                           options.job_name, longest, engine.list().command(0));
  }
  const auto& words = engine.submit().command();
  if (!options.submit.empty() &&
      std::find(words.begin(), words.end(), "{options}") == words.end()) {
    return InvalidArgument("--submit: engine {} has no {{options}} in submit.command",
                           engine.name());
  }
  PilotOptions pilots{.job_name = options.job_name,
                      .script = options.script,
                      .submit_options = options.submit,
                      .worker_arguments = options.worker_arguments};
  if (options.limits.slots_per_pilot > 1) {
    pilots.worker_arguments.insert(pilots.worker_arguments.begin(),
                                   {"--slots", std::to_string(options.limits.slots_per_pilot)});
  }
  pilots.values = {{"engine", engine.name()},
                   {"coordinator", session.options.coordinator},
                   {"tls", PathForPilots(options.worker_tls)},
                   // A variable's program may be one that only the pilots' machines have.
                   {"worker", FindProgram("worker").value_or(FarmVariable("PARALLAX_WORKER"))},
                   {"state", PathForPilots(FarmVariable("PARALLAX_STATE"))},
                   {"idle_s", std::to_string(options.idle_s)},
                   {"arguments", fmt::format("{}", fmt::join(pilots.worker_arguments, " "))},
                   {"grace_s", GraceOf(engine.signals().term_s())},
                   {"long_grace_s", GraceOf(engine.signals().usr1_s())}};
  RETURN_IF_ERROR(SetResources(options, engine, pilots.values));
  return pilots;
}

KeeperWorld WorldOf(Connection& connection, const BatchEngine& engine, Clock& clock) {
  KeeperWorld world;
  world.clock = &clock;
  world.studies = [&connection]() -> absl::StatusOr<std::vector<v1::StudyStatus>> {
    constexpr int kStudies = 1000;
    ASSIGN_OR_RETURN(const v1::ListStudiesReply reply, connection.ListStudies(kStudies));
    return std::vector<v1::StudyStatus>(reply.studies().begin(), reply.studies().end());
  };
  world.workers = [&connection]() -> absl::StatusOr<std::vector<v1::WorkerStatus>> {
    ASSIGN_OR_RETURN(const v1::ListWorkersReply reply, connection.ListWorkers());
    return std::vector<v1::WorkerStatus>(reply.workers().begin(), reply.workers().end());
  };
  world.pilots = [&engine] { return engine.Pilots(); };
  world.submit = [&engine](int pilots) { return engine.Submit(pilots); };
  world.cancel = [&engine](const std::vector<std::string>& ids) { return engine.Cancel(ids); };
  return world;
}

nlohmann::ordered_json StepJson(const KeeperStep& step) {
  return {{"jobs_waiting", step.view.demand.waiting},
          {"jobs_leased", step.view.demand.leased},
          {"other_slots", step.view.other_slots},
          {"pilots_running", step.decision.running},
          {"pilots_pending", step.decision.pending},
          {"pilots_wanted", step.decision.wanted},
          {"submit", step.decision.submit},
          {"array", step.array},
          {"paused_s", step.paused_s},
          {"cancel", step.decision.cancel}};
}

void Tell(const KeeperStep& step, Session& session) {
  if (session.options.json) {
    session.PrintJson(StepJson(step), /*one_line=*/true);
    return;
  }
  *session.out().stream << FormatUnixTime(session.environment.clock->UnixSeconds()) << "  "
                        << step.Line() << "\n"
                        << std::flush;
}

// Ends with the pilots that are left, as the person wanted.
absl::StatusOr<ExitCode> LeaveFarm(const FarmOptions& options, const BatchEngine& engine,
                                   Session& session) {
  ASSIGN_OR_RETURN(const std::vector<Pilot> pilots, engine.Pilots());
  std::vector<std::string> ids;
  for (const Pilot& pilot : pilots) {
    if (pilot.state != Pilot::State::kEnding) ids.push_back(pilot.id);
  }
  const std::string left = Plural(static_cast<int64_t>(ids.size()), "pilot");
  if (options.at_end == "cancel") {
    RETURN_IF_ERROR(engine.Cancel(ids));
    session.PrintNote("interrupted; cancelled " + left);
  } else {
    session.PrintNote("interrupted; " + left + " left, which end after " +
                      FormatDuration(options.idle_s) + " without work");
  }
  return kExitInterrupted;
}

absl::StatusOr<ExitCode> KeepFarm(const FarmOptions& options, Session& session) {
  ASSIGN_OR_RETURN(const v1::Engine file, LoadEngine(options.engine));
  ASSIGN_OR_RETURN(PilotOptions pilots, PilotOptionsOf(options, file, session));
  const BatchEngine engine(file, std::move(pilots));
  const auto address = ParseRpcAddress(session.options.coordinator);
  if (address.ok() && address->is_local()) {
    session.PrintNote("pilots are told the coordinator's address " + session.options.coordinator +
                      ", which only this machine reaches; name it by --coordinator HOST:PORT");
  }
  ASSIGN_OR_RETURN(const auto connection, session.Connect());
  FarmKeeper keeper({.limits = options.limits,
                     .worker_prefix = file.name() + "-",
                     .arrays = file.submit().array(),
                     .interval_s = options.interval_s},
                    WorldOf(*connection, engine, *session.environment.clock));
  // The first look's errors are the user's: a wrong address, no batch system here.
  absl::StatusOr<KeeperStep> step = keeper.Look(options.dry_run);
  if (!step.ok()) return step.status();
  Tell(*step, session);
  if (options.dry_run) {
    if (step->decision.submit > 0 && !session.options.json) {
      *session.out().stream << engine.SubmitCommand(step->decision.submit) << "\n";
    }
    return kExitOk;
  }
  InterruptScope interrupts;
  bool worked = step->view.demand.waiting + step->view.demand.leased > 0;
  std::string told;
  bool paused = false;
  while (!(options.until_done && worked && step.ok() && step->finished())) {
    if (interrupts.WaitFor(std::chrono::duration<double>(options.interval_s))) {
      return LeaveFarm(options, engine, session);
    }
    step = keeper.Look();
    if (!step.ok()) {
      // A restarting coordinator or a busy batch system does not end the farm. The same error is
      // reported once.
      const std::string error = FirstLine(ToStd(step.status().message()));
      if (error != told) session.PrintNote(error + "; tries again");
      told = error;
      continue;
    }
    told.clear();
    worked = worked || step->view.demand.waiting + step->view.demand.leased > 0;
    // Reports a pause once.
    if (step->did_something() && !(step->paused_s > 0 && paused)) Tell(*step, session);
    paused = step->paused_s > 0;
  }
  Tell(*step, session);
  return kExitOk;
}

void AddFarmOptions(CLI::App* command, FarmOptions& options) {
  AddOption(command, "ENGINE,--engine", "NAME|FILE", options.engine,
            "slurm, pbs, lsf, or the file of another batch system")
      ->required();
  AddOption(command, "--max", "N", options.limits.max, "Largest number of pilots")
      ->required()
      ->check(CLI::Range(1, 100000));
  AddOption(command, "--min", "N", options.limits.min,
            "Smallest number of pilots, also without work (default 0)")
      ->check(CLI::Range(0, 100000));
  AddOption(command, "--script", "FILE", options.script, "The batch script of a pilot")->required();
  AddOption(command, "--slots", "N", options.limits.slots_per_pilot,
            "Jobs that a pilot runs at once (default 1)")
      ->check(CLI::Range(1, 1024));
  AddOption(command, "--idle", "SECONDS", options.idle_s,
            "A pilot ends after this time without work (default 300)")
      ->check(CLI::Range(30, 86400));
  AddOption(command, "--interval", "SECONDS", options.interval_s,
            "Time between two checks of the queue (default 30)")
      ->check(CLI::Range(1.0, 3600.0));
  AddOption(command, "--worker-tls", "DIR", options.worker_tls,
            "Folder with the workers' certificate");
  AddOption(command, "--name", "NAME", options.job_name,
            "Name of the pilots' jobs; a restarted command finds its pilots by it\n"
            "(default parallax)");
  AddOption(command, "--sbatch,--submit", "OPTION", options.submit,
            "An option for sbatch, qsub..., as --sbatch=--partition=short; "
            "may be repeated")
      ->allow_extra_args(false);
  const struct {
    const char *name, *value, *type, *help;
    int most;
  } resources[] = {
      {"--cores", "cores", "N", "Cores of a pilot", 4096},
      {"--memory-mb", "memory_mb", "MB", "Memory of a pilot", 1 << 24},
      {"--wall-minutes", "wall_minutes", "MINUTES", "Longest time of a pilot", 1 << 20}};
  constexpr char kDefault[] = " (default: as the script says)";
  for (const auto& one : resources) {
    command->add_option(one.name, options.resources[one.value], std::string(one.help) + kDefault)
        ->type_name(one.type)
        ->check(CLI::Range(1, one.most));
  }
  AddOption(command, "--log", "FILE", options.resources["log"],
            std::string("File of a pilot's output") + kDefault);
  command->add_flag("--dry-run", options.dry_run,
                    "Check the queue once and print the decision without acting");
  command->add_flag("--until-done", options.until_done,
                    "End when there was work and neither work nor pilots are left");
  AddOption(command, "--at-end", "WHAT", options.at_end,
            "On Ctrl-C leave the pilots (they end when idle) or cancel them")
      ->check(CLI::IsMember({"leave", "cancel"}));
  command->add_option("WORKER_ARGUMENTS", options.worker_arguments,
                      "After --: arguments of the worker");
}

}  // namespace

void RegisterFarm(Registry& registry) {
  auto options = std::make_shared<FarmOptions>();
  CLI::App* farm = registry.AddCommand(
      registry.app, "farm",
      "Start and cancel workers in a batch system as the queue grows and shrinks",
      "Pilots (jobs of the batch system that run a worker) are submitted while jobs wait, also in\n"
      "place of killed ones. Pending pilots are cancelled when less work waits; running ones end\n"
      "by themselves when they are idle. Ctrl-C ends the command.\n"
      "\n"
      "Examples:\n"
      "  parallax farm slurm --max 40 --script deploy/slurm/workers.sbatch --dry-run\n"
      "  parallax farm slurm --max 40 --script workers.sbatch --sbatch=--partition=short\n"
      "  parallax farm slurm --min 2 --max 200 --script workers.sbatch --at-end cancel\n"
      "  parallax farm pbs --max 40 --script deploy/batch/workers.sh --cores 16 --memory-mb 32000\n"
      "  parallax farm --engine my-cluster.yaml --max 40 --script workers.sh\n");
  farm->group(kCoordinatorCommands);
  AddFarmOptions(farm, *options);
  registry.AddConnectionOptions(farm);
  registry.SetAction(farm, [options](Session& session) { return KeepFarm(*options, session); });
}

}  // namespace parallax::client
