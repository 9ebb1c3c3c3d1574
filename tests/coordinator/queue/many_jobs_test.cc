// A farm's database grows to millions of jobs. Statements that run for each job of some kind, or
// for each look at a study, find their rows by an index.
#include <sqlite3.h>

#include <mutex>
#include <string>
#include <vector>

#include "coordinator/queue/reads/page_reader.h"
#include "tests/coordinator/queue/train_fixture.h"

namespace parallax {
namespace {

using testing::IsEmpty;
using testing::Not;

std::mutex whole_reads_mu;
std::vector<std::string>* whole_reads = nullptr;  // Guarded by whole_reads_mu.

// Notes a statement that has looked at jobs one by one. SQLite calls it when a statement has ended.
int NoteWholeRead(unsigned, void*, void* ended, void*) {
  auto* const statement = static_cast<sqlite3_stmt*>(ended);
  const char* const sql = sqlite3_sql(statement);
  const int rows = sqlite3_stmt_status(statement, SQLITE_STMTSTATUS_FULLSCAN_STEP, 1) +
                   sqlite3_stmt_status(statement, SQLITE_STMTSTATUS_AUTOINDEX, 1);
  const std::lock_guard lock(whole_reads_mu);
  const std::string text = sql == nullptr ? "" : sql;
  const bool is_of_jobs =
      text.find("all_jobs") != std::string::npos || text.find("archived_") != std::string::npos;
  if (whole_reads != nullptr && rows > 0 && is_of_jobs) whole_reads->push_back(text);
  return 0;
}

int WatchConnection(sqlite3* db, const char**, const struct sqlite3_api_routines*) {
  return sqlite3_trace_v2(db, SQLITE_TRACE_PROFILE, &NoteWholeRead, nullptr);
}

class ManyJobsTest : public TrainQueueTest {
 protected:
  void SetUp() override {
    sqlite3_auto_extension(reinterpret_cast<void (*)()>(&WatchConnection));
    TrainQueueTest::SetUp();
  }
  ~ManyJobsTest() override {
    Note(nullptr);
    sqlite3_cancel_auto_extension(reinterpret_cast<void (*)()>(&WatchConnection));
  }
  static void Note(std::vector<std::string>* to) {
    const std::lock_guard lock(whole_reads_mu);
    whole_reads = to;
  }
  std::vector<std::string> noted_;
};

TEST_F(ManyJobsTest, TrainingsScoresAndCostsReadNoWholeTableOfJobs) {
  const StudyId study = SubmitRequest(WithTrainings(Request({.pairs = 2, .variants = {"wide"}})));
  MakePairs();
  Note(&noted_);
  TrainAll();
  EvaluateAll();
  EXPECT_TRUE(queue_->CostsOf(study).ok());
  const auto reader = PageReader::Open(options_.db_path, queue_->kinds());
  ASSERT_TRUE(reader.ok()) << reader.status();
  const auto scores = (*reader)->Scores(study.value);
  Note(nullptr);
  ASSERT_TRUE(scores.ok()) << scores.status();
  EXPECT_THAT(*scores, Not(IsEmpty()));
  EXPECT_THAT(noted_, IsEmpty());
}

TEST_F(ManyJobsTest, AStudyComesBackFromTheArchiveWithoutAReadOfAllOfIt) {
  options_.archive_after_s = 1000;
  Reopen();
  const StudyId study = Submit({.name = "old"});
  WorkOff(AnyWorker("w"));
  const auto outputs = queue_->ListStoredOutputs("", 1);
  ASSERT_TRUE(outputs.ok()) << outputs.status();
  ASSERT_THAT(*outputs, Not(IsEmpty()));
  Submit({.name = "new", .seed = 2});
  clock_.Advance(2000);
  for (int i = 0; i < 5; ++i) Tick();
  ASSERT_GT(queue_->Stats().archived_jobs, 0u);
  Note(&noted_);
  const DamagedResult damaged{(*outputs)[0].key, (*outputs)[0].folder, "a bit has flipped"};
  const auto taken = queue_->TakeBack({damaged}, "tester");
  Note(nullptr);
  ASSERT_TRUE(taken.ok()) << taken.status();
  EXPECT_EQ(taken->jobs, 1);
  EXPECT_EQ(State(study), v1::STUDY_STATE_RUNNING);
  EXPECT_THAT(noted_, IsEmpty());
}

}  // namespace
}  // namespace parallax
