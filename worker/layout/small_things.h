// Places small things on tables and shelves: books in rows, laid tables, bowls and vases. Private
// to worker/layout.
#pragma once

#include <vector>

#include "worker/layout/anneal/annealer.h"
#include "worker/layout/anneal/arrangement.h"

namespace parallax {

// A small thing on the item that bears it, in the room's frame.
struct SmallThing {
  const PooledAsset* asset = nullptr;
  Vec3d position = Vec3d::Zero();
  double yaw_rad = 0;
  int bearer = -1;  // Item of the arrangement.
};

// All small things of a room.
struct SmallFill {
  std::vector<SmallThing> things;
  int wanted = 0;  // How many things the table asks for.
};

// Fills the supports of an arrangement with small things, in at most `steps` steps; each step
// places one row of the table on one bearer.
// Errors: those of the catalogue.
absl::StatusOr<SmallFill> FillSupports(const Arrangement& arrangement,
                                       const std::vector<SmallRow>& rows,
                                       const v1::AssetConfig& assets, const ModelRack& rack,
                                       int steps, SceneSeed seed);

}  // namespace parallax
