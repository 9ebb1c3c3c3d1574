// Makes the first call of a test's process.
#pragma once

#include <grpcpp/grpcpp.h>

#include "parallax/v1/service.grpc.pb.h"

namespace parallax {

// Asks the coordinator who it is, and drops the answer. The first call of a process sets up gRPC;
// ThreadSanitizer also reads the debug lines of the program then, which takes a second. Tests with
// shorter leases and waits pay for both here.
inline void MakeFirstCall(v1::Coordinator::Stub& coordinator) {
  grpc::ClientContext context;
  v1::GetInfoReply info;
  coordinator.GetInfo(&context, v1::GetInfoRequest(), &info);
}

}  // namespace parallax
