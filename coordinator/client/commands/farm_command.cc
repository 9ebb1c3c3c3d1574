// farm slurm: workers that come and go with the work, as a batch system gives them.
#include "coordinator/client/commands/farm_command.h"

#include <fmt/core.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "common/base/status.h"
#include "coordinator/client/farm/keeper.h"
#include "coordinator/client/farm/slurm.h"
#include "coordinator/client/interrupt.h"
#include "coordinator/client/views/text.h"

namespace parallax::client {
namespace {

struct FarmOptions {
  FarmLimits limits{.max = 0};
  double interval_s = 30;
  int idle_s = 300;
  std::string script;
  std::string worker_tls;
  std::string job_name = "parallax";
  std::vector<std::string> sbatch;
  std::vector<std::string> worker_arguments;
  bool dry_run = false;
  bool until_done = false;
  std::string at_end = "leave";
};

absl::StatusOr<SlurmOptions> SlurmOptionsOf(const FarmOptions& options, const Session& session) {
  if (!std::filesystem::is_regular_file(options.script)) {
    return InvalidArgument(
        "--script: there is no file {}; deploy/slurm/workers.sbatch is the one to start from",
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
  SlurmOptions slurm{.job_name = options.job_name,
                     .script = options.script,
                     .sbatch_options = options.sbatch,
                     .worker_arguments = options.worker_arguments};
  slurm.environment = {"PARALLAX_COORDINATOR=" + session.options.coordinator,
                       "PARALLAX_TLS=" + options.worker_tls,
                       fmt::format("PARALLAX_IDLE={}", options.idle_s)};
  if (options.limits.slots_per_pilot > 1) {
    slurm.worker_arguments.insert(slurm.worker_arguments.begin(),
                                  {"--slots", std::to_string(options.limits.slots_per_pilot)});
  }
  return slurm;
}

KeeperWorld WorldOf(Connection& connection, const Slurm& slurm, Clock& clock) {
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
  world.pilots = [&slurm] { return slurm.Pilots(); };
  world.submit = [&slurm](int pilots) { return slurm.Submit(pilots); };
  world.cancel = [&slurm](const std::vector<std::string>& ids) { return slurm.Cancel(ids); };
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
absl::StatusOr<ExitCode> LeaveFarm(const FarmOptions& options, const Slurm& slurm,
                                   Session& session) {
  ASSIGN_OR_RETURN(const std::vector<Pilot> pilots, slurm.Pilots());
  std::vector<std::string> ids;
  for (const Pilot& pilot : pilots) {
    if (pilot.state != Pilot::State::kEnding) ids.push_back(pilot.id);
  }
  const std::string left = Plural(static_cast<int64_t>(ids.size()), "pilot");
  if (options.at_end == "cancel") {
    RETURN_IF_ERROR(slurm.Cancel(ids));
    session.PrintNote("interrupted; cancelled " + left);
  } else {
    session.PrintNote("interrupted; " + left + " left, which end after " +
                      FormatDuration(options.idle_s) + " without work");
  }
  return kExitInterrupted;
}

absl::StatusOr<ExitCode> KeepFarm(const FarmOptions& options, Session& session) {
  ASSIGN_OR_RETURN(SlurmOptions slurm_options, SlurmOptionsOf(options, session));
  const Slurm slurm(std::move(slurm_options));
  ASSIGN_OR_RETURN(const auto connection, session.Connect());
  FarmKeeper keeper({.limits = options.limits, .interval_s = options.interval_s},
                    WorldOf(*connection, slurm, *session.environment.clock));
  // The first look's errors are the user's: a wrong address, no Slurm here.
  absl::StatusOr<KeeperStep> step = keeper.Look(options.dry_run);
  if (!step.ok()) return step.status();
  Tell(*step, session);
  if (options.dry_run) {
    if (step->decision.submit > 0 && !session.options.json) {
      *session.out().stream << slurm.SubmitCommand(step->decision.submit) << "\n";
    }
    return kExitOk;
  }
  InterruptScope interrupts;
  bool worked = step->view.demand.waiting + step->view.demand.leased > 0;
  std::string told;
  bool paused = false;
  while (!(options.until_done && worked && step.ok() && step->finished())) {
    if (interrupts.WaitFor(std::chrono::duration<double>(options.interval_s))) {
      return LeaveFarm(options, slurm, session);
    }
    step = keeper.Look();
    if (!step.ok()) {
      // A restarting coordinator or a busy Slurm does not end the farm. The same error is reported
      // once.
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
  command->add_option("--max", options.limits.max, "Largest number of pilots")
      ->type_name("N")
      ->required()
      ->check(CLI::Range(1, 100000));
  command
      ->add_option("--min", options.limits.min,
                   "Smallest number of pilots, also without work (default 0)")
      ->type_name("N")
      ->check(CLI::Range(0, 100000));
  command->add_option("--script", options.script, "The batch script of a pilot")
      ->type_name("SBATCH")
      ->required();
  command
      ->add_option("--slots", options.limits.slots_per_pilot,
                   "Jobs that a pilot runs at once (default 1)")
      ->type_name("N")
      ->check(CLI::Range(1, 1024));
  command
      ->add_option("--idle", options.idle_s, "A pilot ends after this without work (default 300)")
      ->type_name("SECONDS")
      ->check(CLI::Range(30, 86400));
  command->add_option("--interval", options.interval_s, "Between two looks (default 30)")
      ->type_name("SECONDS")
      ->check(CLI::Range(1.0, 3600.0));
  command->add_option("--worker-tls", options.worker_tls, "Folder with the workers' certificate")
      ->type_name("DIR");
  command
      ->add_option("--name", options.job_name,
                   "Name of the jobs, by which they are found again (default parallax)")
      ->type_name("NAME");
  command
      ->add_option("--sbatch", options.sbatch,
                   "An option for sbatch, as --sbatch=--partition=short; "
                   "may be repeated")
      ->type_name("OPTION")
      ->allow_extra_args(false);
  command->add_flag("--dry-run", options.dry_run, "Look once, say what would be done, do nothing");
  command->add_flag("--until-done", options.until_done,
                    "End when there was work and neither work nor pilots are left");
  command
      ->add_option("--at-end", options.at_end,
                   "What Ctrl-C does to pilots: leave (they end when idle) or cancel")
      ->type_name("WHAT")
      ->check(CLI::IsMember({"leave", "cancel"}));
  command->add_option("WORKER_ARGUMENTS", options.worker_arguments,
                      "After --: arguments of the worker");
}

}  // namespace

void RegisterFarm(Registry& registry) {
  CLI::App* farm = registry.AddCommand(registry.app, "farm", "Keep workers in step with the work");
  farm->require_subcommand(1);
  farm->group(kCoordinatorCommands);
  auto options = std::make_shared<FarmOptions>();
  CLI::App* slurm = registry.AddCommand(
      *farm, "slurm", "Keep a Slurm array of workers in step with the queue, from none to --max",
      "Pilots (array tasks that run a worker) are submitted while jobs wait, also in place of "
      "those\n"
      "that Slurm killed; those that still wait are cancelled when there is less to do; those "
      "that\n"
      "run end by themselves when they are idle. Ctrl-C ends the keeper.\n"
      "\n"
      "Examples:\n"
      "  parallax farm slurm --max 40 --script deploy/slurm/workers.sbatch --dry-run\n"
      "  parallax farm slurm --max 40 --script workers.sbatch --sbatch=--partition=short\n"
      "  parallax farm slurm --min 2 --max 200 --script workers.sbatch --at-end cancel\n");
  AddFarmOptions(slurm, *options);
  registry.AddConnectionOptions(slurm);
  registry.SetAction(slurm, [options](Session& session) { return KeepFarm(*options, session); });
}

}  // namespace parallax::client
