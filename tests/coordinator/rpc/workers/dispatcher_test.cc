// The dispatcher without streams: how many workers it takes, and that a list of all is one reply.
#include "coordinator/rpc/workers/dispatcher.h"

#include <gtest/gtest.h>

#include "common/base/names.h"
#include "common/config/check/limits.h"
#include "coordinator/rpc/reply_size.h"
#include "coordinator/rpc/validation.h"
#include "tests/coordinator/queue/queue_fixture.h"
#include "tests/sqlite_by_hand.h"

namespace parallax {
namespace {

class SilentLink final : public WorkerLink {
 public:
  void Send(v1::CoordinatorMessage) override {}
  void Close(const absl::Status&, bool) override {}
};

class DispatcherTest : public FolderTest {
 protected:
  DispatcherTest() {
    // No worker falls silent, however long the disk takes for twenty thousand commits.
    queue_ = *JobQueue::Open({.db_path = dir_ + "/queue.db", .lease_s = 3600});
    pool_ = std::make_unique<TaskPool>(1);
    pool_->Start();
    dispatcher_ = std::make_unique<Dispatcher>(*queue_, *pool_, Clock::System(), 60);
  }
  ~DispatcherTest() override {
    dispatcher_.reset();
    pool_.reset();  // Its last tasks still use the queue.
    queue_.reset();
  }

  // With the longest texts that are let pass.
  static v1::Hello LongHello(size_t number) {
    v1::Hello hello;
    const std::string digits = std::to_string(number);
    hello.set_name(std::string(kMaxNameBytes - digits.size(), 'w') + digits);
    hello.set_protocol(kWorkProtocol);
    for (const std::string& kind : KindRegistry::Builtin().Names()) hello.add_kinds(kind);
    hello.set_slots(kMaxSlots);
    hello.set_version(std::string(kMaxNameBytes, 'v'));
    EXPECT_TRUE(CheckHello(hello, KindRegistry::Builtin()).ok());
    return hello;
  }
  absl::Status Join(const v1::Hello& hello) {
    return dispatcher_->Join(std::make_shared<SilentLink>(), hello, [](const auto&) {});
  }

  std::unique_ptr<JobQueue> queue_;
  std::unique_ptr<TaskPool> pool_;
  std::unique_ptr<Dispatcher> dispatcher_;
};

TEST_F(DispatcherTest, AListOfTheMostWorkersIsOneReply) {
  for (size_t i = 0; i < kMostWorkers; ++i) ASSERT_TRUE(Join(LongHello(i)).ok());
  const absl::Status more = Join(LongHello(kMostWorkers));
  EXPECT_EQ(more.code(), absl::StatusCode::kResourceExhausted) << more;
  EXPECT_TRUE(Join(LongHello(7)).ok()) << "it was there already";

  std::vector<v1::WorkerStatus> workers = dispatcher_->Workers();
  v1::ListWorkersReply reply;
  EXPECT_TRUE(AddItems(workers, reply.mutable_workers(), kMaxNameBytes)) << "some are left out";
  EXPECT_EQ(static_cast<size_t>(reply.workers_size()), kMostWorkers);
  for (const v1::WorkerStatus& worker : reply.workers()) {
    ASSERT_EQ(worker.name().size(), kMaxNameBytes) << "a name is cut";
    ASSERT_EQ(worker.name().front(), 'w');
    ASSERT_NE(worker.name().back(), '.') << "a name is cut";
  }
  EXPECT_LT(reply.ByteSizeLong(), kMaxReplyBytes);

  // With as many kinds, and as long ones, as a program may know.
  v1::WorkerStatus longest = reply.workers(0);
  longest.clear_kinds();
  for (size_t i = 0; i < kMostKinds; ++i) longest.add_kinds(std::string(32, 'k'));
  longest.set_state("suspended");
  EXPECT_LT((longest.ByteSizeLong() + 16) * kMostWorkers, kMaxReplyBytes);
}

class ListeningLink final : public WorkerLink {
 public:
  void Send(v1::CoordinatorMessage message) override { leases += message.has_lease() ? 1 : 0; }
  void Close(const absl::Status& status, bool) override { end = status; }
  int leases = 0;
  absl::Status end;
};

TEST_F(DispatcherTest, AnEarlierHelloOfAWorkerThatComesLateDoesNotEndIt) {
  v1::Hello hello;
  hello.set_name("w");
  hello.add_kinds("solve");
  hello.set_slots(1);
  hello.set_instance("its-process");
  const auto newer = std::make_shared<ListeningLink>(), earlier = std::make_shared<ListeningLink>();
  ASSERT_TRUE(dispatcher_->Join(newer, hello, [](const auto&) {}).ok());
  ASSERT_TRUE(dispatcher_->Join(earlier, hello, [](const auto&) {}).ok());
  EXPECT_EQ(newer->end.code(), absl::StatusCode::kUnavailable) << "it tries again";
  hello.set_instance("another-process");
  const auto other = std::make_shared<ListeningLink>();
  ASSERT_TRUE(dispatcher_->Join(other, hello, [](const auto&) {}).ok());
  EXPECT_EQ(earlier->end.code(), absl::StatusCode::kAlreadyExists) << "it ends itself";
}

// Its database by hand, with a dispatcher that the test calls.
class CalmDispatcherTest : public DispatcherTest {
 protected:
  CalmDispatcherTest() {
    queue_->SetObserver(nullptr);
    dispatcher_.reset();
    pool_.reset();
    queue_.reset();
    queue_ = *JobQueue::Open({.db_path = db_, .own_threads = false});
    pool_ = std::make_unique<TaskPool>(0);
    EXPECT_TRUE(queue_->Submit(MakeStudy({.pairs = 3, .rigs_per_scene = 1}), "tester").ok());
  }
  ~CalmDispatcherTest() override { queue_->SetObserver(nullptr); }

  // A worker that wants two jobs.
  void StartWithAWorker() {
    dispatcher_ = std::make_unique<Dispatcher>(*queue_, *pool_, Clock::System(), 60,
                                               /*own_thread=*/false);
    queue_->SetObserver(dispatcher_.get());
    ASSERT_TRUE(JoinAsW().ok());
    v1::Credit credit;
    credit.set_jobs(2);
    dispatcher_->AddCredit("w", link_.get(), credit);
  }

  absl::Status JoinAsW() {
    v1::Hello hello;
    hello.set_name("w");
    hello.add_kinds("solve");
    hello.set_slots(2);
    return dispatcher_->Join(link_, hello, [](const auto&) {});
  }

  const std::string db_ = dir_ + "/calm.db";
  const std::shared_ptr<ListeningLink> link_ = std::make_shared<ListeningLink>();
};

TEST_F(CalmDispatcherTest, WithoutAThreadOfItsOwnItLeasesWhenItIsCalled) {
  StartWithAWorker();
  dispatcher_->Work();
  EXPECT_TRUE(queue_->Work()) << "it has asked";
  EXPECT_EQ(link_->leases, 0);
  EXPECT_GT(dispatcher_->Work(), Clock::System().Steady());
  EXPECT_EQ(link_->leases, 2);

  bool ran = false;
  pool_->Run([&] { ran = true; });
  EXPECT_TRUE(pool_->RunNext() && ran);
  EXPECT_FALSE(pool_->RunNext());
}

// Otherwise the queue takes away leases that it has just adopted.
TEST_F(CalmDispatcherTest, AWorkerComesBackAfterItsEarlierLeasesAreGivenUp) {
  StartWithAWorker();
  v1::Heartbeat last;
  last.set_draining(true);
  dispatcher_->Heard("w", link_.get(), last);
  dispatcher_->Left("w", link_.get());
  EXPECT_EQ(JoinAsW().code(), absl::StatusCode::kAborted) << "it tries again";
  EXPECT_TRUE(pool_->RunNext());
  EXPECT_TRUE(JoinAsW().ok());
}

TEST_F(CalmDispatcherTest, ItGivesNoWorkBeforeItHasReadWhoIsDrained) {
  const auto rename = [this](const char* sql) {
    sqlite3* db = OpenByHand(db_);
    EXPECT_EQ(sqlite3_exec(db, sql, nullptr, nullptr, nullptr), SQLITE_OK) << sqlite3_errmsg(db);
    sqlite3_close(db);
  };
  while (queue_->Work()) continue;
  rename("ALTER TABLE drains RENAME TO unreadable");
  StartWithAWorker();
  while (queue_->Work()) continue;
  dispatcher_->Work();
  EXPECT_FALSE(queue_->Work()) << "it has asked";
  rename("ALTER TABLE unreadable RENAME TO drains");
  dispatcher_->Work();
  EXPECT_TRUE(queue_->Work());
}

}  // namespace
}  // namespace parallax
