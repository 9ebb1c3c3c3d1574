// The fault experiments of the job system. See README.md; `faults --help` lists them. Each prints
// one line of JSON and ends with 0 when nothing was lost or doubled and the auditor was content.
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <iostream>
#include <nlohmann/json.hpp>

#include "common/base/system/log.h"
#include "common/base/version.h"
#include "tests/faults/experiment.h"

namespace parallax::faults {
namespace {

struct Entry {
  const char* name;
  const char* help;
  Experiment run;
};

const Entry kExperiments[] = {
    {"fail-points", "6: kill -9 at each step of each command of the queue", FailPoints},
    {"file-points", "6: kill -9 at each operation on the queue's files", FilePoints},
    {"daemon-file-points",
     "6: kill -9 of worker and coordinator at each operation on outputs, outbox and store",
     DaemonFilePoints},
    {"zombie", "1: a stopped worker wakes when its jobs are done by others", Zombie},
    {"kill-coordinator", "3: kill -9 of the coordinator under load", KillCoordinator},
    {"outbox", "3: a worker dies with finished work that nobody was there to take", Outboxes},
    {"lost-replies", "4: a fifth of all replies is lost after the commit", LostReplies},
    {"partitions", "5: stalls, half-open streams, cuts and partitions", Partitions},
    {"clock-jumps", "5: wall clocks jump by up to an hour", ClockJumps},
    {"poison", "7: jobs that crash, hang and eat memory; a worker that fails everything", Poison},
    {"invariance", "10: the real study in peace and under all of it: the same dataset", Invariance},
    {"versions", "9: an older release's worker and database; with --old, its programs under load",
     Versions},
    {"strangers", "11: crowds, endless requests and slow callers at both ports", Strangers},
    {"simulate", "12: the whole job system in one thread, decided by a seed", Simulate},
    {"simulate-controls", "12: switches guards off; each must be found within 200 seeds",
     SimulateControls},
    {"power-cut", "2: power cuts; what was not synced is lost in part and out of order", PowerCut},
};

// An experiment that must fail when its guard is switched off.
struct Control {
  const char* sabotage;
  const char* help;
  Experiment run;
};
const Control kControls[] = {
    {"synchronous-off", "the database without fsync, under power cuts", PowerCut},
    {"no-fence-check", "reports under any fence are accepted", PowerCut},
    {"no-epoch-bump", "a start goes on with the last epoch", PowerCut},
    {"no-outbox", "what a dead worker had finished is forgotten", Outboxes},
};

constexpr int kQueueStopsItself = 70;  // coordinator/queue/writer.cc

std::string CommandLine(int argc, char** argv) {
  std::string line;
  for (int i = 0; i < argc; ++i) line += (i ? " " : "") + std::string(argv[i]);
  return line;
}

int Report(const std::string& name, const Tally& tally, double wall_s, const std::string& command) {
  nlohmann::ordered_json json = {{"experiment", name},
                                 {"rounds", tally.rounds},
                                 {"faults", tally.faults},
                                 {"jobs", tally.jobs},
                                 {"lost", tally.lost},
                                 {"doubled", tally.doubled},
                                 {"audit_findings", tally.findings}};
  for (const auto& [figure, value] : tally.figures) json[figure] = value;
  json["wall_s"] = wall_s;
  json["version"] = kProgramVersion;
  json["command"] = command;
  for (const std::string& complaint : tally.complaints) std::cerr << complaint << std::endl;
  std::cout << json.dump() << std::endl;
  return tally.clean() ? 0 : 1;
}

int Main(int argc, char** argv) {
  CLI::App app("Breaks the job system on purpose and looks for what was lost or done twice.");
  app.require_subcommand(1);
  ExperimentOptions options;
  const auto declare = [&](const char* name, const char* help) {
    CLI::App* command = app.add_subcommand(name, help);
    command->add_option("--rounds", options.rounds, "Rounds, each from its own seed (default 1)");
    command->add_option("--seed", options.seed, "Of all that is drawn (default 1)");
    command->add_flag("--full", options.full, "Every point instead of a sample of each round's");
    command->add_option("--jobs", options.jobs, "Size of the study, where it can be chosen");
    command->add_option(
        "--old", options.old_bin,
        "versions: folder with `coordinator` and `noop_worker` of an older release");
    command->add_option("--seconds", options.seconds,
                        "invariance: seconds of kills and stops (default 20); simulate: run kept "
                        "seeds, then new ones for so long");
    command->add_option("--seeds", options.seeds,
                        "simulate: the first and the last, as in 1..1000");
    command->add_flag("--trace", options.trace, "simulate: tell what happens with --seed");
    command->add_option("--rows", options.rows, "kill-coordinator: jobs in the database before");
    return command;
  };
  for (const Entry& entry : kExperiments) declare(entry.name, entry.help);
  std::string control_name;
  CLI::App* control_command =
      declare("control", "Switches a guard off and ends with 0 if the experiment notices");
  std::string control_help = "One of:";
  for (const Control& control : kControls) {
    control_help += std::string(" ") + control.sabotage + " (" + control.help + ");";
  }
  control_command->add_option("GUARD", control_name, control_help)->required();
  CLI11_PARSE(app, argc, argv);

  InitLogging({.level = LogLevel::kError, .program = "faults"});
  const auto begin = std::chrono::steady_clock::now();
  const auto wall_s = [&] {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  };
  const std::string line = CommandLine(argc, argv);
  if (control_command->parsed()) {
    for (const Control& control : kControls) {
      if (control.sabotage != control_name) continue;
      options.sabotage = control_name;
      const int end = InChild([&] {
        Tally tally;
        control.run(options, tally);
        _exit(Report("control " + control_name, tally, wall_s(), line) != 0 ? 0 : 1);
      });
      // A queue that stops itself before a damaged database has noticed, too.
      const bool noticed = end == 0 || end == kQueueStopsItself;
      std::cerr << (noticed ? "noticed, as it must be"
                            : "NOT NOTICED: ended with " + std::to_string(end))
                << std::endl;
      return noticed ? 0 : 1;
    }
    std::cerr << "no such guard; " << control_help << std::endl;
    return 2;
  }
  for (const Entry& entry : kExperiments) {
    if (!app.got_subcommand(entry.name)) continue;
    Tally tally;
    entry.run(options, tally);
    return Report(entry.name, tally, wall_s(), line);
  }
  return 2;
}

}  // namespace
}  // namespace parallax::faults

int main(int argc, char** argv) { return parallax::faults::Main(argc, argv); }
