// Groups of commands: each whole or not at all, whatever becomes of its neighbours.
#include <map>
#include <semaphore>

#include "queue_fixture.h"
#include "tests/sqlite_by_hand.h"

namespace parallax {
namespace {

class GroupCommit : public QueueTest {
 protected:
  // Adds a trigger to the schema: a write of the third scene's frames fails.
  void BreakFramesOfScene2() {
    queue_.reset();
    sqlite3* db = OpenByHand(options_.db_path);
    ASSERT_NE(db, nullptr);
    ASSERT_EQ(sqlite3_exec(db,
                           "CREATE TRIGGER broken BEFORE INSERT ON frames WHEN NEW.ordinal = 2"
                           " BEGIN SELECT RAISE(ABORT, 'broken'); END",
                           nullptr, nullptr, nullptr),
              SQLITE_OK);
    sqlite3_close(db);
    Reopen();
  }
};

TEST_F(GroupCommit, ACommandThatFailsHalfWayTakesNothingAndNobodyWithIt) {
  options_.linger_s = 0.05;
  const StudyId study = Submit({.pairs = 6, .rigs_per_scene = 1});
  for (const v1::Lease& lease : Lease(Solver("s"), 6)) {
    ASSERT_EQ(Complete(SolveAnswer(lease, "s")), v1::REPORT_OUTCOME_OK);
  }
  BreakFramesOfScene2();
  const std::vector<v1::Lease> renders = Lease(Renderer("r"), 6);
  ASSERT_EQ(renders.size(), 6u);

  std::mutex mutex;
  std::map<uint32_t, bool> ok;
  std::counting_semaphore<> answered(0);
  for (const v1::Lease& lease : renders) {
    queue_->CompleteAsync(RenderAnswer(lease, "r"), "",
                          [&, scene = lease.scene()](absl::StatusOr<v1::ReportOutcome> outcome) {
                            {
                              const std::lock_guard lock(mutex);
                              ok[scene] = outcome.ok() && *outcome == v1::REPORT_OUTCOME_OK;
                            }
                            answered.release();
                          });
  }
  for (size_t i = 0; i < renders.size(); ++i) answered.acquire();

  for (uint32_t scene = 0; scene < 6; ++scene) EXPECT_EQ(ok[scene], scene != 2) << scene;
  EXPECT_EQ(Frames(study).size(), 5u);
  EXPECT_EQ(Jobs(study, "render", "LEASED"), 1);
  EXPECT_EQ(Status(study).variants(0).pairs_done(), 5);
}

TEST_F(GroupCommit, ACommandThatIsRefusedBeforeItWritesCostsItsGroupNothing) {
  Submit({.pairs = 2, .rigs_per_scene = 1});
  EXPECT_EQ(queue_->Cancel(StudyId{99}, "no such", "tester").code(), absl::StatusCode::kNotFound);
  EXPECT_EQ(WorkOff(AnyWorker("w")), 4);
}

TEST_F(GroupCommit, WithoutThreadsOfItsOwnTheCallersThreadDoesTheWork) {
  queue_.reset();
  options_.own_threads = false;
  options_.max_batch = 2;
  Reopen();
  Submit({.pairs = 3, .rigs_per_scene = 1});
  const std::vector<v1::Lease> solves = Lease(Solver("s"), 3);
  ASSERT_EQ(solves.size(), 3u);
  int answered = 0;
  for (const v1::Lease& lease : solves) {
    queue_->CompleteAsync(SolveAnswer(lease, "s"), "", [&](absl::StatusOr<v1::ReportOutcome> end) {
      EXPECT_TRUE(end.ok() && *end == v1::REPORT_OUTCOME_OK);
      ++answered;
    });
  }
  EXPECT_EQ(answered, 0);
  EXPECT_TRUE(queue_->Work());
  EXPECT_EQ(answered, 2) << "a group";
  EXPECT_TRUE(queue_->Work());
  EXPECT_EQ(answered, 3);
  EXPECT_FALSE(queue_->Work()) << "nothing is left";
  EXPECT_EQ(Lease(Renderer("r"), 9).size(), 3u);
}

}  // namespace
}  // namespace parallax
