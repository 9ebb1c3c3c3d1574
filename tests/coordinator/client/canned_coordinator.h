// A coordinator for tests of commands: answers from what the test has put in, remembers what it was
// told.
#pragma once

#include <grpcpp/grpcpp.h>
#include <gtest/gtest.h>

#include <memory>
#include <mutex>
#include <sstream>
#include <string>
#include <vector>

#include "common/rpc/address.h"
#include "common/rpc/endpoint.h"
#include "coordinator/client/app.h"
#include "parallax/v1/service.grpc.pb.h"

namespace parallax::client {

class FakeCoordinator : public v1::Coordinator::Service {
 public:
  FakeCoordinator() {
    auto server = RpcServer::Start({*ParseRpcAddress("127.0.0.1:0")}, RpcSecurity{}, *this);
    EXPECT_TRUE(server.ok()) << server.status();
    server_ = *std::move(server);
  }
  std::string address() const { return server_->addresses()[0].ToString(); }

  // Answers that a test prepares. GetStudy first calls `on_get_study`, so that time can pass.
  std::vector<v1::StudyStatus> studies;
  std::vector<v1::JobStatus> jobs;
  std::vector<v1::WorkerStatus> workers;
  std::vector<v1::PublishedFrame> frames;
  std::vector<v1::JobResult> results;
  std::vector<v1::AuditEntry> audit;
  std::vector<v1::DrainOrder> drains;
  std::vector<std::string> drained_workers;
  v1::ListAttemptsReply attempts;
  v1::ForgetReply forgotten;
  std::vector<v1::UserStatus> users;
  int studies_in_a_reply = 1000000;
  int jobs_in_a_reply = 1000000;  // More are cut.
  int job_lists = 0;              // Calls.
  v1::Scene scene;
  std::string store_uri = "s3://somewhere";
  bool submit_existed = false;
  std::vector<v1::WaitingJobs> unservable;  // Its answer to a submit.
  std::string page_url = "http://0.0.0.0:7080/#code=abc";
  int64_t retried_jobs = 0;
  grpc::Status study_status;  // GetStudy ends with it.
  std::function<void(FakeCoordinator&)> on_get_study = [](FakeCoordinator&) {};
  std::function<void(FakeCoordinator&)> on_list_attempts = [](FakeCoordinator&) {};

  // Requests that it has received.
  std::vector<v1::SubmitRequest> submitted;
  std::vector<std::string> orders;
  v1::ListJobsRequest listed_jobs;

  grpc::Status Submit(grpc::ServerContext*, const v1::SubmitRequest* request,
                      v1::SubmitReply* reply) override {
    std::lock_guard lock(mutex_);
    submitted.push_back(*request);
    reply->set_study_id(studies.empty() ? 1 : studies.back().study_id());
    reply->set_existed(submit_existed);
    *reply->mutable_unservable() = {unservable.begin(), unservable.end()};
    return grpc::Status::OK;
  }
  grpc::Status OpenPage(grpc::ServerContext*, const v1::OpenPageRequest*,
                        v1::OpenPageReply* reply) override {
    std::lock_guard lock(mutex_);
    reply->set_url(page_url);
    return grpc::Status::OK;
  }
  grpc::Status ListStudies(grpc::ServerContext*, const v1::ListStudiesRequest* request,
                           v1::ListStudiesReply* reply) override {
    std::lock_guard lock(mutex_);
    for (const auto& study : studies) {
      if (request->before() > 0 && study.study_id() >= request->before()) continue;
      if (reply->studies_size() < studies_in_a_reply) *reply->add_studies() = study;
    }
    return grpc::Status::OK;
  }
  grpc::Status GetStudy(grpc::ServerContext*, const v1::GetStudyRequest* request,
                        v1::StudyStatus* reply) override {
    std::lock_guard lock(mutex_);
    on_get_study(*this);
    if (!study_status.ok()) return study_status;
    return Find(request->study_id(), reply);
  }
  grpc::Status Cancel(grpc::ServerContext*, const v1::StudyRequest* request,
                      v1::StudyStatus* reply) override {
    return Order("cancel", *request, v1::STUDY_STATE_CANCELLED, reply);
  }
  grpc::Status Pause(grpc::ServerContext*, const v1::StudyRequest* request,
                     v1::StudyStatus* reply) override {
    return Order("pause", *request, v1::STUDY_STATE_PAUSED, reply);
  }
  grpc::Status Resume(grpc::ServerContext*, const v1::StudyRequest* request,
                      v1::StudyStatus* reply) override {
    return Order("resume", *request, v1::STUDY_STATE_RUNNING, reply);
  }
  grpc::Status Comment(grpc::ServerContext*, const v1::StudyRequest* request,
                       v1::StudyStatus* reply) override {
    std::lock_guard lock(mutex_);
    orders.push_back("comment " + std::to_string(request->study_id()));
    for (auto& study : studies) {
      if (study.study_id() != request->study_id()) continue;
      v1::StudyComment* comment = study.add_comments();
      comment->set_actor("submitter ada ipv4:10.0.0.7:4711");
      comment->set_text(request->reason());
      comment->set_unix_s(1.8e9);
    }
    return Find(request->study_id(), reply);
  }
  grpc::Status SetPriority(grpc::ServerContext*, const v1::SetPriorityRequest* request,
                           v1::StudyStatus* reply) override {
    std::lock_guard lock(mutex_);
    orders.push_back("priority " + std::to_string(request->study_id()) + " " +
                     std::to_string(request->priority()) + " " + request->reason());
    for (auto& study : studies) {
      if (study.study_id() == request->study_id()) study.set_priority(request->priority());
    }
    return Find(request->study_id(), reply);
  }
  grpc::Status RetryJob(grpc::ServerContext*, const v1::RetryJobRequest* request,
                        v1::RetryReply* reply) override {
    std::lock_guard lock(mutex_);
    orders.push_back("retry " + std::to_string(request->study_id()) + " job " +
                     std::to_string(request->job_id()) + " " + request->reason());
    reply->set_jobs(1);
    return grpc::Status::OK;
  }
  grpc::Status Retry(grpc::ServerContext*, const v1::StudyRequest* request,
                     v1::RetryReply* reply) override {
    std::lock_guard lock(mutex_);
    orders.push_back("retry " + std::to_string(request->study_id()) + " " + request->reason());
    reply->set_jobs(retried_jobs);
    return grpc::Status::OK;
  }
  grpc::Status Forget(grpc::ServerContext*, const v1::StudyRequest* request,
                      v1::ForgetReply* reply) override {
    std::lock_guard lock(mutex_);
    orders.push_back("forget " + std::to_string(request->study_id()) + " " + request->reason());
    *reply = forgotten;
    return grpc::Status::OK;
  }
  grpc::Status ListAttempts(grpc::ServerContext*, const v1::ListAttemptsRequest* request,
                            v1::ListAttemptsReply* reply) override {
    std::lock_guard lock(mutex_);
    on_list_attempts(*this);
    if (request->job_id() != attempts.job().job_id()) {
      return {grpc::StatusCode::NOT_FOUND, "job " + std::to_string(request->job_id())};
    }
    *reply = attempts;
    return grpc::Status::OK;
  }
  grpc::Status DrainWorkers(grpc::ServerContext*, const v1::DrainWorkersRequest* request,
                            v1::DrainWorkersReply* reply) override {
    std::lock_guard lock(mutex_);
    orders.push_back(std::string(request->undo() ? "undrain " : "drain ") + request->pattern() +
                     " " + request->reason());
    for (const std::string& name : drained_workers) reply->add_workers(name);
    return grpc::Status::OK;
  }
  grpc::Status SetMaxRunning(grpc::ServerContext*, const v1::SetMaxRunningRequest* request,
                             v1::StudyStatus* reply) override {
    std::lock_guard lock(mutex_);
    orders.push_back("limit " + std::to_string(request->study_id()) + " " +
                     std::to_string(request->max_running()) + " " + request->reason());
    for (auto& study : studies) {
      if (study.study_id() == request->study_id()) study.set_max_running(request->max_running());
    }
    return Find(request->study_id(), reply);
  }
  grpc::Status ListUsers(grpc::ServerContext*, const v1::ListUsersRequest*,
                         v1::ListUsersReply* reply) override {
    for (const auto& user : users) *reply->add_users() = user;
    return grpc::Status::OK;
  }
  grpc::Status ListJobs(grpc::ServerContext*, const v1::ListJobsRequest* request,
                        v1::ListJobsReply* reply) override {
    std::lock_guard lock(mutex_);
    listed_jobs = *request;
    ++job_lists;
    bool behind = request->after_job() == 0;
    for (const auto& job : jobs) {
      const int most = std::min(request->limit(), jobs_in_a_reply);
      const bool fits = reply->jobs_size() < most;
      if (behind && (request->state().empty() || request->state() == job.state())) {
        if (fits) *reply->add_jobs() = job;
        reply->set_cut(!fits && most < request->limit());
      }
      behind |= job.job_id() == request->after_job() && job.state() == request->after_state();
    }
    return grpc::Status::OK;
  }
  grpc::Status ListWorkers(grpc::ServerContext*, const v1::ListWorkersRequest*,
                           v1::ListWorkersReply* reply) override {
    for (const auto& worker : workers) *reply->add_workers() = worker;
    for (const auto& drain : drains) *reply->add_drains() = drain;
    return grpc::Status::OK;
  }
  grpc::Status ListFrames(grpc::ServerContext*, const v1::ListFramesRequest* request,
                          v1::ListFramesReply* reply) override {
    reply->set_store_uri(store_uri);
    for (const auto& frame : frames) {
      if (frame.cursor() > request->cursor()) *reply->add_frames() = frame;
    }
    return grpc::Status::OK;
  }
  grpc::Status ListResults(grpc::ServerContext*, const v1::ListResultsRequest* request,
                           v1::ListResultsReply* reply) override {
    for (const auto& result : results) {
      if (result.cursor() > request->cursor()) *reply->add_results() = result;
    }
    return grpc::Status::OK;
  }
  grpc::Status GetScene(grpc::ServerContext*, const v1::GetSceneRequest*,
                        v1::GetSceneReply* reply) override {
    *reply->mutable_scene() = scene;
    return grpc::Status::OK;
  }
  grpc::Status ListAudit(grpc::ServerContext*, const v1::ListAuditRequest* request,
                         v1::ListAuditReply* reply) override {
    for (const auto& entry : audit) {
      if (request->study_id() != 0 && entry.study_id() != request->study_id()) continue;
      *reply->add_entries() = entry;
    }
    return grpc::Status::OK;
  }
  grpc::Status GetInfo(grpc::ServerContext*, const v1::GetInfoRequest*,
                       v1::GetInfoReply* reply) override {
    reply->set_store_uri(store_uri);
    return grpc::Status::OK;
  }

 private:
  grpc::Status Find(int64_t id, v1::StudyStatus* reply) {
    for (const auto& study : studies) {
      if (study.study_id() != id) continue;
      *reply = study;
      return grpc::Status::OK;
    }
    return {grpc::StatusCode::NOT_FOUND, "no study " + std::to_string(id)};
  }
  grpc::Status Order(const std::string& name, const v1::StudyRequest& request, v1::StudyState state,
                     v1::StudyStatus* reply) {
    std::lock_guard lock(mutex_);
    orders.push_back(name + " " + std::to_string(request.study_id()) + " " + request.reason());
    for (auto& study : studies) {
      if (study.study_id() == request.study_id()) study.set_state(state);
    }
    return Find(request.study_id(), reply);
  }

  std::mutex mutex_;
  std::unique_ptr<RpcServer> server_;  // Last: it calls the rest until it is gone.
};

// Result of a command.
struct Outcome {
  int exit_code = -1;
  std::string out;
  std::string err;
};

// Runs a command as from a script: no terminal, no colours.
inline Outcome RunCommand(const std::vector<std::string>& arguments,
                          std::istream* answers = nullptr) {
  std::ostringstream out, err;
  Environment environment;
  environment.out.stream = &out;
  environment.err.stream = &err;
  environment.poll_s = 0.01;
  environment.plain_line_s = 0;
  environment.answers = answers;
  Outcome outcome;
  outcome.exit_code = RunClient(arguments, environment);
  outcome.out = out.str();
  outcome.err = err.str();
  return outcome;
}

}  // namespace parallax::client
