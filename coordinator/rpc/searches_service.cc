#include "coordinator/rpc/searches_service.h"

#include <chrono>

#include "common/base/names.h"
#include "common/base/system/log.h"
#include "common/config/config.h"
#include "common/config/training_plan.h"
#include "common/rpc/endpoint.h"
#include "coordinator/rpc/content_keeper.h"
#include "coordinator/rpc/validation.h"
#include "coordinator/rpc/workers/steering.h"

namespace parallax {
namespace {

constexpr std::chrono::seconds kTakeAStep(1);

}  // namespace

SearchesService::SearchesService(JobQueue& queue, TaskPool& pool, Clock& clock, TrialScorer scorer,
                                 std::map<std::string, Sampler> samplers, ContentKeeper* content,
                                 NotifyHosts notify_hosts)
    : keeper_(queue, clock, std::move(scorer), std::move(samplers)),
      calls_(pool),
      content_(content),
      notify_hosts_(std::move(notify_hosts)) {}

void SearchesService::Start() {
  thread_ = std::thread([this] { Loop(); });
}

void SearchesService::Stop() {
  {
    std::lock_guard lock(mu_);
    stopping_ = true;
  }
  stop_.notify_all();
  if (thread_.joinable()) thread_.join();
  calls_.Wait();
}

SearchesService::Reactor* SearchesService::Open(Context* context,
                                                const v1::OpenSearchRequest* request,
                                                v1::SearchStatus* reply) {
  return calls_.Run(context, [this, context, request, reply]() -> absl::Status {
    v1::StudySpec study = request->study();
    RETURN_IF_ERROR(ValidateStudy(study));
    RETURN_IF_ERROR(notify_hosts_.Check(study));
    RETURN_IF_ERROR(CheckPriority(CallerOf(*context), study.priority()));
    ResolveTraining(&study);
    if (content_ != nullptr) RETURN_IF_ERROR(content_->CheckStudy(study));
    const absl::StatusOr<std::string> opened_by = keeper_.OpenedBy(study.name());
    if (opened_by.ok()) {
      RETURN_IF_ERROR(CheckOpener(CallerOf(*context), *opened_by, "search " + Quoted(study.name()),
                                  "to go on with"));
    }
    ASSIGN_OR_RETURN(*reply, keeper_.Open(study, ActorOf(*context)));
    LogInfo("search opened", {{"search", study.name()}});
    return absl::OkStatus();
  });
}

SearchesService::Reactor* SearchesService::List(Context* context,
                                                const v1::ListSearchesRequest* request,
                                                v1::ListSearchesReply* reply) {
  return calls_.Run(context, [this, request, reply]() -> absl::Status {
    ASSIGN_OR_RETURN(std::vector<v1::SearchStatus> searches, keeper_.List(request->name()));
    for (v1::SearchStatus& search : searches) *reply->add_searches() = std::move(search);
    return absl::OkStatus();
  });
}

SearchesService::Reactor* SearchesService::Stop(Context* context,
                                                const v1::StopSearchRequest* request,
                                                v1::SearchStatus* reply) {
  return calls_.Run(context, [this, context, request, reply]() -> absl::Status {
    const std::string& name = request->name();
    ASSIGN_OR_RETURN(const std::string opened_by, keeper_.OpenedBy(name));
    RETURN_IF_ERROR(
        CheckOpener(CallerOf(*context), opened_by, "search " + Quoted(name), "to stop"));
    ASSIGN_OR_RETURN(*reply, keeper_.Stop(name, CleanText(request->reason()), request->forget()));
    LogInfo("search stopped", {{"search", name}, {"reason", request->reason()}});
    return absl::OkStatus();
  });
}

void SearchesService::Loop() {
  std::unique_lock lock(mu_);
  while (!stopping_) {
    lock.unlock();
    const absl::Status status = keeper_.Tick();
    if (!status.ok()) LogWarning("searches can't go on", {{"error", ToStd(status.message())}});
    lock.lock();
    stop_.wait_for(lock, kTakeAStep, [this] { return stopping_; });
  }
}

}  // namespace parallax
