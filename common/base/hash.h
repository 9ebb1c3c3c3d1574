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

// Computes the digest of bytes that arrive in pieces. Not thread-safe.
class Sha256 {
 public:
  Sha256();
  ~Sha256();
  // Appends bytes. Returns *this, for chains of calls.
  Sha256& Update(std::string_view bytes);
  // Returns the digest of all bytes so far. Call it once, as the last call.
  Sha256Digest Finish();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

// Returns the digest of `bytes`.
Sha256Digest Sha256Of(std::string_view bytes);
// Returns a digest as 64 lower-case hex characters.
std::string HexOf(const Sha256Digest& digest);
// Returns the digest of `bytes` as 64 lower-case hex characters.
std::string Sha256Hex(std::string_view bytes);

// Returns the digest of a file's content in hex. Reads the file in pieces, so its size does not
// matter. Errors: those of open(2) and read(2), naming the path.
absl::StatusOr<std::string> Sha256HexOfFile(const std::string& path);

}  // namespace parallax
