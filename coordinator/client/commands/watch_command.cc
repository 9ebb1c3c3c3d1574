// watch: follow a study until it ends.
#include <fmt/core.h>

#include <chrono>

#include "coordinator/client/command.h"
#include "coordinator/client/interrupt.h"
#include "coordinator/client/runs/follow.h"
#include "coordinator/client/views/study_view.h"

namespace parallax::client {
namespace {

ExitCode Conclude(const v1::StudyStatus& study, Session& session) {
  for (const std::string& line : ProblemLines(session.err(), study, 5)) {
    *session.err().stream << line << "\n";
  }
  return study.state() == v1::STUDY_STATE_SUCCEEDED ? kExitOk : kExitFailed;
}

absl::StatusOr<ExitCode> Watch(const std::string& id_or_name, Session& session) {
  ASSIGN_OR_RETURN(const auto connection, session.Connect());
  ASSIGN_OR_RETURN(const v1::StudyStatus found, connection->FindStudy(id_or_name));
  const Environment& environment = session.environment;
  InterruptScope interrupts;
  ProgressDisplay display(session.out(), {session.options.json, environment.plain_line_s});
  ProgressView view;
  double heard_s = SteadySeconds(*environment.clock);
  bool is_away = false;
  while (true) {
    const double now_s = SteadySeconds(*environment.clock);
    const absl::Status look = LookAt(*connection, found.study_id(), now_s, view);
    const double silent_s = now_s - heard_s;
    if (!look.ok() && (!absl::IsUnavailable(look) || silent_s > kPatience_s)) return look;
    if (look.ok()) heard_s = now_s;
    const bool finished = look.ok() && IsFinished(view.study().state());
    const std::string note = look.ok() ? "" : AwayNote(silent_s);
    if (!look.ok() && !is_away && !display.redraws()) session.PrintNote(note);
    is_away = !look.ok();
    if (view.study().study_id() != 0) display.Show(view, now_s, finished, note);
    if (finished) break;
    if (session.OutputIsClosed()) return kExitInterrupted;
    if (interrupts.WaitFor(std::chrono::duration<double>(environment.poll_s))) {
      display.Keep();
      session.PrintNote(fmt::format("the study continues; `parallax watch {}` follows it again",
                                    found.study_id()));
      return kExitInterrupted;
    }
  }
  display.Keep();
  return Conclude(view.study(), session);
}

}  // namespace

void RegisterWatch(Registry& registry) {
  CLI::App* command = registry.AddCommand(
      registry.app, "watch", "Follow a study until it ends: bars, pairs per hour, time left",
      "Exits with 0 when the study has succeeded, with 1 when it failed or was cancelled. Where\n"
      "output isn't a terminal, a line is written now and then; --json writes an object a line.\n"
      "Ctrl-C ends watching, not the study.\n"
      "\n"
      "Examples:\n"
      "  parallax watch baseline\n"
      "  parallax submit my.yaml | xargs parallax watch && ./train.sh\n");
  auto study = std::make_shared<std::string>();
  command->add_option("STUDY", *study, "Id, or name (the newest of that name)")->required();
  command->group(kCoordinatorCommands);
  registry.AddConnectionOptions(command);
  registry.SetAction(command, [study](Session& session) { return Watch(*study, session); });
}

}  // namespace parallax::client
