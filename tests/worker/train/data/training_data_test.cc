#include "worker/train/data/training_data.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <set>

#include "tests/worker/dataset/synthetic_archive.h"
#include "worker/train/data/batch_loader.h"

namespace parallax {
namespace {

std::string MakeArchive(const std::string& name, const SyntheticArchive& options = {}) {
  const std::string dir =
      testing::TempDir() + "train_data_" + std::to_string(getpid()) + "_" + name;
  MakeSyntheticArchive(dir, options);
  return dir;
}

TEST(TrainingSource, ReadsArchiveAndVariantFolderWithWeights) {
  const std::string dir = MakeArchive("weights", {.variants = {"a", "b"}});
  const auto both = ReadTrainingSource(dir, {});
  ASSERT_TRUE(both.ok()) << both.status();
  EXPECT_EQ(both->frames.size(), 12u);
  EXPECT_EQ(both->weight, 1);
  EXPECT_EQ(both->frames.front().name, "a/000000/000");
  const auto one = ReadTrainingSource(dir + "/b=0.25", {});
  ASSERT_TRUE(one.ok()) << one.status();
  EXPECT_EQ(one->frames.size(), 6u);
  EXPECT_EQ(one->weight, 0.25);
  EXPECT_NE(one->data_hash, both->data_hash);
  for (const char* weight : {"=", "=0", "=-1", "=x", "=1x", "=inf"}) {
    EXPECT_TRUE(absl::IsInvalidArgument(ReadTrainingSource(dir + weight, {}).status())) << weight;
  }
}

TEST(TrainingSource, LeavesOutWhatFiltersTurnedDown) {
  const std::string dir = MakeArchive("dark", {.last_frame_dark = true});
  const auto filtered = ReadTrainingSource(dir, {});
  ASSERT_TRUE(filtered.ok()) << filtered.status();
  EXPECT_EQ(filtered->frames.size(), 5u);
  EXPECT_EQ(filtered->left_out, 1);
  EXPECT_EQ(ReadTrainingSource(dir, {.unfiltered = true})->frames.size(), 6u);
}

TEST(TrainingSource, HeldoutPairsAreTakenOnlyFromTheirOwnFolder) {
  const std::string dir = MakeArchive("heldout", {.variants = {"a", "heldout"}});
  const auto source = ReadTrainingSource(dir, {});
  ASSERT_TRUE(source.ok()) << source.status();
  EXPECT_EQ(source->frames.size(), 6u);
  EXPECT_EQ(source->frames.back().name, "a/000002/001");
  EXPECT_TRUE(source->heldout_left_out);
  const auto own = ReadTrainingSource(dir + "/heldout", {});
  ASSERT_TRUE(own.ok()) << own.status();
  EXPECT_EQ(own->frames.size(), 6u);
  EXPECT_FALSE(own->heldout_left_out);
  EXPECT_EQ(ReadTrainingSource(dir, {.heldout = true})->frames.size(), 12u);
}

TEST(TrainingSource, NamesWhatIsMissing) {
  const std::string dir = MakeArchive("missing", {.scenes = 1});
  EXPECT_TRUE(absl::IsNotFound(ReadTrainingSource(dir + "/nowhere", {}).status()));
  const std::string map = dir + "/a/frames/000000/001/disparity_left.exr";
  std::filesystem::remove(map);
  const absl::Status status = ReadTrainingSource(dir, {}).status();
  EXPECT_TRUE(absl::IsFailedPrecondition(status));
  EXPECT_NE(status.message().find(ToAbsl(map + " is missing")), absl::string_view::npos) << status;
  EXPECT_EQ(ReadTrainingSource(dir, {.allow_missing = true})->frames.size(), 1u);
  std::filesystem::remove(dir + "/a/frames/000000/000/left.png");
  const absl::Status empty = ReadTrainingSource(dir, {.allow_missing = true}).status();
  EXPECT_NE(empty.message().find("no pair to train on"), absl::string_view::npos) << empty;
}

TEST(TrainingSource, RefusesAVariantWithoutItsIndex) {
  const std::string dir = MakeArchive("no_index", {.variants = {"a", "b"}});
  std::filesystem::remove(dir + "/b/index.jsonl");
  const absl::Status status = ReadTrainingSource(dir, {}).status();
  EXPECT_TRUE(absl::IsFailedPrecondition(status)) << status;
  EXPECT_NE(status.message().find("b/index.jsonl is missing"), absl::string_view::npos) << status;
  EXPECT_EQ(ReadTrainingSource(dir, {.allow_missing = true})->frames.size(), 6u);
}

TEST(TrainingPair, SkyHasNoTruthAndMapsMayBeAbsent) {
  const std::string dir = MakeArchive("pair", {.scenes = 1, .rigs = 1}) + "/a/frames/000000/000";
  const auto pair = ReadTrainingPair(dir);
  ASSERT_TRUE(pair.ok()) << pair.status();
  std::set<int> trusts;
  for (size_t i = 0; i < pair->left.trust.pixels(); ++i) {
    trusts.insert(pair->left.trust.values()[i]);
    if (pair->left.disparity_px.values()[i] <= 0) {
      EXPECT_EQ(pair->left.trust.values()[i], kNoTruth);
    }
  }
  EXPECT_TRUE(trusts.contains(kOccluded) && trusts.contains(kVisible));
  std::filesystem::remove(dir + "/disparity_right.exr");
  std::filesystem::remove(dir + "/occlusion_left.png");
  const auto bare = ReadTrainingPair(dir);
  ASSERT_TRUE(bare.ok()) << bare.status();
  EXPECT_TRUE(bare->right.disparity_px.empty());
}

TEST(FrameOrder, VisitsEveryFrameOnceARound) {
  FrameOrder order(5, {7}, {1});
  std::vector<int> first, second;
  for (int i = 0; i < 7; ++i) first.push_back(order.Next().frame);
  for (int i = 0; i < 7; ++i) second.push_back(order.Next().frame);
  EXPECT_EQ(std::set<int>(first.begin(), first.end()).size(), 7u);
  EXPECT_EQ(std::set<int>(second.begin(), second.end()).size(), 7u);
  EXPECT_NE(first, second);
}

TEST(FrameOrder, KeepsWeightsAtEveryMoment) {
  FrameOrder order(5, {3, 10, 4}, {0.5, 0.3, 0.2});
  double counts[3] = {};
  for (int i = 1; i <= 200; ++i) {
    ++counts[order.Next().source];
    EXPECT_NEAR(counts[0], 0.5 * i, 1.01);
    EXPECT_NEAR(counts[1], 0.3 * i, 1.01);
    EXPECT_NEAR(counts[2], 0.2 * i, 1.01);
  }
}

TrainSettings TinyCrops() {
  TrainSettings settings;
  settings.crop_height = 32;
  settings.crop_width = 64;
  settings.batch = 3;
  return settings;
}

TEST(BatchLoader, OrderAndDrawsDependOnSeedAndStepOnly) {
  // Two variants show other pictures of equally many frames; dark frames are kept.
  const auto source = ReadTrainingSource(MakeArchive("order_a"), {});
  const auto other =
      ReadTrainingSource(MakeArchive("order_b", {.last_frame_dark = true}), {.unfiltered = true});
  ASSERT_TRUE(source.ok() && other.ok());
  const std::vector<TrainingSource> a{*source}, b{*other};
  BatchLoader one(a, TinyCrops(), 0, 1), three(a, TinyCrops(), 0, 3, 5), late(a, TinyCrops(), 4, 2),
      elsewhere(b, TinyCrops(), 0);
  for (int step = 0; step < 8; ++step) {
    const auto batch = one.Next(), same = three.Next(), paired = elsewhere.Next();
    ASSERT_TRUE(batch.ok() && same.ok() && paired.ok()) << batch.status();
    EXPECT_EQ(batch->names, same->names);
    EXPECT_EQ(batch->names, paired->names);
    for (size_t i = 0; i < 3; ++i) {
      EXPECT_EQ(batch->crops[i].left, same->crops[i].left);
      EXPECT_EQ(batch->crops[i].disparity_px, paired->crops[i].disparity_px);
    }
    if (step < 4) continue;
    const auto resumed = late.Next();
    ASSERT_TRUE(resumed.ok());
    EXPECT_EQ(batch->names, resumed->names);
    EXPECT_EQ(batch->crops[2].right, resumed->crops[2].right);
  }
  TrainSettings seeded = TinyCrops();
  seeded.seed = 2;
  BatchLoader first(a, TinyCrops(), 0), second(a, seeded, 0);
  EXPECT_NE(first.Next()->crops[0].left, second.Next()->crops[0].left);
}

TEST(BatchLoader, ReadsAPairOnce) {
  const auto source = ReadTrainingSource(MakeArchive("once"), {});
  ASSERT_TRUE(source.ok());
  const std::vector<TrainingSource> sources{*source};
  BatchLoader loader(sources, TinyCrops(), 0, 1, 1), fresh(sources, TinyCrops(), 2, 1, 1);
  for (int step = 0; step < 2; ++step) ASSERT_TRUE(loader.Next().ok());  // All six.
  const auto wanted = fresh.Next();
  for (const TrainingFrame& frame : source->frames) std::filesystem::remove_all(frame.dir);
  const auto batch = loader.Next(), later = loader.Next();  // One may have been made before.
  ASSERT_TRUE(batch.ok() && wanted.ok() && later.ok()) << batch.status() << later.status();
  EXPECT_EQ(batch->crops[1].right, wanted->crops[1].right);
}

// In a thread of its own an exception would end the program.
TEST(BatchLoader, AnExceptionWhileABatchIsMadeIsAnError) {
  const auto source = ReadTrainingSource(MakeArchive("thrown"), {});
  ASSERT_TRUE(source.ok());
  const std::vector<TrainingSource> sources{*source};
  TrainSettings settings = TinyCrops();
  settings.crop_width = 0;  // OpenCV throws for an empty picture.
  BatchLoader loader(sources, settings, 7);
  const absl::Status status = loader.Next().status();
  EXPECT_TRUE(absl::IsInternal(status)) << status;
  EXPECT_EQ(status.message().substr(0, 17), "batch of step 7: ") << status;
}

TEST(BatchLoader, NamesTheFrameThatIsTooSmall) {
  const auto source = ReadTrainingSource(MakeArchive("small"), {});
  ASSERT_TRUE(source.ok());
  const std::vector<TrainingSource> sources{*source};
  TrainSettings settings = TinyCrops();
  settings.crop_height = 64;
  BatchLoader loader(sources, settings, 0);
  const absl::Status status = loader.Next().status();
  EXPECT_NE(status.message().find("a pair of 96x54 px is smaller than the crop"),
            absl::string_view::npos)
      << status;
  EXPECT_EQ(status.message().substr(0, 5), "a/000") << status;
}

}  // namespace
}  // namespace parallax
