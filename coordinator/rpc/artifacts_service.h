// The service `parallax.v1.Artifacts`: transfers files of the store for workers and clients that
// cannot reach it.
//
// - A worker puts a file only below the folder of an attempt that it holds, both when the transfer
//   begins and when it ends. So a worker that has lost its lease can't change published files.
// - Bytes go to the spool, are hashed on their way, synced to disk and moved into the store: a file
//   is in the store whole and as announced, or not at all. Sending the same file again costs one
//   round trip.
// - Submitters and operators put only the user's content (common/store/content.h): files named by
//   their hashes, so that none can be changed. The total size of all content is bounded.
// - Memory is bounded: each call buffers one chunk, and the number of calls is bounded.
// - No caller can keep the others out. Streams without a header are counted apart from those that
//   move files; when there are too many, the one that has waited longest is ended. A call without
//   traffic is ended. One certificate on one machine has at most half of the places, whatever names
//   it claims, and content at most half of those for files.
//
// Thread-safe.
#pragma once

#include <grpcpp/grpcpp.h>

#include <atomic>
#include <functional>
#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <string>

#include "common/base/status.h"
#include "coordinator/rpc/call_watch.h"
#include "coordinator/rpc/content_keeper.h"
#include "parallax/v1/service.grpc.pb.h"

namespace parallax {

class JobQueue;
class Store;
class StoreGuard;

inline constexpr size_t kFileChunkBytes = 1 << 20;
inline constexpr int64_t kMaxFileBytes = int64_t{1} << 30;

// Bounds on the time and number of calls.
struct ArtifactsLimits {
  double header_s = 10;      // Longest wait of a Put stream for its header.
  double idle_s = 30;        // Longest wait for a peer that neither sends nor reads.
  double transfer_s = 120;   // Time for a whole file, beside that of its bytes at bytes_per_s.
  double bytes_per_s = 5e5;  // Half the rate at which a sending worker gives up.
  size_t waiting = 64;       // Streams without a header.
  size_t puts = 64;          // Files that are received at a time.
  size_t reads = 64;         // Calls of Get, List and Remove at a time.
  size_t puts_a_peer = 32;
  size_t reads_a_peer = 32;
  ContentOptions content;  // Bounds on the users' content.
};

// Bounds the number of concurrent calls, of all callers together and of each caller. Thread-safe.
class CallPlaces {
 public:
  CallPlaces(size_t all, size_t of_one) : all_(all), of_one_(of_one) {}

  // Takes a place if one is free, and gives it back when destroyed. `places` must outlive it.
  class Place {
   public:
    Place(CallPlaces& places, std::string caller);
    ~Place();
    Place(const Place&) = delete;
    Place& operator=(const Place&) = delete;
    // Returns OK if the call got a place. Errors: kUnavailable if all places are taken.
    absl::Status status() const;

   private:
    CallPlaces& places_;
    const std::string caller_;
    bool granted_ = false;
  };

 private:
  const size_t all_;
  const size_t of_one_;
  std::mutex mu_;
  size_t taken_ = 0;  // Guarded by mu_, like the following.
  std::map<std::string, size_t> by_caller_;
};

class ArtifactsService final : public v1::Artifacts::Service {
 public:
  // Checks that this worker may now put the file `path` of this attempt or, with `folder`, remove
  // the folder `path`.
  using Rule = std::function<absl::Status(const std::string& worker, const v1::AttemptId& attempt,
                                          const std::string& path, bool folder)>;

  // `store` must outlive the service; if it is null, every call is kFailedPrecondition. `spool_dir`
  // holds files that are being received, best on the store's disk.
  ArtifactsService(Store* store, std::string spool_dir, Rule rule,
                   const ArtifactsLimits& limits = {});

  // Makes the spool folder and empties it. Call it before the first RPC. Errors: those of the
  // folder.
  absl::Status Prepare();

  // Sets what watches the store: while it is not there, no call is served. Call it before the first
  // RPC; `guard` must outlive the calls.
  void SetGuard(const StoreGuard* guard) { guard_ = guard; }

  // Keeps the users' content; null without a store.
  ContentKeeper* content() { return content_.get(); }

  using PutStream = grpc::ServerReaderWriter<v1::PutFileReply, v1::PutFileMessage>;
  grpc::Status Put(grpc::ServerContext* context, PutStream* stream) override;
  grpc::Status Get(grpc::ServerContext* context, const v1::GetFileRequest* request,
                   grpc::ServerWriter<v1::FileChunk>* writer) override;
  grpc::Status List(grpc::ServerContext* context, const v1::ListFilesRequest* request,
                    grpc::ServerWriter<v1::ListFilesReply>* writer) override;
  grpc::Status Remove(grpc::ServerContext* context, const v1::RemoveFilesRequest* request,
                      v1::RemoveFilesReply* reply) override;

 private:
  class SpoolFile;
  absl::Status ReadHeader(PutStream& stream, CallWatch::Call& call, v1::PutFileHeader* header);
  // PutOutput puts a file below an attempt's folder. Both functions reply whether the file is
  // wanted, receive it if so, and reply that it is stored.
  absl::Status PutOutput(PutStream& stream, CallWatch::Call& call, const v1::PutFileHeader& header);
  absl::Status PutFileThere(PutStream& stream, CallWatch::Call& call,
                            const v1::PutFileHeader& header,
                            const std::function<absl::Status()>& allowed);
  absl::Status PutContent(PutStream& stream, CallWatch::Call& call,
                          const v1::PutFileHeader& header);
  absl::Status Receive(PutStream& stream, CallWatch::Call& call, const v1::PutFileHeader& header,
                       SpoolFile& file);
  // Runs `body(call)` in a place for reads, and ends the call if the peer stops reading.
  template <typename Body>
  grpc::Status RunRead(grpc::ServerContext* context, Body body);

  absl::Status CheckStore() const;

  Store* const store_;
  const StoreGuard* guard_ = nullptr;
  const std::string spool_dir_;
  const Rule rule_;
  const ArtifactsLimits limits_;
  CallWatch watch_;
  CallPlaces puts_;
  CallPlaces content_puts_;
  CallPlaces reads_;
  std::mutex waiting_mu_;
  std::list<CallWatch::Call*> waiting_;     // Without a header, the longest first. Guarded.
  std::atomic<uint64_t> spooled_ = 0;       // Gives names to spool files.
  std::unique_ptr<ContentKeeper> content_;  // Null without a store.
};

// Returns the coordinator's rule, whose errors are kAborted unless the worker holds the attempt,
// and kInvalidArgument for a path outside the attempt's folder. `queue` must outlive it.
ArtifactsService::Rule HolderWritesBelowItsAttempt(const JobQueue& queue);

// Checks that `path` is below "<key>/.attempt-<fence>/" or, with `folder_itself`, that it equals
// this folder. Errors: kInvalidArgument.
absl::Status CheckAttemptPath(std::string_view path, uint64_t fence, bool folder_itself);

}  // namespace parallax
