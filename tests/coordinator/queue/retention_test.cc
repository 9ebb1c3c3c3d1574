// Retention: the archive of finished studies, and litter in the store.
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <set>

#include "queue_fixture.h"

namespace parallax {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;
using testing::SizeIs;
using testing::UnorderedElementsAre;

class Archive : public QueueTest {
 protected:
  void SetUp() override {
    options_.archive_after_s = 1000;
    Reopen();
  }
  void LetArchive() {
    clock_.Advance(2000);
    Tick();
  }
  int64_t Archived() { return static_cast<int64_t>(queue_->Stats().archived_jobs); }
};

TEST_F(Archive, JobsOfStudiesFinishedForLongMoveAndAreStillTold) {
  const StudyId old = Submit({.name = "old", .pairs = 4, .rigs_per_scene = 2});
  EXPECT_EQ(Fail(Failure(LeaseOne(AnyWorker("w")), "w", "boom", false)), v1::REPORT_OUTCOME_OK);
  WorkOff(AnyWorker("w"));
  const v1::StudyStatus before = Status(old);
  const auto jobs_before = ListJobs(old);
  clock_.Advance(500);
  Tick();
  EXPECT_EQ(Archived(), 0);  // Not yet.
  const StudyId young = Submit({.name = "young", .seed = 2, .pairs = 2, .rigs_per_scene = 2});
  clock_.Advance(700);
  Tick();
  EXPECT_EQ(Archived(), static_cast<int64_t>(jobs_before.size()));
  ExpectSound();

  const v1::StudyStatus after = Status(old);
  EXPECT_EQ(after.SerializeAsString().size(), before.SerializeAsString().size());
  EXPECT_EQ(after.variants(0).pairs_done(), 4);
  ASSERT_THAT(after.variants(0).problems(), SizeIs(1));
  EXPECT_EQ(after.variants(0).problems(0).error(), before.variants(0).problems(0).error());
  EXPECT_THAT(ListJobs(old), SizeIs(jobs_before.size()));
  EXPECT_THAT(ListJobs(old, "FAILED"), SizeIs(1));
  EXPECT_THAT(Frames(old), SizeIs(4));
  EXPECT_EQ(WorkOff(AnyWorker("w")), 2);
  EXPECT_EQ(Status(young).state(), v1::STUDY_STATE_SUCCEEDED);
}

TEST_F(Archive, ArchivedResultsAreReusedAndTheStudyIsNotRetried) {
  const StudyId old = Submit({.name = "old", .pairs = 4, .rigs_per_scene = 2});
  WorkOff(AnyWorker("w"));
  Submit({.name = "newer", .seed = 2, .pairs = 2, .rigs_per_scene = 2});
  LetArchive();
  EXPECT_GT(Archived(), 0);
  EXPECT_EQ(queue_->Retry(old, "tester").status().code(), absl::StatusCode::kFailedPrecondition);
  const StudyId again = Submit({.name = "again", .pairs = 4, .rigs_per_scene = 2});
  EXPECT_EQ(WorkOff(AnyWorker("w")), 2);  // Jobs of `newer`.
  EXPECT_EQ(Status(again).variants(0).frames_reused(), 4);
}

TEST_F(Archive, ALateReportOfAnArchivedJobIsStillKnownForDone) {
  Submit({.name = "old", .pairs = 2, .rigs_per_scene = 2});
  const v1::Lease solve = LeaseOne(AnyWorker("w"));
  EXPECT_EQ(Complete(SolveAnswer(solve, "w")), v1::REPORT_OUTCOME_OK);
  WorkOff(AnyWorker("w"));
  Submit({.name = "newer", .seed = 2, .pairs = 2, .rigs_per_scene = 2});
  LetArchive();
  EXPECT_GT(Archived(), 0);
  EXPECT_EQ(Complete(SolveAnswer(solve, "w")), v1::REPORT_OUTCOME_ALREADY_DONE);
}

TEST_F(Archive, TheNumberOfAnArchivedJobIsNeverGivenAgain) {
  const StudyId old = Submit({.name = "old", .pairs = 4, .rigs_per_scene = 2});
  WorkOff(AnyWorker("w"));
  LetArchive();
  LetArchive();
  std::set<int64_t> ids;
  for (const v1::JobStatus& job : ListJobs(old)) ids.insert(job.job_id());
  const StudyId next = Submit({.name = "next", .seed = 2, .pairs = 4, .rigs_per_scene = 2});
  WorkOff(AnyWorker("w"));
  for (const v1::JobStatus& job : ListJobs(next)) EXPECT_TRUE(ids.insert(job.job_id()).second);
}

TEST_F(Archive, NothingThatIsNotFinishedMoves) {
  const StudyId study = Submit({.pairs = 4, .rigs_per_scene = 2});
  const v1::Lease held = LeaseOne(AnyWorker("w"));
  LetArchive();
  EXPECT_EQ(Archived(), 0);
  Reopen();
  WorkOff(AnyWorker("x"));
  EXPECT_EQ(Status(study).variants(0).pairs_done(), 4);
}

// Kills a process at each step of moving a study, and goes on with what it left.
TEST_F(Archive, AProcessKilledWhileItMovesJobsLosesNone) {
  const auto move_in_child = [&](int step) {
    options_.fail_point = [=](const std::string& command, int at) {
      if (command == "tick" && at == step) raise(SIGKILL);
      return absl::OkStatus();
    };
    clock_.Advance(2000);
    const auto queue = JobQueue::Open(options_);
    if (!queue.ok()) _exit(3);
    _exit((*queue)->Tick().ok() && (*queue)->Stats().archived_jobs > 0 ? 0 : 4);
  };
  int killed = 0;
  for (int step = 1;; ++step) {
    ASSERT_LT(step, 100);
    queue_.reset();
    for (const char* suffix : {"", "-wal", "-shm"}) {
      std::filesystem::remove(options_.db_path + suffix);
    }
    Reopen();
    const StudyId old = Submit({.name = "old", .pairs = 4, .rigs_per_scene = 2});
    EXPECT_EQ(Fail(Failure(LeaseOne(AnyWorker("w")), "w", "boom", false)), v1::REPORT_OUTCOME_OK);
    WorkOff(AnyWorker("w"));
    const size_t jobs = ListJobs(old).size();
    Submit({.name = "young", .seed = 2, .pairs = 2, .rigs_per_scene = 2});
    queue_.reset();
    const pid_t pid = fork();
    if (pid == 0) move_in_child(step);
    int status = 0;
    ASSERT_EQ(waitpid(pid, &status, 0), pid);
    if (WIFEXITED(status)) {
      ASSERT_EQ(WEXITSTATUS(status), 0) << step;
      break;  // There is no such step.
    }
    ++killed;
    Reopen();
    ExpectSound();
    EXPECT_THAT(ListJobs(old), SizeIs(jobs)) << step;
    LetArchive();
    EXPECT_EQ(Archived(), static_cast<int64_t>(jobs)) << step;
    EXPECT_THAT(ListJobs(old), SizeIs(jobs)) << step;
    ExpectSound();
    clock_.Advance(-2000);
  }
  // A mark of the study, and of each job a row moved there, its losses there, and both gone here.
  EXPECT_GE(killed, 1 + 4 * 5);
}

class Litter : public QueueTest {
 protected:
  std::vector<std::string> List(double older_than_s = 0) {
    const auto paths = queue_->ListLitter(older_than_s, 100);
    EXPECT_TRUE(paths.ok()) << paths.status();
    return paths.ok() ? *paths : std::vector<std::string>();
  }
  v1::Lease RenderOf(const std::string& worker) {
    for (const v1::Lease& lease : Lease(Solver("s"), 64)) Complete(SolveAnswer(lease, "s"));
    return LeaseOne(Renderer(worker));
  }
  static std::string FolderOf(const v1::Lease& lease) {
    return lease.store_prefix() + "/.attempt-" + std::to_string(lease.attempt().fence());
  }
  // Notes on finished pairs, when the job is done.
  static std::string NotesOf(const v1::Lease& lease) { return FolderOf(lease) + "/finished"; }
};

TEST_F(Litter, IsTheFolderOfEveryAttemptThatDidNotWinOnceItsSceneIsOver) {
  const StudyId study = Submit({.pairs = 6, .rigs_per_scene = 2});
  const v1::Lease failed = RenderOf("a");
  Fail(Failure(failed, "a", "boom"));
  const v1::Lease lost = LeaseOne(Renderer("b"));
  ASSERT_TRUE(queue_->WorkerLost("b").ok());
  EXPECT_THAT(List(), IsEmpty()) << "the next attempts may go on from them";
  const v1::Lease won = LeaseOne(Renderer("c"));
  ASSERT_EQ(won.scene(), lost.scene());
  Complete(RenderAnswer(won, "c"));
  EXPECT_THAT(List(), UnorderedElementsAre(FolderOf(lost), NotesOf(won)));
  const v1::Lease cancelled = LeaseOne(Renderer("d"));
  ASSERT_TRUE(queue_->Cancel(study, "", "tester").ok());
  EXPECT_THAT(List(), UnorderedElementsAre(FolderOf(failed), FolderOf(lost), FolderOf(cancelled),
                                           NotesOf(won)));
}

TEST_F(Litter, IsToldOfOnlyWhenItIsOldEnoughAndUntilItIsForgotten) {
  Submit({.pairs = 2, .rigs_per_scene = 2});
  const v1::Lease failed = RenderOf("a");
  Fail(Failure(failed, "a", "boom", /*retryable=*/false));
  EXPECT_THAT(List(100), IsEmpty());
  clock_.Advance(101);
  EXPECT_THAT(List(100), ElementsAre(FolderOf(failed)));
  ASSERT_TRUE(queue_->ForgetLitter(List(100)).ok());
  EXPECT_THAT(List(100), IsEmpty());
}

TEST_F(Litter, ComesBackWhenAZombieReportsLate) {
  Submit({.pairs = 2, .rigs_per_scene = 2});
  const v1::Lease late = RenderOf("zombie");
  ASSERT_TRUE(queue_->WorkerLost("zombie").ok());
  const v1::Lease heir = LeaseOne(Renderer("heir"));
  Complete(RenderAnswer(heir, "heir"));
  EXPECT_THAT(List(), UnorderedElementsAre(FolderOf(late), NotesOf(heir)));
  ASSERT_TRUE(queue_->ForgetLitter(List()).ok());
  EXPECT_EQ(Complete(RenderAnswer(late, "zombie")), v1::REPORT_OUTCOME_STALE_FENCE);
  EXPECT_THAT(List(), ElementsAre(FolderOf(late)));
}

TEST_F(Litter, OfAStrangersReportIsNotBelieved) {
  Submit({.pairs = 4, .rigs_per_scene = 2});
  const v1::Lease won = RenderOf("a");
  Complete(RenderAnswer(won, "a"));
  const v1::Lease lost = LeaseOne(Renderer("b"));
  ASSERT_TRUE(queue_->WorkerLost("b").ok());
  Complete(RenderAnswer(LeaseOne(Renderer("c")), "c"));
  ASSERT_TRUE(queue_->ForgetLitter(List()).ok());
  // A late report that names the winner's files.
  v1::CompleteRequest report = RenderAnswer(won, "b");
  *report.mutable_attempt() = lost.attempt();
  EXPECT_EQ(Complete(report), v1::REPORT_OUTCOME_STALE_FENCE);
  EXPECT_THAT(List(), IsEmpty());
}

}  // namespace
}  // namespace parallax
