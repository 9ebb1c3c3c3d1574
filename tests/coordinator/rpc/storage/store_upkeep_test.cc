// The store under a database: whose it is, whether it is there, and whether its files are what they
// were.
#include <filesystem>
#include <fstream>
#include <set>

#include "common/base/hash.h"
#include "common/base/system/file.h"
#include "common/store/local_store.h"
#include "common/store/store_guard.h"
#include "coordinator/rpc/storage/scrubber.h"
#include "coordinator/rpc/storage/store_claim.h"
#include "tests/coordinator/queue/queue_fixture.h"

namespace parallax {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

class StoreUpkeepTest : public QueueTest {
 protected:
  // Opens the database with its store, as `coordinator serve` does.
  absl::Status Open(bool adopt = false) {
    queue_.reset();
    store_.reset();
    options_.open_store = [this, adopt](const KnownStore& known) -> absl::StatusOr<std::string> {
      ASSIGN_OR_RETURN(store_, ClaimStore(Dir(), known, adopt));
      presence_ = std::make_unique<FilePresence>(*store_);
      return store_->Id();
    };
    options_.files_there = [this](const std::vector<JobKind::OutputFile>& files) {
      return presence_->Has(files);
    };
    auto queue = JobQueue::Open(options_);
    if (queue.ok()) queue_ = *std::move(queue);
    return queue.status();
  }
  void SetUp() override { ASSERT_TRUE(Open().ok()); }
  std::string Dir() const { return dir_ + "/store"; }

  // A worker's answer, whose files it has put into the store.
  v1::CompleteRequest WithFiles(const v1::Lease& lease) {
    v1::CompleteRequest request = Answer(lease, "w");
    if (lease.kind() != "render") return request;
    EditRender(request, [&](v1::RenderResult& result) {
      for (v1::FrameResult& frame : *result.mutable_frames()) {
        for (v1::FileEntry& file : *frame.mutable_files()) {
          const std::string bytes = frame.path() + file.name() + std::string(1000, 'x');
          file.set_size(static_cast<int64_t>(bytes.size()));
          file.set_sha256(Sha256Hex(bytes));
          EXPECT_TRUE(store_->Put(frame.path() + "/" + file.name(), bytes).ok());
        }
      }
    });
    return request;
  }
  int Work() {
    int jobs = 0;
    for (auto leases = Lease(AnyWorker("w"), 8); !leases.empty();
         leases = Lease(AnyWorker("w"), 8)) {
      for (const v1::Lease& lease : leases) {
        EXPECT_EQ(Complete(WithFiles(lease)), v1::REPORT_OUTCOME_OK);
        ++jobs;
      }
    }
    return jobs;
  }
  std::vector<std::string> FilesOf(StudyId study) {
    std::vector<std::string> files;
    for (const v1::PublishedFrame& frame : Frames(study)) {
      for (const v1::FileEntry& file : frame.frame().files()) {
        files.push_back(Dir() + "/" + frame.frame().path() + "/" + file.name());
      }
    }
    return files;
  }
  static void Flip(const std::string& path, std::streamoff at) {
    std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
    file.seekg(at);
    const char byte = static_cast<char>(file.get() ^ 1);
    file.seekp(at);
    file.put(byte);
  }
  // A folder in its place: reading it is an error, but not that it is not there.
  static void MakeUnreadable(const std::string& path) {
    fs::remove(path);
    fs::create_directory(path);
  }
  v1::StudyState State(StudyId study) { return Status(study).state(); }

  std::unique_ptr<Store> store_;
  std::unique_ptr<FilePresence> presence_;
};

// ---- Whose it is
TEST_F(StoreUpkeepTest, AnEmptyFolderWhereThereWasAStoreIsRefused) {
  const std::string id = store_->Id();
  fs::rename(Dir(), dir_ + "/disk");
  for (const bool make : {false, true}) {
    if (make) fs::create_directory(Dir());
    const absl::Status status = Open();
    EXPECT_TRUE(absl::IsFailedPrecondition(status)) << status;
    EXPECT_THAT(std::string(status.message()), HasSubstr("results are in the store " + id));
    EXPECT_THAT(std::string(status.message()), HasSubstr("--adopt-store"));
    EXPECT_FALSE(make && !fs::is_empty(Dir())) << "nothing is written there";
  }
  fs::remove(Dir());
  fs::rename(dir_ + "/disk", Dir());
  EXPECT_TRUE(Open().ok());
  EXPECT_EQ(store_->Id(), id);
}

TEST_F(StoreUpkeepTest, AnotherStoreIsRefusedUnlessItIsAdopted) {
  const std::string id = store_->Id();
  fs::rename(Dir(), dir_ + "/disk");
  const std::string other = (*OpenStore(Dir()))->Id();
  EXPECT_THAT(std::string(Open().message()), HasSubstr("it is the store " + other));
  ASSERT_TRUE(Open(/*adopt=*/true).ok());
  EXPECT_EQ((*queue_->ListAudit({}))[0].detail(), id + " is replaced by " + other);
  ASSERT_TRUE(Open().ok()) << "from then on it is the database's";
}

TEST_F(StoreUpkeepTest, AStoreBelongsToOneDatabase) {
  const std::string first = queue_->database_id();
  queue_.reset();
  const std::string db = options_.db_path;
  options_.db_path = dir_ + "/other.db";
  clock_.Advance(10);
  const absl::Status status = Open();
  EXPECT_THAT(std::string(status.message()), HasSubstr("belongs to the database " + first));
  options_.db_path = db;
  EXPECT_TRUE(Open().ok());
}

TEST_F(StoreUpkeepTest, ADatabaseFromBeforeItKeptAnIdKnowsItsStoreByItsResults) {
  Submit();
  Work();
  KnownStore old;
  old.database_id = queue_->database_id();
  old.sample = queue_->ListStoredOutputs("", 1)->front().files;
  EXPECT_TRUE(ClaimStore(Dir(), old, false).ok());
  EXPECT_TRUE(absl::IsFailedPrecondition(ClaimStore(dir_ + "/absent", old, false).status()));
  ASSERT_TRUE(OpenStore(dir_ + "/other").ok());
  const absl::Status other = ClaimStore(dir_ + "/other", old, false).status();
  EXPECT_THAT(std::string(other.message()), HasSubstr("newest results are not there"));
}

// ---- Whether it is there
TEST_F(StoreUpkeepTest, AStoreThatGoesIsNoticedAndSoIsItsReturn) {
  std::vector<bool> changes;
  StoreGuard guard(*store_, {.every_s = 3600, .changed = [&changes](const absl::Status& status) {
                               changes.push_back(status.ok());
                             }});
  EXPECT_TRUE(guard.Look().ok());
  fs::rename(Dir(), dir_ + "/disk");
  EXPECT_TRUE(absl::IsUnavailable(guard.Look()));
  fs::create_directory(Dir());
  EXPECT_TRUE(absl::IsUnavailable(guard.Look())) << "a bare mount point";
  ASSERT_TRUE(OpenStore(Dir()).ok());
  EXPECT_THAT(std::string(guard.Look().message()), HasSubstr("wanted is " + store_->Id()));
  fs::remove_all(Dir());
  fs::rename(dir_ + "/disk", Dir());
  EXPECT_TRUE(guard.Look().ok());
  EXPECT_EQ(changes, (std::vector<bool>{false, true}));
}

TEST_F(StoreUpkeepTest, WhileTheStoreIsGoneNothingCountsAsLost) {
  const StudyId study = Submit();
  Work();
  fs::rename(Dir(), dir_ + "/disk");
  fs::create_directory(Dir());
  Scrubber scrubber(*queue_, *store_, {.clock = &clock_});
  // The open store still sees its files where they are now; by name there is nothing.
  EXPECT_FALSE(scrubber.Pass([](const DamagedResult&) { ADD_FAILURE(); }).ok());
  EXPECT_EQ(State(study), v1::STUDY_STATE_SUCCEEDED);
  EXPECT_THAT(Frames(study), SizeIs(4));
}

// ---- Whether its files are what they were
TEST_F(StoreUpkeepTest, OneByteInEachOfFiftyFilesIsFoundToldAndRepaired) {
  const StudyId study = Submit({.pairs = 24});
  Work();
  const std::vector<std::string> files = FilesOf(study);
  ASSERT_GT(files.size(), 60u);
  std::set<std::string> pairs;
  for (size_t i = 0; i < 50; ++i) {
    const std::string& file = files[i * files.size() / 50];
    Flip(file, static_cast<std::streamoff>(i * 13));
    pairs.insert(file.substr(0, file.rfind('/')));
  }
  std::set<std::string> told;
  Scrubber scrubber(*queue_, *store_, {.clock = &clock_});
  const auto pass =
      scrubber.Pass([&told](const DamagedResult& damaged) { told.insert(damaged.folder); });
  ASSERT_TRUE(pass.ok()) << pass.status();
  EXPECT_EQ(told.size(), pairs.size());
  for (const std::string& pair : pairs) EXPECT_EQ(told.count(fs::relative(pair, Dir())), 1u);
  EXPECT_EQ(pass->damaged, static_cast<int64_t>(pairs.size()));
  EXPECT_EQ(State(study), v1::STUDY_STATE_RUNNING);
  EXPECT_EQ(Status(study).variants(0).pairs_done(), 24 - static_cast<int64_t>(pairs.size()));
  ExpectSound();
  Work();
  EXPECT_EQ(State(study), v1::STUDY_STATE_SUCCEEDED);
  const auto again = scrubber.Pass([](const DamagedResult&) { ADD_FAILURE(); });
  ASSERT_TRUE(again.ok()) << again.status();
  EXPECT_EQ(again->damaged, 0);
}

TEST_F(StoreUpkeepTest, AMissingAndAShortFileAreDamageAndWithoutRepairNothingChanges) {
  const StudyId study = Submit();
  Work();
  const std::vector<std::string> files = FilesOf(study);
  fs::remove(files.front());
  fs::resize_file(files.back(), 7);
  std::vector<std::string> told;
  Scrubber scrubber(*queue_, *store_, {.repair = false, .clock = &clock_});
  ASSERT_TRUE(
      scrubber.Pass([&told](const DamagedResult& damaged) { told.push_back(damaged.why); }).ok());
  EXPECT_THAT(told, testing::UnorderedElementsAre(HasSubstr("is not in the store"),
                                                  HasSubstr("has 7 bytes, not ")));
  EXPECT_EQ(State(study), v1::STUDY_STATE_SUCCEEDED);
}

TEST_F(StoreUpkeepTest, AFileThatCantBeReadIsDamageAndTheOthersAreRead) {
  const StudyId study = Submit();
  Work();
  const std::vector<std::string> files = FilesOf(study);
  MakeUnreadable(files.front());
  Flip(files.back(), 3);
  std::vector<std::string> told;
  Scrubber scrubber(*queue_, *store_, {.clock = &clock_});
  const auto pass =
      scrubber.Pass([&told](const DamagedResult& damaged) { told.push_back(damaged.why); });
  ASSERT_TRUE(pass.ok()) << pass.status();
  EXPECT_TRUE(pass->ended_unix_s.has_value());
  EXPECT_THAT(
      told, testing::UnorderedElementsAre(HasSubstr(": can't be read: "), HasSubstr("(SHA-256)")));
  Work();
  EXPECT_EQ(State(study), v1::STUDY_STATE_SUCCEEDED);
  for (const std::string& file : FilesOf(study)) EXPECT_TRUE(fs::is_regular_file(file)) << file;
}

TEST_F(StoreUpkeepTest, WhereNothingCanBeReadNothingIsDamaged) {
  const StudyId study = Submit();
  Work();
  for (const std::string& file : FilesOf(study)) MakeUnreadable(file);
  Scrubber scrubber(*queue_, *store_, {.clock = &clock_});
  const auto pass = scrubber.Pass([](const DamagedResult&) { ADD_FAILURE(); });
  EXPECT_TRUE(absl::IsUnavailable(pass.status())) << pass.status();
  EXPECT_THAT(Frames(study), SizeIs(4));
}

TEST_F(StoreUpkeepTest, APassGoesOnWhereItWas) {
  Submit({.pairs = 60, .rigs_per_scene = 1});
  Work();
  const auto outputs = *queue_->ListStoredOutputs("", 1000);
  const Sha256Digest& half = outputs[29].key;
  ASSERT_TRUE(
      queue_->KeepScrub({.position = std::string(half.begin(), half.end()), .files = 1000}).ok());
  Scrubber scrubber(*queue_, *store_, {.clock = &clock_});
  const auto pass = scrubber.Pass([](const DamagedResult&) {});
  ASSERT_TRUE(pass.ok()) << pass.status();
  EXPECT_EQ(pass->files, 1000 + 30 * static_cast<int64_t>(outputs[0].files.size()));
  EXPECT_EQ(scrubber.figures().files, pass->files - 1000);
}

TEST_F(StoreUpkeepTest, ReadingIsBounded) {
  Submit({.pairs = 2, .rigs_per_scene = 1});
  Work();
  Scrubber slow(*queue_, *store_, {.bytes_per_s = 100'000});
  const SteadyTime begin = Clock::System().Steady();
  const auto pass = slow.Pass([](const DamagedResult&) {});
  ASSERT_TRUE(pass.ok()) << pass.status();
  const std::chrono::duration<double> took = Clock::System().Steady() - begin;
  EXPECT_GE(took.count(), static_cast<double>(pass->bytes) / 100'000);
}

TEST_F(StoreUpkeepTest, AnEqualStudyIsNotGivenWhatIsNotThere) {
  const StudyId one = Submit({.name = "one"});
  Work();
  const std::vector<std::string> files = FilesOf(one);
  fs::remove(files.front());
  const StudyId two = Submit({.name = "two"});
  Tick();
  EXPECT_EQ(State(one), v1::STUDY_STATE_RUNNING);
  EXPECT_EQ(State(two), v1::STUDY_STATE_RUNNING);
  Work();
  EXPECT_EQ(State(two), v1::STUDY_STATE_SUCCEEDED);
  for (const std::string& file : FilesOf(two)) EXPECT_TRUE(fs::exists(file)) << file;
}

}  // namespace
}  // namespace parallax
