#include "coordinator/rpc/artifacts_service.h"

#include <fcntl.h>
#include <fmt/core.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <optional>

#include "common/base/hash.h"
#include "common/base/seconds.h"
#include "common/rpc/endpoint.h"
#include "common/rpc/grpc_status.h"
#include "common/store/content.h"
#include "common/store/store.h"
#include "common/store/store_guard.h"
#include "coordinator/queue/job_queue.h"
#include "coordinator/rpc/validation.h"

namespace parallax {
namespace {

namespace fs = std::filesystem;

constexpr int kFilesInAMessage = 1000;

bool IsSha256Hex(const std::string& text) {
  return text.size() == 64 && text.find_first_not_of("0123456789abcdef") == std::string::npos;
}

}  // namespace

// A file of the spool: removed again unless the store took it.
class ArtifactsService::SpoolFile {
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

namespace {

constexpr double kOwnWork_s = 3600;  // Limit while a call waits for the store, not its peer.

absl::Status NoStore() { return FailedPrecondition("this coordinator serves no files"); }

// Names the caller that a call counts for, by certificate and machine: by nothing that the caller
// may say or have many of.
std::string PeerOf(const grpc::ServerContext& context) {
  std::string peer = context.peer();
  if (peer.rfind("ip", 0) == 0) peer.resize(std::min(peer.rfind(':'), peer.size()));
  return CallerOf(context).name + " " + peer;
}

absl::Status CheckHeader(const v1::PutFileHeader& header) {
  RETURN_IF_ERROR(CheckPutHeader(header));
  RETURN_IF_ERROR(CheckStorePath(header.path()));
  if (header.size() < 0 || header.size() > kMaxFileBytes) {
    return InvalidArgument("file {} of {} bytes; allowed is [0, {}]", header.path(), header.size(),
                           kMaxFileBytes);
  }
  if (!IsSha256Hex(header.sha256())) {
    return InvalidArgument("file {}: no SHA-256 of 64 lower-case hex digits", header.path());
  }
  return absl::OkStatus();
}

// Workers put their attempts' files, people the content of their studies.
absl::Status CheckMayPut(const RpcCaller& caller, const v1::PutFileHeader& header) {
  const bool content = IsBelowContent(header.path());
  const bool may = content ? caller.Is(Role::kSubmitter) || caller.Is(Role::kOperator)
                           : caller.Is(Role::kWorker);
  if (may) return absl::OkStatus();
  return PermissionDenied("Put of {} is for the role {}; the certificate of '{}' has another",
                          header.path(), content ? "submitter or operator" : "worker", caller.name);
}

absl::Status CheckContent(const v1::PutFileHeader& header) {
  if (header.path() != ContentPath(header.sha256())) {
    return InvalidArgument("content {}: wanted is the path {} of its hash", header.path(),
                           ContentPath(header.sha256()));
  }
  if (header.size() <= kMostContentFileBytes) return absl::OkStatus();
  return InvalidArgument("content of {} bytes; allowed are {}", header.size(),
                         kMostContentFileBytes);
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
  const std::string folder = fmt::format("/.attempt-{}", fence);
  const size_t at = path.find(folder);
  const size_t end = at == std::string_view::npos ? at : at + folder.size();
  const bool inside = at != std::string_view::npos && at > 0 &&
                      (end == path.size() ? folder_itself : path[end] == '/');
  if (inside && path.find("/.attempt-") == at) return absl::OkStatus();
  return InvalidArgument("path {} is not below the folder of attempt {}", path, fence);
}

ArtifactsService::Rule HolderWritesBelowItsAttempt(const JobQueue& queue) {
  return [&queue](const std::string& worker, const v1::AttemptId& attempt, const std::string& path,
                  bool folder) -> absl::Status {
    RETURN_IF_ERROR(CheckAttempt(attempt));
    RETURN_IF_ERROR(CheckAttemptPath(path, attempt.fence(), folder));
    if (queue.IsHeldBy(worker, attempt)) return absl::OkStatus();
    return Aborted("attempt {} of job {} is not held by worker {}", attempt.fence(),
                   attempt.job_id(), worker);
  };
}

CallPlaces::Place::Place(CallPlaces& places, std::string caller)
    : places_(places), caller_(std::move(caller)) {
  const std::lock_guard lock(places_.mu_);
  const auto own = places_.by_caller_.find(caller_);
  const size_t held = own == places_.by_caller_.end() ? 0 : own->second;
  granted_ = places_.taken_ < places_.all_ && held < places_.of_one_;
  if (!granted_) return;
  ++places_.taken_;
  ++places_.by_caller_[caller_];
}

CallPlaces::Place::~Place() {
  if (!granted_) return;
  const std::lock_guard lock(places_.mu_);
  --places_.taken_;
  const auto own = places_.by_caller_.find(caller_);
  if (--own->second == 0) places_.by_caller_.erase(own);
}

absl::Status CallPlaces::Place::status() const {
  return granted_ ? absl::OkStatus() : Unavailable("busy");
}

ArtifactsService::ArtifactsService(Store* store, std::string spool_dir, Rule rule,
                                   const ArtifactsLimits& limits)
    : store_(store),
      spool_dir_(std::move(spool_dir)),
      rule_(std::move(rule)),
      limits_(limits),
      puts_(limits.puts, limits.puts_a_peer),
      content_puts_(limits.puts / 2, limits.puts_a_peer / 2),
      reads_(limits.reads, limits.reads_a_peer) {
  if (store_ != nullptr) content_ = std::make_unique<ContentKeeper>(*store_, limits.content);
}

absl::Status ArtifactsService::Prepare() {
  if (store_ == nullptr) return absl::OkStatus();
  std::error_code error;
  fs::remove_all(spool_dir_, error);
  fs::create_directories(spool_dir_, error);
  return error ? ErrnoError(error.value(), "spool " + spool_dir_) : absl::OkStatus();
}

absl::Status ArtifactsService::CheckStore() const {
  if (store_ == nullptr) return NoStore();
  return guard_ == nullptr ? absl::OkStatus() : guard_->status();
}

// ---- Putting
grpc::Status ArtifactsService::Put(grpc::ServerContext* context, PutStream* stream) {
  if (const absl::Status there = CheckStore(); !there.ok()) return ToGrpc(there);
  CallWatch::Call call(
      watch_, [context] { context->TryCancel(); }, limits_.header_s);
  v1::PutFileHeader header;
  absl::Status status = ReadHeader(*stream, call, &header);
  if (status.ok()) status = CheckMayPut(CallerOf(*context), header);
  if (status.ok()) {
    const bool is_content = IsBelowContent(header.path());
    const std::string peer = PeerOf(*context);
    const CallPlaces::Place place(puts_, peer);
    status = place.status();
    // Content has half of the places, so that workers always have some.
    std::optional<CallPlaces::Place> content_place;
    if (is_content) content_place.emplace(content_puts_, peer);
    if (content_place && status.ok()) status = content_place->status();
    if (status.ok()) {
      status = is_content ? PutContent(*stream, call, header) : PutOutput(*stream, call, header);
    }
  }
  if (call.expired()) status = DeadlineExceeded("nothing came for too long");
  return ToGrpc(status);
}

absl::Status ArtifactsService::ReadHeader(PutStream& stream, CallWatch::Call& call,
                                          v1::PutFileHeader* header) {
  std::list<CallWatch::Call*>::iterator seat;
  {
    const std::lock_guard lock(waiting_mu_);
    // A sender writes its header with the call itself: who has waited longest has nothing to send.
    if (waiting_.size() >= limits_.waiting) {
      for (CallWatch::Call* waiting : waiting_) {
        if (waiting->expired()) continue;  // Is about to leave.
        waiting->Expire();
        break;
      }
    }
    seat = waiting_.insert(waiting_.end(), &call);
  }
  v1::PutFileMessage first;
  const bool read = stream.Read(&first);
  {
    const std::lock_guard lock(waiting_mu_);
    waiting_.erase(seat);
  }
  if (!read || !first.has_header()) return InvalidArgument("a file without a header");
  *header = std::move(*first.mutable_header());
  return CheckHeader(*header);
}

absl::Status ArtifactsService::PutOutput(PutStream& stream, CallWatch::Call& call,
                                         const v1::PutFileHeader& header) {
  return PutFileThere(stream, call, header, [&] {
    return rule_(header.worker(), header.attempt(), header.path(), false);
  });
}

absl::Status ArtifactsService::PutContent(PutStream& stream, CallWatch::Call& call,
                                          const v1::PutFileHeader& header) {
  RETURN_IF_ERROR(CheckContent(header));
  content_->Note(header.sha256());
  // Files that are there are not sent again, and take no room twice.
  const bool is_there = IsThere(*store_, header);
  if (!is_there) RETURN_IF_ERROR(content_->TakeRoom(header.sha256(), header.size()));
  const absl::Status status = PutFileThere(stream, call, header, [] { return absl::OkStatus(); });
  if (!is_there) content_->EndRoom(header.sha256(), status.ok());
  return status;
}

absl::Status ArtifactsService::PutFileThere(PutStream& stream, CallWatch::Call& call,
                                            const v1::PutFileHeader& header,
                                            const std::function<absl::Status()>& allowed) {
  RETURN_IF_ERROR(allowed());
  call.Extend(kOwnWork_s);
  v1::PutFileReply reply;
  reply.set_wanted(!IsThere(*store_, header));
  call.Extend(limits_.idle_s);
  stream.Write(reply);
  if (!reply.wanted()) return absl::OkStatus();

  const std::string spooled = fmt::format("{}/{}", spool_dir_, ++spooled_);
  SpoolFile file(spooled);
  RETURN_IF_ERROR(file.Create());
  RETURN_IF_ERROR(Receive(stream, call, header, file));
  call.Extend(kOwnWork_s);
  // Its lease may have ended meanwhile.
  RETURN_IF_ERROR(allowed());
  RETURN_IF_ERROR(
      store_->PutFile(header.path(), spooled, {header.size(), header.sha256()}, /*may_move=*/true));
  reply.set_stored(true);
  call.Extend(limits_.idle_s);
  stream.Write(reply);
  return absl::OkStatus();
}

absl::Status ArtifactsService::Receive(PutStream& stream, CallWatch::Call& call,
                                       const v1::PutFileHeader& header, SpoolFile& file) {
  const SteadyTime end =
      SecondsAfter(Clock::System().Steady(),
                   limits_.transfer_s + static_cast<double>(header.size()) / limits_.bytes_per_s);
  const auto next = [&](v1::PutFileMessage* message) {
    call.Extend(std::min(limits_.idle_s, SecondsBetween(Clock::System().Steady(), end)));
    return stream.Read(message);
  };
  Sha256 hash;
  int64_t size = 0;
  for (v1::PutFileMessage message; size < header.size() && next(&message);) {
    const std::string& chunk = message.chunk();
    if (!message.has_chunk() || chunk.empty() || chunk.size() > kFileChunkBytes) {
      return InvalidArgument("wanted is a chunk of 1 to {} bytes", kFileChunkBytes);
    }
    size += static_cast<int64_t>(chunk.size());
    if (size > header.size()) break;
    hash.Update(chunk);
    RETURN_IF_ERROR(file.Append(chunk));
  }
  if (size != header.size() || HexOf(hash.Finish()) != header.sha256()) {
    return DataLoss("file {}: what came is not what was announced", header.path());
  }
  return absl::OkStatus();
}

// ---- Reading
template <typename Body>
grpc::Status ArtifactsService::RunRead(grpc::ServerContext* context, Body body) {
  if (const absl::Status there = CheckStore(); !there.ok()) return ToGrpc(there);
  const CallPlaces::Place place(reads_, PeerOf(*context));
  if (!place.status().ok()) return ToGrpc(place.status());
  CallWatch::Call call(
      watch_, [context] { context->TryCancel(); }, kOwnWork_s);
  return ToGrpc(body(call));
}

grpc::Status ArtifactsService::Get(grpc::ServerContext* context, const v1::GetFileRequest* request,
                                   grpc::ServerWriter<v1::FileChunk>* writer) {
  return RunRead(context, [&](CallWatch::Call& call) -> absl::Status {
    RETURN_IF_ERROR(CheckStorePath(request->path()));
    if (request->offset() < 0) return InvalidArgument("offset below 0");
    for (int64_t offset = request->offset(); !context->IsCancelled();) {
      v1::FileChunk chunk;
      call.Extend(kOwnWork_s);
      ASSIGN_OR_RETURN(*chunk.mutable_data(),
                       store_->GetPiece(request->path(), offset, kFileChunkBytes));
      offset += static_cast<int64_t>(chunk.data().size());
      call.Extend(limits_.idle_s);
      if (chunk.data().empty() || !writer->Write(chunk)) break;
    }
    return absl::OkStatus();
  });
}

grpc::Status ArtifactsService::List(grpc::ServerContext* context,
                                    const v1::ListFilesRequest* request,
                                    grpc::ServerWriter<v1::ListFilesReply>* writer) {
  return RunRead(context, [&](CallWatch::Call& call) -> absl::Status {
    ASSIGN_OR_RETURN(const std::vector<StoreEntry> entries, store_->List(request->prefix()));
    v1::ListFilesReply reply;
    for (const StoreEntry& entry : entries) {
      v1::FileFacts& file = *reply.add_files();
      file.set_path(entry.path);
      file.set_size(entry.size);
      if (reply.files_size() < kFilesInAMessage) continue;
      call.Extend(limits_.idle_s);
      if (!writer->Write(reply)) return absl::OkStatus();
      reply.Clear();
    }
    call.Extend(limits_.idle_s);
    if (reply.files_size() > 0) writer->Write(reply);
    return absl::OkStatus();
  });
}

grpc::Status ArtifactsService::Remove(grpc::ServerContext* context,
                                      const v1::RemoveFilesRequest* request,
                                      v1::RemoveFilesReply*) {
  return RunRead(context, [&](CallWatch::Call&) -> absl::Status {
    RETURN_IF_ERROR(CheckStorePath(request->path()));
    RETURN_IF_ERROR(rule_(request->worker(), request->attempt(), request->path(), true));
    return store_->RemoveTree(request->path());
  });
}

}  // namespace parallax
