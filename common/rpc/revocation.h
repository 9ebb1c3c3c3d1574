// Certificates that a farm no longer accepts: a file of the coordinator's TLS folder with one
// SHA-256 fingerprint a line, which is read again when it changes.
#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "common/base/clock.h"
#include "common/base/status.h"

namespace parallax {

// The file's name in the folder that `coordinator serve --tls` gets.
inline constexpr char kRevokedFile[] = "revoked";

// Thread-safe.
class RevokedCertificates {
 public:
  // `path` may be absent: then nothing is revoked. A file that can't be read later on changes
  // nothing, and is told in the log. Errors: kInvalidArgument for a line that is no fingerprint;
  // those of reading.
  static absl::StatusOr<std::unique_ptr<RevokedCertificates>> Open(const std::string& path,
                                                                   Clock& clock);
  virtual ~RevokedCertificates() = default;

  // Whether the certificate with this fingerprint (lower-case hex) is revoked, as of at most a
  // second ago.
  virtual bool Contains(std::string_view sha256) = 0;
};

}  // namespace parallax
