#include "common/rpc/certificate.h"

#include <gmock/gmock.h>
#include <grpcpp/grpcpp.h>
#include <gtest/gtest.h>

#include "common/base/status.h"
#include "common/base/system/file.h"
#include "common/rpc/endpoint.h"
#include "common/rpc/grpc_status.h"
#include "parallax/v1/service.grpc.pb.h"
#include "tests/folder_test.h"

namespace parallax {
namespace {

using std::chrono::seconds;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr double kDay_s = 86400;

double Now() { return Clock::System().UnixSeconds(); }

CertificateOrder Order(const std::string& name, double now_s = Now(), double days = 10) {
  return {.name = name, .now_unix_s = now_s, .days = days};
}

std::string MessageOf(const absl::Status& status) { return std::string(status.message()); }

TEST(Certificate, SaysNameRoleHostsAndTimes) {
  const KeyPair ca = *MakeAuthority(Order("ca", Now(), 100));
  for (const Role role : kAllRoles) {
    const auto facts = ReadCertificate(IssueClient(ca, Order("ada.b-c_1"), role)->certificate_pem);
    ASSERT_TRUE(facts.ok()) << facts.status();
    EXPECT_EQ(facts->name, "ada.b-c_1");
    EXPECT_EQ(facts->role, role);
    EXPECT_TRUE(facts->hosts.empty());
    EXPECT_NEAR(facts->not_after_unix_s, Now() + 10 * kDay_s, 10);
    EXPECT_LT(facts->not_before_unix_s, Now());
  }
  const auto server =
      ReadCertificate(IssueServer(ca, Order("coordinator"), {"farm.example.org", "10.0.0.7", "::1"})
                          ->certificate_pem);
  EXPECT_FALSE(server->role.has_value());
  EXPECT_THAT(server->hosts, ElementsAre("farm.example.org", "10.0.0.7", "::1"));
}

TEST(Certificate, LivesNoLongerThanItsAuthority) {
  const KeyPair ca = *MakeAuthority(Order("ca", Now(), 5));
  const auto facts = ReadCertificate(IssueClient(ca, Order("a"), Role::kWorker)->certificate_pem);
  EXPECT_NEAR(facts->not_after_unix_s, Now() + 5 * kDay_s, 10);
  const KeyPair old = *MakeAuthority(Order("ca", Now() - 10 * kDay_s, 5));
  EXPECT_FALSE(IssueClient(old, Order("a"), Role::kWorker).ok());
}

TEST(Certificate, NamesAndHostsThatCouldAddEntriesAreRefused) {
  const KeyPair ca = *MakeAuthority(Order("ca"));
  for (const std::string name : {"", "a b", "a,DNS:b", "-a", "a/CN=root", "ä"}) {
    EXPECT_FALSE(IssueClient(ca, Order(name), Role::kWorker).ok()) << name;
  }
  EXPECT_FALSE(IssueClient(ca, Order(std::string(65, 'a')), Role::kWorker).ok());
  for (const std::string host : {"", "a b", "a,DNS:b", "-a", "a:7070", "*"}) {
    EXPECT_FALSE(IssueServer(ca, Order("s"), {host}).ok()) << host;
  }
  EXPECT_FALSE(IssueServer(ca, Order("s"), {}).ok());
}

TEST(Role, NamesGoThereAndBack) {
  for (const Role role : kAllRoles) EXPECT_EQ(ParseRole(RoleName(role)), role);
  EXPECT_FALSE(ParseRole("root").has_value());
}

class Answering final : public v1::Coordinator::Service {
 public:
  grpc::Status GetInfo(grpc::ServerContext* context, const v1::GetInfoRequest*,
                       v1::GetInfoReply* reply) override {
    reply->set_version(ActorOf(*context));
    return grpc::Status::OK;
  }
  grpc::Status ListWorkers(grpc::ServerContext*, const v1::ListWorkersRequest*,
                           v1::ListWorkersReply*) override {
    ++reached;
    return grpc::Status::OK;
  }
  int reached = 0;
};

// One authority, a server that shows what it is told to, and clients of all sorts.
class TlsTest : public FolderTest {
 protected:
  TlsTest() : ca_(*MakeAuthority(Order("ca", Now() - 20 * kDay_s, 100))) {}

  static std::shared_ptr<const TlsIdentity> Identity(const KeyPair& ca, const KeyPair& own) {
    auto identity = std::make_shared<TlsIdentity>();
    identity->dir = "tls-folder";
    identity->ca_pem = ca.certificate_pem;
    identity->own = own;
    return identity;
  }
  RpcSecurity Client(const KeyPair& ca, Role role = Role::kWorker) {
    return {.tls = Identity(ca, *IssueClient(ca, Order("ada"), role))};
  }
  RpcAddress Serve(const KeyPair& own, bool with_tls = true) {
    RpcSecurity security;
    if (with_tls) security.tls = Identity(ca_, own);
    auto server = RpcServer::Start({*ParseRpcAddress("127.0.0.1:0")}, security, {&service_},
                                   [](const RpcCaller& caller, std::string_view method) {
                                     if (method == "/parallax.v1.Coordinator/GetInfo")
                                       return absl::OkStatus();
                                     return PermissionDenied("not for {}", caller.name);
                                   });
    EXPECT_TRUE(server.ok()) << server.status();
    server_ = *std::move(server);
    return server_->addresses()[0];
  }
  RpcAddress ServeWell() { return Serve(*IssueServer(ca_, Order("s"), {"127.0.0.1"})); }

  static absl::StatusOr<std::string> Ask(const RpcAddress& address, const RpcSecurity& security) {
    ASSIGN_OR_RETURN(auto channel, ConnectRpc(address, security));
    auto coordinator = v1::Coordinator::NewStub(channel);
    grpc::ClientContext context;
    SetRpcTimeout(context, seconds(20));
    v1::GetInfoReply reply;
    RETURN_IF_ERROR(FromGrpc(coordinator->GetInfo(&context, {}, &reply)));
    return reply.version();
  }
  // The call fails, and this is why.
  static void ExpectRefusal(const RpcAddress& address, const RpcSecurity& security,
                            const std::string& why) {
    EXPECT_EQ(Ask(address, security).status().code(), absl::StatusCode::kUnavailable);
    const absl::Status explained = ExplainRpcSecurity(address, security);
    EXPECT_EQ(explained.code(), absl::StatusCode::kUnauthenticated);
    EXPECT_THAT(MessageOf(explained), HasSubstr(why));
    EXPECT_EQ(MessageOf(explained).find('\n'), std::string::npos);
  }

  const KeyPair ca_;
  Answering service_;
  std::unique_ptr<RpcServer> server_;
};

TEST_F(TlsTest, BothSidesKnowEachOther) {
  const RpcAddress address = ServeWell();
  const auto actor = Ask(address, Client(ca_, Role::kOperator));
  ASSERT_TRUE(actor.ok()) << actor.status();
  EXPECT_THAT(*actor, HasSubstr("operator ada ipv4:127.0.0.1:"));
  EXPECT_TRUE(ExplainRpcSecurity(address, Client(ca_)).ok());
}

TEST_F(TlsTest, TheGateIsAskedBeforeTheService) {
  auto coordinator = v1::Coordinator::NewStub(*ConnectRpc(ServeWell(), Client(ca_)));
  grpc::ClientContext context;
  SetRpcTimeout(context, seconds(20));
  v1::ListWorkersReply reply;
  const absl::Status status = FromGrpc(coordinator->ListWorkers(&context, {}, &reply));
  EXPECT_EQ(status, PermissionDenied("not for ada"));
  EXPECT_EQ(service_.reached, 0);
}

TEST_F(TlsTest, AClientWithoutTlsIsToldToUseIt) {
  ExpectRefusal(ServeWell(), {}, "speaks TLS; give --tls DIR");
}

TEST_F(TlsTest, AServerWithoutTlsIsToldApart) {
  const RpcAddress address = Serve({}, /*with_tls=*/false);
  ExpectRefusal(address, Client(ca_), "does not speak TLS");
  EXPECT_TRUE(ExplainRpcSecurity(address, {}).ok());
}

TEST_F(TlsTest, AnotherFarmsAuthorityIsToldApart) {
  const KeyPair other = *MakeAuthority(Order("other"));
  ExpectRefusal(ServeWell(), Client(other), "the authority in tls-folder/ca.crt did not sign");
}

TEST_F(TlsTest, AClientOfAnotherAuthorityIsRefusedByTheServer) {
  const KeyPair other = *MakeAuthority(Order("other"));
  const RpcSecurity forged = {
      .tls = Identity(ca_, *IssueClient(other, Order("mallory"), Role::kOperator))};
  ExpectRefusal(ServeWell(), forged, "refuses the certificate in tls-folder");
}

TEST_F(TlsTest, AnExpiredServerIsToldWithItsDate) {
  const double then_s = Now() - 10 * kDay_s;
  const RpcAddress address = Serve(*IssueServer(ca_, Order("s", then_s, 5), {"127.0.0.1"}));
  ExpectRefusal(address, Client(ca_), "expired on " + DateOf(then_s + 5 * kDay_s));
}

TEST_F(TlsTest, AnExpiredClientIsRefusedByTheServer) {
  const KeyPair own = *IssueClient(ca_, Order("ada", Now() - 10 * kDay_s, 5), Role::kWorker);
  ExpectRefusal(ServeWell(), {.tls = Identity(ca_, own)}, "refuses the certificate in tls-folder");
}

TEST_F(TlsTest, AWrongHostNameIsToldWithTheRightOnes) {
  const RpcAddress address = Serve(*IssueServer(ca_, Order("s"), {"farm.example.org", "10.1.2.3"}));
  ExpectRefusal(address, Client(ca_),
                "certificate for farm.example.org, 10.1.2.3 and not for 127.0.0.1");
}

TEST_F(TlsTest, AServersCertificateIsNoClients) {
  const RpcAddress address = ServeWell();
  const RpcSecurity server = {.tls = Identity(ca_, *IssueServer(ca_, Order("s"), {"localhost"}))};
  EXPECT_FALSE(Ask(address, server).ok());
  const RpcAddress fake = Serve(*IssueClient(ca_, Order("worker"), Role::kWorker));
  EXPECT_FALSE(Ask(fake, Client(ca_)).ok()) << "a worker must not pass for the coordinator";
}

TEST_F(TlsTest, NobodyThereNeedsNoExplanation) {
  const RpcAddress address = ServeWell();
  server_.reset();
  EXPECT_TRUE(ExplainRpcSecurity(address, Client(ca_)).ok());
}

TEST_F(TlsTest, TlsAllowsOtherMachinesAndExcludesInsecure) {
  EXPECT_TRUE(CheckRpcSecurity(*ParseRpcAddress("farm:1"), Client(ca_)).ok());
  EXPECT_THAT(MessageOf(CheckRpcSecurity(*ParseRpcAddress("farm:1"), {})), HasSubstr("--tls DIR"));
  EXPECT_FALSE(MakeRpcSecurity(true, "dir", Clock::System()).ok());
  EXPECT_EQ(MakeRpcSecurity(false, "", Clock::System())->tls, nullptr);
}

TEST_F(TlsTest, AFolderIsLoadedOnlyWhenItsPartsFit) {
  const auto load = [this] { return LoadTlsIdentity(dir_, Clock::System()); };
  const auto write = [this](const KeyPair& ca, const KeyPair& own) {
    ASSERT_TRUE(WriteFile(dir_ + "/ca.crt", ca.certificate_pem).ok());
    ASSERT_TRUE(WriteFile(dir_ + "/tls.crt", own.certificate_pem).ok());
    ASSERT_TRUE(WriteFile(dir_ + "/tls.key", own.key_pem).ok());
  };
  EXPECT_THAT(MessageOf(load().status()), HasSubstr("coordinator init DIR --issue ROLE NAME"));
  const KeyPair own = *IssueClient(ca_, Order("ada"), Role::kWorker);
  write(ca_, own);
  ASSERT_TRUE(load().ok()) << load().status();
  EXPECT_EQ((*load())->facts.name, "ada");

  write(ca_, {own.certificate_pem, IssueClient(ca_, Order("b"), Role::kWorker)->key_pem});
  EXPECT_THAT(MessageOf(load().status()), HasSubstr("tls.key is not the key of tls.crt"));
  write(*MakeAuthority(Order("other")), own);
  EXPECT_THAT(MessageOf(load().status()), HasSubstr("was not signed by the authority in ca.crt"));
  write(ca_, *IssueClient(ca_, Order("ada", Now() - 10 * kDay_s, 5), Role::kWorker));
  EXPECT_THAT(MessageOf(load().status()), HasSubstr("tls.crt expired on "));
  write(ca_, *IssueClient(ca_, Order("ada", Now() + kDay_s, 5), Role::kWorker));
  EXPECT_THAT(MessageOf(load().status()), HasSubstr("is not valid before "));
  write(ca_, {"nonsense", own.key_pem});
  EXPECT_THAT(MessageOf(load().status()), HasSubstr("tls.crt: not a certificate in PEM"));
}

}  // namespace
}  // namespace parallax
