#include "worker/assets/nature/bedded_rock.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "common/base/mix_bits.h"
#include "worker/assets/kernel/detail_scope.h"
#include "worker/assets/parts.h"

namespace parallax {
namespace {

using namespace kernel;  // NOLINT: the modelling vocabulary of this folder.

// How far parts of the rock stand out, in radii of the formation.
constexpr float kSeamRelief = -0.2f;    // A soft seam lies this deep.
constexpr float kFallenRelief = -0.3f;  // The hole of a fallen block is at most this deep.
constexpr float kGroove = 0.06f;        // A gap between blocks is this deep.

// Returns the k-th of a block's numbers in [0, 1).
float UnitOf(uint64_t block, uint64_t k) {
  return static_cast<float>(MixBits(block + k) >> 40) * 0x1p-24f;
}

// A block of a bed: the Voronoi cell of one of the jittered points.
struct Block {
  uint64_t id = 0;
  float distance = std::numeric_limits<float>::max();  // To its point, in cells.
};

// Returns the two nearest blocks of the bed with this seed; `at` in cells.   Source: Worley,
// SIGGRAPH 1996.
std::pair<Block, Block> NearestBlocks(uint64_t seed, const Vec2f& at) {
  Block first, second;
  const int column = static_cast<int>(std::floor(at.x())),
            row = static_cast<int>(std::floor(at.y()));
  for (int y = row - 1; y <= row + 1; ++y) {
    for (int x = column - 1; x <= column + 1; ++x) {
      const uint64_t id =
          MixBits(MixBits(seed + static_cast<uint64_t>(x)) + static_cast<uint64_t>(y));
      const Vec2f point(static_cast<float>(x) + 0.1f + 0.8f * UnitOf(id, 0),
                        static_cast<float>(y) + 0.1f + 0.8f * UnitOf(id, 1));
      const Block block{id, (point - at).norm()};
      if (block.distance < first.distance) {
        second = first;
        first = block;
      } else if (block.distance < second.distance) {
        second = block;
      }
    }
  }
  return {first, second};
}

float ReliefOf(const Block& block) {
  const float fallen = UnitOf(block.id, 2) < 0.2f ? kFallenRelief * UnitOf(block.id, 3) : 0;
  return 0.16f * (UnitOf(block.id, 4) - 0.5f) + fallen;
}

// Returns the mean of both sides' relief at their border, and `own` from the distance `width` on.
float Blend(float own, float other, float distance, float width) {
  return Lerp(0.5f * (own + other), own, Smooth01(distance / width));
}

float Groove(float distance, float width) { return -kGroove * (1 - Smooth01(distance / width)); }

}  // namespace

BeddedRock::BeddedRock(const BeddedRockSpec& spec, Rng& rng)
    : spec_(spec), noise_(rng), dip_{Draw(rng, -0.06, 0.06), Draw(rng, -0.06, 0.06)} {
  AddBeds(rng);
}

void BeddedRock::AddBeds(Rng& rng) {
  float floor = -4 * spec_.bed_m;
  while (floor < 1.4f * spec_.height_m + 4 * spec_.bed_m) {
    const bool seam = !beds_.empty() && beds_.back().hard > -1 && rng.Bernoulli(0.27);
    beds_.push_back({floor, seam ? -1.0f : Draw(rng, -0.4, 1), rng.Seed()});
    floor += spec_.bed_m * (seam ? Draw(rng, 0.2, 0.4) : std::exp(Draw(rng, -0.7, 0.8)));
  }
}

float BeddedRock::BlockRelief(const Bed& bed, const Vec3f& p) const {
  if (bed.hard <= -1) return kSeamRelief;
  const float block_m = 0.8f * spec_.thick_m;
  const auto [own, other] = NearestBlocks(bed.seed, p.head<2>() / block_m);
  const float border_m = 0.5f * block_m * (other.distance - own.distance);
  return 0.07f * bed.hard + Blend(ReliefOf(own), ReliefOf(other), border_m, spec_.ledge_m) +
         Groove(border_m, spec_.ledge_m);
}

float BeddedRock::Relief(const Vec3f& p) const {
  const float z = p.z() + dip_.dot(p.head<2>());
  const auto above = std::upper_bound(beds_.begin() + 1, beds_.end() - 1, z,
                                      [](float at, const Bed& bed) { return at < bed.floor_m; });
  const auto bed = above - 1;
  const float up_m = std::max(0.0f, above->floor_m - z), down_m = std::max(0.0f, z - bed->floor_m);
  const bool to_upper = up_m < down_m || bed == beds_.begin();
  const float border_m = std::min(up_m, down_m);
  const Bed& neighbour = to_upper ? *above : *(bed - 1);
  const float own = BlockRelief(*bed, p);
  // A thin bed reaches its own relief in its middle.
  const float width_m = std::min(spec_.ledge_m, 0.5f * (above->floor_m - bed->floor_m));
  if (border_m > width_m) return own;
  return Blend(own, BlockRelief(neighbour, p), border_m, width_m) + Groove(border_m, width_m);
}

Vec3f BeddedRock::Worn(const Vec3f& p, const Vec3f& out) const {
  const float r = spec_.thick_m;
  const float shape = 0.16f * noise_.Fractal(0.5f * p / r, 2);
  const float rough = 0.035f * noise_.Fractal(2.5f * p / r + Vec3f::Constant(7.3f), 4);
  // Blocks fall sideways; faces that look up or down stay.
  const Vec3f sideways(out.x(), out.y(), 0);
  return p + r * ((shape + Relief(p)) * sideways + rough * out);
}

}  // namespace parallax
