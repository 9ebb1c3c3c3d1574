#include "coordinator/rpc/workers/steering.h"

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

}  // namespace parallax
