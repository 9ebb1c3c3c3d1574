// A simulated user who lets the farm search over settings. What it finds must be what a calm farm
// finds.
#pragma once

#include <string>

#include "coordinator/search/search_keeper.h"
#include "tests/faults/simulate/coordinator.h"
#include "tests/faults/simulate/users/client.h"
#include "tests/faults/simulate/world.h"

namespace parallax::faults {

// Returns a scorer of the studies in `queue`, which must outlive it. Scores follow from settings.
TrialScorer ScorerOf(JobQueue& queue);

class SimSearcher {
 public:
  // `client`, whose network it shares, and the others must outlive the searcher. A calm farm's
  // database comes into `folder`.
  SimSearcher(World& world, SimCoordinator& coordinator, SimClient& client,
              const std::string& folder);

  void Start();
  // Returns whether its search has ended, and is removed again.
  bool is_done() const { return is_done_; }

 private:
  void LookLater();
  void Look();
  void Remove();

  World& world_;
  SimCoordinator& coordinator_;
  SimClient& client_;
  Rng dice_;
  const v1::StudySpec study_;
  const std::string calm_;  // A calm farm finds this.
  bool has_ended_ = false;
  bool is_done_ = false;
};

}  // namespace parallax::faults
