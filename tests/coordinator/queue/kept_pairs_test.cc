// Pairs that an attempt has finished before it ended: the next attempts at the scene are told where
// they are, for as long as the scene is open.
#include "coordinator/queue/database_tools.h"
#include "queue_fixture.h"
#include "tests/sqlite_by_hand.h"

namespace parallax {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::UnorderedElementsAre;

class KeptPairs : public QueueTest {
 protected:
  StudyId SubmitSolved(const StudyOptions& options) {
    const StudyId study = Submit(options);
    for (const v1::Lease& lease : Lease(Solver("s"), 64)) {
      EXPECT_EQ(Complete(SolveAnswer(lease, "s")), v1::REPORT_OUTCOME_OK);
    }
    return study;
  }
  v1::Lease LeaseAndLose(const std::string& worker) {
    const v1::Lease lease = LeaseOne(Renderer(worker));
    EXPECT_TRUE(queue_->WorkerLost(worker).ok());
    clock_.Advance(1);
    return lease;
  }
  static std::vector<std::string> EarlierOf(const v1::Lease& lease) {
    const v1::RenderJob job = RenderOf(lease);
    return {job.earlier_folders().begin(), job.earlier_folders().end()};
  }
  static std::string FolderOf(const v1::Lease& lease) {
    return lease.store_prefix() + "/.attempt-" + std::to_string(lease.attempt().fence());
  }
  // A worker's notes on its finished pairs.
  static std::string NotesOf(const v1::Lease& lease) { return FolderOf(lease) + "/finished"; }
  std::vector<std::string> Litter() {
    const auto paths = queue_->ListLitter(0, 100);
    EXPECT_TRUE(paths.ok()) << paths.status();
    return paths.ok() ? *paths : std::vector<std::string>();
  }
  void Meddle(const std::string& sql) {
    queue_.reset();
    sqlite3* db = OpenByHand(options_.db_path);
    ASSERT_NE(db, nullptr);
    char* error = nullptr;
    EXPECT_EQ(sqlite3_exec(db, sql.c_str(), nullptr, nullptr, &error), SQLITE_OK) << error;
    sqlite3_close(db);
  }
};

TEST_F(KeptPairs, TheNextAttemptIsToldOfAllEarlierOnesTheNewestFirst) {
  SubmitSolved({.pairs = 4, .rigs_per_scene = 4});
  const v1::Lease lost = LeaseAndLose("a");
  EXPECT_THAT(EarlierOf(lost), IsEmpty());
  const v1::Lease back = LeaseOne(Renderer("b"));
  EXPECT_THAT(EarlierOf(back), ElementsAre(FolderOf(lost)));
  ASSERT_TRUE(queue_->HandBack("b", back.attempt(), "drained").ok());
  clock_.Advance(1);
  const v1::Lease failed = LeaseOne(Renderer("c"));
  Fail(Failure(failed, "c", "bang"));
  clock_.Advance(1000);
  Reopen();
  Tick();
  const v1::Lease winner = LeaseOne(Renderer("d"));
  EXPECT_THAT(EarlierOf(winner), ElementsAre(FolderOf(failed), FolderOf(back), FolderOf(lost)));
  EXPECT_THAT(Litter(), IsEmpty());
  ExpectSound();
  EXPECT_EQ(Complete(RenderAnswer(winner, "d")), v1::REPORT_OUTCOME_OK);
  EXPECT_THAT(Litter(), UnorderedElementsAre(FolderOf(failed), FolderOf(back), FolderOf(lost),
                                             NotesOf(winner)));
}

TEST_F(KeptPairs, PartsOfADividedJobAreToldTooAndTheFolderStaysUntilTheLastOfThemEnds) {
  SubmitSolved({.pairs = 4, .rigs_per_scene = 4});
  const v1::Lease lost = LeaseAndLose("a");
  WorkerFacts idle = Renderer("b");
  idle.farm["render"] = {.idle = 2, .all = 2};
  const v1::Lease first = LeaseOne(idle);
  const v1::Lease second = LeaseOne(Renderer("c"));
  ASSERT_EQ(RenderOf(first).rigs_size(), 2);
  ASSERT_EQ(RenderOf(second).rigs_size(), 2);
  EXPECT_THAT(EarlierOf(first), ElementsAre(FolderOf(lost)));
  EXPECT_THAT(EarlierOf(second), ElementsAre(FolderOf(lost)));
  EXPECT_EQ(Complete(RenderAnswer(first, "b")), v1::REPORT_OUTCOME_OK);
  EXPECT_THAT(Litter(), ElementsAre(NotesOf(first)));
  ExpectSound();
  EXPECT_EQ(Complete(RenderAnswer(second, "c")), v1::REPORT_OUTCOME_OK);
  EXPECT_THAT(Litter(), UnorderedElementsAre(FolderOf(lost), NotesOf(first), NotesOf(second)));
}

// Until then a worker that dies with its job done costs nothing but the way there.
TEST_F(KeptPairs, NotesOfADoneJobGoWithItsResultAndNotBefore) {
  SubmitSolved({.pairs = 5, .rigs_per_scene = 4});
  const v1::Lease dies = LeaseAndLose("a");  // It was done, and nobody heard of it.
  EXPECT_THAT(Litter(), IsEmpty());
  const v1::Lease heir = LeaseOne(Renderer("b"));
  EXPECT_THAT(EarlierOf(heir), ElementsAre(FolderOf(dies)));
  EXPECT_EQ(Complete(RenderAnswer(heir, "b")), v1::REPORT_OUTCOME_OK);
  EXPECT_THAT(Litter(), UnorderedElementsAre(FolderOf(dies), NotesOf(heir)));
  // A job of one pair has none.
  ASSERT_TRUE(queue_->ForgetLitter(Litter()).ok());
  EXPECT_EQ(Complete(RenderAnswer(LeaseOne(Renderer("b")), "b")), v1::REPORT_OUTCOME_OK);
  EXPECT_THAT(Litter(), IsEmpty());
  // The late report of the dead one changes nothing.
  EXPECT_EQ(Complete(RenderAnswer(dies, "a")), v1::REPORT_OUTCOME_STALE_FENCE);
}

TEST_F(KeptPairs, AnotherStudysEqualSceneGoesOnFromThemAndAnotherScenesJobsDoNot) {
  SubmitSolved({.name = "one", .pairs = 4, .rigs_per_scene = 4});
  const StudyId two = SubmitSolved({.name = "two", .pairs = 8, .rigs_per_scene = 4});
  const v1::Lease lost = LeaseAndLose("a");
  std::vector<std::vector<std::string>> told;
  for (const v1::Lease& lease : Lease(Renderer("b"), 8)) told.push_back(EarlierOf(lease));
  EXPECT_THAT(told, UnorderedElementsAre(ElementsAre(FolderOf(lost)), IsEmpty()));
  EXPECT_EQ(Jobs(two, "render", "BLOCKED") + Jobs(two, "render", "LEASED"), 2);
}

TEST_F(KeptPairs, NothingIsKeptOfASceneThatIsGivenUp) {
  const StudyId cancelled = SubmitSolved({.pairs = 4, .rigs_per_scene = 4});
  const v1::Lease lost = LeaseAndLose("a");
  const v1::Lease held = LeaseOne(Renderer("b"));
  ASSERT_TRUE(queue_->Cancel(cancelled, "", "tester").ok());
  EXPECT_THAT(Litter(), UnorderedElementsAre(FolderOf(lost), FolderOf(held)));
  ExpectSound();
  ASSERT_TRUE(queue_->ForgetLitter(Litter()).ok());
  SubmitSolved({.name = "other", .seed = 2, .pairs = 4, .rigs_per_scene = 4});
  const v1::Lease failed = LeaseOne(Renderer("c"));
  Fail(Failure(failed, "c", "bang", /*retryable=*/false));
  EXPECT_THAT(Litter(), ElementsAre(FolderOf(failed)));
}

TEST_F(KeptPairs, TheAuditorSeesFoldersThatAreKeptWithoutReason) {
  const struct {
    const char* sql;
    const char* finding;
  } kCases[] = {
      {"UPDATE kept_folders SET ordinal = 7", "a scene's folder is kept only while"},
      {"INSERT INTO kept_folders SELECT l.path, x'00', 1, 1, 0 FROM litter AS l LIMIT 1",
       "a folder that is kept is not litter"},
      {"INSERT INTO kept_folders SELECT lower(substr(hex(work_key), 1, 2)) || '/' ||"
       " lower(hex(work_key)) || '/.attempt-' || fence, x'00', 1, 1, 2 FROM jobs"
       " WHERE kind = 'render' AND state = 'SUCCEEDED'",
       "a published frame is not litter"},
  };
  for (const auto& one : kCases) {
    queue_.reset();
    for (const char* suffix : {"", "-wal", "-shm"}) {
      std::filesystem::remove(options_.db_path + suffix);
    }
    Reopen();
    SubmitSolved({.pairs = 12, .rigs_per_scene = 4});
    Fail(Failure(LeaseOne(Renderer("a")), "a", "bang", /*retryable=*/false));
    EXPECT_EQ(Complete(RenderAnswer(LeaseOne(Renderer("b")), "b")), v1::REPORT_OUTCOME_OK);
    LeaseAndLose("c");
    ExpectSound();
    Meddle(one.sql);
    const auto findings = AuditDatabaseFile(options_.db_path);
    ASSERT_TRUE(findings.ok()) << findings.status();
    EXPECT_THAT(*findings, Contains(HasSubstr(one.finding))) << one.sql;
  }
}

}  // namespace
}  // namespace parallax
