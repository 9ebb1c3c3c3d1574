#include "coordinator/client/progress_view.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>

#include "coordinator/client/study_view.h"
#include "coordinator/client/text.h"

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

void ProgressView::Observe(double time_s, const v1::StudyStatus& study,
                           const v1::ListJobsReply& leased) {
  if (start_s_ < 0) start_s_ = time_s;
  now_s_ = time_s;
  study_ = study;
  solving_ = rendering_ = 0;
  for (auto& [name, variant] : variants_) variant.begun_pairs = 0;
  for (const v1::JobStatus& job : leased.jobs()) {
    if (job.kind() == v1::JOB_KIND_SOLVE) {
      ++solving_;
      continue;
    }
    ++rendering_;
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
  add(solving_, "solving");
  add(rendering_, "rendering");
  add(JobsInState(study_, "READY"), "waiting");
  add(JobsInState(study_, "RETRY_WAIT"), "to be tried again");
  add(counts.layouts_reused, "layout reused", "layouts reused");
  add(counts.reused, "frame reused", "frames reused");
  add(counts.rejected, "scene rejected", "scenes rejected");
  add(counts.failed, "failed");
  return line;
}

std::vector<std::string> ProgressView::Lines(const Terminal& terminal) const {
  std::vector<std::string> lines;
  lines.push_back(terminal.Paint(Tone::kBold, study_.name()) + "  " +
                  PaintedState(terminal, study_.state()) + "  " +
                  FormatDuration(now_s_ - start_s_));
  int name_width = 0;
  int count_width = 0;
  std::vector<std::string> counts_text;
  for (const v1::VariantStatus& status : study_.variants()) {
    name_width = std::max(name_width, DisplayWidth(status.name()));
    counts_text.push_back(FormatCount(status.pairs_done()) + "/" +
                          FormatCount(status.pairs_wanted()));
    count_width = std::max(count_width, DisplayWidth(counts_text.back()));
  }
  // Bars take what names, counts, percentage, rate and ETA leave.
  const int bar = std::clamp(terminal.size().columns - name_width - count_width - 48, 8, 40);
  // Bars that would not fit on the screen are told of in a line.
  const int room = std::max(1, terminal.size().rows - 5);
  int shown = 0;
  for (const v1::VariantStatus& status : study_.variants()) {
    if (shown == room && study_.variants_size() > room) {
      lines.push_back("  and " + Plural(study_.variants_size() - shown, "more variant"));
      break;
    }
    const Variant& variant = variants_.at(status.name());
    const double wanted = static_cast<double>(std::max<int64_t>(1, status.pairs_wanted()));
    const double done = static_cast<double>(status.pairs_done());
    const bool complete = status.pairs_done() >= status.pairs_wanted();
    const bool running = study_.state() == v1::STUDY_STATE_RUNNING;
    std::string line = "  " + Pad(status.name(), name_width) + "  " +
                       ProgressBar(terminal, done / wanted, variant.begun_pairs / wanted, bar) +
                       "  " +
                       Pad(counts_text[static_cast<size_t>(shown)], count_width, Align::kRight) +
                       "  " + Pad(FormatPercent(done, wanted), 4, Align::kRight);
    if (complete) {
      line += "  " + terminal.Paint(Tone::kGood, "done");
    } else if (running) {
      const double remaining = wanted - done - variant.begun_pairs;
      line += "  " + Pad(FormatRate(variant.rate.PerSecond()), 14, Align::kRight) + "  " +
              FormatEta(variant.rate.SecondsFor(remaining));
    }
    lines.push_back(std::move(line));
    ++shown;
  }
  if (const std::string jobs = JobsLine(); !jobs.empty()) {
    lines.push_back("  " + terminal.Paint(Tone::kDim, jobs));
  }
  return lines;
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
    if (!IsFinished(study_.state())) line += "  " + FormatEta(rate_.SecondsFor(wanted - done));
  }
  if (study_.state() != v1::STUDY_STATE_RUNNING) line += "  " + StateName(study_.state());
  if (const std::string jobs = JobsLine(); !jobs.empty()) line += "  " + jobs;
  return line;
}

Json ProgressView::Json() const {
  const PairCounts counts = CountsOf(study_);
  nlohmann::ordered_json json = {
      {"study_id", study_.study_id()},
      {"name", study_.name()},
      {"state", StateName(study_.state())},
      {"pairs_done", counts.done},
      {"pairs_wanted", counts.wanted},
      {"elapsed_s", now_s_ - start_s_},
      {"pairs_per_hour", OptionalJson(PerHour(rate_.PerSecond()))},
      {"eta_s", OptionalJson(rate_.SecondsFor(static_cast<double>(counts.wanted - counts.done)))}};
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
