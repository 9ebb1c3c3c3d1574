// A store that goes away while a coordinator serves: nothing is leased, published or submitted
// until it is back, and nothing is lost.
#include "common/store/store.h"
#include "tests/coordinator/rpc/puppet.h"
#include "tests/coordinator/rpc/server_fixture.h"

namespace parallax {
namespace {

class StoreAwayTest : public CoordinatorServerTest {
 protected:
  void SetUp() override {
    store_ = *OpenStore(dir_ + "/store");
    options_.store = store_.get();
    options_.spool_dir = dir_ + "/spool";
    options_.store_look_s = 0.01;
    StartCoordinator();
  }
  void TearDown() override { StopCoordinator(); }

  void WaitUntilStoreIs(bool there) {
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(20);
    while (server_->StoreStatus().ok() != there && std::chrono::steady_clock::now() < deadline) {
      std::this_thread::yield();
    }
    ASSERT_EQ(server_->StoreStatus().ok(), there);
  }
  void TakeAway() {
    fs::rename(dir_ + "/store", dir_ + "/disk");
    fs::create_directory(dir_ + "/store");
    WaitUntilStoreIs(false);
  }
  void BringBack() {
    fs::remove(dir_ + "/store");
    fs::rename(dir_ + "/disk", dir_ + "/store");
    WaitUntilStoreIs(true);
  }

  std::unique_ptr<Store> store_;
};

TEST_F(StoreAwayTest, NothingIsLeasedPublishedOrTakenUntilItIsBack) {
  const int64_t study = Submit(2, 1, {"only"});
  StartAgent("w", gated_);
  ASSERT_TRUE(gated_.WaitForStart());
  TakeAway();
  EXPECT_FALSE(server_->Metrics().store_problem.empty());
  const auto leases = server_->Metrics().leases;
  Puppet puppet(*stub_);
  puppet.Hello("idle");
  puppet.Credit(4);
  gated_.Release();  // Work ends meanwhile.
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  EXPECT_LE(server_->Metrics().leases, leases + 1);
  EXPECT_TRUE(Frames(study).empty());
  grpc::ClientContext context;
  SetRpcTimeout(context, std::chrono::seconds(20));
  v1::SubmitReply reply;
  v1::SubmitRequest request;
  request.mutable_study()->set_name("late");
  EXPECT_EQ(stub_->Submit(&context, request, &reply).error_code(), grpc::UNAVAILABLE);
  puppet.Cut();
  puppet.WaitForEnd().IgnoreError();
  BringBack();
  EXPECT_TRUE(WaitForState(study, v1::STUDY_STATE_SUCCEEDED));
  EXPECT_EQ(JobsOf(GetStudy(study).variants(0), "", "QUARANTINED"), 0);
  EXPECT_TRUE(server_->Metrics().store_problem.empty());
}

}  // namespace
}  // namespace parallax
