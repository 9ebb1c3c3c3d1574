#include "common/config/check/notify_check.h"

#include <algorithm>

#include "common/base/http_url.h"
#include "common/config/check/checks.h"

namespace parallax {
namespace config_internal {

void CheckNotify(const v1::StudySpec& study, Findings* findings) {
  if (!study.has_notify()) return;
  const v1::NotifySpec& notify = study.notify();
  CheckFields(notify, "notify", findings);
  const std::string why = notify.has_url()
                              ? WhyNotHttpUrl(notify.url())
                              : "missing, allowed is http://HOST/... or https://HOST/...";
  if (!why.empty()) findings->push_back({"notify.url", why});
  const bool only_done =
      !notify.on().empty() && std::all_of(notify.on().begin(), notify.on().end(),
                                          [](const std::string& event) { return event == "done"; });
  if (study.has_stream() && only_done) {
    findings->push_back({"notify.on",
                         "only done, and an endless study never is; allowed are failed, stalled "
                         "and waits"});
  }
}

}  // namespace config_internal

v1::NotifySpec TakeNotify(v1::StudySpec* study) {
  v1::NotifySpec notify;
  notify.Swap(study->mutable_notify());
  study->clear_notify();
  if (notify.url().empty()) return notify;
  const std::string shown = "<" + HostOfUrl(notify.url()) + ">";
  std::string& text = *study->mutable_source_yaml();
  for (size_t at = 0; (at = text.find(notify.url(), at)) != std::string::npos;) {
    text.replace(at, notify.url().size(), shown);
    at += shown.size();
  }
  return notify;
}

}  // namespace parallax
