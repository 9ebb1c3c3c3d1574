#include "coordinator/http/metrics_text.h"

#include <gtest/gtest.h>

#include <set>
#include <sstream>

namespace parallax {
namespace {

StatusSnapshot Example() {
  StatusSnapshot snapshot{.version = "1.2.3", .epoch = 4, .pairs_per_hour = 120};
  snapshot.queue.jobs[{"solve", "READY"}] = 3;
  snapshot.queue.jobs[{"render", "LEASED"}] = 2;
  snapshot.queue.commit_seconds = 0.25;
  snapshot.queue.checkpoints = 7;
  snapshot.queue.checkpoint_seconds = 0.125;
  snapshot.queue.commit_bounds_s = {0.001};
  snapshot.queue.commit_counts = {3, 4};
  snapshot.queue.commits = 4;
  snapshot.queue.commands = 40;
  snapshot.queue.leases_granted = 12;
  snapshot.queue.batch_bounds = {8};
  snapshot.queue.batch_counts = {1, 4};
  snapshot.server.stages["trace"] = {.count = 2, .seconds = 8.5};
  snapshot.server.work["render"] = {.jobs = 1, .wall_s = 9, .cpu_s = 16};
  snapshot.eta_s[9] = 270;
  snapshot.running.push_back({12, "odd", "train", "narrow, seed 1", {{"loss", 1.5}, {"step", 20}}});
  snapshot.server.reports["OK"] = 7;
  snapshot.server.lease_latency_bounds_s = {0.001, 0.1};
  snapshot.server.lease_latency_counts = {1, 5, 6};
  snapshot.server.lease_latency_sum_s = 0.5;
  snapshot.space = {.results_bytes = 5000,
                    .disks = {{"store", {300, 1000}}, {"database", {200, 900}}}};
  snapshot.workers.emplace_back().set_state("busy");
  snapshot.workers.emplace_back().set_state("busy");
  snapshot.now_unix_s = 1000;
  v1::StreamStatus& stream = snapshot.streams.emplace_back();
  stream.set_name("rooms");
  stream.set_chunks_begun(7);
  stream.set_chunks_made(6);
  stream.set_chunks_forgotten(4);
  stream.set_pairs_kept(400);
  stream.set_needs("chunk 6 is paused");
  for (int rank = 0; rank < 2; ++rank) {
    v1::StreamConsumer& consumer = *stream.add_consumers();
    consumer.set_name("raft");
    consumer.set_rank(rank);
    consumer.set_heard_unix_s(rank * 990.0);  // Rank 0 was not heard yet.
  }
  v1::StreamStatus& closed = snapshot.streams.emplace_back(stream);
  closed.set_name("old");
  closed.set_closed(true);
  v1::SearchStatus& search = snapshot.searches.emplace_back();
  search.set_name("camera");
  search.set_state("running");
  search.set_needs("sampler steps: exit status 7");
  v1::SearchStatus& ended = snapshot.searches.emplace_back(search);
  ended.set_name("last");
  ended.set_state("ended");
  v1::StudyStatus& study = snapshot.studies.emplace_back();
  study.set_study_id(9);
  study.set_name("odd \"name\"\n");
  v1::WaitingJobs& waiting = *study.add_waiting();
  waiting.set_kind("train");
  waiting.set_jobs(4);
  waiting.set_reason("trainer");
  *study.add_waiting() = waiting;
  study.add_variants()->set_name("narrow");
  study.mutable_variants(0)->set_pairs_done(11);
  study.mutable_variants(0)->set_pairs_wanted(20);
  return snapshot;
}

bool HasLine(const std::string& text, const std::string& line) {
  return ("\n" + text).find("\n" + line + "\n") != std::string::npos;
}

TEST(MetricsText, HasASampleForEachThingWorthWatching) {
  const std::string text = MetricsText(Example());
  for (const char* line : {
           "parallax_info{version=\"1.2.3\",schema_version=\"0\"} 1",
           "parallax_jobs{kind=\"solve\",state=\"READY\"} 3",
           "parallax_jobs{kind=\"render\",state=\"LEASED\"} 2",
           "parallax_jobs_waiting{kind=\"train\",reason=\"trainer\"} 8",
           "parallax_commit_seconds_total 0.25",
           "parallax_checkpoints_total 7",
           "parallax_checkpoint_seconds_total 0.125",
           "parallax_commit_seconds_bucket{le=\"0.001\"} 3",
           "parallax_commit_seconds_bucket{le=\"+Inf\"} 4",
           "parallax_commit_seconds_sum 0.25",
           "parallax_commit_batch_bucket{le=\"8\"} 1",
           "parallax_commit_batch_sum 40",
           "parallax_attempts_total{outcome=\"leased\"} 12",
           "parallax_stage_seconds_total{stage=\"trace\"} 8.5",
           "parallax_stage_runs_total{stage=\"trace\"} 2",
           "parallax_job_cpu_seconds_total{kind=\"render\"} 16",
           "parallax_study_eta_seconds{study=\"odd \\\"name\\\"\\n\",study_id=\"9\"} 270",
           "parallax_workers{state=\"busy\"} 2",
           "parallax_reports_total{outcome=\"OK\"} 7",
           "parallax_lease_latency_seconds_bucket{le=\"0.001\"} 1",
           "parallax_lease_latency_seconds_bucket{le=\"+Inf\"} 6",
           "parallax_lease_latency_seconds_sum 0.5",
           "parallax_lease_latency_seconds_count 6",
           "parallax_pairs_per_hour 120",
           "parallax_stream_chunks_begun{stream=\"rooms\"} 7",
           "parallax_stream_chunks_made{stream=\"rooms\"} 6",
           "parallax_stream_chunks_forgotten{stream=\"rooms\"} 4",
           "parallax_stream_pairs_kept{stream=\"rooms\"} 400",
           "parallax_stream_consumers{stream=\"rooms\"} 2",
           "parallax_stream_needs_person{stream=\"rooms\"} 1",
           "parallax_stream_needs_person{stream=\"old\"} 0",
           "parallax_stream_consumer_silent_seconds{stream=\"rooms\",consumer=\"raft\",rank=\"1\"} "
           "10",
           "parallax_search_needs_person{search=\"camera\"} 1",
           "parallax_search_needs_person{search=\"last\"} 0",
           "parallax_search_open{search=\"last\"} 0",
           "parallax_store_results_bytes 5000",
           "parallax_disk_free_bytes{of=\"store\"} 300",
           "parallax_disk_bytes{of=\"database\"} 900",
           "parallax_job_figure{study=\"odd\",kind=\"train\",job_id=\"12\",label=\"narrow, seed "
           "1\",figure=\"loss\"} 1.5",
           "parallax_pairs_published{study=\"odd \\\"name\\\"\\n\",study_id=\"9\",variant="
           "\"narrow\"} 11",
       }) {
    EXPECT_TRUE(HasLine(text, line)) << line << "\nnot in\n" << text;
  }
}

TEST(MetricsText, DemandIsWhatMayStartAndWhatRunsWithoutPausedStudies) {
  StatusSnapshot snapshot;
  const std::pair<const char*, int64_t> states[] = {
      {"BLOCKED", 100}, {"READY", 10}, {"RETRY_WAIT", 5}, {"LEASED", 2}, {"SUCCEEDED", 1000}};
  for (const auto& [state, count] : states) snapshot.queue.jobs[{"render", state}] = count;
  snapshot.queue.jobs[{"solve", "SUCCEEDED"}] = 3;
  EXPECT_TRUE(HasLine(MetricsText(snapshot), "parallax_demand_slots{kind=\"render\"} 17"));
  EXPECT_TRUE(HasLine(MetricsText(snapshot), "parallax_demand_slots{kind=\"solve\"} 0"));

  v1::StudyStatus& paused = snapshot.studies.emplace_back();
  paused.set_state(v1::STUDY_STATE_PAUSED);
  v1::VariantStatus* variant = paused.add_variants();
  for (const auto& [state, count] : {std::pair{"READY", 4}, std::pair{"LEASED", 1}}) {
    v1::JobCount* jobs = variant->add_jobs();
    jobs->set_kind("render");
    jobs->set_state(state);
    jobs->set_jobs(count);
  }
  EXPECT_TRUE(HasLine(MetricsText(snapshot), "parallax_demand_slots{kind=\"render\"} 13"));
  // A study counts alike if it is not among the newest.
  std::swap(snapshot.studies, snapshot.older_unfinished);
  EXPECT_TRUE(HasLine(MetricsText(snapshot), "parallax_demand_slots{kind=\"render\"} 13"));
  std::swap(snapshot.studies, snapshot.older_unfinished);
  // A limit holds three of the four back.
  paused.set_state(v1::STUDY_STATE_RUNNING);
  paused.set_held_jobs(3);
  EXPECT_TRUE(HasLine(MetricsText(snapshot), "parallax_demand_slots{kind=\"render\"} 14"));
}

TEST(MetricsText, DeclaresEachMetricOnceBeforeItsSamples) {
  std::istringstream lines(MetricsText(Example()));
  std::set<std::string> declared;
  for (std::string line; std::getline(lines, line);) {
    if (line.rfind("# TYPE ", 0) == 0) {
      const std::string name = line.substr(7, line.find(' ', 7) - 7);
      EXPECT_TRUE(declared.insert(name).second) << name << " declared twice";
    } else if (line[0] != '#') {
      std::string name = line.substr(0, line.find_first_of("{ "));
      for (const std::string suffix : {"_bucket", "_sum", "_count"}) {
        if (name.size() <= suffix.size() || !name.ends_with(suffix)) continue;
        const std::string histogram = name.substr(0, name.size() - suffix.size());
        if (declared.count(histogram) > 0) name = histogram;
      }
      EXPECT_EQ(declared.count(name), 1u) << line;
    }
  }
}

}  // namespace
}  // namespace parallax
