#include "coordinator/http/status_page.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "common/base/names.h"

namespace parallax {
namespace {

constexpr char kStyle[] = R"(
:root { color-scheme: light dark; --ink:#1b2230; --soft:#5d6b82; --line:#e2e7ef; --card:#fff; --back:#f4f6fa;
  --good:#1f8a5b; --run:#2f6fde; --warn:#b9770e; --bad:#c23b3b; --track:#e6ebf3; }
@media (prefers-color-scheme: dark) { :root { --ink:#e7ecf5; --soft:#95a3ba; --line:#2a3345; --card:#171d29;
  --back:#0f141d; --good:#43c08a; --run:#6a9dff; --warn:#e0a94a; --bad:#ef7676; --track:#252e3f; } }
* { box-sizing: border-box; }
body { margin:0; background:var(--back); color:var(--ink); font:14px/1.45 system-ui,"Segoe UI",Roboto,sans-serif; }
main { max-width:1080px; margin:0 auto; padding:28px 20px 60px; }
header { display:flex; align-items:baseline; gap:14px; flex-wrap:wrap; margin-bottom:20px; }
h1 { font-size:22px; margin:0; letter-spacing:-.01em; } h1 i { font-style:normal; color:var(--run); }
h2 { font-size:13px; text-transform:uppercase; letter-spacing:.08em; color:var(--soft); margin:30px 0 10px; }
h3 { font-size:16px; margin:0; } .soft { color:var(--soft); }
.tiles { display:grid; grid-template-columns:repeat(auto-fit,minmax(150px,1fr)); gap:12px; }
.card { background:var(--card); border:1px solid var(--line); border-radius:10px; padding:14px 16px; margin-bottom:12px; }
.tile { margin:0; } .tile b { display:block; font-size:24px; font-weight:600; font-variant-numeric:tabular-nums; }
.row { display:flex; justify-content:space-between; align-items:baseline; gap:12px; flex-wrap:wrap; }
table { width:100%; border-collapse:collapse; font-variant-numeric:tabular-nums; margin-top:8px; }
th { text-align:left; color:var(--soft); font-weight:500; font-size:12px; } td,th { padding:5px 18px 5px 0; }
tr + tr td { border-top:1px solid var(--line); } .num { text-align:right; }
.bar { height:8px; width:100%; min-width:110px; background:var(--track); border-radius:4px; overflow:hidden; }
.bar span { display:block; height:100%; background:var(--run); } .bar.done span { background:var(--good); }
.tag { font-size:12px; padding:1px 8px; border-radius:9px; border:1px solid currentColor; white-space:nowrap; }
.good { color:var(--good); } .run { color:var(--run); } .warn { color:var(--warn); } .bad { color:var(--bad); }
.problem { font:12px/1.5 ui-monospace,monospace; color:var(--bad); overflow-wrap:anywhere; margin-top:6px; }
)";

// Reloads itself; the page is cheap to make.
constexpr int kReload_s = 5;
constexpr int kProblemsShown = 3;

struct Look {
  const char* name;
  const char* style;
};

Look LookOf(v1::StudyState state) {
  switch (state) {
    case v1::STUDY_STATE_RUNNING:
      return {"running", "run"};
    case v1::STUDY_STATE_PAUSED:
      return {"paused", "warn"};
    case v1::STUDY_STATE_SUCCEEDED:
      return {"succeeded", "good"};
    case v1::STUDY_STATE_CANCELLED:
      return {"cancelled", "soft"};
    case v1::STUDY_STATE_FAILED:
      return {"failed", "bad"};
    default:
      return {"unknown", "soft"};
  }
}

const char* StyleOfWorker(const std::string& state) {
  if (state == "busy") return "run";
  if (state == "idle") return "good";
  if (state == "lost") return "bad";
  return state == "left" ? "soft" : "warn";
}

std::string Tag(const std::string& text, const char* style) {
  return std::string("<span class=\"tag ") + style + "\">" + EscapeHtml(text) + "</span>";
}

std::string Tile(const std::string& value, const std::string& label) {
  return "<div class=\"card tile\"><b>" + value + "</b><span class=\"soft\">" + label +
         "</span></div>";
}

std::string Bar(int64_t done, int64_t wanted) {
  const double percent =
      wanted > 0 ? 100.0 * static_cast<double>(done) / static_cast<double>(wanted) : 0;
  char width[32];
  std::snprintf(width, sizeof width, "%.1f%%", std::clamp(percent, 0.0, 100.0));
  return std::string("<div class=\"bar") + (done >= wanted ? " done" : "") +
         "\"><span style=\"width:" + width + "\"></span></div>";
}

int64_t StateCount(const v1::VariantStatus& variant, std::string_view state) {
  int64_t jobs = 0;
  for (const v1::JobCount& count : variant.jobs()) {
    if (count.state() == state) jobs += count.jobs();
  }
  return jobs;
}

// "2 running, 14 ready, 1 failed"
std::string JobsText(const v1::VariantStatus& variant) {
  const struct {
    const char* state;
    const char* label;
  } shown[] = {{"LEASED", "running"},   {"READY", "ready"},   {"BLOCKED", "waiting"},
               {"RETRY_WAIT", "retry"}, {"FAILED", "failed"}, {"QUARANTINED", "quarantined"},
               {"REJECTED", "rejected"}};
  std::string text;
  for (const auto& [state, label] : shown) {
    const int64_t count = StateCount(variant, state);
    if (count == 0) continue;
    if (!text.empty()) text += ", ";
    text += CountText(count) + " " + label;
  }
  return text;
}

std::string VariantRow(const v1::VariantStatus& variant) {
  return "<tr><td>" + EscapeHtml(variant.name()) + "</td><td style=\"width:34%\">" +
         Bar(variant.pairs_done(), variant.pairs_wanted()) + "</td><td class=\"num\">" +
         CountText(variant.pairs_done()) + " / " + CountText(variant.pairs_wanted()) +
         "</td><td class=\"soft\">" + JobsText(variant) + "</td><td class=\"num soft\">" +
         CountText(variant.solves_reused() + variant.layouts_reused()) + "</td></tr>\n";
}

std::string Problems(const v1::StudyStatus& study) {
  std::string html;
  for (const v1::VariantStatus& variant : study.variants()) {
    int shown = 0;
    for (const v1::JobProblem& problem : variant.problems()) {
      if (++shown > kProblemsShown) break;
      html += "<div class=\"problem\">" + EscapeHtml(variant.name()) + " scene " +
              std::to_string(problem.scene()) + ", job " + std::to_string(problem.job_id()) + " " +
              EscapeHtml(problem.state()) + ": " + EscapeHtml(problem.error()) + "</div>\n";
    }
  }
  return html;
}

std::string StudyCard(const v1::StudyStatus& study, const StatusSnapshot& snapshot) {
  const Look look = LookOf(study.state());
  const PairCount pairs = CountPairs(study);
  const bool ended = study.finished_unix_s() > 0;
  const double span_s =
      (ended ? study.finished_unix_s() : snapshot.now_unix_s) - study.submitted_unix_s();
  const auto eta = snapshot.eta_s.find(study.study_id());
  const std::string left =
      eta == snapshot.eta_s.end() ? "" : ", " + DurationText(eta->second) + " left";
  std::string html = "<section class=\"card\"><div class=\"row\"><h3>" + EscapeHtml(study.name()) +
                     " <span class=\"soft\">#" + std::to_string(study.study_id()) +
                     "</span></h3><span>" + CountText(pairs.done) + " of " +
                     CountText(pairs.wanted) + " pairs <span class=\"soft\">" +
                     (ended ? "in " : "for ") + DurationText(span_s) + left + "</span> " +
                     Tag(look.name, look.style) + "</span></div>\n";
  html +=
      "<table><tr><th>variant</th><th></th><th class=\"num\">pairs</th><th>jobs</th>"
      "<th class=\"num\">solves reused</th></tr>\n";
  for (const v1::VariantStatus& variant : study.variants()) html += VariantRow(variant);
  return html + "</table>" + Problems(study) + "</section>\n";
}

std::string WorkersCard(const std::vector<v1::WorkerStatus>& workers) {
  if (workers.empty()) {
    return "<section class=\"card soft\">No worker has connected yet.</section>";
  }
  std::string html =
      "<section class=\"card\"><table><tr><th>worker</th><th>state</th><th>takes</th>"
      "<th class=\"num\">running</th><th class=\"num\">slots</th><th class=\"num\">heard</th>"
      "<th>version</th></tr>\n";
  for (const v1::WorkerStatus& worker : workers) {
    std::string kinds;
    for (const std::string& kind : worker.kinds()) {
      kinds += (kinds.empty() ? "" : ", ") + EscapeHtml(kind);
    }
    html += "<tr><td>" + EscapeHtml(worker.name()) + "</td><td>" +
            Tag(worker.state(), StyleOfWorker(worker.state())) + "</td><td class=\"soft\">" +
            kinds + "</td><td class=\"num\">" + CountText(worker.running()) +
            "</td><td class=\"num\">" + CountText(worker.slots()) + "</td><td class=\"num soft\">" +
            DurationText(worker.last_heard_s()) + " ago</td><td class=\"soft\">" +
            EscapeHtml(worker.version()) + "</td></tr>\n";
  }
  return html + "</table></section>\n";
}

std::string Tiles(const StatusSnapshot& snapshot) {
  PairCount pairs;
  for (const v1::StudyStatus& study : snapshot.studies) {
    const PairCount of_study = CountPairs(study);
    pairs.done += of_study.done;
    pairs.wanted += of_study.wanted;
  }
  int64_t ready = 0;
  for (const auto& [key, count] : snapshot.queue.jobs) ready += key.second == "READY" ? count : 0;
  return "<div class=\"tiles\">" + Tile(CountText(pairs.done), "pairs published") +
         Tile(CountText(std::llround(snapshot.pairs_per_hour)), "pairs per hour") +
         Tile(CountText(snapshot.server.workers_connected), "workers connected") +
         Tile(CountText(snapshot.server.running) + " <span class=\"soft\">/ " +
                  CountText(snapshot.server.slots) + "</span>",
              "slots busy") +
         Tile(CountText(ready), "jobs ready") + "</div>\n";
}

}  // namespace

PairCount CountPairs(const v1::StudyStatus& study) {
  PairCount pairs;
  for (const v1::VariantStatus& variant : study.variants()) {
    pairs.done += variant.pairs_done();
    pairs.wanted += variant.pairs_wanted();
  }
  return pairs;
}

std::string EscapeHtml(std::string_view text) {
  std::string escaped;
  for (const char c : Printable(text)) {
    switch (c) {
      case '&':
        escaped += "&amp;";
        break;
      case '<':
        escaped += "&lt;";
        break;
      case '>':
        escaped += "&gt;";
        break;
      case '"':
        escaped += "&quot;";
        break;
      case '\'':
        escaped += "&#39;";
        break;
      default:
        escaped += c;
    }
  }
  return escaped;
}

std::string DurationText(double seconds) {
  const int64_t s = std::max<int64_t>(0, std::llround(seconds));
  const auto two = [](int64_t big, const char* big_unit, int64_t small, const char* small_unit) {
    std::string text = std::to_string(big) + " " + big_unit;
    if (small > 0) text += " " + std::to_string(small) + " " + small_unit;
    return text;
  };
  if (s < 60) return std::to_string(s) + " s";
  if (s < 3600) return two(s / 60, "min", s < 600 ? s % 60 : 0, "s");
  if (s < 86400) return two(s / 3600, "h", s % 3600 / 60, "min");
  return two(s / 86400, "d", s % 86400 / 3600, "h");
}

std::string CountText(int64_t count) {
  const std::string digits = std::to_string(count < 0 ? -count : count);
  std::string text = count < 0 ? "-" : "";
  for (size_t i = 0; i < digits.size(); ++i) {
    if (i > 0 && (digits.size() - i) % 3 == 0) text += "&#8201;";
    text += digits[i];
  }
  return text;
}

std::string StatusPage(const StatusSnapshot& snapshot) {
  std::string html =
      "<!doctype html><html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" "
      "content=\"width=device-width, initial-scale=1\"><meta http-equiv=\"refresh\" content=\"" +
      std::to_string(kReload_s) + "\"><title>Parallax coordinator</title><style>";
  html += kStyle;
  html += "</style></head><body><main>\n<header><h1><i>Parallax</i> coordinator</h1>";
  html += "<span class=\"soft\">version " + EscapeHtml(snapshot.version) + " &middot; up " +
          DurationText(snapshot.uptime_s) + " &middot; epoch " + std::to_string(snapshot.epoch) +
          " &middot; store " + EscapeHtml(snapshot.store_uri) + "</span></header>\n";
  html += Tiles(snapshot) + "<h2>Studies</h2>\n";
  if (snapshot.studies.empty()) {
    html +=
        "<section class=\"card soft\">Nothing submitted yet: parallax submit STUDY.yaml</section>";
  }
  for (const v1::StudyStatus& study : snapshot.studies) {
    html += StudyCard(study, snapshot);
  }
  html += "<h2>Workers</h2>\n" + WorkersCard(snapshot.workers) + "</main></body></html>\n";
  return html;
}

}  // namespace parallax
