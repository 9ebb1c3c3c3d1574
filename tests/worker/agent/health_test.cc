// Answers that a probe gets over gRPC's health protocol.
#include "worker/agent/health.h"

#include <grpcpp/generic/generic_stub.h>
#include <grpcpp/grpcpp.h>
#include <gtest/gtest.h>

#include <chrono>
#include <thread>

#include "agent_fixture.h"

namespace parallax {
namespace {

enum Serving { kServing = 1, kNotServing = 2 };

// One question as grpc.health.v1 puts it on the wire: HealthCheckRequest{1: service},
// HealthCheckResponse{1: status}. -1: no answer; that of a service nobody has heard of, too.
int Probe(int port, const std::string& service) {
  const auto channel =
      grpc::CreateChannel("127.0.0.1:" + std::to_string(port), grpc::InsecureChannelCredentials());
  grpc::GenericStub stub(channel);
  std::string request;
  if (!service.empty()) request = std::string("\x0a") + static_cast<char>(service.size()) + service;
  const grpc::Slice slice(request);
  const grpc::ByteBuffer question(&slice, 1);
  grpc::ClientContext context;
  context.set_deadline(std::chrono::system_clock::now() + std::chrono::seconds(10));
  grpc::CompletionQueue queue;
  const auto call =
      stub.PrepareUnaryCall(&context, "/grpc.health.v1.Health/Check", question, &queue);
  call->StartCall();
  grpc::ByteBuffer answer;
  grpc::Status status;
  call->Finish(&answer, &status, nullptr);
  void* tag = nullptr;
  bool ok = false;
  queue.Next(&tag, &ok);
  if (!status.ok()) return -1;
  std::vector<grpc::Slice> parts;
  if (!answer.Dump(&parts).ok()) return -1;
  std::string bytes;
  for (const grpc::Slice& part : parts) {
    bytes.append(reinterpret_cast<const char*>(part.begin()), part.size());
  }
  return bytes.size() == 2 && bytes[0] == 8 ? bytes[1] : 0;
}

int ProbeUntil(int port, const std::string& service, int wanted) {
  int seen = -1;
  for (int i = 0; i < 200 && seen != wanted; ++i) {
    seen = Probe(port, service);
    if (seen != wanted) std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  return seen;
}

TEST(HealthTest, ALoopThatStandsStillIsNotAlive) {
  std::atomic<double> since_look_s = 0;
  const auto server = HealthServer::Start("127.0.0.1:0", [&] {
    return WorkerHealth{since_look_s, true};
  });
  ASSERT_TRUE(server.ok()) << server.status();
  EXPECT_EQ(Probe((*server)->port(), "alive"), kServing);
  EXPECT_EQ(Probe((*server)->port(), ""), kServing);
  EXPECT_EQ(Probe((*server)->port(), "ready"), kServing);
  EXPECT_EQ(Probe((*server)->port(), "nothing"), -1);
  since_look_s = 1000;
  EXPECT_EQ(ProbeUntil((*server)->port(), "alive", kNotServing), kNotServing);
  EXPECT_EQ(ProbeUntil((*server)->port(), "ready", kNotServing), kNotServing);
}

TEST(HealthTest, ABadAddressAndATakenPortAreErrors) {
  const auto ask = [] { return WorkerHealth{}; };
  EXPECT_EQ(HealthServer::Start("nowhere", ask).status().code(),
            absl::StatusCode::kInvalidArgument);
  const auto first = HealthServer::Start("127.0.0.1:0", ask);
  ASSERT_TRUE(first.ok()) << first.status();
  const auto second = HealthServer::Start("127.0.0.1:" + std::to_string((*first)->port()), ask);
  EXPECT_EQ(second.status().code(), absl::StatusCode::kUnavailable);
}

using HealthOfAgentTest = AgentTest;

TEST_F(HealthOfAgentTest, AWorkerIsReadyBetweenWelcomeAndDrain) {
  runner_.Hold(1, started_, finish_, cancelled_);
  StartAgent();
  const auto server = HealthServer::Start("127.0.0.1:0", [this] { return agent_->Health(); });
  ASSERT_TRUE(server.ok()) << server.status();
  EXPECT_EQ(ProbeUntil((*server)->port(), "ready", kServing), kServing);
  coordinator_.Offer(SolveLease(1, 11, 1));
  ASSERT_TRUE(started_.Wait());
  agent_->Drain();
  EXPECT_EQ(ProbeUntil((*server)->port(), "ready", kNotServing), kNotServing);
  EXPECT_EQ(Probe((*server)->port(), "alive"), kServing);
  finish_.Open();
  JoinAgent();
}

}  // namespace
}  // namespace parallax
