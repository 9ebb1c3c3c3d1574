#include "coordinator/rpc/pooled_calls.h"

#include "common/rpc/grpc_status.h"
#include "coordinator/rpc/workers/steering.h"

namespace parallax {

void PooledCalls::Begin() {
  std::lock_guard lock(mu_);
  ++calls_;
}

void PooledCalls::End() {
  std::lock_guard lock(mu_);
  --calls_;
  ended_.notify_all();
}

void PooledCalls::Wait() {
  std::unique_lock lock(mu_);
  ended_.wait(lock, [this] { return calls_ == 0; });
}

PooledCalls::Reactor* PooledCalls::Run(Context* context, std::function<absl::Status()> body) {
  Reactor* const reactor = context->DefaultReactor();
  Begin();
  pool_.Run([this, reactor, body = std::move(body)] {
    reactor->Finish(ToGrpc(body()));
    End();
  });
  return reactor;
}

absl::Status CheckOpener(const RpcCaller& caller, const std::string& opened_by,
                         const std::string& what, const std::string& deeds) {
  if (caller.Is(Role::kOperator)) return absl::OkStatus();
  if (caller.Is(Role::kSubmitter) && opened_by.rfind(ActorName(caller) + " ", 0) == 0) {
    return absl::OkStatus();
  }
  return PermissionDenied("{} was not begun by '{}'; others' are the operator's {}", what,
                          caller.name, deeds);
}

}  // namespace parallax
