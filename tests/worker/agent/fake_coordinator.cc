#include "fake_coordinator.h"

#include <grpcpp/grpcpp.h>
#include <gtest/gtest.h>

namespace parallax {

void FakeCoordinator::Start() {
  auto server = RpcServer::Start({address_}, {}, *this);
  ASSERT_TRUE(server.ok()) << server.status();
  server_ = *std::move(server);
}

void FakeCoordinator::Stop() { server_.reset(); }

void FakeCoordinator::Change(const std::function<void(Behaviour&)>& edit) {
  std::lock_guard lock(mu_);
  edit(behaviour_);
  changed_.notify_all();
}

void FakeCoordinator::Offer(v1::Lease lease) {
  std::lock_guard lock(mu_);
  offers_.push_back(std::move(lease));
  SendLeases();
}

void FakeCoordinator::SendStop(const v1::AttemptId& attempt) {
  std::lock_guard lock(mu_);
  ASSERT_NE(stream_, nullptr);
  v1::CoordinatorMessage message;
  *message.mutable_stop()->mutable_attempt() = attempt;
  stream_->Write(message);
}

void FakeCoordinator::SendAck(int64_t sequence) {
  std::lock_guard lock(mu_);
  v1::CoordinatorMessage ack;
  ack.mutable_heartbeat_ack()->set_sequence(sequence);
  if (stream_ != nullptr) stream_->Write(ack);
}

bool FakeCoordinator::WaitFor(const std::function<bool(const Seen&)>& condition) {
  std::unique_lock lock(mu_);
  return changed_.wait_for(lock, std::chrono::seconds(20), [&] { return condition(seen_); });
}

FakeCoordinator::Seen FakeCoordinator::seen() {
  std::lock_guard lock(mu_);
  return seen_;
}

void FakeCoordinator::SendLeases() {
  while (stream_ != nullptr && credit_ > 0 && !offers_.empty()) {
    v1::CoordinatorMessage message;
    *message.mutable_lease() = std::move(offers_.front());
    offers_.pop_front();
    --credit_;
    ++seen_.leases_sent;
    stream_->Write(message);
  }
  changed_.notify_all();
}

grpc::Status FakeCoordinator::Work(grpc::ServerContext*, WorkStream* stream) {
  v1::WorkerMessage message;
  if (!stream->Read(&message) || !message.has_hello()) {
    return grpc::Status(grpc::StatusCode::INVALID_ARGUMENT, "no hello");
  }
  {
    std::lock_guard lock(mu_);
    if (behaviour_.hello_status != grpc::StatusCode::OK) {
      return grpc::Status(behaviour_.hello_status, "go away");
    }
    v1::CoordinatorMessage welcome;
    welcome.mutable_welcome()->set_lease_s(behaviour_.lease_s);
    welcome.mutable_welcome()->set_store_uri(behaviour_.store_uri);
    welcome.mutable_welcome()->set_coordinator_id(behaviour_.id);
    if (behaviour_.adopt) {
      *welcome.mutable_welcome()->mutable_adopted() = message.hello().holding();
    }
    stream->Write(welcome);
    seen_.hellos.push_back(message.hello());
    ++seen_.streams_open;
    stream_ = stream;
    credit_ = 0;
    changed_.notify_all();
  }
  while (stream->Read(&message)) {
    std::lock_guard lock(mu_);
    if (message.has_credit()) {
      credit_ += message.credit().jobs();
      seen_.credit_ahead += message.credit().ahead();
      SendLeases();
    } else if (message.has_heartbeat()) {
      seen_.heartbeats.push_back(message.heartbeat());
      if (behaviour_.answer_heartbeats) {
        v1::CoordinatorMessage ack;
        ack.mutable_heartbeat_ack()->set_sequence(message.heartbeat().sequence());
        stream->Write(ack);
      }
    } else if (message.has_hand_back()) {
      seen_.hand_backs.push_back(message.hand_back());
    }
    changed_.notify_all();
  }
  std::lock_guard lock(mu_);
  --seen_.streams_open;
  if (stream_ == stream) stream_ = nullptr;
  changed_.notify_all();
  return grpc::Status::OK;
}

grpc::Status FakeCoordinator::Answer(v1::ReportReply* reply) {
  changed_.notify_all();
  if (behaviour_.drop_replies > 0) {
    --behaviour_.drop_replies;
    return grpc::Status(grpc::StatusCode::UNAVAILABLE, "reply dropped");
  }
  if (behaviour_.report_status != grpc::StatusCode::OK) {
    return grpc::Status(behaviour_.report_status, "report refused");
  }
  reply->set_outcome(behaviour_.outcome);
  return grpc::Status::OK;
}

grpc::Status FakeCoordinator::Complete(grpc::ServerContext*, const v1::CompleteRequest* request,
                                       v1::ReportReply* reply) {
  std::unique_lock lock(mu_);
  changed_.wait_for(lock, std::chrono::seconds(20), [this] { return !behaviour_.hold_reports; });
  seen_.completes.push_back(*request);
  return Answer(reply);
}

grpc::Status FakeCoordinator::Fail(grpc::ServerContext*, const v1::FailRequest* request,
                                   v1::ReportReply* reply) {
  std::lock_guard lock(mu_);
  seen_.fails.push_back(*request);
  return Answer(reply);
}

grpc::Status FakeCoordinator::GetInfo(grpc::ServerContext*, const v1::GetInfoRequest*,
                                      v1::GetInfoReply* reply) {
  std::lock_guard lock(mu_);
  reply->set_coordinator_id(behaviour_.id);
  reply->set_protocol(behaviour_.protocol);
  return grpc::Status::OK;
}

}  // namespace parallax
