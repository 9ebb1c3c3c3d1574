// worker --role
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "noop_runner.h"
#include "worker/agent/worker_command_line.h"

namespace parallax {
namespace {

using testing::ElementsAre;

TEST(KindsOfRole, AllOrAnyListOfKinds) {
  NoopRunner runner;
  const JobHandlers handlers = HandlersOf(runner);
  EXPECT_THAT(*KindsOfRole("all", handlers), ElementsAre("solve", "render"));
  EXPECT_THAT(*KindsOfRole("solve", handlers), ElementsAre("solve"));
  EXPECT_THAT(*KindsOfRole("render", handlers), ElementsAre("render"));
  EXPECT_THAT(*KindsOfRole("render,solve,render", handlers), ElementsAre("render", "solve"));
}

TEST(KindsOfRole, WhatThereIsNotIsRefusedWithWhatThereIs) {
  NoopRunner runner;
  const JobHandlers handlers = HandlersOf(runner);
  const auto unknown = KindsOfRole("solve,bake", handlers).status();
  EXPECT_EQ(unknown.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(unknown.message(), "--role: unknown kind of job 'bake' (there are all, solve, render)");
  EXPECT_FALSE(KindsOfRole("", handlers).ok());
  EXPECT_FALSE(KindsOfRole(",", handlers).ok());
}

}  // namespace
}  // namespace parallax
