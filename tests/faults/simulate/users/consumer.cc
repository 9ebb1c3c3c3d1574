#include "tests/faults/simulate/users/consumer.h"

#include <fmt/core.h>

#include <algorithm>
#include <set>

#include "tests/coordinator/queue/queue_fixture.h"

namespace parallax::faults {
namespace {

constexpr char kStream[] = "stream";
constexpr int kMostStudies = 10'000;
constexpr double kNeverSilent_s = 3e7;

v1::StudySpec Endless(Rng dice) {
  const int pairs = dice.UniformInt(2, 6);  // Each of two ranks has some in each round.
  v1::StudySpec study = MakeStudy({.name = kStream,
                                   .seed = dice.Bits32(),
                                   .pairs = pairs,
                                   .rigs_per_scene = dice.UniformInt(1, 3),
                                   .variants = {"a", "b"}})
                            .study();
  study.mutable_stream()->set_chunk_pairs(pairs);
  study.mutable_stream()->set_chunks_ahead(dice.UniformInt(1, 3));
  study.mutable_stream()->set_uses(dice.UniformInt(1, 3));
  study.mutable_stream()->set_silent_s(kNeverSilent_s);
  return study;
}

std::string Shown(uint64_t position) {
  const StreamPosition at = StreamPosition::Of(position);
  return fmt::format("{}.{}", at.round, at.place);
}

}  // namespace

SimConsumer::SimConsumer(World& world, SimCoordinator& coordinator, SimClient& client)
    : world_(world),
      coordinator_(coordinator),
      client_(client),
      dice_(world.rng.Child("consumer")),
      study_(Endless(dice_.Child("study"))),
      rounds_(dice_.UniformInt(2, 5)),
      ranks_(static_cast<size_t>(dice_.UniformInt(1, 2))) {
  for (size_t i = 0; i < ranks_.size(); ++i) ranks_[i].number = static_cast<uint32_t>(i);
}

void SimConsumer::Start() {
  client_.CallUntilDone([this] {
    const auto status = coordinator_.streams().Open(study_, "client");
    if (!status.ok()) coordinator_.model().Expect(status.status(), "open a stream");
    return status.ok();
  });
  for (Rank& rank : ranks_) AskLater(rank);
}

uint32_t SimConsumer::PairsOfRound(int64_t round) const {
  const auto [first, last] = ChunksOfRound(study_, round);
  return static_cast<uint32_t>((last - first + 1) * ChunkPairsOf(study_));
}

uint64_t SimConsumer::FirstFrom(const Rank& rank, uint64_t position) const {
  StreamPosition at = StreamPosition::Of(position);
  while (true) {
    while (at.place % ranks_.size() != rank.number) ++at.place;
    if (at.place < PairsOfRound(at.round)) return at.Packed();
    at = {at.round + 1, 0};
  }
}

void SimConsumer::AskLater(Rank& rank) {
  world_.schedule.After(world_.Next(world_.knobs.queue.lease_s / 5), [this, &rank] { Ask(rank); });
}

// One call. Its request or its reply may be lost; it then asks again.
void SimConsumer::Ask(Rank& rank) {
  if (closes_) return;
  v1::NextPairsRequest request;
  request.set_stream(kStream);
  request.set_consumer("training");
  request.set_rank(static_cast<int>(rank.number));
  request.set_ranks(static_cast<int>(ranks_.size()));
  request.set_acknowledged(rank.used);
  request.set_position(rank.position);
  request.set_resume(rank.resumes);
  request.set_limit(dice_.UniformInt(1, 4));
  rank.told = std::max(rank.told, rank.used);
  const int64_t call = ++rank.call;
  client_.Call([this, &rank, request, call] {
    v1::NextPairsRequest heard = request;
    if (world_.mutation.no_acknowledging) heard.clear_acknowledged();
    const auto reply = coordinator_.streams().Next(heard);
    if (VfsHasEnded()) return;
    // It may ask before the stream is opened, and after another rank has closed it.
    if (absl::IsNotFound(reply.status()) && (rank.told == 0 || closes_)) return;
    if (!reply.ok()) return coordinator_.model().Expect(reply.status(), "pairs of a stream");
    if (!world_.has_faults && reply->pairs().empty()) RetryChunks();
    if (world_.has_faults && dice_.Bernoulli(world_.knobs.loss_p)) return;
    world_.schedule.After(world_.Delay(), [this, &rank, request, call, reply = *reply] {
      if (rank.call == call) Take(rank, request, reply);
    });
  });
  world_.schedule.After(world_.knobs.queue.lease_s / 2, [this, &rank, call] {
    if (rank.call == call) Ask(rank);
  });
}

void SimConsumer::Take(Rank& rank, const v1::NextPairsRequest& request,
                       const v1::NextPairsReply& reply) {
  ++rank.call;
  CheckReply(rank, request, reply);
  rank.acknowledged = std::max(rank.acknowledged, request.acknowledged());
  rank.position = reply.position();
  rank.resumes = false;
  world_.story.Tell("consumer: rank {} gets {} pairs, goes on at {}{}{}", rank.number,
                    reply.pairs_size(), Shown(reply.position()),
                    reply.waits_for().empty() ? "" : ", waits: ", reply.waits_for());
  if (world_.has_faults && dice_.Bernoulli(0.15)) {
    world_.story.Tell("consumer: rank {} dies", rank.number);
    rank.resumes = true;
    rank.position = rank.used = 0;
  } else if (dice_.Bernoulli(0.7) || StreamPosition::Of(rank.position).round >= rounds_) {
    rank.used = rank.position;
  } else if (!reply.pairs().empty()) {
    rank.used = std::max(rank.used, dice_.Pick(reply.pairs()).position());
  }
  if (!HasAll()) return AskLater(rank);
  if (!std::exchange(closes_, true)) Close();
}

// The pairs begin where the rank wants them, and none is left out.
void SimConsumer::CheckReply(const Rank& rank, const v1::NextPairsRequest& request,
                             const v1::NextPairsReply& reply) {
  const auto complain = [&](uint64_t position, const std::string& what) {
    coordinator_.model().Complain(
        fmt::format("stream: rank {}: pair {} {}", rank.number, Shown(position), what));
  };
  uint64_t least = FirstFrom(rank, request.resume() ? rank.acknowledged : request.position());
  // An acknowledgement without an answer may count.
  uint64_t most = FirstFrom(rank, request.resume() ? rank.told : request.position());
  for (const v1::StreamedPair& pair : reply.pairs()) {
    if (pair.position() < least) complain(pair.position(), "comes again, at " + Shown(least));
    if (pair.position() > most) complain(pair.position(), "comes instead of " + Shown(most));
    const auto [known, is_new] = pairs_.try_emplace(
        pair.position(), Pair{pair.chunk(), pair.variant(), pair.scene(), pair.frame().rig()});
    if (!is_new &&
        known->second != Pair{pair.chunk(), pair.variant(), pair.scene(), pair.frame().rig()}) {
      complain(pair.position(), "is another one than before");
    }
    least = most = FirstFrom(rank, pair.position() + 1);
  }
}

bool SimConsumer::HasAll() const {
  return std::all_of(ranks_.begin(), ranks_.end(), [&](const Rank& rank) {
    return StreamPosition::Of(rank.acknowledged).round >= rounds_;
  });
}

// The pairs of each round came in the order that a farm without faults gives them.
void SimConsumer::CheckOrder() {
  std::map<int64_t, std::set<Pair>> chunks;
  for (const auto& [position, pair] : pairs_) chunks[std::get<0>(pair)].insert(pair);
  for (int64_t round = 0; round < rounds_; ++round) {
    std::vector<Pair> calm;
    const auto [first, last] = ChunksOfRound(study_, round);
    for (int64_t i = first; i <= last; ++i) {
      calm.insert(calm.end(), chunks[i].begin(), chunks[i].end());
    }
    const std::vector<uint32_t> order = OrderOfRound(study_, round, calm.size());
    if (order.size() != PairsOfRound(round)) {
      coordinator_.model().Complain(fmt::format("stream: round {} has {} pairs, not {}", round,
                                                order.size(), PairsOfRound(round)));
      return;
    }
    for (uint32_t place = 0; place < order.size(); ++place) {
      const auto came = pairs_.find(StreamPosition{round, place}.Packed());
      if (came == pairs_.end() || came->second != calm[order[place]]) {
        coordinator_.model().Complain(
            fmt::format("stream: pair {}.{} is not that of a calm farm", round, place));
      }
    }
  }
}

void SimConsumer::Close() {
  CheckOrder();
  client_.CallUntilDone([this] {
    const auto closed = coordinator_.streams().Close(kStream);
    if (!closed.ok() && !absl::IsNotFound(closed.status())) {
      coordinator_.model().Expect(closed.status(), "close a stream");
      return false;
    }
    const auto left = coordinator_.queue().ListStreams();
    const auto studies = coordinator_.queue().ListStudies(kMostStudies);
    if (!left.ok() || !left->empty() || !studies.ok()) return false;
    for (const v1::StudyStatus& study : *studies) {
      if (study.name().starts_with(std::string(kStream) + "-")) {
        coordinator_.model().Complain("stream: " + study.name() + " is left");
      }
    }
    world_.story.Tell("consumer: its stream is gone");
    return is_done_ = true;
  });
}

// Chunks that failed wait for a person.
void SimConsumer::RetryChunks() {
  const auto streams = coordinator_.queue().ListStreams();
  if (!streams.ok()) return;
  for (const v1::StreamRecord& stream : *streams) {
    for (const int64_t study : stream.chunk_studies()) {
      (void)coordinator_.queue().Retry(StudyId{study}, "client");
    }
  }
}

}  // namespace parallax::faults
