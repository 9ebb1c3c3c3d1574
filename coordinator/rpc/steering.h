// Whose study it is: a submitter steers what it submitted, an operator steers all. The RPCs and the
// web page ask the same question here.
#pragma once

#include <string>

#include "common/base/ids.h"
#include "common/base/status.h"
#include "common/rpc/endpoint.h"

namespace parallax {

class JobQueue;

// As actors begin in the audit table: "submitter ada".
std::string ActorName(const RpcCaller& caller);

// Errors: kPermissionDenied unless the caller may pause, resume, cancel, retry and forget the
// study; kNotFound for a study that there is not; the queue's.
absl::Status CheckSteering(JobQueue& queue, const RpcCaller& caller, StudyId study);

}  // namespace parallax
