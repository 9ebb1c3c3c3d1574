// Credentials for a store on S3: fixed ones of the environment, or those that a command prints,
// which are renewed before they end. The command speaks the protocol of AWS's `credential_process`,
// so that AWS's own tools know the chain (profile, single sign-on, web identity, instance role):
// {"Version": 1, "AccessKeyId": ..., "SecretAccessKey": ..., "SessionToken": ..., "Expiration":
// ...} Private to common/store.
#pragma once

#include <mutex>
#include <string>

#include "common/base/status.h"
#include "common/base/system/clock.h"

namespace parallax {

struct S3Credentials {
  std::string access_key;
  std::string secret_key;
  std::string session_token;  // "": none.
  double ends_unix_s = 0;     // 0: never.
};

// Reads what a command has printed. Errors: kInvalidArgument that names the missing field, and
// never shows what was printed.
absl::StatusOr<S3Credentials> ParseS3Credentials(const std::string& printed);

// Thread-safe.
class S3CredentialSource {
 public:
  explicit S3CredentialSource(S3Credentials fixed) : now_(std::move(fixed)) {}
  // Runs `command` by the shell when credentials are first asked for, and five minutes before they
  // end. `clock` must outlive the source.
  S3CredentialSource(std::string command, Clock& clock)
      : command_(std::move(command)), clock_(&clock) {}

  // Returns credentials that are valid now. If the command fails while those of before are still
  // valid, returns these. Errors: kPermissionDenied with the command and what it said.
  absl::StatusOr<S3Credentials> Get();
  // Hears that the server refused `refused` for their age. Returns whether Get will ask anew.
  bool Renew(const S3Credentials& refused);

 private:
  absl::StatusOr<S3Credentials> Ask() const;

  const std::string command_;  // "": the credentials are fixed.
  Clock* const clock_ = nullptr;
  std::mutex mu_;
  S3Credentials now_;  // Guarded by mu_; without access key: to be asked for.
};

}  // namespace parallax
