#include "coordinator/client/views/study_view.h"

#include <fmt/core.h>

#include <algorithm>
#include <map>

#include "common/config/check/limit_rules.h"
#include "coordinator/client/views/progress.h"
#include "coordinator/client/views/text.h"
#include "coordinator/client/views/text_table.h"
#include "coordinator/queue/job_kind.h"

namespace parallax::client {
namespace {

int64_t JobsIn(const v1::StudyStatus& study, std::string_view kind,
               std::initializer_list<const char*> states) {
  int64_t jobs = 0;
  for (const v1::VariantStatus& variant : study.variants()) {
    for (const char* state : states) jobs += JobsInState(variant, state, kind);
  }
  return jobs;
}

// Zero is nothing to read.
std::string Quiet(const Terminal& terminal, int64_t count, Tone tone = Tone::kPlain) {
  return count == 0 ? terminal.Paint(Tone::kDim, "-") : terminal.Paint(tone, FormatCount(count));
}

}  // namespace

std::vector<std::string> OtherJobLines(const v1::StudyStatus& study) {
  std::vector<std::string> lines;
  const KindRegistry& kinds = KindRegistry::Builtin();
  for (size_t i = 0; i < kinds.size(); ++i) {
    if (kinds.at(i).traits().of_scene) continue;
    const auto count = [&](std::initializer_list<const char*> states) {
      return JobsIn(study, kinds.at(i).name(), states);
    };
    std::string line;
    const auto add = [&line](int64_t jobs, const char* what) {
      if (jobs == 0) return;
      line += (line.empty() ? "" : ", ") + FormatCount(jobs) + " " + what;
    };
    add(count({"SUCCEEDED"}), "done");
    add(count({"LEASED"}), "running");
    add(count({"BLOCKED", "READY", "RETRY_WAIT"}), "to come");
    // In a study that has succeeded, other jobs have done the work of the failed ones.
    const bool good = study.state() == v1::STUDY_STATE_SUCCEEDED;
    add(count({"FAILED", "QUARANTINED"}), good ? "failed before" : "failed");
    add(count({"CANCELLED"}), good ? "cancelled before" : "cancelled");
    if (!line.empty()) lines.push_back(kinds.at(i).name() + ": " + line);
  }
  return lines;
}

bool HasOtherJobs(const v1::StudyStatus& study) {
  const KindRegistry& kinds = KindRegistry::Builtin();
  for (size_t i = 0; i < kinds.size(); ++i) {
    if (kinds.at(i).traits().of_scene) continue;
    if (JobsIn(study, kinds.at(i).name(), {"BLOCKED", "READY", "RETRY_WAIT", "LEASED"}) > 0) {
      return true;
    }
  }
  return false;
}

std::vector<std::string> LimitLines(const v1::StudyStatus& study) {
  if (IsFinished(study.state())) return {};
  std::vector<std::string> lines;
  if (study.max_running() > 0) {
    lines.push_back("at most " + Plural(study.max_running(), "job") + " at a time (max_running)");
  }
  if (!study.at_limit().empty()) {
    lines.push_back("at its limit: " + study.at_limit() + "; " +
                    Plural(study.held_jobs(), "job waits", "jobs wait") + " for it");
  }
  return lines;
}

std::string WaitingText(const v1::WaitingJobs& jobs) {
  return Plural(jobs.jobs(), jobs.kind() + " job") + (jobs.jobs() == 1 ? " waits: " : " wait: ") +
         jobs.text();
}

bool WantsAttention(const v1::WaitingJobs& jobs) {
  const std::string& reason = jobs.reason();
  return reason != "busy" && reason != "starting" && reason != "limit" && reason != "pause";
}

Tone StateTone(v1::StudyState state) {
  switch (state) {
    case v1::STUDY_STATE_SUCCEEDED:
      return Tone::kGood;
    case v1::STUDY_STATE_FAILED:
      return Tone::kBad;
    case v1::STUDY_STATE_PAUSED:
    case v1::STUDY_STATE_CANCELLED:
      return Tone::kWarning;
    default:
      return Tone::kAccent;
  }
}

std::string PaintedState(const Terminal& terminal, v1::StudyState state) {
  return terminal.Paint(StateTone(state), StateName(state));
}

void PrintStudy(const Terminal& terminal, const v1::StudyStatus& study) {
  std::ostream& out = *terminal.stream;
  out << terminal.Paint(Tone::kBold, study.name()) << "  study " << study.study_id() << "  "
      << PaintedState(terminal, study.state()) << "  submitted "
      << FormatUnixTime(study.submitted_unix_s());
  if (study.finished_unix_s() > 0) {
    out << "  took " << FormatDuration(study.finished_unix_s() - study.submitted_unix_s());
  }
  out << "\n\n";
  Table table({"VARIANT", Right("PAIRS"), Right(""), Right("SOLVES"), Right("SOLVES REUSED"),
               Right("LAYOUTS REUSED"), Right("FRAMES REUSED"), Right("REJECTED"),
               Right("FAILED")});
  const auto add = [&](const std::string& name, const PairCounts& counts) {
    const double done = static_cast<double>(counts.done);
    const double wanted = static_cast<double>(counts.wanted);
    table.AddRow({name, FormatCount(counts.done) + "/" + FormatCount(counts.wanted),
                  FormatPercent(done, wanted), Quiet(terminal, counts.solves_done),
                  Quiet(terminal, counts.solves_reused), Quiet(terminal, counts.layouts_reused),
                  Quiet(terminal, counts.reused), Quiet(terminal, counts.rejected),
                  Quiet(terminal, counts.failed, Tone::kBad)});
  };
  for (const v1::VariantStatus& variant : study.variants()) add(variant.name(), CountsOf(variant));
  if (study.variants_size() > 1) add(terminal.Paint(Tone::kDim, "total"), CountsOf(study));
  table.Print(terminal);
  for (const std::string& line : OtherJobLines(study)) out << line << "\n";
  if (study.priority() != 0) out << "priority " << study.priority() << "\n";
  for (const std::string& line : LimitLines(study)) out << line << "\n";
  for (const v1::WaitingJobs& jobs : study.waiting()) {
    if (jobs.reason() == "limit") continue;  // Among the lines above.
    const Tone tone = WantsAttention(jobs) ? Tone::kWarning : Tone::kPlain;
    out << terminal.Paint(tone, WaitingText(jobs)) << "\n";
  }
  for (const v1::StudyComment& comment : study.comments()) {
    out << "comment of " << UserOfActor(comment.actor()) << ", " << FormatUnixTime(comment.unix_s())
        << ": " << comment.text() << "\n";
  }
  const std::vector<std::string> problems = ProblemLines(terminal, study, 10);
  if (problems.empty()) return;
  out << "\nProblems\n";
  for (const std::string& line : problems) out << "  " << line << "\n";
  if (CountsOf(study).failed > 0 && study.state() != v1::STUDY_STATE_SUCCEEDED) {
    out << "  `parallax retry " << study.study_id() << "` tries failed jobs again\n";
  }
}

namespace {

// "4 for trainer, 12 for busy": jobs by the reason for which they do not run.
std::string WaitingCell(const Terminal& terminal, const v1::StudyStatus& study) {
  std::map<std::string, int64_t> by_reason;
  bool wants_attention = false;
  for (const v1::WaitingJobs& jobs : study.waiting()) {
    by_reason[jobs.reason()] += jobs.jobs();
    wants_attention |= WantsAttention(jobs);
  }
  std::string text;
  for (const auto& [reason, jobs] : by_reason) {
    text += (text.empty() ? "" : ", ") + FormatCount(jobs) + " " + reason;
  }
  return wants_attention ? terminal.Paint(Tone::kWarning, text) : text;
}

}  // namespace

void PrintStudyList(const Terminal& terminal, const v1::ListStudiesReply& list) {
  if (list.studies_size() == 0) {
    *terminal.stream << "no studies yet: `parallax submit STUDY` adds one\n";
    return;
  }
  Table table({Right("ID"), "NAME", "STATE", Right("VARIANTS"), Right("PAIRS"), Right(""),
               Right("FAILED"), "SUBMITTED", "WAITING"});
  for (const v1::StudyStatus& study : list.studies()) {
    const PairCounts counts = CountsOf(study);
    table.AddRow(
        {std::to_string(study.study_id()), study.name(), PaintedState(terminal, study.state()),
         FormatCount(study.variants_size()),
         FormatCount(counts.done) + "/" + FormatCount(counts.wanted),
         FormatPercent(static_cast<double>(counts.done), static_cast<double>(counts.wanted)),
         Quiet(terminal, counts.failed, Tone::kBad), FormatUnixTime(study.submitted_unix_s()),
         WaitingCell(terminal, study)});
  }
  table.Print(terminal);
}

namespace {

std::string PlaceOf(const std::string& variant, uint32_t scene) {
  return scene == kNoScene ? variant : fmt::format("{} scene {}", variant, scene);
}

}  // namespace

bool HasScene(const v1::JobStatus& job) { return job.scene() != kNoScene; }

std::string PlaceOf(const std::string& variant, const v1::JobProblem& problem) {
  return PlaceOf(variant, problem.job_id() == 0 ? kNoScene : problem.scene());
}

std::string PlaceOf(const v1::JobStatus& job) {
  return job.label().empty() ? PlaceOf(job.variant(), job.scene()) : job.label();
}

std::vector<std::string> ProblemLines(const Terminal& terminal, const v1::StudyStatus& study,
                                      size_t most) {
  // Equal errors of many jobs are one line with a count; the first job stands for them.
  struct Group {
    std::string variant;
    const v1::JobProblem* problem;
    int64_t count;
  };
  std::vector<Group> groups;
  for (const v1::VariantStatus& variant : study.variants()) {
    for (const v1::JobProblem& problem : variant.problems()) {
      const auto same = std::find_if(groups.begin(), groups.end(), [&](const Group& group) {
        return group.problem->state() == problem.state() &&
               FirstLine(group.problem->error()) == FirstLine(problem.error());
      });
      if (same != groups.end()) {
        ++same->count;
      } else {
        groups.push_back({variant.name(), &problem, 1});
      }
    }
  }
  std::vector<std::string> lines;
  for (const Group& group : groups) {
    if (lines.size() == most) {
      lines.push_back("and " + Plural(static_cast<int64_t>(groups.size() - most), "more problem"));
      break;
    }
    const std::string& state = group.problem->state();
    const bool final = state == "FAILED" || state == "QUARANTINED";
    const int64_t job = group.problem->job_id();  // 0: the variant gave up.
    lines.push_back(fmt::format(
        "{}  {}{}{}: {}", terminal.Paint(final ? Tone::kBad : Tone::kWarning, LowerName(state)),
        PlaceOf(group.variant, *group.problem), job > 0 ? fmt::format(" job {}", job) : "",
        group.count > 1 ? fmt::format(" (and {} like it)", group.count - 1) : "",
        FirstLine(group.problem->error())));
  }
  return lines;
}

}  // namespace parallax::client
