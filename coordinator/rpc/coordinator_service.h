// Implements every RPC of parallax.v1.Coordinator on top of the queue. No RPC blocks gRPC's
// threads: calls that wait for a commit or read the database run on pools. Workers and clients have
// a pool each, so that slow clients can't starve workers.
#pragma once

#include <grpcpp/grpcpp.h>

#include <condition_variable>
#include <functional>
#include <mutex>
#include <string>

#include "coordinator/queue/job_queue.h"
#include "coordinator/rpc/call_watch.h"
#include "coordinator/rpc/coordinator_server.h"
#include "coordinator/rpc/task_pool.h"
#include "coordinator/rpc/workers/dispatcher.h"
#include "coordinator/rpc/workers/report_meter.h"
#include "coordinator/rpc/workers/wait_reasons.h"
#include "coordinator/rpc/workers/work_stream.h"
#include "parallax/v1/service.grpc.pb.h"

namespace parallax {

class ContentKeeper;
class Store;
class StoreGuard;

// Thread-safe.
class CoordinatorService final : public v1::Coordinator::CallbackService {
 public:
  // All arguments must outlive the service. `outputs` is the store in which files of results must
  // be; null: not checked. `content` checks that the content of studies is in the store; null: not
  // checked. Studies' notices may go to `notify_hosts` only.
  CoordinatorService(JobQueue& queue, Dispatcher& dispatcher, const WaitReasons& waits,
                     TaskPool& worker_pool, TaskPool& client_pool, AnnouncedStore store,
                     std::string coordinator_id, double lease_s, const Store* outputs,
                     ContentKeeper* content, NotifyHosts notify_hosts, double hello_s);

  // Sets what watches the store: while it is not there, no study is taken and no files are
  // published. Call it before the first RPC; `guard` must outlive the calls.
  void SetGuard(const StoreGuard* guard) { guard_ = guard; }
  void SetPage(CoordinatorServer::PageOpener page);  // See CoordinatorServer.
  const ReportMeter& meter() const { return meter_; }
  // Waits until no call is in progress.
  void WaitForCalls();

  using Context = grpc::CallbackServerContext;
  using Reactor = grpc::ServerUnaryReactor;
  grpc::ServerBidiReactor<v1::WorkerMessage, v1::CoordinatorMessage>* Work(Context*) override;
  Reactor* Complete(Context*, const v1::CompleteRequest*, v1::ReportReply*) override;
  Reactor* Fail(Context*, const v1::FailRequest*, v1::ReportReply*) override;
  Reactor* Submit(Context*, const v1::SubmitRequest*, v1::SubmitReply*) override;
  Reactor* ListStudies(Context*, const v1::ListStudiesRequest*, v1::ListStudiesReply*) override;
  Reactor* GetStudy(Context*, const v1::GetStudyRequest*, v1::StudyStatus*) override;
  Reactor* Cancel(Context*, const v1::StudyRequest*, v1::StudyStatus*) override;
  Reactor* Pause(Context*, const v1::StudyRequest*, v1::StudyStatus*) override;
  Reactor* Resume(Context*, const v1::StudyRequest*, v1::StudyStatus*) override;
  Reactor* Retry(Context*, const v1::StudyRequest*, v1::RetryReply*) override;
  Reactor* Forget(Context*, const v1::StudyRequest*, v1::ForgetReply*) override;
  Reactor* SetMaxRunning(Context*, const v1::SetMaxRunningRequest*, v1::StudyStatus*) override;
  Reactor* SetPriority(Context*, const v1::SetPriorityRequest*, v1::StudyStatus*) override;
  Reactor* Comment(Context*, const v1::StudyRequest*, v1::StudyStatus*) override;
  Reactor* RetryJob(Context*, const v1::RetryJobRequest*, v1::RetryReply*) override;
  Reactor* ListUsers(Context*, const v1::ListUsersRequest*, v1::ListUsersReply*) override;
  Reactor* ListAttempts(Context*, const v1::ListAttemptsRequest*, v1::ListAttemptsReply*) override;
  Reactor* DrainWorkers(Context*, const v1::DrainWorkersRequest*, v1::DrainWorkersReply*) override;
  Reactor* ListJobs(Context*, const v1::ListJobsRequest*, v1::ListJobsReply*) override;
  Reactor* ListWorkers(Context*, const v1::ListWorkersRequest*, v1::ListWorkersReply*) override;
  Reactor* ListFrames(Context*, const v1::ListFramesRequest*, v1::ListFramesReply*) override;
  Reactor* ListResults(Context*, const v1::ListResultsRequest*, v1::ListResultsReply*) override;
  Reactor* GetScene(Context*, const v1::GetSceneRequest*, v1::GetSceneReply*) override;
  Reactor* GetInfo(Context*, const v1::GetInfoRequest*, v1::GetInfoReply*) override;
  Reactor* ListAudit(Context*, const v1::ListAuditRequest*, v1::ListAuditReply*) override;
  Reactor* OpenPage(Context*, const v1::OpenPageRequest*, v1::OpenPageReply*) override;

 private:
  using StudyCall = absl::Status (JobQueue::*)(StudyId, std::string_view, std::string_view);

  // coordinator_service_clients.cc
  // Reads a study with the reasons of its READY jobs, cut to fit into a reply.
  absl::Status GetStudyTo(StudyId study, v1::StudyStatus* reply);
  Reactor* EndNow(Context* context, const absl::Status& status);
  // Runs `body` on the clients' pool and ends the call with what it returns; ends it at once if
  // `checked` is an error.
  Reactor* ForClient(Context* context, const absl::Status& checked,
                     std::function<absl::Status()> body);
  Reactor* ChangeStudy(Context* context, const v1::StudyRequest* request, v1::StudyStatus* reply,
                       StudyCall call);

  // coordinator_service.cc
  void EndReport(Reactor* reactor, v1::ReportReply* reply,
                 const absl::StatusOr<v1::ReportOutcome>& outcome, const char* if_ok);
  // Returns the kind of the result's job; null if it is unknown.
  const JobKind* KindOf(const v1::CompleteRequest& request) const;
  bool Admit(Reactor* reactor, v1::ReportReply* reply, const absl::Status& status,
             const std::string& coordinator_id);
  absl::Status CheckStore() const;  // OK unless the store is not there.
  bool IsForeign(const std::string& coordinator_id) const;
  void Enter();
  void Leave();

  JobQueue& queue_;
  Dispatcher& dispatcher_;
  const WaitReasons& waits_;
  TaskPool& worker_pool_;
  TaskPool& client_pool_;
  const AnnouncedStore store_;
  const std::string coordinator_id_;
  const Store* const outputs_;
  ContentKeeper* const content_;
  const NotifyHosts notify_hosts_;
  const StoreGuard* guard_ = nullptr;
  CallWatch watch_;  // Over streams that have not said hello.
  const WorkStreamContext streams_;

  ReportMeter meter_;

  std::mutex page_mu_;
  CoordinatorServer::PageOpener page_;  // Guarded by page_mu_.

  std::mutex mu_;
  std::condition_variable idle_;
  int calls_ = 0;  // Guarded by mu_: streams, and calls that are not over.
};

}  // namespace parallax
