// The trainers that this worker may run, which its operator installed and allowed. Nothing that
// comes with a job is ever executed.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "common/base/status.h"
#include "worker/train/contract.h"

namespace parallax {

// A trainer that this worker may run.
struct InstalledTrainer {
  TrainerContract contract;
  std::string repository;  // Folder of its own code; empty if there is none.
};

// Immutable.
class InstalledTrainers {
 public:
  // `dir` has a file for each trainer, "<name>.yaml", and beside it, where it is needed, a folder
  // or link "<name>" to the trainer's own code. "builtin" is known without a file. `dir` may be
  // empty. Errors: kNotFound for an allowed trainer without a file; kInvalidArgument for a file
  // that names another trainer; as ReadTrainerContract.
  static absl::StatusOr<InstalledTrainers> Load(const std::vector<std::string>& allowed,
                                                const std::string& dir);

  // Errors: kUnimplemented naming those that are allowed.
  absl::StatusOr<InstalledTrainer> Find(const std::string& name) const;
  std::vector<std::string> Names() const;

 private:
  std::map<std::string, InstalledTrainer> trainers_;
};

// The command as it is run: every {name} has its value, and a first word "trainer" is the path of
// our own program, $PARALLAX_TRAINER or the one beside this program.
// Errors: as ExpandCommand; kNotFound if that program isn't there.
absl::StatusOr<std::vector<std::string>> CommandToRun(const std::vector<std::string>& command,
                                                      const CommandValues& values);

}  // namespace parallax
