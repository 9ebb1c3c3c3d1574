// Simulated annealing of a room's furniture. The state keeps the hard constraints at every step, so
// the loss has only soft ones.
//
// There are two stages: first objects on the floor and those that stand by them, then also hanging
// objects and objects on top of others. Full: all moves under Metropolis, temperature falling
// geometrically from 3 to 0.001 over both stages, the last 15 % greedy. Reduced: additions only,
// kept when they lower the loss. Best: several full runs, of which the least loss wins. Private to
// worker/layout.
#pragma once

#include "common/base/cancel.h"
#include "parallax/v1/config.pb.h"
#include "worker/layout/anneal/arrangement.h"
#include "worker/layout/anneal/score.h"

namespace parallax {

// The models from which this room chooses, for each class.
class ModelRack {
 public:
  ModelRack(SceneSeed seed, AssetPool& pool) : root_(seed, "layout/model"), pool_(&pool) {}
  // Draws one of a few models of the row's classes; rows of one model always get the same. Null
  // when no model is low enough for the row. Errors: those of AssetPool::Get.
  absl::StatusOr<const PooledAsset*> Draw(const WantedRow& row, Rng& rng) const;
  // Errors: those of AssetPool::Get.
  absl::StatusOr<const PooledAsset*> Get(const std::string& class_name, uint64_t model) const;

 private:
  Rng root_;
  AssetPool* pool_;
};

// How much annealing is done.
struct AnnealPlan {
  bool reduced = false;
  int large_steps = 300, medium_steps = 200;  // Steps of the two stages.
  int runs = 1;                               // Independent runs; the best is kept.
};

// The best arrangement found.
struct AnnealResult {
  Arrangement arrangement;
  Score score;
  int accepted = 0;
  double initial_loss = 0;
  std::vector<double> curve;  // Loss after each step.
};

// Arranges the room. Errors: kCancelled, those of the catalogue.
absl::StatusOr<AnnealResult> Anneal(const RoomProblem& problem, const std::vector<Wish>& wishes,
                                    const std::vector<Fixture>& fixtures, const ModelRack& rack,
                                    const AnnealPlan& plan, SceneSeed seed,
                                    const CancelToken& cancel);

}  // namespace parallax
