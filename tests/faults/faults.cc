// The fault experiments of the job system. See README.md; `faults --help` lists them. Each prints
// one line of JSON and ends with 0 when nothing was lost or doubled and the auditor was content.
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
    {"daemon-file-points",
     "6: kill -9 of worker and coordinator at each operation on outputs, outbox and store",
     DaemonFilePoints},
    {"kill-coordinator", "3: kill -9 of the coordinator under load", KillCoordinator},
    {"outbox", "3: a worker dies with finished work that nobody was there to take", Outboxes},
    {"lost-replies", "4: a fifth of all replies is lost after the commit", LostReplies},
    {"partitions", "5: stalls, half-open streams, cuts and partitions", Partitions},
    {"poison", "7: jobs that crash, hang and eat memory; a worker that fails everything", Poison},
    {"invariance", "10: the real study in peace and under all of it: the same dataset", Invariance},
    {"versions", "9: an older release's worker and database; with --old, its programs under load",
     Versions},
    {"strangers", "11: crowds, endless requests and slow callers at both ports", Strangers},
    {"simulate", "12: the whole job system in one thread, decided by a seed", Simulate},
    {"simulate-controls", "12: switches guards off; each must be found within 200 seeds",
     SimulateControls},
    {"simulate-growth", "12: one long life of the coordinator, whose memory must not grow",
     SimulateGrowth},
};

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
  for (const Entry& entry : kExperiments) {
    CLI::App* command = app.add_subcommand(entry.name, entry.help);
    command->add_option("--rounds", options.rounds, "Rounds, each from its own seed (default 1)");
    command->add_option("--seed", options.seed, "Of all that is drawn (default 1)");
    command->add_flag("--full", options.full, "Every point instead of a sample of each round's");
    command->add_option("--jobs", options.jobs, "Size of the study, where it can be chosen");
    command->add_option(
        "--old", options.old_bin,
        "versions: folder with `coordinator` and `noop_worker` of an older release");
    command->add_option("--seconds", options.seconds,
                        "invariance: seconds of kills and stops (default 20)");
    command->add_option("--seeds", options.seeds,
                        "simulate: the first and the last, as in 1..1000");
    command->add_option("--new", options.new_seeds,
                        "simulate: the kept seeds, then so many that are new each time");
    command->add_flag("--trace", options.trace, "simulate: tell what happens in these seeds");
    command->add_option("--events", options.events,
                        "simulate-growth: through which the coordinator lives (default 100000)");
    command->add_option("--guard", options.guard, "simulate-controls: switch this one off");
    command->add_option("--rows", options.rows, "kill-coordinator: jobs in the database before");
  }
  CLI11_PARSE(app, argc, argv);

  InitLogging({.level = LogLevel::kError, .program = "faults"});
  const auto begin = std::chrono::steady_clock::now();
  const auto wall_s = [&] {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  };
  const std::string line = CommandLine(argc, argv);
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
