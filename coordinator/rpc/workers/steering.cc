#include "coordinator/rpc/workers/steering.h"

#include "common/config/check/limits.h"
#include "coordinator/queue/job_queue.h"

namespace parallax {

std::string ActorName(const RpcCaller& caller) {
  return std::string(caller.role ? RoleName(*caller.role) : "nobody") + " " + caller.name;
}

absl::Status CheckSteering(JobQueue& queue, const RpcCaller& caller, StudyId study) {
  if (caller.Is(Role::kOperator)) return absl::OkStatus();
  ASSIGN_OR_RETURN(const std::string owner, queue.SubmitterOf(study));
  if (caller.Is(Role::kSubmitter) && owner.rfind(ActorName(caller) + " ", 0) == 0) {
    return absl::OkStatus();
  }
  return PermissionDenied(
      "study {} was not submitted by '{}'; others' studies are the operator's to steer",
      study.value, caller.name);
}

absl::Status CheckPriority(const RpcCaller& caller, int priority) {
  if (caller.Is(Role::kOperator) || priority <= kMostOwnPriority) return absl::OkStatus();
  return PermissionDenied(
      "priority {}: a submitter gives at most {}, more is the operator's to give", priority,
      kMostOwnPriority);
}

}  // namespace parallax
