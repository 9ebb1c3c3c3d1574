#include "coordinator/http/status_page.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>

#include "tests/job_messages.h"

namespace parallax {
namespace {

StatusSnapshot Example() {
  StatusSnapshot snapshot;
  snapshot.version = "1.2.3";
  snapshot.store_uri = "file:///srv/parallax";
  snapshot.uptime_s = 93'784;
  snapshot.now_unix_s = 10'000;
  snapshot.pairs_per_hour = 431.4;
  snapshot.server.workers_connected = 2;
  snapshot.server.slots = 12;
  snapshot.server.running = 9;
  snapshot.queue.jobs[{"render", "READY"}] = 1234;
  const struct {
    const char* name;
    v1::StudyState state;
    double finished;
  } studies[] = {{"baseline", v1::STUDY_STATE_RUNNING, 0},
                 {"<b>materials</b>", v1::STUDY_STATE_FAILED, 9000}};
  for (const auto& row : studies) {
    v1::StudyStatus& study = snapshot.studies.emplace_back();
    study.set_study_id(static_cast<int64_t>(snapshot.studies.size()));
    study.set_name(row.name);
    study.set_state(row.state);
    study.set_submitted_unix_s(4000);
    study.set_finished_unix_s(row.finished);
    const char* variants[] = {"narrow", "medium", "wide"};
    for (int i = 0; i < 3; ++i) {
      v1::VariantStatus& variant = *study.add_variants();
      variant.set_name(variants[i]);
      variant.set_pairs_wanted(5000);
      variant.set_pairs_done(i == 2 ? 5000 : 1250 * (i + 1));
      AddJobCount(variant, "render", "LEASED", 4);
      AddJobCount(variant, "solve", "READY", 40);
      variant.set_layouts_reused(250);
    }
  }
  v1::JobProblem& problem = *snapshot.studies[1].mutable_variants(0)->add_problems();
  problem.set_job_id(17);
  problem.set_state("QUARANTINED");
  problem.set_scene(42);
  problem.set_error("INTERNAL: <script>alert(1)</script>");
  const char* states[] = {"busy", "idle", "away", "lost"};
  for (const char* state : states) {
    v1::WorkerStatus& worker = snapshot.workers.emplace_back();
    worker.set_name(std::string("render-node-") + state);
    worker.set_state(state);
    worker.add_kinds("render");
    worker.set_slots(4);
    worker.set_running(3);
    worker.set_last_heard_s(2);
    worker.set_version("1.2.3");
  }
  return snapshot;
}

TEST(StatusPage, ShowsStudiesVariantsWorkersAndProblems) {
  const std::string page = StatusPage(Example());
  // For looking at it: PARALLAX_STATUS_PAGE=/tmp/status.html http_test
  if (const char* path = std::getenv("PARALLAX_STATUS_PAGE")) std::ofstream(path) << page;
  for (const char* text :
       {"baseline", "narrow", "width:25.0%", "1&#8201;250 / 5&#8201;000", "4 running, 40 ready",
        "render-node-lost", "QUARANTINED", "scene 42", "1 d 2 h", "431", "1&#8201;234"}) {
    EXPECT_NE(page.find(text), std::string::npos) << text;
  }
}

TEST(StatusPage, EscapesWhatStrangersNamed) {
  const std::string page = StatusPage(Example());
  EXPECT_EQ(page.find("<script>"), std::string::npos);
  EXPECT_EQ(page.find("<b>materials"), std::string::npos);
  EXPECT_NE(page.find("&lt;script&gt;alert(1)"), std::string::npos);
}

TEST(StatusPage, SaysWhatToDoWhenThereIsNothingYet) {
  const std::string page = StatusPage(StatusSnapshot());
  EXPECT_NE(page.find("parallax submit"), std::string::npos);
  EXPECT_NE(page.find("No worker"), std::string::npos);
}

TEST(StatusPage, WritesDurationsAndCountsForPeople) {
  EXPECT_EQ(DurationText(5.4), "5 s");
  EXPECT_EQ(DurationText(-3), "0 s");
  EXPECT_EQ(DurationText(125), "2 min 5 s");
  EXPECT_EQ(DurationText(3600 * 5 + 60 * 7), "5 h 7 min");
  EXPECT_EQ(DurationText(86400 * 3), "3 d");
  EXPECT_EQ(CountText(0), "0");
  EXPECT_EQ(CountText(-1234567), "-1&#8201;234&#8201;567");
}

}  // namespace
}  // namespace parallax
