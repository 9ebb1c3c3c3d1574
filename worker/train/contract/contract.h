// Trainers as YAML files: how a worker runs a training program, ours or someone else's, reads its
// progress, finds what it leaves, and lets it predict. configs/trainers/ has examples.
//
// Commands are lists of arguments, never lines for a shell. An argument may hold placeholders:
//   {data}        folder of one part of the training data, in the layout that the trainer names
//   {weight}      share of that part; an argument with {data} is repeated for each part
//   {out}         folder for what the trainer leaves, also its working folder unless `directory`
//                 says otherwise
//   {seed} {steps} {threads} {device} {checkpoint_every}
//                 `train` must name {seed}, or all trainings of a study would be one;
//                 `device` is "cuda" for a trainer that needs a GPU, else "cpu";
//                 `checkpoint_every` divides the steps at which checkpoints are kept
//   {resume}      the checkpoint to go on from (`resume` only)
//   {width} {height} {batch}   (`size` and `batch` only, which are appended if the study sets them)
//   {start}       a checkpoint of the built-in trainer whose weights the training begins with
//                 (`start` only, which is appended if the study says `start: network`)
//   {checkpoint} {list}        of `predict`: the trained checkpoint; lines "left right output.pfm",
//                 split at blanks: none of these paths has one, wherever the worker's folders lie
//   {looks}       how often the network looks at a pair (`looks` only, which is appended to
//                 `predict` if the study wants fewer than it takes by itself)
//   {repository}  the folder of the trainer's own code on the worker; see installed_trainers.h
//
// `predict` is a command, or the format of the final checkpoint, torchscript or onnx, if that is a
// network that the program `trainer` can run itself; then it may be a map with `format`,
// pixel_range, mean, std, channels (rgb, bgr), pad_multiple, width_px and height_px, output,
// negate: what they mean stands in exchange_network.h (NetworkConventions).
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <regex>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/status.h"

namespace parallax {

enum class ProgressFormat { kJsonLines, kPattern };

// The content of one trainer's file.
struct TrainerContract {
  std::string name;
  std::string layout;  // "archive", or a layout of `parallax export`.
  // Where `train` and `predict` run; may hold {out} and {repository}. Empty: {out}.
  std::string directory;
  // "path=target" made in {out} before the start; placeholders as above.
  std::vector<std::string> links;
  std::vector<std::string> train;   // The command.
  std::vector<std::string> resume;  // Appended when there is a checkpoint; empty: it cannot resume.
  std::vector<std::string> size;    // Appended when the study names the size of crops.
  std::vector<std::string> batch;   // Appended when the study names the number of crops in a step.
  std::vector<std::string> start;   // Appended when the study starts from a trained network.
  std::vector<std::string> environment;  // "NAME=value" for its commands.
  int64_t default_steps = 0;             // 0: the study must say.
  // Steps that one of a study's `minutes` stands for, on any machine. 0: studies must name steps.
  double steps_per_minute = 0;
  ProgressFormat progress = ProgressFormat::kJsonLines;
  std::shared_ptr<const std::regex> progress_pattern;  // Its groups are those below. Null: JSON.
  // In order of the groups: "step", "loss", "epe_px", "eta_s". A trainer that counts its steps anew
  // in each epoch has "epoch" (from 0) and "epoch_steps" as well.
  std::vector<std::string> progress_groups;
  // Pattern of files in {out}, with one "*" for the step: "checkpoint-*.pt".
  std::string checkpoint_pattern;
  std::string final_checkpoint;  // In {out}.
  // Exit statuses of the trainer that say more than "failed": "not_finite", "out_of_memory", and
  // "usage" for settings or data that are as wrong at the next try.
  std::map<std::string, int> exits;
  std::vector<std::string> predict;  // The command that predicts the pairs of {list}.
  std::vector<std::string> looks;    // Appended to it when the study names the number of looks.
  // GPUs that it needs, for {device}. Which workers get its jobs says the study, by `needs`.
  int gpus = 0;
};

// Parse and read a trainer's file. Errors: kInvalidArgument with all errors of the file, one a
// line: "FILE:LINE: what is wrong"; those of ReadFile.
absl::StatusOr<TrainerContract> ParseTrainerContract(std::string_view yaml,
                                                     const std::string& file);
absl::StatusOr<TrainerContract> ReadTrainerContract(const std::string& path);

// Values for a command's placeholders.
struct CommandValues {
  std::map<std::string, std::string> values;              // By placeholder, without braces.
  std::vector<std::pair<std::string, std::string>> data;  // Folder and weight of each part.
};

// Returns the command with its placeholders replaced. Errors: kInvalidArgument for a placeholder
// without a value.
absl::StatusOr<std::vector<std::string>> ExpandCommand(const std::vector<std::string>& command,
                                                       const CommandValues& values);

// Progress in one line of a trainer's output.
struct TrainerProgress {
  std::optional<int64_t> step;
  std::optional<double> loss, epe_px, eta_s;
};

// Returns the progress in a line of the trainer's output; nothing if the line has none. A pattern
// sees the first 2,000 characters of the line.
std::optional<TrainerProgress> ReadProgress(const TrainerContract& contract,
                                            const std::string& line);

}  // namespace parallax
