// Asks an S3 server: makes a request's URL, tries again where that may help, and turns refusals
// into errors. Private to common/store. Thread-safe.
#pragma once

#include <map>
#include <memory>
#include <set>
#include <string>

#include "common/store/http_client.h"
#include "common/store/s3_credentials.h"
#include "common/store/s3_options.h"

namespace parallax {

using S3Query = std::map<std::string, std::string>;  // Sorted, as the signature wants it.

class S3Requests {
 public:
  explicit S3Requests(S3Options options);

  // Sends a request about the object `key`, or about the bucket if it is "". `request` needs no
  // URL. Answers 429, 5xx and RequestTimeout and broken connections are retried after a growing
  // pause, and once with fresh credentials what was refused for their age. Returns the answer if
  // its code is 2xx or `expected`. Errors: kUnavailable without an answer; those of S3Error.
  absl::StatusOr<HttpAnswer> Ask(HttpRequest request, const std::string& key,
                                 const S3Query& query = {},
                                 const std::set<int>& expected = {}) const;

 private:
  std::string UrlOf(const std::string& key, const S3Query& query) const;

  const S3Options options_;
  const HttpClient http_;
  const std::unique_ptr<S3CredentialSource> credentials_;
};

// Makes the error that an answer tells. `what` is the request. Errors: kNotFound (404),
// kPermissionDenied (401, 403), kFailedPrecondition (301, 307, 400), kResourceExhausted (507), or
// kUnavailable, also for 400 RequestTimeout.
absl::Status S3Error(const HttpAnswer& answer, const std::string& what);

}  // namespace parallax
