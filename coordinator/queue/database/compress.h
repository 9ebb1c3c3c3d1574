// Compresses messages for the database by zstd. Thread-safe.
#pragma once

#include <string>
#include <string_view>

#include "common/base/status.h"
#include "google/protobuf/message_lite.h"

namespace parallax {

// Returns the compressed bytes. Equal bytes give equal results.
std::string Compress(std::string_view bytes);
// Returns the bytes that were given to Compress. Errors: kDataLoss if Compress did not make
// `bytes`, or the result would be larger than 64 MiB.
absl::StatusOr<std::string> Decompress(std::string_view bytes);

// Packs a message's deterministic bytes, and unpacks them. Errors: kDataLoss, as Decompress, or if
// the bytes are not such a message.
std::string PackMessage(const google::protobuf::MessageLite& message);
absl::Status UnpackMessage(std::string_view packed, google::protobuf::MessageLite& message);

}  // namespace parallax
