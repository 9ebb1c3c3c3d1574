// workers: who works for a coordinator.
#include <nlohmann/json.hpp>

#include "coordinator/client/commands/command.h"
#include "coordinator/client/table.h"
#include "coordinator/client/text.h"

namespace parallax::client {
namespace {

std::vector<std::string> KindNames(const v1::WorkerStatus& worker) {
  return {worker.kinds().begin(), worker.kinds().end()};
}

nlohmann::ordered_json WorkerJson(const v1::WorkerStatus& worker) {
  return {{"name", worker.name()},       {"state", LowerName(worker.state())},
          {"kinds", KindNames(worker)},  {"slots", worker.slots()},
          {"running", worker.running()}, {"last_heard_s", worker.last_heard_s()},
          {"version", worker.version()}};
}

absl::StatusOr<ExitCode> Workers(Session& session) {
  ASSIGN_OR_RETURN(const auto connection, session.Connect());
  ASSIGN_OR_RETURN(const v1::ListWorkersReply reply, connection->ListWorkers());
  if (session.options.json) {
    nlohmann::ordered_json json = {{"workers", nlohmann::ordered_json::array()}};
    for (const v1::WorkerStatus& worker : reply.workers()) {
      json["workers"].push_back(WorkerJson(worker));
    }
    session.PrintJson(json);
    return kExitOk;
  }
  if (reply.workers_size() == 0) {
    *session.out().stream << "no workers: `worker --coordinator " << connection->address()
                          << "` on any machine adds one\n";
    return kExitOk;
  }
  Table table({{"WORKER"},
               {"STATE"},
               {"KINDS"},
               {"RUNNING", Align::kRight},
               {"SLOTS", Align::kRight},
               {"LAST HEARD", Align::kRight},
               {"VERSION"}});
  for (const v1::WorkerStatus& worker : reply.workers()) {
    std::string kinds;
    for (const std::string& name : KindNames(worker)) kinds += (kinds.empty() ? "" : ",") + name;
    table.AddRow({worker.name(), LowerName(worker.state()), kinds, std::to_string(worker.running()),
                  std::to_string(worker.slots()), FormatDuration(worker.last_heard_s()) + " ago",
                  worker.version()});
  }
  table.Print(session.out());
  return kExitOk;
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
  registry.SetAction(command, Workers);
}

}  // namespace parallax::client
