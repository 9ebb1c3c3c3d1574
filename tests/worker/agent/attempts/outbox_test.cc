#include "worker/agent/attempts/outbox.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "tests/folder_test.h"

namespace parallax {
namespace {

namespace fs = std::filesystem;

class OutboxTest : public FolderTest {
 protected:
  std::unique_ptr<Outbox> Open(const std::string& worker) {
    auto outbox = Outbox::Open(dir_, worker);
    EXPECT_TRUE(outbox.ok()) << outbox.status();
    return outbox.ok() ? *std::move(outbox) : nullptr;
  }
  static Report Completed(int64_t job, uint64_t fence) {
    v1::CompleteRequest complete;
    complete.mutable_attempt()->set_job_id(job);
    complete.mutable_attempt()->set_fence(fence);
    complete.set_coordinator_id("database-1");
    complete.set_kind("solve");
    complete.set_result("bytes");
    return {complete};
  }
  static Report Failed(int64_t job, uint64_t fence) {
    v1::FailRequest fail;
    fail.mutable_attempt()->set_job_id(job);
    fail.mutable_attempt()->set_fence(fence);
    fail.set_error("why");
    return {fail};
  }
};

TEST_F(OutboxTest, WhatWasPutIsThereAfterADeath) {
  {
    auto outbox = Open("w");
    ASSERT_TRUE(outbox->Put(Completed(1, 11)).ok());
    ASSERT_TRUE(outbox->Put(Completed(2, 12)).ok());
    ASSERT_TRUE(outbox->Put(Failed(3, 13)).ok());
    ASSERT_TRUE(outbox->Remove(Completed(2, 12)).ok());
  }
  const std::vector<Report> left = Open("w")->TakeLeftovers();
  ASSERT_EQ(left.size(), 2u);
  int completes = 0;
  for (const Report& report : left) {
    if (const auto* complete = std::get_if<v1::CompleteRequest>(&report.body)) {
      ++completes;
      EXPECT_EQ(report.attempt().fence(), 11u);
      EXPECT_EQ(report.coordinator_id(), "database-1");
      EXPECT_EQ(complete->result(), "bytes");
    } else {
      EXPECT_EQ(report.attempt().fence(), 13u);
      EXPECT_EQ(std::get<v1::FailRequest>(report.body).error(), "why");
    }
  }
  EXPECT_EQ(completes, 1);
}

TEST_F(OutboxTest, TwoLivingWorkersOfOneNameAreRefused) {
  auto first = Open("w");
  const auto second = Outbox::Open(dir_, "w");
  EXPECT_EQ(second.status().code(), absl::StatusCode::kAlreadyExists) << second.status();
  first.reset();
  EXPECT_TRUE(Outbox::Open(dir_, "w").ok());
}

TEST_F(OutboxTest, ReportsOfTheDeadAreTakenOverAndThoseOfTheLivingAreNot) {
  auto living = Open("living");
  ASSERT_TRUE(living->Put(Completed(1, 11)).ok());
  ASSERT_TRUE(Open("dead")->Put(Completed(2, 12)).ok());
  std::ofstream(dir_ + "/dead/.tmp-1-w1") << "a report that it had begun to write";
  const std::vector<Report> left = Open("heir")->TakeLeftovers();
  ASSERT_EQ(left.size(), 1u);
  EXPECT_EQ(left[0].attempt().job_id(), 2);
  EXPECT_FALSE(fs::exists(dir_ + "/dead"));
  EXPECT_TRUE(fs::exists(dir_ + "/living"));
}

TEST_F(OutboxTest, ADamagedReportIsSetAsideAndTheOthersSurvive) {
  {
    auto outbox = Open("w");
    ASSERT_TRUE(outbox->Put(Completed(1, 11)).ok());
    ASSERT_TRUE(outbox->Put(Completed(2, 12)).ok());
  }
  int damaged = 0;
  for (const auto& entry : fs::directory_iterator(dir_ + "/w")) {
    if (entry.path().string().find("-1-11") == std::string::npos) continue;
    std::fstream file(entry.path(), std::ios::in | std::ios::out | std::ios::binary);
    file.seekp(-1, std::ios::end);
    file.put('\x7f');
    ++damaged;
  }
  ASSERT_EQ(damaged, 1);
  const std::vector<Report> left = Open("w")->TakeLeftovers();
  ASSERT_EQ(left.size(), 1u);
  EXPECT_EQ(left[0].attempt().job_id(), 2);
  int set_aside = 0;
  for (const auto& entry : fs::directory_iterator(dir_ + "/w")) {
    set_aside += entry.path().extension() == ".damaged";
  }
  EXPECT_EQ(set_aside, 1);
}

TEST_F(OutboxTest, NamesThatAreNoFolderNamesAreRefused) {
  for (const char* name : {"", ".", "..", "a/b", "-x", "a b", "a\n"}) {
    EXPECT_FALSE(CheckWorkerName(name).ok()) << name;
  }
  for (const char* name : {"w", "host-1.example.org-4711", "A_b"}) {
    EXPECT_TRUE(CheckWorkerName(name).ok()) << name;
  }
}

}  // namespace
}  // namespace parallax
