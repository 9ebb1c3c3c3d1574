// Every RPC with every role, against a real server with certificates. The rows are written down
// here once more, by hand: a new RPC without a row fails, and so does a rule that was changed
// without thinking of it.
#include "coordinator/rpc/access.h"

#include <gmock/gmock.h>
#include <google/protobuf/descriptor.h>
#include <grpcpp/generic/generic_stub.h>
#include <grpcpp/grpcpp.h>
#include <gtest/gtest.h>

#include <map>

#include "common/base/system/file.h"
#include "common/rpc/certificate.h"
#include "common/rpc/grpc_status.h"
#include "common/rpc/revocation.h"
#include "common/store/store.h"
#include "coordinator/queue/job_queue.h"
#include "coordinator/rpc/coordinator_server.h"
#include "parallax/v1/search.grpc.pb.h"
#include "parallax/v1/service.grpc.pb.h"
#include "parallax/v1/stream.grpc.pb.h"
#include "tests/coordinator/search/search_study.h"
#include "tests/folder_test.h"

namespace parallax {
namespace {

using std::chrono::seconds;
using ::testing::HasSubstr;

// w worker, s submitter, o operator, r read-only.
const std::map<std::string, std::string>& Rows() {
  static const auto* const rows = new std::map<std::string, std::string>{
      {"Coordinator/Work", "w"},
      {"Coordinator/Complete", "w"},
      {"Coordinator/Fail", "w"},
      {"Coordinator/Submit", "so"},
      {"Coordinator/ListStudies", "sor"},
      {"Coordinator/GetStudy", "sor"},
      {"Coordinator/Cancel", "so"},
      {"Coordinator/Pause", "so"},
      {"Coordinator/Resume", "so"},
      {"Coordinator/Retry", "so"},
      {"Coordinator/ListJobs", "sor"},
      {"Coordinator/ListWorkers", "sor"},
      {"Coordinator/ListFrames", "sor"},
      {"Coordinator/ListResults", "sor"},
      {"Coordinator/GetScene", "sor"},
      {"Coordinator/GetInfo", "wsor"},
      {"Coordinator/Forget", "so"},
      {"Coordinator/DrainWorkers", "o"},
      {"Coordinator/SetMaxRunning", "so"},
      {"Coordinator/SetPriority", "so"},
      {"Coordinator/RetryJob", "so"},
      {"Coordinator/ListUsers", "sor"},
      {"Coordinator/Comment", "so"},
      {"Coordinator/ListAttempts", "sor"},
      {"Coordinator/ListAudit", "o"},
      {"Coordinator/OpenPage", "sor"},
      {"Artifacts/Put", "wso"},
      {"Artifacts/Remove", "w"},
      {"Artifacts/Get", "wsor"},
      {"Artifacts/List", "wsor"},
      {"Streams/Open", "so"},
      {"Streams/Next", "so"},
      {"Streams/Close", "so"},
      {"Streams/List", "sor"},
      {"Searches/Open", "so"},
      {"Searches/Stop", "so"},
      {"Searches/List", "sor"},
  };
  return *rows;
}

// All methods of all services of the contract: "Coordinator/Work"...
std::vector<std::string> AllMethods() {
  std::vector<std::string> methods;
  for (const google::protobuf::FileDescriptor* file :
       {v1::Hello::descriptor()->file(), v1::StreamStatus::descriptor()->file(),
        v1::SearchStatus::descriptor()->file()}) {
    for (int i = 0; i < file->service_count(); ++i) {
      const google::protobuf::ServiceDescriptor* service = file->service(i);
      for (int j = 0; j < service->method_count(); ++j) {
        methods.push_back(service->name() + "/" + service->method(j)->name());
      }
    }
  }
  return methods;
}

class AccessTest : public FolderTest {
 protected:
  AccessTest() {
    store_ = *OpenStore(dir_ + "/store");
    ca_ = *MakeAuthority(Order("ca"));
    Start("");
  }
  void Start(const std::string& limits) {
    server_.reset();
    queue_.reset();
    JobQueueOptions queue;
    queue.db_path = dir_ + "/queue.db";
    queue.limits = *LimitRules::Parse(limits, "limits.yaml");
    queue_ = *JobQueue::Open(queue);
    CoordinatorServerOptions options;
    options.listen = {"127.0.0.1:0", "unix:" + dir_ + "/s"};
    options.security.tls = Identity(*IssueServer(ca_, Order("s"), {"127.0.0.1"}));
    options.revoked = dir_ + "/revoked";
    EXPECT_TRUE(WriteFile(options.revoked, kEmptyRevokedList).ok());
    options.store_uri = store_->Uri();
    options.store = store_.get();
    options.spool_dir = dir_ + "/spool";
    options.scorer = [](const ScoreQuery&) { return std::vector<TrialScore>(); };
    auto server = CoordinatorServer::Start(options, *queue_);
    EXPECT_TRUE(server.ok()) << server.status();
    server_ = *std::move(server);
  }
  ~AccessTest() override {
    server_.reset();
    queue_.reset();
  }

  static CertificateOrder Order(const std::string& name) {
    return {.name = name, .now_unix_s = Clock::System().UnixSeconds(), .days = 1};
  }
  std::shared_ptr<const TlsIdentity> Identity(const KeyPair& own) const {
    auto identity = std::make_shared<TlsIdentity>();
    identity->ca_pem = ca_.certificate_pem;
    identity->own = own;
    return identity;
  }
  std::shared_ptr<grpc::Channel> Channel(Role role, const std::string& name = "ada") const {
    return *ConnectRpc(*ParseRpcAddress(server_->addresses()[0]),
                       {.tls = Identity(*IssueClient(ca_, Order(name), role))});
  }
  std::shared_ptr<grpc::Channel> UnixChannel() const {
    return *ConnectRpc(*ParseRpcAddress(server_->addresses()[1]), {});
  }

  // Calls the method with an empty message and returns the answer's status.
  static absl::Status Call(const std::shared_ptr<grpc::Channel>& channel,
                           const std::string& method) {
    grpc::GenericStub stub(channel);
    grpc::ClientContext context;
    SetRpcTimeout(context, seconds(20));
    grpc::CompletionQueue queue;
    const auto next = [&queue] {
      void* tag = nullptr;
      bool ok = false;
      return queue.Next(&tag, &ok) && ok;
    };
    const auto call = stub.PrepareCall(&context, "/parallax.v1." + method, &queue);
    call->StartCall(nullptr);
    next();
    const grpc::Slice nothing;
    call->WriteLast(grpc::ByteBuffer(&nothing, 1), grpc::WriteOptions(), nullptr);
    next();
    grpc::ByteBuffer answer;
    do {
      call->Read(&answer, nullptr);
    } while (next());
    grpc::Status status;
    call->Finish(&status, nullptr);
    next();
    return FromGrpc(status);
  }

  absl::StatusOr<int64_t> Submit(v1::Coordinator::Stub& coordinator, const std::string& key,
                                 int priority = 0) const {
    v1::SubmitRequest request;
    v1::StudySpec& study = *request.mutable_study();
    study.set_name("s");
    study.set_seed(3);
    study.set_pairs(4);
    study.set_rigs_per_scene(2);
    study.set_priority(priority);
    study.add_variants()->set_name("v");
    study.mutable_variants(0)->mutable_config()->set_type(v1::SCENE_TYPE_INDOOR);
    study.mutable_variants(0)->mutable_config()->mutable_rigs()->set_count(2);
    request.set_idempotency_key(key);
    grpc::ClientContext context;
    SetRpcTimeout(context, seconds(20));
    v1::SubmitReply reply;
    RETURN_IF_ERROR(FromGrpc(coordinator.Submit(&context, request, &reply)));
    return reply.study_id();
  }

  static absl::StatusOr<v1::StreamStatus> OpenStream(v1::Streams::Stub& streams, int priority = 0) {
    v1::OpenStreamRequest open;
    v1::StudySpec& study = *open.mutable_study();
    study.set_name("s");
    study.set_pairs(4);
    study.set_rigs_per_scene(2);
    study.set_priority(priority);
    study.mutable_stream()->set_chunk_pairs(4);
    study.add_variants()->set_name("v");
    study.mutable_variants(0)->mutable_config()->set_type(v1::SCENE_TYPE_INDOOR);
    study.mutable_variants(0)->mutable_config()->mutable_rigs()->set_count(2);
    grpc::ClientContext context;
    SetRpcTimeout(context, seconds(20));
    v1::StreamStatus status;
    RETURN_IF_ERROR(FromGrpc(streams.Open(&context, open, &status)));
    return status;
  }

  std::unique_ptr<JobQueue> queue_;
  std::unique_ptr<Store> store_;
  KeyPair ca_;
  std::unique_ptr<CoordinatorServer> server_;
};

TEST_F(AccessTest, EveryRpcHasARowAndEveryRowAnRpc) {
  const std::vector<std::string> methods = AllMethods();
  EXPECT_GE(methods.size(), 20u);
  for (const std::string& method : methods) {
    EXPECT_TRUE(RolesOf("/parallax.v1." + method).has_value()) << method << " has no row";
    EXPECT_EQ(Rows().count(method), 1u) << method << " is not in this test";
  }
  EXPECT_EQ(Rows().size(), methods.size());
}

TEST_F(AccessTest, EveryRoleReachesItsRpcsAndNoOthers) {
  const std::map<Role, char> letters = {{Role::kWorker, 'w'},
                                        {Role::kSubmitter, 's'},
                                        {Role::kOperator, 'o'},
                                        {Role::kReadOnly, 'r'}};
  for (const auto& [role, letter] : letters) {
    const auto channel = Channel(role);
    for (const auto& [method, roles] : Rows()) {
      const absl::Status status = Call(channel, method);
      const bool refused = absl::IsPermissionDenied(status) &&
                           status.message().find("is for the role") != absl::string_view::npos;
      EXPECT_NE(status.code(), absl::StatusCode::kUnavailable) << status;
      EXPECT_NE(status.code(), absl::StatusCode::kUnimplemented) << method;
      EXPECT_EQ(refused, roles.find(letter) == std::string::npos)
          << method << " as " << RoleName(role) << ": " << status;
    }
  }
}

TEST_F(AccessTest, AnRpcWithoutARowIsRefusedToAll) {
  for (const Role role : kAllRoles) {
    EXPECT_TRUE(absl::IsPermissionDenied(Call(Channel(role), "Coordinator/Format")));
  }
}

TEST_F(AccessTest, TheMachinesOwnSocketHasAllRoles) {
  for (const auto& [method, roles] : Rows()) {
    EXPECT_FALSE(absl::IsPermissionDenied(Call(UnixChannel(), method))) << method;
  }
}

TEST_F(AccessTest, ARefusalSaysWhoMayAndWhatToAskFor) {
  const std::string message(Call(Channel(Role::kWorker, "pool"), "Coordinator/Submit").message());
  EXPECT_THAT(message, HasSubstr("Submit is for the role submitter or operator"));
  EXPECT_THAT(message, HasSubstr("'pool' has the role worker"));
  EXPECT_THAT(message, HasSubstr("coordinator init DIR --issue ROLE NAME"));
}

TEST_F(AccessTest, ASubmitterSteersItsOwnStudiesOnly) {
  const auto ada = v1::Coordinator::NewStub(Channel(Role::kSubmitter, "ada"));
  const auto study = Submit(*ada, "");
  ASSERT_TRUE(study.ok()) << study.status();
  const auto pause = [&](v1::Coordinator::Stub& who) {
    grpc::ClientContext context;
    SetRpcTimeout(context, seconds(20));
    v1::StudyRequest request;
    request.set_study_id(*study);
    v1::StudyStatus reply;
    return FromGrpc(who.Pause(&context, request, &reply));
  };
  const auto retry = [&](v1::Coordinator::Stub& who) {
    grpc::ClientContext context;
    SetRpcTimeout(context, seconds(20));
    v1::StudyRequest request;
    request.set_study_id(*study);
    v1::RetryReply reply;
    return FromGrpc(who.Retry(&context, request, &reply));
  };
  const auto bob = v1::Coordinator::NewStub(Channel(Role::kSubmitter, "bob"));
  EXPECT_THAT(std::string(pause(*bob).message()), HasSubstr("was not submitted by 'bob'"));
  EXPECT_TRUE(absl::IsPermissionDenied(retry(*bob)));
  EXPECT_TRUE(pause(*ada).ok());
  EXPECT_TRUE(pause(*v1::Coordinator::NewStub(Channel(Role::kOperator, "bob"))).ok());
}

TEST_F(AccessTest, ASubmitterTakesPairsOfItsOwnStreamsOnly) {
  const auto ada = v1::Streams::NewStub(Channel(Role::kSubmitter, "ada"));
  const absl::StatusOr<v1::StreamStatus> opened = OpenStream(*ada);
  ASSERT_TRUE(opened.ok()) << opened.status();
  EXPECT_THAT(opened->user(), HasSubstr("submitter ada"));

  const auto take = [&](v1::Streams::Stub& who) {
    grpc::ClientContext context;
    SetRpcTimeout(context, seconds(20));
    v1::NextPairsRequest request;
    request.set_stream("s");
    request.set_consumer("train");
    request.set_ranks(1);
    v1::NextPairsReply reply;
    return FromGrpc(who.Next(&context, request, &reply));
  };
  const auto close = [&](v1::Streams::Stub& who) {
    grpc::ClientContext context;
    SetRpcTimeout(context, seconds(20));
    v1::CloseStreamRequest request;
    request.set_name("s");
    v1::StreamStatus reply;
    return FromGrpc(who.Close(&context, request, &reply));
  };
  const auto bob = v1::Streams::NewStub(Channel(Role::kSubmitter, "bob"));
  EXPECT_THAT(std::string(take(*bob).message()), HasSubstr("was not begun by 'bob'"));
  EXPECT_TRUE(absl::IsPermissionDenied(close(*bob)));
  EXPECT_TRUE(take(*ada).ok());
  EXPECT_TRUE(take(*v1::Streams::NewStub(Channel(Role::kOperator, "olga"))).ok());
  EXPECT_TRUE(close(*ada).ok());
}

TEST_F(AccessTest, ASubmitterStopsAndGoesOnWithItsOwnSearchesOnly) {
  v1::SearchStatus status;
  const auto open = [&](v1::Searches::Stub& who, int trials) {
    v1::OpenSearchRequest request;
    *request.mutable_study() = SmallSearch(trials);
    grpc::ClientContext context;
    SetRpcTimeout(context, seconds(20));
    return FromGrpc(who.Open(&context, request, &status));
  };
  const auto ada = v1::Searches::NewStub(Channel(Role::kSubmitter, "ada"));
  const auto bob = v1::Searches::NewStub(Channel(Role::kSubmitter, "bob"));
  const absl::Status opened = open(*ada, 4);
  ASSERT_TRUE(opened.ok()) << opened;
  EXPECT_THAT(std::string(open(*bob, 8).message()), HasSubstr("the operator's to go on with"));
  EXPECT_TRUE(open(*ada, 8).ok());
  EXPECT_THAT(status.user(), HasSubstr("submitter ada"));
  const auto stop = [&](v1::Searches::Stub& who) {
    grpc::ClientContext context;
    SetRpcTimeout(context, seconds(20));
    v1::StopSearchRequest request;
    request.set_name("recipe");
    v1::SearchStatus reply;
    return FromGrpc(who.Stop(&context, request, &reply));
  };
  const absl::Status refused = stop(*bob);
  EXPECT_TRUE(absl::IsPermissionDenied(refused));
  EXPECT_THAT(std::string(refused.message()),
              HasSubstr("search \"recipe\" was not begun by 'bob'; others' are the operator's to "
                        "stop"));
  EXPECT_TRUE(stop(*ada).ok());
  EXPECT_TRUE(stop(*v1::Searches::NewStub(Channel(Role::kOperator, "olga"))).ok());
  // The studies are those of who opened it.
  EXPECT_THAT(*queue_->SubmitterOf(StudyId{1}), HasSubstr("submitter ada"));
}

TEST_F(AccessTest, LimitsAreToldAndRefuseByName) {
  Start("users: {submitter *: {max_studies: 1}}");
  const auto ada = v1::Coordinator::NewStub(Channel(Role::kSubmitter, "ada"));
  const auto bob = v1::Coordinator::NewStub(Channel(Role::kSubmitter, "bob"));
  const auto study = Submit(*ada, "one");
  ASSERT_TRUE(study.ok()) << study.status();
  const absl::Status refused = Submit(*ada, "two").status();
  EXPECT_TRUE(absl::IsFailedPrecondition(refused)) << refused;
  EXPECT_THAT(std::string(refused.message()),
              HasSubstr("submitter ada has 1 unfinished studies, 1 more would be over the limit "
                        "max_studies 1"));
  EXPECT_TRUE(Submit(*bob, "two").ok()) << "each has its own";

  const auto limit = [&](v1::Coordinator::Stub& who, int most) -> absl::StatusOr<int> {
    grpc::ClientContext context;
    SetRpcTimeout(context, seconds(20));
    v1::SetMaxRunningRequest request;
    request.set_study_id(*study);
    request.set_max_running(most);
    v1::StudyStatus reply;
    RETURN_IF_ERROR(FromGrpc(who.SetMaxRunning(&context, request, &reply)));
    return reply.max_running();
  };
  EXPECT_TRUE(absl::IsPermissionDenied(limit(*bob, 3).status())) << "not bob's";
  EXPECT_EQ(*limit(*ada, 3), 3);
  EXPECT_EQ(*limit(*v1::Coordinator::NewStub(Channel(Role::kOperator, "olga")), 2), 2);
  EXPECT_TRUE(absl::IsInvalidArgument(limit(*ada, -1).status()));

  grpc::ClientContext context;
  SetRpcTimeout(context, seconds(20));
  v1::ListUsersReply users;
  const auto board = v1::Coordinator::NewStub(Channel(Role::kReadOnly, "board"));
  ASSERT_TRUE(board->ListUsers(&context, {}, &users).ok());
  ASSERT_EQ(users.users_size(), 2);
  EXPECT_EQ(users.users(0).user(), "submitter ada");
  EXPECT_EQ(users.users(0).studies(), 1);
  EXPECT_EQ(users.users(0).waiting_pairs(), 4);
  EXPECT_EQ(users.users(0).max_studies(), 1);
  EXPECT_EQ(users.users(0).rule(), "submitter *");
}

TEST_F(AccessTest, ASubmitterRaisesItsOwnStudiesAndOnlySoFar) {
  const auto ada = v1::Coordinator::NewStub(Channel(Role::kSubmitter, "ada"));
  const auto bob = v1::Coordinator::NewStub(Channel(Role::kSubmitter, "bob"));
  const auto olga = v1::Coordinator::NewStub(Channel(Role::kOperator, "olga"));
  const auto study = Submit(*ada, "one");
  ASSERT_TRUE(study.ok()) << study.status();
  const auto raise = [&](v1::Coordinator::Stub& who, int priority) -> absl::StatusOr<int> {
    grpc::ClientContext context;
    SetRpcTimeout(context, seconds(20));
    v1::SetPriorityRequest request;
    request.set_study_id(*study);
    request.set_priority(priority);
    v1::StudyStatus reply;
    RETURN_IF_ERROR(FromGrpc(who.SetPriority(&context, request, &reply)));
    return reply.priority();
  };
  EXPECT_TRUE(absl::IsPermissionDenied(raise(*bob, 1).status())) << "not bob's";
  EXPECT_EQ(*raise(*ada, 100), 100);
  EXPECT_EQ(*raise(*ada, -1000), -1000);
  const absl::Status refused = raise(*ada, 101).status();
  EXPECT_TRUE(absl::IsPermissionDenied(refused)) << refused;
  EXPECT_THAT(std::string(refused.message()), HasSubstr("a submitter gives at most 100"));
  EXPECT_EQ(*raise(*olga, 1000), 1000);
  EXPECT_TRUE(absl::IsInvalidArgument(raise(*olga, 1001).status()));
  EXPECT_TRUE(absl::IsPermissionDenied(Submit(*ada, "high", 101).status())) << "nor at its submit";
  EXPECT_TRUE(Submit(*olga, "high", 101).ok());

  grpc::ClientContext context;
  SetRpcTimeout(context, seconds(20));
  v1::RetryJobRequest retry;
  retry.set_study_id(*study);
  retry.set_job_id(1);
  v1::RetryReply reply;
  const absl::Status not_bobs = FromGrpc(bob->RetryJob(&context, retry, &reply));
  EXPECT_THAT(std::string(not_bobs.message()), HasSubstr("was not submitted by 'bob'"));
}

TEST_F(AccessTest, AStreamOfASubmitterHasNoHigherPriorityThanItsStudies) {
  const auto ada = v1::Streams::NewStub(Channel(Role::kSubmitter, "ada"));
  const absl::Status refused = OpenStream(*ada, 101).status();
  EXPECT_TRUE(absl::IsPermissionDenied(refused)) << refused;
  EXPECT_THAT(std::string(refused.message()), HasSubstr("a submitter gives at most 100"));
  EXPECT_TRUE(OpenStream(*v1::Streams::NewStub(Channel(Role::kOperator, "olga")), 101).ok());
}

TEST_F(AccessTest, ACommentIsItsStudysAndSaysWhoseItIs) {
  const auto ada = v1::Coordinator::NewStub(Channel(Role::kSubmitter, "ada"));
  const auto study = Submit(*ada, "one");
  ASSERT_TRUE(study.ok()) << study.status();
  const auto comment = [&](Role role, const std::string& name,
                           const std::string& text) -> absl::StatusOr<v1::StudyStatus> {
    grpc::ClientContext context;
    SetRpcTimeout(context, seconds(20));
    v1::StudyRequest request;
    request.set_study_id(*study);
    request.set_reason(text);
    v1::StudyStatus reply;
    const auto who = v1::Coordinator::NewStub(Channel(role, name));
    RETURN_IF_ERROR(FromGrpc(who->Comment(&context, request, &reply)));
    return reply;
  };
  EXPECT_TRUE(absl::IsPermissionDenied(comment(Role::kSubmitter, "bob", "mine").status()));
  EXPECT_TRUE(comment(Role::kSubmitter, "ada", "for the rebuttal").ok());
  for (const std::string& bad :
       {std::string(), std::string(1001, 'x'), std::string("two\nlines")}) {
    EXPECT_TRUE(absl::IsInvalidArgument(comment(Role::kOperator, "olga", bad).status())) << bad;
  }
  const auto commented = comment(Role::kOperator, "olga", "not before Monday");
  ASSERT_TRUE(commented.ok()) << commented.status();
  ASSERT_EQ(commented->comments_size(), 2);
  EXPECT_EQ(commented->comments(0).text(), "not before Monday");
  EXPECT_THAT(commented->comments(0).actor(), HasSubstr("operator olga "));
  EXPECT_EQ(commented->comments(1).text(), "for the rebuttal");
  EXPECT_GT(commented->comments(1).unix_s(), 1.7e9);
}

TEST_F(AccessTest, TheAuditSaysWhoDidWhat) {
  const auto ada = v1::Coordinator::NewStub(Channel(Role::kSubmitter, "ada"));
  const int64_t study = *Submit(*ada, "");
  grpc::ClientContext context;
  SetRpcTimeout(context, seconds(20));
  v1::StudyRequest request;
  request.set_study_id(study);
  request.set_reason("enough");
  v1::StudyStatus status;
  ASSERT_TRUE(v1::Coordinator::NewStub(UnixChannel())->Cancel(&context, request, &status).ok());
  grpc::ClientContext again;
  SetRpcTimeout(again, seconds(20));
  v1::ListAuditReply audit;
  const auto olga = v1::Coordinator::NewStub(Channel(Role::kOperator, "olga"));
  ASSERT_TRUE(olga->ListAudit(&again, {}, &audit).ok());
  ASSERT_EQ(audit.entries_size(), 2);
  EXPECT_EQ(audit.entries(0).action(), "cancel");
  EXPECT_EQ(audit.entries(0).detail(), "enough");
  EXPECT_THAT(audit.entries(0).actor(), HasSubstr("unix:"));
  EXPECT_EQ(audit.entries(1).action(), "submit");
  EXPECT_EQ(audit.entries(1).study_id(), study);
  EXPECT_THAT(audit.entries(1).actor(), HasSubstr("submitter ada ipv4:127.0.0.1:"));

  v1::ListAuditRequest older;
  older.set_before(audit.entries(0).id());
  older.set_limit(1);
  EXPECT_EQ((*queue_->ListAudit(older))[0].action(), "submit");
}

TEST_F(AccessTest, ASubmitWhoseReplyWasLostMakesOneStudy) {
  const auto ada = v1::Coordinator::NewStub(Channel(Role::kSubmitter, "ada"));
  const int64_t first = *Submit(*ada, "once");  // Say that this answer never arrived.
  const auto ada_again = v1::Coordinator::NewStub(Channel(Role::kSubmitter, "ada"));
  EXPECT_EQ(*Submit(*ada_again, "once"), first);
  EXPECT_EQ(queue_->ListStudies(10)->size(), 1u);
  EXPECT_NE(*Submit(*ada, "twice"), first);
}

}  // namespace
}  // namespace parallax
