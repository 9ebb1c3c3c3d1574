#include "coordinator/client/runs/follow.h"

#include <chrono>
#include <nlohmann/json.hpp>

#include "coordinator/client/views/study_view.h"
#include "coordinator/client/views/text.h"

namespace parallax::client {
namespace {

constexpr int kMostLeased = 10000;

}  // namespace

double SteadySeconds(Clock& clock) {
  return std::chrono::duration<double>(clock.Steady().time_since_epoch()).count();
}

std::string AwayNote(double silent_s) {
  return "the coordinator does not answer and is waited for; giving up in " +
         FormatDuration(kPatience_s - silent_s);
}

absl::Status LookAt(Connection& connection, int64_t study_id, double now_s, ProgressView& view) {
  ASSIGN_OR_RETURN(const v1::StudyStatus study, connection.GetStudy(study_id));
  v1::ListJobsRequest request;
  request.set_study_id(study_id);
  request.set_state("LEASED");
  request.set_limit(kMostLeased);
  ASSIGN_OR_RETURN(const v1::ListJobsReply leased, connection.ListJobs(request));
  view.Observe(now_s, study, leased);
  return absl::OkStatus();
}

void ProgressDisplay::Show(const ProgressView& view, double now_s, bool last,
                           const std::string& note) {
  if (redraws()) {
    std::vector<std::string> lines = view.Lines(terminal_);
    if (!note.empty()) lines.push_back("  " + terminal_.Paint(Tone::kWarning, note));
    block_.Update(lines);
    return;
  }
  const int64_t pairs = CountsOf(view.study()).done;
  const double since_s = now_s - printed_s_;
  const bool due = since_s >= options_.plain_line_s ||
                   (pairs != printed_pairs_ && since_s >= options_.plain_line_s / 10);
  if (!last && !due) return;
  *terminal_.stream << (options_.json ? view.Json().dump() : view.PlainLine()) << "\n"
                    << std::flush;
  printed_s_ = now_s;
  printed_pairs_ = pairs;
}

void ProgressDisplay::Print(const std::string& line) {
  if (redraws()) {
    block_.Print(line);
  } else {
    *terminal_.stream << line << "\n" << std::flush;
  }
}

}  // namespace parallax::client
