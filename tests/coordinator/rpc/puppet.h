#pragma once

#include <grpcpp/grpcpp.h>

#include <memory>
#include <string>
#include <vector>

#include "common/base/version.h"
#include "common/rpc/endpoint.h"
#include "common/rpc/grpc_status.h"
#include "parallax/v1/service.grpc.pb.h"

namespace parallax {

// A worker by hand: one stream whose every message the test writes and reads.
class Puppet {
 public:
  explicit Puppet(v1::Coordinator::Stub& coordinator) {
    SetRpcTimeout(context_, std::chrono::seconds(30));
    stream_ = coordinator.Work(&context_);
  }

  void Hello(const std::string& name, const std::vector<v1::AttemptId>& holding = {},
             const std::vector<std::string>& kinds = {"solve", "render"}) {
    v1::WorkerMessage message;
    v1::Hello& hello = *message.mutable_hello();
    hello.set_name(name);
    hello.set_protocol(kWorkProtocol);
    for (const std::string& kind : kinds) hello.add_kinds(kind);
    hello.set_slots(1);
    for (const v1::AttemptId& attempt : holding) *hello.add_holding() = attempt;
    stream_->Write(message);
  }
  void Credit(int jobs) {
    v1::WorkerMessage message;
    message.mutable_credit()->set_jobs(jobs);
    stream_->Write(message);
  }
  void Heartbeat(int64_t sequence, const std::vector<v1::AttemptId>& running) {
    v1::WorkerMessage message;
    message.mutable_heartbeat()->set_sequence(sequence);
    for (const v1::AttemptId& attempt : running) {
      *message.mutable_heartbeat()->add_running()->mutable_attempt() = attempt;
    }
    stream_->Write(message);
  }
  void HandBack(const v1::AttemptId& attempt) {
    v1::WorkerMessage message;
    *message.mutable_hand_back()->mutable_attempt() = attempt;
    stream_->Write(message);
  }
  // The next message of this kind; others are skipped. False when the stream ends first.
  bool ReadUntil(v1::CoordinatorMessage::MessageCase kind, v1::CoordinatorMessage* message) {
    while (stream_->Read(message)) {
      if (message->message_case() == kind) return true;
    }
    return false;
  }
  // Says hello, asks for `jobs` and returns the first lease.
  v1::Lease FirstLease(const std::string& name, int jobs = 1) {
    Hello(name);
    Credit(jobs);
    v1::CoordinatorMessage message;
    EXPECT_TRUE(ReadUntil(v1::CoordinatorMessage::kLease, &message));
    return message.lease();
  }
  void Cut() { context_.TryCancel(); }
  absl::Status Finish() {
    stream_->WritesDone();
    v1::CoordinatorMessage message;
    while (stream_->Read(&message)) {
    }
    return FromGrpc(stream_->Finish());
  }
  // Waits for the coordinator to end the stream by itself; the status that it ends with.
  absl::Status WaitForEnd() {
    v1::CoordinatorMessage message;
    while (stream_->Read(&message)) {
    }
    return FromGrpc(stream_->Finish());
  }

 private:
  grpc::ClientContext context_;
  std::unique_ptr<grpc::ClientReaderWriter<v1::WorkerMessage, v1::CoordinatorMessage>> stream_;
};

}  // namespace parallax
