#include "worker/agent/health.h"

#include <grpc/support/time.h>
#include <grpcpp/generic/async_generic_service.h>
#include <grpcpp/grpcpp.h>
#include <grpcpp/health_check_service_interface.h>

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <thread>
#include <utility>

#include "common/rpc/address.h"

namespace parallax {
namespace {

// The loop runs at least every few seconds; a store that is slow to answer may delay it.
constexpr double kAlive_s = 120;
constexpr std::chrono::milliseconds kAskEvery{500};

class HealthServerImpl final : public HealthServer {
 public:
  HealthServerImpl(std::unique_ptr<grpc::CallbackGenericService> others,
                   std::unique_ptr<grpc::Server> server, int port,
                   std::function<WorkerHealth()> ask)
      : others_(std::move(others)), server_(std::move(server)), port_(port), ask_(std::move(ask)) {
    Tell();
    asker_ = std::thread([this] {
      std::unique_lock lock(mu_);
      while (!end_.wait_for(lock, kAskEvery, [this] { return ended_; })) Tell();
    });
  }

  ~HealthServerImpl() override {
    {
      std::lock_guard lock(mu_);
      ended_ = true;
    }
    end_.notify_all();
    asker_.join();
    server_->Shutdown(gpr_inf_past(GPR_CLOCK_MONOTONIC));
  }

  int port() const override { return port_; }

 private:
  void Tell() {
    const WorkerHealth health = ask_();
    const bool alive = health.since_look_s < kAlive_s;
    grpc::HealthCheckServiceInterface* service = server_->GetHealthCheckService();
    service->SetServingStatus(alive);
    service->SetServingStatus("alive", alive);
    service->SetServingStatus("ready", alive && health.ready);
  }

  const std::unique_ptr<grpc::CallbackGenericService> others_;
  const std::unique_ptr<grpc::Server> server_;
  const int port_;
  const std::function<WorkerHealth()> ask_;
  std::mutex mu_;
  std::condition_variable end_;
  bool ended_ = false;  // Guarded by mu_.
  std::thread asker_;
};

}  // namespace

absl::StatusOr<std::unique_ptr<HealthServer>> HealthServer::Start(
    const std::string& address, std::function<WorkerHealth()> ask) {
  ASSIGN_OR_RETURN(const RpcAddress where, ParseRpcAddress(address));
  grpc::EnableDefaultHealthCheckService(true);
  grpc::ServerBuilder builder;
  builder.AddChannelArgument(GRPC_ARG_ALLOW_REUSEPORT, 0);
  // gRPC starts no server with the health service alone, so this service refuses everything else.
  auto others = std::make_unique<grpc::CallbackGenericService>();
  builder.RegisterCallbackGenericService(others.get());
  int port = 0;
  builder.AddListeningPort(where.ToString(), grpc::InsecureServerCredentials(), &port);
  std::unique_ptr<grpc::Server> server = builder.BuildAndStart();
  if (server == nullptr) {
    return Unavailable("can't listen on {} for probes", address);
  }
  return std::make_unique<HealthServerImpl>(std::move(others), std::move(server), port,
                                            std::move(ask));
}

}  // namespace parallax
