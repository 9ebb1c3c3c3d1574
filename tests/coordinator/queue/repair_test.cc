// Results whose files are damaged: they are taken back and made again, and nobody says meanwhile
// that they are there.
#include "common/base/hash.h"
#include "tests/coordinator/queue/train_fixture.h"

namespace parallax {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

class RepairTest : public TrainQueueTest {
 protected:
  std::vector<StoredOutput> Outputs(const std::string& after = "", int limit = 1000) {
    auto outputs = queue_->ListStoredOutputs(after, limit);
    EXPECT_TRUE(outputs.ok()) << outputs.status();
    return outputs.ok() ? *std::move(outputs) : std::vector<StoredOutput>();
  }
  // The output that has this file.
  StoredOutput OutputWith(const std::string& file) {
    for (const StoredOutput& output : Outputs()) {
      for (const JobKind::OutputFile& own : output.files) {
        if (own.path.ends_with("/" + file)) return output;
      }
    }
    ADD_FAILURE() << "no " << file;
    return {};
  }
  TakenBack TakeBack(const std::vector<StoredOutput>& outputs) {
    std::vector<DamagedResult> damaged;
    for (const StoredOutput& output : outputs) {
      damaged.push_back({output.key, output.folder, output.folder + ": a bit has flipped"});
    }
    const auto taken = queue_->TakeBack(damaged, "tester");
    EXPECT_TRUE(taken.ok()) << taken.status();
    ExpectSound();
    return taken.value_or(TakenBack());
  }
};

TEST_F(RepairTest, APairThatIsDamagedIsTakenBackAndMadeAgain) {
  const StudyId study = Submit({.pairs = 6});
  WorkOff(AnyWorker("w"));
  const auto before = Frames(study);
  const std::vector<StoredOutput> outputs = Outputs();
  ASSERT_THAT(outputs, SizeIs(6));
  EXPECT_THAT(outputs[0].files, SizeIs(FrameFileNames({}).size()));
  EXPECT_EQ(outputs[0].files[0].sha256, std::string(64, 'a'));
  EXPECT_THAT(*queue_->ListUsesOf(outputs[0].key),
              ElementsAre(HasSubstr("study 1 (study), variant only, scene ")));
  const TakenBack taken = TakeBack({outputs[0], outputs[3]});
  EXPECT_EQ(taken.results, 2);
  EXPECT_EQ(taken.pairs, 2);
  EXPECT_EQ(State(study), v1::STUDY_STATE_RUNNING) << "it does not have what it was asked for";
  EXPECT_EQ(Status(study).variants(0).pairs_done(), 4);
  EXPECT_THAT(Frames(study), SizeIs(4));
  EXPECT_THAT(Outputs(), SizeIs(4));
  EXPECT_GT(WorkOff(AnyWorker("w")), 0);
  EXPECT_EQ(State(study), v1::STUDY_STATE_SUCCEEDED);
  EXPECT_THAT(Frames(study), SizeIs(6));
  // Who follows the study hears of the new ones.
  EXPECT_THAT(Frames(study, before.back().cursor()), SizeIs(2));
  EXPECT_EQ(TakeBack({outputs[0]}).results, 0) << "it was made anew, in another folder";
  // Again, of the same pair, after a restart.
  Reopen();
  EXPECT_EQ(TakeBack({Outputs()[0]}).pairs, 1);
  WorkOff(AnyWorker("w"));
  EXPECT_EQ(State(study), v1::STUDY_STATE_SUCCEEDED);
}

TEST_F(RepairTest, AllStudiesThatHaveAPairGetItAgainAndItIsMadeOnce) {
  const StudyId one = Submit({.name = "one"}), two = Submit({.name = "two"});
  WorkOff(AnyWorker("w"));
  EXPECT_EQ(TakeBack({Outputs()[1]}).pairs, 2);
  EXPECT_EQ(State(one), v1::STUDY_STATE_RUNNING);
  EXPECT_EQ(State(two), v1::STUDY_STATE_RUNNING);
  EXPECT_EQ(WorkOff(AnyWorker("w")), 1);
  EXPECT_EQ(State(one), v1::STUDY_STATE_SUCCEEDED);
  EXPECT_EQ(State(two), v1::STUDY_STATE_SUCCEEDED);
}

TEST_F(RepairTest, AnArchivedStudyComesBackFromTheArchive) {
  options_.archive_after_s = 1000;
  Reopen();
  const StudyId study = Submit({.name = "old"});
  WorkOff(AnyWorker("w"));
  const std::vector<StoredOutput> outputs = Outputs();
  Submit({.name = "new", .seed = 2});
  clock_.Advance(2000);
  for (int i = 0; i < 5; ++i) Tick();
  ASSERT_GT(queue_->Stats().archived_jobs, 0u);
  EXPECT_EQ(TakeBack({outputs[0]}).jobs, 1);
  EXPECT_EQ(State(study), v1::STUDY_STATE_RUNNING);
  WorkOff(AnyWorker("w"));
  EXPECT_EQ(State(study), v1::STUDY_STATE_SUCCEEDED);
}

TEST_F(RepairTest, ACancelledStudyLosesThePairAndAForgottenOneIsLeftAlone) {
  const StudyId study = Submit({.pairs = 4});
  for (int i = 0; i < 3; ++i) {
    const v1::Lease lease = LeaseOne(AnyWorker("w"));
    Complete(Answer(lease, "w"));
  }
  ASSERT_TRUE(queue_->Cancel(study, "", "tester").ok());
  const std::vector<StoredOutput> outputs = Outputs();
  ASSERT_FALSE(outputs.empty());
  const TakenBack taken = TakeBack({outputs[0]});
  EXPECT_EQ(taken.pairs, 1);
  EXPECT_EQ(taken.jobs, 0);
  EXPECT_THAT(Lease(AnyWorker("w")), IsEmpty());
  ASSERT_TRUE(queue_->Forget(study, "", "tester").ok());
  EXPECT_EQ(TakeBack({outputs[1]}).pairs, 0);
  for (int i = 0; i < 10; ++i) Tick();
  ExpectSound();
}

TEST_F(RepairTest, AnEqualStudyIsNotGivenResultsWhoseFilesAreGone) {
  std::string gone;
  options_.files_there = [&gone](const std::vector<JobKind::OutputFile>& files) {
    return gone.empty() || files.front().path.rfind(gone, 0) != 0;
  };
  Reopen();
  const StudyId one = Submit({.name = "one"});
  WorkOff(AnyWorker("w"));
  gone = Outputs()[2].folder;
  const StudyId two = Submit({.name = "two"});
  Tick();
  EXPECT_EQ(State(two), v1::STUDY_STATE_RUNNING);
  EXPECT_EQ(State(one), v1::STUDY_STATE_RUNNING) << "nor does the first one say that it has them";
  EXPECT_EQ(Status(one).variants(0).pairs_done(), 3);
  ExpectSound();
  EXPECT_GT(WorkOff(AnyWorker("w")), 0);
  EXPECT_EQ(State(one), v1::STUDY_STATE_SUCCEEDED);
  EXPECT_EQ(State(two), v1::STUDY_STATE_SUCCEEDED);
}

TEST_F(RepairTest, ATrainingIsNotBegunWithoutItsPairsNorBlamedForThem) {
  const StudyId study = SubmitRequest(Request({.pairs = 2, .variants = {"wide"}}));
  MakePairs();
  const v1::Lease running = LeaseOne(Trainer("t"));
  TakeBack({OutputWith("left.png")});
  for (int i = 0; i < 5; ++i) {
    if (i == 0) Fail(Failure(running, "t", "left.png: another SHA-256"));
    EXPECT_THAT(Lease(Trainer("t"), 9), IsEmpty());
  }
  ExpectSound();
  MakePairs();
  clock_.Advance(31);  // Past the time for which it is left to others.
  TrainAll();
  EXPECT_EQ(State(study), v1::STUDY_STATE_SUCCEEDED);
}

TEST_F(RepairTest, ANetworkThatIsDamagedIsTrainedAgainBeforeItIsScored) {
  v1::SubmitRequest request = Request({.pairs = 2, .variants = {"wide"}});
  request.mutable_study()->mutable_evaluate()->add_benchmarks("shipped");
  const StudyId study = SubmitRequest(request);
  MakePairs();
  TrainAll();
  EXPECT_EQ(TakeBack({OutputWith("step-100.pt")}).jobs, 1);
  EXPECT_THAT(Lease(Evaluator("e"), 9), IsEmpty()) << "there is no network to score";
  TrainAll();
  EvaluateAll();
  EXPECT_EQ(State(study), v1::STUDY_STATE_SUCCEEDED);
  EXPECT_EQ(TakeBack({OutputWith("scores.jsonl")}).jobs, 1);
  EXPECT_EQ(State(study), v1::STUDY_STATE_RUNNING);
  EvaluateAll();
  EXPECT_EQ(State(study), v1::STUDY_STATE_SUCCEEDED);
  // In the archive it is known, too, that they were made again.
  options_.archive_after_s = 1000;
  Reopen();
  Submit({.name = "new", .seed = 2});
  clock_.Advance(2000);
  for (int i = 0; i < 5; ++i) Tick();
  EXPECT_GT(queue_->Stats().archived_jobs, 0u);
  ExpectSound();
}

TEST_F(RepairTest, ScoresOfAnArchivedStudyAreMadeAgainAfterTheirNetwork) {
  options_.archive_after_s = 1000;
  Reopen();
  v1::SubmitRequest request = Request({.pairs = 2, .variants = {"wide"}});
  request.mutable_study()->mutable_evaluate()->add_benchmarks("shipped");
  const StudyId study = SubmitRequest(request);
  MakePairs();
  TrainAll();
  EvaluateAll();
  Submit({.name = "new", .seed = 2});
  clock_.Advance(2000);
  for (int i = 0; i < 5; ++i) Tick();
  ASSERT_TRUE(*queue_->IsArchived(study));
  EXPECT_EQ(TakeBack({OutputWith("scores.jsonl"), OutputWith("step-100.pt")}).jobs, 2);
  EXPECT_THAT(Lease(Evaluator("e"), 9), IsEmpty());
  TrainAll();
  EvaluateAll();
  EXPECT_EQ(State(study), v1::STUDY_STATE_SUCCEEDED);
}

TEST_F(RepairTest, ReusedScoresAreMadeAgainAfterTheirNetwork) {
  v1::SubmitRequest request = Request({.pairs = 2, .variants = {"wide"}});
  request.mutable_study()->mutable_evaluate()->add_benchmarks("shipped");
  const StudyId one = SubmitRequest(request);
  MakePairs();
  TrainAll();
  EvaluateAll();
  request.mutable_study()->set_name("two");
  const StudyId two = SubmitRequest(request);
  ASSERT_EQ(State(two), v1::STUDY_STATE_SUCCEEDED);
  EXPECT_EQ(TakeBack({OutputWith("scores.jsonl"), OutputWith("step-100.pt")}).jobs, 4);
  EXPECT_THAT(Lease(Evaluator("e"), 9), IsEmpty());
  TrainAll();
  EvaluateAll();
  EXPECT_EQ(State(one), v1::STUDY_STATE_SUCCEEDED);
  EXPECT_EQ(State(two), v1::STUDY_STATE_SUCCEEDED);
}

TEST_F(RepairTest, ANetworkThatTheNextReleaseTrainsAgainIsScoredAndItsScoresAreItsOwn) {
  v1::SubmitRequest request = Request({.pairs = 2, .variants = {"wide"}});
  request.mutable_study()->mutable_evaluate()->add_benchmarks("shipped");
  const StudyId study = SubmitRequest(request);
  MakePairs();
  TrainAll();
  options_.versions.train = "next";
  Reopen();
  EXPECT_EQ(TakeBack({OutputWith("step-100.pt")}).jobs, 1);
  const v1::Lease training = LeaseOne(Trainer("t"));
  EXPECT_EQ(Complete(TrainAnswer(training, "t")), v1::REPORT_OUTCOME_OK);
  const v1::Lease scoring = LeaseOne(Evaluator("e"));
  EXPECT_EQ(EvaluateJobOf(scoring).checkpoint_path(), AttemptFolderOf(training) + "/step-100.pt");
  EXPECT_EQ(Complete(EvaluateAnswer(scoring, "e")), v1::REPORT_OUTCOME_OK);
  EXPECT_EQ(State(study), v1::STUDY_STATE_SUCCEEDED);
  // An equal study finds the network and its scores under their keys.
  request.mutable_study()->set_name("again");
  const StudyId again = SubmitRequest(request);
  Tick();
  EXPECT_EQ(State(again), v1::STUDY_STATE_SUCCEEDED);
  // In the archive it is known, too, that it was made again under another key.
  options_.archive_after_s = 1000;
  Reopen();
  Submit({.name = "new", .seed = 2});
  clock_.Advance(2000);
  for (int i = 0; i < 5; ++i) Tick();
  ASSERT_TRUE(*queue_->IsArchived(study));
  ExpectSound();
}

TEST_F(RepairTest, ATrainingThatAnUpgradeFindsReadyHasTheKeyOfTheNextRelease) {
  const StudyId study = SubmitRequest(Request({.pairs = 2, .variants = {"wide"}}));
  MakePairs();
  const v1::Lease before = LeaseOne(Trainer("t"));
  options_.versions.train = "next";
  Reopen();
  const v1::Lease after = LeaseOne(Trainer("t"));
  EXPECT_EQ(after.attempt().job_id(), before.attempt().job_id());
  EXPECT_NE(after.store_prefix(), before.store_prefix());
  ExpectSound();  // Also of the folder that the first attempt has left.
  EXPECT_EQ(Complete(TrainAnswer(after, "t")), v1::REPORT_OUTCOME_OK);
  EXPECT_EQ(State(study), v1::STUDY_STATE_SUCCEEDED);
}

TEST_F(RepairTest, ACancelledStudyLacksANetworkThatAnotherStudyMakesAgain) {
  v1::SubmitRequest request = Request({.pairs = 2, .variants = {"wide"}});
  request.mutable_study()->mutable_evaluate()->add_benchmarks("shipped");
  const StudyId cancelled = SubmitRequest(request);
  MakePairs();
  TrainAll();
  ASSERT_TRUE(queue_->Cancel(cancelled, "", "tester").ok());
  EXPECT_EQ(TakeBack({OutputWith("step-100.pt")}).jobs, 0);
  ExpectSound();
  request.mutable_study()->set_name("again");
  const StudyId again = SubmitRequest(request);
  TrainAll();
  ExpectSound();
  EvaluateAll();
  EXPECT_EQ(State(again), v1::STUDY_STATE_SUCCEEDED);
}

TEST_F(RepairTest, ThePlaceOfAPassIsKept) {
  EXPECT_FALSE((*queue_->GetScrub()).has_value());
  Submit({.pairs = 6});
  WorkOff(AnyWorker("w"));
  const std::vector<StoredOutput> some = Outputs("", 2);
  ASSERT_THAT(some, SizeIs(2));
  const std::string place(some[1].key.begin(), some[1].key.end());
  EXPECT_THAT(Outputs(place), SizeIs(4));
  ASSERT_TRUE(queue_->KeepScrub({.position = place, .began_unix_s = 5, .files = 7}).ok());
  Reopen();
  const auto scrub = *queue_->GetScrub();
  ASSERT_TRUE(scrub.has_value());
  EXPECT_EQ(scrub->position, place);
  EXPECT_EQ(scrub->files, 7);
  EXPECT_FALSE(scrub->ended_unix_s.has_value());
}

TEST_F(RepairTest, ADatabaseKeepsTheIdOfItsStore) {
  KnownStore seen;
  options_.open_store = [&seen](const KnownStore& known) -> absl::StatusOr<std::string> {
    seen = known;
    return std::string("store-1");
  };
  Reopen();
  EXPECT_EQ(seen.id, "");
  EXPECT_EQ(seen.database_id, queue_->database_id());
  EXPECT_THAT(seen.sample, IsEmpty());
  Submit();
  WorkOff(AnyWorker("w"));
  Reopen();
  EXPECT_EQ(seen.id, "store-1");
  EXPECT_FALSE(seen.sample.empty());
  queue_.reset();
  JobQueueOptions unmounted = options_;
  unmounted.open_store = [](const KnownStore&) -> absl::StatusOr<std::string> {
    return MakeError(absl::StatusCode::kNotFound, "not mounted");
  };
  EXPECT_TRUE(absl::IsNotFound(JobQueue::Open(unmounted).status()));
  Reopen();
}

}  // namespace
}  // namespace parallax
