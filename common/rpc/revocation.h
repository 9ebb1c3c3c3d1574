// The certificates that a farm no longer accepts: a file in the coordinator's TLS folder with one
// SHA-256 fingerprint a line. It is read again when it changes.
//
// A list that is lost revokes nobody, so it fails closed: a missing or empty file is an error at
// the start, and a certificate that was revoked while the process runs stays revoked until it ends,
// whatever becomes of the file. To take a revocation back, remove its line and restart.
#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "common/base/status.h"
#include "common/base/system/clock.h"

namespace parallax {

// Name of the file in the folder of `coordinator serve --tls`.
inline constexpr char kRevokedFile[] = "revoked";

// The text of a list that revokes nobody.
inline constexpr char kEmptyRevokedList[] =
    "# SHA-256 of certificates that are refused, one a line\n";

// Thread-safe.
class RevokedCertificates {
 public:
  // Reads the list. If a changed file can't be read later, or lacks an entry that it had, what was
  // read stays and the log says so. `clock` must outlive the object. Errors: kFailedPrecondition
  // for a file that is missing, or has neither an entry nor a comment; kInvalidArgument for a line
  // that is not a fingerprint; those of ReadFile.
  static absl::StatusOr<std::unique_ptr<RevokedCertificates>> Open(const std::string& path,
                                                                   Clock& clock);
  virtual ~RevokedCertificates() = default;

  // Returns whether the certificate with this fingerprint (lower-case hex) is revoked. A change of
  // the file counts after at most a second.
  virtual bool Contains(std::string_view sha256) = 0;
};

}  // namespace parallax
