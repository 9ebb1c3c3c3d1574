#include "common/store/s3_credentials.h"

#include <time.h>

#include <chrono>
#include <nlohmann/json.hpp>
#include <thread>

#include "common/base/system/child_process.h"
#include "common/base/system/file.h"
#include "common/base/system/log.h"
#include "common/base/system/temporary_folder.h"

namespace parallax {
namespace {

constexpr double kRenewBefore_s = 300;
constexpr std::chrono::seconds kPatience{60};
constexpr std::chrono::milliseconds kLookEvery{20};
constexpr size_t kMostBytes = 1 << 20;

// "2026-11-28T22:10:00Z", also with "+00:00", in seconds since 1970; 0: cannot be read.
double EndOfCredentials(const std::string& text) {
  struct tm utc {};
  const char* rest = strptime(text.c_str(), "%Y-%m-%dT%H:%M:%S", &utc);
  if (rest == nullptr) return 0;
  if (*rest == '.') rest += 1 + strspn(rest + 1, "0123456789");
  const std::string zone = rest;
  return zone == "Z" || zone == "+00:00" ? static_cast<double>(timegm(&utc)) : 0;
}

}  // namespace

absl::StatusOr<S3Credentials> ParseS3Credentials(const std::string& printed) {
  const auto json = nlohmann::json::parse(printed, nullptr, /*allow_exceptions=*/false);
  if (!json.is_object()) return InvalidArgument("what it prints is not a JSON object");
  const auto text = [&](const char* name) {
    const auto field = json.find(name);
    return field != json.end() && field->is_string() ? field->get<std::string>() : std::string();
  };
  S3Credentials credentials{text("AccessKeyId"), text("SecretAccessKey"), text("SessionToken")};
  if (credentials.access_key.empty()) return InvalidArgument("it prints no AccessKeyId");
  if (credentials.secret_key.empty()) return InvalidArgument("it prints no SecretAccessKey");
  if (const std::string end = text("Expiration"); !end.empty()) {
    credentials.ends_unix_s = EndOfCredentials(end);
    if (credentials.ends_unix_s == 0) {
      return InvalidArgument("Expiration: \"{}\", wanted is a time as 2026-11-28T22:10:00Z", end);
    }
  }
  return credentials;
}

absl::StatusOr<S3Credentials> S3CredentialSource::Get() {
  const std::lock_guard lock(mu_);
  if (command_.empty()) return now_;
  const double left_s =
      now_.ends_unix_s > 0 ? now_.ends_unix_s - clock_->UnixSeconds() : 2 * kRenewBefore_s;
  if (!now_.access_key.empty() && left_s > kRenewBefore_s) return now_;
  absl::StatusOr<S3Credentials> fresh = Ask();
  if (fresh.ok()) {
    now_ = *fresh;
  } else if (!now_.access_key.empty() && left_s > 0) {
    LogWarning("credentials of the store are not renewed", {{"error", fresh.status()}});
    return now_;
  }
  return fresh;
}

bool S3CredentialSource::Renew(const S3Credentials& refused) {
  const std::lock_guard lock(mu_);
  if (command_.empty()) return false;
  if (now_.access_key == refused.access_key && now_.session_token == refused.session_token) {
    now_ = {};
  }
  return true;
}

// The command's output goes to a file that only this user may read and that is gone afterwards.
absl::StatusOr<S3Credentials> S3CredentialSource::Ask() const {
  const auto failed = [&](std::string_view why) {
    return PermissionDenied("credentials of the store, by `{}`: {}", command_, why);
  };
  ASSIGN_OR_RETURN(const TemporaryFolder folder, TemporaryFolder::Make("s3"));
  const std::string out = folder.path() + "/out", log = folder.path() + "/log";
  ASSIGN_OR_RETURN(
      const auto child,
      ChildProcess::Start(
          {.command = {"/bin/sh", "-c", "(" + command_ + "\n) >\"$0\"", out}, .log = log}));
  const auto end = std::chrono::steady_clock::now() + kPatience;
  std::optional<int> status;
  while (!(status = child->Poll())) {
    if (std::chrono::steady_clock::now() > end) return failed("has not ended after 60 s");
    std::this_thread::sleep_for(kLookEvery);
  }
  if (*status != 0) {
    const std::string said = ReadFile(log, kMostBytes).value_or("");
    return failed(DescribeExit(*status) + (said.empty() ? "" : ": " + said));
  }
  ASSIGN_OR_RETURN(const std::string printed, ReadFile(out, kMostBytes));
  absl::StatusOr<S3Credentials> credentials = ParseS3Credentials(printed);
  return credentials.ok() ? credentials : failed(ToStd(credentials.status().message()));
}

}  // namespace parallax
