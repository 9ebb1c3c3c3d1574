#include "common/rpc/remote_store.h"

#include <grpcpp/grpcpp.h>

#include <functional>

#include "common/base/hash.h"
#include "common/base/status.h"
#include "common/base/system/file.h"
#include "common/rpc/endpoint.h"
#include "common/rpc/grpc_status.h"
#include "parallax/v1/service.grpc.pb.h"

namespace parallax {
namespace {

using Seconds = std::chrono::duration<double>;

// Time limit of a call without bytes; a file's limit adds the time of its bytes at 1 MB/s.
constexpr double kPatience_s = 30;
constexpr double kSlowestLink_bytes_per_s = 1e6;
constexpr size_t kChunkBytes = 1 << 20;
constexpr size_t kMaxGetBytes = size_t{1} << 30;

class RemoteStore final : public Store {
 public:
  RemoteStore(std::shared_ptr<grpc::Channel> channel, RemoteStoreWriter writer)
      : artifacts_(v1::Artifacts::NewStub(std::move(channel))), writer_(std::move(writer)) {}

  std::string Uri() const override { return "coordinator:"; }

  absl::Status Put(std::string_view path, std::string_view bytes) override {
    const StoreFile facts{static_cast<int64_t>(bytes.size()), Sha256Hex(bytes)};
    return Send(path, facts, [bytes](int64_t offset) -> absl::StatusOr<std::string> {
      return std::string(bytes.substr(static_cast<size_t>(offset), kChunkBytes));
    });
  }

  absl::Status PutFile(std::string_view path, const std::string& local_path, const StoreFile& facts,
                       bool) override {
    std::FILE* const file = std::fopen(local_path.c_str(), "rbe");
    if (file == nullptr) return ErrnoError(errno, "read " + local_path);
    const std::unique_ptr<std::FILE, int (*)(std::FILE*)> owner(file, &std::fclose);
    return Send(path, facts, [&](int64_t) -> absl::StatusOr<std::string> {
      std::string chunk(kChunkBytes, '\0');
      chunk.resize(std::fread(chunk.data(), 1, chunk.size(), file));
      if (chunk.empty()) return DataLoss("{}: shorter than it was", local_path);
      return chunk;
    });
  }

  absl::StatusOr<std::string> Get(std::string_view path) const override {
    return Read(path, 0, kMaxGetBytes);
  }

  absl::StatusOr<std::string> GetPiece(std::string_view path, int64_t offset,
                                       size_t max_bytes) const override {
    return Read(path, offset, max_bytes);
  }

  absl::StatusOr<std::vector<StoreEntry>> List(std::string_view prefix) const override {
    if (!prefix.empty()) RETURN_IF_ERROR(CheckStorePath(prefix));
    grpc::ClientContext context;
    SetRpcTimeout(context, Seconds(kPatience_s));
    v1::ListFilesRequest request;
    request.set_prefix(std::string(prefix));
    const auto reader = artifacts_->List(&context, request);
    std::vector<StoreEntry> entries;
    for (v1::ListFilesReply reply; reader->Read(&reply);) {
      for (const v1::FileFacts& file : reply.files()) {
        entries.push_back({file.path(), file.size()});
      }
    }
    RETURN_IF_ERROR(FromGrpc(reader->Finish()));
    return entries;
  }

  absl::Status RemoveTree(std::string_view path) override {
    RETURN_IF_ERROR(CheckStorePath(path));
    grpc::ClientContext context;
    SetRpcTimeout(context, Seconds(kPatience_s));
    v1::RemoveFilesRequest request;
    *request.mutable_attempt() = writer_.attempt;
    request.set_worker(writer_.worker);
    request.set_path(std::string(path));
    v1::RemoveFilesReply reply;
    return FromGrpc(artifacts_->Remove(&context, request, &reply));
  }

  absl::StatusOr<std::string> LocalPath(std::string_view path) const override {
    RETURN_IF_ERROR(CheckStorePath(path));
    return FailedPrecondition("the coordinator's store has no folder here");
  }

 private:
  // `next` gives the bytes from an offset on, a chunk at most.
  absl::Status Send(std::string_view path, const StoreFile& facts,
                    const std::function<absl::StatusOr<std::string>(int64_t)>& next) {
    RETURN_IF_ERROR(CheckStorePath(path));
    grpc::ClientContext context;
    SetRpcTimeout(
        context, Seconds(kPatience_s + static_cast<double>(facts.size) / kSlowestLink_bytes_per_s));
    const auto stream = artifacts_->Put(&context);
    v1::PutFileMessage message;
    v1::PutFileHeader& header = *message.mutable_header();
    *header.mutable_attempt() = writer_.attempt;
    header.set_worker(writer_.worker);
    header.set_path(std::string(path));
    header.set_size(facts.size);
    header.set_sha256(facts.sha256);
    v1::PutFileReply reply;
    if (!stream->Write(message) || !stream->Read(&reply)) return End(*stream);
    if (!reply.wanted()) {
      stream->WritesDone();
      return End(*stream);
    }
    for (int64_t sent = 0; sent < facts.size;) {
      absl::StatusOr<std::string> chunk = next(sent);
      if (!chunk.ok()) {
        context.TryCancel();
        stream->Finish();
        return chunk.status();
      }
      sent += static_cast<int64_t>(chunk->size());
      message.set_chunk(*std::move(chunk));
      if (!stream->Write(message)) return End(*stream);
    }
    stream->WritesDone();
    const bool stored = stream->Read(&reply) && reply.stored();
    RETURN_IF_ERROR(End(*stream));
    return stored ? absl::OkStatus() : Unavailable("the coordinator did not say stored");
  }

  template <typename Stream>
  static absl::Status End(Stream& stream) {
    return FromGrpc(stream.Finish());
  }

  absl::StatusOr<std::string> Read(std::string_view path, int64_t offset, size_t max_bytes) const {
    RETURN_IF_ERROR(CheckStorePath(path));
    grpc::ClientContext context;
    SetRpcTimeout(context, Seconds(kPatience_s +
                                   static_cast<double>(kMaxGetBytes) / kSlowestLink_bytes_per_s));
    v1::GetFileRequest request;
    request.set_path(std::string(path));
    request.set_offset(offset);
    const auto reader = artifacts_->Get(&context, request);
    std::string bytes;
    for (v1::FileChunk chunk; bytes.size() < max_bytes && reader->Read(&chunk);) {
      bytes += chunk.data();
    }
    if (bytes.size() >= max_bytes) {  // The rest is not wanted, if there is one.
      bytes.resize(max_bytes);
      context.TryCancel();
      reader->Finish();
      return bytes;
    }
    RETURN_IF_ERROR(FromGrpc(reader->Finish()));
    return bytes;
  }

  const std::unique_ptr<v1::Artifacts::Stub> artifacts_;
  const RemoteStoreWriter writer_;
};

}  // namespace

std::unique_ptr<Store> MakeRemoteStore(std::shared_ptr<grpc::Channel> channel,
                                       RemoteStoreWriter writer) {
  return std::make_unique<RemoteStore>(std::move(channel), std::move(writer));
}

}  // namespace parallax
