#include "coordinator/rpc/janitor.h"

#include <filesystem>

#include "../queue/queue_fixture.h"
#include "common/base/hash.h"
#include "common/store/content.h"

namespace parallax {
namespace {

namespace fs = std::filesystem;

class JanitorTest : public QueueTest {
 protected:
  void SetUp() override {
    QueueTest::SetUp();
    auto store = OpenStore(dir_ + "/store");
    ASSERT_TRUE(store.ok()) << store.status();
    store_ = *std::move(store);
    content_ = std::make_unique<ContentKeeper>(
        *store_, ContentOptions{.most_bytes = 1000, .keep_s = 100, .clock = &clock_});
    janitor_ = std::make_unique<Janitor>(*queue_, *store_, content_.get(),
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
  bool Exists(const v1::Lease& lease) { return fs::exists(dir_ + "/store/" + FolderOf(lease)); }
  int Sweep() {
    const auto removed = janitor_->Sweep();
    EXPECT_TRUE(removed.ok()) << removed.status();
    return removed.value_or(-1);
  }

  // Puts a folder of one file, as a client does before it submits. Returns the folder's name.
  std::string Ship(const std::string& bytes) {
    const std::string file = Sha256Hex(bytes);
    const std::string list = ContentListText({{"a.hdr", static_cast<int64_t>(bytes.size()), file}});
    for (const std::string& text : {bytes, list}) {
      content_->Note(Sha256Hex(text));
      EXPECT_TRUE(store_->Put(ContentPath(Sha256Hex(text)), text).ok());
    }
    return ContentReferenceText({Sha256Hex(list), "home/hdris"});
  }
  StudyId SubmitWith(const std::string& hdris, const std::string& name) {
    v1::SubmitRequest request = MakeStudy({.name = name, .pairs = 2});
    v1::LightingConfig* lighting =
        request.mutable_study()->mutable_variants(0)->mutable_config()->mutable_lighting();
    lighting->set_hdri_dir(hdris);
    lighting->set_hdris_sha256(Sha256Hex(hdris));
    const auto reply = queue_->Submit(request, "tester");
    EXPECT_TRUE(reply.ok()) << reply.status();
    return StudyId{reply.ok() ? reply->study_id() : 0};
  }
  void CancelAndForget(StudyId study) {
    ASSERT_TRUE(queue_->Cancel(study, "", "tester").ok());
    Tick();
    ASSERT_TRUE(queue_->Forget(study, "", "tester").ok());
  }
  bool HasContent(const std::string& bytes) {
    return store_->Get(ContentPath(Sha256Hex(bytes))).ok();
  }
  int SweepContent() {
    const auto removed = janitor_->SweepContent();
    EXPECT_TRUE(removed.ok()) << removed.status();
    return removed.value_or(-1);
  }

  std::unique_ptr<Store> store_;
  std::unique_ptr<ContentKeeper> content_;
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
  EXPECT_FALSE(fs::exists(dir_ + "/store/" + FolderOf(won) + "/finished"));
  EXPECT_TRUE(fs::exists(dir_ + "/store/" + FolderOf(alive) + "/finished"));
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
  fs::remove_all(dir_ + "/store/" + FolderOf(failed));
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

TEST_F(JanitorTest, ContentGoesWhenTheLastStudyThatNamesItIsForgotten) {
  const std::string shared = Ship("shared"), own = Ship("own");
  const StudyId first = SubmitWith(shared, "first"), second = SubmitWith(shared, "second");
  SubmitWith(own, "third");
  CancelAndForget(first);
  EXPECT_EQ(SweepContent(), 0);
  clock_.Advance(101);
  EXPECT_EQ(SweepContent(), 0) << "the second names it";
  CancelAndForget(second);
  EXPECT_EQ(SweepContent(), 0) << "for a while it stays";
  clock_.Advance(101);
  EXPECT_EQ(SweepContent(), 2) << "a file and its list";
  EXPECT_FALSE(HasContent("shared"));
  EXPECT_TRUE(HasContent("own"));
}

TEST_F(JanitorTest, ContentOfAClientThatIsAboutToSubmitStays) {
  Ship("old");
  EXPECT_EQ(SweepContent(), 0);
  clock_.Advance(101);
  const std::string again = Ship("old");  // It finds its files there.
  EXPECT_EQ(SweepContent(), 0);
  clock_.Advance(99);
  EXPECT_EQ(SweepContent(), 0);
  SubmitWith(again, "late");
  clock_.Advance(101);
  EXPECT_EQ(SweepContent(), 0);
  EXPECT_TRUE(HasContent("old"));
}

TEST_F(JanitorTest, ContentThatASubmitFindsStaysUntilTheStudyNamesIt) {
  v1::StudySpec study;
  study.add_variants()->mutable_config()->mutable_lighting()->set_hdri_dir(Ship("old"));
  EXPECT_EQ(SweepContent(), 0);
  clock_.Advance(101);
  EXPECT_TRUE(content_->CheckStudy(study).ok());
  clock_.Advance(59);
  EXPECT_EQ(SweepContent(), 0) << "neither the list nor its file";
  clock_.Advance(2);
  EXPECT_EQ(SweepContent(), 0) << "first found without a study";
  clock_.Advance(101);
  EXPECT_EQ(SweepContent(), 2);
  EXPECT_TRUE(absl::IsFailedPrecondition(content_->CheckStudy(study)));
}

TEST_F(JanitorTest, RemovedContentLeavesRoom) {
  Ship(std::string(600, 'x'));
  EXPECT_EQ(content_->TakeRoom("new", 900).code(), absl::StatusCode::kResourceExhausted);
  EXPECT_EQ(SweepContent(), 0);
  clock_.Advance(101);
  EXPECT_EQ(SweepContent(), 2);
  EXPECT_TRUE(content_->TakeRoom("new", 900).ok());
}

TEST_F(JanitorTest, AFileTakesRoomOnceHoweverManySendIt) {
  for (int sender = 0; sender < 8; ++sender) EXPECT_TRUE(content_->TakeRoom("file", 600).ok());
  for (int sender = 0; sender < 8; ++sender) content_->EndRoom("file", /*stored=*/sender == 3);
  EXPECT_EQ(content_->TakeRoom("other", 500).code(), absl::StatusCode::kResourceExhausted);
  EXPECT_TRUE(content_->TakeRoom("small", 300).ok());
  content_->EndRoom("small", /*stored=*/false);
  EXPECT_TRUE(content_->TakeRoom("other", 400).ok()) << "what did not arrive takes no room";
}

// The folders of the time that a restored backup lacks.
TEST_F(JanitorTest, FoldersOfNoAttemptAreRemovedWhenTheyAreOld) {
  const std::string key = "ab/" + std::string(64, 'a');
  ASSERT_TRUE(store_->Put(key + "/.attempt-5/000/left.png", "x").ok());
  const Janitor janitor(*queue_, *store_, nullptr, {.every_s = 0, .unknown_s = 3600});
  ASSERT_TRUE(store_->SetOwner(queue_->database_id()).ok());
  EXPECT_EQ(*janitor.SweepUnknown(), 0) << "it is new";
  const std::string file = *store_->LocalPath(key + "/.attempt-5/000/left.png");
  std::filesystem::last_write_time(file,
                                   std::filesystem::last_write_time(file) - std::chrono::hours(2));
  ASSERT_TRUE(store_->SetOwner("another").ok());
  EXPECT_EQ(*janitor.SweepUnknown(), 0) << "the store of another database";
  ASSERT_TRUE(store_->SetOwner(queue_->database_id()).ok());
  EXPECT_EQ(*janitor.SweepUnknown(), 1);
  EXPECT_TRUE(store_->List(key)->empty());
}

TEST_F(JanitorTest, AMissingOrBrokenListKeepsNoOtherContentAlive) {
  Ship("unused");
  SubmitWith(Ship("used"), "well");
  const std::string gone = Ship("gone"), broken = Ship("broken");
  SubmitWith(gone, "without");
  SubmitWith(broken, "damaged");
  ASSERT_TRUE(store_->RemoveTree(ContentPath(FindContentReference(gone)->sha256)).ok());
  ASSERT_TRUE(store_->Put(ContentPath(FindContentReference(broken)->sha256), "no list").ok());
  EXPECT_EQ(SweepContent(), 0);
  clock_.Advance(101);
  EXPECT_EQ(SweepContent(), 4) << "the unused file, its list, and the files of the other two lists";
  EXPECT_TRUE(HasContent("used"));
}

}  // namespace
}  // namespace parallax
