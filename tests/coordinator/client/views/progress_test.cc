#include "coordinator/client/views/progress.h"

#include <fmt/core.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <sstream>
#include <tuple>

#include "coordinator/client/views/progress_view.h"

namespace parallax::client {
namespace {

TEST(Progress, BarIsFullOnlyWhenAllIsDone) {
  const Terminal ascii;
  EXPECT_EQ(ProgressBar(ascii, 0, 0, 4), "[....]");
  EXPECT_EQ(ProgressBar(ascii, 0.5, 0.25, 4), "[##=.]");
  EXPECT_EQ(ProgressBar(ascii, 0.999, 0, 4), "[###.]");
  EXPECT_EQ(ProgressBar(ascii, 1, 0.5, 4), "[####]");
  EXPECT_EQ(ProgressBar(ascii, 7, -3, 4), "[####]");
  Terminal unicode;
  unicode.unicode = true;
  EXPECT_EQ(ProgressBar(unicode, 0.5, 0.25, 4), "██▒░");
}

TEST(Progress, PercentagesRoundDownAndEstimatesToWhatIsKnown) {
  EXPECT_EQ(FormatPercent(999, 1000), "99%");
  EXPECT_EQ(FormatPercent(1000, 1000), "100%");
  EXPECT_EQ(FormatPercent(1, 0), "-");
  EXPECT_EQ(FormatEta(3.2), "ETA about 5 s");
  EXPECT_EQ(FormatEta(65), "ETA about 1 min");
  EXPECT_EQ(FormatEta(std::nullopt), "");
  EXPECT_EQ(FormatRate(0.1), "360 pairs/h");
  EXPECT_EQ(FormatRate(6103.0 / 3600), "6,100 pairs/h");
  EXPECT_EQ(FormatRate(std::nullopt), "-");
}

v1::StudyStatus TwoVariants(int64_t done_a, int64_t reused_a, int64_t done_b) {
  v1::StudyStatus study;
  study.set_study_id(7);
  study.set_name("baseline");
  study.set_state(v1::STUDY_STATE_RUNNING);
  v1::VariantStatus* a = study.add_variants();
  a->set_name("narrow");
  a->set_pairs_wanted(20);
  a->set_pairs_done(done_a);
  a->set_frames_reused(reused_a);
  v1::VariantStatus* b = study.add_variants();
  b->set_name("w");
  b->set_pairs_wanted(20);
  b->set_pairs_done(done_b);
  return study;
}

v1::ListJobsReply OneRender(const std::string& variant, int rigs, double fraction) {
  v1::ListJobsReply reply;
  v1::JobStatus* job = reply.add_jobs();
  job->set_kind("render");
  job->set_variant(variant);
  job->set_fraction(fraction);
  for (int i = 0; i < rigs; ++i) job->add_rigs(static_cast<uint32_t>(i));
  return reply;
}

TEST(ProgressView, ReusedFramesDoNotCountAsSpeed) {
  ProgressView view;
  view.Observe(100, TwoVariants(0, 0, 0), {});
  view.Observe(110, TwoVariants(10, 10, 0), {});
  EXPECT_EQ(view.Json()["pairs_per_hour"], nullptr);
  view.Observe(140, TwoVariants(14, 10, 0), {});
  EXPECT_DOUBLE_EQ(view.Json()["pairs_per_hour"].get<double>(), 360);
  EXPECT_EQ(view.Json()["pairs_done"], 14);
  EXPECT_DOUBLE_EQ(view.Json()["eta_s"].get<double>(), 260);
  EXPECT_DOUBLE_EQ(view.Json()["elapsed_s"].get<double>(), 40);
}

TEST(ProgressView, LeasedJobsMoveTheBarBetweenCompletions) {
  std::ostringstream stream;
  Terminal terminal;
  terminal.stream = &stream;
  terminal.size = [] { return TerminalSize{70, 24}; };
  ProgressView view;
  view.Observe(0, TwoVariants(0, 0, 20), {});
  view.Observe(60, TwoVariants(10, 0, 20), OneRender("narrow", 10, 0.5));
  const std::vector<std::string> lines = view.Lines(terminal);
  ASSERT_EQ(lines.size(), 5u);
  EXPECT_EQ(lines[0], "baseline  running  1:00");
  EXPECT_EQ(lines[1], "  narrow  [#####===...]  10/20   50%     900 pairs/h  ETA about 20 s");
  EXPECT_EQ(lines[2], "  w       [###########]  20/20  100%  done");
  EXPECT_EQ(lines[3], "  total   [########=..]  30/40   75%     900 pairs/h  ETA about 20 s");
  EXPECT_EQ(lines[4], "  1 rendering");
}

TEST(ProgressView, MoreVariantsThanRowsAreCounted) {
  std::ostringstream stream;
  Terminal terminal;
  terminal.stream = &stream;
  terminal.size = [] { return TerminalSize{80, 8}; };
  v1::StudyStatus study;
  study.set_name("many");
  study.set_state(v1::STUDY_STATE_RUNNING);
  for (int i = 0; i < 9; ++i) study.add_variants()->set_name(fmt::format("v{}", i));
  ProgressView view;
  view.Observe(0, study, {});
  const std::vector<std::string> lines = view.Lines(terminal);
  ASSERT_EQ(lines.size(), 5u);
  EXPECT_THAT(lines[2], testing::StartsWith("  v1 "));
  EXPECT_EQ(lines[3], "  and 7 more variants");
  EXPECT_THAT(lines[4], testing::StartsWith("  total "));
}

TEST(ProgressView, PlainLineTellsAllInOne) {
  ProgressView view;
  view.Observe(0, TwoVariants(0, 0, 0), {});
  view.Observe(3600, TwoVariants(10, 0, 10), OneRender("narrow", 4, 0));
  EXPECT_EQ(view.PlainLine(),
            "1:00:00  20/40 pairs (50%)  20.0 pairs/h  ETA about 1 h  1 rendering");
}

// ---- Jobs without a scene
v1::StudyStatus WithJobs(std::initializer_list<std::tuple<const char*, const char*, int>> counts) {
  v1::StudyStatus study = TwoVariants(20, 0, 20);
  for (const auto& [kind, state, jobs] : counts) {
    v1::JobCount* count = study.mutable_variants(0)->add_jobs();
    count->set_kind(kind);
    count->set_state(state);
    count->set_jobs(jobs);
  }
  return study;
}
v1::ListJobsReply OneTraining() {
  v1::ListJobsReply reply;
  v1::JobStatus* job = reply.add_jobs();
  job->set_kind("train");
  job->set_state("LEASED");
  job->set_variant("narrow");
  job->set_label("narrow, seed 1");
  job->set_fraction(0.28);
  job->set_stage("train");
  auto& figures = *job->mutable_figures();
  figures["step"] = 420;
  figures["steps"] = 1500;
  figures["loss"] = 1.8279;
  figures["eta_s"] = 540;
  return reply;
}

TEST(ProgressView, ATrainingTellsItsStepLossAndTime) {
  std::ostringstream stream;
  Terminal terminal;
  terminal.stream = &stream;
  terminal.size = [] { return TerminalSize{70, 24}; };
  ProgressView view;
  view.Observe(0, WithJobs({{"train", "LEASED", 1}, {"train", "SUCCEEDED", 2}}), OneTraining());
  const std::vector<std::string> lines = view.Lines(terminal);
  ASSERT_EQ(lines.size(), 7u);
  EXPECT_EQ(lines[4], "  train: 2 done, 1 running");
  EXPECT_EQ(lines[5], "  train narrow, seed 1: step 420 of 1,500, loss 1.83, about 9 min left");
  EXPECT_EQ(lines[6], "  1 training");
  EXPECT_THAT(view.PlainLine(),
              testing::HasSubstr("; train: 2 done, 1 running; train narrow, seed 1: step 420 of "
                                 "1,500, loss 1.83, about 9 min left"));
  const auto json = view.Json();
  EXPECT_EQ(json["running"][0]["label"], "narrow, seed 1");
  EXPECT_EQ(json["running"][0]["figures"]["loss"], 1.8279);
  EXPECT_EQ(json["eta_s"], 540) << "all pairs are there and nothing else is to come";
}

TEST(ProgressView, NobodyKnowsHowLongJobsThatAreToComeTake) {
  ProgressView view;
  view.Observe(0, WithJobs({{"train", "LEASED", 1}, {"train", "BLOCKED", 2}}), OneTraining());
  EXPECT_EQ(view.Json()["eta_s"], nullptr);
  EXPECT_THAT(view.PlainLine(), testing::HasSubstr("1 running, 2 to come"));
  EXPECT_THAT(view.PlainLine(), testing::Not(testing::HasSubstr("ETA")));
}

TEST(ProgressView, PairsDoNotEndAStudyThatTrains) {
  ProgressView view;
  v1::StudyStatus study = TwoVariants(20, 0, 10);
  v1::JobCount* count = study.mutable_variants(0)->add_jobs();
  count->set_kind("train");
  count->set_state("BLOCKED");
  count->set_jobs(2);
  view.Observe(0, study, {});
  study.mutable_variants(1)->set_pairs_done(15);
  view.Observe(100, study, {});
  EXPECT_EQ(view.Json()["eta_s"], nullptr);
  EXPECT_THAT(view.PlainLine(), testing::HasSubstr("180 pairs/h  pairs in about 2 min"));
}

v1::WaitingJobs Waits(const char* kind, int jobs, const char* reason, const char* text) {
  v1::WaitingJobs waiting;
  waiting.set_kind(kind);
  waiting.set_jobs(jobs);
  waiting.set_reason(reason);
  waiting.set_text(text);
  return waiting;
}

TEST(ProgressView, JobsThatAreReadyHaveTheirReasonsAlsoWhileOthersRun) {
  v1::StudyStatus study = WithJobs({{"train", "READY", 2}, {"render", "READY", 1}});
  *study.add_waiting() = Waits("train", 2, "trainer", "no connected worker has it");
  *study.add_waiting() = Waits("render", 1, "busy", "all 20 suitable workers are busy");
  ProgressView view;
  view.Observe(0, study, OneTraining());
  EXPECT_THAT(view.PlainLine(),
              testing::EndsWith("; 2 train jobs wait: no connected worker has it; 1 render job "
                                "waits: all 20 suitable workers are busy"));
  const auto json = view.Json();
  ASSERT_EQ(json["waiting"].size(), 2u);
  EXPECT_EQ(json["waiting"][0], (nlohmann::ordered_json{{"kind", "train"},
                                                        {"jobs", 2},
                                                        {"reason", "trainer"},
                                                        {"text", "no connected worker has it"}}));
  std::ostringstream stream;
  Terminal terminal;
  terminal.stream = &stream;
  terminal.size = [] { return TerminalSize{70, 24}; };
  EXPECT_THAT(view.Lines(terminal),
              testing::Contains("  2 train jobs wait: no connected worker has it"));
}

TEST(ProgressView, WorkersThatStartBesideItGetTimeToConnect) {
  v1::StudyStatus study = WithJobs({{"solve", "READY", 1}});
  *study.add_waiting() = Waits("solve", 1, "no_worker", "no worker is connected");
  ProgressView view(10);
  view.Observe(5, study, {});
  EXPECT_THAT(view.Json()["waiting"], testing::IsEmpty());
  view.Observe(15, study, {});
  EXPECT_EQ(view.Json()["waiting"][0]["reason"], "no_worker");
}

}  // namespace
}  // namespace parallax::client
