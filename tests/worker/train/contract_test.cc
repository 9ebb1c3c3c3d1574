#include "worker/train/contract.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

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
predict: onnx
needs: {gpus: 2, tags: [a, b]}
size: [--size, "{width},{height}"]
batch: ["-b{batch}"]
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
  }
}

TEST(TrainerContract, ReadsFieldsAndExpandsCommands) {
  const auto contract = ParseTrainerContract(kGood, "mine.yaml");
  ASSERT_TRUE(contract.ok()) << contract.status();
  EXPECT_EQ(contract->predictor, PredictorKind::kOnnx);
  EXPECT_EQ(contract->gpus, 2);
  EXPECT_THAT(contract->tags, ElementsAre("a", "b"));
  EXPECT_EQ(contract->steps_per_minute, 2.5);
  EXPECT_EQ(contract->exits.at("not_finite"), 9);
  EXPECT_THAT(contract->environment, ElementsAre("A=1"));
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
      {"resume: [--from, \"{resume}\"]", "resume: --from", "m.yaml:4: \"resume\" must be a list"},
      {"groups: [step, loss]", "groups: [step]", "the pattern has 2 groups, but 1 are named"},
      {"groups: [step, loss]", "groups: [step, los]", "unknown group \"los\""},
      {"'step (\\d+) loss", "'step (\\d+ loss", "not a regular expression"},
      {"\"*.ckpt\"", "a.ckpt", "must have one *"},
      {", final: last.ckpt", "", "\"final\" is missing"},
      {"predict: onnx", "predict: magic", "\"predict\" is \"magic\""},
      {"gpus: 2", "gpus: -1", "m.yaml:8: \"gpus\" must be a whole number"},
      {"gpus: 2", "gpu: 2", "m.yaml:8: unknown field \"gpu\" in needs"},
      {"predict: onnx\n", "", "\"predict\" is missing"},
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
