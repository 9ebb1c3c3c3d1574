// The trainers that a worker may run: those that its operator has installed and allowed. A worker
// never executes anything that comes with a job.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "common/base/status.h"
#include "worker/train/contract/contract.h"

namespace parallax {

// A trainer that this worker may run.
struct InstalledTrainer {
  TrainerContract contract;
  std::string repository;  // Folder of its own code; empty if none exists.
};

// Immutable.
class InstalledTrainers {
 public:
  // Loads the `allowed` trainers. `dir` has a file "<name>.yaml" for each trainer and, where
  // needed, a folder or link "<name>" with the trainer's own code. "builtin" is known without a
  // file. `dir` may be empty. Errors: kNotFound for an allowed trainer without a file, or whose
  // commands name a file of {repository} that is not there; kInvalidArgument for a file that names
  // another trainer; as ReadTrainerContract.
  static absl::StatusOr<InstalledTrainers> Load(const std::vector<std::string>& allowed,
                                                const std::string& dir);

  // Returns a trainer. Errors: kUnimplemented if it is not allowed, naming those that are.
  absl::StatusOr<InstalledTrainer> Find(const std::string& name) const;
  std::vector<std::string> Names() const;

 private:
  std::map<std::string, InstalledTrainer> trainers_;
};

// Checks that our own program `trainer` is there, if it trains or predicts for this trainer.
// Errors: those of FindProgram.
absl::Status CheckOwnProgram(const TrainerContract& contract);

// Returns the command as it is run: every {name} is replaced by its value, and a first word
// "trainer" by the path of our own program, $PARALLAX_TRAINER or the one beside this program.
// Errors: as ExpandCommand; kNotFound if that program isn't there.
absl::StatusOr<std::vector<std::string>> CommandToRun(const std::vector<std::string>& command,
                                                      const CommandValues& values);

}  // namespace parallax
