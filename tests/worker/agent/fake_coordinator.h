// A coordinator without a queue: hands out the leases that a test puts in, and keeps what workers
// say.
#pragma once

#include <condition_variable>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "common/base/version.h"
#include "common/rpc/endpoint.h"
#include "parallax/v1/service.grpc.pb.h"

namespace parallax {

// Thread-safe.
class FakeCoordinator final : public v1::Coordinator::Service {
 public:
  struct Seen {
    std::vector<v1::Hello> hellos;
    std::vector<v1::CompleteRequest> completes;
    std::vector<v1::FailRequest> fails;
    std::vector<v1::HandBack> hand_backs;
    std::vector<v1::Heartbeat> heartbeats;
    int leases_sent = 0;
    int credit_ahead = 0;  // Part of all credit for which no slot was free.
    int streams_open = 0;
  };
  struct Behaviour {
    std::string id = "database-1";
    int protocol = kWorkProtocol;
    double lease_s = 10;
    std::string store_uri;
    bool adopt = true;  // Every attempt that a worker says it holds.
    bool answer_heartbeats = true;
    bool hold_reports = false;  // Reports wait until this is false again.
    int drop_replies = 0;       // This many reports are taken and answered UNAVAILABLE.
    v1::ReportOutcome outcome = v1::REPORT_OUTCOME_OK;
    grpc::StatusCode report_status = grpc::StatusCode::OK;
    grpc::StatusCode hello_status = grpc::StatusCode::OK;
  };

  explicit FakeCoordinator(RpcAddress address) : address_(std::move(address)) {}
  ~FakeCoordinator() override { Stop(); }

  void Start();
  void Stop();  // Cuts all streams.

  void Change(const std::function<void(Behaviour&)>& edit);
  void Offer(v1::Lease lease);  // Sent as soon as there is credit.
  void SendStop(const v1::AttemptId& attempt);
  void SendAck(int64_t sequence);  // Answers a heartbeat that was left without answer.
  // Waits until `condition` holds. Returns false after 20 s.
  bool WaitFor(const std::function<bool(const Seen&)>& condition);
  Seen seen();

  grpc::Status Work(
      grpc::ServerContext* context,
      grpc::ServerReaderWriter<v1::CoordinatorMessage, v1::WorkerMessage>* stream) override;
  grpc::Status Complete(grpc::ServerContext*, const v1::CompleteRequest* request,
                        v1::ReportReply* reply) override;
  grpc::Status Fail(grpc::ServerContext*, const v1::FailRequest* request,
                    v1::ReportReply* reply) override;
  grpc::Status GetInfo(grpc::ServerContext*, const v1::GetInfoRequest*,
                       v1::GetInfoReply* reply) override;

 private:
  using WorkStream = grpc::ServerReaderWriter<v1::CoordinatorMessage, v1::WorkerMessage>;
  void SendLeases();                      // Requires mu_.
  grpc::Status Answer(v1::ReportReply*);  // Requires mu_.

  const RpcAddress address_;
  std::unique_ptr<RpcServer> server_;

  std::mutex mu_;
  std::condition_variable changed_;
  // Guarded by mu_.
  Behaviour behaviour_;
  Seen seen_;
  std::deque<v1::Lease> offers_;
  WorkStream* stream_ = nullptr;
  int credit_ = 0;
};

}  // namespace parallax
