// plan: what a study will take, before it is submitted.
#include <fmt/core.h>

#include <algorithm>
#include <istream>
#include <map>
#include <nlohmann/json.hpp>

#include "common/base/shell_word.h"
#include "common/base/system/cores.h"
#include "common/config/camera_text.h"
#include "coordinator/client/command.h"
#include "coordinator/client/content/machine_check.h"
#include "coordinator/client/content/study_options.h"
#include "coordinator/client/runs/plan.h"
#include "coordinator/client/runs/plan_power.h"
#include "coordinator/client/runs/shared_store.h"
#include "coordinator/client/runs/submit_study.h"
#include "coordinator/client/search/search_costs.h"
#include "coordinator/client/views/text.h"
#include "coordinator/client/views/text_table.h"
#include "coordinator/stream/stream_order.h"
#include "coordinator/study/expansion.h"
#include "coordinator/view/json_list.h"

namespace parallax::client {
namespace {

using Json = nlohmann::ordered_json;

struct PlanOptions {
  StudyOptions study;
  std::string from;
  int cores = UsableCores();
  MachineOptions machine;
  bool yes = false;
};

Json RowJson(const PlanRow& row) {
  return {{"name", row.name},
          {"pairs", row.pairs},
          {"scenes", row.scenes},
          {"solve_jobs", row.solve_jobs},
          {"render_jobs", row.render_jobs},
          {"layouts_shared", row.layouts_shared},
          {"scenes_shared", row.scenes_shared},
          {"pairs_shared", row.pairs_shared},
          {"solve_core_hours", row.solve_core_s / 3600},
          {"render_core_hours", row.render_core_s / 3600},
          {"core_hours", (row.solve_core_s + row.render_core_s) / 3600},
          {"disk_bytes", row.disk_bytes}};
}

// The differences that the study can show, and those with `more_seeds` in all.
struct Power {
  std::vector<BenchmarkPower> planned, more;
  int more_seeds = 0;
};

Power PowerOfStudy(const v1::StudySpec& study, const BenchmarkSizes& own,
                   const MeasuredSpreads& spreads) {
  const int more_seeds = std::max(study.train().seeds() + 1, study.train().seeds() * 3 / 2);
  return {PowerOf(study, own, spreads), PowerOf(study, own, spreads, more_seeds), more_seeds};
}

Json PowerJson(const BenchmarkPower& power, int seeds) {
  return {{"benchmark", power.benchmark},
          {"pairs", power.pairs},
          {"seeds", seeds},
          {"metric", power.metric},
          {"least_difference", power.least_difference},
          {"measured_here", power.measured_here}};
}

Json PlanJson(const v1::StudySpec& study, const StudyPlan& plan, const Power& power, int cores) {
  Json json = {{"name", study.name()}, {"variants", JsonList(plan.rows, RowJson)}};
  json["total"] = RowJson(plan.total);
  json["total"].erase("name");
  json["solves"] = plan.solves;
  json["solves_without_sharing"] = plan.solves_without_sharing;
  json["solves_saved"] = plan.solves_without_sharing - plan.solves;
  json["layouts_per_seed"] = plan.max_solves_per_seed;
  const TrainingPlan& training = plan.training;
  json["jobs"] =
      plan.total.solve_jobs + plan.total.render_jobs + training.trainings + training.evaluations;
  json["trainings"] = training.trainings;
  json["evaluations"] = training.evaluations;
  json["train_core_hours"] = training.train_core_s / 3600;
  json["evaluate_core_hours"] = training.evaluate_core_s / 3600;
  json["core_hours"] = (plan.total.solve_core_s + plan.total.render_core_s + training.train_core_s +
                        training.evaluate_core_s) /
                       3600;
  json["power"] = JsonList(power.planned, [&](const BenchmarkPower& one) {
    return PowerJson(one, study.train().seeds());
  });
  json["cores"] = cores;
  json["wall_clock_s"] = WallClockS(plan, cores);
  json["disk_bytes"] = plan.total.disk_bytes;
  json["costs"] = {{"from", plan.costs_from}, {"factor", plan.factor}};
  return json;
}

std::string Hours(double core_s) { return FormatNumber(core_s / 3600); }

void PrintTraining(const v1::StudySpec& study, const TrainingPlan& plan, const Terminal& out) {
  if (plan.trainings > 0) {
    *out.stream << "Trainings: " << FormatCount(plan.trainings) << " ("
                << Plural(plan.trainings / study.train().seeds(), "training set") << " x "
                << Plural(study.train().seeds(), "seed") << "), "
                << (plan.not_priced.empty()
                        ? Hours(plan.train_core_s) + " core-hours"
                        : "cost unknown: " + plan.not_priced + " has not been measured")
                << "\n";
  }
  if (plan.evaluations > 0) {
    *out.stream << "Evaluations: " << FormatCount(plan.evaluations) << ", "
                << Hours(plan.evaluate_core_s) << " core-hours\n";
  }
}

// The project has not measured the spread of logs, by which verdicts may be.
void PrintDecides(const v1::StudySpec& study, const std::vector<BenchmarkPower>& powers,
                  const Terminal& out) {
  const bool all_measured = std::all_of(
      powers.begin(), powers.end(), [](const BenchmarkPower& one) { return one.measured_here; });
  if (study.evaluate().decides() != "log" || all_measured) return;
  *out.stream << "Verdicts are by log; differences of bad-2 are those that it would tell\n";
}

// "6.2 points"
std::string LeastText(const BenchmarkPower& power) {
  const bool percent = power.metric.starts_with("bad-") || power.metric.starts_with("d1");
  const char* unit = percent ? "points" : power.metric.starts_with("log") ? "octaves" : "px";
  return fmt::format("{:.{}f} {}", power.least_difference, percent ? 1 : 2, unit);
}

void PrintPower(const v1::StudySpec& study, const StudyPlan& plan, const Power& power,
                const Terminal& out) {
  const int seeds = study.train().seeds();
  const double trained_s = plan.training.train_core_s + plan.training.evaluate_core_s;
  const double made_s = plan.total.solve_core_s + plan.total.render_core_s;
  const auto hours = [&](int with) { return Hours(made_s + trained_s * with / seeds); };
  for (size_t i = 0; i < power.more.size(); ++i) {
    const BenchmarkPower& more = power.more[i];
    *out.stream << "Significant on " << more.benchmark << " (" << Plural(more.pairs, "pair")
                << ", 80 of 100 times): ";
    *out.stream << (power.planned.empty()
                        ? "no difference with one seed, "
                        : fmt::format("differences of {} from {} with {} ({} core-hours), ",
                                      more.metric, LeastText(power.planned[i]),
                                      Plural(seeds, "seed"), hours(seeds)))
                << fmt::format("{} with {} ({})\n", LeastText(more), power.more_seeds,
                               hours(power.more_seeds));
  }
  PrintDecides(study, power.more, out);
}

void PrintPlan(const v1::StudySpec& study, const StudyPlan& plan, const Power& power, int cores,
               const Session& session) {
  const Terminal& out = session.out();
  *out.stream << out.Paint(Tone::kBold, study.name()) << ": " << DescribeSize(study) << "\n";
  Table table({"variant", Right("pairs"), Right("scenes"), Right("jobs"), Right("rooms shared"),
               Right("pairs shared"), Right("core-hours"), Right("disk")});
  const auto add = [&](const PlanRow& row) {
    table.AddRow({row.name, FormatCount(row.pairs), FormatCount(row.scenes),
                  FormatCount(row.solve_jobs + row.render_jobs), FormatCount(row.layouts_shared),
                  FormatCount(row.pairs_shared), Hours(row.solve_core_s + row.render_core_s),
                  FormatBytes(static_cast<double>(row.disk_bytes))});
  };
  for (const PlanRow& row : plan.rows) add(row);
  if (plan.rows.size() > 1) add(plan.total);
  table.Print(out, 2);
  PrintTraining(study, plan.training, out);
  PrintPower(study, plan, power, out);
  *out.stream << "Scenes to solve: " << FormatCount(plan.solves) << " ("
              << FormatCount(plan.solves_without_sharing - plan.solves) << " of "
              << FormatCount(plan.solves_without_sharing) << " solves saved by sharing)\n"
              << "Core-hours: " << Hours(plan.total.solve_core_s) << " to solve, "
              << Hours(plan.total.render_core_s) << " to render; disk "
              << FormatBytes(static_cast<double>(plan.total.disk_bytes)) << "\n"
              << "Time: " << FormatAbout(WallClockS(plan, cores)) << " on " << Plural(cores, "core")
              << "\n"
              << "Costs: " << plan.costs_from << "\n"
              << "Store of `run`: " << DescribeUsersStore() << "\n";
  for (const std::string& camera : DescribeCameras(study)) *out.stream << camera << "\n";
  *out.stream << std::flush;
}

// True to go on.
bool Ask(const PlanOptions& options, const Session& session) {
  if (options.yes) return true;
  std::istream* answers = session.environment.answers;
  if (answers == nullptr || !session.err().interactive) return false;
  *session.err().stream << "submit it? [y/N] " << std::flush;
  std::string answer;
  std::getline(*answers, answer);
  return answer == "y" || answer == "Y" || answer == "yes";
}

// The most chunks of a stream that are on the disk, beside those that keep_s keeps.
int64_t MostChunksOf(const v1::StudySpec& stream) { return UsesOf(stream) + ChunksAheadOf(stream); }

void PrintStream(const v1::StudySpec& stream, const StudyPlan& chunk, const Session& session) {
  const int64_t most = MostChunksOf(stream);
  *session.out().stream << "Endless: that is its first chunk; at most " << Plural(most, "chunk")
                        << " (" << FormatCount(most * ChunkPairsOf(stream)) << " pairs, "
                        << FormatBytes(static_cast<double>(most * chunk.total.disk_bytes))
                        << ") are kept"
                        << (KeepSecondsOf(stream) > 0
                                ? ", and those used up within " + FormatAbout(KeepSecondsOf(stream))
                                : "")
                        << ", and files stay six minutes longer; `parallax stream` begins it\n";
}

Json SearchPowersJson(const std::vector<SearchPower>& powers) {
  Json json = Json::array();
  for (const SearchPower& one : powers) {
    for (const BenchmarkPower& power : one.benchmarks) {
      json.push_back(PowerJson(power, one.seeds));
      json.back()["part"] = one.part;
    }
  }
  return json;
}

void PrintSearchPowers(const v1::StudySpec& study, const std::vector<SearchPower>& powers,
                       const Terminal& out) {
  std::vector<BenchmarkPower> all;
  for (const SearchPower& one : powers) {
    if (one.seeds < 2) {
      *out.stream << "Significant in " << one.part << ": no difference with one seed\n";
    }
    for (const BenchmarkPower& power : one.benchmarks) {
      all.push_back(power);
      *out.stream << fmt::format(
          "Significant on {} ({}, 80 of 100 times) in {}: differences of {} from {} with {}\n",
          power.benchmark, Plural(power.pairs, "pair"), one.part, power.metric, LeastText(power),
          Plural(one.seeds, "seed"));
    }
  }
  PrintDecides(study, all, out);
}

// Prices the rungs of a search, and says which differences its last rung and its confirmation can
// show.
absl::StatusOr<ExitCode> PlanSearch(const v1::StudySpec& study, const PlanOptions& options,
                                    double factor, const MeasuredSpreads& spreads,
                                    Session& session) {
  ASSIGN_OR_RETURN(const BenchmarkSizes own, SizesOfOwnBenchmarks(study));
  ASSIGN_OR_RETURN(const SearchCosts costs, CostsOfSearch(study, factor, own));
  ASSIGN_OR_RETURN(const std::vector<SearchPower> powers,
                   PowersOfSearch(study, costs, own, spreads));
  const std::vector<std::string> missing =
      WhatIsMissing(study, options.study.study, options.machine);
  if (session.options.json) {
    return session.PrintJson({{"name", study.name()},
                              {"search", SearchCostsJson(costs)},
                              {"core_hours", costs.total.core_hours()},
                              {"power", SearchPowersJson(powers)},
                              {"cores", options.cores},
                              {"costs", {{"factor", factor}}},
                              {"missing", missing}});
  }
  PrintSearchCosts(study, costs, session.out());
  PrintSearchPowers(study, powers, session.out());
  *session.out().stream << "Time: " << FormatAbout(3600 * costs.total.core_hours() / options.cores)
                        << " or more on " << Plural(options.cores, "core") << "\n"
                        << "`parallax search " << options.study.study << "` begins it\n"
                        << std::flush;
  PrintMissing(study, missing, session);
  return kExitOk;
}

absl::StatusOr<ExitCode> Plan(const PlanOptions& options, Session& session) {
  ASSIGN_OR_RETURN(v1::StudySpec study, ResolveStudy(options.study));
  RETURN_IF_ERROR(HashContent(study, FolderReaders::kOfFarm));
  const v1::StudySpec stream = study;
  if (options.yes && (study.has_stream() || study.has_search())) {
    return InvalidArgument(
        "--yes: study '{}' is {} and is not submitted; `parallax {} {}` begins it", study.name(),
        study.has_stream() ? "endless" : "a search", study.has_stream() ? "stream" : "search",
        ShellWord(options.study.study));
  }
  if (stream.has_stream()) {
    study = ChunkStudy(stream, 0);
    study.set_name(stream.name());
  }
  double factor = 1;
  MeasuredSpreads spreads;
  if (!options.from.empty()) {
    ASSIGN_OR_RETURN(factor, ReadMeasuredFactor(options.from));
    ASSIGN_OR_RETURN(spreads, ReadSpreads(options.from, study));
  }
  if (study.has_search()) return PlanSearch(study, options, factor, spreads, session);
  ASSIGN_OR_RETURN(const BenchmarkSizes own, SizesOfOwnBenchmarks(study));
  ASSIGN_OR_RETURN(StudyPlan plan, PlanStudy(study, factor, own));
  const Power power = PowerOfStudy(study, own, spreads);
  plan.costs_from = options.from.empty()
                        ? "measured with the generator's benchmarks on one machine; --from DIR "
                          "takes those of your own pairs"
                        : "of the pairs in " + options.from + ", " + FormatNumber(factor) +
                              " times the benchmarks'";
  const bool json = session.options.json;
  const std::vector<std::string> missing =
      WhatIsMissing(study, options.study.study, options.machine);
  if (!json) {
    PrintPlan(study, plan, power, options.cores, session);
    PrintMissing(stream, missing, session);
    if (stream.has_stream()) PrintStream(stream, plan, session);
  }
  const bool submit = !stream.has_stream() && (json ? options.yes : Ask(options, session));
  Json printed = PlanJson(study, plan, power, options.cores);
  printed["missing"] = missing;
  if (stream.has_stream()) {
    printed["stream"] = {{"chunk_pairs", ChunkPairsOf(stream)},
                         {"chunks_kept", MostChunksOf(stream)},
                         {"disk_bytes", MostChunksOf(stream) * plan.total.disk_bytes}};
  }
  if (submit) {
    ASSIGN_OR_RETURN(const auto connection, session.Connect());
    ASSIGN_OR_RETURN(const Submitted submitted,
                     SubmitStudy({.study = study}, *connection, *session.environment.clock));
    const v1::SubmitReply& reply = submitted.reply;
    printed["study_id"] = reply.study_id();
    printed["existed"] = reply.existed();
    *session.err().stream << (reply.existed() ? "is there already" : "submitted") << " as study "
                          << reply.study_id() << "; follow it with `parallax watch "
                          << reply.study_id() << "`\n";
  }
  if (json) session.PrintJson(printed);
  return kExitOk;
}

}  // namespace

void RegisterPlan(Registry& registry) {
  CLI::App* command = registry.AddCommand(
      registry.app, "plan", "Estimate the cost of a study, and submit it if you like",
      "Variants, scenes, jobs, rooms that variants share, core-hours, time and disk. Asks before\n"
      "it submits; --yes submits at once. Without a terminal it submits nothing.\n"
      "\n"
      "Examples:\n"
      "  parallax plan table1\n"
      "  parallax plan table1 --pairs 8 --width 320 --height 180 --json\n"
      "  parallax plan table1 --cores 640             on a farm\n"
      "  parallax plan table1 --from out/quickstart   costs as measured on this machine\n");
  auto options = std::make_shared<PlanOptions>();
  options->study.takes_endless = options->study.takes_search = true;
  AddStudyOptions(*command, options->study);
  AddOption(command, "--from", "DIR", options->from,
            "Take costs and variances from the pairs and scores of this dataset");
  command
      ->add_option("--cores", options->cores,
                   "Number of cores for the estimate of the time (default: this machine's)")
      ->check(CLI::Range(1, 10'000'000));
  AddMachineOptions(*command, options->machine);
  command->add_flag("-y,--yes", options->yes, "Submit without asking");
  registry.AddConnectionOptions(command);
  registry.SetAction(command, [options](Session& session) { return Plan(*options, session); });
}

}  // namespace parallax::client
