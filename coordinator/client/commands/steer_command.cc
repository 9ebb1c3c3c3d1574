// cancel, pause, resume, comment, priority, retry, forget: a person's hand on a study.
#include <fmt/core.h>

#include <nlohmann/json.hpp>

#include "common/config/check/limits.h"
#include "coordinator/client/command.h"
#include "coordinator/client/views/study_view.h"
#include "coordinator/client/views/text.h"

namespace parallax::client {
namespace {

struct SteerOptions {
  std::string study;
  std::string reason;  // For `comment`, the comment's text.
  bool yes = false;    // Used by `forget`.
  int64_t job = 0;     // Used by `retry`; 0: all failed ones.
  int priority = 0;
};

using Order = absl::StatusOr<v1::StudyStatus> (Connection::*)(int64_t, const std::string&);

absl::StatusOr<ExitCode> Steer(const SteerOptions& options, Order order, Session& session) {
  ASSIGN_OR_RETURN(const auto connection, session.Connect());
  ASSIGN_OR_RETURN(const v1::StudyStatus before, connection->FindStudy(options.study));
  if (order == &Connection::Resume && before.state() == v1::STUDY_STATE_CANCELLED) {
    return FailedPrecondition("study {} is cancelled: submit it again instead", before.study_id());
  }
  ASSIGN_OR_RETURN(const v1::StudyStatus after,
                   ((*connection).*order)(before.study_id(), options.reason));
  if (session.options.json) return session.PrintJson(StudyJson(after));
  const PairCounts counts = CountsOf(after);
  *session.out().stream << "study " << after.study_id() << " (" << after.name() << ") "
                        << (before.state() == after.state() ? "was and is " : "is now ")
                        << PaintedState(session.out(), after.state()) << ": "
                        << FormatCount(counts.done) << " of " << Plural(counts.wanted, "pair")
                        << " done\n";
  return kExitOk;
}

absl::StatusOr<ExitCode> Comment(const SteerOptions& options, Session& session) {
  ASSIGN_OR_RETURN(const auto connection, session.Connect());
  ASSIGN_OR_RETURN(const v1::StudyStatus study, connection->FindStudy(options.study));
  ASSIGN_OR_RETURN(const v1::StudyStatus after,
                   connection->Comment(study.study_id(), options.reason));
  if (session.options.json) {
    session.PrintJson(StudyJson(after));
  } else {
    *session.out().stream << "study " << after.study_id() << " (" << after.name() << ") has "
                          << Plural(after.comments_size(), "comment") << "\n";
  }
  return kExitOk;
}

absl::StatusOr<ExitCode> SetPriority(const SteerOptions& options, Session& session) {
  ASSIGN_OR_RETURN(const auto connection, session.Connect());
  ASSIGN_OR_RETURN(const v1::StudyStatus before, connection->FindStudy(options.study));
  v1::SetPriorityRequest request;
  request.set_study_id(before.study_id());
  request.set_priority(options.priority);
  request.set_reason(options.reason);
  ASSIGN_OR_RETURN(const v1::StudyStatus after, connection->SetPriority(request));
  if (session.options.json) {
    session.PrintJson(StudyJson(after));
  } else {
    *session.out().stream << "study " << after.study_id() << " (" << after.name()
                          << ") has priority " << after.priority() << ", it had "
                          << before.priority() << "\n";
  }
  return kExitOk;
}

absl::StatusOr<ExitCode> Retry(const SteerOptions& options, Session& session) {
  ASSIGN_OR_RETURN(const auto connection, session.Connect());
  ASSIGN_OR_RETURN(const v1::StudyStatus study, connection->FindStudy(options.study));
  v1::RetryReply reply;
  if (options.job > 0) {
    v1::RetryJobRequest request;
    request.set_study_id(study.study_id());
    request.set_job_id(options.job);
    request.set_reason(options.reason);
    ASSIGN_OR_RETURN(reply, connection->RetryJob(request));
  } else {
    ASSIGN_OR_RETURN(reply, connection->Retry(study.study_id(), options.reason));
  }
  if (session.options.json) {
    session.PrintJson({{"study_id", study.study_id()}, {"jobs", reply.jobs()}});
  } else if (reply.jobs() == 0) {
    *session.out().stream << "study " << study.study_id() << " has no failed jobs\n";
  } else {
    *session.out().stream << Plural(reply.jobs(), "job") << " of study " << study.study_id()
                          << " will be tried again\n";
  }
  return kExitOk;
}

// "3 jobs, 12 pairs and 1 network or score", without what none exists of.
std::string Having(const v1::ForgetReply& had) {
  std::string text = Plural(had.jobs(), "job") + (had.results() > 0 ? ", " : " and ") +
                     Plural(had.pairs(), "pair");
  if (had.results() > 0) {
    text += " and " + Plural(had.results(), "network or score", "networks and scores");
  }
  return text;
}

absl::StatusOr<ExitCode> Forget(const SteerOptions& options, Session& session) {
  ASSIGN_OR_RETURN(const auto connection, session.Connect());
  ASSIGN_OR_RETURN(const v1::StudyStatus study, connection->FindStudy(options.study));
  const std::string name = fmt::format("study {} ({})", study.study_id(), study.name());
  RETURN_IF_ERROR(session.Confirm(
      name + " with its " + Plural(CountsOf(study).done, "pair") +
          ", its networks and its history will be deleted, except data that other studies use",
      options.yes));
  ASSIGN_OR_RETURN(const v1::ForgetReply had, connection->Forget(study.study_id(), options.reason));
  if (session.options.json) {
    return session.PrintJson({{"study_id", study.study_id()},
                              {"jobs", had.jobs()},
                              {"pairs", had.pairs()},
                              {"results", had.results()}});
  }
  *session.out().stream << name << " is forgotten: it had " << Having(had)
                        << "; the files that no other study uses are removed in the background\n";
  return kExitOk;
}

CLI::App* Add(Registry& registry, const std::shared_ptr<SteerOptions>& options,
              const std::string& name, const std::string& description,
              const std::string& examples = "", bool with_reason = true) {
  CLI::App* command = registry.AddCommand(
      registry.app, name, description,
      examples.empty() ? "Example:\n  parallax " + name + " baseline\n" : examples);
  command->add_option("STUDY", options->study, "Id, or name (the newest of that name)")->required();
  if (with_reason) {
    AddOption(command, "--reason", "TEXT", options->reason,
              "Kept in the coordinator's audit trail");
  }
  command->group(kCoordinatorCommands);
  registry.AddConnectionOptions(command);
  return command;
}

}  // namespace

void RegisterSteer(Registry& registry) {
  const struct {
    const char* name;
    const char* description;
    Order order;
  } orders[] = {
      {"pause", "Pause a study: start no more of its jobs; running jobs finish",
       &Connection::Pause},
      {"resume", "Resume a paused study", &Connection::Resume},
      {"cancel", "End a study for good; finished pairs are kept", &Connection::Cancel},
  };
  for (const auto& entry : orders) {
    auto options = std::make_shared<SteerOptions>();
    CLI::App* command = Add(registry, options, entry.name, entry.description);
    registry.SetAction(command, [options, order = entry.order](Session& session) {
      return Steer(*options, order, session);
    });
  }
  auto options = std::make_shared<SteerOptions>();
  CLI::App* command =
      Add(registry, options, "retry", "Try a study's failed and quarantined jobs again",
          "Retrying resets the attempts of a job. With --job, a job that waits for its next\n"
          "attempt is ready at once.\n"
          "\n"
          "Examples:\n"
          "  parallax retry baseline\n"
          "  parallax retry baseline --job 4711 --reason 'new driver'\n");
  AddOption(command, "--job", "ID", options->job, "Try only this job again (`parallax jobs STUDY`)")
      ->check(CLI::Range(int64_t{1}, INT64_MAX));
  registry.SetAction(command, [options](Session& session) { return Retry(*options, session); });

  auto priority = std::make_shared<SteerOptions>();
  command =
      Add(registry, priority, "priority", "Set which study's jobs start first",
          "Jobs of studies with a higher priority start first; running jobs continue. Submitters\n"
          "give their own studies up to 100, operators up to 1000. A user's own priority (the\n"
          "operator's `limits` file) is added.\n"
          "\n"
          "Examples:\n"
          "  parallax priority baseline 10 --reason deadline\n"
          "  parallax priority baseline -5\n");
  command->add_option("N", priority->priority, "From -1000 to 1000; 0 at first")
      ->required()
      ->check(CLI::Range(-kMaxPriority, kMaxPriority));
  registry.SetAction(command,
                     [priority](Session& session) { return SetPriority(*priority, session); });

  auto comment = std::make_shared<SteerOptions>();
  command =
      Add(registry, comment, "comment", "Add a comment to a study",
          "`parallax status STUDY` and the page show the newest 20, with who wrote them and when; "
          "the\n"
          "audit has all.\n"
          "\n"
          "Example:\n"
          "  parallax comment baseline 'for the rebuttal; keep until March'\n",
          /*with_reason=*/false);
  command->add_option("TEXT", comment->reason, "One line, at most 1,000 bytes")->required();
  registry.SetAction(command, [comment](Session& session) { return Comment(*comment, session); });

  auto forget = std::make_shared<SteerOptions>();
  command = Add(registry, forget, "forget",
                "Remove an ended study: jobs, pairs and networks that no other study uses");
  command->add_flag("--yes", forget->yes, "Do not ask");
  registry.SetAction(command, [forget](Session& session) { return Forget(*forget, session); });
}

}  // namespace parallax::client
