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
  if (whole_reads != nullptr && rows > 0 && sql != nullptr &&
      std::string(sql).find("all_jobs") != std::string::npos) {
    whole_reads->push_back(sql);
  }
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
    sqlite3_cancel_auto_extension(reinterpret_cast<void (*)()>(&WatchConnection));
  }
  static void Note(std::vector<std::string>* to) {
    const std::lock_guard lock(whole_reads_mu);
    whole_reads = to;
  }
};

TEST_F(ManyJobsTest, TrainingsScoresAndCostsReadNoWholeTableOfJobs) {
  const StudyId study = SubmitRequest(WithTrainings(Request({.pairs = 2, .variants = {"wide"}})));
  MakePairs();
  std::vector<std::string> noted;
  Note(&noted);
  TrainAll();
  EvaluateAll();
  EXPECT_TRUE(queue_->CostsOf(study).ok());
  const auto reader = PageReader::Open(options_.db_path, queue_->kinds());
  ASSERT_TRUE(reader.ok()) << reader.status();
  const auto scores = (*reader)->Scores(study.value);
  Note(nullptr);
  ASSERT_TRUE(scores.ok()) << scores.status();
  EXPECT_THAT(*scores, Not(IsEmpty()));
  EXPECT_THAT(noted, IsEmpty());
}

}  // namespace
}  // namespace parallax
