// Decides who may steer a study: a submitter may steer the studies that it submitted, an operator
// all. Both the RPCs and the web page use it.
#pragma once

#include <string>

#include "common/base/ids.h"
#include "common/base/status.h"
#include "common/rpc/endpoint.h"

namespace parallax {

class JobQueue;

// Returns the caller as actors begin in the audit table: "submitter ada".
std::string ActorName(const RpcCaller& caller);

// Checks that the caller may pause, resume, cancel, retry and forget the study. Errors:
// kPermissionDenied if it may not; kNotFound for an unknown study; the queue's.
absl::Status CheckSteering(JobQueue& queue, const RpcCaller& caller, StudyId study);

// Checks that the caller may give a study this priority: submitters at most kMostOwnPriority.
// Errors: kPermissionDenied if it may not.
absl::Status CheckPriority(const RpcCaller& caller, int priority);

}  // namespace parallax
