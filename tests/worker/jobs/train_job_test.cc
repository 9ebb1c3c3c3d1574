#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "common/base/ability_tags.h"
#include "common/base/hash.h"
#include "tests/worker/jobs/job_fixture.h"
#include "worker/agent/attempts/failure.h"
#include "worker/agent/attempts/patient_store.h"

namespace parallax {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::Contains;
using testing::HasSubstr;
using testing::Not;
using Json = nlohmann::json;

std::string Message(const absl::Status& status) { return std::string(status.message()); }

v1::TrainResult ResultOf(const absl::StatusOr<JobOutcome>& outcome) {
  v1::TrainResult result;
  EXPECT_TRUE(outcome.ok()) << outcome.status();
  if (outcome.ok()) {
    EXPECT_TRUE(result.ParseFromString(outcome->result));
  }
  return result;
}

std::string FinalHash(const v1::TrainResult& result) {
  for (const v1::FileEntry& file : result.files()) {
    if (file.name() == result.checkpoints(result.checkpoints_size() - 1).name())
      return file.sha256();
  }
  return "";
}

using TrainJob = JobTest;

TEST_F(TrainJob, LeavesNetworkLogCurveAndAllThatRepeatsIt) {
  const v1::TrainResult result = ResultOf(Train(TrainJobOf(), 1));
  EXPECT_EQ(result.path(), "work/.attempt-1");
  EXPECT_EQ(result.pairs(), kScenes * kRigs - 1) << "one is dark";
  ASSERT_EQ(result.checkpoints_size(), 1);
  EXPECT_EQ(result.checkpoints(0).step(), 6) << "the trainer's own number";
  EXPECT_NEAR(result.loss(), 0.7, 0.3);
  for (const v1::FileEntry& file : result.files()) {
    const std::string bytes = TextOf(result.path() + "/" + file.name());
    EXPECT_EQ(Sha256Hex(bytes), file.sha256()) << file.name();
    EXPECT_EQ(static_cast<int64_t>(bytes.size()), file.size());
  }
  EXPECT_EQ(figures_["step"], 6);
  EXPECT_EQ(figures_.count("eta_s"), 1u);
  EXPECT_THAT(TextOf(result.path() + "/curve.csv"), HasSubstr("\n3,0.333333,0.666667,"));
  const Json card = Json::parse(TextOf(result.path() + "/training.json"));
  EXPECT_EQ(card["seed"], 3);
  EXPECT_EQ(card["data"]["parts"][0]["left_out_by_filters"], 1);
}

TEST_F(TrainJob, MinutesAreStepsAtTheTrainersRateAndSizesReachIt) {
  v1::TrainJob job = TrainJobOf();
  job.set_minutes(0.5);
  const v1::TrainResult plain = ResultOf(Train(job, 1));
  EXPECT_EQ(plain.checkpoints(0).step(), 4);
  job.set_width_px(64);
  job.set_height_px(32);
  EXPECT_NE(FinalHash(ResultOf(Train(job, 2))), FinalHash(plain));
  job.set_batch(2);
  EXPECT_THAT(Message(Train(job, 3).status()), HasSubstr("has no option for the batch"));
}

TEST_F(TrainJob, BeginsWithTheTrainedNetworkOfWhichTheStudySaysTheHash) {
  const std::string network = dir_ + "/network.pt";
  ASSERT_TRUE(WriteFile(network, "weights").ok());
  setenv("PARALLAX_NETWORK", network.c_str(), 1);
  v1::TrainJob job = TrainJobOf();
  const v1::TrainResult scratch = ResultOf(Train(job, 1));
  EXPECT_EQ(Json::parse(TextOf("work/.attempt-1/training.json"))["start"], "scratch");
  job.set_start(NetworkTag(Sha256Hex("weights")));
  EXPECT_NE(FinalHash(ResultOf(Train(job, 2))), FinalHash(scratch));
  EXPECT_EQ(Json::parse(TextOf("work/.attempt-2/training.json"))["start"], job.start());

  ASSERT_TRUE(WriteFile(network, "others").ok());
  const absl::Status other = Train(job, 3).status();
  EXPECT_TRUE(absl::IsFailedPrecondition(other));
  EXPECT_EQ(Message(other), network + " is " + NetworkTag(Sha256Hex("others")) +
                                ", but the training begins with " + job.start());
  setenv("PARALLAX_NETWORK", "/nowhere/network.pt", 1);
  EXPECT_THAT(Message(Train(job, 4).status()), HasSubstr("$PARALLAX_NETWORK: /nowhere"));
  unsetenv("PARALLAX_NETWORK");
}

TEST_F(TrainJob, ATrainerWithoutAWayToStartFromANetworkSaysSo) {
  ASSERT_TRUE(WriteFile(dir_ + "/network.pt", "weights").ok());
  setenv("PARALLAX_NETWORK", (dir_ + "/network.pt").c_str(), 1);
  const std::string path = dir_ + "/trainers/script.yaml";
  std::string text = *ReadFile(path);
  text.erase(text.find("start:"), text.find("looks:") - text.find("start:"));
  ASSERT_TRUE(WriteFile(path, text).ok());
  options_->trainers = *InstalledTrainers::Load(allowed_, dir_ + "/trainers");
  v1::TrainJob job = TrainJobOf();
  job.set_start(NetworkTag(Sha256Hex("weights")));
  EXPECT_THAT(Message(Train(job, 1).status()),
              HasSubstr("trainer script has no option for the network to start from"));
  unsetenv("PARALLAX_NETWORK");
}

// Killed after any step, with the newest checkpoint damaged, on a machine that sees the store or
// not: the network is that of a calm run.
TEST_F(TrainJob, GoesOnFromTheNewestWholeCheckpointWhicheverAttemptLeftIt) {
  WriteTrainer("slow", "SCRIPT_PAUSE=0.3");
  v1::TrainJob job = TrainJobOf();
  job.set_steps(12);
  job.set_checkpoints(4);
  job.set_resume_folder("");
  const v1::TrainResult calm = ResultOf(Train(job, 1));
  job.set_resume_folder("work");
  job.set_trainer("slow");
  CancelToken cancel;
  on_progress_ = [&](const JobFigures& figures) {
    if (figures.count("step") != 0 && figures.at("step") >= 8) cancel.Cancel();
  };
  EXPECT_TRUE(absl::IsCancelled(Train(job, 2, cancel).status()));
  on_progress_ = [](const JobFigures&) {};
  const std::string newest = dir_ + "/store/work/.attempt-2/resume/000000006/net-6.json";
  ASSERT_TRUE(fs::exists(newest));
  std::ofstream(newest, std::ios::app) << "x";

  job.set_trainer("script");
  const v1::TrainResult resumed = ResultOf(Train(job, 3));
  EXPECT_TRUE(had_checkpoints_) << "for another attempt, until the coordinator has the result";
  EXPECT_EQ(FinalHash(resumed), FinalHash(calm));
  EXPECT_THAT(TextOf("work/.attempt-3/log.txt"), HasSubstr("resumed from 3"));
  EXPECT_EQ(resumed.checkpoints_size(), calm.checkpoints_size());
  for (int i = 0; i < calm.checkpoints_size(); ++i) {
    EXPECT_EQ(resumed.checkpoints(i).SerializeAsString(), calm.checkpoints(i).SerializeAsString());
  }
  // A line a step, those of before included.
  const std::string curve = TextOf("work/.attempt-3/curve.csv");
  EXPECT_EQ(std::count(curve.begin(), curve.end(), '\n'), 13) << curve;
}

class ResumedTrainJob : public TrainJob {
 protected:
  // Trains to the end, and another time until step 8, which leaves checkpoints of steps 3 and 6.
  void SetUp() override {
    TrainJob::SetUp();
    WriteTrainer("slow", "SCRIPT_PAUSE=0.3");
    job_ = TrainJobOf();
    job_.set_steps(12);
    job_.set_checkpoints(4);
    job_.set_resume_folder("");
    calm_ = FinalHash(ResultOf(Train(job_, 1)));
    job_.set_resume_folder("work");
    job_.set_trainer("slow");
    CancelToken cancel;
    on_progress_ = [&](const JobFigures& figures) {
      if (figures.count("step") != 0 && figures.at("step") >= 8) cancel.Cancel();
    };
    EXPECT_TRUE(absl::IsCancelled(Train(job_, 2, cancel).status()));
    on_progress_ = [](const JobFigures&) {};
    job_.set_trainer("script");
  }
  // Makes the checkpoint one that its facts describe, but that no trainer can read.
  void Spoil(int step) {
    const std::string folder = "work/.attempt-2/resume/00000000" + std::to_string(step);
    const std::string broken = "[" + std::to_string(step) + ", ";
    Json facts = Json::parse(TextOf(folder + "/facts.json"));
    facts["size"] = broken.size();
    facts["sha256"] = Sha256Hex(broken);
    ASSERT_TRUE(store_->Put(folder + "/" + facts["name"].get<std::string>(), broken).ok());
    ASSERT_TRUE(store_->Put(folder + "/facts.json", facts.dump()).ok());
  }

  v1::TrainJob job_;
  std::string calm_;  // The network's hash.
};

TEST_F(ResumedTrainJob, ACheckpointThatNoTrainerCanReadIsPassedOverForTheOneBefore) {
  Spoil(6);
  EXPECT_EQ(FinalHash(ResultOf(Train(job_, 3))), calm_);
  EXPECT_THAT(TextOf("work/.attempt-3/log.txt"), HasSubstr("resumed from 3"));
}

TEST_F(ResumedTrainJob, WithoutAnyGoodCheckpointItBeginsAnew) {
  Spoil(3);
  Spoil(6);
  const v1::TrainResult result = ResultOf(Train(job_, 3));
  EXPECT_EQ(FinalHash(result), calm_);
  EXPECT_EQ(result.checkpoints_size(), 4);
  EXPECT_THAT(TextOf("work/.attempt-3/log.txt"), Not(HasSubstr("resumed from")));
}

TEST_F(ResumedTrainJob, AFailureBeyondTheCheckpointOrForMemoryIsNotTheCheckpoints) {
  for (const char* does : {"crash 9", "memory 7"}) {
    WriteTrainer("bad", "SCRIPT_TRAINER=" + std::string(does));
    job_.set_trainer("bad");
    const absl::Status status = Train(job_, 3).status();
    EXPECT_EQ(absl::IsAborted(status), does[0] == 'c') << status;
    EXPECT_THAT(LogTailOf(status), HasSubstr("resumed from 6")) << does;
  }
}

TEST_F(TrainJob, AStoppedTrainersHalfCheckpointIsNotKept) {
  WriteTrainer("half", "SCRIPT_TRAINER=half 4");
  v1::TrainJob job = TrainJobOf("half");
  job.set_steps(12);
  job.set_checkpoints(6);  // One after each two steps.
  CancelToken cancel;
  on_progress_ = [&](const JobFigures& figures) {
    if (figures.count("step") != 0 && figures.at("step") >= 4) cancel.Cancel();
  };
  EXPECT_TRUE(absl::IsCancelled(Train(job, 1, cancel).status()));
  EXPECT_EQ(TextOf("work/.attempt-1/resume/000000004/facts.json"), "");
}

TEST_F(TrainJob, ATrainerThatCannotResumeHasLearningCurvesToo) {
  WriteTrainer("once", "", /*resumes=*/false);
  v1::TrainJob job = TrainJobOf("once");
  job.set_steps(12);
  job.set_checkpoints(3);
  const v1::TrainResult result = ResultOf(Train(job, 1));
  std::vector<int64_t> steps;
  for (const v1::TrainedCheckpoint& checkpoint : result.checkpoints()) {
    steps.push_back(checkpoint.step());
  }
  EXPECT_THAT(steps, testing::ElementsAre(4, 8, 12));
  EXPECT_FALSE(had_checkpoints_);
}

TEST_F(TrainJob, TellsNaNCrashMemoryAndFailureInOneLineWithTheLogsEnd) {
  const struct {
    const char* does;
    absl::StatusCode code;
    const char* says;
    const char* log_has = "\"step\": 1";
  } cases[] = {
      {"nan 3", absl::StatusCode::kFailedPrecondition, "the loss is not finite at step 3"},
      {"crash 2", absl::StatusCode::kAborted, "killed by signal 11 (Segmentation fault)"},
      {"memory 2", absl::StatusCode::kResourceExhausted,
       "out of memory: torch.cuda.OutOfMemoryError"},
      {"fail 4", absl::StatusCode::kInternal, "exit status 1: no such luck", "line 200\n"},
      {"usage 2", absl::StatusCode::kInvalidArgument, "pictures are smaller than the crop"},
      {"lazy 2", absl::StatusCode::kInternal, "ended without last.json"},
  };
  int fence = 1;
  for (const auto& c : cases) {
    const std::string name = std::string(c.does).substr(0, std::string(c.does).find(' '));
    WriteTrainer(name, "SCRIPT_TRAINER=" + std::string(c.does));
    const absl::Status status = Train(TrainJobOf(name), fence++).status();
    EXPECT_EQ(status.code(), c.code) << status;
    EXPECT_THAT(Message(status), AllOf(HasSubstr(c.says), Not(HasSubstr("\n"))));
    EXPECT_THAT(LogTailOf(status), HasSubstr(c.log_has));
  }
}

TEST_F(TrainJob, RunsNothingThatTheOperatorDidNotAllow) {
  std::ofstream(dir_ + "/trainers/other.yaml") << "trainer: other\n";
  const absl::Status status = Train(TrainJobOf("other"), 1).status();
  EXPECT_TRUE(absl::IsUnimplemented(status));
  EXPECT_THAT(Message(status), HasSubstr("trainer 'other' is not allowed on this worker"));
  EXPECT_THAT(Message(InstalledTrainers::Load({"builtin", "absent"}, dir_ + "/trainers").status()),
              HasSubstr("absent.yaml"));
}

TEST_F(TrainJob, ACuratedSetIsScoredByTheNetworkThatItIsTold) {
  v1::TrainJob job = TrainJobOf();
  job.set_curated(true);
  job.mutable_parts(0)->mutable_filters()->set_max_ambiguous_share(0.999);
  const std::string network = "[6, \"48\"]";  // 4.5 px everywhere.
  ASSERT_TRUE(store_->Put("other/.attempt-1/last.json", network).ok());
  job.set_curator_path("other/.attempt-1/last.json");
  job.mutable_curator()->set_size(static_cast<int64_t>(network.size()));
  job.mutable_curator()->set_sha256(Sha256Hex(network));
  options_->cores = std::make_unique<CoreShare>(dir_ + "/cores", 2);
  const v1::TrainResult result = ResultOf(Train(job, 1));
  EXPECT_GT(result.pairs(), 0);
  EXPECT_NE(TextOf(result.path() + "/training.json").find(Sha256Hex(network)), std::string::npos);
  job.mutable_parts(0)->mutable_filters()->set_max_ambiguous_share(0.01);
  EXPECT_THAT(Message(Train(job, 2).status()), HasSubstr("no pair is left"));
  job.mutable_curator()->set_sha256(std::string(64, 'a'));
  EXPECT_THAT(Message(Train(job, 3).status()), HasSubstr("is not the network that was trained"));
}

TEST_F(TrainJob, WaitsForItsCores) {
  options_->cores = std::make_unique<CoreShare>(dir_ + "/cores", 2);
  auto other = options_->cores->TakeShared({}, [] {});
  ASSERT_TRUE(other.ok());
  v1::TrainJob job = TrainJobOf();
  job.set_threads(2);
  int waited = 0;
  on_progress_ = [&](const JobFigures& figures) {
    if (figures.empty() && stages_["wait for cores"] == 3 && waited++ == 0)
      *other = CoreShare::Hold();
  };
  ResultOf(Train(job, 1));
  EXPECT_GE(stages_["wait for cores"], 3);
}

TEST_F(TrainJob, ABusyCoordinatorIsAskedAgainForPairsAndCheckpoints) {
  v1::TrainJob job = TrainJobOf();
  job.set_checkpoints(2);
  const std::string here = FinalHash(ResultOf(Train(job, 1)));
  const auto far = std::make_shared<DistantStore>(store_);
  far->busy_piece = 3;
  far->busy_put = 1;
  int tries = 0;
  const auto patient = MakePatientStore(far, {}, [&tries] { ++tries; });
  EXPECT_EQ(FinalHash(ResultOf(Do(*MakeTrainHandler(options_), job, FolderOfAttempt(2, patient)))),
            here);
  EXPECT_GT(far->pieces, far->busy_piece);
  EXPECT_GT(far->puts, far->busy_put);
  EXPECT_GE(tries, far->pieces + far->puts);
}

TEST_F(TrainJob, FromAStoreFarAwayItTrainsOnTheSamePairsAndSendsItsCheckpoints) {
  const std::string here = FinalHash(ResultOf(Train(TrainJobOf(), 1)));
  const auto far = std::make_shared<DistantStore>(store_);
  const auto handler = MakeTrainHandler(options_);
  v1::TrainJob job = TrainJobOf();
  job.set_resume_folder("");
  const auto first = Do(*handler, job, FolderOfAttempt(2, far));
  EXPECT_EQ(FinalHash(ResultOf(first)), here);
  EXPECT_TRUE(fs::exists(dir_ + "/staging/2/last.json") ||
              fs::exists(dir_ + "/staging/2/final.json"));

  // The second time nothing is brought again but what was damaged meanwhile.
  const int brought = far->pieces;
  for (const auto& entry : fs::recursive_directory_iterator(dir_ + "/cache/a1")) {
    if (entry.path().filename().string().rfind("left.png~", 0) == 0) {
      fs::resize_file(entry.path(), 10);
      break;
    }
  }
  EXPECT_EQ(FinalHash(ResultOf(Do(*handler, job, FolderOfAttempt(3, far)))), here);
  EXPECT_EQ(far->pieces, brought + 1);

  options_->frame_cache.max_bytes = 1000;
  ResultOf(Do(*handler, job, FolderOfAttempt(4, far)));
  int files = 0;
  for (const auto& entry : fs::recursive_directory_iterator(dir_ + "/cache"))
    files += entry.is_regular_file();
  EXPECT_EQ(files, 0);
}

}  // namespace
}  // namespace parallax
