// SHA-256 for keys and manifests.   Source: FIPS 180-4; implementation: OpenSSL.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

#include "common/base/status.h"

namespace parallax {

using Sha256Digest = std::array<uint8_t, 32>;

// Incremental. Not thread-safe.
class Sha256 {
 public:
  Sha256();
  ~Sha256();
  Sha256& Update(std::string_view bytes);
  Sha256Digest Finish();  // Once.

 private:
  struct State;
  std::unique_ptr<State> state_;
};

Sha256Digest Sha256Of(std::string_view bytes);
std::string HexOf(const Sha256Digest& digest);  // 64 lower-case characters.
std::string Sha256Hex(std::string_view bytes);

// Of a file's content. Errors: as open(2) and read(2).
absl::StatusOr<std::string> Sha256HexOfFile(const std::string& path);

}  // namespace parallax
