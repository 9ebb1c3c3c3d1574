// Callers of Artifacts that keep still or come in crowds, over real streams: others get through.
#include <grpcpp/grpcpp.h>
#include <gtest/gtest.h>

#include <atomic>
#include <filesystem>
#include <thread>

#include "common/base/hash.h"
#include "common/base/seconds.h"
#include "common/rpc/endpoint.h"
#include "common/rpc/grpc_status.h"
#include "common/rpc/remote_store.h"
#include "common/store/store.h"
#include "coordinator/rpc/artifacts_service.h"
#include "tests/folder_test.h"

namespace parallax {
namespace {

using std::chrono::seconds;

class ArtifactsCrowd : public FolderTest {
 protected:
  void Serve(const ArtifactsLimits& limits) {
    store_ = *OpenStore(dir_ + "/store");
    service_ = std::make_unique<ArtifactsService>(
        store_.get(), dir_ + "/store/.tmp-incoming",
        [](const std::string&, const v1::AttemptId&, const std::string&, bool) {
          return absl::OkStatus();
        },
        limits);
    ASSERT_TRUE(service_->Prepare().ok());
    server_ = *RpcServer::Start(
        {*ParseRpcAddress("127.0.0.1:0"), *ParseRpcAddress("unix:" + dir_ + "/s")}, {}, *service_);
  }
  ~ArtifactsCrowd() override { server_.reset(); }

  std::shared_ptr<grpc::Channel> Channel() { return *ConnectRpc(server_->addresses()[0], {}); }
  // Comes from elsewhere than Channel().
  std::shared_ptr<grpc::Channel> OtherPeer() { return *ConnectRpc(server_->addresses()[1], {}); }

  // A Put stream that is held open.
  struct Idler {
    grpc::ClientContext context;
    std::unique_ptr<v1::Artifacts::Stub> stub;
    std::unique_ptr<grpc::ClientReaderWriter<v1::PutFileMessage, v1::PutFileReply>> stream;
  };
  std::unique_ptr<Idler> OpenWithoutHeader() {
    auto idler = std::make_unique<Idler>();
    idler->stub = v1::Artifacts::NewStub(crowd_);
    SetRpcTimeout(idler->context, seconds(60));
    idler->stream = idler->stub->Put(&idler->context);
    return idler;
  }
  // With a header and nothing after it. The first reply tells that it has its place.
  std::unique_ptr<Idler> OpenStalled(const std::string& worker, int file) {
    auto idler = OpenWithoutHeader();
    v1::PutFileMessage message;
    v1::PutFileHeader& header = *message.mutable_header();
    header.mutable_attempt()->set_job_id(1);
    header.mutable_attempt()->set_fence(7);
    header.set_worker(worker);
    header.set_path("k/.attempt-7/" + worker + std::to_string(file));
    header.set_size(100);
    header.set_sha256(std::string(64, 'a'));
    idler->stream->Write(message);
    return idler;
  }

  absl::Status PutBy(const std::string& worker, const std::string& path,
                     std::shared_ptr<grpc::Channel> channel = nullptr) {
    if (channel == nullptr) channel = Channel();
    return MakeRemoteStore(channel, {worker, {}})->Put(path, "bytes");
  }

  std::unique_ptr<Store> store_;
  std::unique_ptr<ArtifactsService> service_;
  std::unique_ptr<RpcServer> server_;
  std::shared_ptr<grpc::Channel> crowd_;
};

TEST_F(ArtifactsCrowd, StreamsWithoutHeaderLockNobodyOut) {
  Serve({.header_s = 30});  // So that making room is what lets the others through.
  crowd_ = Channel();
  constexpr int kIdlers = 200;
  std::vector<std::unique_ptr<Idler>> idlers;
  for (int i = 0; i < kIdlers; ++i) idlers.push_back(OpenWithoutHeader());
  const SteadyTime begin = Clock::System().Steady();
  std::atomic<int> ended{0};
  std::vector<std::jthread> ends;
  for (auto& idler : idlers) {
    ends.emplace_back([&ended, stream = idler->stream.get()] {
      stream->Finish();
      ++ended;
    });
  }
  for (int i = 0; i < 5; ++i) {
    const absl::Status status = PutBy("honest", "k/.attempt-7/" + std::to_string(i));
    EXPECT_TRUE(status.ok()) << status;
  }
  EXPECT_TRUE(MakeRemoteStore(Channel(), {"honest", {}})->Get("k/.attempt-7/0").ok());
  // The streams that waited longest were ended long before their time.
  const int most = static_cast<int>(ArtifactsLimits().waiting);
  while (ended < kIdlers - most && SecondsSince(begin) < 15) std::this_thread::yield();
  EXPECT_LT(SecondsSince(begin), 15);
  for (auto& idler : idlers) idler->context.TryCancel();
}

TEST_F(ArtifactsCrowd, AStreamWithoutHeaderIsEndedInTime) {
  Serve({.header_s = 0.3});
  crowd_ = Channel();
  const SteadyTime begin = Clock::System().Steady();
  std::vector<std::unique_ptr<Idler>> idlers;
  for (int i = 0; i < 10; ++i) idlers.push_back(OpenWithoutHeader());
  for (auto& idler : idlers) EXPECT_FALSE(idler->stream->Finish().ok());
  EXPECT_LT(SecondsSince(begin), 20) << "not by the client's own deadline";
}

TEST_F(ArtifactsCrowd, AStalledFileIsEndedInTimeAndLeavesNothingBehind) {
  Serve({.idle_s = 0.3});
  crowd_ = Channel();
  const SteadyTime begin = Clock::System().Steady();
  auto idler = OpenStalled("sleepy", 1);
  v1::PutFileReply reply;
  ASSERT_TRUE(idler->stream->Read(&reply));
  EXPECT_TRUE(reply.wanted());
  EXPECT_FALSE(idler->stream->Read(&reply));
  EXPECT_FALSE(idler->stream->Finish().ok());
  EXPECT_LT(SecondsSince(begin), 20);
  server_->Shutdown(seconds(5));  // Waits for the handler.
  EXPECT_TRUE(std::filesystem::is_empty(dir_ + "/store/.tmp-incoming"));
}

TEST_F(ArtifactsCrowd, OnePeersStalledFilesLeaveRoomForAnothersWhateverNamesItClaims) {
  Serve({.puts = 8, .puts_a_peer = 4});
  crowd_ = Channel();
  std::vector<std::unique_ptr<Idler>> idlers;
  v1::PutFileReply reply;
  for (int i = 0; i < 4; ++i) {
    idlers.push_back(OpenStalled("greedy-" + std::to_string(i), i));
    ASSERT_TRUE(idlers.back()->stream->Read(&reply)) << i;
  }
  const absl::Status more = PutBy("greedy-5", "k/.attempt-7/more");
  EXPECT_EQ(more.code(), absl::StatusCode::kUnavailable) << more;
  const absl::Status other = PutBy("honest", "k/.attempt-7/other", OtherPeer());
  EXPECT_TRUE(other.ok()) << other;
  for (auto& idler : idlers) idler->context.TryCancel();
  for (auto& idler : idlers) idler->stream->Finish();
}

TEST_F(ArtifactsCrowd, AReaderThatDoesNotReadIsEndedAndLeavesRoomForOthers) {
  Serve({.idle_s = 0.5, .reads = 4, .reads_a_peer = 2});
  crowd_ = Channel();
  ASSERT_TRUE(store_->Put("k/large", std::string(32 << 20, 'x')).ok());
  struct Reader {
    grpc::ClientContext context;
    std::unique_ptr<grpc::ClientReader<v1::FileChunk>> stream;
  };
  const auto stub = v1::Artifacts::NewStub(crowd_);
  std::vector<std::unique_ptr<Reader>> readers;
  v1::GetFileRequest request;
  request.set_path("k/large");
  for (int i = 0; i < 2; ++i) {
    auto reader = std::make_unique<Reader>();
    SetRpcTimeout(reader->context, seconds(60));
    reader->stream = stub->Get(&reader->context, request);
    v1::FileChunk chunk;
    ASSERT_TRUE(reader->stream->Read(&chunk));  // The first piece; then it stops reading.
    readers.push_back(std::move(reader));
  }
  EXPECT_TRUE(MakeRemoteStore(OtherPeer(), {"w", {}})->GetPiece("k/large", 0, 100).ok());
  std::this_thread::sleep_for(seconds(2));  // Four times what a reader may keep still.
  for (auto& reader : readers) {
    v1::FileChunk chunk;
    while (reader->stream->Read(&chunk)) {
    }
    EXPECT_FALSE(reader->stream->Finish().ok()) << "it was ended while it did not read";
  }
}

}  // namespace
}  // namespace parallax
