// A coordinator on a Unix socket, its clients, and agents with jobs that do no work.
#pragma once

#include <grpcpp/grpcpp.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "common/rpc/endpoint.h"
#include "common/rpc/grpc_status.h"
#include "coordinator/queue/job_queue.h"
#include "coordinator/rpc/coordinator_server.h"
#include "parallax/v1/service.grpc.pb.h"
#include "tests/first_call.h"
#include "tests/folder_test.h"
#include "tests/job_messages.h"
#include "tests/worker/agent/gated_runner.h"
#include "worker/agent/agent.h"

namespace parallax {

namespace fs = std::filesystem;

struct RunningAgent {
  std::unique_ptr<Agent> agent;
  std::thread thread;

  void Stop() {
    if (agent == nullptr) return;
    agent->HandBack();
    thread.join();
    agent.reset();
  }
};

class CoordinatorServerTest : public FolderTest {
 protected:
  CoordinatorServerTest() {
    address_ = "unix:" + dir_ + "/coordinator.sock";
    stub_ = v1::Coordinator::NewStub(*ConnectRpc(*ParseRpcAddress(address_), {}));
  }
  ~CoordinatorServerTest() override {
    for (RunningAgent& agent : agents_) agent.Stop();
    StopCoordinator();
  }

  void StartCoordinator(double lease_s = 10, double reconnect_grace_s = 10) {
    JobQueueOptions queue;
    queue.db_path = dir_ + "/queue.db";
    queue.lease_s = lease_s;
    queue.kinds = kinds_;
    auto opened = JobQueue::Open(queue);
    ASSERT_TRUE(opened.ok()) << opened.status();
    queue_ = *std::move(opened);
    options_.listen = {address_};
    options_.store_uri = "file://" + dir_ + "/store";
    options_.reconnect_grace_s = reconnect_grace_s;
    auto server = CoordinatorServer::Start(options_, *queue_);
    ASSERT_TRUE(server.ok()) << server.status();
    server_ = *std::move(server);
    MakeFirstCall(*stub_);
  }
  void StopCoordinator() {
    server_.reset();
    queue_.reset();
  }

  void StartAgent(const std::string& name, TestRunner& runner, int slots = 1) {
    StartAgent(name, HandlersOf(runner), slots);
  }
  // Takes all kinds that it has handlers for.
  void StartAgent(const std::string& name, JobHandlers handlers, int slots) {
    AgentOptions options;
    options.coordinator = *ParseRpcAddress(address_);
    options.name = name;
    for (const auto& handler : handlers) options.kinds.push_back(handler->kind());
    options.slots = slots;
    options.outbox_root = dir_ + "/outbox";
    options.backoff_base_s = 0.01;
    options.backoff_cap_s = 0.05;
    options.hand_back_s = 0.2;
    handlers_.push_back(std::make_unique<JobHandlers>(std::move(handlers)));
    auto agent = Agent::Create(options, *handlers_.back(), Clock::System());
    ASSERT_TRUE(agent.ok()) << agent.status();
    agents_.push_back({*std::move(agent), {}});
    Agent* const raw = agents_.back().agent.get();
    agents_.back().thread = std::thread([raw] { EXPECT_TRUE(raw->Run().ok()); });
  }

  int64_t Submit(int64_t pairs, int rigs_per_scene, const std::vector<std::string>& variants) {
    v1::SubmitRequest request;
    v1::StudySpec& study = *request.mutable_study();
    study.set_name("noop");
    study.set_seed(7);
    study.set_pairs(pairs);
    study.set_rigs_per_scene(rigs_per_scene);
    for (const std::string& name : variants) {
      v1::VariantSpec& variant = *study.add_variants();
      variant.set_name(name);
      variant.mutable_config()->set_type(v1::SCENE_TYPE_INDOOR);
      variant.mutable_config()->mutable_rigs()->set_count(rigs_per_scene);
      // Variants differ, or they would share all results.
      variant.mutable_config()->mutable_rigs()->mutable_baseline_m()->set_constant(
          0.1 + 0.1 * study.variants_size());
    }
    grpc::ClientContext context;
    SetRpcTimeout(context, std::chrono::seconds(20));
    v1::SubmitReply reply;
    const absl::Status status = FromGrpc(stub_->Submit(&context, request, &reply));
    EXPECT_TRUE(status.ok()) << status;
    return reply.study_id();
  }

  v1::StudyStatus GetStudy(int64_t id) {
    grpc::ClientContext context;
    SetRpcTimeout(context, std::chrono::seconds(20));
    v1::GetStudyRequest request;
    request.set_study_id(id);
    v1::StudyStatus study;
    const absl::Status status = FromGrpc(stub_->GetStudy(&context, request, &study));
    EXPECT_TRUE(status.ok()) << status;
    return study;
  }

  // Asks again and again: the contract has no other way to learn of the end.
  bool WaitForState(int64_t id, v1::StudyState state) {
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(25);
    while (std::chrono::steady_clock::now() < deadline) {
      if (GetStudy(id).state() == state) return true;
      std::this_thread::yield();
    }
    return false;
  }

  std::vector<v1::PublishedFrame> Frames(int64_t id) {
    grpc::ClientContext context;
    SetRpcTimeout(context, std::chrono::seconds(20));
    v1::ListFramesRequest request;
    request.set_study_id(id);
    v1::ListFramesReply reply;
    const absl::Status status = FromGrpc(stub_->ListFrames(&context, request, &reply));
    EXPECT_TRUE(status.ok()) << status;
    return {reply.frames().begin(), reply.frames().end()};
  }

  void ExpectEveryInvariant() {
    const auto problems = queue_->Check();
    ASSERT_TRUE(problems.ok()) << problems.status();
    for (const std::string& problem : *problems) ADD_FAILURE() << problem;
  }

  std::string address_;
  CoordinatorServerOptions options_;
  const KindRegistry* kinds_ = &KindRegistry::Builtin();
  std::unique_ptr<JobQueue> queue_;
  std::unique_ptr<CoordinatorServer> server_;
  std::unique_ptr<v1::Coordinator::Stub> stub_;
  NoopRunner noop_;
  GatedRunner gated_;  // Outlive the agents, as do the handlers.
  std::vector<std::unique_ptr<JobHandlers>> handlers_;
  std::vector<RunningAgent> agents_;
};

}  // namespace parallax
