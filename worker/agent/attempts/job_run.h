// The work of one attempt: runs its handler, sends the files and removes what is of no further use.
// Thread-safe as far as the handler is.
#pragma once

#include "common/base/cancel.h"
#include "common/base/status.h"
#include "parallax/v1/service.pb.h"
#include "worker/agent/attempts/job_handler.h"

namespace parallax {

// Runs the handler, and converts exceptions of libraries to errors. Sends the files to the store if
// the folder is a staging folder. Stores are patient (patient_store.h). `handler` is null if the
// worker has none for the lease's kind. Errors: the handler's and the store's; kUnimplemented
// without a handler; kOutOfRange for a result too large for a message; kResourceExhausted and
// kInternal for exceptions.
absl::StatusOr<JobOutcome> RunJob(JobHandler* handler, const v1::Lease& lease,
                                  const AttemptFolder& given, const CancelToken& cancel,
                                  const JobProgressFn& progress);

// Removes files without further use: working files, staged files, and the output of an attempt that
// will not be published (a full disk is one reason why attempts fail). `kept`: the attempt's result
// is reported. `handler` may be null.
void CleanUpAfter(const JobHandler* handler, const AttemptFolder& folder, bool kept);

}  // namespace parallax
