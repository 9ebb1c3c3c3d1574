// X.509 for a farm: one authority of its own, a certificate for the coordinator, one for each
// worker pool and each person, with the role in it. The only home of OpenSSL's certificates.
//
// A party's files stand in one folder: ca.crt (whom it trusts), tls.crt, tls.key (who it is) - the
// names that a Kubernetes TLS secret has too.
//
// Functions are thread-safe.
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/clock.h"
#include "common/base/status.h"
#include "common/rpc/role.h"

namespace parallax {

struct KeyPair {
  std::string certificate_pem;
  std::string key_pem;  // P-256, PKCS 8, not encrypted.
};

struct CertificateFacts {
  std::string name;                // Common name.
  std::optional<Role> role;        // Absent for authorities and servers.
  std::vector<std::string> hosts;  // Of a server: names and addresses it may be reached by.
  double not_before_unix_s = 0;
  double not_after_unix_s = 0;
  std::string sha256;  // Its fingerprint: of the DER form, lower-case hex.
};

// What a new certificate says. Valid from five minutes before `now_unix_s` (clocks differ) for
// `days`, but no longer than its authority.
struct CertificateOrder {
  std::string name;  // [A-Za-z0-9][A-Za-z0-9._-]*, at most 64 characters.
  double now_unix_s = 0;
  double days = 0;
};

// Errors of all: kInvalidArgument for names and hosts; kInternal for what OpenSSL says.
absl::StatusOr<KeyPair> MakeAuthority(const CertificateOrder& order);
absl::StatusOr<KeyPair> IssueServer(const KeyPair& authority, const CertificateOrder& order,
                                    const std::vector<std::string>& hosts);
absl::StatusOr<KeyPair> IssueClient(const KeyPair& authority, const CertificateOrder& order,
                                    Role role);

// What a certificate says. Errors: kInvalidArgument for what is no PEM certificate.
absl::StatusOr<CertificateFacts> ReadCertificate(const std::string& pem);

std::string DateOf(double unix_s);         // "2026-11-21"
std::string DateAndTimeOf(double unix_s);  // "2026-11-21 14:03:59"

// One party's files, read.
struct TlsIdentity {
  std::string dir;  // For messages.
  std::string ca_pem;
  KeyPair own;
  CertificateFacts facts;
};

// Errors: kNotFound naming the file that the folder lacks; kInvalidArgument for files that are no
// PEM; kFailedPrecondition for a key of another certificate, a certificate that ca.crt did not
// sign, one that has expired or is not valid yet. Each says what to do.
absl::StatusOr<std::shared_ptr<const TlsIdentity>> LoadTlsIdentity(const std::string& dir,
                                                                   Clock& clock);

}  // namespace parallax
