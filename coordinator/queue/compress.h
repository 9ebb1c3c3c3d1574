// zstd for what the database keeps of messages. Thread-safe.
#pragma once

#include <string>
#include <string_view>

#include "common/base/status.h"
#include "google/protobuf/message_lite.h"

namespace parallax {

std::string Compress(std::string_view bytes);
// kDataLoss if they aren't what Compress made, or larger than 64 MiB.
absl::StatusOr<std::string> Decompress(std::string_view bytes);

// Deterministic bytes, compressed; and back.
std::string PackMessage(const google::protobuf::MessageLite& message);
absl::Status UnpackMessage(std::string_view packed, google::protobuf::MessageLite& message);

}  // namespace parallax
