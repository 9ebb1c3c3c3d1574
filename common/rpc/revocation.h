// The certificates that a farm no longer accepts: a file in the coordinator's TLS folder with one
// SHA-256 fingerprint a line. It is read again when it changes.
#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "common/base/status.h"
#include "common/base/system/clock.h"

namespace parallax {

// Name of the file in the folder of `coordinator serve --tls`.
inline constexpr char kRevokedFile[] = "revoked";

// Thread-safe.
class RevokedCertificates {
 public:
  // Reads the list. If there is no file at `path`, nothing is revoked. If a changed file can't be
  // read later, the old list stays and the log has a warning. `clock` must outlive the object.
  // Errors: kInvalidArgument for a line that is not a fingerprint; those of ReadFile.
  static absl::StatusOr<std::unique_ptr<RevokedCertificates>> Open(const std::string& path,
                                                                   Clock& clock);
  virtual ~RevokedCertificates() = default;

  // Returns whether the certificate with this fingerprint (lower-case hex) is revoked. A change of
  // the file counts after at most a second.
  virtual bool Contains(std::string_view sha256) = 0;
};

}  // namespace parallax
