// limits: shows usage and limits of each user, and sets the job limit of a study.
#include <nlohmann/json.hpp>
#include <optional>

#include "common/base/status.h"
#include "common/config/check/limit_rules.h"
#include "coordinator/client/command.h"
#include "coordinator/client/views/study_view.h"
#include "coordinator/client/views/text.h"
#include "coordinator/client/views/text_table.h"
#include "coordinator/view/json_list.h"

namespace parallax::client {
namespace {

struct LimitsOptions {
  std::string study;
  std::optional<int> max_running;
  std::string reason;
};

// "12 / 64", or the number alone where there is no limit.
std::string OfMost(const Terminal& terminal, int64_t has, int64_t most) {
  if (most == 0) return FormatCount(has);
  const std::string text = FormatCount(has) + " / " + FormatCount(most);
  return has >= most ? terminal.Paint(Tone::kWarning, text) : text;
}

absl::StatusOr<ExitCode> ShowUsers(Session& session) {
  ASSIGN_OR_RETURN(const auto connection, session.Connect());
  ASSIGN_OR_RETURN(const v1::ListUsersReply reply, connection->ListUsers());
  if (session.options.json) {
    return session.PrintJson({{"users", JsonList(reply.users(), UserJson)}});
  }
  if (reply.users().empty()) {
    *session.out().stream << "no user has an unfinished study\n";
    return kExitOk;
  }
  Table table({"USER", Right("RUNNING"), Right("STUDIES"), Right("PAIRS WAITING"),
               Right("PRIORITY"), "LIMITS OF"});
  for (const v1::UserStatus& user : reply.users()) {
    const bool none = user.max_running() + user.max_studies() + user.max_waiting_pairs() == 0;
    table.AddRow({user.user(), OfMost(session.out(), user.running(), user.max_running()),
                  OfMost(session.out(), user.studies(), user.max_studies()),
                  OfMost(session.out(), user.waiting_pairs(), user.max_waiting_pairs()),
                  FormatCount(user.priority()),
                  none                  ? "none"
                  : user.rule().empty() ? "default"
                                        : user.rule()});
  }
  table.Print(session.out());
  return kExitOk;
}

absl::StatusOr<ExitCode> LimitStudy(const LimitsOptions& options, Session& session) {
  ASSIGN_OR_RETURN(const auto connection, session.Connect());
  ASSIGN_OR_RETURN(v1::StudyStatus study, connection->FindStudy(options.study));
  if (options.max_running) {
    v1::SetMaxRunningRequest request;
    request.set_study_id(study.study_id());
    request.set_max_running(*options.max_running);
    request.set_reason(options.reason);
    ASSIGN_OR_RETURN(study, connection->SetMaxRunning(request));
  }
  if (session.options.json) {
    return session.PrintJson({{"study_id", study.study_id()},
                              {"user", study.user()},
                              {"running", JobsInState(study, "LEASED")},
                              {"max_running", study.max_running()},
                              {"at_limit", study.at_limit()},
                              {"held_jobs", study.held_jobs()}});
  }
  std::ostream& out = *session.out().stream;
  out << "study " << study.study_id() << " (" << study.name() << ") of " << study.user() << ": "
      << Plural(JobsInState(study, "LEASED"), "job runs", "jobs run") << ", "
      << (study.max_running() == 0 ? "no limit of its own"
                                   : "at most " + FormatCount(study.max_running()))
      << "\n";
  if (!study.at_limit().empty()) {
    out << "at its limit: " << study.at_limit() << "; "
        << Plural(study.held_jobs(), "job waits", "jobs wait") << " for it\n";
  }
  return kExitOk;
}

}  // namespace

void RegisterLimits(Registry& registry) {
  auto options = std::make_shared<LimitsOptions>();
  CLI::App* command = registry.AddCommand(
      registry.app, "limits", "Show per-user usage and limits, and set a study's job limit",
      "Users' limits are the operator's (`coordinator serve --limits FILE`). A study's own limit "
      "is\n"
      "its submitter's: running jobs continue, no new one starts until there is room.\n"
      "\n"
      "Examples:\n"
      "  parallax limits\n"
      "  parallax limits baseline --max-running 16 --reason 'leave room for others'\n"
      "  parallax limits baseline --max-running 0\n");
  command->add_option("STUDY", options->study, "Id, or name (the newest of that name)");
  AddOption(command, "--max-running", "N", options->max_running,
            "Limit of its running jobs; 0: no limit of its own")
      ->check(CLI::Range(0, kMostRunning));
  AddOption(command, "--reason", "TEXT", options->reason, "Kept in the coordinator's audit trail");
  command->group(kCoordinatorCommands);
  registry.AddConnectionOptions(command);
  registry.SetAction(command, [options](Session& session) -> absl::StatusOr<ExitCode> {
    if (!options->study.empty()) return LimitStudy(*options, session);
    if (!options->max_running) return ShowUsers(session);
    return InvalidArgument(
        "--max-running sets the limit of a study: parallax limits STUDY --max-running {}",
        *options->max_running);
  });
}

}  // namespace parallax::client
