#include "coordinator/client/connection.h"

#include <fmt/core.h>
#include <grpcpp/grpcpp.h>

#include <algorithm>
#include <charconv>
#include <chrono>
#include <sstream>
#include <tuple>

#include "common/base/names.h"
#include "common/base/shell_word.h"
#include "common/rpc/address.h"
#include "common/rpc/endpoint.h"
#include "common/rpc/message_texts.h"
#include "common/rpc/remote_store.h"
#include "coordinator/client/views/text.h"
#include "parallax/v1/search.grpc.pb.h"
#include "parallax/v1/service.grpc.pb.h"
#include "parallax/v1/stream.grpc.pb.h"

namespace parallax::client {
namespace {

constexpr std::chrono::seconds kTimeout{20};
// Over a Unix socket nothing is lost on the way, but the machine may be busy: that of `run`
// renders.
constexpr std::chrono::seconds kTimeoutOnThisMachine{120};
// How long a call waits for a coordinator that an earlier one did not reach.
constexpr std::chrono::seconds kTimeToReconnect{1};
constexpr int kDefaultStudies = 100;
constexpr int kDefaultAuditEntries = 100;
constexpr int kDefaultJobs = 1000;
constexpr int kJobsAtOnce = 5000;

// gRPC's own words name sockets and addresses several times over; the cause is the part people
// know.
std::string CauseOf(const std::string& message) {
  for (const char* cause : {"Connection refused", "No such file or directory", "No route to host",
                            "Network is unreachable", "Permission denied", "Connection reset"}) {
    if (message.find(cause) != std::string::npos) return cause;
  }
  if (message.find("DNS resolution failed") != std::string::npos) return "unknown host";
  return Printable(FirstLine(message));
}

// An error of several lines keeps them.
std::string PrintableLines(const std::string& message) {
  std::string lines;
  std::istringstream stream(message);
  for (std::string line; std::getline(stream, line);) {
    lines += (lines.empty() ? "" : "\n") + Printable(line);
  }
  return lines;
}

// "12 (table1), 11 (baseline)..." for a message.
std::string SomeOf(const v1::ListStudiesReply& list) {
  constexpr int kShown = 5;
  std::string known;
  const int shown = std::min(list.studies_size(), kShown);
  for (int i = 0; i < shown; ++i) {
    known += fmt::format("{}{} ({})", i > 0 ? ", " : "", list.studies(i).study_id(),
                         list.studies(i).name());
  }
  return list.studies_size() > shown ? known + "..." : known;
}

// A coordinator can't read a message with a text that is not UTF-8.
template <typename Request>
absl::Status CheckTexts(const Request& request) {
  absl::Status status;
  Request copy = request;
  ChangeTexts(&copy, [&](const std::string& field, std::string* text) {
    if (status.ok() && !IsUtf8(*text)) {
      status = InvalidArgument("{} {} is not UTF-8", field, Quoted(*text));
    }
  });
  return status;
}

}  // namespace

struct Connection::Stub {
  std::shared_ptr<grpc::Channel> channel;
  std::tuple<std::unique_ptr<v1::Coordinator::Stub>, std::unique_ptr<v1::Streams::Stub>,
             std::unique_ptr<v1::Searches::Stub>>
      services;
};

Connection::Connection(RpcAddress address, RpcSecurity security, std::unique_ptr<Stub> stub)
    : where_(std::move(address)),
      security_(std::move(security)),
      address_(where_.ToString()),
      stub_(std::move(stub)) {}
Connection::~Connection() = default;

absl::StatusOr<std::unique_ptr<Connection>> Connection::Open(const std::string& address,
                                                             const RpcSecurity& security) {
  ASSIGN_OR_RETURN(const RpcAddress parsed, ParseRpcAddress(address));
  auto stub = std::make_unique<Stub>();
  ASSIGN_OR_RETURN(stub->channel, ConnectRpc(parsed, security));
  stub->services = {v1::Coordinator::NewStub(stub->channel), v1::Streams::NewStub(stub->channel),
                    v1::Searches::NewStub(stub->channel)};
  return std::unique_ptr<Connection>(new Connection(parsed, security, std::move(stub)));
}

template <typename Service, typename Request, typename Reply>
absl::StatusOr<Reply> Connection::Call(grpc::Status (Service::*method)(grpc::ClientContext*,
                                                                       const Request&, Reply*),
                                       const std::type_identity_t<Request>& request,
                                       double more_s) {
  RETURN_IF_ERROR(CheckTexts(request));
  AwaitRpc(*stub_->channel, kTimeToReconnect);
  grpc::ClientContext context;
  const std::chrono::duration<double> timeout =
      (where_.is_unix() ? kTimeoutOnThisMachine : kTimeout) + std::chrono::duration<double>(more_s);
  SetRpcTimeout(context, timeout);
  Reply reply;
  const grpc::Status status =
      (*std::get<std::unique_ptr<Service>>(stub_->services).*method)(&context, request, &reply);
  if (status.ok()) {
    // Names and errors are printed, and may be those of an earlier version's database. Only errors
    // and logs have more than one line.
    ChangeTexts(&reply, [](const std::string& field, std::string* text) {
      const bool has_lines = field == "error" || field == "detail" || field == "log_tail";
      *text = has_lines ? PrintableLines(*text) : Printable(*text);
    });
    return reply;
  }
  if (status.error_code() == grpc::StatusCode::UNAVAILABLE) {
    RETURN_IF_ERROR(ExplainRpcSecurity(where_, security_));
    return Unavailable(
        "no coordinator at {}: {}; start one with `coordinator serve --db FILE --store DIR "
        "--listen {}`, or name another with --coordinator HOST:PORT",
        address_, CauseOf(status.error_message()), ShellWord(address_));
  }
  if (status.error_code() == grpc::StatusCode::DEADLINE_EXCEEDED) {
    return Unavailable("the coordinator at {} did not answer within {}", address_,
                       FormatDuration(timeout.count()));
  }
  // No call is cancelled here; a coordinator that stops does so with those that it has not
  // answered.
  if (status.error_code() == grpc::StatusCode::CANCELLED) {
    return Unavailable("the coordinator at {} stopped before it had answered", address_);
  }
  if (status.error_code() == grpc::StatusCode::UNIMPLEMENTED) {
    return Internal("what answers at {} is not a Parallax coordinator of this version", address_);
  }
  return MakeError(static_cast<absl::StatusCode>(status.error_code()),
                   PrintableLines(status.error_message()));
}

absl::StatusOr<v1::SubmitReply> Connection::Submit(const v1::SubmitRequest& request) {
  return Call(&v1::Coordinator::Stub::Submit, request);
}

absl::StatusOr<v1::ListStudiesReply> Connection::StudiesBefore(int64_t before, int limit) {
  v1::ListStudiesRequest request;
  request.set_before(before);
  request.set_limit(limit);
  ASSIGN_OR_RETURN(v1::ListStudiesReply page, Call(&v1::Coordinator::Stub::ListStudies, request));
  // An earlier coordinator knows no `before` and begins anew.
  if (before > 0 && !page.studies().empty() && page.studies(0).study_id() >= before) {
    page.clear_studies();
  }
  return page;
}

absl::StatusOr<v1::ListStudiesReply> Connection::ListStudies(int limit) {
  const int wanted = limit > 0 ? limit : kDefaultStudies;
  v1::ListStudiesReply all;
  int64_t before = 0;
  while (all.studies_size() < wanted) {
    ASSIGN_OR_RETURN(const v1::ListStudiesReply page,
                     StudiesBefore(before, wanted - all.studies_size()));
    if (page.studies().empty()) break;
    before = page.studies(page.studies_size() - 1).study_id();
    all.mutable_studies()->MergeFrom(page.studies());
  }
  return all;
}

absl::StatusOr<v1::StudyStatus> Connection::GetStudy(int64_t study_id) {
  v1::GetStudyRequest request;
  request.set_study_id(study_id);
  return Call(&v1::Coordinator::Stub::GetStudy, request);
}

namespace {
v1::StudyRequest MakeStudyRequest(int64_t study_id, const std::string& reason) {
  v1::StudyRequest request;
  request.set_study_id(study_id);
  request.set_reason(reason);
  return request;
}
}  // namespace

absl::StatusOr<v1::StudyStatus> Connection::Cancel(int64_t study_id, const std::string& reason) {
  return Call(&v1::Coordinator::Stub::Cancel, MakeStudyRequest(study_id, reason));
}

absl::StatusOr<v1::StudyStatus> Connection::Pause(int64_t study_id, const std::string& reason) {
  return Call(&v1::Coordinator::Stub::Pause, MakeStudyRequest(study_id, reason));
}

absl::StatusOr<v1::StudyStatus> Connection::Resume(int64_t study_id, const std::string& reason) {
  return Call(&v1::Coordinator::Stub::Resume, MakeStudyRequest(study_id, reason));
}

absl::StatusOr<v1::StudyStatus> Connection::Comment(int64_t study_id, const std::string& text) {
  return Call(&v1::Coordinator::Stub::Comment, MakeStudyRequest(study_id, text));
}

absl::StatusOr<v1::RetryReply> Connection::Retry(int64_t study_id, const std::string& reason) {
  return Call(&v1::Coordinator::Stub::Retry, MakeStudyRequest(study_id, reason));
}

absl::StatusOr<v1::ForgetReply> Connection::Forget(int64_t study_id, const std::string& reason) {
  return Call(&v1::Coordinator::Stub::Forget, MakeStudyRequest(study_id, reason));
}

absl::StatusOr<v1::ListAttemptsReply> Connection::ListAttempts(int64_t job_id) {
  v1::ListAttemptsRequest request;
  request.set_job_id(job_id);
  return Call(&v1::Coordinator::Stub::ListAttempts, request);
}

absl::StatusOr<v1::DrainWorkersReply> Connection::DrainWorkers(
    const v1::DrainWorkersRequest& request) {
  return Call(&v1::Coordinator::Stub::DrainWorkers, request);
}

absl::StatusOr<v1::ListJobsReply> Connection::ListJobs(v1::ListJobsRequest request) {
  const int wanted = request.limit() > 0 ? request.limit() : kDefaultJobs;
  v1::ListJobsReply all;
  while (all.jobs_size() < wanted) {
    const int asked = std::min(wanted - all.jobs_size(), kJobsAtOnce);
    request.set_limit(asked);
    ASSIGN_OR_RETURN(const v1::ListJobsReply page, Call(&v1::Coordinator::Stub::ListJobs, request));
    // An earlier coordinator knows no `after_job` and begins anew.
    if (page.jobs().empty() ||
        (!all.jobs().empty() && page.jobs(0).job_id() == all.jobs(0).job_id())) {
      break;
    }
    const v1::JobStatus& last = page.jobs(page.jobs_size() - 1);
    request.set_after_job(last.job_id());
    request.set_after_state(last.state());
    all.mutable_jobs()->MergeFrom(page.jobs());
    if (page.jobs_size() < asked && !page.cut()) break;
  }
  return all;
}

absl::StatusOr<v1::StudyStatus> Connection::SetMaxRunning(const v1::SetMaxRunningRequest& request) {
  return Call(&v1::Coordinator::Stub::SetMaxRunning, request);
}

absl::StatusOr<v1::StudyStatus> Connection::SetPriority(const v1::SetPriorityRequest& request) {
  return Call(&v1::Coordinator::Stub::SetPriority, request);
}

absl::StatusOr<v1::RetryReply> Connection::RetryJob(const v1::RetryJobRequest& request) {
  return Call(&v1::Coordinator::Stub::RetryJob, request);
}

absl::StatusOr<v1::ListUsersReply> Connection::ListUsers() {
  return Call(&v1::Coordinator::Stub::ListUsers, {});
}

absl::StatusOr<std::string> Connection::OpenPage() {
  ASSIGN_OR_RETURN(v1::OpenPageReply reply, Call(&v1::Coordinator::Stub::OpenPage, {}));
  return std::move(*reply.mutable_url());
}

absl::StatusOr<v1::ListWorkersReply> Connection::ListWorkers() {
  return Call(&v1::Coordinator::Stub::ListWorkers, {});
}

absl::StatusOr<v1::ListFramesReply> Connection::ListFrames(int64_t study_id, int64_t cursor,
                                                           int limit) {
  v1::ListFramesRequest request;
  request.set_study_id(study_id);
  request.set_cursor(cursor);
  request.set_limit(limit);
  return Call(&v1::Coordinator::Stub::ListFrames, request);
}

absl::StatusOr<v1::ListResultsReply> Connection::ListResults(int64_t study_id, int64_t cursor,
                                                             int limit) {
  v1::ListResultsRequest request;
  request.set_study_id(study_id);
  request.set_cursor(cursor);
  request.set_limit(limit);
  return Call(&v1::Coordinator::Stub::ListResults, request);
}

absl::StatusOr<v1::GetSceneReply> Connection::GetScene(int64_t study_id, const std::string& variant,
                                                       uint32_t scene) {
  v1::GetSceneRequest request;
  request.set_study_id(study_id);
  request.set_variant(variant);
  request.set_scene(scene);
  return Call(&v1::Coordinator::Stub::GetScene, request);
}

absl::StatusOr<v1::GetInfoReply> Connection::GetInfo() {
  return Call(&v1::Coordinator::Stub::GetInfo, {});
}

absl::StatusOr<v1::ListAuditReply> Connection::ListAudit(v1::ListAuditRequest request) {
  const int wanted = request.limit() > 0 ? request.limit() : kDefaultAuditEntries;
  v1::ListAuditReply all;
  while (all.entries_size() < wanted) {
    request.set_limit(wanted - all.entries_size());
    ASSIGN_OR_RETURN(const v1::ListAuditReply page,
                     Call(&v1::Coordinator::Stub::ListAudit, request));
    if (page.entries().empty() ||
        (request.before() > 0 && page.entries(0).id() >= request.before())) {
      break;
    }
    request.set_before(page.entries(page.entries_size() - 1).id());
    all.mutable_entries()->MergeFrom(page.entries());
  }
  return all;
}

absl::StatusOr<v1::StreamStatus> Connection::OpenStream(const v1::StudySpec& study) {
  v1::OpenStreamRequest request;
  *request.mutable_study() = study;
  return Call(&v1::Streams::Stub::Open, request);
}

absl::StatusOr<v1::ListStreamsReply> Connection::ListStreams(const std::string& name) {
  v1::ListStreamsRequest request;
  request.set_name(name);
  return Call(&v1::Streams::Stub::List, request);
}

absl::StatusOr<v1::StreamStatus> Connection::CloseStream(const std::string& name,
                                                         const std::string& reason) {
  v1::CloseStreamRequest request;
  request.set_name(name);
  request.set_reason(reason);
  return Call(&v1::Streams::Stub::Close, request);
}

absl::StatusOr<v1::NextPairsReply> Connection::NextPairs(const v1::NextPairsRequest& request) {
  return Call(&v1::Streams::Stub::Next, request, request.wait_s());
}

absl::StatusOr<v1::SearchStatus> Connection::OpenSearch(const v1::StudySpec& study) {
  v1::OpenSearchRequest request;
  *request.mutable_study() = study;
  return Call(&v1::Searches::Stub::Open, request);
}

absl::StatusOr<v1::ListSearchesReply> Connection::ListSearches(const std::string& name) {
  v1::ListSearchesRequest request;
  request.set_name(name);
  return Call(&v1::Searches::Stub::List, request);
}

absl::StatusOr<v1::SearchStatus> Connection::StopSearch(const std::string& name, bool forget) {
  v1::StopSearchRequest request;
  request.set_name(name);
  request.set_forget(forget);
  return Call(&v1::Searches::Stub::Stop, request);
}

std::unique_ptr<Store> Connection::RemoteStore() const {
  return MakeRemoteStore(stub_->channel, {.worker = "client", .attempt = {}});
}

absl::StatusOr<v1::StudyStatus> Connection::FindStudy(const std::string& id_or_name) {
  int64_t id = 0;
  const char* end = id_or_name.data() + id_or_name.size();
  const auto [at, error] = std::from_chars(id_or_name.data(), end, id);
  if (error == std::errc() && at == end) {
    absl::StatusOr<v1::StudyStatus> study = GetStudy(id);
    if (!absl::IsNotFound(study.status())) return study;
  }
  std::string known;
  for (int64_t before = 0;;) {
    ASSIGN_OR_RETURN(const v1::ListStudiesReply list, StudiesBefore(before, kDefaultStudies));
    if (list.studies().empty()) break;
    if (before == 0) known = SomeOf(list);
    before = list.studies(list.studies_size() - 1).study_id();
    int64_t newest = 0;
    for (const v1::StudyStatus& study : list.studies()) {
      if (study.name() == id_or_name) newest = std::max(newest, study.study_id());
    }
    // Only GetStudy gives the whole status.
    if (newest != 0) return GetStudy(newest);
  }
  return NotFound("no study '{}' at {}{}", id_or_name, address_,
                  known.empty() ? "; nothing has been submitted there" : "; there are " + known);
}

}  // namespace parallax::client
