// Checkpoints of a running training in the store, so that another attempt, on whatever machine,
// goes on from the newest one that is whole.
//
//   <attempt's folder>/resume/<step, 9 digits>/<checkpoint>
//                                              curve.csv    what the training has told so far
//                                              facts.json   written last: size, hash, step
//
// Not thread-safe.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/base/cancel.h"
#include "common/base/status.h"
#include "common/store/store.h"

namespace parallax {

struct CheckpointFacts {
  int64_t step = 0;
  std::string name;  // As the trainer called the file, without folders.
  int64_t size = 0;
  std::string sha256;      // Lower-case hex.
  bool for_curve = false;  // Kept to the end, for learning curves.
  double train_s = 0;      // Seconds of training up to it, over all attempts.
};

// A checkpoint that an attempt has left in the store.
struct LeftCheckpoint {
  CheckpointFacts facts;
  std::string folder;  // In the store.
};

// Checkpoints below `resume_folder` whose facts can be read, by step, then in order of folders.
// Errors: as Store::List.
absl::StatusOr<std::vector<LeftCheckpoint>> ListCheckpoints(const Store& store,
                                                            const std::string& resume_folder);

// Brings a checkpoint to `path`, and what stands beside it in curve.csv to `curve` (if not null).
// Errors: kDataLoss if it isn't what its facts say; those of the store and of writing.
absl::Status FetchCheckpoint(const Store& store, const LeftCheckpoint& left,
                             const std::string& path, std::string* curve);

class CheckpointKeeper {
 public:
  // `attempt_path` is the attempt's folder in `store`, which outlives the keeper.
  CheckpointKeeper(Store& store, std::string attempt_path)
      : store_(store), attempt_path_(std::move(attempt_path)) {}

  // Durable when it returns. Removes older ones but for the last and those for the curve. Errors:
  // those of Store::PutFile.
  absl::Status Put(const CheckpointFacts& facts, const std::string& path, const std::string& curve);
  // Removes all of them. Best effort.
  void RemoveAll();

  // By step.
  const std::vector<CheckpointFacts>& kept() const { return kept_; }

 private:
  std::string FolderOf(int64_t step) const;

  Store& store_;
  const std::string attempt_path_;
  std::vector<CheckpointFacts> kept_;
};

}  // namespace parallax
