#include "common/store/s3_options.h"

#include <algorithm>
#include <cstdlib>
#include <initializer_list>
#include <optional>

#include "common/store/s3_text.h"
#include "common/store/store.h"

namespace parallax {
namespace {

constexpr std::string_view kScheme = "s3://";

std::string Environment(std::initializer_list<const char*> names) {
  for (const char* name : names) {
    const char* value = std::getenv(name);
    if (value != nullptr && *value != '\0') return value;
  }
  return "";
}

absl::Status BadUri(std::string_view uri, const std::string& why) {
  return InvalidArgument(
      "store {}: {} (wanted s3://BUCKET[/PREFIX][?endpoint=URL&region=NAME&path_style=1])", uri,
      why);
}

}  // namespace

absl::StatusOr<S3Options> ParseS3Uri(std::string_view uri) {
  S3Options options;
  options.endpoint = Environment({"AWS_ENDPOINT_URL_S3", "AWS_ENDPOINT_URL"});
  options.region = Environment({"AWS_REGION", "AWS_DEFAULT_REGION"});
  options.access_key = Environment({"AWS_ACCESS_KEY_ID"});
  options.secret_key = Environment({"AWS_SECRET_ACCESS_KEY"});
  options.session_token = Environment({"AWS_SESSION_TOKEN"});
  if (options.access_key.empty() && options.secret_key.empty()) {
    options.credentials_command = Environment({"PARALLAX_S3_CREDENTIALS"});
  }
  std::optional<bool> path_style;
  const size_t mark = uri.find('?');
  const std::string_view place = uri.substr(0, mark).substr(kScheme.size());
  std::string_view rest = mark == std::string_view::npos ? "" : uri.substr(mark + 1);
  while (!rest.empty()) {
    const std::string_view pair = rest.substr(0, rest.find('&'));
    rest.remove_prefix(std::min(rest.size(), pair.size() + 1));
    const std::string name(pair.substr(0, pair.find('=')));
    const std::string value = PercentDecode(pair.substr(std::min(pair.size(), name.size() + 1)));
    if (name == "endpoint") {
      options.endpoint = value;
    } else if (name == "region") {
      options.region = value;
    } else if (name == "path_style" && (value == "0" || value == "1")) {
      path_style = value == "1";
    } else {
      return BadUri(uri, "unknown setting '" + std::string(pair) + "'");
    }
  }
  options.bucket = place.substr(0, place.find('/'));
  if (place.size() > options.bucket.size())
    options.prefix = place.substr(options.bucket.size() + 1);
  while (!options.prefix.empty() && options.prefix.back() == '/') options.prefix.pop_back();
  if (options.bucket.empty()) return BadUri(uri, "no bucket");
  if (!options.prefix.empty()) {
    const absl::Status prefix = CheckStorePath(options.prefix);
    if (!prefix.ok()) return BadUri(uri, std::string(ToStd(prefix.message())));
  }
  if (options.region.empty()) options.region = "us-east-1";
  // A certificate for *.s3.REGION.amazonaws.com is not one for a host with another dot.
  const bool has_dot = options.bucket.find('.') != std::string::npos;
  options.path_style = path_style.value_or(!options.endpoint.empty() || has_dot);
  if (options.endpoint.empty()) {
    const bool is_china = options.region.starts_with("cn-");
    options.endpoint = "https://s3." + options.region + ".amazonaws.com" + (is_china ? ".cn" : "");
  }
  while (options.endpoint.ends_with('/')) options.endpoint.pop_back();
  if (options.endpoint.rfind("http://", 0) != 0 && options.endpoint.rfind("https://", 0) != 0) {
    return BadUri(uri, "endpoint '" + options.endpoint + "' is neither http:// nor https://");
  }
  if (options.credentials_command.empty() &&
      (options.access_key.empty() || options.secret_key.empty())) {
    return FailedPrecondition(
        "store {}: no credentials; set AWS_ACCESS_KEY_ID and AWS_SECRET_ACCESS_KEY, or "
        "PARALLAX_S3_CREDENTIALS to a command that prints them (`aws configure "
        "export-credentials --format process`)",
        uri);
  }
  return options;
}

std::string S3Uri(const S3Options& options) {
  return std::string(kScheme) + options.bucket +
         (options.prefix.empty() ? "" : "/" + options.prefix) +
         "?endpoint=" + PercentEncode(options.endpoint, true) + "&region=" + options.region +
         "&path_style=" + (options.path_style ? "1" : "0");
}

}  // namespace parallax
