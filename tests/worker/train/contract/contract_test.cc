#include "worker/train/contract/contract.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <thread>

#include "common/base/system/child_process.h"
#include "common/base/system/file.h"
#include "worker/train/contract/installed_trainers.h"

namespace parallax {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

constexpr const char* kGood = R"(trainer: mine
layout: kitti
train: [./train, "--data={data}:{weight}", --out, "{out}/x", "{seed}"]
resume: [--from, "{resume}"]
progress: {pattern: 'step (\d+) loss ([0-9.]+)', groups: [step, loss]}
leaves: {checkpoints: "*.ckpt", final: last.ckpt}
predict: [./predict, "{checkpoint}", "{list}"]
needs: {gpus: 2}
size: [--size, "{width},{height}"]
batch: ["-b{batch}"]
start: [--init, "{start}"]
looks: ["--looks={looks}"]
environment: [A=1]
steps_per_minute: 2.5
exits: {not_finite: 9}
)";

TEST(TrainerContract, ShippedTrainersAreGood) {
  for (const char* name : {"builtin", "openstereo", "raft-stereo"}) {
    const auto contract = ReadTrainerContract(std::string(TRAINER_CONFIGS) + "/" + name + ".yaml");
    ASSERT_TRUE(contract.ok()) << contract.status();
    EXPECT_EQ(contract->name, name);
    EXPECT_GT(contract->default_steps, 0);
    // Nothing is needed that the authors' repositories do not have.
    for (const std::string& argument : contract->predict) {
      EXPECT_EQ(argument.find("{repository}/"), std::string::npos) << argument;
    }
  }
}

TEST(TrainerContract, FilesThatCommandsNameInTheRepositoryMustBeThere) {
  const std::string dir = testing::TempDir() + "repository_" + std::to_string(getpid());
  std::filesystem::create_directories(dir + "/mine");
  std::string text = kGood;
  text.replace(text.find("./predict"), 9, "'{repository}/tools/predict.py'");
  std::ofstream(dir + "/mine.yaml") << text;
  const auto missing = InstalledTrainers::Load({"mine"}, dir);
  EXPECT_EQ(missing.status().code(), absl::StatusCode::kNotFound);
  EXPECT_THAT(std::string(missing.status().message()),
              HasSubstr("/mine/tools/predict.py is missing"));
  std::filesystem::create_directories(dir + "/mine/tools");
  std::ofstream(dir + "/mine/tools/predict.py") << "\n";
  EXPECT_TRUE(InstalledTrainers::Load({"mine"}, dir).ok());
  std::filesystem::remove_all(dir);
}

TEST(TrainerContract, ReadsFieldsAndExpandsCommands) {
  const auto contract = ParseTrainerContract(kGood, "mine.yaml");
  ASSERT_TRUE(contract.ok()) << contract.status();
  EXPECT_EQ(contract->gpus, 2);
  EXPECT_EQ(contract->steps_per_minute, 2.5);
  EXPECT_EQ(contract->exits.at("not_finite"), 9);
  EXPECT_THAT(contract->environment, ElementsAre("A=1"));
  EXPECT_THAT(*ExpandCommand(contract->start, {{{"start", "/n.pt"}}, {}}),
              ElementsAre("--init", "/n.pt"));
  EXPECT_THAT(*ExpandCommand(contract->looks, {{{"looks", "1"}}, {}}), ElementsAre("--looks=1"));
  EXPECT_THAT(*ExpandCommand(contract->size, {{{"width", "64"}, {"height", "32"}}, {}}),
              ElementsAre("--size", "64,32"));
  CommandValues values{{{"out", "/o"}, {"seed", "7"}}, {{"/d1", "0.5"}, {"/d {seed}", "2"}}};
  const auto command = ExpandCommand(contract->train, values);
  ASSERT_TRUE(command.ok()) << command.status();
  // A value that looks like a placeholder stays as it is.
  EXPECT_THAT(*command,
              ElementsAre("./train", "--data=/d1:0.5", "--data=/d {seed}:2", "--out", "/o/x", "7"));
  EXPECT_TRUE(absl::IsInvalidArgument(ExpandCommand(contract->resume, values).status()));
}

TEST(TrainerContract, ReadsProgressOfBothFormats) {
  auto contract = ParseTrainerContract(kGood, "mine.yaml");
  ASSERT_TRUE(contract.ok());
  const auto seen = ReadProgress(*contract, "info: step 120 loss 0.5 of many");
  ASSERT_TRUE(seen.has_value());
  EXPECT_EQ(seen->step, 120);
  EXPECT_EQ(seen->loss, 0.5);
  EXPECT_FALSE(seen->eta_s.has_value());
  EXPECT_FALSE(ReadProgress(*contract, "step x").has_value());

  contract->progress = ProgressFormat::kJsonLines;
  const auto json =
      ReadProgress(*contract, R"({"step":3,"steps":9,"loss":1.5,"epe_px":2.5,"eta_s":60})");
  ASSERT_TRUE(json.has_value());
  EXPECT_EQ(json->step, 3);
  EXPECT_EQ(json->epe_px, 2.5);
  EXPECT_EQ(json->eta_s, 60);
  EXPECT_FALSE(ReadProgress(*contract, R"({"event":"done"})").has_value());
  // Python's json writes a loss that is not a number like this.
  EXPECT_TRUE(std::isnan(*ReadProgress(*contract, R"({"step": 3, "loss": NaN})")->loss));
  EXPECT_TRUE(std::isnan(*ReadProgress(*contract, R"({"step": 3, "loss": -Infinity})")->loss));
  EXPECT_FALSE(ReadProgress(*contract, "warning: {").has_value());

  const auto open = ReadTrainerContract(std::string(TRAINER_CONFIGS) + "/openstereo.yaml");
  ASSERT_TRUE(open.ok()) << open.status();
  const auto epochs = ReadProgress(
      *open, "INFO  Training Epoch: 2/90 Iter:  10/100 Loss:1.25000(1.3) LR:1.0e-03 DataTime:0.01");
  ASSERT_TRUE(epochs.has_value());
  EXPECT_EQ(epochs->step, 210);
  EXPECT_EQ(epochs->loss, 1.25);

  const auto raft = ReadTrainerContract(std::string(TRAINER_CONFIGS) + "/raft-stereo.yaml");
  const auto line = ReadProgress(*raft,
                                 "2026-01-01 INFO Training Metrics (299): [   300,  0.0001042]     "
                                 "0.6523,     0.8210,     0.9020,     3.1201, ");
  ASSERT_TRUE(line.has_value());
  EXPECT_EQ(line->step, 299);
  EXPECT_EQ(line->epe_px, 3.1201);
}

// The pattern's ".*" would recurse for each character.
TEST(TrainerContract, ALineOfManyCharactersDoesNotExhaustTheStack) {
  std::string text = kGood;
  const std::string pattern = R"(step (\d+) loss ([0-9.]+))";
  text.replace(text.find(pattern), pattern.size(), R"(step (\d+).*loss ([0-9.]+))");
  const auto contract = ParseTrainerContract(text, "mine.yaml");
  ASSERT_TRUE(contract.ok()) << contract.status();
  const std::string many(60'000, 'x');
  EXPECT_FALSE(ReadProgress(*contract, "step 7 " + many + " loss 0.5").has_value());
  const auto seen = ReadProgress(*contract, "step 7 of 9, loss 0.5 " + many);
  ASSERT_TRUE(seen.has_value());
  EXPECT_EQ(seen->step, 7);
  EXPECT_EQ(seen->loss, 0.5);
}

// Runs the shipped trainer with a script that seeds itself as RAFT-Stereo's does, and with
// stand-ins for its libraries. Returns what the script says.
std::string RaftSays(const std::string& dir, const std::string& seed) {
  const auto contract = ReadTrainerContract(std::string(TRAINER_CONFIGS) + "/raft-stereo.yaml");
  if (!contract.ok()) return contract.status().ToString();
  const auto command =
      ExpandCommand(contract->train, {{{"repository", dir}, {"seed", seed}, {"steps", "9"}}, {}});
  if (!command.ok()) return command.status().ToString();
  const auto child = ChildProcess::Start({.command = *command,
                                          .directory = dir,
                                          .log = dir + "/log.txt",
                                          .environment = {"PYTHONPATH=" + dir + "/libraries"}});
  while (child.ok() && !(*child)->Poll()) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  return ReadFile(dir + "/log.txt").value_or("no log");
}

TEST(TrainerContract, RaftStereoIsSeededThoughItsScriptSeedsItself) {
  const std::string dir = testing::TempDir() + "raft_" + std::to_string(getpid());
  std::filesystem::create_directories(dir + "/libraries");
  std::ofstream(dir + "/libraries/torch.py") << "def manual_seed(n): print('torch', n)\n";
  std::ofstream(dir + "/libraries/numpy.py")
      << "class random:\n  @staticmethod\n  def seed(n): print('numpy', n)\n";
  std::ofstream(dir + "/beside.py") << "\n";
  std::ofstream(dir + "/train_stereo.py")
      << "import sys, numpy, torch, beside\nif __name__ == '__main__':\n"
         "  print('script', sys.argv[1:3])\n  torch.manual_seed(1234)\n"
         "  numpy.random.seed(1234)\n  numpy.random.seed([5])\n";
  EXPECT_THAT(RaftSays(dir, "0"), HasSubstr("script ['--name', 'parallax']\ntorch 1234\n"
                                            "numpy 1234\nnumpy [5]\n"))
      << "the authors' own seed";
  EXPECT_THAT(RaftSays(dir, "2"), HasSubstr("script ['--name', 'parallax']\ntorch 2001240\n"
                                            "numpy 2001240\nnumpy [5]\n"));
  std::filesystem::remove_all(dir);
}

TEST(TrainerContract, NetworksInExchangeFormatsAreRunByTheProgramTrainer) {
  const auto command = [](const std::string& predict) {
    std::string text = kGood;
    const std::string own = "[./predict, \"{checkpoint}\", \"{list}\"]";
    text.replace(text.find(own), own.size(), predict);
    const auto contract = ParseTrainerContract(text, "mine.yaml");
    EXPECT_TRUE(contract.ok()) << contract.status();
    return contract.ok() ? contract->predict : std::vector<std::string>();
  };
  EXPECT_THAT(command("torchscript"),
              ElementsAre("trainer", "predict", "--format=torchscript", "--checkpoint",
                          "{checkpoint}", "--list", "{list}", "--threads", "{threads}"));
  EXPECT_THAT(command("{format: onnx, pixel_range: 1, mean: [0.5, 0.25, 0], std: [1, 2, 0.125], "
                      "channels: bgr, pad_multiple: 64, width_px: 640, height_px: 384, output: -2, "
                      "negate: true}"),
              ElementsAre("trainer", "predict", "--format=onnx", "--checkpoint", "{checkpoint}",
                          "--list", "{list}", "--threads", "{threads}", "--pixel-range=1",
                          "--mean=0.5,0.25,0", "--std=1,2,0.125", "--channels=bgr",
                          "--pad-multiple=64", "--output=-2", "--negate=true", "--size=384x640"));
}

TEST(TrainerContract, ErrorsNameFileLineAndWhatIsAllowed) {
  struct Case {
    const char* from;  // Text of kGood
    const char* to;    // and what stands there instead.
    const char* says;
  };
  const Case cases[] = {
      {"trainer: mine\n", "", "m.yaml:1: \"trainer\" is missing"},
      {"layout: kitti", "layout: kitty", "m.yaml:2: unknown layout \"kitty\" (there are archive, "},
      {"{seed}", "{sead}", "m.yaml:3: unknown placeholder {sead}"},
      {", \"{seed}\"", "", "m.yaml:3: \"train\" must name {seed}"},
      {"layout: kitti", "layout: kitti\ndirectory: \"{data}\"",
       "m.yaml:3: unknown placeholder {data} (there are out, repository)"},
      {"resume: [--from, \"{resume}\"]", "resume: --from", "m.yaml:4: \"resume\" must be a list"},
      {"groups: [step, loss]", "groups: [step]", "the pattern has 2 groups, but 1 are named"},
      {"groups: [step, loss]", "groups: [step, los]", "unknown group \"los\""},
      {"'step (\\d+) loss", "'step (\\d+ loss", "not a regular expression"},
      {"\"*.ckpt\"", "a.ckpt", "must have one *"},
      {", final: last.ckpt", "", "\"final\" is missing"},
      {"predict: [./predict, \"{checkpoint}\", \"{list}\"]", "predict: tensorrt",
       "m.yaml:7: \"predict\" is \"tensorrt\", but must be torchscript, onnx, a map"},
      {"predict: [./predict, \"{checkpoint}\", \"{list}\"]",
       "predict: {width_px: 64, height_px: 32}", "m.yaml:7: \"format\" is missing"},
      {"predict: [./predict, \"{checkpoint}\", \"{list}\"]",
       "predict: {format: onnx, mean: [1, 2]}", "m.yaml:7: \"mean\" must be three numbers"},
      {"predict: [./predict, \"{checkpoint}\", \"{list}\"]",
       "predict: {format: onnx, std: [1, 2, 0]}", "\"std\" must be three numbers above 0"},
      {"predict: [./predict, \"{checkpoint}\", \"{list}\"]",
       "predict: {format: onnx, pixel_range: 0}", "\"pixel_range\" must be a number above 0"},
      {"predict: [./predict, \"{checkpoint}\", \"{list}\"]",
       "predict: {format: onnx, channels: rbg}", "\"channels\" must be rgb or bgr"},
      {"predict: [./predict, \"{checkpoint}\", \"{list}\"]",
       "predict: {format: onnx, width_px: 64}", "\"width_px\" and \"height_px\" go together"},
      {"predict: [./predict, \"{checkpoint}\", \"{list}\"]",
       "predict: {format: onnx, output: last}", "\"output\" must be the number of an output"},
      {"predict: [./predict, \"{checkpoint}\", \"{list}\"]", "predict: {format: onnx, scale: 2}",
       "unknown field \"scale\" in predict (there are format, "},
      {"gpus: 2", "gpus: -1", "m.yaml:8: \"gpus\" must be a whole number"},
      {"gpus: 2", "gpu: 2", "m.yaml:8: unknown field \"gpu\" in needs"},
      {"gpus: 2", "tags: [a]", "m.yaml:8: \"tags\" has no effect here"},
      {"gpus: 2", "memory_mb: 2000", "write train.needs.memory_mb in the study"},
      {"predict: [./predict, \"{checkpoint}\", \"{list}\"]\n", "", "\"predict\" is missing"},
      {"layout: kitti", "layout: [", "not YAML"},
  };
  for (const Case& c : cases) {
    std::string text = kGood;
    text.replace(text.find(c.from), std::string(c.from).size(), c.to);
    const absl::Status status = ParseTrainerContract(text, "m.yaml").status();
    EXPECT_TRUE(absl::IsInvalidArgument(status)) << c.says;
    EXPECT_THAT(std::string(status.message()), HasSubstr(c.says));
  }
}

}  // namespace
}  // namespace parallax
