#include "worker/jobs/files/frame_folder.h"

#include <fmt/core.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <set>

#include "common/base/system/file.h"
#include "common/config/sensor_presets.h"
#include "common/image/io.h"
#include "tests/worker/jobs/job_fixture.h"
#include "worker/dataset/archive/dataset_reader.h"
#include "worker/dataset/frame/sensor_stage.h"
#include "worker/jobs/training/training_data_folder.h"

namespace parallax {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

class FrameFolderTest : public JobTest {
 protected:
  absl::StatusOr<FrameFolderFacts> Bring(const std::string& name, FrameFolderOptions options) {
    options.files = FilesForTraining();
    return BringFrames(FramesOf("a"), *store_, FrameCache(options_->frame_cache),
                       dir_ + "/" + name + "/a", options);
  }
  std::vector<DatasetFrame> FramesIn(const std::string& name) const {
    return ReadDataset(dir_ + "/" + name)->variants.at(0).frames;
  }
};

TEST_F(FrameFolderTest, IsAnArchiveOfThePairsThatPass) {
  const auto facts = Bring("one", {});
  ASSERT_TRUE(facts.ok()) << facts.status();
  EXPECT_EQ(facts->pairs, 7);
  EXPECT_EQ(facts->left_out, 1);
  const auto dataset = ReadDataset(dir_ + "/one");
  ASSERT_TRUE(dataset.ok()) << dataset.status();
  EXPECT_THAT(dataset->variants.at(0).faults, ElementsAre());
  EXPECT_EQ(dataset->variants.at(0).frames.size(), 7u);
  EXPECT_EQ(Bring("two", {})->sha256, facts->sha256);
}

TEST_F(FrameFolderTest, AShareIsTheFirstPairs) {
  const auto half = Bring("half", {.share = 0.5});
  ASSERT_TRUE(half.ok()) << half.status();
  EXPECT_EQ(half->pairs, 4);
  EXPECT_EQ(FramesIn("half").back().scene, 1u);
  EXPECT_EQ(Bring("least", {.share = 0.01})->pairs, 1);
}

TEST_F(FrameFolderTest, MismatchedPairsHaveTheRightImageOfAnotherScene) {
  const auto facts = Bring("mixed", {.mismatched = 1});
  ASSERT_TRUE(facts.ok()) << facts.status();
  EXPECT_EQ(facts->mismatched, 7);
  ASSERT_TRUE(Bring("plain", {}).ok());
  const auto mixed = FramesIn("mixed"), plain = FramesIn("plain");
  ASSERT_EQ(mixed.size(), plain.size());
  for (size_t i = 0; i < plain.size(); ++i) {
    const DatasetFrame& other = plain[(i + plain.size() / 2) % plain.size()];
    EXPECT_EQ(mixed[i].files.at("left.png"), plain[i].files.at("left.png"));
    EXPECT_EQ(mixed[i].files.at("right.png"), other.files.at("right.png"));
    EXPECT_NE(other.scene, plain[i].scene);
  }
  EXPECT_THAT(std::string(Bring("lone", {.share = 0.01, .mismatched = 1}).status().message()),
              HasSubstr("can't be mismatched"));
}

class TwentyPairsTest : public FrameFolderTest {
 protected:
  static constexpr int kPairs = 20;

  void SetUp() override {
    MakeSyntheticArchive(dir_ + "/archive", {.variants = {"t"}, .scenes = kPairs, .rigs = 1});
    std::filesystem::copy(dir_ + "/archive/t/frames", dir_ + "/store",
                          std::filesystem::copy_options::recursive);
    auto store = OpenStore(dir_ + "/store");
    ASSERT_TRUE(store.ok()) << store.status();
    store_ = *std::move(store);
    job_.add_parts()->set_variant("t");
    for (uint32_t scene = 0; scene < kPairs; ++scene) {
      v1::FrameFolder& folder = *job_.mutable_parts(0)->add_folders();
      folder.set_folder(fmt::format("{:06}", scene));
      folder.set_scene(scene);
      folder.add_rigs(0);
      // Synthetic scenes look alike.
      ASSERT_TRUE(WritePng(dir_ + "/store/" + folder.folder() + "/000/right.png",
                           ImageRgb8(96, 54, static_cast<uint8_t>(scene)))
                      .ok());
    }
  }

  TrainingDataFolder Make(const std::string& name, double share) {
    job_.set_mismatched(share > 0);
    job_.set_mismatched_share(share);
    TrainerContract contract;
    contract.layout = "archive";
    auto data = MakeTrainingData(job_, contract, {.store = store_.get(), .dir = dir_ + "/" + name});
    EXPECT_TRUE(data.ok()) << data.status();
    return data.ok() ? *std::move(data) : TrainingDataFolder();
  }

  // Scenes of the folder whose right image is not their own.
  std::set<uint32_t> ForeignIn(const std::string& name) const {
    std::set<uint32_t> scenes;
    const auto own = ReadDataset(dir_ + "/plain/0")->variants.at(0).frames;
    const auto frames = ReadDataset(dir_ + "/" + name + "/0")->variants.at(0).frames;
    for (size_t i = 0; i < frames.size(); ++i) {
      if (frames[i].files.at("right.png") != own[i].files.at("right.png")) {
        scenes.insert(frames[i].scene);
      }
    }
    return scenes;
  }

  v1::TrainJob job_;
};

TEST_F(TwentyPairsTest, AShareOfMismatchedPairsIsSpreadAndPartOfEachLargerOne) {
  const TrainingDataFolder plain = Make("plain", 0);
  EXPECT_EQ(plain.facts["mismatched_share"], 0);
  std::set<uint32_t> smaller;
  std::set<std::string> hashes;
  for (const auto& [share, pairs] :
       {std::pair(0.01, 1u), {0.1, 2u}, {0.25, 5u}, {0.5, 10u}, {0.9, 18u}, {1.0, 20u}}) {
    SCOPED_TRACE(share);
    const std::string name = fmt::format("share-{}", pairs);
    const TrainingDataFolder data = Make(name, share);
    EXPECT_EQ(data.pairs, kPairs) << "the others keep their right images";
    EXPECT_EQ(data.facts["mismatched_share"], share);
    EXPECT_EQ(data.facts["parts"][0]["mismatched_pairs"], pairs);
    hashes.insert(data.facts["parts"][0]["sha256"]);
    const std::set<uint32_t> foreign = ForeignIn(name);
    EXPECT_EQ(foreign.size(), pairs);
    EXPECT_TRUE(std::includes(foreign.begin(), foreign.end(), smaller.begin(), smaller.end()));
    if (pairs == 10) {
      for (uint32_t from = 0; from < kPairs; from += 5) {
        const auto in_five =
            std::distance(foreign.lower_bound(from), foreign.lower_bound(from + 5));
        EXPECT_GE(in_five, 2) << "from scene " << from;
      }
    }
    smaller = foreign;
  }
  EXPECT_EQ(hashes.size(), 6u);
}

TEST_F(FrameFolderTest, FramesThatNetworksMissAreTurnedDownWhereSharesAreGiven) {
  v1::FrameSet set = FramesOf("a");
  set.mutable_filters()->set_max_ambiguous_share(0.6);
  std::map<FrameId, double> shares;
  for (uint32_t scene = 0; scene < kScenes; ++scene) {
    for (uint32_t rig = 0; rig < kRigs; ++rig) shares[{scene, rig}] = 0.6;
  }
  shares[{1, 0}] = 0.61;
  shares[{2, 1}] = 1;
  FrameFolderOptions options;
  options.files = FilesForTraining();
  const auto bring = [&](const std::string& name) {
    return BringFrames(set, *store_, FrameCache(options_->frame_cache), dir_ + "/" + name + "/a",
                       options);
  };
  EXPECT_EQ(bring("plain")->pairs, 7) << "no shares, no verdict";
  options.ambiguous_shares = &shares;
  const auto curated = bring("curated");
  ASSERT_TRUE(curated.ok()) << curated.status();
  EXPECT_EQ(curated->pairs, 5);
  EXPECT_EQ(curated->left_out, 3) << "the dark one too";
  for (const DatasetFrame& frame : FramesIn("curated")) {
    EXPECT_FALSE(frame.scene == 1 && frame.rig == 0);
    EXPECT_FALSE(frame.scene == 2 && frame.rig == 1);
  }
}

TEST_F(FrameFolderTest, ASensorsPicturesAreThoseThatAnArchiveGets) {
  v1::FrameSet set = FramesOf("a");
  TakeSensorPreset("webcam", set.mutable_sensor());
  FrameFolderOptions options;
  options.files = FilesForTraining();
  const FrameCache cache(options_->frame_cache);
  const auto facts = BringFrames(set, *store_, cache, dir_ + "/near/a", options);
  ASSERT_TRUE(facts.ok()) << facts.status();
  EXPECT_EQ(facts->pairs, 7) << "verdicts are the rendered pictures'";
  const auto plain = Bring("plain", {});
  EXPECT_NE(facts->sha256, plain->sha256);
  EXPECT_EQ(FramesIn("near")[0].files.size(), FramesIn("plain")[0].files.size());

  const std::string stored = dir_ + "/store/" + FolderOf("a", 0) + "/000/";
  const auto files = FilesOfFrame(stored, FilesForSensor(set.sensor()));
  ASSERT_TRUE(files.ok()) << files.status();
  google::protobuf::RepeatedPtrField<v1::FileEntry> entries;
  for (const auto& [name, file] : *files) {
    entries.Add()->set_name(name);
    entries.rbegin()->set_sha256(file.sha256);
  }
  const auto made = MakeSensorFiles(set.sensor(), SensorKey(set.sensor(), entries),
                                    [&](const std::string& name) { return stored + name; });
  ASSERT_TRUE(made.ok()) << made.status();
  for (const auto& [name, bytes] : *made) {
    EXPECT_EQ(*ReadFile(dir_ + "/near/a/frames/000000/000/" + name), bytes) << name;
  }

  const DistantStore distant(store_);
  const auto far = BringFrames(set, distant, cache, dir_ + "/far/a", options);
  ASSERT_TRUE(far.ok()) << far.status();
  EXPECT_EQ(far->sha256, facts->sha256);
  options.mismatched = 1;
  ASSERT_TRUE(BringFrames(set, *store_, cache, dir_ + "/mixed/a", options).ok());
  const auto mixed = FramesIn("mixed"), near = FramesIn("near");
  EXPECT_EQ(mixed[0].files.at("right.png"), near[3].files.at("right.png"));
}

// Predicts the same disparity everywhere.
class ConstantPredictor final : public Predictor {
 public:
  explicit ConstantPredictor(float disparity_px) : disparity_px_(disparity_px) {}
  std::string name() const override { return "constant"; }
  absl::Status Predict(const std::vector<PredictionTask>& tasks,
                       const PredictionContext&) override {
    for (const PredictionTask& task : tasks) {
      ++predicted;
      RETURN_IF_ERROR(WritePfm(task.output, ImageF(96, 54, disparity_px_)));
    }
    return absl::OkStatus();
  }
  int predicted = 0;

 private:
  const float disparity_px_;
};

TEST_F(FrameFolderTest, ACuratedJobsFramesAreScoredByItsNetwork) {
  v1::TrainJob job = TrainJobOf();
  job.set_curated(true);
  TrainerContract contract;
  contract.layout = "archive";
  int number = 0;
  const auto make = [&](double most, CurationNetwork curator) {
    job.mutable_parts(0)->mutable_filters()->set_max_ambiguous_share(most);
    return MakeTrainingData(job, contract,
                            {.store = store_.get(),
                             .dir = dir_ + "/data" + std::to_string(number++),
                             .curator = std::move(curator)});
  };
  EXPECT_EQ(make(0.5, {}).status().code(), absl::StatusCode::kInvalidArgument);
  // Both rigs see the same with different baselines: a constant fits one better than the other.
  ConstantPredictor network(4.5f);
  std::set<int64_t> seen;
  int64_t last = 0;
  for (const double most : {0.0, 0.2, 0.4, 0.6, 0.8, 0.9, 0.95, 0.99, 1.0}) {
    const auto data = make(most, {"net", &network});
    const int64_t pairs = data.ok() ? data->pairs : 0;
    if (data.ok()) {
      EXPECT_EQ(data->facts["curated_by"], "net");
    } else {
      EXPECT_THAT(std::string(data.status().message()), HasSubstr("no pair is left"));
    }
    EXPECT_GE(pairs, last) << most;
    last = pairs;
    seen.insert(pairs);
  }
  EXPECT_EQ(last, 7);
  EXPECT_EQ(*seen.begin(), 0) << "a constant misses some pixels of every frame";
  EXPECT_GE(seen.size(), 3u) << "some frames are missed more than others";
  EXPECT_EQ(network.predicted, 9 * 7) << "the dark one is not asked for";
}

TEST(Repetitions, GiveEachPartItsWeight) {
  EXPECT_THAT(Repetitions({100, 100}, {1, 1}), ElementsAre(1, 1));
  EXPECT_THAT(Repetitions({300, 100}, {1, 1}), ElementsAre(1, 3));
  EXPECT_THAT(Repetitions({100, 100}, {0.8, 0.2}), ElementsAre(4, 1));
  EXPECT_THAT(Repetitions({1000, 1}, {1, 1}), ElementsAre(1, 20)) << "bounded";
}

TEST_F(FrameFolderTest, OtherLayoutsHoldAllPartsInOneFolder) {
  v1::TrainJob job = TrainJobOf();
  *job.add_parts() = FramesOf("b");
  job.mutable_parts(1)->set_weight(2);
  TrainerContract contract;
  contract.layout = "kitti";
  const auto data = MakeTrainingData(job, contract, {.store = store_.get(), .dir = dir_ + "/data"});
  ASSERT_TRUE(data.ok()) << data.status();
  ASSERT_EQ(data->parts.size(), 1u);
  EXPECT_EQ(data->pairs, 14);
  int images = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(data->parts[0].first)) {
    images += entry.path().parent_path().filename() == "image_2";
  }
  EXPECT_EQ(images, 21) << "the second part twice";
  std::set<std::string> names;
  const auto list = nlohmann::json::parse(*ReadFile(data->parts[0].first + "/export.json"));
  for (const auto& frame : list["frames"]) names.insert(frame["variant"]);
  EXPECT_THAT(names, ElementsAre("a", "b", "b-2")) << "no dot, which would end a sample's key";
}

}  // namespace
}  // namespace parallax
