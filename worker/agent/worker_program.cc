#include "worker/agent/worker_program.h"

#include <CLI/CLI.hpp>
#include <cstdlib>
#include <iostream>

#include "common/base/completion.h"
#include "common/base/status.h"
#include "common/base/system/clock.h"
#include "common/base/system/log.h"
#include "common/base/usage_error.h"
#include "common/base/version.h"
#include "worker/agent/agent.h"
#include "worker/agent/health.h"
#include "worker/agent/signal_relay.h"
#include "worker/agent/signal_watch.h"
#include "worker/agent/worker_command_line.h"

namespace parallax {
namespace {

int Complain(const absl::Status& status, int exit_status) {
  std::cerr << "worker: " << ToStd(status.message()) << std::endl;
  return exit_status;
}

int ExitFor(const absl::Status& status) {
  switch (status.code()) {
    case absl::StatusCode::kInvalidArgument:
    case absl::StatusCode::kUnimplemented:
    case absl::StatusCode::kUnauthenticated:
    case absl::StatusCode::kAlreadyExists:
    case absl::StatusCode::kFailedPrecondition:
      return kWorkerRefused;
    default:
      return kWorkerFailed;
  }
}

int ExitAfter(const AgentSummary& summary, bool orphaned) {
  const bool complete = summary.handed_back == 0 && summary.reports_left == 0;
  return orphaned           ? kWorkerOrphaned
         : summary.hung > 0 ? kWorkerHung
         : complete         ? kWorkerDrained
                            : kWorkerIncomplete;
}

// Runs the agent to its end. Returns the exit status, unless a job hinders the process from ending:
// then ends it.
int RunAgent(Agent& agent, const AgentOptions& options, const WorkerCommandLine& line,
             const SignalRelay& relay) {
  LogInfo("worker starts", {{"coordinator", line.coordinator},
                            {"role", line.role},
                            {"slots", options.slots},
                            {"threads", options.cores},
                            {"version", kProgramVersion}});
  const absl::StatusOr<AgentSummary> summary = agent.Run();
  // A job that ignores its cancellation must not keep the process: its data is durable or
  // worthless.
  if (!summary.ok()) std::_Exit(Complain(summary.status(), ExitFor(summary.status())));
  LogInfo("worker ends", {{"succeeded", summary->succeeded},
                          {"failed", summary->failed},
                          {"handed_back", summary->handed_back},
                          {"reports_left", summary->reports_left}});
  const int status = ExitAfter(*summary, relay.orphaned());
  if (summary->stuck > 0) std::_Exit(status);
  return status;
}

int Work(const AgentOptions& options, const WorkerCommandLine& line, const JobHandlers& handlers) {
  SignalRelay relay;
  const SignalWatch watch(relay.Handlers(line.exit_when_orphaned));
  LogContext names;
  names.worker = options.name;
  const ScopedLogContext scope(names);
  auto created = Agent::Create(options, handlers, Clock::System());
  if (!created.ok()) return Complain(created.status(), kWorkerFailed);
  Agent& agent = **created;
  relay.Attach(&agent);

  std::unique_ptr<HealthServer> health;
  if (!line.health.empty()) {
    auto started = HealthServer::Start(line.health, [&agent] { return agent.Health(); });
    if (!started.ok()) {
      relay.Detach();
      const bool bad_address = absl::IsInvalidArgument(started.status());
      return Complain(started.status(), bad_address ? kWorkerUsage : kWorkerFailed);
    }
    health = *std::move(started);
  }
  const int status = RunAgent(agent, options, line, relay);
  relay.Detach();
  return status;
}

}  // namespace

int RunWorkerProgram(int argc, char** argv, JobHandlers handlers, const BeforeWorkFn& before_work) {
  WorkerCommandLine line;
  CLI::App app(
      "Leases jobs from a coordinator and does them: solves scenes, renders stereo pairs,\n"
      "trains networks and evaluates them.",
      "worker");
  DeclareWorkerOptions(app, line);
  AddCompletion(app);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);  // --help, --version
    std::cerr << "worker: " << ExplainUsage(app, error, {argv + 1, argv + argc}) << std::endl;
    return kWorkerUsage;
  }
  const auto level = ParseLogLevel(line.log_level);
  if (!level.ok()) return Complain(level.status(), kWorkerUsage);
  InitLogging({.json = line.log_json, .level = *level, .program = "worker"});
  auto options = AgentOptionsOf(line, handlers);
  if (!options.ok()) return Complain(options.status(), kWorkerUsage);
  const absl::Status allowed = CheckRpcSecurity(options->coordinator, options->security);
  if (!allowed.ok()) return Complain(allowed, kWorkerUsage);
  if (before_work) {
    const auto abilities = before_work(WorkerSettingsOf(line, *options));
    if (!abilities.ok()) return Complain(abilities.status(), kWorkerUsage);
    options->tags.insert(options->tags.end(), abilities->begin(), abilities->end());
  }
  return Work(*options, line, handlers);
}

}  // namespace parallax
