// Simulated annealing of a room's furniture. The state keeps the hard constraints at every step, so
// the loss is soft.
//
// Full: all moves under Metropolis, temperature falling geometrically from 3 to 0.001, the last 15
// % greedy. Reduced: additions only, kept when they lower the loss. Private to worker/layout.
#pragma once

#include "common/base/cancel.h"
#include "parallax/v1/config.pb.h"
#include "worker/layout/arrangement.h"
#include "worker/layout/loss.h"

namespace parallax {

// The models of each class that this room chooses from.
class ModelRack {
 public:
  ModelRack(SceneSeed seed, AssetPool& pool) : root_(seed, "layout/model"), pool_(&pool) {}
  // One of a few models of the row's classes; rows of one model always give the same.
  // nullptr when no model is low enough for the row.
  absl::StatusOr<const PooledAsset*> Draw(const WantedRow& row, Rng& rng) const;
  absl::StatusOr<const PooledAsset*> Get(const std::string& class_name, uint64_t model) const;

 private:
  Rng root_;
  AssetPool* pool_;
};

struct AnnealResult {
  Arrangement arrangement;
  Loss loss;
  int accepted = 0;
  double initial_loss = 0;
  std::vector<double> curve;  // After each step.
};

// Errors: kCancelled, those of the catalogue.
absl::StatusOr<AnnealResult> Anneal(const RoomProblem& problem,
                                    const std::vector<Fixture>& fixtures, const ModelRack& rack,
                                    v1::SolverConfig::Mode mode, int steps, SceneSeed seed,
                                    const CancelToken& cancel);

}  // namespace parallax
