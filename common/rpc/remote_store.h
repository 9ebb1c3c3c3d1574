// The coordinator's store through `parallax.v1.Artifacts`, for who does not see it. What is put is
// durable in the store when Put returns; a file that is there already is not sent again.
//
// A worker writes below its attempt's folder only, while it holds the attempt; clients only read.
// No call retries: kUnavailable and kResourceExhausted are worth another try, kAborted says that
// the attempt is lost.
#pragma once

#include <memory>
#include <string>

#include "common/store/store.h"
#include "parallax/v1/jobs.pb.h"

namespace grpc {
class Channel;
}

namespace parallax {

struct RemoteStoreWriter {
  std::string worker;
  v1::AttemptId attempt;
};

// Thread-safe.
std::unique_ptr<Store> MakeRemoteStore(std::shared_ptr<grpc::Channel> channel,
                                       RemoteStoreWriter writer);

}  // namespace parallax
