// jobs: what a study's work consists of, and where it is.
#include <fmt/core.h>

#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>

#include "coordinator/client/command.h"
#include "coordinator/client/views/progress_view.h"
#include "coordinator/client/views/study_view.h"
#include "coordinator/client/views/text.h"
#include "coordinator/client/views/text_table.h"
#include "coordinator/queue/job_state.h"
#include "coordinator/study/rigs.h"
#include "coordinator/view/json_list.h"

namespace parallax::client {
namespace {

struct JobsOptions {
  std::string study;
  std::string state;
  int limit = 50;
  bool all = false;
};

std::vector<std::string> StateWords() {
  std::vector<std::string> words;
  for (const char* state : kJobStateNames) words.push_back(LowerName(state));
  return words;
}

Tone ToneOf(const std::string& state) {
  if (state == "SUCCEEDED") return Tone::kGood;
  if (state == "FAILED" || state == "QUARANTINED") return Tone::kBad;
  if (state == "LEASED") return Tone::kAccent;
  if (state == "RETRY_WAIT" || state == "REJECTED" || state == "CANCELLED") return Tone::kWarning;
  return Tone::kPlain;
}

nlohmann::ordered_json JobJson(const v1::JobStatus& job) {
  using Json = nlohmann::ordered_json;
  return {{"job_id", job.job_id()},
          {"kind", job.kind()},
          {"state", LowerName(job.state())},
          {"variant", job.variant()},
          {"scene", HasScene(job) ? Json(job.scene()) : Json(nullptr)},
          {"rigs", std::vector<uint32_t>(job.rigs().begin(), job.rigs().end())},
          {"attempts", job.attempts()},
          {"worker", job.worker()},
          {"fraction", job.fraction()},
          {"stage", job.stage()},
          {"error", job.error()},
          {"waits_reason", job.waits_reason()},
          {"waits_text", job.waits_text()},
          {"label", job.label()},
          {"figures", std::map<std::string, double>(job.figures().begin(), job.figures().end())},
          {"log_tail", job.log_tail()}};
}

void PrintTable(const v1::ListJobsReply& reply, const Session& session) {
  Table table({Right("JOB"), "KIND", "STATE", "VARIANT", Right("SCENE"), "RIGS", Right("TRIES"),
               "WORKER", "DETAIL"});
  for (const v1::JobStatus& job : reply.jobs()) {
    std::string detail = FirstLine(job.error());
    if (job.state() == "READY" && !job.waits_text().empty()) detail = job.waits_text();
    if (job.state() == "LEASED") detail = DescribeProgress(job);
    if (!job.label().empty()) detail = job.label() + (detail.empty() ? "" : ": ") + detail;
    table.AddRow({std::to_string(job.job_id()), job.kind(),
                  session.out().Paint(ToneOf(job.state()), LowerName(job.state())), job.variant(),
                  job.label().empty() && HasScene(job) ? std::to_string(job.scene()) : "-",
                  RigsText({job.rigs().data(), static_cast<size_t>(job.rigs_size())}),
                  std::to_string(job.attempts()), job.worker(), detail});
  }
  table.Print(session.out());
}

// The ends of failed programs' logs, below the table.
void PrintLogs(const v1::ListJobsReply& reply, const Session& session) {
  constexpr int kMostLogs = 3;
  int shown = 0;
  for (const v1::JobStatus& job : reply.jobs()) {
    if (job.log_tail().empty() || shown == kMostLogs) continue;
    ++shown;
    std::ostream& out = *session.out().stream;
    out << "\nThe end of the log of job " << job.job_id()
        << (job.label().empty() ? "" : " (" + job.label() + ")") << ":\n";
    std::istringstream lines(job.log_tail());
    for (std::string line; std::getline(lines, line);) out << "  " << line << "\n";
  }
}

absl::StatusOr<ExitCode> Jobs(const JobsOptions& options, Session& session) {
  ASSIGN_OR_RETURN(const auto connection, session.Connect());
  ASSIGN_OR_RETURN(const v1::StudyStatus study, connection->FindStudy(options.study));
  v1::ListJobsRequest request;
  request.set_study_id(study.study_id());
  request.set_limit(options.all ? std::numeric_limits<int32_t>::max() : options.limit);
  request.set_state(options.state);
  for (char& c : *request.mutable_state()) c = static_cast<char>(std::toupper(c));
  ASSIGN_OR_RETURN(const v1::ListJobsReply reply, connection->ListJobs(request));
  if (session.options.json) {
    return session.PrintJson(
        {{"study_id", study.study_id()}, {"jobs", JsonList(reply.jobs(), JobJson)}});
  }
  if (reply.jobs_size() == 0) {
    *session.out().stream << "study " << study.study_id() << " has no "
                          << (options.state.empty() ? "" : options.state + " ") << "jobs\n";
    return kExitOk;
  }
  PrintTable(reply, session);
  PrintLogs(reply, session);
  if (!options.all && reply.jobs_size() == options.limit) {
    session.PrintNote(
        fmt::format("the first {}; --limit shows more, --all shows all", options.limit));
  }
  return kExitOk;
}

}  // namespace

void RegisterJobs(Registry& registry) {
  CLI::App* command = registry.AddCommand(
      registry.app, "jobs", "The jobs of a study: state, worker, progress, error",
      "States: blocked, ready, leased, retry_wait, succeeded, rejected, failed, quarantined,\n"
      "cancelled.\n"
      "\n"
      "Examples:\n"
      "  parallax jobs baseline --state failed\n"
      "  parallax jobs 3 --state leased --json\n"
      "  parallax jobs 3 --all --json | jq '[.jobs[].attempts] | add'\n");
  auto options = std::make_shared<JobsOptions>();
  command->add_option("STUDY", options->study, "Id, or name (the newest of that name)")->required();
  AddOption(command, "--state", "STATE", options->state, "Only jobs in this state")
      ->check(CLI::IsMember(StateWords(), CLI::ignore_case));
  command->add_option("--limit", options->limit, "Number of jobs (default 50)")
      ->check(CLI::Range(1, 10'000'000));
  command->add_flag("--all", options->all, "All of them");
  command->group(kCoordinatorCommands);
  registry.AddConnectionOptions(command);
  registry.SetAction(command, [options](Session& session) { return Jobs(*options, session); });
}

}  // namespace parallax::client
