// Predictors of disparities: a classical method, a trained network's command, or existing files.
// All work through files, so that a network that crashes does not crash the caller.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "common/base/cancel.h"
#include "common/base/status.h"
#include "common/base/system/clock.h"

namespace parallax {

// One pair to predict. Paths are absolute.
struct PredictionTask {
  std::string name;         // Name of the pair.
  std::string left, right;  // Rectified pictures of one size, in any codec that we read.
  // A PFM to write: the left view's disparities in pixels of the left picture, same size, positive.
  // A value that is not finite says "no prediction" (and is counted as wrong).
  std::string output;
};

// Everything that a prediction needs besides its pairs.
struct PredictionContext {
  std::string work_dir;  // Exists; for lists and logs.
  CancelToken cancel;
  Clock* clock = &Clock::System();
  std::function<void(int done)> progress = [](int) {};  // Pairs predicted so far.
};

// Predicts the disparities of pairs.
class Predictor {
 public:
  virtual ~Predictor() = default;
  virtual std::string name() const = 0;
  // Writes each task's output. Errors: kCancelled; others as the predictor says, naming the pair or
  // command.
  virtual absl::Status Predict(const std::vector<PredictionTask>& tasks,
                               const PredictionContext& context) = 0;
};

// Makes OpenCV's semi-global block matching, with holes filled from their row: the classical
// baseline. Searches disparities up to a quarter of the image's width.
std::unique_ptr<Predictor> MakeSgbmPredictor();

// A command and its time limits.
struct CommandPredictorOptions {
  // Run by /bin/sh; "{list}" is replaced by the path of a text file with a line `left right output`
  // a pair; none of its paths has a blank, whatever the folders are called (links lead there). The
  // command writes each output as PFM and exits with 0.
  std::string command;
  double start_s = 300;        // It may take this long,
  double pair_s = 120;         // and this much longer for each pair; then it is killed.
  std::string name = "";       // Name of the predictor; the command if empty.
  std::string directory = "";  // Where it runs; empty: in our own working folder.
};
// Errors of Predict: kDeadlineExceeded, kAborted (killed by a signal) and kInternal (exit status)
// with the last lines of what the command said. Standard output and error go to
// `work_dir`/predictor.log.
std::unique_ptr<Predictor> MakeCommandPredictor(CommandPredictorOptions options);

// Reads files `dir`/<pair>.pfm, else .npy, .exr or .png (16 bits, x256, 0 = none). Errors of
// Predict: kNotFound naming the first pair without a file, and the number of such pairs;
// kInvalidArgument for a PNG of 8 bits.
std::unique_ptr<Predictor> MakeFolderPredictor(std::string dir);

// Makes a command for MakeCommandPredictor from words without shell syntax: each is quoted, except
// that a word "{list}" stays the placeholder.
std::string CommandOfWords(const std::vector<std::string>& words);

// Returns the command with which the built-in program `trainer` predicts from a checkpoint.
// `threads` and `looks` 0: its own choice.
std::string TrainerPredictCommand(const std::string& trainer_program, const std::string& checkpoint,
                                  int threads = 0, int looks = 0);

}  // namespace parallax
