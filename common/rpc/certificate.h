// X.509 certificates of a farm: its own authority, a certificate for the coordinator, and one for
// each worker pool and each person, which carries the role. They are made and read only here.
//
// Each party has one folder with ca.crt (the authority that it trusts), tls.crt and tls.key (its
// own certificate and key). A Kubernetes TLS secret has the same names.
//
// All functions are thread-safe.
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/status.h"
#include "common/base/system/clock.h"
#include "common/rpc/role.h"

namespace parallax {

// A certificate and its private key, both as PEM.
struct KeyPair {
  std::string certificate_pem;
  std::string key_pem;  // P-256, PKCS 8, not encrypted.
};

// The parts of a certificate that Parallax uses.
struct CertificateFacts {
  std::string name;                // Common name.
  std::optional<Role> role;        // Absent for authorities and servers.
  std::vector<std::string> hosts;  // A server's names and addresses.
  double not_before_unix_s = 0;
  double not_after_unix_s = 0;
  std::string sha256;  // Fingerprint of the DER form, lower-case hex.
};

// Name and validity of a new certificate. It is valid from five minutes before `now_unix_s` (clocks
// differ) for `days` days, but no longer than its authority.
struct CertificateOrder {
  std::string name;  // [A-Za-z0-9][A-Za-z0-9._-]*, at most 64 characters.
  double now_unix_s = 0;
  double days = 0;
};

// Make an authority, and issue certificates of servers and clients with their keys.
// Errors: kInvalidArgument for a bad name or host; kInternal with OpenSSL's message.
absl::StatusOr<KeyPair> MakeAuthority(const CertificateOrder& order);
absl::StatusOr<KeyPair> IssueServer(const KeyPair& authority, const CertificateOrder& order,
                                    const std::vector<std::string>& hosts);
absl::StatusOr<KeyPair> IssueClient(const KeyPair& authority, const CertificateOrder& order,
                                    Role role);

// Parses a certificate. Errors: kInvalidArgument if `pem` is not a PEM certificate.
absl::StatusOr<CertificateFacts> ReadCertificate(const std::string& pem);

std::string DateOf(double unix_s);         // "2026-11-21"
std::string DateAndTimeOf(double unix_s);  // "2026-11-21 14:03:59"

// The content of one party's folder.
struct TlsIdentity {
  std::string dir;  // For messages.
  std::string ca_pem;
  KeyPair own;
  CertificateFacts facts;
};

// Reads and checks the folder `dir`. Errors: each says what to do. kNotFound that names a missing
// file; kInvalidArgument for a file that is not PEM; kFailedPrecondition if the key belongs to
// another certificate, or the certificate was not signed by ca.crt, has expired or is not valid
// yet.
absl::StatusOr<std::shared_ptr<const TlsIdentity>> LoadTlsIdentity(const std::string& dir,
                                                                   Clock& clock);

}  // namespace parallax
