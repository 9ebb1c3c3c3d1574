// Files that are not as the queue has left them: a page that the disk has changed, a log that is
// gone.
#include <sqlite3.h>

#include <fstream>

#include "common/base/system/file.h"
#include "coordinator/queue/database/database_file.h"
#include "coordinator/queue/database/page_checksum.h"
#include "coordinator/queue/database_tools.h"
#include "queue_fixture.h"
#include "tests/faults/simulate/power_cut_vfs.h"

namespace parallax {
namespace {

namespace fs = std::filesystem;

using testing::HasSubstr;

class DamageTest : public QueueTest {
 protected:
  // The open database's files, as a kill would leave them, under another name.
  std::string Killed() {
    const std::string copy = dir_ + "/killed.db";
    for (const char* ending : {"", "-wal", ".lock"}) {
      fs::copy_file(options_.db_path + ending, copy + ending, fs::copy_options::overwrite_existing);
    }
    return copy;
  }
  absl::Status Open(const std::string& path) {
    JobQueueOptions options = options_;
    options.db_path = path;
    return JobQueue::Open(options).status();
  }
  static bool Checksums(const std::string& path) {
    const auto db = SqliteConnection::Open(path, SqliteConnection::Mode::kReadOnly);
    EXPECT_TRUE(db.ok() && (*db)->Integer("SELECT count(*) FROM sqlite_master").ok());
    return HasChecksums((*db)->raw());
  }
  // Reads every page.
  absl::Status Copy(const std::string& path) {
    fs::remove(dir_ + "/copy.db");
    return BackUpFile(path, dir_ + "/copy.db");
  }
};

TEST_F(DamageTest, AnyFlippedBitOfTheDatabaseIsFound) {
  Submit({.pairs = 40});
  queue_.reset();
  const std::string sound = *ReadFile(options_.db_path);
  ASSERT_TRUE(Copy(options_.db_path).ok());
  EXPECT_TRUE(Checksums(dir_ + "/copy.db")) << "a copy has checksums, too";
  const std::string path = dir_ + "/flipped.db";
  // Each byte of the header, whose 16, 17 and 20 say how pages lie; fewer and fewer later.
  for (size_t at = 0; at < sound.size(); at = at < 100 ? at + 1 : at * 21 / 20) {
    const bool all_bits = at == 16 || at == 17 || at == 20;
    for (int bit = 0; bit < 8; ++bit) {
      if (!all_bits && bit != static_cast<int>(at % 8)) continue;
      std::string bytes = sound;
      bytes[at] = static_cast<char>(bytes[at] ^ (1 << bit));
      ASSERT_TRUE(WriteFile(path, bytes).ok());
      EXPECT_FALSE(Copy(path).ok()) << "bit " << bit << " of byte " << at;
    }
  }
  std::string bytes = sound;
  bytes[sound.size() / 2] ^= 1;
  ASSERT_TRUE(WriteFile(path, bytes).ok());
  EXPECT_EQ(Copy(path).code(), absl::StatusCode::kDataLoss);
}

TEST_F(DamageTest, ADatabaseWithoutChecksumsIsStillRead) {
  const std::string path = dir_ + "/older.db";
  {
    const auto db = SqliteConnection::Open(path, SqliteConnection::Mode::kReadWriteCreate);
    ASSERT_TRUE(db.ok() && (*db)->Execute("PRAGMA journal_mode = WAL; CREATE TABLE t(x)").ok());
  }
  EXPECT_TRUE(Copy(path).ok());
  EXPECT_FALSE(Checksums(path));
  EXPECT_FALSE(Checksums(dir_ + "/copy.db"));
}

TEST_F(DamageTest, ALogThatIsGoneIsMissed) {
  Submit({.name = "acknowledged"});
  const std::string path = Killed();
  fs::remove(path + "-wal");
  absl::Status status = Open(path);
  EXPECT_EQ(status.code(), absl::StatusCode::kDataLoss) << status;
  EXPECT_THAT(std::string(status.message()), HasSubstr("killed.db-wal is gone"));
  EXPECT_EQ(AuditDatabaseFile(path).status().code(), absl::StatusCode::kDataLoss);
  EXPECT_EQ(Open(path).code(), absl::StatusCode::kDataLoss) << "as often as it is asked";
  fs::remove(path + ".lock");
  status = Open(path);
  EXPECT_TRUE(status.ok()) << "it was said so: " << status;
}

TEST_F(DamageTest, ALogThatWasPutIntoTheDatabaseIsNotMissed) {
  Submit({.name = "acknowledged"});
  std::string path = Killed();
  EXPECT_TRUE(Open(path).ok());
  EXPECT_FALSE(fs::exists(path + "-wal"));
  EXPECT_TRUE(Open(path).ok()) << "it was closed";
  path = Killed();
  EXPECT_TRUE(AuditDatabaseFile(path).ok());
  EXPECT_FALSE(fs::exists(path + "-wal"));
  EXPECT_TRUE(Open(path).ok()) << "it was looked at";
}

// A disk that sometimes does not give a page after the second.
struct ErringDisk {
  static inline int errors = 0;  // To come.
  static inline const sqlite3_io_methods* real = nullptr;
  static inline sqlite3_io_methods methods{};

  static int Read(sqlite3_file* file, void* bytes, int amount, sqlite3_int64 offset) {
    constexpr sqlite3_int64 kPageBytes = 4096;
    if (errors > 0 && offset >= 2 * kPageBytes) {
      --errors;
      return SQLITE_IOERR_READ;
    }
    return real->xRead(file, bytes, amount, offset);
  }
  static int Open(sqlite3_vfs* vfs, sqlite3_filename name, sqlite3_file* file, int flags,
                  int* out_flags) {
    const auto system = static_cast<sqlite3_vfs*>(vfs->pAppData);
    const int code = system->xOpen(system, name, file, flags, out_flags);
    if (code != SQLITE_OK || (flags & SQLITE_OPEN_MAIN_DB) == 0) return code;
    real = file->pMethods;
    methods = *real;
    methods.xRead = Read;
    file->pMethods = &methods;
    return code;
  }
};

TEST_F(DamageTest, ADiskThatErrsInAnAuditIsNoDamage) {
  Submit({.pairs = 40});
  queue_.reset();  // All of it is in the file.
  sqlite3_vfs* const system = sqlite3_vfs_find(nullptr);
  sqlite3_vfs vfs = *system;
  vfs.zName = "erring";
  vfs.pAppData = system;
  vfs.xOpen = ErringDisk::Open;
  sqlite3_vfs_register(&vfs, 0);
  {
    JobQueueOptions options = options_;
    options.vfs = "erring";
    const auto queue = JobQueue::Open(options);
    ASSERT_TRUE(queue.ok()) << queue.status();
    ErringDisk::errors = 1;
    const auto found = (*queue)->Check();
    EXPECT_EQ(found.status().code(), absl::StatusCode::kUnavailable) << found.status();
    EXPECT_THAT(std::string(found.status().message()), HasSubstr("database: disk I/O error"));
    EXPECT_THAT(*(*queue)->Check(), testing::IsEmpty());
  }
  sqlite3_vfs_unregister(&vfs);
}

TEST_F(DamageTest, AFirstStartWhoseDiskErrsOnceSaysSoInOneLineAndTheNextOneRecovers) {
  faults::RegisterPowerCutVfs();
  JobQueueOptions options = options_;
  options.vfs = faults::kPowerCutVfs;
  options.own_threads = false;  // The errors that come after it are no matter of the start.
  int refused = 0;
  for (int64_t at = 1; at < 3000; at = at < 60 ? at + 1 : at * 5 / 4) {
    options.db_path = dir_ + "/first-" + std::to_string(at) + ".db";
    faults::SetVfsPlan({.errors = {.at = at, .reads = true}});
    const absl::Status status = JobQueue::Open(options).status();
    if (status.ok()) continue;
    ++refused;
    EXPECT_EQ(status.code(), absl::StatusCode::kUnavailable) << at << ": " << status;
    EXPECT_THAT(std::string(status.message()), HasSubstr("disk I/O error"));
    faults::SetVfsPlan({});
    const absl::Status again = JobQueue::Open(options).status();
    EXPECT_TRUE(again.ok()) << at << ": " << again;
  }
  EXPECT_GT(refused, 40);
  faults::SetVfsPlan({});
}

// As the disk's errors make a start do.
TEST_F(DamageTest, AStartThatGivesUpEarlyLeavesTheLog) {
  Submit({.name = "acknowledged"});
  const std::string path = Killed();
  {
    const auto lock = DatabaseLock::Acquire(path);
    ASSERT_TRUE(lock.ok() && OpenWriter(path, "").ok());
  }
  EXPECT_TRUE(fs::exists(path + "-wal"));
  const absl::Status status = Open(path);
  EXPECT_TRUE(status.ok()) << status;
}

}  // namespace
}  // namespace parallax
