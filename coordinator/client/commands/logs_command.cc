// logs: how a job's attempts ended, what the failed ones said last, and what the running one says.
#include <fmt/core.h>

#include <nlohmann/json.hpp>
#include <sstream>

#include "common/base/system/clock.h"
#include "coordinator/client/command.h"
#include "coordinator/client/interrupt.h"
#include "coordinator/client/runs/follow.h"
#include "coordinator/client/views/study_view.h"
#include "coordinator/client/views/text.h"
#include "coordinator/view/json_list.h"

namespace parallax::client {
namespace {

struct LogsOptions {
  int64_t job = 0;
  bool follow = false;
};

// A coordinator that restarts is back within this.
constexpr double kFollowPatience_s = 60;

Tone EndingTone(const std::string& ending) {
  if (ending == "succeeded") return Tone::kGood;
  if (ending == "failed") return Tone::kBad;
  return ending == "running" ? Tone::kAccent : Tone::kWarning;
}

// Returns an ending in words for people: "handed back" says more than "returned".
std::string WordsOf(const std::string& ending) {
  return ending == "returned" ? "handed back" : ending;
}

nlohmann::ordered_json AttemptJson(const v1::AttemptStatus& attempt) {
  return {{"fence", std::to_string(attempt.attempt().fence())},
          {"ending", attempt.ending()},
          {"worker", attempt.worker()},
          {"unix_s", attempt.unix_s()},
          {"error", attempt.error()},
          {"log_tail", attempt.log_tail()}};
}

std::string JobName(const v1::JobStatus& job) {
  std::string of = job.label().empty() ? job.variant() : job.label();
  if (job.label().empty() && HasScene(job)) of += fmt::format(", scene {}", job.scene());
  return fmt::format("job {} ({} {})", job.job_id(), job.kind(), of);
}

void PrintEnding(const v1::AttemptStatus& attempt, double now_unix_s, const Session& session) {
  std::ostream& out = *session.out().stream;
  out << "\n" << session.out().Paint(EndingTone(attempt.ending()), WordsOf(attempt.ending()));
  if (!attempt.worker().empty()) out << " on " << attempt.worker();
  if (attempt.unix_s() > 0) {
    out << ", " << FormatDuration(std::max(0.0, now_unix_s - attempt.unix_s())) << " ago";
  }
  if (!attempt.error().empty()) out << ": " << FirstLine(attempt.error());
  out << "\n";
}

void PrintAttempt(const v1::AttemptStatus& attempt, double now_unix_s, const Session& session) {
  PrintEnding(attempt, now_unix_s, session);
  std::ostream& out = *session.out().stream;
  std::istringstream lines(attempt.log_tail());
  for (std::string line; std::getline(lines, line);) out << "  " << line << "\n";
  if (attempt.ending() == "failed" && attempt.log_tail().empty()) out << "  (its log is gone)\n";
}

void PrintLines(const std::vector<std::string>& lines, const Session& session) {
  for (const std::string& line : lines) {
    if (session.options.json) {
      session.PrintJson({{"line", line}}, /*one_line=*/true);
    } else {
      *session.out().stream << line << "\n";
    }
  }
  *session.out().stream << std::flush;
}

ExitCode ConcludeAttempt(const v1::AttemptStatus& attempt, const Session& session) {
  if (session.options.json) {
    session.PrintJson(AttemptJson(attempt), /*one_line=*/true);
  } else {
    PrintEnding(attempt, session.environment.clock->UnixSeconds(), session);
  }
  return attempt.ending() == "succeeded" ? kExitOk : kExitFailed;
}

// Prints what the attempt that runs says, until it ends.
absl::StatusOr<ExitCode> FollowAttempt(const v1::AttemptStatus& running, const LogsOptions& options,
                                       Connection& connection, Session& session) {
  const Environment& environment = session.environment;
  InterruptScope interrupts;
  std::string said;
  double heard_s = SteadySeconds(*environment.clock);
  while (true) {
    const absl::StatusOr<v1::ListAttemptsReply> reply = connection.ListAttempts(options.job);
    const double now_s = SteadySeconds(*environment.clock);
    const bool away = absl::IsUnavailable(reply.status()) && now_s - heard_s < kFollowPatience_s;
    if (!reply.ok() && !away) return reply.status();
    if (reply.ok()) {
      heard_s = now_s;
      bool listed = false;
      for (const v1::AttemptStatus& attempt : reply->attempts()) {
        if (attempt.attempt().fence() != running.attempt().fence()) continue;
        listed = true;
        if (!attempt.log_tail().empty()) {
          PrintLines(NewLines(said, attempt.log_tail()), session);
          said = attempt.log_tail();
        }
        if (attempt.ending() != "running") return ConcludeAttempt(attempt, session);
      }
      if (!listed) return NotFound("job {}: its attempt is gone", options.job);
      if (session.OutputIsClosed()) return kExitInterrupted;
    }
    if (interrupts.WaitFor(std::chrono::duration<double>(environment.poll_s))) {
      return kExitInterrupted;
    }
  }
}

absl::StatusOr<ExitCode> Logs(const LogsOptions& options, Session& session) {
  ASSIGN_OR_RETURN(const auto connection, session.Connect());
  ASSIGN_OR_RETURN(const v1::ListAttemptsReply reply, connection->ListAttempts(options.job));
  for (const v1::AttemptStatus& attempt : reply.attempts()) {
    if (options.follow && attempt.ending() == "running") {
      return FollowAttempt(attempt, options, *connection, session);
    }
  }
  // Nothing is there to be followed: the exit status says whether the job has succeeded.
  const ExitCode exit_code =
      options.follow && reply.job().state() != "SUCCEEDED" ? kExitFailed : kExitOk;
  if (session.options.json) {
    session.PrintJson({{"job_id", reply.job().job_id()},
                       {"kind", reply.job().kind()},
                       {"state", LowerName(reply.job().state())},
                       {"variant", reply.job().variant()},
                       {"label", reply.job().label()},
                       {"attempts", JsonList(reply.attempts(), AttemptJson)}});
    return exit_code;
  }
  *session.out().stream << JobName(reply.job()) << " is " << LowerName(reply.job().state()) << "; "
                        << (reply.attempts().empty() ? "no attempt yet"
                                                     : Plural(reply.attempts_size(), "attempt"))
                        << "\n";
  // The newest attempt comes last, as in a log.
  const double now_unix_s = session.environment.clock->UnixSeconds();
  for (int i = reply.attempts_size(); i-- > 0;) {
    PrintAttempt(reply.attempts(i), now_unix_s, session);
  }
  return exit_code;
}

}  // namespace

void RegisterLogs(Registry& registry) {
  CLI::App* command = registry.AddCommand(
      registry.app, "logs",
      "Show how a job's attempts ended, with the last log lines of failed ones",
      "`parallax jobs STUDY` lists the numbers of jobs. The last 200 lines of each failed attempt\n"
      "are kept (at most 16 kB; the newest 1,000 logs of a coordinator); a worker that was killed\n"
      "has sent none. A running attempt shows its last lines, at most 2 kB; --follow prints new\n"
      "lines as they come, until it ends: exit status 0 if it has succeeded, else 1; so where "
      "none\n"
      "runs any more. With --json each line is an object, and the last one is the attempt.\n"
      "\n"
      "Examples:\n"
      "  parallax logs 4711\n"
      "  parallax logs 4711 --follow\n"
      "  parallax logs 4711 --json | jq -r '.attempts[0].log_tail'\n");
  auto options = std::make_shared<LogsOptions>();
  command->add_option("JOB", options->job, "The job's number")
      ->required()
      ->check(CLI::Range(int64_t{1}, INT64_MAX));
  command->add_flag("--follow", options->follow,
                    "Print new lines of the attempt that runs until it ends");
  command->group(kCoordinatorCommands);
  registry.AddConnectionOptions(command);
  registry.SetAction(command, [options](Session& session) { return Logs(*options, session); });
}

}  // namespace parallax::client
