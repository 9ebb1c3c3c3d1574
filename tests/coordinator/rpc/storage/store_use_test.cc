// Studies that are forgotten by age and by space, and the room that /metrics shows.
#include "coordinator/rpc/storage/store_use.h"

#include "coordinator/rpc/janitor.h"
#include "tests/coordinator/queue/queue_fixture.h"

namespace parallax {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr double kDay_s = 86400;

class RetentionTest : public QueueTest {
 protected:
  void SetUp() override {
    QueueTest::SetUp();
    auto store = OpenStore(dir_ + "/store");
    ASSERT_TRUE(store.ok()) << store.status();
    store_ = *std::move(store);
  }
  std::unique_ptr<Janitor> Keeping(const RetentionRules& rules) {
    return std::make_unique<Janitor>(
        *queue_, *store_, nullptr,
        JanitorOptions{
            .every_s = 0, .keep = rules, .database = options_.db_path, .clock = &clock_});
  }
  int Retain(Janitor& janitor) {
    const auto forgotten = janitor.Retain();
    EXPECT_TRUE(forgotten.ok()) << forgotten.status();
    return forgotten.value_or(-1);
  }
  // A study that ends now, and a day that passes.
  StudyId Ended(const std::string& name, uint64_t seed, int64_t pairs) {
    const StudyId study = Submit({.name = name, .seed = seed, .pairs = pairs, .rigs_per_scene = 2});
    WorkOff(AnyWorker("w"));
    EXPECT_EQ(Status(study).state(), v1::STUDY_STATE_SUCCEEDED);
    clock_.Advance(kDay_s);
    return study;
  }
  int64_t BytesOf(StudyId study) {
    int64_t bytes = 0;
    for (const v1::PublishedFrame& frame : Frames(study)) {
      for (const v1::FileEntry& file : frame.frame().files()) bytes += file.size();
    }
    return bytes;
  }
  // The ids of the studies that are left, the newest first.
  std::vector<int64_t> Left() {
    std::vector<int64_t> ids;
    const auto studies = queue_->ListStudies(100);
    EXPECT_TRUE(studies.ok()) << studies.status();
    if (!studies.ok()) return ids;
    for (const v1::StudyStatus& study : *studies) ids.push_back(study.study_id());
    return ids;
  }

  std::unique_ptr<Store> store_;
};

TEST_F(RetentionTest, StudiesGoSoManyDaysAfterTheirEndAndTheAuditSaysWhy) {
  const StudyId old = Ended("old", 1, 4);
  const StudyId young = Ended("young", 2, 4);
  const StudyId running = Submit({.name = "running", .seed = 3, .pairs = 2, .rigs_per_scene = 2});
  const auto janitor = Keeping({.keep_s = 30 * kDay_s});
  EXPECT_EQ(Retain(*janitor), 0);
  clock_.Advance(28.5 * kDay_s);  // The first one's end is 30.5 days ago.
  EXPECT_EQ(Retain(*janitor), 1);
  EXPECT_THAT(Left(), ElementsAre(running.value, young.value));
  const auto audit = queue_->ListAudit({});
  ASSERT_TRUE(audit.ok());
  EXPECT_EQ(audit->front().action(), "forget");
  EXPECT_EQ(audit->front().actor(), "coordinator");
  EXPECT_EQ(audit->front().study_id(), old.value);
  EXPECT_EQ(audit->front().detail(), "old: ended 30.5 days ago (--keep-days 30)");
  clock_.Advance(1000 * kDay_s);
  EXPECT_EQ(Retain(*janitor), 1);
  EXPECT_THAT(Left(), ElementsAre(running.value)) << "it is not at its end";
  EXPECT_EQ(Retain(*janitor), 0);
}

TEST_F(RetentionTest, TheOldestGoWhileTheResultsTakeTooMuch) {
  const StudyId first = Ended("first", 1, 4);
  const StudyId second = Ended("second", 2, 8);
  const StudyId third = Ended("third", 3, 4);
  const int64_t pair = BytesOf(first) / 4;
  ASSERT_GT(pair, 0);
  const auto enough = Keeping({.keep_bytes = 16 * pair});
  EXPECT_EQ(Retain(*enough), 0);
  EXPECT_EQ(enough->space().results_bytes, 16 * pair);
  const auto less = Keeping({.keep_bytes = 16 * pair - 1});
  EXPECT_EQ(Retain(*less), 1);
  EXPECT_THAT(Left(), ElementsAre(third.value, second.value));
  // Not the third although it alone would do: the second one is older.
  EXPECT_EQ(Retain(*Keeping({.keep_bytes = 8 * pair})), 1);
  EXPECT_THAT(Left(), ElementsAre(third.value));
  EXPECT_THAT(queue_->ListAudit({})->front().detail(), HasSubstr("(--keep-gb "));
  // Rows and files follow, as after `forget`.
  for (int i = 0; i < 12; ++i) Tick();
  EXPECT_EQ(BytesOf(third), 4 * pair);
  clock_.Advance(10 * options_.lease_s);
  EXPECT_GT(queue_->ListLitter(0, 1000)->size(), 0u);
}

TEST_F(RetentionTest, WhatAnotherStudyUsesCountsOnceAndStays) {
  const StudyId old = Ended("old", 1, 4);
  Ended("same", 1, 4);  // All its pairs are those of `old`.
  const StudyId running = Submit({.name = "running", .seed = 1, .pairs = 8, .rigs_per_scene = 2});
  const int64_t pair = BytesOf(old) / 4;
  const auto janitor = Keeping({.keep_bytes = 1});
  EXPECT_EQ(Retain(*janitor), 2);
  EXPECT_EQ(janitor->space().results_bytes, 4 * pair) << "what the running one has reused";
  EXPECT_THAT(Left(), ElementsAre(running.value));
  for (int i = 0; i < 12; ++i) Tick();
  EXPECT_EQ(BytesOf(running), 4 * pair);
  WorkOff(AnyWorker("w"));
  EXPECT_EQ(Status(running).variants(0).pairs_done(), 8);
  EXPECT_EQ(Retain(*janitor), 1) << "what it has published since is counted";
  EXPECT_EQ(janitor->space().results_bytes, 8 * pair);
  EXPECT_EQ(Retain(*janitor), 0);
  EXPECT_EQ(janitor->space().results_bytes, 0);
}

TEST_F(RetentionTest, WithoutRulesAndWithoutTheStoreNothingIsForgotten) {
  const StudyId study = Ended("only", 1, 4);
  clock_.Advance(10'000 * kDay_s);
  EXPECT_EQ(Retain(*Keeping({})), 0);
  std::filesystem::rename(dir_ + "/store", dir_ + "/unmounted");
  EXPECT_FALSE(Keeping({.keep_s = kDay_s})->Retain().ok());
  EXPECT_THAT(Left(), ElementsAre(study.value));
}

}  // namespace
}  // namespace parallax
