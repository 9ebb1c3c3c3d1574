// The sequence of a stream's pairs: which variants each chunk has, and the order of each round.
// proto/parallax/v1/stream.proto says what chunks, rounds and positions are. Pure functions of the
// study, so that every consumer, and every coordinator after a restart, finds the same sequence.
#pragma once

#include <cstdint>
#include <vector>

#include "parallax/v1/stream.pb.h"

namespace parallax {

// A place in a stream's sequence.
struct StreamPosition {
  int64_t round = 0;
  uint32_t place = 0;

  static StreamPosition Of(uint64_t packed) {
    return {static_cast<int64_t>(packed >> 32), static_cast<uint32_t>(packed)};
  }
  uint64_t Packed() const { return (static_cast<uint64_t>(round) << 32) | place; }
};

// Return a stream's settings, those that its study does not give at their defaults.
int64_t ChunkPairsOf(const v1::StudySpec& stream);
int64_t ChunksAheadOf(const v1::StudySpec& stream);
int64_t UsesOf(const v1::StudySpec& stream);
double KeepSecondsOf(const v1::StudySpec& stream);
double SilentSecondsOf(const v1::StudySpec& stream);

// Returns the number of pairs of each variant in a chunk; they sum up to ChunkPairsOf. Variants get
// whole scenes, except one. Over many chunks each variant's part is its share.
std::vector<int64_t> PairsOfChunk(const v1::StudySpec& stream, int64_t chunk);
// Returns the study that makes a chunk's pairs: "<stream>-<chunk>", without variants that have none
// of them. Each of its variants has a seed of its own.
v1::StudySpec ChunkStudy(const v1::StudySpec& stream, int64_t chunk);

// Returns the first and the last chunk whose pairs a round has.
std::pair<int64_t, int64_t> ChunksOfRound(const v1::StudySpec& stream, int64_t round);
// Returns the order of a round of `pairs` pairs: indices into the pairs of its chunks, the oldest
// chunk first, each chunk's by variant, scene and rig.
std::vector<uint32_t> OrderOfRound(const v1::StudySpec& stream, int64_t round, size_t pairs);

}  // namespace parallax
