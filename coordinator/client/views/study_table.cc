#include "coordinator/client/views/study_table.h"

#include <filesystem>
#include <map>

#include "common/base/system/file.h"
#include "common/store/store.h"
#include "coordinator/client/views/learning_curves.h"
#include "coordinator/client/views/table_options.h"
#include "worker/evaluate/group_errors.h"

namespace parallax::client {
namespace {

namespace fs = std::filesystem;

// Reads those of `files` that are in `dir`.
absl::StatusOr<std::vector<Evaluation>> ReadThoseIn(const std::string& dir,
                                                    const std::set<std::string>& files) {
  std::vector<Evaluation> all;
  for (const std::string& path : files) {
    if (fs::path(path).parent_path() != dir) continue;
    ASSIGN_OR_RETURN(Evaluation one, ReadEvaluation(path));
    all.push_back(std::move(one));
  }
  return all;
}

}  // namespace

absl::StatusOr<std::vector<std::string>> WriteGroupErrors(
    const std::vector<Evaluation>& evaluations, const std::string& dir) {
  RETURN_IF_ERROR(MakeFolders(dir));
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
    return NotFound(
        "no scores by class or material: they come from archives of Parallax (evaluate --on "
        "archive:DIR)");
  }
  return files;
}

absl::StatusOr<std::string> WriteStudyTable(const std::string& out_dir, const v1::StudySpec& study,
                                            const std::set<std::string>& score_files) {
  ASSIGN_OR_RETURN(const std::vector<Evaluation> evaluations,
                   ReadThoseIn(out_dir + "/scores", score_files));
  if (evaluations.empty()) return std::string();
  ASSIGN_OR_RETURN(const ResultTable table, MakeStudyTable(study, evaluations));
  std::string shown;
  for (const auto& [format, ending] :
       {std::pair("text", "txt"), std::pair("markdown", "md"), std::pair("json", "json")}) {
    ASSIGN_OR_RETURN(const std::string text, FormatTable(table, format));
    RETURN_IF_ERROR(WriteFileAtomically(out_dir + "/table." + ending, text));
    if (shown.empty()) shown = text;
  }
  const auto groups = WriteGroupErrors(evaluations, out_dir + "/errors");
  if (!groups.ok() && !absl::IsNotFound(groups.status())) return groups.status();
  ASSIGN_OR_RETURN(const std::vector<Evaluation> checkpoints,
                   ReadThoseIn(out_dir + "/curves", score_files));
  if (!checkpoints.empty()) {
    std::vector<Evaluation> curves = evaluations;
    curves.insert(curves.end(), checkpoints.begin(), checkpoints.end());
    RETURN_IF_ERROR(WriteLearningCurves(out_dir, curves));
  }
  return shown;
}

}  // namespace parallax::client
