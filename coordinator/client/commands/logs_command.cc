// logs: how a job's attempts ended, and what the failed ones said last.
#include <fmt/core.h>

#include <nlohmann/json.hpp>
#include <sstream>

#include "common/base/system/clock.h"
#include "coordinator/client/command.h"
#include "coordinator/client/views/study_view.h"
#include "coordinator/client/views/text.h"

namespace parallax::client {
namespace {

struct LogsOptions {
  int64_t job = 0;
};

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

void PrintAttempt(const v1::AttemptStatus& attempt, double now_unix_s, const Session& session) {
  std::ostream& out = *session.out().stream;
  out << "\n" << session.out().Paint(EndingTone(attempt.ending()), WordsOf(attempt.ending()));
  if (!attempt.worker().empty()) out << " on " << attempt.worker();
  if (attempt.unix_s() > 0) {
    out << ", " << FormatDuration(std::max(0.0, now_unix_s - attempt.unix_s())) << " ago";
  }
  if (!attempt.error().empty()) out << ": " << FirstLine(attempt.error());
  out << "\n";
  std::istringstream lines(attempt.log_tail());
  for (std::string line; std::getline(lines, line);) out << "  " << line << "\n";
  if (attempt.ending() == "failed" && attempt.log_tail().empty()) out << "  (its log is gone)\n";
}

absl::StatusOr<ExitCode> Logs(const LogsOptions& options, Session& session) {
  ASSIGN_OR_RETURN(const auto connection, session.Connect());
  ASSIGN_OR_RETURN(const v1::ListAttemptsReply reply, connection->ListAttempts(options.job));
  if (session.options.json) {
    nlohmann::ordered_json json = {{"job_id", reply.job().job_id()},
                                   {"kind", reply.job().kind()},
                                   {"state", LowerName(reply.job().state())},
                                   {"variant", reply.job().variant()},
                                   {"label", reply.job().label()},
                                   {"attempts", nlohmann::ordered_json::array()}};
    for (const v1::AttemptStatus& attempt : reply.attempts()) {
      json["attempts"].push_back(AttemptJson(attempt));
    }
    session.PrintJson(json);
    return kExitOk;
  }
  *session.out().stream << JobName(reply.job()) << " is " << LowerName(reply.job().state()) << "; "
                        << (reply.attempts().empty() ? "nobody has tried it"
                                                     : Plural(reply.attempts_size(), "attempt"))
                        << "\n";
  // The newest attempt comes last, as in a log.
  const double now_unix_s = session.environment.clock->UnixSeconds();
  for (int i = reply.attempts_size(); i-- > 0;) {
    PrintAttempt(reply.attempts(i), now_unix_s, session);
  }
  return kExitOk;
}

}  // namespace

void RegisterLogs(Registry& registry) {
  CLI::App* command = registry.AddCommand(
      registry.app, "logs", "How a job's attempts ended, with the last lines of those that failed",
      "`parallax jobs STUDY` lists the numbers of jobs. Of each failed attempt the last 200 lines\n"
      "are kept (at most 16 kB; the newest 1,000 logs of a coordinator); a worker that was killed\n"
      "has sent none.\n"
      "\n"
      "Examples:\n"
      "  parallax logs 4711\n"
      "  parallax logs 4711 --json | jq -r '.attempts[0].log_tail'\n");
  auto options = std::make_shared<LogsOptions>();
  command->add_option("JOB", options->job, "The job's number")
      ->required()
      ->check(CLI::Range(int64_t{1}, INT64_MAX));
  command->group(kCoordinatorCommands);
  registry.AddConnectionOptions(command);
  registry.SetAction(command, [options](Session& session) { return Logs(*options, session); });
}

}  // namespace parallax::client
