#include "coordinator/study/notify_hosts.h"

#include "common/base/http_url.h"
#include "common/base/names.h"

namespace parallax {
namespace {

constexpr char kAnyHost[] = "*";

}  // namespace

absl::StatusOr<NotifyHosts> NotifyHosts::Of(const std::vector<std::string>& hosts) {
  NotifyHosts allowed;
  for (const std::string& entry : hosts) {
    const std::string host = entry == kAnyHost ? entry : HostOfUrl("https://" + entry);
    const bool is_host = entry.find_first_of("/?#@") == std::string::npos;
    if (host.empty() || !is_host) {
      return InvalidArgument(
          "--notify-hosts {}: wanted HOST or HOST:PORT, such as "
          "hooks.example.com",
          Quoted(entry));
    }
    allowed.hosts_.insert(host);
  }
  return allowed;
}

bool NotifyHosts::Allows(std::string_view url) const {
  return hosts_.count(kAnyHost) > 0 || hosts_.count(HostOfUrl(url)) > 0;
}

absl::Status NotifyHosts::Check(const v1::StudySpec& study) const {
  if (!study.has_notify() || Allows(study.notify().url())) return absl::OkStatus();
  const std::string host = HostOfUrl(study.notify().url());
  return FailedPrecondition(
      "study '{}': notify.url: this coordinator posts no notices to {}: leave notify out, or have "
      "its operator allow the host (coordinator serve --notify-hosts {})",
      study.name(), host, host);
}

}  // namespace parallax
