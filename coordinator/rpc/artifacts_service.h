// `parallax.v1.Artifacts`: files of the store for workers and clients that do not see it.
//
// - A worker puts files only below the folder of an attempt that it holds, both when it begins and
//   when it ends; so a zombie can't touch anything, and what it left is never published.
// - Bytes go to the spool, are hashed on their way, brought to disk and moved into the store: a
//   file is there whole and as announced, or not at all. The same file again costs one round trip.
// - Memory is bounded: a chunk for each call, and a bound on calls.
//
// Thread-safe.
#pragma once

#include <grpcpp/grpcpp.h>

#include <atomic>
#include <functional>
#include <string>

#include "common/base/status.h"
#include "parallax/v1/service.grpc.pb.h"

namespace parallax {

class JobQueue;
class Store;

inline constexpr size_t kFileChunkBytes = 1 << 20;
inline constexpr int64_t kMaxFileBytes = int64_t{1} << 30;

class ArtifactsService final : public v1::Artifacts::Service {
 public:
  // Whether this worker may change `path` now under this attempt; `folder`: remove it as a whole.
  using Rule = std::function<absl::Status(const std::string& worker, const v1::AttemptId& attempt,
                                          const std::string& path, bool folder)>;

  // `store` null: every call is kFailedPrecondition. It outlives the service.
  ArtifactsService(Store* store, std::string spool_dir, Rule rule);

  // Empties and makes the spool.
  absl::Status Prepare();

  using PutStream = grpc::ServerReaderWriter<v1::PutFileReply, v1::PutFileMessage>;
  grpc::Status Put(grpc::ServerContext*, PutStream* stream) override;
  grpc::Status Get(grpc::ServerContext*, const v1::GetFileRequest*,
                   grpc::ServerWriter<v1::FileChunk>*) override;
  grpc::Status List(grpc::ServerContext*, const v1::ListFilesRequest*,
                    grpc::ServerWriter<v1::ListFilesReply>*) override;
  grpc::Status Remove(grpc::ServerContext*, const v1::RemoveFilesRequest*,
                      v1::RemoveFilesReply*) override;

 private:
  absl::Status PutOne(PutStream& stream);
  template <typename Body>
  grpc::Status Run(Body body);

  Store* const store_;
  const std::string spool_dir_;
  const Rule rule_;
  std::atomic<int> calls_ = 0;         // Each holds a thread and a chunk.
  std::atomic<uint64_t> spooled_ = 0;  // Names files.
};

// The rule of a coordinator: kAborted unless the worker holds the attempt, kInvalidArgument for a
// path outside of the attempt's folder. `queue` outlives it.
ArtifactsService::Rule HolderWritesBelowItsAttempt(const JobQueue& queue);

// kInvalidArgument unless `path` lies below "<key>/.attempt-<fence>/", or is that folder with
// `folder_itself`.
absl::Status CheckAttemptPath(std::string_view path, uint64_t fence, bool folder_itself);

}  // namespace parallax
