// Keeps checkpoints of a running training in the store, so that another attempt, on any machine,
// continues from the newest complete one.
//
//   <attempt's folder>/resume/<step, 9 digits>/<checkpoint>
//                                              curve.csv    what the training has told so far
//                                              facts.json   written last: size, hash, step
//
// They stay until the coordinator has the training's result and removes them.
// Not thread-safe.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/base/cancel.h"
#include "common/base/status.h"
#include "common/store/store.h"

namespace parallax {

// The description of a checkpoint, stored beside it as facts.json.
struct CheckpointFacts {
  int64_t step = 0;
  std::string name;  // The trainer's file name, without folders.
  int64_t size = 0;
  std::string sha256;      // Lower-case hex.
  bool for_curve = false;  // Kept for learning curves.
  double train_s = 0;      // Seconds of training up to it, over all attempts.
};

// A checkpoint that an attempt has left in the store.
struct LeftCheckpoint {
  CheckpointFacts facts;
  std::string folder;  // In the store.
};

// Lists the checkpoints below `resume_folder` with readable facts, by step, then in order of
// folders. Errors: as Store::List.
absl::StatusOr<std::vector<LeftCheckpoint>> ListCheckpoints(const Store& store,
                                                            const std::string& resume_folder);

// Copies a checkpoint to `path`, and the text of the curve.csv beside it to `curve` (if not null).
// Errors: kDataLoss if its contents differ from its facts; those of the store and of writing.
absl::Status FetchCheckpoint(const Store& store, const LeftCheckpoint& left,
                             const std::string& path, std::string* curve);

// Stores the checkpoints of one attempt.
class CheckpointKeeper {
 public:
  // `attempt_path` is the attempt's folder in `store`, which outlives the keeper.
  CheckpointKeeper(Store& store, std::string attempt_path)
      : store_(store), attempt_path_(std::move(attempt_path)) {}

  // Stores a checkpoint durably, and removes older ones except the last and those for the curve.
  // Errors: those of Store::PutFile.
  absl::Status Put(const CheckpointFacts& facts, const std::string& path, const std::string& curve);
  // Leaves all stored checkpoints as they are, but counts them as older attempts' from now on, so
  // that others of the same steps may take their places.
  void Forget() { kept_.clear(); }

  // Returns the stored checkpoints, by step.
  const std::vector<CheckpointFacts>& kept() const { return kept_; }

 private:
  std::string FolderOf(int64_t step) const;

  Store& store_;
  const std::string attempt_path_;
  std::vector<CheckpointFacts> kept_;
};

}  // namespace parallax
