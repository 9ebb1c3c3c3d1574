#include "coordinator/client/views/progress_view.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>

#include "coordinator/client/views/progress.h"
#include "coordinator/client/views/study_view.h"
#include "coordinator/client/views/text.h"
#include "coordinator/queue/job_kind.h"

namespace parallax::client {
namespace {

using Json = nlohmann::ordered_json;

// Frames that were there already came for nothing: they would promise a rate that rendering can't
// keep.
double FreshPairs(const PairCounts& counts) {
  return static_cast<double>(std::max<int64_t>(0, counts.done - counts.reused));
}

Json OptionalJson(std::optional<double> value) { return value ? Json(*value) : Json(nullptr); }

std::optional<double> PerHour(std::optional<double> per_second) {
  if (!per_second) return std::nullopt;
  return *per_second * 3600;
}

}  // namespace

std::string DescribeProgress(const v1::JobStatus& job) {
  const auto figure = [&job](const char* name) -> std::optional<double> {
    const auto found = job.figures().find(name);
    if (found == job.figures().end()) return std::nullopt;
    return found->second;
  };
  const std::string percent = fmt::format("{}%", static_cast<int>(job.fraction() * 100));
  const std::optional<double> step = figure("step");
  if (!step) return job.stage() + " " + percent;
  std::string text = "step " + FormatCount(std::llround(*step));
  if (const auto steps = figure("steps")) text += " of " + FormatCount(std::llround(*steps));
  if (const auto loss = figure("loss")) text += ", loss " + FormatNumber(*loss);
  if (const auto eta_s = figure("eta_s")) text += ", " + FormatAbout(*eta_s) + " left";
  return text;
}

std::vector<v1::WaitingJobs> ProgressView::Waiting() const {
  std::vector<v1::WaitingJobs> waiting;
  const bool workers_come = now_s_ - start_s_ < workers_come_s_;
  for (const v1::WaitingJobs& jobs : study_.waiting()) {
    if (!workers_come || !WantsAttention(jobs)) waiting.push_back(jobs);
  }
  return waiting;
}

std::optional<double> ProgressView::SecondsToPairs() const {
  const PairCounts counts = CountsOf(study_);
  if (counts.done >= counts.wanted) return std::nullopt;
  return rate_.SecondsFor(static_cast<double>(counts.wanted - counts.done));
}

std::optional<double> ProgressView::SecondsLeft() const {
  const PairCounts counts = CountsOf(study_);
  if (counts.done < counts.wanted) return HasOtherJobs(study_) ? std::nullopt : SecondsToPairs();
  for (const char* state : {"READY", "BLOCKED", "RETRY_WAIT"}) {
    if (JobsInState(study_, state) > 0) return std::nullopt;
  }
  double left_s = 0;
  for (const v1::JobStatus& job : labelled_) {
    const auto eta_s = job.figures().find("eta_s");
    if (eta_s == job.figures().end()) return std::nullopt;
    left_s = std::max(left_s, eta_s->second);
  }
  return left_s;
}

void ProgressView::Observe(double time_s, const v1::StudyStatus& study,
                           const v1::ListJobsReply& leased) {
  if (start_s_ < 0) start_s_ = time_s;
  now_s_ = time_s;
  study_ = study;
  at_work_.clear();
  labelled_.clear();
  for (auto& [name, variant] : variants_) variant.begun_pairs = 0;
  for (const v1::JobStatus& job : leased.jobs()) {
    ++at_work_[job.kind()];
    if (!job.label().empty()) labelled_.push_back(job);
    variants_[job.variant()].begun_pairs += job.fraction() * job.rigs_size();
  }
  double begun = 0;
  for (const v1::VariantStatus& status : study.variants()) {
    Variant& variant = variants_[status.name()];
    variant.rate.Add(time_s, FreshPairs(CountsOf(status)) + variant.begun_pairs);
    begun += variant.begun_pairs;
  }
  rate_.Add(time_s, FreshPairs(CountsOf(study)) + begun);
}

std::string ProgressView::JobsLine() const {
  std::string line;
  const auto add = [&line](int64_t count, std::string_view one, std::string_view more = "") {
    if (count == 0) return;
    line += (line.empty() ? "" : ", ") + Plural(count, one, more.empty() ? one : more);
  };
  const PairCounts counts = CountsOf(study_);
  const KindRegistry& kinds = KindRegistry::Builtin();
  for (size_t i = 0; i < kinds.size(); ++i) {
    const auto count = at_work_.find(kinds.at(i).name());
    if (count != at_work_.end()) add(count->second, kinds.at(i).traits().doing);
  }
  add(JobsInState(study_, "READY"), "waiting");
  add(JobsInState(study_, "RETRY_WAIT"), "to be tried again");
  add(counts.layouts_reused, "layout reused", "layouts reused");
  add(counts.reused, "frame reused", "frames reused");
  add(counts.rejected, "scene rejected", "scenes rejected");
  add(counts.failed, study_.state() == v1::STUDY_STATE_SUCCEEDED ? "failed before" : "failed");
  return line;
}

std::vector<std::string> ProgressView::LinesBelow(const Terminal& terminal) const {
  std::vector<std::string> lines;
  for (const std::string& line : OtherJobLines(study_)) lines.push_back("  " + line);
  constexpr size_t kMostShown = 4;
  for (size_t i = 0; i < labelled_.size() && i < kMostShown; ++i) {
    lines.push_back("  " + labelled_[i].kind() + " " + labelled_[i].label() + ": " +
                    DescribeProgress(labelled_[i]));
  }
  if (labelled_.size() > kMostShown) {
    lines.push_back("  and " + FormatCount(static_cast<int64_t>(labelled_.size() - kMostShown)) +
                    " more running");
  }
  if (const std::string jobs = JobsLine(); !jobs.empty()) {
    lines.push_back("  " + terminal.Paint(Tone::kDim, jobs));
  }
  for (const v1::WaitingJobs& jobs : Waiting()) {
    const Tone tone = WantsAttention(jobs) ? Tone::kWarning : Tone::kDim;
    lines.push_back("  " + terminal.Paint(tone, WaitingText(jobs)));
  }
  return lines;
}

std::vector<std::string> ProgressView::Lines(const Terminal& terminal) const {
  struct Row {
    std::string name;
    PairCounts counts;
    double begun_pairs;
    const RateEstimator* rate;
  };
  std::vector<Row> rows;
  double begun = 0;
  for (const v1::VariantStatus& status : study_.variants()) {
    const Variant& variant = variants_.at(status.name());
    rows.push_back({status.name(), CountsOf(status), variant.begun_pairs, &variant.rate});
    begun += variant.begun_pairs;
  }
  if (rows.size() > 1) rows.push_back({"total", CountsOf(study_), begun, &rate_});

  const auto pairs = [](const Row& row) {
    return FormatCount(row.counts.done) + "/" + FormatCount(row.counts.wanted);
  };
  int name_width = 0;
  int count_width = 0;
  for (const Row& row : rows) {
    name_width = std::max(name_width, DisplayWidth(row.name));
    count_width = std::max(count_width, DisplayWidth(pairs(row)));
  }
  // Bars take what names, counts, percentage, rate and ETA leave.
  const int bar = std::clamp(terminal.size().columns - name_width - count_width - 48, 8, 40);
  const auto line_of = [&](const Row& row) {
    const double wanted = static_cast<double>(std::max<int64_t>(1, row.counts.wanted));
    const double done = static_cast<double>(row.counts.done);
    std::string line = "  " + Pad(row.name, name_width) + "  " +
                       ProgressBar(terminal, done / wanted, row.begun_pairs / wanted, bar) + "  " +
                       Pad(pairs(row), count_width, Align::kRight) + "  " +
                       Pad(FormatPercent(done, wanted), 4, Align::kRight);
    if (row.counts.done >= row.counts.wanted) {
      line += "  " + terminal.Paint(Tone::kGood, "done");
    } else if (study_.state() == v1::STUDY_STATE_RUNNING && row.rate->PerSecond()) {
      line += "  " + Pad(FormatRate(row.rate->PerSecond()), 14, Align::kRight) + "  " +
              FormatEta(row.rate->SecondsFor(wanted - done - row.begun_pairs));
    }
    return line;
  };

  std::vector<std::string> lines;
  lines.push_back(terminal.Paint(Tone::kBold, study_.name()) + "  " +
                  PaintedState(terminal, study_.state()) + "  " +
                  FormatDuration(now_s_ - start_s_));
  // A line stands for the bars that do not fit on the screen; the last line always fits.
  const std::vector<std::string> below = LinesBelow(terminal);
  const int taken = 3 + std::max(1, static_cast<int>(below.size()));
  const size_t room = static_cast<size_t>(std::max(2, terminal.size().rows - taken));
  const size_t shown = rows.size() <= room ? rows.size() : room - 2;
  for (size_t i = 0; i < shown; ++i) lines.push_back(line_of(rows[i]));
  if (shown < rows.size()) {
    lines.push_back("  and " +
                    Plural(static_cast<int64_t>(rows.size() - shown - 1), "more variant"));
    lines.push_back(line_of(rows.back()));
  }
  lines.insert(lines.end(), below.begin(), below.end());
  return lines;
}

std::string ProgressView::EtaText() const {
  const auto left_s = SecondsLeft();
  const auto to_pairs_s = SecondsToPairs();
  if (left_s || !to_pairs_s) return FormatEta(left_s);
  return "pairs in " + FormatAbout(*to_pairs_s);
}

std::string ProgressView::PlainLine() const {
  const PairCounts counts = CountsOf(study_);
  const double wanted = static_cast<double>(counts.wanted);
  const double done = static_cast<double>(counts.done);
  std::string line = Pad(FormatDuration(now_s_ - start_s_), 7, Align::kRight) + "  " +
                     FormatCount(counts.done) + "/" + FormatCount(counts.wanted) + " pairs (" +
                     FormatPercent(done, wanted) + ")";
  if (const auto rate = rate_.PerSecond()) {
    line += "  " + FormatRate(rate);
    if (!IsFinished(study_.state())) line += "  " + EtaText();
  }
  if (study_.state() != v1::STUDY_STATE_RUNNING) line += "  " + StateName(study_.state());
  if (const std::string jobs = JobsLine(); !jobs.empty()) line += "  " + jobs;
  for (const std::string& others : OtherJobLines(study_)) line += "; " + others;
  for (const v1::JobStatus& job : labelled_) {
    if (job.figures().empty()) continue;
    line += "; " + job.kind() + " " + job.label() + ": " + DescribeProgress(job);
    break;  // One tells enough.
  }
  for (const v1::WaitingJobs& jobs : Waiting()) line += "; " + WaitingText(jobs);
  return line;
}

Json ProgressView::Json() const {
  const std::vector<v1::WaitingJobs> waiting = Waiting();
  const PairCounts counts = CountsOf(study_);
  nlohmann::ordered_json json = {{"study_id", study_.study_id()},
                                 {"name", study_.name()},
                                 {"state", StateName(study_.state())},
                                 {"pairs_done", counts.done},
                                 {"pairs_wanted", counts.wanted},
                                 {"elapsed_s", now_s_ - start_s_},
                                 {"pairs_per_hour", OptionalJson(PerHour(rate_.PerSecond()))},
                                 {"eta_s", OptionalJson(SecondsLeft())}};
  auto& running = json["running"] = nlohmann::ordered_json::array();
  for (const v1::JobStatus& job : labelled_) {
    running.push_back(
        {{"kind", job.kind()},
         {"label", job.label()},
         {"fraction", job.fraction()},
         {"figures", std::map<std::string, double>(job.figures().begin(), job.figures().end())}});
  }
  json["waiting"] = WaitingJson({waiting.begin(), waiting.end()});
  auto& list = json["variants"] = nlohmann::ordered_json::array();
  for (const v1::VariantStatus& status : study_.variants()) {
    const Variant& variant = variants_.at(status.name());
    list.push_back({{"name", status.name()},
                    {"pairs_done", status.pairs_done()},
                    {"pairs_wanted", status.pairs_wanted()},
                    {"pairs_per_hour", OptionalJson(PerHour(variant.rate.PerSecond()))},
                    {"eta_s", OptionalJson(variant.rate.SecondsFor(static_cast<double>(
                                  status.pairs_wanted() - status.pairs_done())))}});
  }
  return json;
}

}  // namespace parallax::client
