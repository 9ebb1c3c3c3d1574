// The frame of all calls, and the calls of workers; coordinator_service_clients.cc has those of
// clients.
#include "coordinator/rpc/coordinator_service.h"

#include "common/base/status.h"
#include "common/rpc/grpc_status.h"
#include "common/store/store_guard.h"
#include "coordinator/rpc/validation.h"
#include "coordinator/rpc/workers/output_check.h"

namespace parallax {
namespace {

constexpr size_t kSmallReport = 16384;  // Bytes.

}  // namespace

CoordinatorService::CoordinatorService(JobQueue& queue, Dispatcher& dispatcher,
                                       const WaitReasons& waits, TaskPool& worker_pool,
                                       TaskPool& client_pool, AnnouncedStore store,
                                       std::string coordinator_id, double lease_s,
                                       const Store* outputs, ContentKeeper* content,
                                       NotifyHosts notify_hosts, double hello_s)
    : queue_(queue),
      dispatcher_(dispatcher),
      waits_(waits),
      worker_pool_(worker_pool),
      client_pool_(client_pool),
      store_(std::move(store)),
      coordinator_id_(std::move(coordinator_id)),
      outputs_(outputs),
      content_(content),
      notify_hosts_(std::move(notify_hosts)),
      streams_{queue,   dispatcher,          worker_pool, store_, coordinator_id_,
               lease_s, [this] { Leave(); }, watch_,      hello_s} {}

void CoordinatorService::Enter() {
  std::lock_guard lock(mu_);
  ++calls_;
}

void CoordinatorService::Leave() {
  std::lock_guard lock(mu_);
  if (--calls_ == 0) idle_.notify_all();
}

void CoordinatorService::WaitForCalls() {
  std::unique_lock lock(mu_);
  idle_.wait(lock, [this] { return calls_ == 0; });
}

const JobKind* CoordinatorService::KindOf(const v1::CompleteRequest& request) const {
  const std::optional<KindId> kind = queue_.kinds().Find(request.kind());
  return kind ? &queue_.kinds()[*kind] : nullptr;
}

grpc::ServerBidiReactor<v1::WorkerMessage, v1::CoordinatorMessage>* CoordinatorService::Work(
    Context* context) {
  Enter();
  return WorkStream::Open(streams_, context);
}

absl::Status CoordinatorService::CheckStore() const {
  return guard_ == nullptr ? absl::OkStatus() : guard_->status();
}

bool CoordinatorService::IsForeign(const std::string& coordinator_id) const {
  return !coordinator_id.empty() && coordinator_id != coordinator_id_;
}

void CoordinatorService::EndReport(Reactor* reactor, v1::ReportReply* reply,
                                   const absl::StatusOr<v1::ReportOutcome>& outcome,
                                   const char* if_ok) {
  if (outcome.ok()) reply->set_outcome(*outcome);
  meter_.Count(outcome, if_ok);
  reactor->Finish(ToGrpc(outcome.status()));
}

// Ends the call if the queue needn't be asked; else it counts as under way.
bool CoordinatorService::Admit(Reactor* reactor, v1::ReportReply* reply, const absl::Status& status,
                               const std::string& coordinator_id) {
  if (!status.ok()) {
    EndReport(reactor, reply, status, "");
    return false;
  }
  if (IsForeign(coordinator_id)) {
    EndReport(reactor, reply, v1::REPORT_OUTCOME_STALE_FENCE, "");
    return false;
  }
  Enter();
  return true;
}

CoordinatorService::Reactor* CoordinatorService::Complete(Context* context,
                                                          const v1::CompleteRequest* request,
                                                          v1::ReportReply* reply) {
  Reactor* const reactor = context->DefaultReactor();
  if (!Admit(reactor, reply, CheckComplete(*request), request->coordinator_id())) return reactor;
  const JobKind* const kind = KindOf(*request);
  const bool has_output = kind != nullptr && kind->traits().has_output;
  const bool check = outputs_ != nullptr && has_output;
  const auto ask = [this, reactor, request, reply, kind, check, has_output] {
    // The worker keeps its report and tries again.
    if (const absl::Status there = has_output ? CheckStore() : absl::OkStatus(); !there.ok()) {
      EndReport(reactor, reply, there, "");
      return Leave();
    }
    std::string missing;
    if (check) {
      const std::vector<JobKind::OutputFile> files = kind->FilesOf(request->result());
      auto why = WhyNotInStore(*outputs_, files);
      if (why.ok() && why->empty()) {
        why = WhyNotAsHashed(*outputs_, files, request->attempt().fence());
      }
      // The store can't be asked now: the worker keeps its report and tries again.
      if (!why.ok()) {
        EndReport(reactor, reply, Unavailable("{}", why.status().message()), "");
        return Leave();
      }
      missing = *std::move(why);
    }
    queue_.CompleteAsync(
        *request, missing,
        [this, reactor, request, reply, kind](absl::StatusOr<v1::ReportOutcome> end) {
          if (end.ok() && *end == v1::REPORT_OUTCOME_OK) {
            dispatcher_.Reported(request->worker(), true);
            if (kind != nullptr) meter_.AddWork(*request, *kind);
          }
          EndReport(reactor, reply, end, "OK");
          Leave();
        });
  };
  // Packing a recipe takes its time, which is none of gRPC's threads'; a word to another thread
  // takes more than packing a few frames.
  if (!check && request->ByteSizeLong() <= kSmallReport) {
    ask();
  } else {
    worker_pool_.Run(ask);
  }
  return reactor;
}

CoordinatorService::Reactor* CoordinatorService::Fail(Context* context,
                                                      const v1::FailRequest* request,
                                                      v1::ReportReply* reply) {
  Reactor* const reactor = context->DefaultReactor();
  if (!Admit(reactor, reply, CheckFail(*request), request->coordinator_id())) return reactor;
  worker_pool_.Run([this, reactor, request, reply] {
    const absl::StatusOr<v1::ReportOutcome> end = queue_.Fail(CleanFail(*request));
    if (end.ok() && *end == v1::REPORT_OUTCOME_OK) dispatcher_.Reported(request->worker(), false);
    EndReport(reactor, reply, end, "FAILED");
    Leave();
  });
  return reactor;
}

}  // namespace parallax
