// workers: who works for a coordinator, and who is not to take more.
#include <nlohmann/json.hpp>

#include "common/base/shell_word.h"
#include "coordinator/client/command.h"
#include "coordinator/client/views/text.h"
#include "coordinator/client/views/text_table.h"
#include "coordinator/view/json_list.h"
#include "coordinator/view/status_view.h"

namespace parallax::client {
namespace {

nlohmann::ordered_json DrainJson(const v1::DrainOrder& drain) {
  return {{"pattern", drain.pattern()},
          {"reason", drain.reason()},
          {"actor", drain.actor()},
          {"unix_s", drain.unix_s()}};
}

void PrintDrains(const v1::ListWorkersReply& reply, const Session& session) {
  for (const v1::DrainOrder& drain : reply.drains()) {
    *session.out().stream << "drained: '" << drain.pattern() << "', since "
                          << FormatUnixTime(drain.unix_s()) << " by " << drain.actor()
                          << (drain.reason().empty() ? "" : ": " + drain.reason()) << "\n";
  }
}

absl::StatusOr<ExitCode> Workers(Session& session) {
  ASSIGN_OR_RETURN(const auto connection, session.Connect());
  ASSIGN_OR_RETURN(const v1::ListWorkersReply reply, connection->ListWorkers());
  if (session.options.json) {
    return session.PrintJson({{"workers", JsonList(reply.workers(), WorkerJson)},
                              {"drains", JsonList(reply.drains(), DrainJson)}});
  }
  if (reply.workers_size() == 0) {
    *session.out().stream << "no workers: `worker --coordinator "
                          << ShellWord(connection->address()) << "` on any machine adds one\n";
    PrintDrains(reply, session);
    return kExitOk;
  }
  Table table({"WORKER", "STATE", "KINDS", Right("RUNNING"), Right("SLOTS"), Right("LAST HEARD"),
               "VERSION"});
  for (const v1::WorkerStatus& worker : reply.workers()) {
    std::string kinds;
    for (const std::string& name : worker.kinds()) kinds += (kinds.empty() ? "" : ",") + name;
    table.AddRow({worker.name(), LowerName(worker.state()), kinds, std::to_string(worker.running()),
                  std::to_string(worker.slots()), FormatDuration(worker.last_heard_s()) + " ago",
                  worker.version()});
  }
  table.Print(session.out());
  PrintDrains(reply, session);
  return kExitOk;
}

struct DrainOptions {
  std::string pattern;
  std::string reason;
  bool undo = false;
};

absl::StatusOr<ExitCode> Drain(const DrainOptions& options, Session& session) {
  ASSIGN_OR_RETURN(const auto connection, session.Connect());
  v1::DrainWorkersRequest request;
  request.set_pattern(options.pattern);
  request.set_reason(options.reason);
  request.set_undo(options.undo);
  ASSIGN_OR_RETURN(const v1::DrainWorkersReply reply, connection->DrainWorkers(request));
  const std::vector<std::string> names(reply.workers().begin(), reply.workers().end());
  if (session.options.json) {
    return session.PrintJson(
        {{"pattern", options.pattern}, {"drained", !options.undo}, {"workers", names}});
  }
  std::ostream& out = *session.out().stream;
  if (names.empty()) {
    out << "no worker of that name is connected; "
        << (options.undo ? "those that come take work again\n" : "those that come get no work\n");
    return kExitOk;
  }
  for (const std::string& name : names) {
    out << name
        << (options.undo ? " takes work again\n" : " finishes what it has and gets nothing new\n");
  }
  return kExitOk;
}

void RegisterDrain(Registry& registry, CLI::App* workers) {
  auto options = std::make_shared<DrainOptions>();
  CLI::App* command = registry.AddCommand(
      *workers, "drain", "Let workers finish what they have and give them nothing new",
      "The order holds for workers of these names that come later too, and over restarts of the\n"
      "coordinator, until it is undone. A worker that is started with --exit-when-idle ends.\n"
      "\n"
      "Examples:\n"
      "  parallax workers drain node17 --reason 'new disk'\n"
      "  parallax workers drain 'node1?-*'\n"
      "  parallax workers drain 'node1?-*' --undo\n");
  command->add_option("NAME", options->pattern, "A worker's name; * matches any characters, ? one")
      ->required();
  command->add_flag("--undo", options->undo, "End the order with exactly this NAME");
  AddOption(command, "--reason", "TEXT", options->reason,
            "Shown with the workers, kept in the audit trail");
  registry.AddConnectionOptions(command);
  registry.SetAction(command, [options](Session& session) { return Drain(*options, session); });
}

}  // namespace

void RegisterWorkers(Registry& registry) {
  CLI::App* command = registry.AddCommand(
      registry.app, "workers", "The workers of a coordinator and what they are doing",
      "Examples:\n"
      "  parallax workers\n"
      "  parallax workers --json | jq '[.workers[].slots] | add'\n");
  command->group(kCoordinatorCommands);
  registry.AddConnectionOptions(command);
  command->require_subcommand(0, 1);
  registry.SetAction(command, Workers);
  RegisterDrain(registry, command);
}

}  // namespace parallax::client
