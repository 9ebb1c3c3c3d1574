// Keeps streams going: submits the chunks that their consumers will come to, hands their pairs out,
// and forgets chunks that are used up. Nothing of it is lost by a restart: what consumers have
// acknowledged, and the studies of the chunks, are in the queue's database.
//
// - A chunk is submitted under an idempotency key of its own, so that a restart finds it again.
// - Chunks are made up to `chunks_ahead` beyond the consumer that is farthest behind. So a slow one
//   holds the makers back, and the disk is bounded: `uses` + `chunks_ahead` chunks, beside those
//   that `keep_s` keeps.
// - A consumer that is silent for `silent_s` keeps nothing while others go on. If it comes back to
//   pairs that are gone, it hears so.
//
// Thread-safe. Blocks on the queue.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "common/base/status.h"
#include "common/base/system/clock.h"
#include "coordinator/queue/record_keeper.h"
#include "coordinator/stream/stream_order.h"
#include "parallax/v1/stream.pb.h"

namespace parallax {

// A chunk that was begun, and not forgotten.
struct StreamChunk {
  int64_t study = 0;
  SteadyTime looked;  // When its study was last asked for its state.
  bool ended = false;
  bool failed = false;
  std::string needs;                    // Why it does not end without a person.
  std::vector<v1::StreamedPair> pairs;  // Once it has ended: in the order of stream_order.h.
  int64_t filtered_out = 0;             // Pairs that fail a filter, which nobody gets.
  std::optional<SteadyTime> used_up;    // When it was found that no consumer needs it any more.
};

struct OpenStream {
  using Round = std::vector<const v1::StreamedPair*>;  // In the order of delivery.
  v1::StreamRecord record;
  std::map<int64_t, StreamChunk> chunks;
  std::map<int64_t, Round> rounds;  // Consumers have asked for them.
  // When ranks were last heard, by (consumer, rank). A restart hears all of them.
  std::map<std::pair<std::string, int>, SteadyTime> heard;
  std::string needs;  // Why no chunk can be begun.

  const v1::StudySpec& study() const { return record.study(); }
  int64_t chunks_begun() const { return record.chunks_forgotten() + record.chunk_studies_size(); }
};

class StreamKeeper final : public RecordKeeper<OpenStream, v1::StreamStatus> {
 public:
  StreamKeeper(JobQueue& queue, Clock& clock)
      : RecordKeeper(queue, clock, "stream",
                     {&JobQueue::ListStreams, &JobQueue::KeepStream, &JobQueue::RemoveStream}) {}

  // Begins a stream, or finds the one that was begun with the same study; if `actor` began it, its
  // later chunks have the `notify` of now. `actor` is who asks, for the audit table. Errors:
  // kAlreadyExists for a name that another stream has; kInvalidArgument for a study that is not
  // endless; those of JobQueue::Submit and of the database.
  absl::StatusOr<v1::StreamStatus> Open(const v1::StudySpec& given, std::string_view actor);
  // Ends a stream. Its chunks are cancelled and forgotten by the next calls of Tick. Errors:
  // kNotFound.
  absl::StatusOr<v1::StreamStatus> Close(const std::string& name);

  // Returns pairs and keeps the acknowledgement, durably if it is a new one. Without pairs the
  // reply says what it waits for: ask again. Errors: kNotFound for an unknown or closed stream;
  // kInvalidArgument for another number of ranks than the consumer has, or for more than a round
  // has pairs; kOutOfRange for a position
  // whose pairs are forgotten, or are far from made; kResourceExhausted for too many consumers.
  absl::StatusOr<v1::NextPairsReply> Next(const v1::NextPairsRequest& request);

  // Submits and forgets chunks as the consumers need. Call it every second or so. Errors: the
  // database's; others are what `needs` of a status says.
  absl::Status Tick();

 private:
  using Chunk = StreamChunk;
  using Stream = OpenStream;
  using Round = OpenStream::Round;

  // All need mu_.
  void Fill(Stream& stream) const override;
  absl::StatusOr<bool> Advance(Stream& stream) override;
  // Submits the chunks that consumers will come to; why it can't is in `needs`.
  absl::Status BeginChunks(Stream& stream);
  absl::Status ForgetChunks(Stream& stream);
  // Cancels and forgets all studies of a closed stream, also those that its record lacks. Returns
  // whether all are gone.
  absl::StatusOr<bool> End(Stream& stream);
  // Asks for the state of a chunk's study, and for its pairs when it has ended.
  absl::Status LookAt(const Stream& stream, int64_t number, Chunk& chunk);
  // Submits a chunk anew whose study failed and has gone to the archive, where nobody can retry it.
  absl::Status BeginAgain(Stream& stream, int64_t number, Chunk& chunk);
  // Returns the round; null with the reason if its pairs are not all made.
  absl::StatusOr<const Round*> RoundOf(Stream& stream, int64_t number, std::string* waits_for);
  // Finds the consumer's rank, or enters it durably, and notes that it was heard.
  absl::StatusOr<v1::StreamConsumer*> Hear(Stream& stream, const v1::NextPairsRequest& request);
  // Returns the oldest round that some consumer may still ask for.
  int64_t OldestRound(const Stream& stream) const;
  // Returns the first chunk of which that round has pairs.
  int64_t OldestChunk(const Stream& stream) const;
  v1::StreamStatus StatusOf(Stream& stream, bool whole) const override;
};

}  // namespace parallax
