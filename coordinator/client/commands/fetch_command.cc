// fetch: the finished pairs of a study as a dataset folder.
#include <fmt/core.h>

#include <nlohmann/json.hpp>

#include "common/base/status.h"
#include "coordinator/client/command.h"
#include "coordinator/client/runs/archive_sync.h"
#include "coordinator/client/runs/out_dir.h"
#include "coordinator/client/runs/study_results.h"
#include "coordinator/client/views/study_table.h"
#include "coordinator/client/views/study_view.h"
#include "coordinator/client/views/text.h"

namespace parallax::client {
namespace {

struct FetchOptions {
  std::string study;
  std::string out;
  bool no_verify = false;
};

constexpr size_t kDamagedShown = 10;

// OK if no pair is damaged.
absl::Status DamageOf(const ArchiveSync& archive) {
  const std::vector<std::string>& damaged = archive.damaged();
  if (damaged.empty()) return absl::OkStatus();
  std::string text = fmt::format(
      "{} {} damaged in the coordinator's store and left out; it makes them again when it has "
      "found "
      "them itself (or `coordinator check --store STORE --deep --repair`), and the same command "
      "then "
      "brings them:",
      Plural(static_cast<int64_t>(damaged.size()), "pair"), damaged.size() == 1 ? "is" : "are");
  for (size_t i = 0; i < damaged.size() && i < kDamagedShown; ++i) text += "\n  " + damaged[i];
  if (damaged.size() > kDamagedShown) text += "\n  ...";
  return DataLoss("{}", text);
}

nlohmann::ordered_json FetchJson(const v1::StudyStatus& study, const std::string& out,
                                 const ArchiveSync& archive, int64_t frames) {
  const ArchiveWriter::Totals& totals = archive.writer().totals();
  return {{"study_id", study.study_id()},
          {"name", study.name()},
          {"state", StateName(study.state())},
          {"out", out},
          {"frames", frames},
          {"frames_added", totals.frames_added},
          {"frames_present", totals.frames_present},
          {"frames_replaced", totals.frames_replaced},
          {"frames_damaged", archive.damaged().size()},
          {"files_linked", totals.files_linked - archive.files_streamed()},
          {"files_copied", totals.files_copied},
          {"files_streamed", archive.files_streamed()}};
}

absl::StatusOr<ExitCode> Fetch(const FetchOptions& options, Session& session) {
  ASSIGN_OR_RETURN(const auto connection, session.Connect());
  ASSIGN_OR_RETURN(const v1::StudyStatus study, connection->FindStudy(options.study));
  ASSIGN_OR_RETURN(const auto out, OutDir::Open(options.out));
  ASSIGN_OR_RETURN(const auto archive,
                   ArchiveSync::Open(out->path(), study.spec(), !options.no_verify));
  RETURN_IF_ERROR(archive->CatchUp(*connection, study.study_id()));
  RETURN_IF_ERROR(archive->Finish());
  ASSIGN_OR_RETURN(const auto results, StudyResults::Open(out->path(), study.spec()));
  RETURN_IF_ERROR(results->CatchUp(*connection, study.study_id()));
  ASSIGN_OR_RETURN(const std::string table,
                   WriteStudyTable(out->path(), study.spec(), results->score_files()));
  int64_t frames = 0;
  for (const auto& [variant, count] : archive->writer().Frames()) frames += count;
  if (session.options.json) {
    nlohmann::ordered_json json = FetchJson(study, out->path(), *archive, frames);
    json["trainings"] = results->trainings();
    json["evaluations"] = results->evaluations();
    session.PrintJson(json);
    RETURN_IF_ERROR(DamageOf(*archive));
    return kExitOk;
  }
  const ArchiveWriter::Totals& totals = archive->writer().totals();
  *session.out().stream << out->path() << ": " << Plural(frames, "pair") << " ("
                        << FormatCount(totals.frames_added + totals.frames_replaced) << " new, "
                        << FormatCount(totals.frames_present) << " there already)\n";
  if (results->trainings() > 0 || results->evaluations() > 0) {
    *session.out().stream << "  " << Plural(results->trainings(), "training") << ", "
                          << Plural(results->evaluations(), "evaluation") << "\n";
  }
  if (!table.empty()) *session.out().stream << "\n" << table;
  if (!IsFinished(study.state())) {
    session.PrintNote(fmt::format("study {} is {}; the same command later brings the rest",
                                  study.study_id(), StateName(study.state())));
  }
  RETURN_IF_ERROR(DamageOf(*archive));
  return kExitOk;
}

}  // namespace

void RegisterFetch(Registry& registry) {
  CLI::App* command = registry.AddCommand(
      registry.app, "fetch", "Bring a study's finished pairs, networks and scores into a folder",
      "Files are hard links into the coordinator's store where "
      "this machine sees it, and come through the\n"
      "coordinator otherwise. May be repeated while the study "
      "runs: only what is new is brought. New files are read and compared with their hashes; "
      "pairs\n"
      "that are damaged are left out, and named.\n"
      "\n"
      "Example:\n"
      "  parallax fetch baseline --out out/baseline\n");
  auto options = std::make_shared<FetchOptions>();
  command->add_option("STUDY", options->study, "Id, or name (the newest of that name)")->required();
  AddOption(command, "-o,--out", "DIR", options->out, "The dataset folder")->required();
  command->add_flag("--no-verify", options->no_verify,
                    "Link files without reading them: quicker, and damaged ones come as well");
  command->group(kCoordinatorCommands);
  registry.AddConnectionOptions(command);
  registry.SetAction(command, [options](Session& session) { return Fetch(*options, session); });
}

}  // namespace parallax::client
