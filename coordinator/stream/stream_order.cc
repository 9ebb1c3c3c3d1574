#include "coordinator/stream/stream_order.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "common/base/rng.h"

namespace parallax {
namespace {

// The golden ratio's fraction: its multiples, modulo 1, spread as evenly as any sequence can.
constexpr double kGolden = 0.6180339887498949;

// The end of a chunk is no news: one follows the other.
void AddNotify(const v1::NotifySpec& stream, v1::StudySpec& chunk) {
  chunk.mutable_notify()->set_url(stream.url());
  for (const char* event : {"failed", "stalled", "waits"}) {
    const bool wanted = stream.on().empty() || std::find(stream.on().begin(), stream.on().end(),
                                                         event) != stream.on().end();
    if (wanted) chunk.mutable_notify()->add_on(event);
  }
}

// Returns the shares of the variants at a pair of the stream; they sum up to 1.
std::vector<double> SharesAt(const v1::StudySpec& stream, int64_t pair) {
  std::vector<double> shares(static_cast<size_t>(stream.variants_size()), 0);
  for (const v1::StreamShare& share : stream.stream().mix()) {
    if (pair < share.from_pair()) continue;
    if (share.has_until_pair() && pair >= share.until_pair()) continue;
    for (int i = 0; i < stream.variants_size(); ++i) {
      if (stream.variants(i).name() != share.variant()) continue;
      shares[static_cast<size_t>(i)] += share.has_weight() ? share.weight() : 1;
    }
  }
  double sum = std::accumulate(shares.begin(), shares.end(), 0.0);
  if (sum <= 0) {
    std::fill(shares.begin(), shares.end(), 1);
    sum = static_cast<double>(shares.size());
  }
  for (double& share : shares) share /= sum;
  return shares;
}

// Returns the shares of a chunk's pairs, which may change within it.
std::vector<double> SharesOfChunk(const v1::StudySpec& stream, int64_t chunk) {
  const int64_t begin = chunk * ChunkPairsOf(stream), end = begin + ChunkPairsOf(stream);
  std::vector<int64_t> changes = {begin, end};
  for (const v1::StreamShare& share : stream.stream().mix()) {
    for (const int64_t pair : {share.from_pair(), share.until_pair()}) {
      if (pair > begin && pair < end) changes.push_back(pair);
    }
  }
  std::sort(changes.begin(), changes.end());
  std::vector<double> shares(static_cast<size_t>(stream.variants_size()), 0);
  for (size_t i = 0; i + 1 < changes.size(); ++i) {
    const double part = static_cast<double>(changes[i + 1] - changes[i]) /
                        static_cast<double>(ChunkPairsOf(stream));
    const std::vector<double> at = SharesAt(stream, changes[i]);
    for (size_t v = 0; v < shares.size(); ++v) shares[v] += part * at[v];
  }
  return shares;
}

}  // namespace

int64_t ChunkPairsOf(const v1::StudySpec& stream) {
  return stream.stream().has_chunk_pairs() ? stream.stream().chunk_pairs() : 200;
}
int64_t ChunksAheadOf(const v1::StudySpec& stream) {
  return stream.stream().has_chunks_ahead() ? stream.stream().chunks_ahead() : 3;
}
int64_t UsesOf(const v1::StudySpec& stream) {
  return stream.stream().has_uses() ? stream.stream().uses() : 1;
}
double KeepSecondsOf(const v1::StudySpec& stream) { return stream.stream().keep_s(); }
double SilentSecondsOf(const v1::StudySpec& stream) {
  return stream.stream().has_silent_s() ? stream.stream().silent_s() : 600;
}

std::vector<int64_t> PairsOfChunk(const v1::StudySpec& stream, int64_t chunk) {
  const int64_t pairs = ChunkPairsOf(stream);
  const int64_t scene = std::clamp<int64_t>(stream.rigs_per_scene(), 1, pairs);
  const int64_t scenes = (pairs + scene - 1) / scene;
  const std::vector<double> shares = SharesOfChunk(stream, chunk);
  // Systematic sampling of the chunk's scenes, at offsets that spread over the chunks.
  Rng rng(SceneSeed{stream.seed()}, "stream/mix");
  const double offset = std::fmod(rng.Uniform() + kGolden * static_cast<double>(chunk), 1.0);
  std::vector<int64_t> made(shares.size(), 0);
  double before = offset;
  size_t last = 0;
  for (size_t v = 0; v < shares.size(); ++v) {
    const double after = before + shares[v] * static_cast<double>(scenes);
    const bool is_end = v + 1 == shares.size();
    const int64_t from = std::min(static_cast<int64_t>(before), scenes);
    const int64_t to = is_end ? scenes : std::min(static_cast<int64_t>(after), scenes);
    made[v] = (to - from) * scene;
    if (made[v] > 0) last = v;
    before = after;
  }
  // The sums are exact in whole scenes, and the last of these may be smaller.
  made[last] -= std::accumulate(made.begin(), made.end(), int64_t{0}) - pairs;
  return made;
}

v1::StudySpec ChunkStudy(const v1::StudySpec& stream, int64_t chunk) {
  v1::StudySpec study;
  study.set_name(fmt::format("{}-{}", stream.name(), chunk));
  Rng seeds = Rng(SceneSeed{stream.seed()}, "stream").Child("chunk", static_cast<uint64_t>(chunk));
  study.set_seed(seeds.Seed());
  study.set_pairs(ChunkPairsOf(stream));
  study.set_rigs_per_scene(stream.rigs_per_scene());
  study.set_priority(stream.priority());
  *study.mutable_tags() = stream.tags();
  study.set_memory_mb(stream.memory_mb());
  if (stream.has_notify()) AddNotify(stream.notify(), study);
  const std::vector<int64_t> pairs = PairsOfChunk(stream, chunk);
  for (int i = 0; i < stream.variants_size(); ++i) {
    if (pairs[static_cast<size_t>(i)] == 0) continue;
    v1::VariantSpec& variant = *study.add_variants();
    variant = stream.variants(i);
    variant.set_pairs(pairs[static_cast<size_t>(i)]);
    variant.set_seed(seeds.Child(variant.name(), variant.seed()).Seed());
  }
  return study;
}

std::pair<int64_t, int64_t> ChunksOfRound(const v1::StudySpec& stream, int64_t round) {
  return {std::max<int64_t>(0, round - UsesOf(stream) + 1), round};
}

std::vector<uint32_t> OrderOfRound(const v1::StudySpec& stream, int64_t round, size_t pairs) {
  std::vector<uint32_t> order(pairs);
  std::iota(order.begin(), order.end(), 0u);
  Rng(SceneSeed{stream.seed()}, "stream")
      .Child("round", static_cast<uint64_t>(round))
      .Shuffle(order);
  return order;
}

}  // namespace parallax
