// The calls of clients. Checks of a request that cost nothing come before the pool.
#include <algorithm>

#include "common/base/names.h"
#include "common/base/status.h"
#include "common/base/system/log.h"
#include "common/base/version.h"
#include "common/config/training_plan.h"
#include "common/rpc/endpoint.h"
#include "common/rpc/grpc_status.h"
#include "coordinator/rpc/content_keeper.h"
#include "coordinator/rpc/coordinator_service.h"
#include "coordinator/rpc/reply_size.h"
#include "coordinator/rpc/validation.h"
#include "coordinator/rpc/workers/steering.h"

namespace parallax {
namespace {

constexpr int kMostListed = 10'000;
constexpr int kStudiesListed = 100;  // Default page size.
constexpr int kStudiesAtOnce = 20;   // Read and cut before the next are read.

}  // namespace

CoordinatorService::Reactor* CoordinatorService::EndNow(Context* context,
                                                        const absl::Status& status) {
  Reactor* const reactor = context->DefaultReactor();
  reactor->Finish(ToGrpc(status));
  return reactor;
}

CoordinatorService::Reactor* CoordinatorService::ForClient(Context* context,
                                                           const absl::Status& checked,
                                                           std::function<absl::Status()> body) {
  if (!checked.ok()) return EndNow(context, checked);
  Reactor* const reactor = context->DefaultReactor();
  Enter();
  client_pool_.Run([this, reactor, body = std::move(body)] {
    reactor->Finish(ToGrpc(body()));
    Leave();
  });
  return reactor;
}

CoordinatorService::Reactor* CoordinatorService::Submit(Context* context,
                                                        const v1::SubmitRequest* request,
                                                        v1::SubmitReply* reply) {
  return ForClient(context, absl::OkStatus(), [this, context, request, reply]() -> absl::Status {
    RETURN_IF_ERROR(CheckStore());
    RETURN_IF_ERROR(CheckSubmit(*request));
    RETURN_IF_ERROR(notify_hosts_.Check(request->study()));
    RETURN_IF_ERROR(CheckPriority(CallerOf(*context), request->study().priority()));
    v1::SubmitRequest resolved = *request;
    ResolveTraining(resolved.mutable_study());
    if (content_ != nullptr) RETURN_IF_ERROR(content_->CheckStudy(*resolved.mutable_study()));
    ASSIGN_OR_RETURN(*reply, queue_.Submit(resolved, ActorOf(*context)));
    if (!reply->existed()) {
      for (v1::WaitingJobs& jobs : waits_.UnservableOf(resolved.study())) {
        *reply->add_unservable() = std::move(jobs);
      }
    }
    LogInfo(reply->existed() ? "study submitted again" : "study submitted",
            {{"study", request->study().name()}, {"study_id", reply->study_id()}});
    return absl::OkStatus();
  });
}

CoordinatorService::Reactor* CoordinatorService::ListStudies(Context* context,
                                                             const v1::ListStudiesRequest* request,
                                                             v1::ListStudiesReply* reply) {
  const absl::Status status = CheckLimit(request->limit(), kMostListed);
  return ForClient(context, status, [this, request, reply]() -> absl::Status {
    const int limit = request->limit() > 0 ? request->limit() : kStudiesListed;
    int64_t before = request->before();
    while (reply->studies_size() < limit) {
      const int wanted = std::min(limit - reply->studies_size(), kStudiesAtOnce);
      ASSIGN_OR_RETURN(std::vector<v1::StudyStatus> studies, queue_.ListStudies(wanted, before));
      if (studies.empty()) break;
      before = studies.back().study_id();
      for (v1::StudyStatus& study : studies) {
        waits_.AddTo(study);
        FitStudy(&study);
      }
      if (!AddItems(studies, reply->mutable_studies(), kMaxReasonBytes)) break;
    }
    return absl::OkStatus();
  });
}

absl::Status CoordinatorService::GetStudyTo(StudyId study, v1::StudyStatus* reply) {
  ASSIGN_OR_RETURN(*reply, queue_.GetStudy(study));
  waits_.AddTo(*reply);
  FitStudy(reply);
  return absl::OkStatus();
}

CoordinatorService::Reactor* CoordinatorService::GetStudy(Context* context,
                                                          const v1::GetStudyRequest* request,
                                                          v1::StudyStatus* reply) {
  const absl::Status status = CheckStudyId(request->study_id());
  return ForClient(context, status, [this, request, reply] {
    return GetStudyTo(StudyId{request->study_id()}, reply);
  });
}

CoordinatorService::Reactor* CoordinatorService::ChangeStudy(Context* context,
                                                             const v1::StudyRequest* request,
                                                             v1::StudyStatus* reply,
                                                             StudyCall call) {
  const absl::Status status = CheckStudyChange(*request);
  return ForClient(context, status, [this, context, request, reply, call]() -> absl::Status {
    const StudyId study{request->study_id()};
    RETURN_IF_ERROR(CheckSteering(queue_, CallerOf(*context), study));
    JobQueue& queue = queue_;  // GCC 12 checks `queue_.*call` with a `this` that it has not set.
    RETURN_IF_ERROR((queue.*call)(study, request->reason(), ActorOf(*context)));
    return GetStudyTo(study, reply);
  });
}

CoordinatorService::Reactor* CoordinatorService::Cancel(Context* context,
                                                        const v1::StudyRequest* request,
                                                        v1::StudyStatus* reply) {
  return ChangeStudy(context, request, reply, &JobQueue::Cancel);
}

CoordinatorService::Reactor* CoordinatorService::Pause(Context* context,
                                                       const v1::StudyRequest* request,
                                                       v1::StudyStatus* reply) {
  return ChangeStudy(context, request, reply, &JobQueue::Pause);
}

CoordinatorService::Reactor* CoordinatorService::Resume(Context* context,
                                                        const v1::StudyRequest* request,
                                                        v1::StudyStatus* reply) {
  return ChangeStudy(context, request, reply, &JobQueue::Resume);
}

CoordinatorService::Reactor* CoordinatorService::Comment(Context* context,
                                                         const v1::StudyRequest* request,
                                                         v1::StudyStatus* reply) {
  return ChangeStudy(context, request, reply, &JobQueue::Comment);
}

CoordinatorService::Reactor* CoordinatorService::Retry(Context* context,
                                                       const v1::StudyRequest* request,
                                                       v1::RetryReply* reply) {
  const absl::Status status = CheckStudyChange(*request);
  return ForClient(context, status, [this, context, request, reply]() -> absl::Status {
    RETURN_IF_ERROR(CheckSteering(queue_, CallerOf(*context), StudyId{request->study_id()}));
    ASSIGN_OR_RETURN(const int64_t jobs, queue_.Retry(StudyId{request->study_id()},
                                                      ActorOf(*context), request->reason()));
    reply->set_jobs(jobs);
    return absl::OkStatus();
  });
}

CoordinatorService::Reactor* CoordinatorService::Forget(Context* context,
                                                        const v1::StudyRequest* request,
                                                        v1::ForgetReply* reply) {
  const absl::Status status = CheckStudyChange(*request);
  return ForClient(context, status, [this, context, request, reply]() -> absl::Status {
    const StudyId study{request->study_id()};
    RETURN_IF_ERROR(CheckSteering(queue_, CallerOf(*context), study));
    ASSIGN_OR_RETURN(*reply, queue_.Forget(study, request->reason(), ActorOf(*context)));
    LogInfo("study forgotten", {{"study_id", study.value}, {"pairs", reply->pairs()}});
    return absl::OkStatus();
  });
}

CoordinatorService::Reactor* CoordinatorService::SetMaxRunning(
    Context* context, const v1::SetMaxRunningRequest* request, v1::StudyStatus* reply) {
  const absl::Status status = CheckSetMaxRunning(*request);
  return ForClient(context, status, [this, context, request, reply]() -> absl::Status {
    const StudyId study{request->study_id()};
    RETURN_IF_ERROR(CheckSteering(queue_, CallerOf(*context), study));
    RETURN_IF_ERROR(
        queue_.SetMaxRunning(study, request->max_running(), request->reason(), ActorOf(*context)));
    return GetStudyTo(study, reply);
  });
}

CoordinatorService::Reactor* CoordinatorService::SetPriority(Context* context,
                                                             const v1::SetPriorityRequest* request,
                                                             v1::StudyStatus* reply) {
  const absl::Status status = CheckSetPriority(*request);
  return ForClient(context, status, [this, context, request, reply]() -> absl::Status {
    const StudyId study{request->study_id()};
    RETURN_IF_ERROR(CheckSteering(queue_, CallerOf(*context), study));
    RETURN_IF_ERROR(CheckPriority(CallerOf(*context), request->priority()));
    RETURN_IF_ERROR(
        queue_.SetPriority(study, request->priority(), request->reason(), ActorOf(*context)));
    return GetStudyTo(study, reply);
  });
}

CoordinatorService::Reactor* CoordinatorService::RetryJob(Context* context,
                                                          const v1::RetryJobRequest* request,
                                                          v1::RetryReply* reply) {
  const absl::Status status = CheckRetryJob(*request);
  return ForClient(context, status, [this, context, request, reply]() -> absl::Status {
    const StudyId study{request->study_id()};
    RETURN_IF_ERROR(CheckSteering(queue_, CallerOf(*context), study));
    RETURN_IF_ERROR(
        queue_.RetryJob(study, request->job_id(), request->reason(), ActorOf(*context)));
    reply->set_jobs(1);
    return absl::OkStatus();
  });
}

CoordinatorService::Reactor* CoordinatorService::ListUsers(Context* context,
                                                           const v1::ListUsersRequest*,
                                                           v1::ListUsersReply* reply) {
  return ForClient(context, absl::OkStatus(), [this, reply]() -> absl::Status {
    ASSIGN_OR_RETURN(std::vector<v1::UserStatus> users, queue_.ListUsers());
    AddItems(users, reply->mutable_users(), kMaxErrorBytes);
    return absl::OkStatus();
  });
}

CoordinatorService::Reactor* CoordinatorService::ListJobs(Context* context,
                                                          const v1::ListJobsRequest* request,
                                                          v1::ListJobsReply* reply) {
  absl::Status status = CheckStudyId(request->study_id());
  if (status.ok()) status = CheckLimit(request->limit(), kMostListed);
  if (status.ok()) status = CheckJobState(request->state());
  if (status.ok()) status = CheckJobState(request->after_state());
  return ForClient(context, status, [this, request, reply]() -> absl::Status {
    ASSIGN_OR_RETURN(std::vector<v1::JobStatus> jobs, queue_.ListJobs(*request));
    RETURN_IF_ERROR(waits_.AddTo(jobs, request->study_id()));
    // Logs are bounded already, and their ends count.
    std::vector<std::string> logs;
    for (v1::JobStatus& job : jobs) logs.push_back(std::move(*job.mutable_log_tail()));
    for (v1::JobStatus& job : jobs) job.clear_log_tail();
    reply->set_cut(!AddItems(jobs, reply->mutable_jobs(), kMaxReasonBytes));
    for (int i = 0; i < reply->jobs_size(); ++i) {
      *reply->mutable_jobs(i)->mutable_log_tail() = std::move(logs[static_cast<size_t>(i)]);
    }
    return absl::OkStatus();
  });
}

CoordinatorService::Reactor* CoordinatorService::ListWorkers(Context* context,
                                                             const v1::ListWorkersRequest*,
                                                             v1::ListWorkersReply* reply) {
  return ForClient(context, absl::OkStatus(), [this, reply]() -> absl::Status {
    std::vector<v1::WorkerStatus> workers = dispatcher_.Workers();
    AddItems(workers, reply->mutable_workers(), kMaxNameBytes);
    ASSIGN_OR_RETURN(std::vector<v1::DrainOrder> drains, queue_.Drains());
    AddItems(drains, reply->mutable_drains(), kMaxReasonBytes);
    return absl::OkStatus();
  });
}

CoordinatorService::Reactor* CoordinatorService::DrainWorkers(
    Context* context, const v1::DrainWorkersRequest* request, v1::DrainWorkersReply* reply) {
  const absl::Status status = CheckDrain(*request);
  return ForClient(context, status, [this, context, request, reply]() -> absl::Status {
    v1::DrainOrder order;
    order.set_pattern(request->pattern());
    order.set_reason(request->reason());
    order.set_actor(ActorOf(*context));
    RETURN_IF_ERROR(queue_.Drain(order, request->undo()));
    LogInfo(request->undo() ? "workers take work again" : "workers are drained",
            {{"pattern", request->pattern()}, {"reason", request->reason()}});
    for (const std::string& name : dispatcher_.ConnectedLike(request->pattern())) {
      reply->add_workers(name);
    }
    return absl::OkStatus();
  });
}

CoordinatorService::Reactor* CoordinatorService::ListAttempts(
    Context* context, const v1::ListAttemptsRequest* request, v1::ListAttemptsReply* reply) {
  const absl::Status status = CheckJobId(request->job_id());
  return ForClient(context, status, [this, request, reply]() -> absl::Status {
    ASSIGN_OR_RETURN(*reply, queue_.ListAttempts(request->job_id()));
    return absl::OkStatus();
  });
}

CoordinatorService::Reactor* CoordinatorService::ListResults(Context* context,
                                                             const v1::ListResultsRequest* request,
                                                             v1::ListResultsReply* reply) {
  absl::Status status = CheckStudyId(request->study_id());
  if (status.ok()) status = CheckLimit(request->limit(), kMostListed);
  return ForClient(context, status, [this, request, reply]() -> absl::Status {
    ASSIGN_OR_RETURN(std::vector<v1::JobResult> results, queue_.ListResults(*request));
    AddItems(results, reply->mutable_results(), kMaxErrorBytes);
    reply->set_store_uri(store_.uri);
    return absl::OkStatus();
  });
}

CoordinatorService::Reactor* CoordinatorService::ListFrames(Context* context,
                                                            const v1::ListFramesRequest* request,
                                                            v1::ListFramesReply* reply) {
  absl::Status status = CheckStudyId(request->study_id());
  if (status.ok()) status = CheckLimit(request->limit(), kMostListed);
  return ForClient(context, status, [this, request, reply]() -> absl::Status {
    ASSIGN_OR_RETURN(std::vector<v1::PublishedFrame> frames, queue_.ListFrames(*request));
    AddItems(frames, reply->mutable_frames(), kMaxErrorBytes);
    reply->set_store_uri(store_.uri);
    return absl::OkStatus();
  });
}

CoordinatorService::Reactor* CoordinatorService::GetScene(Context* context,
                                                          const v1::GetSceneRequest* request,
                                                          v1::GetSceneReply* reply) {
  absl::Status status = CheckStudyId(request->study_id());
  if (status.ok()) status = CheckName("variant", request->variant());
  return ForClient(context, status, [this, request, reply]() -> absl::Status {
    ASSIGN_OR_RETURN(*reply->mutable_scene(), queue_.GetScene(*request));
    return absl::OkStatus();
  });
}

CoordinatorService::Reactor* CoordinatorService::GetInfo(Context* context,
                                                         const v1::GetInfoRequest*,
                                                         v1::GetInfoReply* reply) {
  reply->set_version(kProgramVersion);
  reply->set_epoch(queue_.epoch());
  reply->set_store_uri(store_.uri);
  reply->set_store_id(store_.id);
  reply->set_schema_version(queue_.schema_version());
  reply->set_coordinator_id(coordinator_id_);
  reply->set_protocol(kWorkProtocol);
  return EndNow(context, absl::OkStatus());
}

void CoordinatorService::SetPage(CoordinatorServer::PageOpener page) {
  std::lock_guard lock(page_mu_);
  page_ = std::move(page);
}

CoordinatorService::Reactor* CoordinatorService::OpenPage(Context* context,
                                                          const v1::OpenPageRequest*,
                                                          v1::OpenPageReply* reply) {
  return ForClient(context, absl::OkStatus(), [this, context, reply]() -> absl::Status {
    std::lock_guard lock(page_mu_);
    if (page_ == nullptr) {
      return FailedPrecondition(
          "this coordinator serves no page: `coordinator serve --http HOST:PORT` does");
    }
    ASSIGN_OR_RETURN(*reply->mutable_url(), page_(CallerOf(*context)));
    return absl::OkStatus();
  });
}

CoordinatorService::Reactor* CoordinatorService::ListAudit(Context* context,
                                                           const v1::ListAuditRequest* request,
                                                           v1::ListAuditReply* reply) {
  const absl::Status status = CheckLimit(request->limit(), kMostListed);
  return ForClient(context, status, [this, request, reply]() -> absl::Status {
    ASSIGN_OR_RETURN(std::vector<v1::AuditEntry> entries, queue_.ListAudit(*request));
    AddItems(entries, reply->mutable_entries(), kMaxErrorBytes);
    return absl::OkStatus();
  });
}

}  // namespace parallax
