// The hosts to which studies may have notices posted. Values; thread-safe.
#pragma once

#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/status.h"
#include "parallax/v1/study.pb.h"

namespace parallax {

class NotifyHosts {
 public:
  NotifyHosts() = default;  // None.
  // Each is "HOST", at the port of http or https, or "HOST:PORT"; "*" allows any. Errors:
  // kInvalidArgument naming the entry.
  static absl::StatusOr<NotifyHosts> Of(const std::vector<std::string>& hosts);

  bool empty() const { return hosts_.empty(); }
  bool Allows(std::string_view url) const;
  // Checks `notify` of a study that has it. Errors: kFailedPrecondition naming the host, and what
  // an operator can do.
  absl::Status Check(const v1::StudySpec& study) const;

 private:
  std::set<std::string> hosts_;  // As HostOfUrl returns them.
};

}  // namespace parallax
