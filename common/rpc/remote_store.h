// The coordinator's store through `parallax.v1.Artifacts`, for machines that cannot reach the store
// itself. Files are durable in the store when Put returns; a file that is there already is not sent
// again.
//
// A worker may write only below its attempt's folder, while it holds the attempt; clients only
// read. Calls are not retried here (workers' jobs do: patient_store.h). Errors, beside those of
// Store: kUnavailable and kResourceExhausted are worth another try; kAborted means that the worker
// no longer holds the attempt.
#pragma once

#include <memory>
#include <string>

#include "common/store/store.h"
#include "parallax/v1/jobs.pb.h"

namespace grpc {
class Channel;
}

namespace parallax {

// The worker and attempt that write; both empty for clients, which only read.
struct RemoteStoreWriter {
  std::string worker;
  v1::AttemptId attempt;
};

// Returns a store that sends its calls over `channel`. Thread-safe.
std::unique_ptr<Store> MakeRemoteStore(std::shared_ptr<grpc::Channel> channel,
                                       RemoteStoreWriter writer);

}  // namespace parallax
