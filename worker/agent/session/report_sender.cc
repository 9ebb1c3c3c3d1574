#include "worker/agent/session/report_sender.h"

#include <grpcpp/grpcpp.h>

#include <condition_variable>
#include <list>
#include <mutex>
#include <thread>

#include "common/base/system/log.h"
#include "common/rpc/endpoint.h"
#include "common/rpc/grpc_status.h"
#include "worker/agent/session/backoff.h"

namespace parallax {
namespace {

using Seconds = std::chrono::duration<double>;

}  // namespace

class ReportSender::Impl {
  struct Entry {
    Report report;
    Backoff backoff;
    SteadyTime due{};
    bool leftover = false;
    bool tried = false;
  };

 public:
  Impl(const ReportSenderOptions& options, Outbox& outbox,
       v1::Coordinator::StubInterface& coordinator, Clock& clock, Rng rng,
       std::function<void()> on_change)
      : options_(options),
        outbox_(outbox),
        coordinator_(coordinator),
        clock_(clock),
        rng_(rng),
        on_change_(std::move(on_change)) {
    for (Report& report : outbox_.TakeLeftovers()) {
      LogInfo("report left from an earlier run",
              {{"job", report.attempt().job_id()}, {"attempt", report.attempt().fence()}});
      entries_.push_back(NewEntry(std::move(report)));
      entries_.back().leftover = true;
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
    entries_.push_back(NewEntry(std::move(report)));
    changed_.notify_all();
  }

  void SetCoordinator(std::optional<std::string> id) {
    std::lock_guard lock(mu_);
    coordinator_id_ = std::move(id);
    // After a new connection, every report is tried again.
    for (Entry& entry : entries_) {
      entry.backoff.Reset();
      entry.due = {};
    }
    changed_.notify_all();
  }

  std::vector<v1::AttemptId> Pending(const std::string& coordinator_id) const {
    std::lock_guard lock(mu_);
    std::vector<v1::AttemptId> attempts;
    for (const Entry& entry : entries_) {
      if (entry.report.coordinator_id() == coordinator_id) {
        attempts.push_back(entry.report.attempt());
      }
    }
    return attempts;
  }

  bool HasUntriedLeftovers(const std::string& coordinator_id) const {
    std::lock_guard lock(mu_);
    for (const Entry& entry : entries_) {
      if (entry.leftover && !entry.tried && entry.report.coordinator_id() == coordinator_id) {
        return true;
      }
    }
    return false;
  }

  size_t pending_in_all() const {
    std::lock_guard lock(mu_);
    return entries_.size();
  }

 private:
  using Iterator = std::list<Entry>::iterator;

  // Requires mu_ (for the counter of streams), or to be the constructor.
  Entry NewEntry(Report report) {
    return {std::move(report),
            Backoff(rng_.Child("report", next_report_++), Seconds(options_.backoff_base_s),
                    Seconds(options_.backoff_cap_s))};
  }

  void Loop() {
    std::unique_lock lock(mu_);
    while (!stopping_) {
      const Iterator next = NextDue();
      if (next == entries_.end()) {
        changed_.wait(lock);
      } else if (next->due > clock_.Steady()) {
        changed_.wait_until(lock, next->due);
      } else {
        TrySend(lock, next);
      }
    }
  }

  // The sendable report that is due first, if any. Requires mu_.
  Iterator NextDue() {
    Iterator best = entries_.end();
    if (!coordinator_id_) return best;
    for (Iterator it = entries_.begin(); it != entries_.end(); ++it) {
      if (it->report.coordinator_id() != *coordinator_id_) continue;
      if (best == entries_.end() || it->due < best->due) best = it;
    }
    return best;
  }

  // Only this thread removes entries, so the iterator stays valid while the lock is released.
  void TrySend(std::unique_lock<std::mutex>& lock, Iterator it) {
    grpc::ClientContext context;
    SetRpcTimeout(context, Seconds(options_.timeout_s));
    in_flight_ = &context;
    lock.unlock();
    v1::ReportReply reply;
    const absl::Status status = Call(context, it->report, &reply);
    const bool done = status.ok() || status.code() == absl::StatusCode::kInvalidArgument;
    LogAnswer(it->report, status, reply);
    if (done) {
      const absl::Status removed = outbox_.Remove(it->report);
      if (!removed.ok()) LogWarning("report stays in the outbox", {{"error", removed}});
    }
    lock.lock();
    in_flight_ = nullptr;
    if (done) {
      entries_.erase(it);
    } else {
      it->tried = true;
      it->due =
          clock_.Steady() + std::chrono::duration_cast<SteadyTime::duration>(it->backoff.Next());
    }
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
  const Rng rng_;
  const std::function<void()> on_change_;

  mutable std::mutex mu_;
  std::condition_variable changed_;
  // Guarded by mu_.
  std::list<Entry> entries_;
  std::optional<std::string> coordinator_id_;
  grpc::ClientContext* in_flight_ = nullptr;
  uint64_t next_report_ = 0;
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
