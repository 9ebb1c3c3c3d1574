#include "coordinator/client/views/run_report.h"

#include <nlohmann/json.hpp>

#include "coordinator/client/views/study_view.h"
#include "coordinator/client/views/text.h"

namespace parallax::client {
namespace {

double CoreSecondsAPair(const RunReport& report) {
  return report.pairs_rendered > 0
             ? report.core_seconds / static_cast<double>(report.pairs_rendered)
             : 0;
}

// Pairs have a rate of their own only where all of the run's time went into them.
bool MadePairsOnly(const RunReport& report) {
  return report.trainings == 0 && report.evaluations == 0;
}

std::string RenderedText(const RunReport& report) {
  const std::string pairs = Plural(report.pairs_rendered, "pair");
  if (!MadePairsOnly(report)) return pairs;
  const double per_hour = report.elapsed_s > 0
                              ? 3600 * static_cast<double>(report.pairs_rendered) / report.elapsed_s
                              : 0;
  return pairs + ", " + FormatNumber(CoreSecondsAPair(report)) + " core-seconds a pair, " +
         FormatNumber(per_hour) + " pairs/h";
}

std::string Headline(const Terminal& terminal, const RunReport& report, const PairCounts& counts) {
  if (report.study.state() != v1::STUDY_STATE_SUCCEEDED) {
    return terminal.Paint(Tone::kBad, "failed") + ": " + FormatCount(counts.done) + " of " +
           Plural(counts.wanted, "pair") + " were made";
  }
  if (report.pairs_rendered == 0) {
    return terminal.Paint(Tone::kGood, "nothing to render") + ": all " +
           Plural(counts.wanted, "pair") + " were there already";
  }
  return terminal.Paint(Tone::kGood, "done") + ": " + Plural(counts.wanted, "pair") + " in " +
         FormatDuration(report.elapsed_s);
}

}  // namespace

void PrintRunReport(const Terminal& terminal, const RunReport& report) {
  std::ostream& out = *terminal.stream;
  const PairCounts counts = CountsOf(report.study);
  const auto line = [&](const char* name, const std::string& value) {
    out << "  " << Pad(name, 10) << "  " << value << "\n";
  };
  out << terminal.Paint(Tone::kBold, report.study.name()) << " "
      << Headline(terminal, report, counts) << "\n";
  if (report.pairs_rendered > 0) {
    line("rendered", RenderedText(report));
    if (const int64_t kept = counts.done - report.pairs_rendered; kept > 0) {
      line("kept", Plural(kept, "pair") + " from earlier runs");
    }
  }
  if (counts.layouts_reused > 0) {
    line("layouts", Plural(counts.layouts_reused, "solve saved", "solves saved") +
                        " by sharing between variants");
  }
  if (counts.rejected > 0) {
    line("rejected", Plural(counts.rejected, "scene") + " without a valid layout, replaced");
  }
  if (report.worker_crashes > 0) {
    line("crashes", Plural(report.worker_crashes, "worker crash", "worker crashes") +
                        "; lost work was done again");
  }
  if (counts.failed > 0) {
    line("failed", Plural(counts.failed, "job") + (report.study.state() == v1::STUDY_STATE_SUCCEEDED
                                                       ? "; other tries did their work"
                                                       : ""));
  }
  line("dataset", report.out_dir + " (" + Plural(report.frames_in_dataset, "pair") + ")");
  if (!report.contact_sheet.empty()) {
    line("sheet", report.contact_sheet);
    line("histograms", report.histograms);
  }
  if (report.warp_median_difference >= 0) {
    line("check", "right warped onto left differs by " +
                      FormatNumber(report.warp_median_difference) + "/255 in the median");
  }
  if (report.trainings > 0) {
    line("networks", Plural(report.trainings, "training") + " in " + report.out_dir + "/training");
  }
  if (report.evaluations > 0) {
    line("scores", Plural(report.evaluations, "evaluation") + " in " + report.out_dir + "/scores");
  }
  if (!report.table.empty()) {
    line("table", report.out_dir + "/table.txt, table.md, table.json");
    out << "\n" << report.table;
  }
}

nlohmann::ordered_json RunReportJson(const RunReport& report) {
  const auto path = [](const std::string& text) {
    return text.empty() ? nlohmann::ordered_json(nullptr) : nlohmann::ordered_json(text);
  };
  nlohmann::ordered_json json = StudyJson(report.study);
  json["pairs_rendered"] = report.pairs_rendered;
  json["frames_in_dataset"] = report.frames_in_dataset;
  json["elapsed_s"] = report.elapsed_s;
  json["core_seconds"] = report.core_seconds;
  json["core_seconds_per_pair"] =
      MadePairsOnly(report) ? nlohmann::ordered_json(CoreSecondsAPair(report)) : nullptr;
  json["worker_crashes"] = report.worker_crashes;
  json["dataset"] = report.out_dir;
  json["contact_sheet"] = path(report.contact_sheet);
  json["histograms"] = path(report.histograms);
  json["warp_median_difference"] = report.warp_median_difference;
  json["trainings"] = report.trainings;
  json["evaluations"] = report.evaluations;
  json["set_aside"] = report.set_aside;
  json["table"] = path(report.table.empty() ? "" : report.out_dir + "/table.json");
  return json;
}

}  // namespace parallax::client
