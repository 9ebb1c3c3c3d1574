#include "common/base/memory_budget.h"

#include <gtest/gtest.h>

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

TEST_F(MemoryBudget, WhatDoesNotFitIsRefusedWithAllNumbers) {
  SetMemoryLimit(int64_t{4000} << 20);
  EXPECT_TRUE(CheckMemory("a mesh", int64_t{1000} << 20).ok());
  const absl::Status status = CheckMemory("a mesh", int64_t{5000} << 20);
  EXPECT_EQ(status.code(), absl::StatusCode::kResourceExhausted);
  const std::string message(status.message());
  for (const char* part : {"a mesh", "5000 MB", "4000 MB"}) {
    EXPECT_NE(message.find(part), std::string::npos) << message;
  }
  // What is held already counts.
  EXPECT_FALSE(CheckMemory("a mesh", int64_t{4000} << 20).ok());
}

TEST_F(MemoryBudget, TheDefaultIsTheMachinesAndAnyRequestIsBounded) {
  SetMemoryLimit(-5);
  EXPECT_GT(MemoryLimit(), int64_t{100} << 20);
  EXPECT_FALSE(CheckMemory("everything", INT64_MAX).ok());
}

}  // namespace
}  // namespace parallax
