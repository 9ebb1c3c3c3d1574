// Calls of a service whose bodies block: they run on a pool's threads, and the service can wait
// until none is in progress. Also who may act on what a caller has begun.
//
// Thread-safe.
#pragma once

#include <grpcpp/grpcpp.h>

#include <condition_variable>
#include <functional>
#include <mutex>
#include <string>

#include "common/base/status.h"
#include "common/rpc/endpoint.h"
#include "coordinator/rpc/task_pool.h"

namespace parallax {

class PooledCalls {
 public:
  // `pool` must outlive the calls.
  explicit PooledCalls(TaskPool& pool) : pool_(pool) {}

  using Context = grpc::CallbackServerContext;
  using Reactor = grpc::ServerUnaryReactor;
  // Runs the body of a call on the pool; its status ends the call.
  Reactor* Run(Context* context, std::function<absl::Status()> body);

  // Note that a call has begun and ended, for those that Run does not run.
  void Begin();
  void End();
  // Waits until no call is in progress.
  void Wait();

 private:
  TaskPool& pool_;
  std::mutex mu_;
  std::condition_variable ended_;
  int calls_ = 0;  // Guarded by mu_.
};

// Checks that the caller is the submitter `opened_by` (an actor of the audit table), or an
// operator. `what`: "stream 'drive'"; `deeds`: "to take pairs from and to close". Errors:
// kPermissionDenied.
absl::Status CheckOpener(const RpcCaller& caller, const std::string& opened_by,
                         const std::string& what, const std::string& deeds);

}  // namespace parallax
