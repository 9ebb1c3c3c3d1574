// table: what trains well, from score files.
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>

#include "common/base/edit_distance.h"
#include "common/base/status.h"
#include "common/base/system/file.h"
#include "common/base/system/temporary_folder.h"
#include "common/config/config.h"
#include "coordinator/client/commands/evaluate_command.h"
#include "coordinator/client/runs/study_results.h"
#include "coordinator/client/views/study_table.h"
#include "coordinator/client/views/table_options.h"
#include "worker/evaluate/score_table.h"

namespace parallax::client {
namespace {

struct TableCommandOptions {
  std::string dir;
  std::string format = "text";
  std::string out, pictures;
  std::string decides;  // Empty: as the study says.
  TableOptions table;
};

// Scores of a folder, or of a coordinator's study; `table` gets the study's order and reference.
absl::StatusOr<std::vector<Evaluation>> FindScores(const TableCommandOptions& options,
                                                   TableOptions& table, Session& session) {
  const std::string& what = options.dir;
  std::error_code error;
  v1::StudySpec study;
  std::string dir = what;
  if (std::filesystem::is_directory(what, error)) {
    const std::string lock = what + "/study.lock.yaml";
    const auto loaded = std::filesystem::exists(lock, error)
                            ? LoadStudy(lock)
                            : absl::StatusOr<v1::StudySpec>(NotFound(""));
    if (loaded.ok()) study = *loaded;
  }
  std::optional<TemporaryFolder> brought;
  if (!std::filesystem::exists(what, error)) {
    ASSIGN_OR_RETURN(const auto connection, session.ConnectInPlaceOf(what));
    const absl::StatusOr<v1::StudyStatus> found = connection->FindStudy(what);
    if (!found.ok()) {
      return MakeError(found.status().code(), what + ": no such folder here, and " +
                                                  std::string(ToStd(found.status().message())));
    }
    const v1::StudyStatus& status = *found;
    study = status.spec();
    ASSIGN_OR_RETURN(brought, TemporaryFolder::Make("table"));
    dir = brought->path();
    ASSIGN_OR_RETURN(const auto results, StudyResults::Open(dir, study));
    RETURN_IF_ERROR(results->CatchUp(*connection, status.study_id(), /*only_scores=*/true));
  }
  const TableOptions of_study = TableOptionsOf(study);
  if (table.variant_order.empty()) table.variant_order = of_study.variant_order;
  table.weigh_groups = table.weigh_groups || of_study.weigh_groups;
  table.decide_by_log = options.decides.empty() ? of_study.decide_by_log : options.decides == "log";
  absl::StatusOr<std::vector<Evaluation>> scores = ReadEvaluations(dir);
  // The study's reference may have no scores yet.
  if (table.baseline.empty() && scores.ok() &&
      std::any_of(scores->begin(), scores->end(), [&](const Evaluation& evaluation) {
        return evaluation.run.variant == of_study.baseline;
      })) {
    table.baseline = of_study.baseline;
  }
  // The folder is gone when the user reads of it.
  if (brought && absl::IsNotFound(scores.status())) {
    return NotFound("study {} has no scores yet", what);
  }
  return scores;
}

// Checks that the variants of --order are among those that have scores.
absl::Status CheckOrder(const std::vector<std::string>& order,
                        const std::vector<Evaluation>& evaluations) {
  std::set<std::string> known;
  for (const Evaluation& evaluation : evaluations) known.insert(evaluation.run.variant);
  for (const std::string& variant : order) {
    if (known.count(variant) > 0) continue;
    return InvalidArgument("--order: no variant '{}' has scores{} (there are {})", variant,
                           NearestHint(variant, {known.begin(), known.end()}),
                           fmt::join(known, ", "));
  }
  return absl::OkStatus();
}

absl::StatusOr<ExitCode> MakeTables(const TableCommandOptions& options, Session& session) {
  const std::string format = session.options.json ? "json" : options.format;
  TableOptions table_options = options.table;
  ASSIGN_OR_RETURN(const std::vector<Evaluation> evaluations,
                   FindScores(options, table_options, session));
  RETURN_IF_ERROR(CheckOrder(options.table.variant_order, evaluations));
  ASSIGN_OR_RETURN(const ResultTable table, MakeTable(evaluations, table_options));
  ASSIGN_OR_RETURN(const std::string text, FormatTable(table, format));
  if (options.out.empty()) {
    *session.out().stream << text << std::flush;
  } else {
    RETURN_IF_ERROR(WriteFile(options.out, text));
    *session.out().stream << options.out << "\n";
  }
  if (!options.pictures.empty()) {
    ASSIGN_OR_RETURN(const auto files, WriteGroupErrors(evaluations, options.pictures));
    for (const std::string& file : files) *session.err().stream << file << "\n";
  }
  return kExitOk;
}

}  // namespace

void RegisterTable(Registry& registry) {
  CLI::App* command = registry.AddCommand(
      registry.app, "table", "Make the table of score files: figures, intervals, verdicts",
      "A row for each variant and trainer, averaged over its seeds; a column for each benchmark.\n"
      "Intervals hold 95 % of what other seeds and other pictures would give. Each row is "
      "compared\n"
      "with the baseline, paired by picture and seed: better, worse or not significant, and how "
      "many\n"
      "more seeds would decide.\n"
      "\n"
      "Examples:\n"
      "  parallax table scores\n"
      "  parallax table out/table1\n"
      "  parallax table table1 --json         of the coordinator's study of that name\n"
      "  parallax table scores --baseline default --format markdown --out table.md\n"
      "  parallax table scores --json | jq '.comparisons[] | {variant, benchmark, verdict}'\n"
      "  parallax table scores --pictures out/errors     errors by class and material\n");
  auto options = std::make_shared<TableCommandOptions>();
  command
      ->add_option(
          "STUDY|DIR", options->dir,
          "A folder with score files, in it or below; or a study of the coordinator, by id "
          "or name")
      ->required();
  AddOption(command, "-f,--format", "FORMAT", options->format,
            "text (default), markdown, latex, csv or json")
      ->check(CLI::IsMember(TableFormats()));
  AddOption(command, "--baseline", "VARIANT", options->table.baseline,
            "The variant that all are compared with (default: `default`, `baseline`, or the "
            "first)");
  AddOption(command, "--order", "VARIANTS", options->table.variant_order,
            "Variants in the order of the rows; others follow by name")
      ->delimiter(',');
  AddOption(command, "--decides", "FIGURE", options->decides,
            "The figure whose differences are called better or worse: shown, or log, the "
            "mean logarithm of the error (default: as `evaluate.decides` of the study, else "
            "shown)")
      ->check(CLI::IsMember({"shown", "log"}));
  command->add_flag("--weigh-groups", options->table.weigh_groups,
                    "Let each set of pairs (mb2006_..., or `group:` in a list) count alike in the "
                    "mean, instead of each pair, as `evaluate.weigh_groups` of a study");
  AddOption(command, "-o,--out", "FILE", options->out, "Write it to this file");
  AddOption(command, "--pictures", "DIR2", options->pictures,
            "Also write errors by class and material, as PNG and CSV, into this folder");
  registry.AddConnectionOptions(command);
  registry.SetAction(command,
                     [options](Session& session) { return MakeTables(*options, session); });
}

}  // namespace parallax::client
