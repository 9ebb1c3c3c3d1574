// The file under the queue: who may open it, what it refuses to hold, what the auditor finds in it.
#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <fstream>
#include <thread>
#include <utility>

#include "common/base/status.h"
#include "coordinator/queue/database/database_file.h"
#include "coordinator/queue/database/migrations.h"
#include "coordinator/queue/database_tools.h"
#include "coordinator/queue/reads/auditor.h"
#include "coordinator/queue/tables/ledger.h"
#include "queue_fixture.h"
#include "tests/sqlite_by_hand.h"

namespace parallax {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

class StorageTest : public QueueTest {
 protected:
  // Changes the closed database by hand.
  void Meddle(const std::string& sql) {
    queue_.reset();
    sqlite3* db = OpenByHand(options_.db_path);
    ASSERT_NE(db, nullptr);
    char* error = nullptr;
    EXPECT_EQ(sqlite3_exec(db, sql.c_str(), nullptr, nullptr, &error), SQLITE_OK) << error;
    sqlite3_close(db);
  }
  absl::Status OpenStatus() { return JobQueue::Open(options_).status(); }
};

TEST_F(StorageTest, ASecondCoordinatorIsRefused) {
  const absl::Status status = OpenStatus();
  EXPECT_EQ(status.code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(std::string(status.message()), HasSubstr("open in another coordinator (process "));
  EXPECT_EQ(AuditDatabaseFile(options_.db_path).status().code(),
            absl::StatusCode::kFailedPrecondition);
}

// The same file under other names: a link, a link to its folder, a second name.
TEST_F(StorageTest, TheLockIsOnTheFileAndNotOnItsName) {
  const std::string file = options_.db_path;
  std::filesystem::create_symlink(file, dir_ + "/link.db");
  std::filesystem::create_directory_symlink(dir_, dir_ + "/again");
  for (const char* name : {"/link.db", "/again/queue.db", "/second.db"}) {
    options_.db_path = dir_ + name;
    if (options_.db_path.ends_with("second.db")) {
      std::filesystem::create_hard_link(file, options_.db_path);
    }
    EXPECT_EQ(OpenStatus().code(), absl::StatusCode::kFailedPrecondition) << name;
    // In another process, which does not know what this one holds.
    const pid_t child = fork();
    if (child == 0) {
      const auto lock = DatabaseLock::Acquire(options_.db_path);
      _exit(absl::IsFailedPrecondition(lock.status()) ? 0 : 1);
    }
    int status = -1;
    ASSERT_EQ(waitpid(child, &status, 0), child);
    EXPECT_EQ(status, 0) << name;
  }
  options_.db_path = file;
  queue_.reset();
  EXPECT_THAT(std::string(OpenStatus().message()), HasSubstr("has 2 names"));
  std::filesystem::remove(dir_ + "/second.db");
  Reopen();
}

TEST_F(StorageTest, ARefusedOpeningLeavesTheLocksOfTheFirst) {
  const auto is_locked = [this] {
    const pid_t child = fork();
    if (child == 0) {
      const int fd = open(options_.db_path.c_str(), O_RDWR);
      struct flock lock {};
      lock.l_type = F_WRLCK;
      _exit(fd >= 0 && fcntl(fd, F_GETLK, &lock) == 0 && lock.l_type != F_UNLCK ? 0 : 1);
    }
    int status = -1;
    return waitpid(child, &status, 0) == child && status == 0;
  };
  ASSERT_TRUE(is_locked());
  std::filesystem::create_symlink(options_.db_path, dir_ + "/link.db");
  EXPECT_FALSE(DatabaseLock::Acquire(dir_ + "/link.db").ok());
  EXPECT_TRUE(is_locked());
}

TEST_F(StorageTest, NetworkFileSystemsAreKnownByTheirNumbers) {
  EXPECT_STREQ(NetworkFileSystem(0x6969), "NFS");
  EXPECT_STREQ(NetworkFileSystem(static_cast<int>(0xFF534D42)), "CIFS");  // Sign-extended.
  EXPECT_STREQ(NetworkFileSystem(0x65735546), "FUSE");
  for (const long local : {0xEF53L, 0x58465342L, 0x9123683EL, 0x01021994L, 0x794c7630L}) {
    EXPECT_EQ(NetworkFileSystem(local), nullptr) << local;
  }
}

TEST_F(StorageTest, AFolderThatIsNotThereIsNamed) {
  const std::string path = std::exchange(options_.db_path, dir_ + "/absent/queue.db");
  const absl::Status status = OpenStatus();
  options_.db_path = path;
  EXPECT_EQ(status.code(), absl::StatusCode::kNotFound);
  EXPECT_THAT(std::string(status.message()), HasSubstr("/absent"));
}

TEST_F(StorageTest, ADatabaseFromTheFutureIsRefusedUnchanged) {
  Meddle("PRAGMA user_version = 1000");
  const absl::Status status = OpenStatus();
  EXPECT_EQ(status.code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(std::string(status.message()), HasSubstr("from the future"));
  EXPECT_THAT(std::string(status.message()), HasSubstr("version 1000"));
}

TEST_F(StorageTest, AFileThatIsNotOursIsRefused) {
  queue_.reset();
  options_.db_path = dir_ + "/text.db";
  std::ofstream(options_.db_path) << std::string(10'000, 'x');
  EXPECT_EQ(OpenStatus().code(), absl::StatusCode::kDataLoss);

  options_.db_path = dir_ + "/foreign.db";
  Meddle("CREATE TABLE recipes(name TEXT)");
  EXPECT_EQ(OpenStatus().code(), absl::StatusCode::kDataLoss);
}

TEST_F(StorageTest, MigrationsAreNumberedWithoutGapsAndRunFromEveryVersion) {
  int expected = 1;
  for (const Migration& migration : AllMigrations()) {
    EXPECT_EQ(migration.number, expected++);
    EXPECT_EQ(std::atoi(migration.name), migration.number);
  }
  for (const Migration& from : AllMigrations()) {
    const std::string path = dir_ + "/from" + std::to_string(from.number) + ".db";
    {
      auto db = OpenWriter(path, "");
      ASSERT_TRUE(db.ok());
      ASSERT_TRUE(Migrate(**db, from.number).ok());
      EXPECT_EQ(**(*db)->Integer("PRAGMA user_version"), from.number);
    }
    JobQueueOptions options = options_;
    options.db_path = path;
    const auto queue = JobQueue::Open(options);
    ASSERT_TRUE(queue.ok()) << queue.status();
    EXPECT_EQ((*queue)->schema_version(), NewestSchemaVersion());
    EXPECT_THAT(*(*queue)->Check(), IsEmpty());
  }
}

TEST_F(StorageTest, ReadersCannotWrite) {
  const auto reader = OpenReader(options_.db_path, "");
  ASSERT_TRUE(reader.ok()) << reader.status();
  EXPECT_FALSE((*reader)->Run("UPDATE studies SET name = 'x'").ok());
}

// A broken index may cause this: the variant's row names a study that does not list the variant.
TEST_F(StorageTest, AVariantThatItsStudyDoesNotListIsDataLoss) {
  const StudyId study = Submit({.pairs = 2});
  queue_.reset();
  const auto db = OpenWriter(options_.db_path, "");
  ASSERT_TRUE(db.ok());
  const LimitRules no_limits;
  Ledger ledger(**db, KindRegistry::Builtin(), no_limits);
  ASSERT_TRUE(ledger.FindStudy(study.value).ok());
  ASSERT_TRUE((*db)
                  ->Run("INSERT INTO variants (id, study_id, name, config_z, pairs_wanted,"
                        " rigs_per_scene) SELECT 99, study_id, 'stray', config_z, 2, 1"
                        " FROM variants LIMIT 1")
                  .ok());
  const absl::Status status = ledger.FindVariant(99).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kDataLoss);
  EXPECT_THAT(std::string(status.message()), HasSubstr("variant 99"));
}

// A study that can't be read whole leaves nothing of itself in memory.
TEST_F(StorageTest, AStudyWithABrokenVariantIsNotHalfLoaded) {
  const StudyId study = Submit({.pairs = 2, .variants = {"a", "b"}});
  queue_.reset();
  const auto db = OpenWriter(options_.db_path, "");
  ASSERT_TRUE(db.ok());
  ASSERT_TRUE((*db)->Run("UPDATE variants SET config_z = x'00' WHERE name = 'b'").ok());
  const LimitRules no_limits;
  Ledger ledger(**db, KindRegistry::Builtin(), no_limits);
  const auto whole = (*db)->Integer("SELECT id FROM variants WHERE name = 'a'");
  ASSERT_TRUE(whole.ok());
  EXPECT_FALSE(ledger.FindStudy(study.value).ok());
  EXPECT_FALSE(ledger.FindVariant(**whole).ok());
  EXPECT_EQ(ledger.totals(), JobCounts{});
}

// Each is a move or a change that the schema itself must forbid.
TEST_F(StorageTest, TheSchemaForbidsWhatTheMachineNeverDoes) {
  Submit({.pairs = 6, .rigs_per_scene = 2});
  Complete(Answer(LeaseOne(Solver("w")), "w"));  // Job 1 SUCCEEDED, 4 READY render.
  Complete(Answer(LeaseOne(Renderer("w")), "w"));
  LeaseOne(Solver("w"));  // Job 2 LEASED; 3 READY.
  queue_.reset();
  const auto db = OpenWriter(options_.db_path, "");
  ASSERT_TRUE(db.ok());
  const struct {
    const char* sql;
    const char* message;
  } cases[] = {
      {"UPDATE jobs SET error = 'x' WHERE id = 1", "a job that has ended never changes"},
      {"UPDATE jobs SET state = 'READY', finished_unix_s = NULL WHERE id = 1", "never changes"},
      {"DELETE FROM jobs WHERE id = 3", "never deleted"},
      {"UPDATE jobs SET state = 'RETRY_WAIT', not_before_unix_s = 1 WHERE id = 3", "no such move"},
      {"UPDATE jobs SET state = 'FAILED', finished_unix_s = 1 WHERE id = 3", "no such move"},
      {"UPDATE jobs SET state = 'BLOCKED', awaits_job = 3 WHERE id = 2", "no such move"},
      {"UPDATE jobs SET state = 'LEASED' WHERE id = 3", "CHECK"},
      {"UPDATE jobs SET state = 'DONE' WHERE id = 3", "CHECK"},
      {"UPDATE jobs SET state = 'BLOCKED' WHERE id = 3", "CHECK"},
      {"UPDATE jobs SET state = 'SUCCEEDED' WHERE id = 2", "CHECK"},
      {"UPDATE jobs SET attempts = 'many' WHERE id = 2", "TEXT"},
      {"UPDATE variants SET pairs_done = pairs_wanted + 1", "CHECK"},
      {"UPDATE frames SET rig = 9", "never changes"},
      {"UPDATE results SET fence = 9", "never changes"},
      {"INSERT INTO frames(study_id, variant_id, ordinal, rig, frame_key, reused)"
       " SELECT study_id, variant_id, ordinal, rig, frame_key, 0 FROM frames",
       "UNIQUE"},
      {"INSERT INTO frames(study_id, variant_id, ordinal, rig, frame_key, reused)"
       " VALUES (1, 1, 5, 5, x'00', 0)",
       "FOREIGN KEY"},
      {"UPDATE audit SET actor = 'me'", "append-only"},
      {"DELETE FROM audit", "append-only"},
  };
  for (const auto& c : cases) {
    const absl::Status status = (*db)->Run(c.sql);
    EXPECT_FALSE(status.ok()) << c.sql;
    EXPECT_THAT(std::string(status.message()), HasSubstr(c.message)) << c.sql;
  }
}

TEST_F(StorageTest, TheAuditorFindsPlantedCorruption) {
  Submit({.pairs = 6, .rigs_per_scene = 2, .variants = {"a", "b"}});
  Submit({.name = "twin", .pairs = 6, .rigs_per_scene = 2});
  const auto leases = Lease(Solver("w"), 2);
  Complete(Answer(leases[0], "w"));
  Complete(Answer(LeaseOne(Renderer("w")), "w"));
  Fail(Failure(leases[1], "w", "boom"));
  LeaseOne(Solver("w"));
  ExpectSound();
  queue_.reset();
  const std::string original = options_.db_path;
  // Triggers and checks would not let these in; a bug beneath them, or a bad disk, might.
  const std::string open_up =
      "PRAGMA ignore_check_constraints = ON;"
      "DROP TRIGGER jobs_move; DROP TRIGGER jobs_stay; DROP TRIGGER results_are_final;";
  const struct {
    const char* sql;
    const char* found;
  } cases[] = {
      {"UPDATE job_counts SET jobs = jobs + 1 WHERE state = 'READY'", "job counts are right"},
      {"UPDATE variants SET pairs_done = pairs_done + 1", "pairs done are right"},
      {"UPDATE variants SET pairs_planned = pairs_planned - 1", "pairs planned are right"},
      {"UPDATE variants SET scenes_open = scenes_open + 1", "open scenes are counted"},
      {"UPDATE variants SET frames_reused = 7 WHERE id = 1", "reuse is counted right"},
      {"UPDATE variants SET scenes_rejected = 7 WHERE id = 1", "rejections are counted"},
      {"UPDATE variants SET next_ordinal = 9 WHERE id = 1", "without gaps"},
      {"UPDATE scenes SET jobs_open = jobs_open + 1", "counts its open jobs"},
      {"UPDATE scenes SET rigs_done = 0", "counts its frames"},
      {"UPDATE scenes SET scene_hash = NULL", "a solved scene has its result"},
      {"DELETE FROM frames WHERE cursor = 1", "has all its frames"},
      {"DELETE FROM jobs WHERE state IN ('READY', 'BLOCKED')", "done, lost or asked for"},
      {"UPDATE jobs SET state = 'READY', awaits_job = NULL WHERE state = 'BLOCKED'",
       "a ready job's work"},
      {"UPDATE jobs SET state = 'READY', worker = NULL WHERE state = 'LEASED'",
       "a blocked job awaits a lease"},
      {"UPDATE jobs SET fence = 77 WHERE kind = 'render' AND state = 'SUCCEEDED'",
       "issued by an epoch on record"},
      {"UPDATE jobs SET fence = (SELECT max(fence) FROM jobs) WHERE fence IS NOT NULL",
       "a fence names one attempt"},
      {"UPDATE jobs SET app_failures = 2 WHERE app_failures = 1", "the ledgers agree"},
      {"DELETE FROM attempt_losses", "the ledgers agree"},
      {"UPDATE jobs SET reused = 1 WHERE kind = 'solve' AND state = 'SUCCEEDED' AND reused = 0",
       "an attempt's or reused"},
      {"UPDATE studies SET cancelled = 1", "a cancelled study has nothing"},
      {"UPDATE studies SET finished_unix_s = 5", "finished exactly when"},
      {"UPDATE results SET bytes = x'0102' WHERE stage = 'recipe'", "a recipe hashes to its name"},
      {"UPDATE results SET fence = fence + 1 WHERE stage = 'frame'",
       "published by a job that ended with it"},
      {"UPDATE results SET bytes = x'00' WHERE stage = 'frame'", "in the winner's folder"},
      {"UPDATE jobs SET state = 'LEASED', fence = 1, worker = 'x', awaits_job = NULL"
       " WHERE state = 'BLOCKED'",
       "make one group's part"},
      {"PRAGMA foreign_keys = OFF; DELETE FROM studies WHERE id = 2", "foreign key"},
  };
  for (const auto& c : cases) {
    options_.db_path = dir_ + "/planted.db";
    std::filesystem::copy_file(original, options_.db_path,
                               std::filesystem::copy_options::overwrite_existing);
    Meddle(open_up + c.sql);
    const auto violations = AuditDatabaseFile(options_.db_path);
    ASSERT_TRUE(violations.ok()) << c.sql << violations.status();
    EXPECT_THAT(*violations, testing::Contains(HasSubstr(c.found))) << c.sql;
  }
}

TEST_F(StorageTest, AFileThatACoordinatorHasOpenCanBeCopied) {
  Submit({.pairs = 4});
  const std::string backup = dir_ + "/copy.db";
  EXPECT_EQ(BackUpFile(dir_ + "/none.db", backup).code(), absl::StatusCode::kNotFound);
  const absl::Status copied = BackUpFile(options_.db_path, backup);
  ASSERT_TRUE(copied.ok()) << copied;
  EXPECT_EQ(BackUpFile(options_.db_path, backup).code(), absl::StatusCode::kAlreadyExists);
  Submit({.name = "later"});
  const std::string id = queue_->database_id();
  options_.db_path = backup;
  Reopen();
  EXPECT_THAT(*queue_->ListStudies(10), SizeIs(1)) << "as it was when it was copied";
  EXPECT_EQ(queue_->database_id(), id) << "the same database";
  options_.db_path = dir_ + "/other.db";
  clock_.Advance(1);
  Reopen();
  EXPECT_NE(queue_->database_id(), id);
}

TEST_F(StorageTest, AReaderThatTakesTheWriteLockForAMomentIsWaitedFor) {
  sqlite3* reader = nullptr;
  ASSERT_EQ(sqlite3_open(options_.db_path.c_str(), &reader), SQLITE_OK);
  sqlite3_busy_timeout(reader, 10'000);  // The queue may be writing by itself.
  ASSERT_EQ(sqlite3_exec(reader, "BEGIN IMMEDIATE", nullptr, nullptr, nullptr), SQLITE_OK);
  std::thread submitting([this] { Submit({.name = "patient"}); });
  // Long enough for the writer to have met the lock; too short would only hide a failure.
  std::this_thread::sleep_for(std::chrono::milliseconds(50));
  EXPECT_EQ(sqlite3_exec(reader, "ROLLBACK", nullptr, nullptr, nullptr), SQLITE_OK);
  submitting.join();
  sqlite3_close(reader);
  EXPECT_THAT(*queue_->ListStudies(10), SizeIs(1));
}

TEST_F(StorageTest, ABackupIsWholeWhileWorkGoesOn) {
  const StudyId study = Submit({.pairs = 200, .rigs_per_scene = 2});
  std::atomic<bool> stop{false};
  std::thread worker([&] {
    while (!stop) {
      for (const v1::Lease& lease : Lease(AnyWorker("w"), 4)) Complete(Answer(lease, "w"));
    }
  });
  const std::string backup = dir_ + "/backup.db";
  EXPECT_TRUE(queue_->Backup(backup).ok());
  EXPECT_EQ(queue_->Backup(backup).code(), absl::StatusCode::kAlreadyExists);
  stop = true;
  worker.join();
  EXPECT_THAT(*AuditDatabaseFile(backup), IsEmpty());
  options_.db_path = backup;
  Reopen();
  clock_.Advance(31);
  Tick();
  WorkOff(AnyWorker("v"));
  EXPECT_EQ(Status(study).state(), v1::STUDY_STATE_SUCCEEDED);
}

TEST_F(StorageTest, ManyThreadsShareCommits) {
  options_.linger_s = 0.002;
  Reopen();
  const StudyId study = Submit({.pairs = 400, .rigs_per_scene = 1});
  std::vector<std::thread> threads;
  for (int i = 0; i < 16; ++i) {
    threads.emplace_back([this, name = "w" + std::to_string(i)] {
      int dry = 0;
      while (dry < 50) {
        const auto leases = queue_->Lease(AnyWorker(name), 2);
        ASSERT_TRUE(leases.ok());
        dry = leases->empty() ? dry + 1 : 0;
        for (const v1::Lease& lease : *leases) {
          ASSERT_EQ(*queue_->Complete(Answer(lease, name)), v1::REPORT_OUTCOME_OK);
        }
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(Status(study).state(), v1::STUDY_STATE_SUCCEEDED);
  const JobQueueStats stats = queue_->Stats();
  EXPECT_GT(stats.commands, 2 * stats.commits);
  EXPECT_EQ(stats.completions, 800u);
  EXPECT_EQ(stats.leases_granted, 800u);
  EXPECT_EQ(stats.leases_held, 0);
  EXPECT_EQ((stats.jobs.at({"render", "SUCCEEDED"})), 400);
}

TEST_F(StorageTest, AFailedCommandLeavesNothing) {
  std::atomic<bool> armed = false;  // The writer's thread reads them.
  std::atomic<int> at = 0;
  options_.fail_point = [&](const std::string& command, int step) {
    return armed && command != "commit" && command != "expand" && command != "settle" && step == at
               ? Internal("fail point")
               : absl::OkStatus();
  };
  Reopen();
  const StudyId study = Submit({.pairs = 6, .rigs_per_scene = 2, .variants = {"a", "b"}});
  // Each step of each command fails once; then the command is let through.
  const auto insist = [&](const std::function<absl::Status()>& command) {
    armed = true;
    for (at = 1;; ++at) {
      const absl::Status status = command();
      if (status.ok()) break;
      EXPECT_EQ(status.message(), "fail point");
      ASSERT_LT(at.load(), 200);
    }
    armed = false;
    EXPECT_GT(at.load(), 1);
    ExpectSound();
  };
  const auto all_of = [&](const char* worker) {
    std::vector<v1::Lease> leases;
    insist([&] {
      auto got = queue_->Lease(AnyWorker(worker), 2);
      if (got.ok()) leases = *got;
      return got.status();
    });
    return leases;
  };
  auto leases = all_of("w");
  ASSERT_THAT(leases, SizeIs(2));
  insist([&] { return queue_->Complete(Answer(leases[0], "w")).status(); });
  insist([&] { return queue_->Complete(RejectAnswer(leases[1], "w", false)).status(); });
  leases = all_of("v");
  ASSERT_THAT(leases, SizeIs(2));
  insist([&] { return queue_->Fail(Failure(leases[0], "v", "boom", false)).status(); });
  insist([&] { return queue_->WorkerLost("v").status(); });
  insist([&] { return queue_->Submit(MakeStudy({.name = "two", .pairs = 3}), "t").status(); });
  insist([&] { return queue_->Pause(study, "", "t"); });
  insist([&] { return queue_->Resume(study, "", "t"); });
  insist([&] { return queue_->Cancel(study, "", "t"); });
  WorkOff(AnyWorker("u"));
}

// Kills the process at each step of each command, in a child, and audits what is left.
TEST_F(StorageTest, AProcessKilledAtAnyStepLeavesASoundDatabase) {
  queue_.reset();
  const auto child_life = [&](const char* command, int step) {
    options_.fail_point = [=](const std::string& seen, int at) {
      if (seen == command && at == step) raise(SIGKILL);
      return absl::OkStatus();
    };
    auto opened = JobQueue::Open(options_);
    if (!opened.ok()) _exit(3);
    JobQueue& queue = **opened;
    (void)queue.Submit(MakeStudy({.pairs = 6, .rigs_per_scene = 2, .variants = {"a", "b"}}), "t");
    for (int i = 0; i < 4; ++i) {
      const auto leases = queue.Lease(AnyWorker("w"), 2);
      for (size_t j = 0; leases.ok() && j < leases->size(); ++j) {
        const v1::Lease& lease = (*leases)[j];
        if (i == 1 && j == 0) {
          (void)queue.Fail(Failure(lease, "w", "boom", false));
        } else {
          (void)queue.Complete(Answer(lease, "w"));
        }
      }
    }
    (void)queue.Cancel(StudyId{1}, "", "t");
    _exit(0);
  };
  int killed = 0;
  for (const char* command :
       {"submit", "expand", "lease", "complete", "fail", "cancel", "settle", "commit"}) {
    for (int step = 1; step < 60; step += step < 6 ? 1 : 7) {
      std::filesystem::remove(options_.db_path);
      std::filesystem::remove(options_.db_path + "-wal");
      std::filesystem::remove(options_.db_path + "-shm");
      const pid_t pid = fork();
      if (pid == 0) child_life(command, step);
      int status = 0;
      ASSERT_EQ(waitpid(pid, &status, 0), pid);
      if (WIFEXITED(status)) {
        ASSERT_EQ(WEXITSTATUS(status), 0);
        break;  // The command has no such step.
      }
      ++killed;
      Reopen();
      ExpectSound();
      clock_.Advance(31);
      Tick();
      WorkOff(AnyWorker("v"));
      ExpectSound();
      queue_.reset();
    }
  }
  EXPECT_GE(killed, 30);
}

}  // namespace
}  // namespace parallax
