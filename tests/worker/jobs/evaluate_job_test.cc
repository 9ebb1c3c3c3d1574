#include <gmock/gmock.h>

#include "common/base/ability_tags.h"
#include "common/base/hash.h"
#include "common/image/io.h"
#include "tests/worker/jobs/job_fixture.h"
#include "worker/agent/attempts/failure.h"
#include "worker/evaluate/evaluation.h"
#include "worker/jobs/offered_tags.h"

namespace parallax {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

class EvaluateJobTest : public JobTest {
 protected:
  v1::EvaluateJob JobOnHeldout() const {
    v1::EvaluateJob job;
    job.set_benchmark("heldout");
    job.set_trainer("sgbm");
    job.set_threads(1);
    *job.mutable_heldout() = FramesOf("b");
    job.add_group_by("material");
    return job;
  }
  absl::StatusOr<JobOutcome> Evaluate(const v1::EvaluateJob& job, int fence) {
    return Do(*MakeEvaluateHandler(options_), job, FolderOfAttempt(fence));
  }
};

TEST_F(EvaluateJobTest, ANetworkIsScoredByItsTrainersCommand) {
  v1::TrainResult trained;
  trained.ParseFromString(Train(TrainJobOf(), 1)->result);
  v1::EvaluateJob job = JobOnHeldout();
  job.set_name("a");
  job.set_trainer("script");
  job.set_seed(3);
  for (const v1::FileEntry& file : trained.files()) {
    if (file.name() == trained.checkpoints(0).name()) *job.mutable_checkpoint() = file;
  }
  job.set_checkpoint_path(trained.path() + "/" + job.checkpoint().name());
  const auto outcome = Evaluate(job, 2);
  ASSERT_TRUE(outcome.ok()) << outcome.status();
  v1::EvaluateResult result;
  ASSERT_TRUE(result.ParseFromString(outcome->result));
  EXPECT_EQ(result.pairs(), 7);
  EXPECT_EQ(result.metric(), "bad-2 nocc");
  EXPECT_GT(result.value(), 0);

  const auto scores = ReadEvaluation(dir_ + "/store/work/.attempt-2/scores.jsonl");
  ASSERT_TRUE(scores.ok()) << scores.status();
  EXPECT_EQ(scores->benchmark, "heldout");
  EXPECT_EQ(scores->run.variant, "a");
  EXPECT_EQ(scores->run.seed, 3);
  EXPECT_EQ(scores->run.checkpoint, job.checkpoint().sha256());
  EXPECT_EQ(scores->images[0].groups.count("material"), 1u);
  EXPECT_EQ(scores->images[0].groups.count("class"), 0u) << "not asked for";
  EXPECT_TRUE(std::filesystem::exists(dir_ + "/store/work/.attempt-2/sheet.png"));

  EXPECT_EQ(scores->run.looks, 0) << "as many as it takes";
  job.set_looks(1);
  ASSERT_TRUE(Evaluate(job, 4).ok());
  const auto once = ReadEvaluation(dir_ + "/store/work/.attempt-4/scores.jsonl");
  EXPECT_EQ(once->run.looks, 1);
  EXPECT_NE(once->images[0].regions, scores->images[0].regions) << "the trainer was told";

  job.mutable_checkpoint()->set_sha256(std::string(64, '0'));
  EXPECT_TRUE(absl::IsDataLoss(Evaluate(job, 3).status()));
}

TEST_F(EvaluateJobTest, ATrainerWithoutAWayToLookOnceSaysSo) {
  std::ofstream(dir_ + "/trainers/mine.yaml")
      << "trainer: mine\nlayout: archive\ntrain: [./train, '{seed}']\nprogress: json\n"
         "leaves: {final: last.json}\npredict: [./predict, '{checkpoint}', '{list}']\n";
  options_->trainers = *InstalledTrainers::Load({"mine"}, dir_ + "/trainers");
  ASSERT_TRUE(store_->Put("net.json", "[1, 2]").ok());
  v1::EvaluateJob job = JobOnHeldout();
  job.set_trainer("mine");
  job.set_checkpoint_path("net.json");
  job.mutable_checkpoint()->set_size(6);
  job.mutable_checkpoint()->set_sha256(Sha256Hex("[1, 2]"));
  job.set_looks(1);
  EXPECT_THAT(std::string(Evaluate(job, 1).status().message()),
              HasSubstr("trainer mine has no option for the number of looks"));
}

TEST_F(EvaluateJobTest, APredictorThatFailsIsOneLineWithItsLogsEnd) {
  v1::EvaluateJob job = JobOnHeldout();
  job.set_trainer("script");
  job.set_checkpoint_path("broken.json");
  ASSERT_TRUE(store_->Put("broken.json", "[1, 2").ok());
  job.mutable_checkpoint()->set_size(5);
  job.mutable_checkpoint()->set_sha256(Sha256Hex("[1, 2"));
  const absl::Status status = Evaluate(job, 1).status();
  const std::string message(status.message());
  EXPECT_THAT(message,
              HasSubstr("`script` ended with exit status 1: json.decoder.JSONDecodeError"));
  EXPECT_THAT(message, testing::Not(HasSubstr("\n")));
  EXPECT_THAT(LogTailOf(status), HasSubstr("Traceback"));
}

TEST_F(EvaluateJobTest, ABaselineNeedsNoNetwork) {
  v1::EvaluateJob job = JobOnHeldout();
  job.set_max_pairs(2);
  const auto outcome = Evaluate(job, 1);
  ASSERT_TRUE(outcome.ok()) << outcome.status();
  const auto scores = ReadEvaluation(dir_ + "/store/work/.attempt-1/scores.jsonl");
  ASSERT_TRUE(scores.ok()) << scores.status();
  EXPECT_EQ(scores->images.size(), 2u);
  EXPECT_FALSE(scores->run.seed.has_value());
  EXPECT_EQ(scores->run.variant, "sgbm");
}

// A command that names a file of its trainer's folder by a relative path.
TEST_F(EvaluateJobTest, ANetworkPredictsInTheFolderThatItsTrainerNames) {
  std::filesystem::create_directories(dir_ + "/trainers/here/cfgs");
  std::ofstream(dir_ + "/trainers/here/cfgs/small.yaml") << "width: 1\n";
  std::ofstream(dir_ + "/trainers/here.yaml")
      << "trainer: here\nlayout: archive\ndirectory: '{repository}'\ntrain: [./train, '{seed}']\n"
         "progress: json\nleaves: {final: last.json}\n"
         "predict: [sh, -c, 'test -f \"$0\" && exec \"$@\"', cfgs/small.yaml, " PYTHON
         ", -B, " SCRIPT_TRAINER ", predict, --checkpoint, '{checkpoint}', --list, '{list}']\n";
  auto trainers = InstalledTrainers::Load({"here"}, dir_ + "/trainers");
  ASSERT_TRUE(trainers.ok()) << trainers.status();
  options_->trainers = *std::move(trainers);
  const std::string network = "[6, \"48\"]";
  ASSERT_TRUE(store_->Put("net/last.json", network).ok());
  v1::EvaluateJob job = JobOnHeldout();
  job.set_trainer("here");
  job.set_checkpoint_path("net/last.json");
  job.mutable_checkpoint()->set_size(static_cast<int64_t>(network.size()));
  job.mutable_checkpoint()->set_sha256(Sha256Hex(network));
  const auto outcome = Evaluate(job, 1);
  EXPECT_TRUE(outcome.ok()) << outcome.status() << LogTailOf(outcome.status());
}

// Its disparity is the mean of the left picture minus that of the right.
TEST_F(EvaluateJobTest, AnOnnxNetworkIsRunByTheProgramTrainer) {
  setenv("PARALLAX_TRAINER", TRAINER, 1);
  std::filesystem::create_directories(dir_ + "/trainers");
  std::ofstream(dir_ + "/trainers/exported.yaml")
      << "trainer: exported\nlayout: archive\ntrain: [./train, '{seed}']\nprogress: json\n"
         "leaves: {final: last.onnx}\npredict: {format: onnx, pixel_range: 1}\n";
  auto trainers = InstalledTrainers::Load({"exported"}, dir_ + "/trainers");
  ASSERT_TRUE(trainers.ok()) << trainers.status();
  options_->trainers = *std::move(trainers);
  const auto network = ReadFile(ONNX_NETWORK);
  ASSERT_TRUE(network.ok()) << network.status();
  ASSERT_TRUE(store_->Put("net/last.onnx", *network).ok());
  v1::EvaluateJob job = JobOnHeldout();
  job.set_trainer("exported");
  job.set_checkpoint_path("net/last.onnx");
  job.mutable_checkpoint()->set_size(static_cast<int64_t>(network->size()));
  job.mutable_checkpoint()->set_sha256(Sha256Hex(*network));
  const auto outcome = Evaluate(job, 1);
  unsetenv("PARALLAX_TRAINER");
  ASSERT_TRUE(outcome.ok()) << outcome.status() << LogTailOf(outcome.status());
  v1::EvaluateResult result;
  ASSERT_TRUE(result.ParseFromString(outcome->result));
  EXPECT_EQ(result.pairs(), 7);
}

// One scene of the 27 of a public benchmark.
class PartOfABenchmarkTest : public EvaluateJobTest {
 protected:
  void SetUp() override {
    EvaluateJobTest::SetUp();
    const std::string scene = dir_ + "/sets/ETH3D/two_view_training/s";
    std::filesystem::create_directories(scene);
    for (const char* name : {"/im0.png", "/im1.png"}) {
      ASSERT_TRUE(WritePng(scene + name, ImageRgb8(64, 48)).ok());
    }
    ASSERT_TRUE(WritePng(scene + "/mask0nocc.png", ImageU8(64, 48, 255)).ok());
    ASSERT_TRUE(WritePfm(scene + "/disp0GT.pfm", ImageF(64, 48, 5)).ok());
    options_->benchmarks_dir = dir_ + "/sets";
  }
};

TEST_F(PartOfABenchmarkTest, AResultTellsHowManyOfItsPairsAreMissing) {
  v1::EvaluateJob job;
  job.set_benchmark("eth3d");
  job.set_trainer("sgbm");
  job.set_max_pairs(1);
  const auto outcome = Evaluate(job, 1);
  ASSERT_TRUE(outcome.ok()) << outcome.status();
  v1::EvaluateResult result;
  ASSERT_TRUE(result.ParseFromString(outcome->result));
  EXPECT_EQ(result.pairs(), 1);
  EXPECT_EQ(result.pairs_missing(), 26);
}

TEST_F(PartOfABenchmarkTest, AWorkerTellsItsTrainersAndBenchmarksByTags) {
  setenv("PARALLAX_NETWORK", "/nowhere/network.pt", 1);
  EXPECT_THAT(AbilityTagsOf(*options_), ElementsAre("trainer:script", "benchmark:eth3d"));
  options_->benchmarks_dir = "";
  EXPECT_THAT(AbilityTagsOf(*options_), ElementsAre("trainer:script"));
  ASSERT_TRUE(WriteFile(dir_ + "/network.pt", "weights").ok());
  setenv("PARALLAX_NETWORK", (dir_ + "/network.pt").c_str(), 1);
  EXPECT_THAT(AbilityTagsOf(*options_),
              ElementsAre("trainer:script", NetworkTag(Sha256Hex("weights"))));
  unsetenv("PARALLAX_NETWORK");
}

TEST_F(EvaluateJobTest, ATrainerWhoseProgramIsMissingIsNotOffered) {
  setenv("PARALLAX_NETWORK", "/nowhere/network.pt", 1);
  std::ofstream(dir_ + "/trainers/exported.yaml")
      << "trainer: exported\nlayout: archive\ntrain: [./train, '{seed}']\nprogress: json\n"
         "leaves: {final: last.onnx}\npredict: onnx\n";
  auto trainers = InstalledTrainers::Load({"builtin", "exported", "script"}, dir_ + "/trainers");
  ASSERT_TRUE(trainers.ok()) << trainers.status();
  options_->trainers = *std::move(trainers);
  setenv("PARALLAX_TRAINER", TRAINER, 1);
  EXPECT_THAT(AbilityTagsOf(*options_),
              ElementsAre("trainer:builtin", "trainer:exported", "trainer:script"));
  setenv("PARALLAX_TRAINER", "/nowhere/trainer", 1);
  EXPECT_THAT(AbilityTagsOf(*options_), ElementsAre("trainer:script"));
  unsetenv("PARALLAX_TRAINER");
  unsetenv("PARALLAX_NETWORK");
}

TEST_F(EvaluateJobTest, NoJobReadsPathsOfThisMachine) {
  v1::EvaluateJob job = JobOnHeldout();
  for (const char* name : {"folder:/etc", "list:/etc/passwd", "x=archive:/tmp", "../kitti2015"}) {
    job.set_benchmark(name);
    const absl::Status status = Evaluate(job, 1).status();
    EXPECT_TRUE(absl::IsInvalidArgument(status)) << status;
    EXPECT_THAT(std::string(status.message()), HasSubstr("a name, and no path"));
  }
}

}  // namespace
}  // namespace parallax
