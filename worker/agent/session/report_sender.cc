#include "worker/agent/session/report_sender.h"

#include <grpcpp/grpcpp.h>

#include <condition_variable>
#include <mutex>
#include <thread>

#include "common/base/system/log.h"
#include "common/rpc/endpoint.h"
#include "common/rpc/grpc_status.h"

namespace parallax {
namespace {

using Seconds = std::chrono::duration<double>;

}  // namespace

class ReportSender::Impl {
 public:
  Impl(const ReportSenderOptions& options, Outbox& outbox,
       v1::Coordinator::StubInterface& coordinator, Clock& clock, Rng rng,
       std::function<void()> on_change)
      : options_(options),
        outbox_(outbox),
        coordinator_(coordinator),
        clock_(clock),
        on_change_(std::move(on_change)),
        queue_(options, clock, std::move(rng)) {
    for (Report& report : outbox_.TakeLeftovers()) {
      LogInfo("report left from an earlier run",
              {{"job", report.attempt().job_id()}, {"attempt", report.attempt().fence()}});
      queue_.Add(std::move(report), /*leftover=*/true);
    }
    thread_ = std::thread([this] { Loop(); });
  }

  ~Impl() {
    {
      std::lock_guard lock(mu_);
      stopping_ = true;
      if (in_flight_ != nullptr) in_flight_->TryCancel();
    }
    changed_.notify_all();
    thread_.join();
  }

  void Submit(Report report) {
    const absl::Status written = outbox_.Put(report);
    if (!written.ok()) {
      LogError("report is not in the outbox: it is lost if this worker dies before it is sent",
               {{"error", written}});
    }
    std::lock_guard lock(mu_);
    queue_.Add(std::move(report), /*leftover=*/false);
    changed_.notify_all();
  }

  void SetCoordinator(std::optional<std::string> id) {
    std::lock_guard lock(mu_);
    queue_.SetCoordinator(std::move(id));
    changed_.notify_all();
  }

  std::vector<v1::AttemptId> Pending(const std::string& coordinator_id) const {
    std::lock_guard lock(mu_);
    return queue_.Pending(coordinator_id);
  }

  bool HasUntriedLeftovers(const std::string& coordinator_id) const {
    std::lock_guard lock(mu_);
    return queue_.HasUntriedLeftovers(coordinator_id);
  }

  size_t pending_in_all() const {
    std::lock_guard lock(mu_);
    return queue_.size();
  }

 private:
  void Loop() {
    std::unique_lock lock(mu_);
    while (!stopping_) {
      ReportQueue::Entry* const next = queue_.Next();
      if (next == nullptr) {
        changed_.wait(lock);
      } else if (next->due > clock_.Steady()) {
        changed_.wait_until(lock, next->due);
      } else {
        TrySend(lock, next);
      }
    }
  }

  // Only this thread removes entries, so the entry stays valid while the lock is released.
  void TrySend(std::unique_lock<std::mutex>& lock, ReportQueue::Entry* entry) {
    grpc::ClientContext context;
    SetRpcTimeout(context, Seconds(options_.timeout_s));
    in_flight_ = &context;
    lock.unlock();
    v1::ReportReply reply;
    const absl::Status status = Call(context, entry->report, &reply);
    LogAnswer(entry->report, status, reply);
    if (ReportQueue::IsDefinitive(status)) {
      const absl::Status removed = outbox_.Remove(entry->report);
      if (!removed.ok()) LogWarning("report stays in the outbox", {{"error", removed}});
    }
    lock.lock();
    in_flight_ = nullptr;
    queue_.Answered(entry, status);
    lock.unlock();
    on_change_();
    lock.lock();
  }

  absl::Status Call(grpc::ClientContext& context, const Report& report, v1::ReportReply* reply) {
    if (const auto* complete = std::get_if<v1::CompleteRequest>(&report.body)) {
      return FromGrpc(coordinator_.Complete(&context, *complete, reply));
    }
    return FromGrpc(coordinator_.Fail(&context, std::get<v1::FailRequest>(report.body), reply));
  }

  static void LogAnswer(const Report& report, const absl::Status& status,
                        const v1::ReportReply& reply) {
    LogContext names;
    names.job = report.attempt().job_id();
    names.attempt = report.attempt().fence();
    ScopedLogContext scope(names);
    if (status.code() == absl::StatusCode::kInvalidArgument) {
      LogError("coordinator refuses the report", {{"error", status}});
    } else if (!status.ok()) {
      LogWarning("report not answered yet", {{"error", status}});
    } else if (reply.outcome() == v1::REPORT_OUTCOME_OK) {
      LogDebug("report accepted");
    } else {
      LogInfo("report answered", {{"outcome", v1::ReportOutcome_Name(reply.outcome())}});
    }
  }

  const ReportSenderOptions options_;
  Outbox& outbox_;
  v1::Coordinator::StubInterface& coordinator_;
  Clock& clock_;
  const std::function<void()> on_change_;

  mutable std::mutex mu_;
  std::condition_variable changed_;
  // Guarded by mu_.
  ReportQueue queue_;
  grpc::ClientContext* in_flight_ = nullptr;
  bool stopping_ = false;

  std::thread thread_;
};

ReportSender::ReportSender(const ReportSenderOptions& options, Outbox& outbox,
                           v1::Coordinator::StubInterface& coordinator, Clock& clock, Rng rng,
                           std::function<void()> on_change)
    : impl_(
          std::make_unique<Impl>(options, outbox, coordinator, clock, rng, std::move(on_change))) {}
ReportSender::~ReportSender() = default;
void ReportSender::Submit(Report report) { impl_->Submit(std::move(report)); }
void ReportSender::SetCoordinator(std::optional<std::string> id) {
  impl_->SetCoordinator(std::move(id));
}
std::vector<v1::AttemptId> ReportSender::Pending(const std::string& coordinator_id) const {
  return impl_->Pending(coordinator_id);
}
bool ReportSender::HasUntriedLeftovers(const std::string& coordinator_id) const {
  return impl_->HasUntriedLeftovers(coordinator_id);
}
size_t ReportSender::pending_in_all() const { return impl_->pending_in_all(); }

}  // namespace parallax
