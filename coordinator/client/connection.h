// The client's side of the service `parallax.v1.Coordinator`. Every call has a deadline, and every
// error is a sentence for the user.
//
// Thread-safe.
#pragma once

#include <memory>
#include <string>
#include <type_traits>

#include "common/base/status.h"
#include "common/rpc/endpoint.h"
#include "parallax/v1/search.pb.h"
#include "parallax/v1/service.pb.h"
#include "parallax/v1/stream.pb.h"

namespace grpc {
class ClientContext;
class Status;
}  // namespace grpc

namespace parallax {
class Store;
}

namespace parallax::client {

inline constexpr char kDefaultCoordinator[] = "127.0.0.1:7070";

class Connection {
 public:
  // Makes a connection without connecting yet: the first call shows whether somebody listens.
  // Errors: kInvalidArgument for a bad address; kFailedPrecondition for one that needs TLS or
  // `insecure`.
  static absl::StatusOr<std::unique_ptr<Connection>> Open(const std::string& address,
                                                          const RpcSecurity& security = {});
  ~Connection();

  const std::string& address() const { return address_; }

  // The RPCs of the service; see service.proto. Texts of replies are made printable
  // (common/base/names.h). Long lists are fetched in several calls.
  // Errors of all: kInvalidArgument for a text that is not UTF-8; kUnavailable if there
  // is no coordinator, with how to start one, or if it stops or does not answer in time; else the
  // coordinator's own.
  absl::StatusOr<v1::SubmitReply> Submit(const v1::SubmitRequest& request);
  absl::StatusOr<v1::ListStudiesReply> ListStudies(int limit = 0);
  absl::StatusOr<v1::StudyStatus> GetStudy(int64_t study_id);
  absl::StatusOr<v1::StudyStatus> Cancel(int64_t study_id, const std::string& reason);
  absl::StatusOr<v1::StudyStatus> Pause(int64_t study_id, const std::string& reason);
  absl::StatusOr<v1::StudyStatus> Resume(int64_t study_id, const std::string& reason);
  absl::StatusOr<v1::RetryReply> Retry(int64_t study_id, const std::string& reason = "");
  absl::StatusOr<v1::ForgetReply> Forget(int64_t study_id, const std::string& reason);
  absl::StatusOr<v1::StudyStatus> Comment(int64_t study_id, const std::string& text);
  // Errors: as all.
  absl::StatusOr<v1::StudyStatus> SetMaxRunning(const v1::SetMaxRunningRequest& request);
  absl::StatusOr<v1::StudyStatus> SetPriority(const v1::SetPriorityRequest& request);
  absl::StatusOr<v1::RetryReply> RetryJob(const v1::RetryJobRequest& request);
  // Errors: as all.
  absl::StatusOr<v1::ListUsersReply> ListUsers();
  absl::StatusOr<v1::ListAttemptsReply> ListAttempts(int64_t job_id);
  absl::StatusOr<v1::DrainWorkersReply> DrainWorkers(const v1::DrainWorkersRequest& request);
  // Lists at most request.limit() jobs; 0: 1,000. Errors: those of every RPC.
  absl::StatusOr<v1::ListJobsReply> ListJobs(v1::ListJobsRequest request);
  absl::StatusOr<v1::ListWorkersReply> ListWorkers();
  // Returns a link to the web page that opens one session with the caller's rights. Errors:
  // kFailedPrecondition if the coordinator serves no page; those of every RPC.
  absl::StatusOr<std::string> OpenPage();
  absl::StatusOr<v1::ListFramesReply> ListFrames(int64_t study_id, int64_t cursor, int limit);
  absl::StatusOr<v1::ListResultsReply> ListResults(int64_t study_id, int64_t cursor, int limit);
  absl::StatusOr<v1::GetSceneReply> GetScene(int64_t study_id, const std::string& variant,
                                             uint32_t scene);
  absl::StatusOr<v1::GetInfoReply> GetInfo();
  absl::StatusOr<v1::ListAuditReply> ListAudit(v1::ListAuditRequest request);

  // The RPCs of the service Streams; see stream.proto. Errors: as all; kAlreadyExists for the name
  // of a stream with another study.
  absl::StatusOr<v1::StreamStatus> OpenStream(const v1::StudySpec& study);
  // Errors: as all; kNotFound for an unknown name. An empty one lists all.
  absl::StatusOr<v1::ListStreamsReply> ListStreams(const std::string& name);
  // Errors: as all; kNotFound.
  absl::StatusOr<v1::StreamStatus> CloseStream(const std::string& name, const std::string& reason);
  // Errors: as all; kNotFound; kOutOfRange for a position whose pairs are forgotten.
  absl::StatusOr<v1::NextPairsReply> NextPairs(const v1::NextPairsRequest& request);

  // The RPCs of the service Searches; see search.proto. Errors: as all; kAlreadyExists for the name
  // of a search with another study.
  absl::StatusOr<v1::SearchStatus> OpenSearch(const v1::StudySpec& study);
  // Errors: as all; kNotFound for an unknown name. An empty one lists all, without trials.
  absl::StatusOr<v1::ListSearchesReply> ListSearches(const std::string& name);
  // Errors: as all; kNotFound.
  absl::StatusOr<v1::SearchStatus> StopSearch(const std::string& name, bool forget);

  // Returns the coordinator's store, reached through the coordinator, for machines that do not see
  // it. It can be read, and takes the user's content.
  std::unique_ptr<Store> RemoteStore() const;

  // Returns the study that a user means by "12" or "baseline": an id, or the newest study of that
  // name. Errors: kNotFound that names the existing studies.
  absl::StatusOr<v1::StudyStatus> FindStudy(const std::string& id_or_name);

 private:
  struct Stub;
  Connection(RpcAddress address, RpcSecurity security, std::unique_ptr<Stub> stub);
  // Returns at most `limit` studies with ids below `before` (0: any), the newest first; the
  // coordinator may give fewer. Errors: as all.
  absl::StatusOr<v1::ListStudiesReply> StudiesBefore(int64_t before, int limit);
  // Calls a method of the service's stub, which may take `more_s` longer than others.
  template <typename Service, typename Request, typename Reply>
  absl::StatusOr<Reply> Call(grpc::Status (Service::*method)(grpc::ClientContext*, const Request&,
                                                             Reply*),
                             const std::type_identity_t<Request>& request, double more_s = 0);

  const RpcAddress where_;
  const RpcSecurity security_;
  const std::string address_;
  std::unique_ptr<Stub> stub_;
};

}  // namespace parallax::client
