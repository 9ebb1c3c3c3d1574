#include <gmock/gmock.h>

#include "common/base/hash.h"
#include "tests/worker/jobs/job_fixture.h"
#include "worker/agent/failure.h"
#include "worker/evaluate/evaluate.h"

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

  job.mutable_checkpoint()->set_sha256(std::string(64, '0'));
  EXPECT_TRUE(absl::IsDataLoss(Evaluate(job, 3).status()));
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
