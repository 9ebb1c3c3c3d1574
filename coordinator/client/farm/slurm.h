// Starts pilots by Slurm, through its programs sbatch, squeue and scancel, which are sought on
// $PATH.
#pragma once

#include <string>
#include <vector>

#include "common/base/status.h"
#include "coordinator/client/farm/farm_policy.h"

namespace parallax::client {

struct SlurmOptions {
  std::string job_name;                       // Name by which squeue finds this farm's pilots.
  std::string script;                         // deploy/slurm/workers.sbatch, or a copy of it.
  std::vector<std::string> sbatch_options;    // "--partition=short"
  std::vector<std::string> worker_arguments;  // Arguments of the script.
  std::vector<std::string> environment;       // "NAME=value", passed on by sbatch.
};

// Thread-safe. Errors of all methods: kUnavailable with the program's first line of output if it
// fails; kDeadlineExceeded if it does not end within a minute.
class Slurm {
 public:
  explicit Slurm(SlurmOptions options) : options_(std::move(options)) {}

  // Returns the user's pilots with this job name, in the order of submission.
  absl::StatusOr<std::vector<Pilot>> Pilots() const;
  // Submits an array of `pilots` pilots. Returns its job id.
  absl::StatusOr<std::string> Submit(int pilots) const;
  // Cancels pilots by their ids. Errors: those of all methods.
  absl::Status Cancel(const std::vector<std::string>& ids) const;
  // Returns the command line of Submit, for people.
  std::string SubmitCommand(int pilots) const;

 private:
  std::vector<std::string> SubmitWords(int pilots) const;
  const SlurmOptions options_;
};

// Parses lines "ID|STATE" of `squeue --array --noheader --format=%i|%T`. Errors: kInvalidArgument
// for any other line.
absl::StatusOr<std::vector<Pilot>> ParsePilots(const std::string& text);

}  // namespace parallax::client
