// Fixture of tests of keepers of records by name: streams, searches.
#pragma once

#include <memory>
#include <string>
#include <utility>

#include "tests/coordinator/queue/queue_fixture.h"

namespace parallax {

template <typename Keeper, typename StatusMessage>
class KeeperTest : public QueueTest {
 protected:
  explicit KeeperTest(std::string name) : name_(std::move(name)) {}
  void SetUp() override {
    QueueTest::SetUp();
    Restart();
  }
  void TearDown() override {
    keeper_.reset();
    QueueTest::TearDown();
  }
  virtual std::unique_ptr<Keeper> MakeKeeper() = 0;

  // A kill of the coordinator: nothing is left but the database.
  void Restart() {
    keeper_.reset();
    Reopen();
    keeper_ = MakeKeeper();
  }
  // Another farm, which has done nothing yet.
  void BeginAnew() {
    keeper_.reset();
    queue_.reset();
    for (const char* file : {"", "-wal", "-shm", ".lock"}) {
      std::filesystem::remove(options_.db_path + file);
    }
    Restart();
  }

  StatusMessage Open(const v1::StudySpec& study) {
    const auto status = keeper_->Open(study, "submitter ada ipv4:1");
    EXPECT_TRUE(status.ok()) << status.status();
    return status.ok() ? *status : StatusMessage();
  }
  // Returns the status of the record that the test is about.
  StatusMessage Status() {
    const auto list = keeper_->List(name_);
    EXPECT_TRUE(list.ok()) << list.status();
    return list.ok() ? list->front() : StatusMessage();
  }

  std::unique_ptr<Keeper> keeper_;

 private:
  const std::string name_;
};

}  // namespace parallax
