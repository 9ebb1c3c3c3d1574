#include "simulated_farm.h"

#include <grpcpp/grpcpp.h>

#include <condition_variable>
#include <deque>
#include <map>
#include <mutex>
#include <thread>

#include "common/base/version.h"
#include "common/rpc/grpc_status.h"
#include "no_op.h"
#include "parallax/v1/service.grpc.pb.h"
#include "tests/job_messages.h"
#include "worker/agent/session/work_session.h"

namespace parallax {
namespace {

constexpr double kBeat_s = 10;
constexpr double kReportTimeout_s = 60;

}  // namespace

class SimulatedFarm::Worker {
 public:
  Worker(const FarmOptions& options, int number, std::atomic<bool>& asking, FarmTally& tally)
      : name_(options.name + "-" + std::to_string(number)),
        slots_(options.slots),
        asking_(asking),
        tally_(tally) {
    grpc::ChannelArguments arguments;
    arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);  // A connection of its own.
    stub_ = v1::Coordinator::NewStub(
        grpc::CreateCustomChannel(options.address, grpc::InsecureChannelCredentials(), arguments));
    session_ = WorkSession::Open(
        *stub_, {[this](v1::CoordinatorMessage message) { OnMessage(message); },
                 [this](const absl::Status& end) { tally_.broken += end.ok() ? 0 : 1; }});
    v1::WorkerMessage message;
    v1::Hello& hello = *message.mutable_hello();
    hello.set_name(name_);
    hello.set_protocol(kWorkProtocol);
    hello.add_kinds("solve");
    hello.add_kinds("render");
    hello.set_slots(slots_);
    hello.set_memory_mb(1024);
    session_->Send(std::move(message));
  }

  ~Worker() {
    session_->Cancel();
    {
      std::unique_lock lock(mutex_);
      none_open_.wait(lock, [this] { return calls_.empty(); });
      tally_.lease_ms.Add(lease_ms_);
      tally_.report_ms.Add(report_ms_);
    }
    session_.reset();
  }

  void Beat() {
    v1::WorkerMessage message;
    v1::Heartbeat& heartbeat = *message.mutable_heartbeat();
    {
      const std::lock_guard lock(mutex_);
      for (const auto& [call, owned] : calls_) {
        *heartbeat.add_running()->mutable_attempt() = call->request.attempt();
      }
      heartbeat.set_sequence(++beats_);
    }
    session_->Send(std::move(message));
  }

 private:
  struct Call {
    grpc::ClientContext context;
    v1::CompleteRequest request;
    v1::ReportReply reply;
    BenchClock::time_point begin;
    int pairs = 0;  // Pairs that it publishes.
  };

  void OnMessage(const v1::CoordinatorMessage& message) {
    if (message.has_welcome()) {
      for (int i = 0; i < slots_; ++i) Ask();
    } else if (message.has_lease()) {
      OnLease(message.lease());
    }
  }

  void Ask() {
    if (!asking_) return;
    {
      const std::lock_guard lock(mutex_);
      asked_.push_back(BenchClock::now());
    }
    v1::WorkerMessage message;
    message.mutable_credit()->set_jobs(1);
    session_->Send(std::move(message));
  }

  void OnLease(const v1::Lease& lease) {
    ++tally_.leases;
    auto owned = std::make_unique<Call>();
    Call* call = owned.get();
    call->request = NoOpAnswer(lease, name_);
    if (lease.kind() == "render") call->pairs = RenderOf(lease).rigs_size();
    call->begin = BenchClock::now();
    call->context.set_deadline(std::chrono::system_clock::now() +
                               std::chrono::duration_cast<std::chrono::system_clock::duration>(
                                   std::chrono::duration<double>(kReportTimeout_s)));
    {
      const std::lock_guard lock(mutex_);
      if (!asked_.empty()) {
        lease_ms_.push_back(1000 * SecondsSince(asked_.front()));
        asked_.pop_front();
      }
      calls_.emplace(call, std::move(owned));
    }
    stub_->async()->Complete(
        &call->context, &call->request, &call->reply,
        [this, call](const grpc::Status& status) { OnAnswer(call, status.ok()); });
  }

  void OnAnswer(Call* call, bool answered) {
    if (!answered) {
      ++tally_.broken;
    } else if (call->reply.outcome() == v1::REPORT_OUTCOME_OK) {
      ++tally_.completions;
      tally_.pairs += call->pairs;
    } else {
      ++tally_.refused;
    }
    if (answered) Ask();
    const std::lock_guard lock(mutex_);
    report_ms_.push_back(1000 * SecondsSince(call->begin));
    calls_.erase(call);
    if (calls_.empty()) none_open_.notify_all();
  }

  const std::string name_;
  const int slots_;
  std::atomic<bool>& asking_;
  FarmTally& tally_;
  std::unique_ptr<v1::Coordinator::Stub> stub_;
  std::unique_ptr<WorkSession> session_;

  std::mutex mutex_;
  std::condition_variable none_open_;
  // Guarded by mutex_.
  std::map<Call*, std::unique_ptr<Call>> calls_;
  std::deque<BenchClock::time_point> asked_;
  std::vector<double> lease_ms_, report_ms_;
  int64_t beats_ = 0;
};

class SimulatedFarm::Timer {
 public:
  explicit Timer(SimulatedFarm& farm) : thread_([this, &farm] { Loop(farm); }) {}
  ~Timer() {
    {
      const std::lock_guard lock(mutex_);
      stopping_ = true;
    }
    stop_.notify_all();
    thread_.join();
  }

 private:
  void Loop(SimulatedFarm& farm) {
    std::unique_lock lock(mutex_);
    while (!stop_.wait_for(lock, std::chrono::duration<double>(kBeat_s),
                           [this] { return stopping_; })) {
      farm.Beat();
    }
  }
  std::mutex mutex_;
  std::condition_variable stop_;
  bool stopping_ = false;  // Guarded by mutex_.
  std::thread thread_;
};

SimulatedFarm::SimulatedFarm() = default;

absl::StatusOr<std::unique_ptr<SimulatedFarm>> SimulatedFarm::Start(const FarmOptions& options,
                                                                    FarmTally& tally) {
  std::unique_ptr<SimulatedFarm> farm(new SimulatedFarm());
  for (int i = 0; i < options.workers; ++i) {
    farm->workers_.push_back(std::make_unique<Worker>(options, i, farm->asking_, tally));
  }
  farm->timer_ = std::make_unique<Timer>(*farm);
  return farm;
}

SimulatedFarm::~SimulatedFarm() {
  asking_ = false;
  timer_.reset();
  workers_.clear();
}

void SimulatedFarm::StopAsking() { asking_ = false; }

void SimulatedFarm::Beat() {
  for (const auto& worker : workers_) worker->Beat();
}

}  // namespace parallax
