#include "coordinator/client/runs/study_results.h"

#include <fmt/core.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "common/base/hash.h"
#include "common/base/names.h"
#include "common/base/system/file.h"
#include "common/config/training_plan.h"
#include "common/store/store.h"

namespace parallax::client {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr int kResultsAtOnce = 200;

// A link or copy of `from`; a file with that content is left alone.
absl::Status Place(const std::string& from, const std::string& to, const std::string& sha256) {
  std::error_code error;
  if (fs::exists(to, error)) {
    const absl::StatusOr<std::string> there = Sha256HexOfFile(to);
    if (there.ok() && *there == sha256) return absl::OkStatus();
    fs::remove(to, error);
  }
  ASSIGN_OR_RETURN(const std::string content, Sha256HexOfFile(from));
  if (content != sha256) {
    return DataLoss("store file {}: its content is not what its manifest says", from);
  }
  if (::link(from.c_str(), to.c_str()) == 0) return absl::OkStatus();
  if (errno == ENOENT) return ErrnoError(errno, from);
  fs::copy_file(from, to, error);
  return error ? ErrnoError(error.value(), "write " + to) : absl::OkStatus();
}

}  // namespace

absl::StatusOr<std::unique_ptr<StudyResults>> StudyResults::Open(const std::string& out_dir,
                                                                 const v1::StudySpec& study) {
  for (const v1::VariantSpec& variant : study.variants()) {
    if (!study.has_train() && !study.has_evaluate()) break;
    if (std::find(std::begin(kResultFolders), std::end(kResultFolders), variant.name()) ==
        std::end(kResultFolders)) {
      continue;
    }
    return FailedPrecondition(
        "variant '{}': a study that trains keeps its results in {}/{}; give the variant another "
        "name",
        variant.name(), out_dir, variant.name());
  }
  const std::string trainer = study.train().trainer().empty() ? "builtin" : study.train().trainer();
  RETURN_IF_ERROR(CheckName("trainer", trainer));
  return std::unique_ptr<StudyResults>(new StudyResults(out_dir, trainer));
}

absl::Status StudyResults::CatchUp(Connection& connection, int64_t study_id, bool only_scores) {
  while (true) {
    absl::StatusOr<v1::ListResultsReply> reply =
        connection.ListResults(study_id, cursor_, kResultsAtOnce);
    if (absl::IsUnimplemented(reply.status())) return absl::OkStatus();  // An older coordinator.
    if (!reply.ok()) return reply.status();
    if (reply->results().empty()) return absl::OkStatus();
    if (store_ == nullptr) {
      ASSIGN_OR_RETURN(store_, StoreReader::Open(connection, fmt::format("{}/.results-{}", out_dir_,
                                                                         ::getpid())));
    }
    for (const v1::JobResult& result : reply->results()) {
      RETURN_IF_ERROR(Add(result, only_scores));
      cursor_ = result.cursor();
    }
  }
}

absl::Status StudyResults::Add(const v1::JobResult& result, bool only_scores) {
  const std::optional<ResultName> name = ParseResultLabel(result.label());
  if (!name) return absl::OkStatus();  // A newer coordinator sent it.
  const bool training = name->benchmark.empty();
  if (training && only_scores) return absl::OkStatus();
  RETURN_IF_ERROR(CheckStorePath(result.path()));
  for (const v1::FileEntry& file : result.files()) RETURN_IF_ERROR(CheckName("file", file.name()));
  v1::FrameResult files;
  files.set_path(result.path());
  *files.mutable_files() = result.files();
  if (!store_->is_local()) RETURN_IF_ERROR(store_->Bring(files));
  const std::string from = store_->folder() + "/" + result.path();
  RETURN_IF_ERROR(training ? AddTraining(*name, from, result) : AddScores(*name, from, result));
  store_->Drop(files);
  return absl::OkStatus();
}

absl::Status StudyResults::AddTraining(const ResultName& name, const std::string& from,
                                       const v1::JobResult& result) {
  const std::string dir =
      fmt::format("{}/training/{}/{}/seed-{}", out_dir_, name.set, trainer_, name.seed.value_or(0));
  RETURN_IF_ERROR(MakeFolders(dir));
  for (const v1::FileEntry& file : result.files()) {
    if (file.name() == "training.json") continue;
    RETURN_IF_ERROR(Place(from + "/" + file.name(), dir + "/" + file.name(), file.sha256()));
  }
  ++trainings_;
  // Sets with equal data share a training: the card says whose folder it is in.
  ASSIGN_OR_RETURN(const std::string text, ReadFile(from + "/training.json"));
  Json card = Json::parse(text, nullptr, /*allow_exceptions=*/false);
  if (!card.is_object()) return DataLoss("{}/training.json: not JSON", from);
  card["set"] = name.set;
  return WriteFileAtomically(dir + "/training.json", card.dump(2) + "\n");
}

absl::Status StudyResults::AddScores(const ResultName& name, const std::string& from,
                                     const v1::JobResult& result) {
  ASSIGN_OR_RETURN(Evaluation evaluation, ReadEvaluation(from + "/scores.jsonl"));
  NameRun(name, trainer_, evaluation.run);
  std::string file = name.benchmark + "." + name.set + "." + evaluation.run.trainer;
  if (name.seed) file += fmt::format(".seed-{}", *name.seed);
  ++evaluations_;
  if (name.checkpoint < name.checkpoints) {
    RETURN_IF_ERROR(MakeFolders(out_dir_ + "/curves"));
    file += fmt::format(".{}-of-{}", name.checkpoint, name.checkpoints);
    return WriteScores("/curves/" + file, evaluation);
  }
  RETURN_IF_ERROR(MakeFolders(out_dir_ + "/scores"));
  RETURN_IF_ERROR(MakeFolders(out_dir_ + "/sheets"));
  for (const v1::FileEntry& entry : result.files()) {
    if (entry.name() != "sheet.png") continue;
    RETURN_IF_ERROR(
        Place(from + "/sheet.png", out_dir_ + "/sheets/" + file + ".png", entry.sha256()));
  }
  return WriteScores("/scores/" + file, evaluation);
}

absl::Status StudyResults::WriteScores(const std::string& name, const Evaluation& evaluation) {
  const std::string path = out_dir_ + name + ".jsonl";
  score_files_.insert(path);
  return WriteFileAtomically(path, EncodeEvaluation(evaluation));
}

}  // namespace parallax::client
