// Fixture of tests of SearchKeeper: a farm whose workers are functions.
#pragma once

#include <cmath>
#include <functional>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "coordinator/search/search_keeper.h"
#include "tests/coordinator/queue/keeper_fixture.h"
#include "tests/coordinator/queue/train_fixture.h"
#include "tests/coordinator/search/search_study.h"

namespace parallax {

// Objectives of a farm where 30 floating objects are the best, and more is known on later rungs.
class SearchKeeperTest : public KeeperTest<SearchKeeper, v1::SearchStatus> {
 protected:
  SearchKeeperTest() : KeeperTest("recipe") {}
  std::unique_ptr<SearchKeeper> MakeKeeper() override {
    return std::make_unique<SearchKeeper>(
        *queue_, clock_, [this](const ScoreQuery& query) { return ScoresOf(query); }, samplers_);
  }
  // Nothing is left of the keeper.
  void ForgetAll() { keeper_ = MakeKeeper(); }

  absl::StatusOr<std::vector<TrialScore>> ScoresOf(const ScoreQuery& query) {
    if (!store_is_there_) return Unavailable("the store is gone");
    if (while_scoring_) while_scoring_();
    ASSIGN_OR_RETURN(const v1::StudyStatus study, queue_->GetStudy(StudyId{query.study}));
    queries_.push_back(query);
    std::vector<TrialScore> scores;
    for (const v1::VariantSpec& variant : study.spec().variants()) {
      if (gave_up_.count(variant.name()) + query.without.count(variant.name()) > 0) continue;
      const double count = variant.config().floating().count().constant();
      const auto points = query.points.find(variant.name());
      TrialScore& score = scores.emplace_back();
      score.variant = variant.name();
      score.objective.set_value(20 + std::abs(count - 30) / 10 +
                                (points == query.points.end() ? 0 : points->second));
      score.difference.set_value(score.objective.value() - scores[0].objective.value());
      score.verdict = score.difference.value() < -0.5  ? "better"
                      : score.difference.value() > 0.5 ? "worse"
                                                       : "not significant";
    }
    return scores;
  }

  v1::SearchRecord Record() {
    const auto records = queue_->ListSearches();
    EXPECT_TRUE(records.ok() && records->size() == 1);
    return records.ok() && !records->empty() ? records->front() : v1::SearchRecord();
  }
  void TickSearches() {
    const absl::Status status = keeper_->Tick();
    EXPECT_TRUE(status.ok()) << status;
  }

  // Answers a lease; each pair took 36 core-seconds, a layout 5, and a scene 7.
  void Finish(const v1::Lease& lease) {
    if (lease.kind() == "train" && broken_.count(TrainJobOf(lease).name()) > 0) {
      Fail(Failure(lease, "w", "out of paper", /*retryable=*/false));
      return;
    }
    v1::CompleteRequest answer = AnyAnswer(lease, "w");
    if (lease.kind() == "solve" && gave_up_.count(lease.variant()) > 0) {
      answer = RejectAnswer(lease, "w", false);
    }
    if (lease.kind() == "solve") {
      EditSolve(answer, [](v1::SolveResult& result) {
        if (result.has_layout()) result.set_layout_s(5);
        result.set_dress_s(7);
      });
    }
    if (lease.kind() == "render") {
      EditRender(answer, [](v1::RenderResult& result) {
        for (v1::FrameResult& frame : *result.mutable_frames()) {
          (*frame.mutable_stage_s())["cpu"] = 36;
        }
      });
    }
    EXPECT_EQ(Complete(answer), v1::REPORT_OUTCOME_OK);
  }
  // Does at most so many jobs; returns how many it did.
  int Work(int most = 1'000'000) {
    int jobs = 0;
    while (jobs < most) {
      const auto leases = Lease(Everyman("w"), std::min(8, most - jobs));
      if (leases.empty()) break;
      for (const v1::Lease& lease : leases) Finish(lease);
      jobs += static_cast<int>(leases.size());
    }
    return jobs;
  }
  // Works until the search is over.
  void RunToItsEnd() {
    for (int i = 0; i < 50; ++i) {
      Work();
      TickSearches();
      const std::string state = Status().state();
      if (state == "ended" || state == "stopped") return;
    }
    FAIL() << Status().DebugString();
  }
  int StudiesOfQueue() {
    const auto studies = queue_->ListStudies(1000);
    EXPECT_TRUE(studies.ok());
    return studies.ok() ? static_cast<int>(studies->size()) : -1;
  }

  std::vector<ScoreQuery> queries_;
  bool store_is_there_ = true;
  std::function<void()> while_scoring_;
  std::set<std::string> broken_;   // Variants whose trainings fail.
  std::set<std::string> gave_up_;  // Variants without any valid scene.
  std::map<std::string, Sampler> samplers_;
};

}  // namespace parallax
