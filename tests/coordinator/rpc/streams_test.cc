// The service Streams: calls that wait, what ends them, and who may call.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "coordinator/rpc/validation.h"
#include "parallax/v1/stream.grpc.pb.h"
#include "server_fixture.h"

namespace parallax {
namespace {

using testing::HasSubstr;

class StreamsTest : public CoordinatorServerTest {
 protected:
  StreamsTest() { streams_ = v1::Streams::NewStub(*ConnectRpc(*ParseRpcAddress(address_), {})); }

  static v1::StudySpec Endless() {
    v1::StudySpec study;
    study.set_name("drive");
    study.set_seed(7);
    study.set_pairs(6);
    study.set_rigs_per_scene(3);
    study.mutable_stream()->set_chunk_pairs(6);
    v1::VariantSpec& variant = *study.add_variants();
    variant.set_name("rooms");
    variant.mutable_config()->set_type(v1::SCENE_TYPE_INDOOR);
    variant.mutable_config()->mutable_rigs()->set_count(3);
    return study;
  }
  absl::Status Open(const v1::StudySpec& study) {
    grpc::ClientContext context;
    SetRpcTimeout(context, std::chrono::seconds(20));
    v1::OpenStreamRequest request;
    *request.mutable_study() = study;
    v1::StreamStatus status;
    return FromGrpc(streams_->Open(&context, request, &status));
  }
  static v1::NextPairsRequest Request(double wait_s) {
    v1::NextPairsRequest request;
    request.set_stream("drive");
    request.set_consumer("train");
    request.set_ranks(1);
    request.set_wait_s(wait_s);
    request.set_resume(true);
    return request;
  }
  absl::StatusOr<v1::NextPairsReply> Next(const v1::NextPairsRequest& request) {
    grpc::ClientContext context;
    SetRpcTimeout(context, std::chrono::seconds(60));
    v1::NextPairsReply reply;
    RETURN_IF_ERROR(FromGrpc(streams_->Next(&context, request, &reply)));
    return reply;
  }

  std::unique_ptr<v1::Streams::Stub> streams_;
};

TEST_F(StreamsTest, ACallWaitsUntilPairsAreMade) {
  StartCoordinator();
  ASSERT_TRUE(Open(Endless()).ok());
  const auto nothing = Next(Request(0));
  ASSERT_TRUE(nothing.ok()) << nothing.status();
  EXPECT_EQ(nothing->pairs_size(), 0);
  EXPECT_THAT(nothing->waits_for(), HasSubstr("chunk 0 (study 1) is being made"));

  absl::StatusOr<v1::NextPairsReply> waited;
  std::thread consumer([&] { waited = Next(Request(50)); });
  NoopRunner runner;
  StartAgent("w", runner);
  consumer.join();
  ASSERT_TRUE(waited.ok()) << waited.status();
  EXPECT_GE(waited->pairs_size(), 6);
  EXPECT_EQ(waited->store_uri(), options_.store_uri);

  // A training takes 60 pairs, and none of them twice.
  std::set<std::string> all;
  v1::NextPairsRequest request = Request(20);
  while (all.size() < 60) {
    const auto reply = Next(request);
    ASSERT_TRUE(reply.ok()) << reply.status();
    for (const v1::StreamedPair& pair : reply->pairs()) {
      EXPECT_TRUE(all.insert(pair.frame().path()).second) << pair.frame().path();
      EXPECT_TRUE(fs::exists(dir_ + "/store/" + pair.frame().path())) << "it is forgotten already";
    }
    request.set_resume(false);
    request.set_position(reply->position());
    request.set_acknowledged(reply->position());
  }
  agents_.back().Stop();
  ExpectEveryInvariant();
}

TEST_F(StreamsTest, ACoordinatorThatStopsEndsWaitingCallsAndForgetsNothing) {
  StartCoordinator();
  ASSERT_TRUE(Open(Endless()).ok());
  absl::Status ended;
  std::thread consumer([&] { ended = Next(Request(50)).status(); });
  const auto began = std::chrono::steady_clock::now();
  while (Next(Request(0))->waits_for().empty()) std::this_thread::yield();
  StopCoordinator();
  consumer.join();
  EXPECT_TRUE(absl::IsUnavailable(ended)) << ended;
  EXPECT_LT(std::chrono::steady_clock::now() - began, std::chrono::seconds(40));
  StartCoordinator();
  EXPECT_TRUE(Next(Request(0)).ok());
}

TEST_F(StreamsTest, NoticesGoToAllowedHostsOnly) {
  options_.notify_hosts = *NotifyHosts::Of({"ci:8080"});
  StartCoordinator();
  v1::StudySpec study = Endless();
  study.mutable_notify()->set_url("http://evil/secret");
  EXPECT_THAT(std::string(Open(study).message()),
              HasSubstr("study 'drive': notify.url: this coordinator posts no notices to evil"));
  study.mutable_notify()->set_url("http://ci:8080/secret");
  EXPECT_TRUE(Open(study).ok());
}

TEST_F(StreamsTest, WrongCallsAreRefusedByName) {
  StartCoordinator();
  EXPECT_THAT(std::string(Next(Request(0)).status().message()),
              HasSubstr("stream \"drive\" is not known; `parallax stream FILE` begins one"));
  v1::NextPairsRequest request = Request(0);
  request.set_rank(1);
  EXPECT_THAT(std::string(CheckNextPairs(request).message()),
              HasSubstr("rank is 1, allowed is [0, 0]"));
  request = Request(61);
  EXPECT_THAT(std::string(CheckNextPairs(request).message()), HasSubstr("wait_s is 61"));
  request = Request(0);
  request.set_consumer("a b\n");
  EXPECT_THAT(std::string(CheckNextPairs(request).message()), HasSubstr("consumer"));
  v1::StudySpec study = Endless();
  study.mutable_stream()->set_uses(0);
  EXPECT_THAT(std::string(Open(study).message()), HasSubstr("stream.uses: 0 is out of range"));
}

}  // namespace
}  // namespace parallax
