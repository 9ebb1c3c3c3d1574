// table: what trains well, from score files.
#include "worker/evaluate/table.h"

#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>

#include "common/base/file.h"
#include "coordinator/client/commands/evaluate.h"
#include "worker/evaluate/group_errors.h"

namespace parallax::client {
namespace {

struct TableCommandOptions {
  std::string dir;
  std::string format = "text";
  std::string out, pictures;
  TableOptions table;
};

// Errors by class and material of each variant, over all its seeds and benchmarks that have them.
absl::StatusOr<std::vector<std::string>> WriteGroups(const std::vector<Evaluation>& evaluations,
                                                     const std::string& dir) {
  std::error_code error;
  std::filesystem::create_directories(dir, error);
  if (error) return ErrnoError(error.value(), "make " + dir);
  std::map<std::string, std::vector<Evaluation>> by_row;
  for (const Evaluation& one : evaluations) {
    by_row[one.run.variant + "." + one.run.trainer].push_back(one);
  }
  std::vector<std::string> files;
  for (const auto& [row, its] : by_row) {
    for (const std::string group : {"class", "material"}) {
      const auto errors = GroupErrors(its, group);
      if (!errors.ok()) continue;
      const std::string name = dir + "/" + row + ".by_" + group;
      RETURN_IF_ERROR(WriteFile(name + ".csv", GroupErrorsCsv(*errors)));
      RETURN_IF_ERROR(DrawGroupErrors(*errors, "Error by " + group + ": " + row, name + ".png"));
      files.insert(files.end(), {name + ".csv", name + ".png"});
    }
  }
  if (files.empty()) {
    return MakeError(absl::StatusCode::kNotFound,
                     "no scores by class or material: they come from archives of Parallax "
                     "(evaluate --on archive:DIR)");
  }
  return files;
}

absl::StatusOr<ExitCode> MakeTables(const TableCommandOptions& options, Session& session) {
  const std::string format = session.options.json ? "json" : options.format;
  ASSIGN_OR_RETURN(const std::vector<Evaluation> evaluations, ReadEvaluations(options.dir));
  ASSIGN_OR_RETURN(const ResultTable table, MakeTable(evaluations, options.table));
  ASSIGN_OR_RETURN(const std::string text, FormatTable(table, format));
  if (options.out.empty()) {
    *session.out().stream << text << std::flush;
  } else {
    RETURN_IF_ERROR(WriteFile(options.out, text));
    *session.out().stream << options.out << "\n";
  }
  if (!options.pictures.empty()) {
    ASSIGN_OR_RETURN(const auto files, WriteGroups(evaluations, options.pictures));
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
      "with the baseline, paired by picture and seed: better, worse or not told apart, and how "
      "many\n"
      "more seeds would tell.\n"
      "\n"
      "Examples:\n"
      "  parallax table scores\n"
      "  parallax table scores --baseline default --format markdown --out table.md\n"
      "  parallax table scores --json | jq '.comparisons[] | {variant, benchmark, verdict}'\n"
      "  parallax table scores --pictures out/errors     errors by class and material\n");
  command->group(kLocalCommands);
  auto options = std::make_shared<TableCommandOptions>();
  command->add_option("DIR", options->dir, "Score files, in it or in folders below")->required();
  command
      ->add_option("-f,--format", options->format, "text (default), markdown, latex, csv or json")
      ->type_name("FORMAT")
      ->check(CLI::IsMember(TableFormats()));
  command
      ->add_option("--baseline", options->table.baseline,
                   "The variant that all are compared with (default: `default`, `baseline`, or the "
                   "first)")
      ->type_name("VARIANT");
  command
      ->add_option("--order", options->table.variant_order,
                   "Variants in the order of the rows; others follow by name")
      ->delimiter(',')
      ->type_name("VARIANTS");
  command->add_option("-o,--out", options->out, "Write it to this file")->type_name("FILE");
  command
      ->add_option("--pictures", options->pictures,
                   "Also write errors by class and material, as PNG and CSV, into this folder")
      ->type_name("DIR2");
  registry.AddJsonOption(command);
  registry.SetAction(command,
                     [options](Session& session) { return MakeTables(*options, session); });
}

}  // namespace parallax::client
