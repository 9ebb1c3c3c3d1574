// submit: give a study to a coordinator.
#include <fmt/core.h>

#include <nlohmann/json.hpp>

#include "common/config/check/limit_rules.h"
#include "coordinator/client/command.h"
#include "coordinator/client/content/study_options.h"
#include "coordinator/client/runs/submit_study.h"
#include "coordinator/client/views/study_view.h"
#include "coordinator/client/views/text.h"
#include "coordinator/study/expansion.h"

namespace parallax::client {
namespace {

struct SubmitOptions {
  StudyOptions study;
  int max_running = 0;
  bool again = false;
  bool no_content = false;
};

absl::StatusOr<ExitCode> Submit(const SubmitOptions& options, Session& session) {
  ASSIGN_OR_RETURN(v1::StudySpec study, ResolveStudy(options.study));
  RETURN_IF_ERROR(HashContent(study, FolderReaders::kOfFarm));
  ASSIGN_OR_RETURN(const auto connection, session.Connect());
  ASSIGN_OR_RETURN(const Submitted submitted, SubmitStudy({.study = study,
                                                           .max_running = options.max_running,
                                                           .again = options.again,
                                                           .ship_content = !options.no_content},
                                                          *connection, *session.environment.clock));
  const auto& [reply, shipped] = submitted;
  std::string state = "running";
  if (reply.existed()) {
    ASSIGN_OR_RETURN(const v1::StudyStatus status, connection->GetStudy(reply.study_id()));
    state = StateName(status.state());
  }
  const int64_t pairs = TotalPairsOf(study);
  if (session.options.json) {
    return session.PrintJson({{"study_id", reply.study_id()},
                              {"name", study.name()},
                              {"existed", reply.existed()},
                              {"state", state},
                              {"variants", study.variants_size()},
                              {"content_files", shipped.files},
                              {"content_bytes", shipped.bytes},
                              {"pairs_wanted", pairs},
                              {"unservable", WaitingJson(reply.unservable())}});
  }
  if (shipped.files > 0) {
    session.PrintNote("own content: " + Plural(shipped.folders, "folder") + ", " +
                      Plural(shipped.files, "file") + ", " +
                      FormatBytes(static_cast<double>(shipped.bytes)) +
                      " are in the coordinator's store, where workers without a copy fetch them");
  }
  // The id alone on standard output, so that a script needs no parser; the rest is for people.
  *session.out().stream << reply.study_id() << "\n" << std::flush;
  if (reply.existed()) {
    session.PrintNote(
        fmt::format("this very study is there already as study {} ({}): nothing was submitted; "
                    "--again submits it once more",
                    reply.study_id(), state));
  } else {
    *session.err().stream << "submitted " << study.name() << ": " << DescribeSize(study)
                          << "; follow it with `parallax watch " << reply.study_id() << "`\n";
  }
  for (const v1::WaitingJobs& jobs : reply.unservable()) {
    const bool all = jobs.reason() == "no_worker";
    session.PrintNote(fmt::format("{} will wait: {}",
                                  all ? "its jobs" : "its " + jobs.kind() + " jobs", jobs.text()));
  }
  return kExitOk;
}

}  // namespace

void RegisterSubmit(Registry& registry) {
  CLI::App* command = registry.AddCommand(
      registry.app, "submit", "Give a study to a coordinator; prints its id",
      "The same study again is not made twice: its id is printed and a note says so. Results are\n"
      "found by content, so a larger --pairs later renders only missing pairs. Folders of your\n"
      "own meshes, textures, surroundings and pictures go into the coordinator's store first.\n"
      "\n"
      "Examples:\n"
      "  parallax submit baseline --pairs 1000\n"
      "  id=$(parallax submit my.yaml --priority 10) && parallax watch \"$id\"\n");
  auto options = std::make_shared<SubmitOptions>();
  AddStudyOptions(*command, options->study);
  AddOption(command, "--name", "NAME", options->study.name, "Another name for the study");
  command->add_option("--priority", options->study.priority,
                      "Priority of its jobs; higher ones start first (default: the study's)");
  AddOption(command, "--max-running", "N", options->max_running,
            "Limit of its running jobs; `parallax limits` changes it later\n"
            "(default 0: as many as there are workers)")
      ->check(CLI::Range(0, kMostRunning));
  command->add_flag("--again", options->again,
                    "Submit although the same study was submitted before");
  command->add_flag("--no-content", options->no_content,
                    "Send no own content: each worker has its copy below its --picture-root");
  command->group(kCoordinatorCommands);
  registry.AddConnectionOptions(command);
  registry.SetAction(command, [options](Session& session) { return Submit(*options, session); });
}

}  // namespace parallax::client
