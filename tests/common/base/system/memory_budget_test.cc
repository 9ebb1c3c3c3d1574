#include "common/base/system/memory_budget.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

namespace parallax {
namespace {

class MemoryBudget : public ::testing::Test {
 protected:
  void TearDown() override { SetMemoryLimit(0); }
};

TEST_F(MemoryBudget, ResidentMemoryGrowsWithWhatIsTouched) {
  const int64_t before = ResidentMemory();
  const std::vector<char> block(64 << 20, 1);
  EXPECT_GT(ResidentMemory() - before, 50 << 20);
  EXPECT_EQ(block.back(), 1);
}

TEST_F(MemoryBudget, TheSmallestLimitOfAGroupAndThoseAboveItHolds) {
  const std::string root = ::testing::TempDir() + "cgroup";
  std::filesystem::remove_all(root);
  const auto set = [&](const std::string& folder, const char* file, const char* limit) {
    std::filesystem::create_directories(root + folder);
    std::ofstream(root + folder + "/" + file) << limit << "\n";
  };
  // The groups that Slurm makes: the job is limited, its steps are not.
  set("/system.slice/job_5/step_batch", "memory.max", "max");
  set("/system.slice/job_5", "memory.max", "2000000000");
  set("/system.slice", "memory.max", "8000000000");
  EXPECT_EQ(CgroupMemoryLimit("0::/system.slice/job_5/step_batch\n", root), 2000000000);
  EXPECT_EQ(CgroupMemoryLimit("0::/system.slice\n", root), 8000000000);
  EXPECT_EQ(CgroupMemoryLimit("0::/\n", root), 0);
  // A container may not see the group's own folder, but its limit is at the root.
  set("", "memory.max", "1000000000");
  EXPECT_EQ(CgroupMemoryLimit("0::/nowhere/to/be/seen\n", root), 1000000000);
  // The older hierarchy.
  set("/memory/slurm/job_5", "memory.limit_in_bytes", "500000000");
  set("/memory", "memory.limit_in_bytes", "9223372036854771712");
  EXPECT_EQ(CgroupMemoryLimit("3:cpu:/x\n4:memory:/slurm/job_5/step_0\n0::/\n", root), 500000000);
  EXPECT_EQ(CgroupMemoryLimit("", root), 0);
  EXPECT_EQ(CgroupMemoryLimit("nonsense\n4\n", root), 0);
}

TEST_F(MemoryBudget, WhatDoesNotFitIsRefusedWithAllNumbers) {
  SetMemoryLimit(int64_t{4000} << 20);
  EXPECT_TRUE(CheckMemory("a mesh", int64_t{1000} << 20).ok());
  const absl::Status status = CheckMemory("a mesh", int64_t{5000} << 20);
  EXPECT_EQ(status.code(), absl::StatusCode::kResourceExhausted);
  const std::string message(status.message());
  for (const char* part : {"a mesh", "5000 MB", "4000 MB"}) {
    EXPECT_NE(message.find(part), std::string::npos) << message;
  }
  // Memory that is in use already counts.
  EXPECT_FALSE(CheckMemory("a mesh", int64_t{4000} << 20).ok());
}

TEST_F(MemoryBudget, RequestsAddUpAndReachTheOuterSum) {
  const MemoryRequests all;
  EXPECT_TRUE(CheckMemory("a picture", 10).ok());
  {
    const MemoryRequests inner;
    EXPECT_FALSE(CheckMemory("another", INT64_MAX / 2).ok());  // What does not fit counts too.
    EXPECT_EQ(inner.bytes(), INT64_MAX / 2);
    EXPECT_EQ(all.bytes(), 10);
  }
  EXPECT_EQ(all.bytes(), 10 + INT64_MAX / 2);
}

TEST_F(MemoryBudget, TheDefaultIsTheMachinesAndAnyRequestIsBounded) {
  SetMemoryLimit(-5);
  EXPECT_GT(MemoryLimit(), int64_t{100} << 20);
  EXPECT_FALSE(CheckMemory("everything", INT64_MAX).ok());
}

}  // namespace
}  // namespace parallax
