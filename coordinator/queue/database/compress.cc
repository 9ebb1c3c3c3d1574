#include "coordinator/queue/database/compress.h"

#include <zstd.h>

#include <memory>

#include "coordinator/queue/database/stored_size.h"
#include "coordinator/study/keys.h"

namespace parallax {
namespace {
constexpr int kLevel = 1;

// Making a context costs more than compressing a small message.
ZSTD_CCtx* Compressor() {
  thread_local const std::unique_ptr<ZSTD_CCtx, size_t (*)(ZSTD_CCtx*)> context(ZSTD_createCCtx(),
                                                                                ZSTD_freeCCtx);
  return context.get();
}
ZSTD_DCtx* Decompressor() {
  thread_local const std::unique_ptr<ZSTD_DCtx, size_t (*)(ZSTD_DCtx*)> context(ZSTD_createDCtx(),
                                                                                ZSTD_freeDCtx);
  return context.get();
}

}  // namespace

std::string Compress(std::string_view bytes) {
  std::string out(ZSTD_compressBound(bytes.size()), '\0');
  out.resize(
      ZSTD_compressCCtx(Compressor(), out.data(), out.size(), bytes.data(), bytes.size(), kLevel));
  return out;
}

absl::StatusOr<std::string> Decompress(std::string_view bytes) {
  const unsigned long long size = ZSTD_getFrameContentSize(bytes.data(), bytes.size());
  if (size > kMaxStoredBytes) return DataLoss("not a zstd frame of ours");
  std::string out(static_cast<size_t>(size), '\0');
  const size_t got =
      ZSTD_decompressDCtx(Decompressor(), out.data(), out.size(), bytes.data(), bytes.size());
  if (ZSTD_isError(got) || got != out.size()) {
    return DataLoss("broken zstd frame");
  }
  return out;
}

std::string PackMessage(const google::protobuf::MessageLite& message) {
  return Compress(DeterministicBytes(message));
}

absl::Status UnpackMessage(std::string_view packed, google::protobuf::MessageLite& message) {
  ASSIGN_OR_RETURN(const std::string bytes, Decompress(packed));
  if (message.ParseFromString(bytes)) return absl::OkStatus();
  return DataLoss("a stored message does not parse");
}

}  // namespace parallax
