#include "worker/train/training.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <torch/csrc/jit/api/module.h>
#include <torch/csrc/jit/serialization/import.h>
#include <torch/types.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <filesystem>

#include "common/base/hash.h"
#include "common/base/system/file.h"
#include "tests/worker/dataset/synthetic_archive.h"
#include "worker/train/network/checkpoint.h"
#include "worker/train/network/checkpoint_export.h"
#include "worker/train/trained_predictor.h"

namespace parallax {
namespace {

using Json = nlohmann::ordered_json;

// One archive for the whole program: two scenes' pairs of 160x96 px.
const std::string& Archive() {
  static const std::string dir = [] {
    const std::string path = testing::TempDir() + "train_" + std::to_string(getpid()) + "_pairs";
    MakeSyntheticArchive(path, {.scenes = 2, .rigs = 2, .width_px = 160, .height_px = 96});
    return path;
  }();
  return dir;
}

std::string FreshDir(const std::string& name) {
  const std::string dir = testing::TempDir() + "train_" + std::to_string(getpid()) + "_" + name;
  std::filesystem::remove_all(dir);
  return dir;
}

TrainingJob TinyJob(const std::string& name, int64_t steps) {
  TrainingJob job;
  job.settings.steps = steps;
  job.settings.crop_height = 64;
  job.settings.crop_width = 128;
  job.settings.max_disparity = 64;
  job.out_dir = FreshDir(name);
  job.sources = {*ReadTrainingSource(Archive(), {})};
  return job;
}

std::string HashOf(const std::string& path) {
  const auto hash = Sha256HexOfFile(path);
  return hash.ok() ? *hash : hash.status().ToString();
}

// ---- The program

struct Outcome {
  int exit = -1;
  std::string out, err;
};

// Runs a shell command line to its end.
Outcome Shell(const std::string& line) {
  const std::string out = FreshDir("stdout"), err = FreshDir("stderr");
  const int status = std::system((line + " >" + out + " 2>" + err).c_str());
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, *ReadFile(out), *ReadFile(err)};
}

const std::string kSmall = "--crop 32x64 --threads 2 --checkpoint-every 3 ";

// Threads that wait in a loop for each other take the cores of other tests: trainers start as
// workers start them.
const int kPassive = setenv("OMP_WAIT_POLICY", "passive", 1);

std::string TrainLine(const std::string& dir, const std::string& more) {
  return std::string(TRAINER) + " train --data " + Archive() + " --out " + dir +
         " --seed 4 --progress-every 1 " + more;
}

// Starts the program, sends it `signal` as soon as a line of its output contains `sign`, and waits
// for its end. Its exit status, or minus the signal that killed it.
int SignalWhen(const std::string& line, const std::string& sign, int signal) {
  int ends[2];
  if (pipe(ends) != 0) return -1000;
  const pid_t child = fork();
  if (child == 0) {
    dup2(ends[1], STDOUT_FILENO);
    close(ends[0]);
    close(ends[1]);
    execl("/bin/sh", "sh", "-c", ("exec " + line).c_str(), nullptr);
    _exit(127);
  }
  close(ends[1]);
  std::FILE* lines = fdopen(ends[0], "r");
  char text[4096];
  bool seen = false;
  while (std::fgets(text, sizeof text, lines) != nullptr) {
    if (seen || std::string(text).find(sign) == std::string::npos) continue;
    seen = true;
    kill(child, signal);
  }
  int status = 0;
  waitpid(child, &status, 0);
  std::fclose(lines);
  EXPECT_TRUE(seen) << "the program ended before it said " << sign;
  return WIFSIGNALED(status) ? -WTERMSIG(status) : WEXITSTATUS(status);
}

TEST(Trainer, KilledAndResumedEndsInTheSameBytes) {
  const std::string calm = FreshDir("calm"), killed = FreshDir("killed");
  ASSERT_EQ(Shell(TrainLine(calm, kSmall + "--steps 9")).exit, 0);
  EXPECT_EQ(SignalWhen(TrainLine(killed, kSmall + "--steps 9"), "\"step\":5,", SIGKILL), -SIGKILL);
  ASSERT_FALSE(std::filesystem::exists(killed + "/final.pt"));
  const Outcome resumed =
      Shell(TrainLine(killed, kSmall + "--steps 9 --resume " + killed + "/checkpoint-000003.pt"));
  ASSERT_EQ(resumed.exit, 0) << resumed.err;
  EXPECT_EQ(resumed.out.find("\"step\":1,"), std::string::npos) << "began anew";
  EXPECT_EQ(HashOf(killed + "/final.pt"), HashOf(calm + "/final.pt"));
  EXPECT_EQ(HashOf(killed + "/checkpoint-000006.pt"), HashOf(calm + "/checkpoint-000006.pt"));
  EXPECT_NE(HashOf(calm + "/checkpoint-000006.pt"), HashOf(calm + "/final.pt"));

  const Outcome other = Shell(TrainLine(
      killed, kSmall + "--steps 9 --batch 1 --resume " + killed + "/checkpoint-000003.pt"));
  EXPECT_EQ(other.exit, 1);
  EXPECT_NE(other.err.find("it has batch: 2, but 1 is wanted"), std::string::npos) << other.err;
}

// Weights of another run, and nothing else of it.
TEST(Trainer, BeginsWithTheWeightsOfAnotherRunAndSaysWhich) {
  const std::string first = FreshDir("first"), warm = FreshDir("warm"), again = FreshDir("again");
  ASSERT_EQ(Shell(TrainLine(first, kSmall + "--steps 4")).exit, 0);
  const std::string start = " --start " + first + "/final.pt ";
  // No step changes them before the first.
  ASSERT_EQ(Shell(TrainLine(warm, kSmall + "--steps 1 --learning-rate 0" + start)).exit, 0);
  const StereoNetwork network;
  const auto trained = ReadCheckpoint(first + "/final.pt", network);
  const auto unchanged = ReadCheckpoint(warm + "/final.pt", network);
  ASSERT_TRUE(trained.ok() && unchanged.ok()) << trained.status() << unchanged.status();
  EXPECT_TRUE(torch::equal(unchanged->state.weights, trained->state.average));
  EXPECT_FALSE(torch::equal(trained->state.weights, trained->state.average));

  const auto card_of = [](const std::string& dir) {
    return Json::parse(*ReadFile(dir + "/train.json"));
  };
  EXPECT_EQ(card_of(warm)["start_sha256"], HashOf(first + "/final.pt"));
  EXPECT_TRUE(card_of(first)["start_sha256"].is_null());
  ASSERT_EQ(Shell(TrainLine(warm, kSmall + "--steps 6" + start)).exit, 0);
  EXPECT_EQ(card_of(warm)["settings"]["learning_rate"], kStartedLearningRate);
  EXPECT_EQ(card_of(first)["settings"]["learning_rate"], TrainSettings().learning_rate);

  // A resumed run has the same bytes; with other weights it is another run.
  const std::string resume = "--resume " + warm + "/checkpoint-000003.pt";
  ASSERT_EQ(Shell(TrainLine(again, kSmall + "--steps 6" + start + resume)).exit, 0);
  EXPECT_EQ(HashOf(again + "/final.pt"), HashOf(warm + "/final.pt"));
  const Outcome scratch =
      Shell(TrainLine(again, kSmall + "--steps 6 --learning-rate 3e-4 " + resume));
  EXPECT_EQ(scratch.exit, 1);
  EXPECT_NE(scratch.err.find("it has start: \"" + HashOf(first + "/final.pt") + "\", but null"),
            std::string::npos)
      << scratch.err;
  const Outcome none = Shell(TrainLine(again, kSmall + "--steps 6 --start /nowhere.pt"));
  EXPECT_EQ(none.exit, 1);
  EXPECT_NE(none.err.find("/nowhere.pt"), std::string::npos) << none.err;
}

TEST(Trainer, ExportedWeightsPredictAndStartRunsButDoNotResumeThem) {
  const std::string whole = FreshDir("whole"), weights = whole + "/weights.pt";
  ASSERT_EQ(Shell(TrainLine(whole, kSmall + "--steps 3")).exit, 0);
  const std::string program = TRAINER, of_it = " --checkpoint " + whole + "/final.pt ";
  const Outcome exported = Shell(program + " export" + of_it + "--weights " + weights);
  ASSERT_EQ(exported.exit, 0) << exported.err;
  EXPECT_LT(3 * std::filesystem::file_size(weights),
            std::filesystem::file_size(whole + "/final.pt"));
  const StereoNetwork network;
  const auto all = ReadCheckpoint(whole + "/final.pt", network);
  const auto some = ReadCheckpoint(weights, network);
  ASSERT_TRUE(all.ok() && some.ok()) << all.status() << some.status();
  EXPECT_TRUE(torch::equal(all->state.average, some->state.average));
  EXPECT_EQ(all->settings, some->settings);
  EXPECT_TRUE(Predictor::Load(weights).ok());
  const std::string next = FreshDir("next");
  EXPECT_EQ(Shell(TrainLine(next, kSmall + "--steps 3 --start " + weights)).exit, 0);
  const Outcome resumed = Shell(TrainLine(next, kSmall + "--steps 3 --resume " + weights));
  EXPECT_EQ(resumed.exit, 1);
  EXPECT_NE(resumed.err.find("has only weights"), std::string::npos) << resumed.err;
  EXPECT_EQ(Shell(program + " export" + of_it).exit, 2) << "neither a module nor weights";
  EXPECT_EQ(Shell(program + " export" + of_it + "--torchscript x").exit, 2) << "without a size";
}

TEST(Trainer, StopsOnSigtermWithACheckpoint) {
  const std::string dir = FreshDir("stopped"), err = dir + ".stderr";
  const std::string line =
      TrainLine(dir, "--crop 32x64 --steps 100000 --checkpoint-every 100000 2>" + err);
  EXPECT_EQ(SignalWhen(line, "\"step\":3,", SIGTERM), static_cast<int>(TrainerExit::kStopped));
  EXPECT_EQ(ReadFile(err)->find("trainer: stopped at step "), 0u) << *ReadFile(err);
  EXPECT_GE(std::distance(std::filesystem::directory_iterator(dir), {}), 2)
      << "no checkpoint beside train.json";
}

TEST(Trainer, ErrorsAreOneLineAndHaveTheirOwnExitStatus) {
  struct Case {
    std::string line;
    int exit;
    const char* says;
  };
  const std::string dir = FreshDir("errors"), trainer = TRAINER;
  ASSERT_TRUE(WriteFile(dir + ".txt", "not a checkpoint").ok());
  const Case cases[] = {
      {trainer + " train --out " + dir + " --data /nowhere", 1, "/nowhere: no such folder"},
      {TrainLine(dir, "--crop 64x100"), 2, "crop width is 100, but must be a multiple of 32"},
      {TrainLine(dir, "--crop 64"), 2, "--crop is \"64\""},
      {TrainLine(dir, "--crop 96x192"), 2,
       "a pair of 160x96 px is smaller than the crop of 192x96"},
      {TrainLine(dir, "--steps 5 --learning-rate 2"), 2, "learning rate is 2.0"},
      {TrainLine(dir, kSmall + "--resume " + dir + ".txt"), 1, "not a checkpoint of this trainer"},
      {TrainLine(dir, kSmall + "--resume /nowhere.pt"), 1, "/nowhere.pt"},
      {trainer + " predict --checkpoint " + dir + ".txt --list x", 1, "not a checkpoint"},
      {trainer + " predict --checkpoint x", 2, "give --list, or"},
      {"ulimit -v 3000000; " + TrainLine(dir, "--crop 96x160 --batch 200 --steps 1 --threads 1"), 4,
       "out of memory"},
  };
  for (const Case& c : cases) {
    const Outcome outcome = Shell(c.line);
    EXPECT_EQ(outcome.exit, c.exit) << c.line << "\n" << outcome.err;
    EXPECT_NE(outcome.err.find(c.says), std::string::npos) << c.line << "\n" << outcome.err;
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
  }
}

// ---- Learning

TEST(Training, LossThatIsNotFiniteEndsTheRun) {
  TrainingJob job = TinyJob("nan", 20);
  job.settings.learning_rate = 1;
  job.settings.gradient_clip = 1e30;
  job.settings.weight_decay = 1e30;
  const TrainingEnd end = RunTraining(job, false, [](const Json&) {});
  EXPECT_EQ(end.exit, TrainerExit::kNotFinite) << end.message;
  EXPECT_NE(end.message.find("not finite at step "), std::string::npos) << end.message;
  EXPECT_FALSE(std::filesystem::exists(job.out_dir + "/final.pt"));
}

// Writes a checkpoint of a network whose first `count` weights are `value`, and loads it.
absl::StatusOr<Predictor> LoadWith(const std::string& dir, int64_t count, float value) {
  StereoNetwork network;
  InitialiseWeights(network, 1);
  const Optimiser optimiser(network);
  OptimiserState state = optimiser.state();
  state.average = state.average.clone();
  state.average.slice(0, 0, count).fill_(value);
  std::filesystem::create_directories(dir);
  const std::string path = dir + "/final.pt";
  const Json settings = {{"max_disparity", 64}};
  RETURN_IF_ERROR(WriteCheckpoint(path, network, {1, settings, state}));
  return Predictor::Load(path);
}

TEST(Predictor, WeightsAndDisparitiesThatAreNotFiniteAreErrorsAndNotZero) {
  const std::string dir = FreshDir("diverged");
  const ImageRgb8 picture(64, 32, 200);
  const auto good = LoadWith(dir, 1, 0.5f);
  ASSERT_TRUE(good.ok()) << good.status();
  EXPECT_TRUE(good->Predict(picture, picture, {}).ok());
  for (const float value : {std::nanf(""), HUGE_VALF}) {
    const absl::Status status = LoadWith(dir, 1, value).status();
    EXPECT_TRUE(absl::IsDataLoss(status)) << status;
    EXPECT_NE(status.message().find("final.pt: weight "), absl::string_view::npos) << status;
  }
  const auto large = LoadWith(dir, 1000, 3e38f);  // Their sums are infinite.
  ASSERT_TRUE(large.ok()) << large.status();
  const absl::Status status = large->Predict(picture, picture, {}).status();
  EXPECT_TRUE(absl::IsInternal(status)) << status;
}

TEST(Training, OverfitsAFewPairsAndPredictsThem) {
  TrainingJob job = TinyJob("overfit", 150);
  job.settings.learning_rate = 3e-3;
  job.settings.augment = {.scale_low = 0,
                          .scale_high = 0,
                          .stretch = 0,
                          .flip_probability = 0,
                          .colour_probability = 0,
                          .erase_probability = 0,
                          .y_jitter_probability = 0,
                          .noise_probability = 0,
                          .blur_probability = 0};
  job.heldout = job.sources;
  double epe_px = 0;
  Json done;
  const TrainingEnd end = RunTraining(job, false, [&](const Json& line) {
    if (line.contains("epe_px")) epe_px = line["epe_px"];
    if (line.value("event", "") == "done") done = line;
  });
  ASSERT_EQ(end.exit, TrainerExit::kDone) << end.message;
  EXPECT_LT(epe_px, 0.5);
  EXPECT_LT(done["heldout"]["epe_px"].get<double>(), 0.5) << done;

  // Card: what repeats the run.
  const Json card = Json::parse(*ReadFile(job.out_dir + "/train.json"));
  EXPECT_EQ(card["data"][0]["sha256"], job.sources[0].data_hash);
  EXPECT_EQ(card["settings"]["threads"], 2);
  EXPECT_EQ(card["result"]["steps"], 150);

  // Any size, deterministic, finite.
  const auto predictor = Predictor::Load(job.out_dir + "/final.pt");
  ASSERT_TRUE(predictor.ok()) << predictor.status();
  for (const auto& [width, height] : {std::pair(160, 96), {33, 7}, {97, 65}}) {
    ImageRgb8 left(width, height, 90), right(width, height, 90);
    const auto once = predictor->Predict(left, right, {}),
               again = predictor->Predict(left, right, {});
    ASSERT_TRUE(once.ok()) << once.status();
    EXPECT_EQ(once->width(), width);
    EXPECT_EQ(once->height(), height);
    EXPECT_EQ(*once, *again);
    for (const float value : once->values()) ASSERT_TRUE(std::isfinite(value) && value >= 0);
  }
  EXPECT_TRUE(
      absl::IsInvalidArgument(predictor->Predict(ImageRgb8(8, 8), ImageRgb8(9, 8), {}).status()));

  // The same weights look twice at a small pair if they were trained at several scales.
  StereoNetwork network;
  absl::StatusOr<Checkpoint> checkpoint = ReadCheckpoint(job.out_dir + "/final.pt", network);
  ASSERT_TRUE(checkpoint.ok()) << checkpoint.status();
  checkpoint->settings["scale_high"] = 0.4;
  const std::string scaled = job.out_dir + "/scaled.pt";
  ASSERT_TRUE(WriteCheckpoint(scaled, network, *checkpoint).ok());
  const absl::StatusOr<TrainingPair> pair = ReadTrainingPair(job.sources[0].frames[0].dir);
  ASSERT_TRUE(pair.ok()) << pair.status();
  EXPECT_NE(*predictor->Predict(pair->left.image, pair->right.image, {}),
            *Predictor::Load(scaled)->Predict(pair->left.image, pair->right.image, {}));
  EXPECT_EQ(*predictor->Predict(pair->left.image, pair->right.image, {}),
            *Predictor::Load(scaled)->Predict(pair->left.image, pair->right.image, {.looks = 1}));
}

}  // namespace
}  // namespace parallax
