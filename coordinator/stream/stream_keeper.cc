#include "coordinator/stream/stream_keeper.h"

#include <fmt/core.h>

#include <algorithm>
#include <limits>
#include <tuple>

#include "common/base/names.h"
#include "common/base/seconds.h"
#include "common/base/system/log.h"
#include "common/config/check/limit_rules.h"
#include "common/config/check/notify_check.h"
#include "common/config/verdicts.h"
#include "coordinator/queue/job_queue.h"
#include "coordinator/study/expansion.h"
#include "coordinator/study/keys.h"
#include "coordinator/study/study_needs.h"

namespace parallax {
namespace {

constexpr double kLookEvery_s = 0.2;
constexpr int kFramesAtOnce = 10'000;
constexpr int kMostPairs = 1024;  // In a reply.
constexpr int kUsualPairs = 64;
constexpr int kMostConsumers = 4096;  // The most ranks of all consumers of a stream.

// Returns what the keys of all studies of a stream begin with. The time tells them from those of an
// earlier stream of the name.
std::string KeysOf(const v1::StreamRecord& record) {
  return fmt::format("stream/{}/{:.6f}/", record.study().name(), record.opened_unix_s());
}
// Returns the key under which a chunk is submitted.
std::string KeyOf(const v1::StreamRecord& record, int64_t chunk) {
  return fmt::format("{}{}", KeysOf(record), chunk);
}

// Returns the position that a rank has used up everything before, at the begin of a round.
uint64_t BeginOf(int64_t round) { return StreamPosition{round, 0}.Packed(); }

std::string Named(const v1::StreamConsumer& consumer) {
  return fmt::format("'{}', rank {} of {}", consumer.name(), consumer.rank(), consumer.ranks());
}

// Returns the study without what may change while its stream goes on.
std::string LastingPart(v1::StudySpec study) {
  study.clear_source_yaml();
  study.clear_notify();
  return DeterministicBytes(study);
}

// Returns whether a pair passes the filters of its variant.
absl::StatusOr<bool> Passes(const v1::StudySpec& stream, const v1::PublishedFrame& frame) {
  for (const v1::VariantSpec& variant : stream.variants()) {
    if (variant.name() != frame.variant()) continue;
    FrameFacts facts;
    facts.statistics.insert(frame.frame().statistics().begin(), frame.frame().statistics().end());
    ASSIGN_OR_RETURN(const std::vector<Verdict> verdicts, Judge(facts, variant.config().filters()));
    return std::all_of(verdicts.begin(), verdicts.end(),
                       [](const Verdict& verdict) { return verdict.passed; });
  }
  return true;
}

}  // namespace

void StreamKeeper::Fill(Stream& stream) const {
  const v1::StreamRecord& record = stream.record;
  for (int i = 0; i < record.chunk_studies_size(); ++i) {
    stream.chunks[record.chunks_forgotten() + i].study = record.chunk_studies(i);
  }
  for (const v1::StreamConsumer& consumer : record.consumers()) {
    stream.heard[{consumer.name(), consumer.rank()}] = clock_.Steady();
  }
}

absl::StatusOr<v1::StreamStatus> StreamKeeper::Open(const v1::StudySpec& given,
                                                    std::string_view actor) {
  v1::StudySpec study = given;
  const v1::NotifySpec notify = TakeNotify(&study);
  if (!study.has_stream()) {
    return InvalidArgument(
        "study '{}' has {} pairs; a stream is of an endless study, whose file says `pairs: "
        "endless`",
        study.name(), study.pairs());
  }
  RETURN_IF_ERROR(CheckStudySpec(ChunkStudy(study, 0)));
  if (notify.has_url()) *study.mutable_notify() = notify;
  std::lock_guard lock(mu_);
  RETURN_IF_ERROR(Load());
  const auto found = entries_.find(study.name());
  if (found == entries_.end()) {
    v1::StreamRecord record;
    *record.mutable_study() = study;
    record.set_actor(std::string(actor));
    record.set_opened_unix_s(clock_.UnixSeconds());
    RETURN_IF_ERROR(Begin(std::move(record)).status());
  } else if (found->second.record.closed()) {
    return AlreadyExists("stream '{}' is being closed: its pairs are removed; try again soon",
                         study.name());
  } else if (LastingPart(found->second.study()) != LastingPart(study)) {
    return AlreadyExists(
        "stream '{}' is there already, with other settings: give this study another name, or "
        "`parallax stream {} --close`",
        study.name(), study.name());
  } else if (UserOfActor(found->second.record.actor()) == UserOfActor(actor) &&
             DeterministicBytes(found->second.study()) != DeterministicBytes(study)) {
    v1::StreamRecord record = found->second.record;
    *record.mutable_study() = study;
    RETURN_IF_ERROR(Keep(found->second, std::move(record)));
  }
  Stream& stream = entries_[study.name()];
  RETURN_IF_ERROR(BeginChunks(stream));
  v1::StreamStatus status = StatusOf(stream, /*whole=*/true);
  *status.mutable_study() = stream.study();
  status.mutable_study()->clear_notify();
  return status;
}

absl::StatusOr<v1::StreamStatus> StreamKeeper::Close(const std::string& name) {
  std::lock_guard lock(mu_);
  ASSIGN_OR_RETURN(Stream * stream, Find(name));
  if (!stream->record.closed()) {
    v1::StreamRecord closed = stream->record;
    closed.set_closed(true);
    RETURN_IF_ERROR(Keep(*stream, std::move(closed)));
  }
  return StatusOf(*stream, /*whole=*/true);
}

int64_t StreamKeeper::OldestRound(const Stream& stream) const {
  int64_t oldest = std::numeric_limits<int64_t>::max(), oldest_heard = oldest;
  for (const v1::StreamConsumer& consumer : stream.record.consumers()) {
    const int64_t round = StreamPosition::Of(consumer.acknowledged()).round;
    oldest = std::min(oldest, round);
    const SteadyTime heard = stream.heard.at({consumer.name(), consumer.rank()});
    if (SecondsBetween(heard, clock_.Steady()) < SilentSecondsOf(stream.study()))
      oldest_heard = std::min(oldest_heard, round);
  }
  // Nothing is forgotten for consumers that are all silent.
  oldest = oldest_heard != std::numeric_limits<int64_t>::max() ? oldest_heard : oldest;
  const int64_t first = stream.record.chunks_forgotten() + UsesOf(stream.study()) - 1;
  const int64_t kept = stream.record.chunks_forgotten() == 0 ? 0 : first;
  return oldest == std::numeric_limits<int64_t>::max() ? kept : std::max(oldest, kept);
}

int64_t StreamKeeper::OldestChunk(const Stream& stream) const {
  return ChunksOfRound(stream.study(), OldestRound(stream)).first;
}

absl::Status StreamKeeper::BeginChunks(Stream& stream) {
  const int64_t end = OldestRound(stream) + 1 + ChunksAheadOf(stream.study());
  stream.needs.clear();
  while (stream.chunks_begun() < end) {
    const int64_t chunk = stream.chunks_begun();
    v1::SubmitRequest request;
    *request.mutable_study() = ChunkStudy(stream.study(), chunk);
    request.set_idempotency_key(KeyOf(stream.record, chunk));
    const absl::StatusOr<v1::SubmitReply> reply = queue_.Submit(request, stream.record.actor());
    if (!reply.ok()) {
      stream.needs =
          fmt::format("chunk {} can't be submitted: {}", chunk, ToStd(reply.status().message()));
      return absl::OkStatus();
    }
    v1::StreamRecord record = stream.record;
    record.add_chunk_studies(reply->study_id());
    RETURN_IF_ERROR(Keep(stream, std::move(record)));
    stream.chunks[chunk].study = reply->study_id();
  }
  return absl::OkStatus();
}

absl::Status StreamKeeper::ForgetChunks(Stream& stream) {
  const int64_t oldest = OldestChunk(stream);
  for (auto& [number, chunk] : stream.chunks) {
    if (number < oldest && !chunk.used_up) chunk.used_up = clock_.Steady();
  }
  while (!stream.chunks.empty()) {
    const auto first = stream.chunks.begin();
    const Chunk& chunk = first->second;
    if (!chunk.used_up ||
        SecondsBetween(*chunk.used_up, clock_.Steady()) < KeepSecondsOf(stream.study())) {
      return absl::OkStatus();
    }
    const absl::StatusOr<v1::ForgetReply> forgotten = queue_.Forget(
        StudyId{chunk.study}, "its consumers are done with it", stream.record.actor());
    // A chunk that a silent consumer left behind may not have ended.
    if (absl::IsFailedPrecondition(forgotten.status())) {
      return queue_.Cancel(StudyId{chunk.study}, "no consumer needs it", stream.record.actor());
    }
    if (!forgotten.ok() && !absl::IsNotFound(forgotten.status())) return forgotten.status();
    // Its earlier studies too: BeginAgain may have been broken off before it forgot one. A key is
    // followed by its user's name.
    for (const char* rest : {"\n", "/after/"}) {
      ASSIGN_OR_RETURN(
          const std::vector<int64_t> earlier,
          queue_.ListSubmitted(KeyOf(stream.record, first->first) + rest, stream.record.actor()));
      for (const int64_t study : earlier) {
        const absl::Status gone =
            queue_.Forget(StudyId{study}, "its chunk was begun again", stream.record.actor())
                .status();
        if (!gone.ok() && !absl::IsNotFound(gone)) return gone;
      }
    }
    v1::StreamRecord record = stream.record;
    record.set_chunks_forgotten(first->first + 1);
    record.mutable_chunk_studies()->erase(record.chunk_studies().begin());
    RETURN_IF_ERROR(Keep(stream, std::move(record)));
    std::erase_if(stream.rounds, [&](const auto& round) {
      return ChunksOfRound(stream.study(), round.first).first <= first->first;
    });
    stream.chunks.erase(first);
  }
  return absl::OkStatus();
}

absl::StatusOr<bool> StreamKeeper::End(Stream& stream) {
  stream.rounds.clear();
  // By their keys: the record lacks a study if a coordinator died between its submission and Keep.
  ASSIGN_OR_RETURN(const std::vector<int64_t> studies,
                   queue_.ListSubmitted(KeysOf(stream.record), stream.record.actor()));
  bool all_gone = true;
  for (const int64_t study : studies) {
    ASSIGN_OR_RETURN(
        const bool is_gone,
        queue_.CancelAndForget(StudyId{study}, "its stream is closed", stream.record.actor()));
    all_gone = all_gone && is_gone;
  }
  if (all_gone) stream.chunks.clear();
  return all_gone;
}

absl::Status StreamKeeper::Tick() {
  std::lock_guard lock(mu_);
  return AdvanceAll();
}

absl::StatusOr<bool> StreamKeeper::Advance(Stream& stream) {
  if (stream.record.closed()) return End(stream);
  RETURN_IF_ERROR(ForgetChunks(stream));
  RETURN_IF_ERROR(BeginChunks(stream));
  for (auto& [number, chunk] : stream.chunks) {
    RETURN_IF_ERROR(LookAt(stream, number, chunk));
    if (chunk.failed) RETURN_IF_ERROR(BeginAgain(stream, number, chunk));
  }
  return false;
}

absl::Status StreamKeeper::LookAt(const Stream& stream, int64_t number, Chunk& chunk) {
  if (chunk.ended) return absl::OkStatus();
  if (SecondsBetween(chunk.looked, clock_.Steady()) < kLookEvery_s) return absl::OkStatus();
  chunk.looked = clock_.Steady();
  const absl::StatusOr<v1::StudyStatus> study = queue_.GetStudy(StudyId{chunk.study});
  chunk.needs.clear();
  if (absl::IsNotFound(study.status())) {
    chunk.needs = fmt::format(
        "chunk {} (study {}) was forgotten before it was delivered: `parallax "
        "stream {} --close`, and begin it again",
        number, chunk.study, stream.study().name());
    return absl::OkStatus();
  }
  RETURN_IF_ERROR(study.status());
  chunk.failed = study->state() == v1::STUDY_STATE_FAILED;
  chunk.needs = NeedsOf(
      *study, fmt::format("chunk {}", number),
      fmt::format("`parallax stream {} --close`, and begin it again", stream.study().name()));
  if (study->state() != v1::STUDY_STATE_SUCCEEDED) return absl::OkStatus();
  std::vector<v1::StreamedPair> pairs;
  int64_t filtered_out = 0;
  v1::ListFramesRequest request;
  request.set_study_id(chunk.study);
  request.set_limit(kFramesAtOnce);
  while (true) {
    ASSIGN_OR_RETURN(std::vector<v1::PublishedFrame> frames, queue_.ListFrames(request));
    if (frames.empty()) break;
    request.set_cursor(frames.back().cursor());
    for (v1::PublishedFrame& frame : frames) {
      const absl::StatusOr<bool> passes = Passes(stream.study(), frame);
      if (!passes.ok()) {
        chunk.needs = fmt::format("chunk {} (study {}): {}", number, chunk.study,
                                  ToStd(passes.status().message()));
        return absl::OkStatus();
      }
      if (!*passes) {
        ++filtered_out;
        continue;
      }
      v1::StreamedPair& pair = pairs.emplace_back();
      pair.set_chunk(number);
      pair.set_variant(frame.variant());
      pair.set_scene(frame.scene());
      *pair.mutable_frame() = std::move(*frame.mutable_frame());
    }
  }
  std::sort(pairs.begin(), pairs.end(), [](const v1::StreamedPair& a, const v1::StreamedPair& b) {
    return std::tuple(std::string_view(a.variant()), a.scene(), a.frame().rig()) <
           std::tuple(std::string_view(b.variant()), b.scene(), b.frame().rig());
  });
  chunk.pairs = std::move(pairs);
  chunk.filtered_out = filtered_out;
  chunk.ended = true;
  return absl::OkStatus();
}

absl::Status StreamKeeper::BeginAgain(Stream& stream, int64_t number, Chunk& chunk) {
  const int64_t before = chunk.study;
  ASSIGN_OR_RETURN(const bool is_archived, queue_.IsArchived(StudyId{before}));
  if (!is_archived) return absl::OkStatus();
  v1::SubmitRequest request;
  *request.mutable_study() = ChunkStudy(stream.study(), number);
  // A start that dies before the record is kept finds the same study again.
  request.set_idempotency_key(fmt::format("{}/after/{}", KeyOf(stream.record, number), before));
  const auto reply = queue_.Submit(request, stream.record.actor());
  if (!reply.ok()) {
    chunk.needs = fmt::format("chunk {} can't be submitted again: {}", number,
                              ToStd(reply.status().message()));
    return absl::OkStatus();
  }
  v1::StreamRecord record = stream.record;
  record.set_chunk_studies(static_cast<int>(number - record.chunks_forgotten()), reply->study_id());
  RETURN_IF_ERROR(queue_.KeepStream(record));
  stream.record = std::move(record);
  chunk = {.study = reply->study_id()};
  const absl::Status forgotten =
      queue_.Forget(StudyId{before}, "its chunk was begun again", stream.record.actor()).status();
  return absl::IsNotFound(forgotten) ? absl::OkStatus() : forgotten;
}

absl::StatusOr<const StreamKeeper::Round*> StreamKeeper::RoundOf(Stream& stream, int64_t number,
                                                                 std::string* waits_for) {
  const auto known = stream.rounds.find(number);
  if (known != stream.rounds.end()) return &known->second;
  const auto [first, last] = ChunksOfRound(stream.study(), number);
  std::vector<const v1::StreamedPair*> pairs;
  for (int64_t i = first; i <= last; ++i) {
    const auto chunk = stream.chunks.find(i);
    if (chunk == stream.chunks.end()) {
      *waits_for = !stream.needs.empty()
                       ? stream.needs
                       : fmt::format("chunk {} is not begun: slower consumers come first", i);
      return nullptr;
    }
    RETURN_IF_ERROR(LookAt(stream, i, chunk->second));
    if (!chunk->second.ended) {
      *waits_for = chunk->second.needs.empty()
                       ? fmt::format("chunk {} (study {}) is being made", i, chunk->second.study)
                       : chunk->second.needs;
      return nullptr;
    }
    for (const v1::StreamedPair& pair : chunk->second.pairs) pairs.push_back(&pair);
  }
  Round round(pairs.size());
  const std::vector<uint32_t> order = OrderOfRound(stream.study(), number, pairs.size());
  for (size_t i = 0; i < order.size(); ++i) round[i] = pairs[order[i]];
  return &(stream.rounds[number] = std::move(round));
}

absl::StatusOr<v1::StreamConsumer*> StreamKeeper::Hear(Stream& stream,
                                                       const v1::NextPairsRequest& request) {
  v1::StreamConsumer* found = nullptr;
  for (v1::StreamConsumer& consumer : *stream.record.mutable_consumers()) {
    if (consumer.name() != request.consumer()) continue;
    if (consumer.ranks() != request.ranks()) {
      return InvalidArgument(
          "consumer '{}' has {} ranks, and one of {} asks: take another name for the consumer, or "
          "as many ranks as before",
          request.consumer(), consumer.ranks(), request.ranks());
    }
    if (consumer.rank() == request.rank()) found = &consumer;
  }
  if (found == nullptr) {
    const int64_t round = StreamPosition::Of(request.position()).round;
    if (!request.resume() && round > stream.chunks_begun()) {
      return OutOfRange("consumer '{}' begins with pairs of round {}, and round {} is not made",
                        request.consumer(), round, stream.chunks_begun());
    }
    if (stream.record.consumers_size() + request.ranks() > kMostConsumers) {
      return ResourceExhausted(
          "stream '{}' has {} ranks of consumers, {} more ask, allowed are {} in all: take a name "
          "that a consumer had before",
          stream.study().name(), stream.record.consumers_size(), request.ranks(), kMostConsumers);
    }
    if (request.ranks() > ChunkPairsOf(stream.study())) {
      return InvalidArgument(
          "consumer '{}' has {} ranks, and a round of stream '{}' has {} pairs, so some ranks "
          "would get none: wanted is a stream whose stream.chunk_pairs is at least {}",
          request.consumer(), request.ranks(), stream.study().name(), ChunkPairsOf(stream.study()),
          request.ranks());
    }
    // All of its ranks: what one of them has not asked for yet is kept.
    const uint64_t begin = request.resume() ? BeginOf(OldestRound(stream)) : request.position();
    v1::StreamRecord record = stream.record;
    for (int rank = 0; rank < request.ranks(); ++rank) {
      v1::StreamConsumer& consumer = *record.add_consumers();
      consumer.set_name(request.consumer());
      consumer.set_rank(rank);
      consumer.set_ranks(request.ranks());
      consumer.set_acknowledged(begin);
    }
    RETURN_IF_ERROR(Keep(stream, std::move(record)));
    for (int rank = 0; rank < request.ranks(); ++rank) {
      stream.heard[{request.consumer(), rank}] = clock_.Steady();
    }
    found = stream.record.mutable_consumers(stream.record.consumers_size() - request.ranks() +
                                            request.rank());
  }
  stream.heard[{request.consumer(), request.rank()}] = clock_.Steady();
  found->set_heard_unix_s(clock_.UnixSeconds());
  return found;
}

absl::StatusOr<v1::NextPairsReply> StreamKeeper::Next(const v1::NextPairsRequest& request) {
  std::lock_guard lock(mu_);
  ASSIGN_OR_RETURN(Stream * stream, Find(request.stream()));
  if (stream->record.closed()) return NotFound("stream '{}' is closed", request.stream());
  ASSIGN_OR_RETURN(v1::StreamConsumer * consumer, Hear(*stream, request));
  const uint64_t before = consumer->acknowledged();
  if (request.acknowledged() > before) {
    const int64_t round = StreamPosition::Of(request.acknowledged()).round;
    if (round > stream->chunks_begun()) {
      return OutOfRange("{} acknowledges pairs of round {}, and round {} is not made",
                        Named(*consumer), round, stream->chunks_begun());
    }
    consumer->set_acknowledged(request.acknowledged());
    const absl::Status kept = queue_.KeepStream(stream->record);
    if (!kept.ok()) {
      consumer->set_acknowledged(before);  // It does not count: the next call must keep it.
      return kept;
    }
  }

  v1::NextPairsReply reply;
  StreamPosition at =
      StreamPosition::Of(request.resume() ? consumer->acknowledged() : request.position());
  if (ChunksOfRound(stream->study(), at.round).first < stream->record.chunks_forgotten()) {
    return OutOfRange(
        "the pairs of round {} are forgotten, the first that is kept is {}: {} was silent for more "
        "than silent_s while others went on, or begins from a position before its "
        "acknowledgement; position {} goes on",
        at.round, OldestRound(*stream), Named(*consumer), BeginOf(OldestRound(*stream)));
  }
  const int limit = request.limit() > 0 ? std::min(request.limit(), kMostPairs) : kUsualPairs;
  const auto ranks = static_cast<uint32_t>(request.ranks());
  const auto rank = static_cast<uint32_t>(request.rank());
  while (reply.pairs_size() < limit) {
    ASSIGN_OR_RETURN(const Round* round, RoundOf(*stream, at.round, reply.mutable_waits_for()));
    if (round == nullptr) break;
    // The first place from here on that is this rank's. Where filters have left fewer pairs than
    // ranks, the ranks without one take turns.
    const auto turn = static_cast<uint32_t>(round->size() < ranks ? at.round % ranks : 0);
    at.place += (rank + turn + ranks - at.place % ranks) % ranks;
    if (at.place >= round->size()) {
      at = {at.round + 1, 0};
      continue;
    }
    v1::StreamedPair& pair = *reply.add_pairs();
    pair = *(*round)[at.place];
    pair.set_position(at.Packed());
    ++at.place;
  }
  reply.set_position(at.Packed());
  if (!reply.pairs().empty()) reply.clear_waits_for();
  return reply;
}

v1::StreamStatus StreamKeeper::StatusOf(Stream& stream, bool) const {
  v1::StreamStatus status;
  status.set_name(stream.study().name());
  status.set_user(UserOfActor(stream.record.actor()));
  status.set_closed(stream.record.closed());
  status.set_opened_unix_s(stream.record.opened_unix_s());
  status.set_chunks_begun(stream.chunks_begun());
  status.set_chunks_forgotten(stream.record.chunks_forgotten());
  status.set_needs(stream.needs);
  bool is_made = true;
  status.set_chunks_made(stream.record.chunks_forgotten());
  for (const auto& [number, chunk] : stream.chunks) {
    is_made = is_made && chunk.ended;
    if (is_made) status.set_chunks_made(number + 1);
    status.set_pairs_filtered_out(status.pairs_filtered_out() + chunk.filtered_out);
    status.set_pairs_kept(status.pairs_kept() + static_cast<int64_t>(chunk.pairs.size()));
    if (status.needs().empty()) status.set_needs(chunk.needs);
  }
  *status.mutable_consumers() = stream.record.consumers();
  return status;
}

}  // namespace parallax
