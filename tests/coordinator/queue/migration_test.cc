// A database of an older program, with jobs in every state, goes on under this one.
#include <sqlite3.h>

#include <fstream>
#include <map>
#include <sstream>

#include "coordinator/queue/database/database_file.h"
#include "coordinator/queue/database/migrations.h"
#include "queue_fixture.h"

namespace parallax {
namespace {

using testing::Pair;
using testing::SizeIs;
using testing::UnorderedElementsAre;

class MigrationTest : public QueueTest {
 protected:
  void SetUp() override {
    // The clock of the program that left it, a minute later.
    clock_.Advance(760);
    std::ifstream file(PARALLAX_EVERY_STATE_V1);
    std::stringstream dump;
    dump << file.rdbuf();
    ASSERT_FALSE(dump.str().empty());
    Run(dump.str());
  }
  void Run(const std::string& sql) {
    sqlite3* db = nullptr;
    ASSERT_EQ(sqlite3_open(options_.db_path.c_str(), &db), SQLITE_OK);
    char* error = nullptr;
    EXPECT_EQ(sqlite3_exec(db, sql.c_str(), nullptr, nullptr, &error), SQLITE_OK) << error;
    sqlite3_close(db);
  }
  int64_t Number(const std::string& sql) {
    sqlite3* db = nullptr;
    EXPECT_EQ(sqlite3_open(options_.db_path.c_str(), &db), SQLITE_OK);
    sqlite3_stmt* statement = nullptr;
    EXPECT_EQ(sqlite3_prepare_v2(db, sql.c_str(), -1, &statement, nullptr), SQLITE_OK) << sql;
    EXPECT_EQ(sqlite3_step(statement), SQLITE_ROW) << sql;
    const int64_t value = sqlite3_column_int64(statement, 0);
    sqlite3_finalize(statement);
    sqlite3_close(db);
    return value;
  }
  std::map<std::string, int64_t> JobsByState(StudyId study) {
    std::map<std::string, int64_t> jobs;
    const v1::StudyStatus status = Status(study);
    for (const v1::VariantStatus& variant : status.variants()) {
      for (const v1::JobCount& count : variant.jobs()) {
        jobs[count.kind() + " " + count.state()] += count.jobs();
      }
    }
    return jobs;
  }
};

TEST_F(MigrationTest, EveryRowOfVersionOneComesOver) {
  ASSERT_EQ(Number("PRAGMA user_version"), 1);
  const char* const kTables[] = {"jobs",   "scenes",         "studies",    "variants",
                                 "frames", "attempt_losses", "job_counts", "audit"};
  // Old tables whose rows are in `results` now, with their stages.
  const std::pair<const char*, const char*> kResults[] = {{"layout_results", "layout"},
                                                          {"recipes", "recipe"},
                                                          {"scene_results", "scene"},
                                                          {"frame_results", "frame"}};
  std::map<std::string, int64_t> results;
  for (const auto& [table, stage] : kResults) {
    results[stage] = Number(std::string("SELECT count(*) FROM ") + table);
    EXPECT_GT(results[stage], 0) << table;
  }
  std::map<std::string, int64_t> rows;
  for (const char* table : kTables) {
    rows[table] = Number(std::string("SELECT count(*) FROM ") + table);
    EXPECT_GT(rows[table], 0) << table;
  }
  const int64_t fences = Number("SELECT max(fence) + count(DISTINCT fence) FROM jobs");
  Reopen();
  EXPECT_EQ(queue_->schema_version(), NewestSchemaVersion());
  EXPECT_THAT(JobsByState(StudyId{3}),
              UnorderedElementsAre(
                  Pair("solve SUCCEEDED", 3), Pair("solve REJECTED", 3), Pair("solve FAILED", 1),
                  Pair("solve QUARANTINED", 1), Pair("solve RETRY_WAIT", 1),
                  Pair("solve LEASED", 3), Pair("solve BLOCKED", 2), Pair("solve READY", 31),
                  Pair("render SUCCEEDED", 1), Pair("render LEASED", 1), Pair("render READY", 1)));
  ExpectSound();
  queue_.reset();
  for (const auto& [table, n] : rows) {
    EXPECT_EQ(Number("SELECT count(*) FROM " + table), n) << table;
  }
  for (const auto& [stage, n] : results) {
    EXPECT_EQ(Number("SELECT count(*) FROM results WHERE stage = '" + stage + "'"), n) << stage;
  }
  EXPECT_EQ(Number("SELECT max(fence) + count(DISTINCT fence) FROM jobs"), fences);
  EXPECT_EQ(Number("SELECT count(*) FROM litter"), 2) << "of the two lost render attempts";
  EXPECT_EQ(Number("SELECT count(*) FROM pragma_foreign_key_check"), 0);
}

TEST_F(MigrationTest, StudiesKnowWhoSubmittedThemAndHaveNoLimit) {
  Run("INSERT INTO audit(unix_s, actor, action, study_id, detail) SELECT 1, 'someone', 'pause', 1, "
      "''");
  Run("DROP TRIGGER audit_is_final; UPDATE audit SET actor = 'submitter ada ipv4:10.0.0.7:4711'"
      " WHERE action = 'submit' AND study_id = 3;"
      " UPDATE audit SET actor = 'operator root unix:' WHERE action = 'submit' AND study_id = 4");
  Reopen();
  EXPECT_EQ(Status(StudyId{1}).user(), "local");
  EXPECT_EQ(Status(StudyId{3}).user(), "submitter ada");
  EXPECT_EQ(Status(StudyId{4}).user(), "operator root");
  EXPECT_EQ(Status(StudyId{3}).max_running(), 0);
  queue_->KeepSample({.unix_s = clock_.UnixSeconds(), .ready = 3});
  Tick();
  EXPECT_THAT(*queue_->ListSamples(0), SizeIs(1));
  // The leases of the older program count.
  ASSERT_TRUE(queue_->SetMaxRunning(StudyId{3}, 4, "", "tester").ok());
  EXPECT_THAT(Lease(AnyWorker("new"), 1), testing::IsEmpty());
  ASSERT_TRUE(queue_->SetMaxRunning(StudyId{3}, 5, "", "tester").ok());
  EXPECT_THAT(Lease(AnyWorker("new"), 3), SizeIs(1));
}

// Every version on the way to this one, with jobs in every state.
TEST_F(MigrationTest, EachVersionBetweenGoesOn) {
  for (int version = 2; version < NewestSchemaVersion(); ++version) {
    std::filesystem::remove(options_.db_path);
    SetUp();
    {
      auto db = OpenWriter(options_.db_path, "");
      ASSERT_TRUE(db.ok()) << db.status();
      ASSERT_TRUE(Migrate(**db, version).ok()) << version;
    }
    EXPECT_EQ(Number("PRAGMA user_version"), version);
    Reopen();
    EXPECT_EQ(queue_->schema_version(), NewestSchemaVersion());
    EXPECT_EQ(Status(StudyId{3}).user(), "local") << version;
    ExpectSound();
    queue_.reset();
    for (const char* suffix : {"-wal", "-shm"}) {
      std::filesystem::remove(options_.db_path + suffix);
    }
    clock_.Advance(-760);
  }
}

// Lists of studies ask for both on each look, and an archived study may have a million jobs.
TEST_F(MigrationTest, ProblemsAreFoundByAnIndexAlsoInTheArchive) {
  Reopen();
  const auto db = OpenReader(options_.db_path, options_.vfs);
  ASSERT_TRUE(db.ok()) << db.status();
  const std::pair<std::string, std::string> tables[] = {{"jobs", "jobs_problem"},
                                                        {"archived_jobs", "archived_jobs_problem"}};
  for (const auto& [table, index] : tables) {
    const std::string where = " WHERE state IN ('FAILED', 'QUARANTINED') AND variant_id ";
    for (const std::string& variants : {std::string("= 1 ORDER BY finished_unix_s DESC, id DESC"),
                                        std::string("IN (SELECT id FROM variants)")}) {
      const std::string sql =
          "EXPLAIN QUERY PLAN SELECT error FROM " + table + where + variants + " LIMIT 10";
      SqliteQuery query(**db, sql.c_str());
      std::string plan;
      while (query.Next()) plan += std::string(query.Text(3)) + "\n";
      ASSERT_TRUE(query.status().ok()) << query.status();
      EXPECT_THAT(plan, testing::HasSubstr("INDEX " + index + " ")) << sql;
    }
  }
}

TEST_F(MigrationTest, WorkOfVersionOneGoesOnToItsEnd) {
  v1::AttemptId old;
  old.set_job_id(Number("SELECT id FROM jobs WHERE state = 'LEASED' AND kind = 'render'"));
  old.set_fence(static_cast<uint64_t>(
      Number("SELECT fence FROM jobs WHERE id = " + std::to_string(old.job_id()))));
  Reopen();
  // A worker that held a lease under the old program holds it under the new one.
  EXPECT_THAT(*queue_->Adopt("w8", {old}), SizeIs(1));
  EXPECT_EQ(*queue_->HandBack("w8", old, "drain"), v1::REPORT_OUTCOME_OK);
  clock_.Advance(700);  // Leases expire, back-offs end.
  Tick();
  // Its results are still reused, its keys still known.
  EXPECT_EQ(Submit({.name = "cancelled", .seed = 2, .pairs = 4, .key = "key-2"}).value, 2);
  ASSERT_TRUE(queue_->Resume(StudyId{4}, "now", "tester").ok());
  WorkOff(AnyWorker("new"));
  for (const int64_t study : {3, 4}) {
    EXPECT_EQ(Status(StudyId{study}).state(), v1::STUDY_STATE_SUCCEEDED) << study;
  }
}

TEST_F(MigrationTest, AMigrationThatWouldLoseWhatOthersNameIsUndone) {
  Run("PRAGMA foreign_keys = OFF; DELETE FROM studies WHERE id = 1");
  const auto queue = JobQueue::Open(options_);
  EXPECT_EQ(queue.status().code(), absl::StatusCode::kDataLoss) << queue.status();
  EXPECT_EQ(Number("PRAGMA user_version"), 1);
}

}  // namespace
}  // namespace parallax
