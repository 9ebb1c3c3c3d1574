#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "common/base/status.h"
#include "common/base/system/temporary_folder.h"
#include "common/rpc/endpoint.h"
#include "common/rpc/grpc_status.h"
#include "common/rpc/remote_store.h"
#include "common/store/content.h"
#include "coordinator/rpc/artifacts_service.h"
#include "tests/common/store/store_conformance.h"
#include "tests/coordinator/queue/queue_fixture.h"

namespace parallax {
namespace {

namespace fs = std::filesystem;
using std::chrono::seconds;
using ::testing::HasSubstr;

// A store behind a server of its own.
struct Served {
  const TemporaryFolder folder = *TemporaryFolder::Make("artifacts");
  std::unique_ptr<Store> store;
  std::unique_ptr<ArtifactsService> service;
  std::unique_ptr<RpcServer> server;
  bool allowed = true;  // The rule's verdict.

  explicit Served(const ArtifactsLimits& limits = {}) {
    store = *OpenStore(folder.path() + "/store");
    service = std::make_unique<ArtifactsService>(
        store.get(), folder.path() + "/store/.tmp-incoming",
        [this](const std::string&, const v1::AttemptId&, const std::string&, bool) {
          return allowed ? absl::OkStatus() : Aborted("not yours");
        },
        limits);
    EXPECT_TRUE(service->Prepare().ok());
    auto started = RpcServer::Start({*ParseRpcAddress("127.0.0.1:0")}, {}, *service);
    EXPECT_TRUE(started.ok()) << started.status();
    server = *std::move(started);
  }
  std::shared_ptr<grpc::Channel> Channel() const { return *ConnectRpc(server->addresses()[0], {}); }
  size_t Spooled() const {
    return static_cast<size_t>(std::distance(
        fs::directory_iterator(folder.path() + "/store/.tmp-incoming"), fs::directory_iterator()));
  }
};

// The remote store together with what serves it.
class RemoteStoreOfItsOwn final : public Store {
 public:
  RemoteStoreOfItsOwn() : remote_(MakeRemoteStore(served_.Channel(), {"w", {}})) {}
  std::string Uri() const override { return remote_->Uri(); }
  absl::Status Put(std::string_view path, std::string_view bytes) override {
    return remote_->Put(path, bytes);
  }
  absl::Status PutFile(std::string_view path, const std::string& local, const StoreFile& facts,
                       bool may_move) override {
    return remote_->PutFile(path, local, facts, may_move);
  }
  absl::StatusOr<std::string> Get(std::string_view path) const override {
    return remote_->Get(path);
  }
  absl::StatusOr<std::string> GetPiece(std::string_view path, int64_t offset,
                                       size_t max_bytes) const override {
    return remote_->GetPiece(path, offset, max_bytes);
  }
  absl::StatusOr<std::vector<StoreEntry>> List(std::string_view prefix) const override {
    return remote_->List(prefix);
  }
  absl::Status RemoveTree(std::string_view path) override { return remote_->RemoveTree(path); }
  absl::StatusOr<std::string> LocalPath(std::string_view path) const override {
    return remote_->LocalPath(path);
  }

 private:
  Served served_;
  std::unique_ptr<Store> remote_;
};

std::unique_ptr<Store> MakeServedStore() { return std::make_unique<RemoteStoreOfItsOwn>(); }

INSTANTIATE_TEST_SUITE_P(ThroughTheCoordinator, StoreConformance,
                         ::testing::Values(&MakeServedStore));

class ArtifactsTest : public testing::Test {
 protected:
  using Stream = grpc::ClientReaderWriter<v1::PutFileMessage, v1::PutFileReply>;

  v1::PutFileMessage Header(const std::string& path, const std::string& bytes) const {
    v1::PutFileMessage message;
    v1::PutFileHeader& header = *message.mutable_header();
    header.mutable_attempt()->set_job_id(1);
    header.mutable_attempt()->set_fence(7);
    header.set_worker("w");
    header.set_path(path);
    header.set_size(static_cast<int64_t>(bytes.size()));
    header.set_sha256(Sha256Hex(bytes));
    return message;
  }
  // Header, these chunks, end: what the call ends with.
  absl::Status Put(const v1::PutFileMessage& header, const std::vector<std::string>& chunks,
                   const std::function<void()>& after_header = nullptr) {
    grpc::ClientContext context;
    SetRpcTimeout(context, seconds(20));
    const auto stream = stub_->Put(&context);
    stream->Write(header);
    v1::PutFileReply reply;
    if (stream->Read(&reply)) {
      if (after_header != nullptr) after_header();
      wanted_ = reply.wanted();
      for (const std::string& chunk : chunks) {
        v1::PutFileMessage message;
        message.set_chunk(chunk);
        if (!stream->Write(message)) break;
      }
      stream->WritesDone();
      while (stream->Read(&reply)) {
      }
    }
    return FromGrpc(stream->Finish());
  }

  Served served_;
  std::unique_ptr<v1::Artifacts::Stub> stub_ = v1::Artifacts::NewStub(served_.Channel());
  bool wanted_ = false;
};

TEST_F(ArtifactsTest, WhatIsNotAsAnnouncedIsNotThere) {
  const std::string bytes = "0123456789";
  const v1::PutFileMessage header = Header("k/a", bytes);
  for (const std::vector<std::string>& chunks :
       std::vector<std::vector<std::string>>{{}, {"01234"}, {"01234", "56789x"}, {"012345678X"}}) {
    EXPECT_EQ(Put(header, chunks).code(), absl::StatusCode::kDataLoss);
    EXPECT_TRUE(absl::IsNotFound(served_.store->Get("k/a").status()));
  }
  EXPECT_EQ(Put(header, {std::string(kFileChunkBytes + 1, 'x')}).code(),
            absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(Put(header, {""}).code(), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(served_.Spooled(), 0u) << "nothing half received is left";
  EXPECT_TRUE(Put(header, {"01234", "56789"}).ok());
  EXPECT_EQ(*served_.store->Get("k/a"), bytes);
}

TEST_F(ArtifactsTest, TheSameFileIsNotSentAgain) {
  ASSERT_TRUE(Put(Header("k/a", "same"), {"same"}).ok());
  EXPECT_TRUE(wanted_);
  EXPECT_TRUE(Put(Header("k/a", "same"), {}).ok());
  EXPECT_FALSE(wanted_);
  EXPECT_TRUE(Put(Header("k/a", "else"), {"else"}).ok()) << "of the same size";
  EXPECT_TRUE(wanted_);
  EXPECT_EQ(*served_.store->Get("k/a"), "else");
}

TEST_F(ArtifactsTest, ALeaseThatEndsOnTheWayLeavesNothing) {
  const auto lose = [this] { served_.allowed = false; };
  EXPECT_EQ(Put(Header("k/a", "late"), {"late"}, lose).code(), absl::StatusCode::kAborted);
  EXPECT_TRUE(served_.store->List("")->empty());
  EXPECT_EQ(Put(Header("k/a", "late"), {}).code(), absl::StatusCode::kAborted);
  EXPECT_EQ(served_.Spooled(), 0u);
}

TEST_F(ArtifactsTest, SizesPathsAndHashesAreBounded) {
  v1::PutFileMessage header = Header("k/a", "x");
  header.mutable_header()->set_size(kMaxFileBytes + 1);
  EXPECT_EQ(Put(header, {}).code(), absl::StatusCode::kInvalidArgument);
  header.mutable_header()->set_size(-1);
  EXPECT_EQ(Put(header, {}).code(), absl::StatusCode::kInvalidArgument);
  header = Header("k/a", "x");
  header.mutable_header()->set_sha256(std::string(64, 'G'));
  EXPECT_EQ(Put(header, {}).code(), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(Put(Header("../../etc/passwd", "x"), {"x"}).code(), absl::StatusCode::kInvalidArgument);
  v1::PutFileMessage chunk_first;
  chunk_first.set_chunk("x");
  EXPECT_EQ(Put(chunk_first, {}).code(), absl::StatusCode::kInvalidArgument);
  const auto remote = MakeRemoteStore(served_.Channel(), {});
  EXPECT_FALSE(remote->Get(".parallax-store").ok()) << "the store's own file";
}

TEST_F(ArtifactsTest, ContentIsNamedByItsHashAndNeedsNoAttempt) {
  served_.allowed = false;  // No attempt's rule is asked.
  const std::string path = ContentPath(Sha256Hex("mine"));
  EXPECT_TRUE(Put(Header(path, "mine"), {"mine"}).ok());
  EXPECT_EQ(*served_.store->Get(path), "mine");
  EXPECT_TRUE(Put(Header(path, "mine"), {}).ok());
  EXPECT_FALSE(wanted_);
  for (const std::string& elsewhere : {path, std::string("content/list"), path + "/x",
                                       std::string("content"), "content/../" + path}) {
    EXPECT_EQ(Put(Header(elsewhere, "other"), {"other"}).code(), absl::StatusCode::kInvalidArgument)
        << elsewhere;
  }
  EXPECT_EQ(*served_.store->Get(path), "mine");
  EXPECT_EQ(Put(Header("contents/x", "x"), {"x"}).code(), absl::StatusCode::kAborted);
}

TEST(ArtifactsContent, HasABoundOnAllOfIt) {
  ArtifactsLimits limits;
  limits.content.most_bytes = 10;
  Served served(limits);
  ASSERT_TRUE(served.store->Put(ContentPath(Sha256Hex("four")), "four").ok());
  const auto remote = MakeRemoteStore(served.Channel(), {.worker = "client", .attempt = {}});
  const auto put = [&](const std::string& bytes) {
    return remote->Put(ContentPath(Sha256Hex(bytes)), bytes);
  };
  EXPECT_TRUE(put("five.").ok());
  const absl::Status full = put("six...");
  EXPECT_EQ(full.code(), absl::StatusCode::kResourceExhausted);
  EXPECT_THAT(std::string(ToStd(full.message())), HasSubstr("9 bytes, 6 more are wanted, and 10"));
  EXPECT_TRUE(put("four").ok()) << "it is there";
  EXPECT_TRUE(put("1").ok());
}

// A client that finds its content there relies on it until it submits.
TEST(ArtifactsContent, StaysForWhoPutsItAgain) {
  FakeClock clock;
  ArtifactsLimits limits;
  limits.content.keep_s = 100;
  limits.content.clock = &clock;
  Served served(limits);
  const auto remote = MakeRemoteStore(served.Channel(), {.worker = "client", .attempt = {}});
  const auto put = [&] { return remote->Put(ContentPath(Sha256Hex("mine")), "mine"); };
  ASSERT_TRUE(put().ok());
  EXPECT_EQ(*served.service->content()->Sweep({}), 0);
  clock.Advance(101);
  ASSERT_TRUE(put().ok());
  EXPECT_EQ(*served.service->content()->Sweep({}), 0);
  clock.Advance(101);
  EXPECT_EQ(*served.service->content()->Sweep({}), 1);
}

TEST_F(ArtifactsTest, AStartEmptiesTheSpool) {
  ASSERT_TRUE(WriteFile(served_.folder.path() + "/store/.tmp-incoming/1", "half").ok());
  ASSERT_TRUE(served_.service->Prepare().ok());
  EXPECT_EQ(served_.Spooled(), 0u);
}

TEST(AttemptPath, OnlyTheAttemptsOwnFolderWillDo) {
  EXPECT_TRUE(CheckAttemptPath("k/.attempt-7/003/left.png", 7, false).ok());
  EXPECT_TRUE(CheckAttemptPath("a/b/.attempt-7/x", 7, false).ok());
  EXPECT_TRUE(CheckAttemptPath("k/.attempt-7", 7, true).ok());
  for (const char* path :
       {"k/.attempt-7", "k/.attempt-71/x", "k/.attempt-8/x", "k/x", ".attempt-7/x",
        "k/.attempt-8/.attempt-7/x", "k/.attempt-7/../x", "/k/.attempt-7/x"}) {
    EXPECT_FALSE(CheckAttemptPath(path, 7, false).ok()) << path;
  }
  EXPECT_FALSE(CheckAttemptPath("k", 7, true).ok());
  EXPECT_FALSE(CheckAttemptPath("k/.attempt-8", 7, true).ok());
}

}  // namespace
}  // namespace parallax
