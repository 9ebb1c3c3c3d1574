#include "coordinator/rpc/coordinator_server.h"

#include <grpcpp/grpcpp.h>
#include <gtest/gtest.h>
#include <stdlib.h>

#include <filesystem>
#include <set>
#include <thread>

#include "common/base/status.h"
#include "common/rpc/endpoint.h"
#include "common/rpc/grpc_status.h"
#include "coordinator/http/http_server.h"
#include "coordinator/queue/job_queue.h"
#include "parallax/v1/service.grpc.pb.h"
#include "puppet.h"
#include "server_fixture.h"
#include "tests/coordinator/http/browser.h"

namespace parallax {
namespace {

TEST_F(CoordinatorServerTest, AStudyOfNoopJobsCompletes) {
  StartCoordinator();
  for (int i = 0; i < 4; ++i) StartAgent("worker-" + std::to_string(i), noop_, 2);
  const int64_t id = Submit(40, 4, {"narrow", "wide"});
  ASSERT_TRUE(WaitForState(id, v1::STUDY_STATE_SUCCEEDED));
  const v1::StudyStatus study = GetStudy(id);
  ASSERT_EQ(study.variants_size(), 2);
  std::set<std::string> seen;
  for (const v1::VariantStatus& variant : study.variants()) {
    EXPECT_EQ(variant.pairs_done(), 40) << variant.name();
  }
  for (const v1::PublishedFrame& frame : Frames(id)) {
    EXPECT_TRUE(fs::exists(dir_ + "/store/" + frame.frame().path() + "/left.png"));
    seen.insert(frame.variant() + "/" + std::to_string(frame.scene()) + "/" +
                std::to_string(frame.frame().rig()));
  }
  EXPECT_EQ(seen.size(), 80u) << "no pair twice, none missing";
  ExpectEveryInvariant();
  const ServerMetrics metrics = server_->Metrics();
  EXPECT_EQ(metrics.workers_connected, 4);
  EXPECT_EQ(metrics.slots, 8);
  EXPECT_GE(metrics.leases, 22);
  EXPECT_EQ(metrics.lease_latency_counts.back(), metrics.leases);
}

TEST_F(CoordinatorServerTest, ALostWorkersJobGoesToAnother) {
  StartCoordinator(/*lease_s=*/10, /*reconnect_grace_s=*/0.05);
  const int64_t id = Submit(2, 2, {"v"});
  Puppet puppet(*stub_);
  const v1::AttemptId first = puppet.FirstLease("doomed").attempt();
  puppet.Cut();
  StartAgent("heir", noop_);
  ASSERT_TRUE(WaitForState(id, v1::STUDY_STATE_SUCCEEDED));
  EXPECT_EQ(server_->Metrics().workers_lost, 1);

  // The zombie's report comes late.
  v1::CompleteRequest late;
  *late.mutable_attempt() = first;
  late.set_worker("doomed");
  EditSolve(late, [](auto& result) { result.mutable_rejected()->set_reason("late"); });
  grpc::ClientContext context;
  v1::ReportReply reply;
  ASSERT_TRUE(stub_->Complete(&context, late, &reply).ok());
  EXPECT_EQ(reply.outcome(), v1::REPORT_OUTCOME_STALE_FENCE);
  EXPECT_EQ(server_->Metrics().reports["STALE_FENCE"], 1);
  ExpectEveryInvariant();
}

TEST_F(CoordinatorServerTest, ASilentWorkerIsGivenUpAfterItsLease) {
  StartCoordinator(/*lease_s=*/0.5);
  const int64_t id = Submit(2, 2, {"v"});
  Puppet puppet(*stub_);
  puppet.FirstLease("mute");
  EXPECT_EQ(puppet.WaitForEnd().code(), absl::StatusCode::kCancelled) << "not our own deadline";
  EXPECT_EQ(server_->Metrics().workers_lost, 1);
  StartAgent("heir", noop_);
  EXPECT_TRUE(WaitForState(id, v1::STUDY_STATE_SUCCEEDED));
  ExpectEveryInvariant();
}

TEST_F(CoordinatorServerTest, HeartbeatsAreAnsweredAndKeepALease) {
  StartCoordinator(/*lease_s=*/0.5);
  Submit(2, 2, {"v"});
  Puppet puppet(*stub_);
  const v1::AttemptId mine = puppet.FirstLease("steady").attempt();
  v1::AttemptId foreign = mine;
  foreign.set_fence(mine.fence() + 1000);
  const auto until = std::chrono::steady_clock::now() + std::chrono::milliseconds(1500);
  v1::CoordinatorMessage message;
  for (int64_t sequence = 1; std::chrono::steady_clock::now() < until; ++sequence) {
    puppet.Heartbeat(sequence, {mine});
    ASSERT_TRUE(puppet.ReadUntil(v1::CoordinatorMessage::kHeartbeatAck, &message));
    EXPECT_EQ(message.heartbeat_ack().sequence(), sequence);
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  EXPECT_EQ(server_->Metrics().workers_lost, 0) << "three leases long";
  puppet.Heartbeat(1, {mine, foreign});
  ASSERT_TRUE(puppet.ReadUntil(v1::CoordinatorMessage::kStop, &message));
  EXPECT_EQ(message.stop().attempt().fence(), foreign.fence());
}

TEST_F(CoordinatorServerTest, AWorkerThatComesBackKeepsWhatItHolds) {
  StartCoordinator();
  Submit(2, 2, {"v"});
  v1::CoordinatorMessage message;
  v1::AttemptId mine;
  {
    Puppet puppet(*stub_);
    mine = puppet.FirstLease("w").attempt();
    puppet.Cut();
    EXPECT_EQ(puppet.WaitForEnd().code(), absl::StatusCode::kCancelled);
  }
  v1::AttemptId unknown = mine;
  unknown.set_fence(mine.fence() + 7);
  Puppet again(*stub_);
  again.Hello("w", {mine, unknown});
  ASSERT_TRUE(again.ReadUntil(v1::CoordinatorMessage::kWelcome, &message));
  ASSERT_EQ(message.welcome().adopted_size(), 1);
  EXPECT_EQ(message.welcome().adopted(0).fence(), mine.fence());
  EXPECT_EQ(message.welcome().lease_s(), 10);
  EXPECT_EQ(message.welcome().store_uri(), "file://" + dir_ + "/store");
}

TEST_F(CoordinatorServerTest, RunningWorkGoesOnThroughARestart) {
  StartCoordinator();
  StartAgent("w", gated_);
  const int64_t id = Submit(2, 2, {"v"});
  ASSERT_TRUE(gated_.WaitForStart());
  StopCoordinator();
  StartCoordinator();
  gated_.Release();
  ASSERT_TRUE(WaitForState(id, v1::STUDY_STATE_SUCCEEDED));
  EXPECT_EQ(gated_.started(), 1) << "not solved twice";
  ExpectEveryInvariant();
}

// Fails everything, but no faster than the coordinator takes notice: how many failures wait to be
// reported would depend on the machine's load otherwise.
class BrokenRunner final : public NoopRunner {
 public:
  // `noticed(n)`: may the failure that follows n earlier ones happen now?
  explicit BrokenRunner(std::function<bool(uint64_t)> noticed) : noticed_(std::move(noticed)) {}

  absl::StatusOr<v1::SolveResult> Solve(const v1::SolveJob&, const CancelToken& cancel,
                                        const JobProgressFn&) override {
    return Fail(cancel);
  }
  absl::StatusOr<v1::RenderResult> Render(const v1::RenderJob&, const AttemptFolder&,
                                          const CancelToken& cancel,
                                          const JobProgressFn&) override {
    return Fail(cancel);
  }

 private:
  absl::Status Fail(const CancelToken& cancel) {
    const uint64_t earlier = count_++;
    while (!noticed_(earlier) && !cancel.cancelled()) std::this_thread::yield();
    return Internal("this machine is broken");
  }

  const std::function<bool(uint64_t)> noticed_;
  std::atomic<uint64_t> count_ = 0;  // Two slots fail at once.
};

TEST_F(CoordinatorServerTest, AWorkerThatFailsEverythingWhileOthersSucceedIsSuspended) {
  StartCoordinator();
  NoopRunner good;
  StartAgent("good", good);
  const int64_t study = Submit(4000, 1, {"v"});
  const auto done = [&] {
    const auto status = queue_->GetStudy(StudyId{study});
    return status.ok() ? status->variants(0).pairs_done() : 0;
  };
  while (done() < 10) std::this_thread::yield();
  // Both slots may be one failure ahead; the fifth in a row comes after others have succeeded.
  const uint64_t two_slots = 2;
  std::atomic<int64_t> done_at_first = 0;
  BrokenRunner broken([&](uint64_t earlier) {
    if (earlier == 0) done_at_first = done();
    if (earlier >= 4 && done() <= done_at_first + 1) return false;
    return queue_->Stats().failures + two_slots > earlier;
  });
  StartAgent("broken", broken, 2);
  const auto state_of_broken = [this] {
    for (const v1::WorkerStatus& worker : server_->Workers()) {
      if (worker.name() == "broken") return worker.state();
    }
    return std::string();
  };
  while (state_of_broken() != "suspended") std::this_thread::yield();
  // Five in a row suspend it. What its two slots hold and await, and what it has yet to report, may
  // still fail, and no more.
  const int64_t at_suspension = done();
  while (done() < std::min<int64_t>(at_suspension + 300, 4000)) std::this_thread::yield();
  EXPECT_LE(queue_->Stats().failures, 12u);
  for (RunningAgent& agent : agents_) agent.Stop();  // They use what ends with this test.
}

TEST_F(CoordinatorServerTest, AHandedBackJobIsLeasedAgainAtOnce) {
  StartCoordinator();
  Submit(2, 2, {"v"});
  Puppet puppet(*stub_);
  const v1::AttemptId first = puppet.FirstLease("w", 2).attempt();
  puppet.HandBack(first);
  v1::CoordinatorMessage message;
  ASSERT_TRUE(puppet.ReadUntil(v1::CoordinatorMessage::kLease, &message));
  EXPECT_EQ(message.lease().attempt().job_id(), first.job_id());
  EXPECT_GT(message.lease().attempt().fence(), first.fence());
  EXPECT_TRUE(puppet.Finish().ok());
}

// ---- Operators' orders
class OrdersTest : public CoordinatorServerTest {
 protected:
  absl::StatusOr<std::vector<std::string>> Drain(const std::string& pattern, bool undo = false) {
    v1::DrainWorkersRequest request;
    request.set_pattern(pattern);
    request.set_undo(undo);
    request.set_reason("new disk");
    grpc::ClientContext context;
    v1::DrainWorkersReply reply;
    RETURN_IF_ERROR(FromGrpc(stub_->DrainWorkers(&context, request, &reply)));
    return std::vector<std::string>(reply.workers().begin(), reply.workers().end());
  }
  v1::ListWorkersReply Workers() {
    grpc::ClientContext context;
    SetRpcTimeout(context, std::chrono::seconds(20));
    v1::ListWorkersReply reply;
    const absl::Status status = FromGrpc(stub_->ListWorkers(&context, {}, &reply));
    EXPECT_TRUE(status.ok()) << status;
    return reply;
  }
  bool WaitForWorker(const std::string& state) {
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(20);
    while (std::chrono::steady_clock::now() < deadline) {
      const v1::ListWorkersReply reply = Workers();
      if (reply.workers_size() == 1 && reply.workers(0).state() == state) return true;
      std::this_thread::yield();
    }
    return false;
  }
};

TEST_F(OrdersTest, ADrainedWorkerFinishesWhatItHasAndGetsNothingNewUntilItIsUndone) {
  StartCoordinator();
  StartAgent("node17-1", gated_);
  const int64_t study = Submit(4, 2, {"v"});
  ASSERT_TRUE(gated_.WaitForStart());
  const auto named = Drain("node1?-*");
  ASSERT_TRUE(named.ok()) << named.status();
  EXPECT_EQ(*named, std::vector<std::string>{"node17-1"});
  EXPECT_TRUE(WaitForWorker("draining"));
  gated_.Release();
  EXPECT_TRUE(WaitForWorker("drained"));
  const uint64_t done = queue_->Stats().completions;
  EXPECT_GE(done, 1u) << "what it had";
  // One that is named by nothing gets all the rest.
  EXPECT_EQ(Workers().workers(0).drained_by(), "node1?-*");
  ASSERT_EQ(Workers().drains_size(), 1);
  EXPECT_EQ(Workers().drains(0).reason(), "new disk");
  StartAgent("node2", noop_);
  ASSERT_TRUE(WaitForState(study, v1::STUDY_STATE_SUCCEEDED));
  EXPECT_EQ(gated_.started(), 1);
  agents_[1].Stop();

  // The order outlives the coordinator.
  StopCoordinator();
  StartCoordinator();
  const int64_t second = Submit(2, 2, {"w"});
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  while (Workers().workers_size() == 0 && std::chrono::steady_clock::now() < deadline) {
    std::this_thread::yield();
  }
  ASSERT_EQ(Workers().workers(0).state(), "drained");
  EXPECT_EQ(queue_->Stats().leases_granted, 0u);
  ASSERT_TRUE(Drain("node1?-*", /*undo=*/true).ok());
  EXPECT_TRUE(WaitForState(second, v1::STUDY_STATE_SUCCEEDED));
  EXPECT_EQ(Workers().drains_size(), 0);
}

TEST_F(OrdersTest, PatternsThatNoNameCanMatchAreRefused) {
  StartCoordinator();
  for (const char* pattern : {"", "a b", "[ab]", "-x", "a/*", "a\\*"}) {
    EXPECT_EQ(Drain(pattern).status().code(), absl::StatusCode::kInvalidArgument) << pattern;
  }
  for (const char* pattern : {"*", "?", "node.1_a-*", "n*?"}) {
    EXPECT_TRUE(Drain(pattern).ok()) << pattern;
  }
  EXPECT_EQ(Drain("none", true).status().code(), absl::StatusCode::kNotFound);
}

TEST_F(OrdersTest, AStudyIsForgottenAndItsJobsWithIt) {
  StartCoordinator();
  StartAgent("w", noop_);
  const int64_t study = Submit(4, 2, {"v"});
  v1::StudyRequest request;
  request.set_study_id(study);
  v1::ForgetReply had;
  const auto forget = [&] {
    grpc::ClientContext context;
    return FromGrpc(stub_->Forget(&context, request, &had));
  };
  ASSERT_TRUE(WaitForState(study, v1::STUDY_STATE_SUCCEEDED));
  v1::ListJobsRequest list;
  list.set_study_id(study);
  v1::ListJobsReply jobs;
  grpc::ClientContext context;
  ASSERT_TRUE(stub_->ListJobs(&context, list, &jobs).ok());
  ASSERT_GT(jobs.jobs_size(), 0);
  const auto attempts_of = [&](int64_t job) -> absl::StatusOr<v1::ListAttemptsReply> {
    v1::ListAttemptsRequest ask;
    ask.set_job_id(job);
    grpc::ClientContext call;
    v1::ListAttemptsReply reply;
    RETURN_IF_ERROR(FromGrpc(stub_->ListAttempts(&call, ask, &reply)));
    return reply;
  };
  const auto attempts = attempts_of(jobs.jobs(0).job_id());
  ASSERT_TRUE(attempts.ok()) << attempts.status();
  EXPECT_EQ(attempts->attempts(0).ending(), "succeeded");
  EXPECT_EQ(attempts->attempts(0).worker(), "w");
  EXPECT_EQ(attempts_of(0).status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(attempts_of(9999).status().code(), absl::StatusCode::kNotFound);

  ASSERT_TRUE(forget().ok());
  EXPECT_EQ(had.pairs(), 4);
  EXPECT_EQ(forget().code(), absl::StatusCode::kNotFound);
  // The rows go in the background; a newer job lets the newest of them go.
  const int64_t next = Submit(2, 2, {"w"});
  ASSERT_TRUE(WaitForState(next, v1::STUDY_STATE_SUCCEEDED));
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  while (attempts_of(jobs.jobs(0).job_id()).ok() && std::chrono::steady_clock::now() < deadline) {
    std::this_thread::yield();
  }
  EXPECT_EQ(attempts_of(jobs.jobs(0).job_id()).status().code(), absl::StatusCode::kNotFound);
  ExpectEveryInvariant();
}

TEST_F(CoordinatorServerTest, CancelStopsWhatRuns) {
  StartCoordinator();
  StartAgent("w", gated_);
  const int64_t id = Submit(2, 2, {"v"});
  ASSERT_TRUE(gated_.WaitForStart());
  v1::StudyRequest request;
  request.set_study_id(id);
  request.set_reason("not wanted");
  grpc::ClientContext context;
  v1::StudyStatus study;
  const absl::Status status = FromGrpc(stub_->Cancel(&context, request, &study));
  ASSERT_TRUE(status.ok()) << status;
  EXPECT_EQ(study.state(), v1::STUDY_STATE_CANCELLED);
  EXPECT_TRUE(gated_.WaitForCancel());
  ExpectEveryInvariant();
}

TEST_F(CoordinatorServerTest, ASecondWorkerOfOneNameReplacesTheFirst) {
  StartCoordinator();
  Puppet first(*stub_);
  first.Hello("twin");
  v1::CoordinatorMessage message;
  ASSERT_TRUE(first.ReadUntil(v1::CoordinatorMessage::kWelcome, &message));
  Puppet second(*stub_);
  second.Hello("twin");
  EXPECT_EQ(first.WaitForEnd().code(), absl::StatusCode::kAlreadyExists);
  ASSERT_TRUE(second.ReadUntil(v1::CoordinatorMessage::kWelcome, &message));
  EXPECT_EQ(server_->Metrics().workers_connected, 1);
}

TEST_F(CoordinatorServerTest, AStreamThatSaysNoHelloIsEndedInTime) {
  options_.hello_s = 0.3;
  StartCoordinator();
  Puppet silent(*stub_), polite(*stub_);
  polite.Hello("w");
  EXPECT_EQ(silent.WaitForEnd(), DeadlineExceeded("no hello on this stream"));
  v1::CoordinatorMessage message;
  ASSERT_TRUE(polite.ReadUntil(v1::CoordinatorMessage::kWelcome, &message));
  EXPECT_EQ(server_->Metrics().workers_connected, 1) << "who said hello stays";
}

TEST_F(CoordinatorServerTest, AStreamThatDoesNotFollowTheContractEndsWithAReason) {
  StartCoordinator();
  {
    Puppet puppet(*stub_);
    puppet.Credit(1);
    const absl::Status status = puppet.WaitForEnd();
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument) << status;
    EXPECT_NE(status.ToString().find("hello"), std::string::npos) << status;
  }
  {
    Puppet puppet(*stub_);
    puppet.Hello("a/b");
    EXPECT_EQ(puppet.WaitForEnd().code(), absl::StatusCode::kInvalidArgument);
  }
  {
    Puppet puppet(*stub_);
    puppet.Hello("w");
    puppet.Credit(-5);
    EXPECT_EQ(puppet.WaitForEnd().code(), absl::StatusCode::kInvalidArgument);
  }
}

TEST_F(CoordinatorServerTest, AReportOfAnotherDatabaseIsStale) {
  StartCoordinator();
  Submit(2, 2, {"v"});
  Puppet puppet(*stub_);
  // The same job and fence, once of another database and once of this one.
  v1::FailRequest fail;
  *fail.mutable_attempt() = puppet.FirstLease("w").attempt();
  fail.set_worker("w");
  fail.set_fingerprint("x");
  const struct {
    std::string id;
    v1::ReportOutcome outcome;
  } cases[] = {{"another", v1::REPORT_OUTCOME_STALE_FENCE},
               {queue_->database_id(), v1::REPORT_OUTCOME_OK}};
  for (const auto& row : cases) {
    fail.set_coordinator_id(row.id);
    grpc::ClientContext context;
    v1::ReportReply reply;
    ASSERT_TRUE(stub_->Fail(&context, fail, &reply).ok());
    EXPECT_EQ(reply.outcome(), row.outcome) << row.id;
  }
}

TEST_F(CoordinatorServerTest, ErrorsOfTheQueueReachTheClient) {
  StartCoordinator();
  {
    grpc::ClientContext context;
    v1::GetStudyRequest request;
    request.set_study_id(4711);
    v1::StudyStatus study;
    const absl::Status status = FromGrpc(stub_->GetStudy(&context, request, &study));
    EXPECT_EQ(status.code(), absl::StatusCode::kNotFound);
    EXPECT_NE(status.ToString().find("4711"), std::string::npos) << status;
  }
  {
    grpc::ClientContext context;
    v1::SubmitReply reply;
    EXPECT_EQ(FromGrpc(stub_->Submit(&context, {}, &reply)).code(),
              absl::StatusCode::kInvalidArgument);
  }
}

TEST_F(CoordinatorServerTest, AnAddressInUseIsRefusedByName) {
  StartCoordinator();
  const auto second = CoordinatorServer::Start({.listen = {address_}}, *queue_);
  ASSERT_FALSE(second.ok());
  EXPECT_EQ(second.status().code(), absl::StatusCode::kAlreadyExists) << second.status();
  EXPECT_NE(second.status().ToString().find(address_), std::string::npos);
}

TEST_F(CoordinatorServerTest, HttpTellsHealthMetricsAndWorkers) {
  StartCoordinator();
  StartAgent("worker-7", noop_);
  const int64_t id = Submit(4, 2, {"v"});
  ASSERT_TRUE(WaitForState(id, v1::STUDY_STATE_SUCCEEDED));
  HttpServerOptions options;
  options.listen = "127.0.0.1:0";
  options.db_path = dir_ + "/queue.db";
  auto http = HttpServer::Start(options, *queue_, *server_);
  ASSERT_TRUE(http.ok()) << http.status();
  const Browser client("http://" + (*http)->address());
  const auto health = client.Get("/healthz");
  ASSERT_TRUE(health);
  EXPECT_EQ(health->status, 200);
  EXPECT_NE(health->body.find("\"status\":\"ok\""), std::string::npos) << health->body;
  const auto metrics = client.Get("/metrics");
  ASSERT_TRUE(metrics);
  EXPECT_NE(metrics->body.find("parallax_pairs_published{study=\"noop\",study_id=\"" +
                               std::to_string(id) + "\",variant=\"v\"} 4\n"),
            std::string::npos)
      << metrics->body;
  const auto workers = client.Get("/api/v1/workers");
  ASSERT_TRUE(workers);
  EXPECT_NE(workers->body.find("worker-7"), std::string::npos);
  EXPECT_EQ(client.Get("/")->status, 200);
  EXPECT_EQ(client.Get("/nothing")->status, 404);

  HttpServerOptions taken = options;
  taken.listen = (*http)->address();
  const auto second = HttpServer::Start(taken, *queue_, *server_);
  ASSERT_FALSE(second.ok());
  EXPECT_EQ(second.status().code(), absl::StatusCode::kAlreadyExists) << second.status();
  EXPECT_NE(second.status().ToString().find(taken.listen), std::string::npos);
  taken.listen = "0.0.0.0:0";
  EXPECT_EQ(HttpServer::Start(taken, *queue_, *server_).status().code(),
            absl::StatusCode::kFailedPrecondition);
}

}  // namespace
}  // namespace parallax
