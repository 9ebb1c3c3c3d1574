// Where a store on S3 is and who may use it, from a URI and the environment:
//
//   s3://BUCKET[/PREFIX][?endpoint=URL&region=NAME&path_style=1]
//
// endpoint    another server than AWS (default $AWS_ENDPOINT_URL_S3, $AWS_ENDPOINT_URL); its
//             buckets are then addressed by path
// region      default $AWS_REGION, $AWS_DEFAULT_REGION, us-east-1
// path_style  1: endpoint/bucket/key, 0: bucket.endpoint/key (default: 1 with an endpoint or a
//             bucket whose name has a dot)
//
// Credentials come from the environment only, never from the URI, which is shown and logged:
// AWS_ACCESS_KEY_ID, AWS_SECRET_ACCESS_KEY and AWS_SESSION_TOKEN; or, without these, from the
// command in PARALLAX_S3_CREDENTIALS, which is run again before they end (s3_credentials.h):
//
//   PARALLAX_S3_CREDENTIALS='aws configure export-credentials --format process'
#pragma once

#include <chrono>
#include <cstdint>
#include <string>
#include <string_view>

#include "common/base/status.h"

namespace parallax {

// Place and credentials of a store on S3, and how requests are retried.
struct S3Options {
  std::string bucket;
  std::string prefix;    // "" or "a/b", without slashes at its ends.
  std::string endpoint;  // "https://s3.eu-west-1.amazonaws.com"
  std::string region;
  bool path_style = false;
  std::string access_key;
  std::string secret_key;
  std::string session_token;
  std::string credentials_command;  // In place of the keys.
  int64_t part_bytes = 64 << 20;    // S3 wants at least 5 MiB, except for the last part.
  int tries = 7;
  std::chrono::milliseconds first_pause{100};  // Doubles with each try.
  std::chrono::milliseconds longest_pause{5000};
};

// Reads the options from the URI and the environment. Errors: kInvalidArgument that names what is
// wrong in the URI; kFailedPrecondition without credentials.
absl::StatusOr<S3Options> ParseS3Uri(std::string_view uri);

// Returns the URI that ParseS3Uri reads back to the same place, without credentials.
std::string S3Uri(const S3Options& options);

}  // namespace parallax
