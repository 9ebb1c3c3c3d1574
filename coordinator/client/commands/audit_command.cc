// audit: who did what.
#include <charconv>
#include <nlohmann/json.hpp>

#include "common/rpc/certificate.h"
#include "coordinator/client/command.h"
#include "coordinator/client/views/text.h"
#include "coordinator/client/views/text_table.h"
#include "coordinator/view/json_list.h"
#include "coordinator/view/status_view.h"

namespace parallax::client {
namespace {

struct AuditOptions {
  std::string study;
  int limit = 100;
};

absl::StatusOr<ExitCode> Audit(const AuditOptions& options, Session& session) {
  ASSIGN_OR_RETURN(const auto connection, session.Connect());
  v1::ListAuditRequest request;
  request.set_limit(options.limit);
  int64_t number = 0;
  const std::string& text = options.study;
  if (const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
      error == std::errc() && end == text.data() + text.size()) {
    request.set_study_id(number);  // It may be a forgotten one.
  } else if (!text.empty()) {
    ASSIGN_OR_RETURN(const v1::StudyStatus study, connection->FindStudy(options.study));
    request.set_study_id(study.study_id());
  }
  ASSIGN_OR_RETURN(const v1::ListAuditReply reply, connection->ListAudit(request));
  if (session.options.json) {
    return session.PrintJson({{"entries", JsonList(reply.entries(), AuditEntryJson)}});
  }
  if (reply.entries_size() == 0) {
    *session.out().stream << "nothing has been done yet\n";
    return kExitOk;
  }
  Table table({"WHEN (UTC)", "ACTION", Right("STUDY"), "WHO", "DETAIL"});
  for (const v1::AuditEntry& entry : reply.entries()) {
    table.AddRow({DateAndTimeOf(entry.unix_s()), entry.action(),
                  entry.study_id() == 0 ? "" : std::to_string(entry.study_id()), entry.actor(),
                  FirstLine(entry.detail())});
  }
  table.Print(session.out());
  return kExitOk;
}

}  // namespace

void RegisterAudit(Registry& registry) {
  CLI::App* command = registry.AddCommand(
      registry.app, "audit", "Show who submitted, cancelled, paused..., newest first",
      "Entries are never removed. With TLS only operators may read them.\n"
      "\n"
      "Examples:\n"
      "  parallax audit\n"
      "  parallax audit baseline --json\n");
  auto options = std::make_shared<AuditOptions>();
  command->add_option("STUDY", options->study, "Id or name: only entries of this study");
  command->add_option("-n,--limit", options->limit, "Number of entries (default 100)")
      ->check(CLI::Range(1, 10000));
  command->group(kCoordinatorCommands);
  registry.AddConnectionOptions(command);
  registry.SetAction(command, [options](Session& session) { return Audit(*options, session); });
}

}  // namespace parallax::client
