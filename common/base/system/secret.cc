#include "common/base/system/secret.h"

#include <openssl/rand.h>

#include "common/base/hash.h"

namespace parallax {

absl::StatusOr<std::string> NewSecret() {
  unsigned char bytes[16];
  if (RAND_bytes(bytes, sizeof bytes) != 1) return Internal("no random numbers from OpenSSL");
  std::string hex;
  for (const unsigned char byte : bytes) {
    hex += "0123456789abcdef"[byte >> 4];
    hex += "0123456789abcdef"[byte & 15];
  }
  return hex;
}

bool SameSecret(std::string_view a, std::string_view b) {
  const Sha256Digest one = Sha256Of(a), other = Sha256Of(b);
  unsigned difference = 0;
  for (size_t i = 0; i < one.size(); ++i) difference |= one[i] ^ other[i];
  return difference == 0;
}

}  // namespace parallax
