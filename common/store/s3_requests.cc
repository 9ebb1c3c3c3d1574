#include "common/store/s3_requests.h"

#include <fmt/core.h>

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <utility>

#include "common/base/status.h"
#include "common/base/system/log.h"
#include "common/store/s3_text.h"

namespace parallax {
namespace {

// 400 RequestTimeout: the body came too slowly, which is no mistake of the request.
bool IsTransient(const HttpAnswer& answer) {
  return answer.code == 0 || answer.code == 429 || answer.code >= 500 ||
         (answer.code == 400 && Element(answer.body, "Code") == "RequestTimeout");
}

// A HEAD's answer has no body that says so.
bool AreTooOld(const HttpAnswer& answer) {
  const std::string_view code = Element(answer.body, "Code");
  return code == "ExpiredToken" || code == "InvalidAccessKeyId" ||
         (answer.body.empty() && (answer.code == 400 || answer.code == 403));
}

absl::StatusCode CodeOf(const HttpAnswer& answer) {
  switch (answer.code) {
    case 301:  // The bucket is in another region, or has another endpoint.
    case 307:
      return absl::StatusCode::kFailedPrecondition;
    case 404:
      return absl::StatusCode::kNotFound;
    case 401:
    case 403:
      return absl::StatusCode::kPermissionDenied;
    case 400:
      return IsTransient(answer) ? absl::StatusCode::kUnavailable
                                 : absl::StatusCode::kFailedPrecondition;
    case 507:
      return absl::StatusCode::kResourceExhausted;
    default:
      return absl::StatusCode::kUnavailable;
  }
}

void Pause(std::chrono::milliseconds pause) {
  std::mutex mu;
  std::condition_variable never;
  std::unique_lock lock(mu);
  never.wait_for(lock, pause, [] { return false; });
}

}  // namespace

absl::Status S3Error(const HttpAnswer& answer, const std::string& what) {
  std::string why(Element(answer.body, "Code"));
  if (const auto message = Element(answer.body, "Message"); !message.empty()) {
    why += fmt::format(": {}", message);
  }
  if (const auto endpoint = Element(answer.body, "Endpoint"); !endpoint.empty()) {
    why += fmt::format("; the endpoint is {}; set region or endpoint in the store's URI", endpoint);
  }
  if (answer.code == 0) return Unavailable("{}: {}", what, answer.error);
  return MakeError(CodeOf(answer), fmt::format("{}: HTTP {} {}", what, answer.code, why));
}

S3Requests::S3Requests(S3Options options)
    : options_(std::move(options)),
      credentials_(options_.credentials_command.empty()
                       ? std::make_unique<S3CredentialSource>(S3Credentials{
                             options_.access_key, options_.secret_key, options_.session_token})
                       : std::make_unique<S3CredentialSource>(options_.credentials_command,
                                                              Clock::System())) {}

std::string S3Requests::UrlOf(const std::string& key, const S3Query& query) const {
  std::string url;
  const size_t host = options_.endpoint.find("://") + 3;
  if (options_.path_style) {
    url = options_.endpoint + "/" + PercentEncode(options_.bucket, false);
  } else {
    url =
        options_.endpoint.substr(0, host) + options_.bucket + "." + options_.endpoint.substr(host);
  }
  url += "/" + PercentEncode(key, true);
  char mark = '?';
  for (const auto& [name, value] : query) {
    url += mark + PercentEncode(name, false) + "=" + PercentEncode(value, false);
    mark = '&';
  }
  return url;
}

absl::StatusOr<HttpAnswer> S3Requests::Ask(HttpRequest request, const std::string& key,
                                           const S3Query& query,
                                           const std::set<int>& expected) const {
  request.url = UrlOf(key, query);
  const std::string what = "s3 " + request.method + " " + options_.bucket + "/" + key;
  HttpAnswer answer;
  auto pause = options_.first_pause;
  bool renewed = false;
  for (int i = 1;; ++i) {
    ASSIGN_OR_RETURN(const S3Credentials credentials, credentials_->Get());
    answer = http_.Send(request, {.access_key = credentials.access_key,
                                  .secret_key = credentials.secret_key,
                                  .session_token = credentials.session_token,
                                  .region = options_.region});
    if (AreTooOld(answer) && !renewed && credentials_->Renew(credentials)) {
      renewed = true;
      continue;
    }
    if (!IsTransient(answer) || i >= options_.tries) break;
    LogDebug("s3 request to be tried again", {{"request", what}, {"code", answer.code}});
    Pause(pause);
    pause = std::min(pause * 2, options_.longest_pause);
  }
  if ((answer.code >= 200 && answer.code < 300) || expected.count(answer.code) > 0) {
    return answer;
  }
  return S3Error(answer, what);
}

}  // namespace parallax
