// status: all studies, or one with its variants.
#include <nlohmann/json.hpp>

#include "coordinator/client/command.h"
#include "coordinator/client/views/study_view.h"
#include "coordinator/view/json_list.h"

namespace parallax::client {
namespace {

struct StatusOptions {
  std::string study;
  int limit = 20;
};

absl::StatusOr<ExitCode> List(const StatusOptions& options, Session& session) {
  ASSIGN_OR_RETURN(const auto connection, session.Connect());
  ASSIGN_OR_RETURN(const v1::ListStudiesReply list, connection->ListStudies(options.limit));
  if (!session.options.json) {
    PrintStudyList(session.out(), list);
    return kExitOk;
  }
  return session.PrintJson({{"studies", JsonList(list.studies(), StudyJson)}});
}

absl::StatusOr<ExitCode> Show(const StatusOptions& options, Session& session) {
  ASSIGN_OR_RETURN(const auto connection, session.Connect());
  ASSIGN_OR_RETURN(const v1::StudyStatus study, connection->FindStudy(options.study));
  if (session.options.json) {
    session.PrintJson(StudyJson(study));
  } else {
    PrintStudy(session.out(), study);
  }
  return kExitOk;
}

}  // namespace

void RegisterStatus(Registry& registry) {
  CLI::App* command = registry.AddCommand(
      registry.app, "status", "All studies, or one study with its variants and problems",
      "Columns: PAIRS done/wanted. SOLVES: scenes that have a recipe; SOLVES REUSED: whole "
      "recipes\n"
      "taken from an earlier equal study; LAYOUTS REUSED: scenes whose furniture was solved once "
      "and\n"
      "shared with another variant; FRAMES REUSED: pairs that were rendered before; REJECTED: "
      "seeds\n"
      "without a valid scene, replaced by the next; FAILED: jobs given up.\n"
      "\n"
      "Examples:\n"
      "  parallax status\n"
      "  parallax status baseline\n"
      "  parallax status 3 --json | jq .pairs_done\n");
  auto options = std::make_shared<StatusOptions>();
  command->add_option("STUDY", options->study, "Id, or name (the newest of that name)");
  command->add_option("--limit", options->limit, "Studies listed, the newest first (default 20)")
      ->check(CLI::Range(1, 10000));
  command->group(kCoordinatorCommands);
  registry.AddConnectionOptions(command);
  registry.SetAction(command, [options](Session& session) {
    return options->study.empty() ? List(*options, session) : Show(*options, session);
  });
}

}  // namespace parallax::client
