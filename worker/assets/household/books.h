// Books: one, a stack, a row.
#pragma once

#include "worker/assets/asset_families.h"
#include "worker/assets/parts.h"

namespace parallax {

// One closed book.
struct BookParams {
  float width_m = 0.15f;       // Spine to fore-edge, along x.
  float height_m = 0.22f;      // Head to tail, along y.
  float thickness_m = 0.025f;  // Along z.
  bool hardcover = true;       // Boards that stand over the block, a rounded spine.
  uint64_t seed = 0;
};
// Lies on its back cover, spine at -x.
Asset MakeBook(const BookParams& params);
Asset SampleBook(Rng& rng);
Asset SampleBookStack(Rng& rng);
Asset SampleBookColumn(Rng& rng);

}  // namespace parallax
