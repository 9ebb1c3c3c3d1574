#include "coordinator/rpc/streams_service.h"

#include <algorithm>
#include <chrono>

#include "common/base/seconds.h"
#include "common/base/system/log.h"
#include "common/config/config.h"
#include "common/rpc/endpoint.h"
#include "common/rpc/grpc_status.h"
#include "coordinator/rpc/content_keeper.h"
#include "coordinator/rpc/validation.h"
#include "coordinator/rpc/workers/steering.h"

namespace parallax {
namespace {

constexpr std::chrono::milliseconds kAskAgain(100);
constexpr double kTickEvery_s = 1;
constexpr size_t kMostWaiting = 1024;  // Calls beyond these are answered without pairs at once.

absl::Status Stopping() { return Unavailable("the coordinator is stopping; ask again"); }

}  // namespace

StreamsService::StreamsService(JobQueue& queue, TaskPool& pool, Clock& clock, std::string store_uri,
                               ContentKeeper* content, NotifyHosts notify_hosts)
    : keeper_(queue, clock),
      pool_(pool),
      calls_(pool),
      clock_(clock),
      store_uri_(std::move(store_uri)),
      content_(content),
      notify_hosts_(std::move(notify_hosts)) {}

void StreamsService::Start() {
  thread_ = std::thread([this] { Loop(); });
}

void StreamsService::Stop() {
  {
    std::lock_guard lock(mu_);
    stopping_ = true;
  }
  changed_.notify_all();
  if (thread_.joinable()) thread_.join();
  std::list<Waiting> waiting;
  {
    std::lock_guard lock(mu_);
    waiting.swap(waiting_);
  }
  for (const Waiting& call : waiting) {
    call.reactor->Finish(ToGrpc(Stopping()));
    calls_.End();
  }
  calls_.Wait();
}

absl::Status StreamsService::CheckOwner(const Context& context, const std::string& stream) {
  const RpcCaller caller = CallerOf(context);
  if (caller.Is(Role::kOperator)) return absl::OkStatus();
  ASSIGN_OR_RETURN(const std::string opened_by, keeper_.OpenedBy(stream));
  return CheckOpener(caller, opened_by, "stream '" + stream + "'",
                     "to take pairs from and to close");
}

StreamsService::Reactor* StreamsService::Open(Context* context,
                                              const v1::OpenStreamRequest* request,
                                              v1::StreamStatus* reply) {
  return calls_.Run(context, [this, context, request, reply]() -> absl::Status {
    v1::StudySpec study = request->study();
    RETURN_IF_ERROR(ValidateStudy(study));
    RETURN_IF_ERROR(notify_hosts_.Check(study));
    RETURN_IF_ERROR(CheckPriority(CallerOf(*context), study.priority()));
    if (content_ != nullptr) RETURN_IF_ERROR(content_->CheckStudy(study));
    ASSIGN_OR_RETURN(*reply, keeper_.Open(study, ActorOf(*context)));
    LogInfo("stream opened", {{"stream", study.name()}});
    return absl::OkStatus();
  });
}

StreamsService::Reactor* StreamsService::List(Context* context,
                                              const v1::ListStreamsRequest* request,
                                              v1::ListStreamsReply* reply) {
  return calls_.Run(context, [this, request, reply]() -> absl::Status {
    ASSIGN_OR_RETURN(std::vector<v1::StreamStatus> streams, keeper_.List(request->name()));
    for (v1::StreamStatus& stream : streams) *reply->add_streams() = std::move(stream);
    return absl::OkStatus();
  });
}

StreamsService::Reactor* StreamsService::Close(Context* context,
                                               const v1::CloseStreamRequest* request,
                                               v1::StreamStatus* reply) {
  return calls_.Run(context, [this, context, request, reply]() -> absl::Status {
    RETURN_IF_ERROR(CheckOwner(*context, request->name()));
    ASSIGN_OR_RETURN(*reply, keeper_.Close(request->name()));
    LogInfo("stream closed", {{"stream", request->name()}, {"reason", request->reason()}});
    return absl::OkStatus();
  });
}

StreamsService::Reactor* StreamsService::Next(Context* context, const v1::NextPairsRequest* request,
                                              v1::NextPairsReply* reply) {
  Reactor* const reactor = context->DefaultReactor();
  const absl::Status checked = CheckNextPairs(*request);
  if (!checked.ok()) {
    reactor->Finish(ToGrpc(checked));
    return reactor;
  }
  calls_.Begin();
  const Waiting call{.context = context,
                     .reactor = reactor,
                     .request = request,
                     .reply = reply,
                     .until = SecondsAfter(clock_.Steady(), request->wait_s())};
  pool_.Run([this, call] {
    const absl::Status owner = CheckOwner(*call.context, call.request->stream());
    if (owner.ok()) return Answer(call);
    call.reactor->Finish(ToGrpc(owner));
    calls_.End();
  });
  return reactor;
}

void StreamsService::Answer(const Waiting& call) {
  absl::StatusOr<v1::NextPairsReply> next = keeper_.Next(*call.request);
  const bool is_over = !next.ok() || !next->pairs().empty() || clock_.Steady() >= call.until ||
                       call.context->IsCancelled();
  if (!is_over) {
    std::lock_guard lock(mu_);
    if (stopping_) {
      next = Stopping();
    } else if (waiting_.size() < kMostWaiting) {
      waiting_.push_back(call);
      return;
    }
  }
  if (next.ok()) {
    *call.reply = *std::move(next);
    call.reply->set_store_uri(store_uri_);
  }
  call.reactor->Finish(ToGrpc(next.status()));
  calls_.End();
}

void StreamsService::Loop() {
  SteadyTime ticked = SecondsAfter(clock_.Steady(), -kTickEvery_s);
  std::unique_lock lock(mu_);
  while (!stopping_) {
    std::list<Waiting> waiting;
    waiting.swap(waiting_);
    lock.unlock();
    if (SecondsBetween(ticked, clock_.Steady()) >= kTickEvery_s) {
      ticked = clock_.Steady();
      const absl::Status status = keeper_.Tick();
      if (!status.ok()) LogWarning("streams can't go on", {{"error", ToStd(status.message())}});
    }
    for (const Waiting& call : waiting) Answer(call);
    lock.lock();
    changed_.wait_for(lock, kAskAgain, [this] { return stopping_; });
  }
}

}  // namespace parallax
