#include "common/rpc/endpoint.h"

#include <grpcpp/grpcpp.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include "common/base/status.h"
#include "common/rpc/grpc_status.h"
#include "parallax/v1/service.grpc.pb.h"
#include "tests/folder_test.h"

namespace parallax {
namespace {

using std::chrono::seconds;

class EchoVersion final : public v1::Coordinator::Service {
 public:
  grpc::Status GetInfo(grpc::ServerContext*, const v1::GetInfoRequest*,
                       v1::GetInfoReply* reply) override {
    reply->set_version("echo");
    return grpc::Status::OK;
  }
  grpc::Status GetScene(grpc::ServerContext*, const v1::GetSceneRequest*,
                        v1::GetSceneReply* reply) override {
    reply->mutable_scene()->set_generator_version(std::string(kMaxRpcMessageBytes + 1, 'x'));
    return grpc::Status::OK;
  }
};

class EndpointTest : public FolderTest {
 protected:
  RpcAddress Parse(const std::string& text) { return *ParseRpcAddress(text); }
  absl::StatusOr<std::unique_ptr<RpcServer>> Listen(const std::string& text) {
    return RpcServer::Start({Parse(text)}, {}, service_);
  }
  absl::StatusOr<std::string> Ask(const RpcAddress& address) {
    ASSIGN_OR_RETURN(auto channel, ConnectRpc(address, {}));
    auto coordinator = v1::Coordinator::NewStub(channel);
    grpc::ClientContext context;
    SetRpcTimeout(context, seconds(10));
    v1::GetInfoReply reply;
    RETURN_IF_ERROR(FromGrpc(coordinator->GetInfo(&context, {}, &reply)));
    return reply.version();
  }

  EchoVersion service_;
};

TEST_F(EndpointTest, CallsTravelOverTcpAndUnixSocketsOfOneServer) {
  const std::string socket = "unix:" + dir_ + "/s";
  auto server = RpcServer::Start({Parse("127.0.0.1:0"), Parse(socket)}, {}, service_);
  ASSERT_TRUE(server.ok()) << server.status();
  ASSERT_NE((*server)->addresses()[0].port, 0);
  for (const RpcAddress& address : (*server)->addresses()) {
    const auto answer = Ask(address);
    ASSERT_TRUE(answer.ok()) << address.ToString() << " " << answer.status();
    EXPECT_EQ(*answer, "echo");
  }
  struct stat entry;
  ASSERT_EQ(stat((dir_ + "/s").c_str(), &entry), 0);
  EXPECT_EQ(entry.st_mode & 0777, 0600u) << "others must not reach the socket";
}

TEST_F(EndpointTest, AnAddressInUseIsNamed) {
  auto first = Listen("127.0.0.1:0");
  ASSERT_TRUE(first.ok()) << first.status();
  const std::string address = (*first)->addresses()[0].ToString();
  const auto second = Listen(address);
  ASSERT_FALSE(second.ok());
  EXPECT_EQ(second.status().code(), absl::StatusCode::kAlreadyExists) << second.status();
  EXPECT_NE(second.status().ToString().find(address), std::string::npos) << second.status();
}

TEST_F(EndpointTest, AUnixSocketThatIsServedIsNotTakenAway) {
  const std::string address = "unix:" + dir_ + "/s";
  auto first = Listen(address);
  ASSERT_TRUE(first.ok()) << first.status();
  const auto second = Listen(address);
  EXPECT_EQ(second.status().code(), absl::StatusCode::kAlreadyExists) << second.status();
  EXPECT_TRUE(Ask((*first)->addresses()[0]).ok());
}

TEST_F(EndpointTest, AUnixSocketLeftByADeadServerIsReplaced) {
  const std::string address = "unix:" + dir_ + "/s";
  ASSERT_TRUE(Listen(address).ok());
  auto again = Listen(address);
  ASSERT_TRUE(again.ok()) << again.status();
  EXPECT_TRUE(Ask((*again)->addresses()[0]).ok());
}

TEST_F(EndpointTest, AMissingFolderOfASocketIsNamed) {
  const auto server = Listen("unix:" + dir_ + "/none/s");
  ASSERT_FALSE(server.ok());
  EXPECT_NE(server.status().ToString().find("none/s"), std::string::npos) << server.status();
}

TEST_F(EndpointTest, OtherMachinesNeedInsecure) {
  const RpcAddress address = Parse("0.0.0.0:0");
  EXPECT_EQ(RpcServer::Start({address}, {}, service_).status().code(),
            absl::StatusCode::kFailedPrecondition);
  EXPECT_EQ(ConnectRpc(Parse("farm:1"), {}).status().code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_TRUE(ConnectRpc(Parse("farm:1"), {.insecure = true}).ok());
}

TEST_F(EndpointTest, MessagesBeyondTheBoundAreRefused) {
  auto server = Listen("127.0.0.1:0");
  ASSERT_TRUE(server.ok()) << server.status();
  auto coordinator = v1::Coordinator::NewStub(*ConnectRpc((*server)->addresses()[0], {}));
  grpc::ClientContext context;
  SetRpcTimeout(context, seconds(30));
  v1::GetSceneReply reply;
  EXPECT_EQ(FromGrpc(coordinator->GetScene(&context, {}, &reply)).code(),
            absl::StatusCode::kResourceExhausted);
}

TEST_F(EndpointTest, StatusesKeepTheirCodeAndMessage) {
  for (int code = 0; code <= 16; ++code) {
    const absl::Status status(static_cast<absl::StatusCode>(code), code == 0 ? "" : "why");
    EXPECT_EQ(FromGrpc(ToGrpc(status)), status);
  }
  EXPECT_LE(ToGrpc(Internal("{}", std::string(100'000, 'x'))).error_message().size(), 2000u);
}

}  // namespace
}  // namespace parallax
