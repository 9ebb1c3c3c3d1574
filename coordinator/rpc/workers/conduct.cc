#include "coordinator/rpc/workers/conduct.h"

#include <algorithm>

#include "common/base/seconds.h"

namespace parallax {
namespace {

constexpr int kFailuresThatSuspend = 5;  // In a row, while others succeed.
constexpr double kFirstSuspension_s = 30;
constexpr double kLongestSuspension_s = 3600;

}  // namespace

bool ConductBook::Reported(const std::string& worker, bool succeeded, SteadyTime now) {
  Conduct& conduct = conduct_[worker];
  if (succeeded) {
    conduct = Conduct();
    conduct.last_success = now;
    return false;
  }
  if (conduct.failures_in_row++ == 0) conduct.first_failure = now;
  const bool on_trial = conduct.suspension_s > 0;
  if (conduct.failures_in_row < kFailuresThatSuspend && !on_trial) return false;
  // If no worker succeeds, the work is to blame.
  const bool others_succeed = std::any_of(conduct_.begin(), conduct_.end(), [&](const auto& other) {
    return other.first != worker && other.second.last_success >= conduct.first_failure;
  });
  if (!others_succeed || now < conduct.suspended_until) return false;
  conduct.suspension_s =
      on_trial ? std::min(kLongestSuspension_s, 2 * conduct.suspension_s) : kFirstSuspension_s;
  conduct.suspended_until = SecondsAfter(now, conduct.suspension_s);
  return true;
}

double ConductBook::SuspendedFor(const std::string& worker, SteadyTime now) const {
  const auto found = conduct_.find(worker);
  return found == conduct_.end() ? 0 : SecondsBetween(now, found->second.suspended_until);
}

int ConductBook::TrustIn(const std::string& worker, int credit, int running, SteadyTime now) const {
  const auto found = conduct_.find(worker);
  if (found == conduct_.end() || found->second.suspension_s == 0) return credit;
  if (now < found->second.suspended_until || running > 0) return 0;
  return std::min(credit, 1);
}

}  // namespace parallax
