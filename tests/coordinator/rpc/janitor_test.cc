#include "coordinator/rpc/janitor.h"

#include <filesystem>

#include "../queue/queue_fixture.h"

namespace parallax {
namespace {

namespace fs = std::filesystem;

class JanitorTest : public QueueTest {
 protected:
  void SetUp() override {
    QueueTest::SetUp();
    auto store = OpenStore(folder_ + "/store");
    ASSERT_TRUE(store.ok()) << store.status();
    store_ = *std::move(store);
    janitor_ = std::make_unique<Janitor>(*queue_, *store_,
                                         JanitorOptions{.lease_s = 30, .leases = 2, .every_s = 0});
  }
  // Leases a render and writes a file as its worker would.
  v1::Lease BeginRender(const std::string& worker) {
    for (const v1::Lease& lease : Lease(Solver("s"), 64)) Complete(SolveAnswer(lease, "s"));
    const v1::Lease lease = LeaseOne(Renderer(worker));
    EXPECT_TRUE(store_->Put(FolderOf(lease) + "/000/left.png", "pixels").ok());
    EXPECT_TRUE(store_->Put(FolderOf(lease) + "/finished/000.pb", "a note").ok());
    return lease;
  }
  static std::string FolderOf(const v1::Lease& lease) {
    return lease.store_prefix() + "/.attempt-" + std::to_string(lease.attempt().fence());
  }
  bool Exists(const v1::Lease& lease) { return fs::exists(folder_ + "/store/" + FolderOf(lease)); }
  int Sweep() {
    const auto removed = janitor_->Sweep();
    EXPECT_TRUE(removed.ok()) << removed.status();
    return removed.value_or(-1);
  }

  std::unique_ptr<Store> store_;
  std::unique_ptr<Janitor> janitor_;
};

TEST_F(JanitorTest, RemovesLosersAndNeitherWinnersNorTheLiving) {
  Submit({.pairs = 4, .rigs_per_scene = 2});
  const v1::Lease lost = BeginRender("a");
  ASSERT_TRUE(queue_->WorkerLost("a").ok());
  const v1::Lease won = BeginRender("b");
  EXPECT_EQ(Complete(RenderAnswer(won, "b")), v1::REPORT_OUTCOME_OK);
  const v1::Lease alive = BeginRender("c");
  EXPECT_EQ(Sweep(), 0);  // Too fresh: its worker may not have heard.
  clock_.Advance(61);
  EXPECT_EQ(Sweep(), 2) << "the loser and the winner's notes";
  EXPECT_FALSE(Exists(lost));
  EXPECT_TRUE(Exists(won));
  EXPECT_FALSE(fs::exists(folder_ + "/store/" + FolderOf(won) + "/finished"));
  EXPECT_TRUE(fs::exists(folder_ + "/store/" + FolderOf(alive) + "/finished"));
  EXPECT_TRUE(Exists(alive));
  EXPECT_EQ(Sweep(), 0);
}

TEST_F(JanitorTest, SweepsAgainBehindAZombie) {
  Submit({.pairs = 2, .rigs_per_scene = 2});
  const v1::Lease lost = BeginRender("a");
  ASSERT_TRUE(queue_->WorkerLost("a").ok());
  clock_.Advance(61);
  EXPECT_EQ(Sweep(), 0) << "the next attempt may go on from it";
  EXPECT_EQ(Complete(RenderAnswer(BeginRender("b"), "b")), v1::REPORT_OUTCOME_OK);
  clock_.Advance(61);
  EXPECT_EQ(Sweep(), 2);
  ASSERT_TRUE(store_->Put(FolderOf(lost) + "/001/left.png", "late").ok());
  EXPECT_EQ(Complete(RenderAnswer(lost, "a")), v1::REPORT_OUTCOME_STALE_FENCE);
  clock_.Advance(61);
  EXPECT_EQ(Sweep(), 1);
  EXPECT_FALSE(Exists(lost));
}

TEST_F(JanitorTest, ForgetsWhatIsGoneAlready) {
  Submit({.pairs = 2, .rigs_per_scene = 2});
  const v1::Lease failed = BeginRender("a");
  fs::remove_all(folder_ + "/store/" + FolderOf(failed));
  EXPECT_EQ(Fail(Failure(failed, "a", "boom", /*retryable=*/false)), v1::REPORT_OUTCOME_OK);
  clock_.Advance(61);
  EXPECT_EQ(Sweep(), 1);
  EXPECT_EQ(Sweep(), 0);
}

TEST_F(JanitorTest, OfAForgottenStudyNoFolderOfAnAttemptIsLeft) {
  const StudyId study = Submit({.pairs = 2, .rigs_per_scene = 2});
  const v1::Lease lease = BeginRender("a");
  EXPECT_TRUE(store_->Put(FolderOf(lease) + "/001/left.png", "pixels").ok());
  EXPECT_EQ(Complete(RenderAnswer(lease, "a")), v1::REPORT_OUTCOME_OK);
  ASSERT_TRUE(queue_->Forget(study, "", "tester").ok());
  for (int i = 0; i < 8; ++i) Tick();
  EXPECT_EQ(Sweep(), 0);
  clock_.Advance(61);
  EXPECT_EQ(Sweep(), 3) << "its two pairs, and their notes";
  EXPECT_FALSE(Exists(lease));
}

}  // namespace
}  // namespace parallax
