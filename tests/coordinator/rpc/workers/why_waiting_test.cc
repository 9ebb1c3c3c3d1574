#include "coordinator/rpc/workers/why_waiting.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

namespace parallax {
namespace {

using Tags = std::vector<std::string>;

ReadyKey Jobs(const std::string& kind, Tags tags = {}, int64_t memory_mb = 0) {
  std::sort(tags.begin(), tags.end());
  return {1, kind, memory_mb, std::move(tags)};
}
WorkerGroup Free(Tags kinds, Tags tags = {}, int64_t memory_mb = 8000) {
  return {.kinds = std::move(kinds), .tags = std::move(tags), .memory_mb = memory_mb, .free = 1};
}
WorkerGroup Busy(Tags kinds, Tags tags = {}, int64_t memory_mb = 8000) {
  WorkerGroup group = Free(std::move(kinds), std::move(tags), memory_mb);
  std::swap(group.free, group.busy);
  return group;
}
WorkerGroup Drained(Tags kinds, Tags tags = {}) {
  WorkerGroup group = Free(std::move(kinds), std::move(tags));
  std::swap(group.free, group.drained);
  return group;
}

struct WaitingRow {
  const char* what;
  ReadyKey jobs;
  StudyHold study;
  std::vector<WorkerGroup> workers;
  const char* code;
  const char* text;
};

std::vector<WaitingRow> WaitingRows() {
  const ReadyKey train = Jobs("train", {"trainer:raftstereo"});
  WorkerGroup many = Busy({"render"});
  many.busy = 20;
  WorkerGroup suspended = Free({"render"});
  std::swap(suspended.free, suspended.suspended);
  return {
      {"nobody", Jobs("render"), {}, {}, "no_worker", "no worker is connected"},
      {"other kinds",
       train,
       {},
       {Free({"render"})},
       "kind",
       "no connected worker takes train jobs (worker --role train)"},
      {"no trainer, worker free",
       train,
       {},
       {Free({"train"}, {"trainer:builtin"})},
       "trainer",
       "no connected worker for train jobs has the trainer raftstereo (worker --allow-trainers "
       "raftstereo, or install its program)"},
      {"no trainer, all busy",
       train,
       {},
       {Busy({"train", "render"}), many},
       "trainer",
       "no connected worker for train jobs has the trainer raftstereo (worker --allow-trainers "
       "raftstereo, or install its program)"},
      {"no network",
       Jobs("train", {"network:12ab"}),
       {},
       {Free({"train"}, {"network:34cd"})},
       "tag",
       "no connected worker for train jobs has the network with the SHA-256 12ab (the "
       "coordinator's version of Parallax, or $PARALLAX_NETWORK)"},
      {"its trainer is with a worker that does not train",
       train,
       {},
       {Free({"render"}, {"trainer:raftstereo"}), Free({"train"})},
       "trainer",
       "no connected worker for train jobs has the trainer raftstereo (worker --allow-trainers "
       "raftstereo, or install its program)"},
      {"no benchmark",
       Jobs("evaluate", {"benchmark:eth3d"}),
       {},
       {Busy({"evaluate"})},
       "benchmark",
       "no connected worker for evaluate jobs has the benchmark eth3d (worker --benchmarks FOLDER, "
       "with eth3d in it)"},
      {"no GPU",
       Jobs("train", {"gpu", "trainer:a"}),
       {},
       {Busy({"train"}, {"trainer:a"})},
       "gpu",
       "no connected worker for train jobs has a GPU (worker --tags gpu)"},
      {"no tag",
       Jobs("render", {"bigmem"}),
       {},
       {Busy({"render"})},
       "tag",
       "no connected worker for render jobs has the tag bigmem (worker --tags bigmem)"},
      {"too little memory",
       Jobs("render", {}, 64000),
       {},
       {Busy({"render"}, {}, 24000)},
       "memory",
       "no connected worker for render jobs has 64 GB of memory (the most that one offers is 24 "
       "GB)"},
      {"the trainer comes before the memory",
       Jobs("train", {"trainer:a"}, 64000),
       {},
       {Busy({"train"})},
       "trainer",
       "no connected worker for train jobs has the trainer a (worker --allow-trainers a, or "
       "install its program)"},
      {"each need somewhere, nowhere together",
       Jobs("train", {"big", "trainer:a"}, 4000),
       {},
       {Free({"train"}, {"trainer:a"}), Free({"train"}, {"big"}, 2000)},
       "tag",
       "no connected worker for train jobs has all of the trainer a, the tag big, 4000 MB of "
       "memory"},
      {"paused",
       train,
       {.paused = true},
       {},
       "pause",
       "the study is paused (parallax resume STUDY)"},
      {"at its limit",
       Jobs("render"),
       {.at_limit = "max_running 8"},
       {Free({"render"})},
       "limit",
       "the study is at its limit: max_running 8"},
      {"a limit does not hide a missing trainer",
       train,
       {.at_limit = "max_running 8"},
       {Free({"train"})},
       "trainer",
       "no connected worker for train jobs has the trainer raftstereo (worker --allow-trainers "
       "raftstereo, or install its program)"},
      {"drained",
       Jobs("render"),
       {},
       {Drained({"render"}), Drained({"render"}, {"x"})},
       "drain",
       "all 2 suitable workers are drained (parallax workers drain NAME --undo)"},
      {"the one with the trainer is drained",
       Jobs("train", {"trainer:a"}),
       {},
       {Drained({"train"}, {"trainer:a"}), Free({"train"})},
       "drain",
       "the only suitable worker is drained (parallax workers drain NAME --undo)"},
      {"suspended",
       Jobs("render"),
       {},
       {suspended},
       "suspended",
       "the only suitable worker is suspended, having failed all jobs of late"},
      {"busy", Jobs("render"), {}, {many}, "busy", "all 20 suitable workers are busy"},
      {"busy, one drained",
       Jobs("render"),
       {},
       {many, Drained({"render"})},
       "busy",
       "20 of 21 suitable workers are busy, the others take no jobs"},
      {"its turn comes",
       Jobs("render"),
       {},
       {many, Free({"render"})},
       "starting",
       "1 suitable worker is free: next to start"},
      {"more than it needs",
       Jobs("render", {"a"}, 10),
       {},
       {Free({"render"}, {"a", "b"}, 11)},
       "starting",
       "1 suitable worker is free: next to start"},
  };
}

TEST(WhyWaiting, EveryRowHasItsReason) {
  std::set<std::string> seen;
  for (const WaitingRow& row : WaitingRows()) {
    const WaitReason reason = WhyWaiting(row.jobs, row.study, row.workers);
    EXPECT_EQ(reason.code, row.code) << row.what;
    EXPECT_EQ(reason.text, row.text) << row.what;
    seen.insert(reason.code);
  }
  for (const char* code : kWaitCodes) EXPECT_EQ(seen.count(code), 1u) << code;
  EXPECT_EQ(seen.size(), std::size(kWaitCodes));
}

TEST(WhyWaiting, OnlyWhatNoConnectedWorkerHasIsUnservable) {
  Tags unservable;
  for (const char* code : kWaitCodes) {
    if (IsUnservable(code)) unservable.push_back(code);
  }
  EXPECT_THAT(unservable, testing::ElementsAre("no_worker", "kind", "trainer", "benchmark", "gpu",
                                               "tag", "memory"));
  EXPECT_FALSE(IsUnservable("another"));
}

}  // namespace
}  // namespace parallax
