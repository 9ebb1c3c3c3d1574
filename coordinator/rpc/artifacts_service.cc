#include "coordinator/rpc/artifacts_service.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>

#include "common/base/hash.h"
#include "common/rpc/grpc_status.h"
#include "common/store/store.h"
#include "coordinator/queue/job_queue.h"
#include "coordinator/rpc/validation.h"

namespace parallax {
namespace {

namespace fs = std::filesystem;

constexpr int kMostCalls = 64;
constexpr int kFilesInAMessage = 1000;

bool IsSha256Hex(const std::string& text) {
  return text.size() == 64 && text.find_first_not_of("0123456789abcdef") == std::string::npos;
}

// A file of the spool: removed again unless the store took it.
class SpoolFile {
 public:
  explicit SpoolFile(std::string path) : path_(std::move(path)) {}
  ~SpoolFile() {
    if (fd_ >= 0) close(fd_);
    unlink(path_.c_str());
  }
  SpoolFile(const SpoolFile&) = delete;
  SpoolFile& operator=(const SpoolFile&) = delete;

  absl::Status Create() {
    fd_ = open(path_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0644);
    return fd_ >= 0 ? absl::OkStatus() : ErrnoError(errno, "spool " + path_);
  }
  absl::Status Append(std::string_view bytes) {
    while (!bytes.empty()) {
      const ssize_t count = write(fd_, bytes.data(), bytes.size());
      if (count < 0 && errno == EINTR) continue;
      if (count < 0) return ErrnoError(errno, "spool " + path_);
      bytes.remove_prefix(static_cast<size_t>(count));
    }
    return absl::OkStatus();
  }

 private:
  const std::string path_;
  int fd_ = -1;
};

absl::Status CheckHeader(const v1::PutFileHeader& header) {
  RETURN_IF_ERROR(CheckStorePath(header.path()));
  if (header.size() < 0 || header.size() > kMaxFileBytes) {
    return absl::InvalidArgumentError("file " + header.path() + " of " +
                                      std::to_string(header.size()) + " bytes; allowed is [0, " +
                                      std::to_string(kMaxFileBytes) + "]");
  }
  if (!IsSha256Hex(header.sha256())) {
    return absl::InvalidArgumentError("file " + header.path() +
                                      ": no SHA-256 of 64 lower-case hex digits");
  }
  return absl::OkStatus();
}

absl::StatusOr<std::string> HashOf(const Store& store, const std::string& path) {
  Sha256 hash;
  for (int64_t offset = 0;;) {
    ASSIGN_OR_RETURN(const std::string piece, store.GetPiece(path, offset, kFileChunkBytes));
    if (piece.empty()) return HexOf(hash.Finish());
    hash.Update(piece);
    offset += static_cast<int64_t>(piece.size());
  }
}

// Left by an upload whose reply was lost, or by a worker that started again.
bool IsThere(const Store& store, const v1::PutFileHeader& header) {
  const auto entries = store.List(header.path());
  if (entries.ok() && !entries->empty()) return false;  // A folder.
  const auto beyond = store.GetPiece(header.path(), header.size(), 1);
  if (!beyond.ok() || !beyond->empty()) return false;
  const auto hash = HashOf(store, header.path());
  return hash.ok() && *hash == header.sha256();
}

}  // namespace

absl::Status CheckAttemptPath(std::string_view path, uint64_t fence, bool folder_itself) {
  RETURN_IF_ERROR(CheckStorePath(path));
  const std::string folder = "/.attempt-" + std::to_string(fence);
  const size_t at = path.find(folder);
  const size_t end = at == std::string_view::npos ? at : at + folder.size();
  const bool inside = at != std::string_view::npos && at > 0 &&
                      (end == path.size() ? folder_itself : path[end] == '/');
  if (inside && path.find("/.attempt-") == at) return absl::OkStatus();
  return absl::InvalidArgumentError("path " + std::string(path) +
                                    " is not below the folder of attempt " + std::to_string(fence));
}

ArtifactsService::Rule HolderWritesBelowItsAttempt(const JobQueue& queue) {
  return [&queue](const std::string& worker, const v1::AttemptId& attempt, const std::string& path,
                  bool folder) -> absl::Status {
    RETURN_IF_ERROR(CheckAttempt(attempt));
    RETURN_IF_ERROR(CheckAttemptPath(path, attempt.fence(), folder));
    if (queue.IsHeldBy(worker, attempt)) return absl::OkStatus();
    return absl::AbortedError("attempt " + std::to_string(attempt.fence()) + " of job " +
                              std::to_string(attempt.job_id()) + " is not held by worker " +
                              worker);
  };
}

ArtifactsService::ArtifactsService(Store* store, std::string spool_dir, Rule rule)
    : store_(store), spool_dir_(std::move(spool_dir)), rule_(std::move(rule)) {}

absl::Status ArtifactsService::Prepare() {
  if (store_ == nullptr) return absl::OkStatus();
  std::error_code error;
  fs::remove_all(spool_dir_, error);
  fs::create_directories(spool_dir_, error);
  return error ? ErrnoError(error.value(), "spool " + spool_dir_) : absl::OkStatus();
}

template <typename Body>
grpc::Status ArtifactsService::Run(Body body) {
  if (store_ == nullptr) {
    return ToGrpc(absl::FailedPreconditionError("this coordinator serves no files"));
  }
  const int before = calls_.fetch_add(1);
  const absl::Status status = before < kMostCalls ? body() : absl::UnavailableError("busy");
  calls_.fetch_sub(1);
  return ToGrpc(status);
}

grpc::Status ArtifactsService::Put(grpc::ServerContext*, PutStream* stream) {
  return Run([&] { return PutOne(*stream); });
}

absl::Status ArtifactsService::PutOne(PutStream& stream) {
  v1::PutFileMessage first;
  if (!stream.Read(&first) || !first.has_header()) {
    return absl::InvalidArgumentError("a file without a header");
  }
  const v1::PutFileHeader& header = first.header();
  RETURN_IF_ERROR(CheckHeader(header));
  RETURN_IF_ERROR(rule_(header.worker(), header.attempt(), header.path(), false));
  v1::PutFileReply reply;
  reply.set_wanted(!IsThere(*store_, header));
  stream.Write(reply);
  if (!reply.wanted()) return absl::OkStatus();

  const std::string spooled = spool_dir_ + "/" + std::to_string(++spooled_);
  SpoolFile file(spooled);
  RETURN_IF_ERROR(file.Create());
  Sha256 hash;
  int64_t size = 0;
  for (v1::PutFileMessage message; size < header.size() && stream.Read(&message);) {
    const std::string& chunk = message.chunk();
    if (!message.has_chunk() || chunk.empty() || chunk.size() > kFileChunkBytes) {
      return absl::InvalidArgumentError("wanted is a chunk of 1 to " +
                                        std::to_string(kFileChunkBytes) + " bytes");
    }
    size += static_cast<int64_t>(chunk.size());
    if (size > header.size()) break;
    hash.Update(chunk);
    RETURN_IF_ERROR(file.Append(chunk));
  }
  if (size != header.size() || HexOf(hash.Finish()) != header.sha256()) {
    return absl::DataLossError("file " + header.path() + ": what came is not what was announced");
  }
  // Its lease may have ended meanwhile.
  RETURN_IF_ERROR(rule_(header.worker(), header.attempt(), header.path(), false));
  RETURN_IF_ERROR(
      store_->PutFile(header.path(), spooled, {header.size(), header.sha256()}, /*may_move=*/true));
  reply.set_stored(true);
  stream.Write(reply);
  return absl::OkStatus();
}

grpc::Status ArtifactsService::Get(grpc::ServerContext* context, const v1::GetFileRequest* request,
                                   grpc::ServerWriter<v1::FileChunk>* writer) {
  return Run([&]() -> absl::Status {
    RETURN_IF_ERROR(CheckStorePath(request->path()));
    if (request->offset() < 0) return absl::InvalidArgumentError("offset below 0");
    for (int64_t offset = request->offset(); !context->IsCancelled();) {
      v1::FileChunk chunk;
      ASSIGN_OR_RETURN(*chunk.mutable_data(),
                       store_->GetPiece(request->path(), offset, kFileChunkBytes));
      offset += static_cast<int64_t>(chunk.data().size());
      if (chunk.data().empty() || !writer->Write(chunk)) break;
    }
    return absl::OkStatus();
  });
}

grpc::Status ArtifactsService::List(grpc::ServerContext*, const v1::ListFilesRequest* request,
                                    grpc::ServerWriter<v1::ListFilesReply>* writer) {
  return Run([&]() -> absl::Status {
    ASSIGN_OR_RETURN(const std::vector<StoreEntry> entries, store_->List(request->prefix()));
    v1::ListFilesReply reply;
    for (const StoreEntry& entry : entries) {
      v1::FileFacts& file = *reply.add_files();
      file.set_path(entry.path);
      file.set_size(entry.size);
      if (reply.files_size() < kFilesInAMessage) continue;
      writer->Write(reply);
      reply.Clear();
    }
    if (reply.files_size() > 0) writer->Write(reply);
    return absl::OkStatus();
  });
}

grpc::Status ArtifactsService::Remove(grpc::ServerContext*, const v1::RemoveFilesRequest* request,
                                      v1::RemoveFilesReply*) {
  return Run([&]() -> absl::Status {
    RETURN_IF_ERROR(CheckStorePath(request->path()));
    RETURN_IF_ERROR(rule_(request->worker(), request->attempt(), request->path(), true));
    return store_->RemoveTree(request->path());
  });
}

}  // namespace parallax
