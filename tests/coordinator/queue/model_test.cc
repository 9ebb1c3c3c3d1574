// Random studies, workers, failures, losses, late reports, pauses, cancels, retries and restarts
// against a model of what was promised: what was acknowledged stays, each pair is published once,
// every study comes to its end.
#include <map>
#include <set>

#include "common/base/rng.h"
#include "coordinator/study/expansion.h"
#include "train_fixture.h"

namespace parallax {
namespace {

struct Held {
  v1::Lease lease;
  std::string worker;
};

class ModelTest : public TrainQueueTest, public testing::WithParamInterface<int> {
 protected:
  // A seed's validity depends on the seed alone, as with the real solver.
  static bool Valid(uint64_t scene_seed) { return scene_seed % 5 != 0; }
  static v1::CompleteRequest Result(const Held& held) {
    if (held.lease.kind() == "solve" && !Valid(SolveOf(held.lease).scene_seed())) {
      return RejectAnswer(held.lease, held.worker, !SolveOf(held.lease).has_layout());
    }
    return AnyAnswer(held.lease, held.worker);
  }

  void Step(Rng& rng);
  void Report(Rng& rng);
  void Remember();

  std::vector<StudyId> studies_;
  std::set<int64_t> cancelled_;
  std::vector<Held> held_;
  std::vector<Held> past_;                    // Reported or given up: late from now on.
  std::map<int64_t, uint64_t> newest_fence_;  // By job.
  std::map<int64_t, std::string> published_;  // Cursor -> frame, as once listed.
};

void ModelTest::Report(Rng& rng) {
  if (held_.empty()) return;
  const size_t at = static_cast<size_t>(rng.UniformInt(0, static_cast<int>(held_.size()) - 1));
  const Held held = held_[at];
  held_.erase(held_.begin() + static_cast<std::ptrdiff_t>(at));
  past_.push_back(held);
  const int what = rng.UniformInt(0, 9);
  if (what < 7) {
    const v1::ReportOutcome outcome = Complete(Result(held));
    // A repeat of an accepted report is accepted again.
    if (outcome == v1::REPORT_OUTCOME_OK) {
      EXPECT_EQ(Complete(Result(held)), v1::REPORT_OUTCOME_ALREADY_DONE);
    }
  } else if (what == 7) {
    Fail(Failure(held.lease, held.worker, rng.Bernoulli(0.5) ? "boom" : "bang"));
  } else if (what == 8) {
    (void)*queue_->HandBack(held.worker, held.lease.attempt(), "drain");
  }  // Else the worker forgets it.
}

void ModelTest::Step(Rng& rng) {
  const std::string worker = "w" + std::to_string(rng.UniformInt(0, 5));
  const int what = rng.UniformInt(0, 99);
  if (what < 35) {
    for (const v1::Lease& lease : Lease(Everyman(worker), rng.UniformInt(1, 4))) {
      held_.push_back({lease, worker});
      newest_fence_[lease.attempt().job_id()] = lease.attempt().fence();
    }
  } else if (what < 75) {
    Report(rng);
  } else if (what < 80 && !past_.empty()) {
    const Held& zombie =
        past_[static_cast<size_t>(rng.UniformInt(0, static_cast<int>(past_.size()) - 1))];
    const v1::AttemptId& attempt = zombie.lease.attempt();
    const v1::ReportOutcome outcome = Complete(Result(zombie));
    if (newest_fence_.at(attempt.job_id()) != attempt.fence()) {
      EXPECT_EQ(outcome, v1::REPORT_OUTCOME_STALE_FENCE);
    }
  } else if (what < 84) {
    clock_.Advance(rng.Uniform(0, 20));
    Tick();
  } else if (what < 87) {
    (void)*queue_->WorkerLost(worker);
  } else if (what < 90 && studies_.size() < 8) {
    const v1::SubmitRequest request =
        MakeStudy({.seed = static_cast<uint64_t>(rng.UniformInt(1, 2)),
                   .pairs = rng.UniformInt(1, 14),
                   .rigs_per_scene = rng.UniformInt(1, 3),
                   .variants = rng.Bernoulli(0.5) ? std::vector<std::string>{"a", "b"}
                                                  : std::vector<std::string>{"a"},
                   .priority = rng.UniformInt(0, 1)});
    studies_.push_back(
        SubmitRequest(rng.Bernoulli(0.5) ? WithTrainings(request, rng.UniformInt(0, 3)) : request));
  } else if (!studies_.empty()) {
    const StudyId study = rng.Pick(studies_);
    if (what < 92) {
      EXPECT_TRUE(queue_->Pause(study, "", "m").ok());
    } else if (what < 96) {
      EXPECT_TRUE(queue_->Resume(study, "", "m").ok());
    } else if (what < 97) {
      (void)queue_->Retry(study, "m");
    } else if (what < 98 && rng.Bernoulli(0.3)) {
      if (queue_->Cancel(study, "", "m").ok()) cancelled_.insert(study.value);
    } else if (what == 99) {
      Reopen();
      std::vector<v1::AttemptId> holding;
      for (const Held& held : held_) {
        if (held.worker == worker) holding.push_back(held.lease.attempt());
      }
      EXPECT_TRUE(queue_->Adopt(worker, holding).ok());
    }
  }
}

// A frame that was listed once never changes.
void ModelTest::Remember() {
  for (const StudyId study : studies_) {
    for (const v1::PublishedFrame& frame : Frames(study)) {
      const auto known = published_.emplace(frame.cursor(), frame.SerializeAsString()).first;
      EXPECT_EQ(known->second, frame.SerializeAsString());
    }
  }
}

TEST_P(ModelTest, WhateverHappensPromisesAreKept) {
  Rng rng(SceneSeed{static_cast<uint64_t>(GetParam())}, "model");
  options_.scenes_ahead = rng.UniformInt(1, 6);
  Reopen();
  studies_.push_back(
      SubmitRequest(WithTrainings(MakeStudy({.pairs = 10, .variants = {"a", "b"}}))));
  for (int step = 0; step < 600; ++step) {
    Step(rng);
    if (step % 100 == 99) {
      Remember();
      ExpectSound();
    }
  }
  // Calm: everything goes on to its end.
  for (int round = 0; round < 20; ++round) {
    for (const StudyId study : studies_) {
      EXPECT_TRUE(queue_->Resume(study, "", "m").ok());
      if (!cancelled_.contains(study.value)) {
        EXPECT_TRUE(queue_->Retry(study, "m").ok());
      }
    }
    clock_.Advance(1000);
    Tick();
    for (;;) {
      const auto leases = Lease(Everyman("calm"), 8);
      if (leases.empty()) break;
      for (const v1::Lease& lease : leases) {
        EXPECT_EQ(Complete(Result({lease, "calm"})), v1::REPORT_OUTCOME_OK);
      }
    }
  }
  Remember();
  for (const StudyId study : studies_) {
    const v1::StudyStatus status = Status(study);
    std::set<std::string> pairs;
    for (const v1::PublishedFrame& frame : Frames(study)) {
      EXPECT_TRUE(pairs
                      .insert(frame.variant() + "/" + std::to_string(frame.scene()) + "/" +
                              std::to_string(frame.frame().rig()))
                      .second);
    }
    if (cancelled_.contains(study.value)) {
      EXPECT_EQ(status.state(), v1::STUDY_STATE_CANCELLED);
      continue;
    }
    EXPECT_EQ(status.state(), v1::STUDY_STATE_SUCCEEDED) << status.DebugString();
    for (const v1::VariantStatus& variant : status.variants()) {
      EXPECT_EQ(variant.pairs_done(), variant.pairs_wanted());
    }
    EXPECT_EQ(static_cast<int64_t>(pairs.size()), TotalPairsOf(status.spec()));
  }
}

INSTANTIATE_TEST_SUITE_P(Seeds, ModelTest, testing::Range(0, 8));

}  // namespace
}  // namespace parallax
