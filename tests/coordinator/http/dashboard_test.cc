// The Grafana board names only metrics that exist, and its panels don't lie on each other.
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <regex>
#include <set>

#include "coordinator/http/metrics_text.h"

namespace parallax {
namespace {

nlohmann::json Board() {
  std::ifstream file(PARALLAX_SOURCE_DIR "/deploy/dashboards/parallax.json");
  return nlohmann::json::parse(file);
}

// A farm at work: everything that has labels has one of each.
StatusSnapshot Farm() {
  StatusSnapshot snapshot;
  snapshot.queue.jobs[{"render", "READY"}] = 1;
  snapshot.queue.commit_bounds_s = snapshot.queue.batch_bounds = {1};
  snapshot.queue.commit_counts = snapshot.queue.batch_counts = {1, 1};
  snapshot.server.reports["OK"] = 1;
  snapshot.server.stages["trace"] = {1, 2.0};
  snapshot.server.work["render"] = {1, 2.0, 3.0};
  snapshot.server.lease_latency_bounds_s = {1};
  snapshot.server.lease_latency_counts = {1, 1};
  snapshot.workers.emplace_back().set_state("busy");
  v1::StudyStatus& study = snapshot.studies.emplace_back();
  study.set_study_id(9);
  study.add_variants()->set_name("only");
  snapshot.eta_s[9] = 60;
  return snapshot;
}

std::set<std::string> NamesIn(const std::string& text) {
  static const std::regex kName("parallax_[a-z_]+");
  return {std::sregex_token_iterator(text.begin(), text.end(), kName),
          std::sregex_token_iterator()};
}

// Names of the exported samples, comments left out.
std::set<std::string> Exported() {
  std::istringstream text(MetricsText(Farm()));
  std::set<std::string> names;
  for (std::string line; std::getline(text, line);) {
    if (!line.empty() && line[0] != '#') names.insert(line.substr(0, line.find_first_of("{ ")));
  }
  return names;
}

TEST(Dashboard, NamesOnlyMetricsThatAreExported) {
  const std::set<std::string> exported = Exported();
  size_t targets = 0;
  const auto board = Board();
  for (const auto& panel : board["panels"]) {
    if (panel["type"] == "row") continue;
    ASSERT_FALSE(panel["targets"].empty()) << panel["title"];
    for (const auto& target : panel["targets"]) {
      const std::set<std::string> names = NamesIn(target["expr"]);
      EXPECT_FALSE(names.empty()) << panel["title"];
      for (const std::string& name : names) {
        EXPECT_EQ(exported.count(name), 1u) << name << " in " << panel["title"];
      }
      ++targets;
    }
  }
  EXPECT_GT(targets, 20u);
}

TEST(Dashboard, ShowsEverythingThatAFarmIsWatchedBy) {
  const std::set<std::string> shown = NamesIn(Board().dump());
  for (const char* name :
       {"parallax_jobs", "parallax_lease_latency_seconds_bucket", "parallax_commit_batch_sum",
        "parallax_commit_seconds_bucket", "parallax_attempts_total", "parallax_reports_total",
        "parallax_workers", "parallax_stage_seconds_total", "parallax_pairs_per_hour",
        "parallax_study_eta_seconds"}) {
    EXPECT_EQ(shown.count(name), 1u) << name;
  }
}

TEST(Dashboard, PanelsHaveTheirOwnPlaceAndNumber) {
  std::set<int> ids;
  std::set<std::pair<int, int>> taken;
  const auto board = Board();
  for (const auto& panel : board["panels"]) {
    EXPECT_TRUE(ids.insert(panel["id"].get<int>()).second) << panel["title"];
    const auto& place = panel["gridPos"];
    const int left = place["x"], top = place["y"], width = place["w"], height = place["h"];
    EXPECT_LE(left + width, 24);
    for (int x = left; x < left + width; ++x) {
      for (int y = top; y < top + height; ++y) {
        EXPECT_TRUE(taken.insert({x, y}).second) << panel["title"];
      }
    }
  }
}

}  // namespace
}  // namespace parallax
