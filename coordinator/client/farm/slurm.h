// Slurm as the one that starts pilots: its programs sbatch, squeue and scancel, sought on $PATH.
#pragma once

#include <string>
#include <vector>

#include "common/base/status.h"
#include "coordinator/client/farm/policy.h"

namespace parallax::client {

struct SlurmOptions {
  std::string job_name;                       // By which squeue finds this farm's pilots again.
  std::string script;                         // deploy/slurm/workers.sbatch, or a copy of it.
  std::vector<std::string> sbatch_options;    // "--partition=short"
  std::vector<std::string> worker_arguments;  // After the script.
  std::vector<std::string> environment;       // "NAME=value", handed on by sbatch.
};

// Errors of all: kUnavailable with the first line that the program wrote, if it fails;
// kDeadlineExceeded if it does not end within a minute.   Thread-safe.
class Slurm {
 public:
  explicit Slurm(SlurmOptions options) : options_(std::move(options)) {}

  // The user's pilots of this name, in order of submission.
  absl::StatusOr<std::vector<Pilot>> Pilots() const;
  // Submits an array of so many pilots; its job id.
  absl::StatusOr<std::string> Submit(int pilots) const;
  absl::Status Cancel(const std::vector<std::string>& ids) const;
  // The command that Submit runs, as one line for people.
  std::string SubmitCommand(int pilots) const;

 private:
  std::vector<std::string> SubmitWords(int pilots) const;
  const SlurmOptions options_;
};

// Lines "ID|STATE" of `squeue --array --noheader --format=%i|%T`. Errors: kInvalidArgument for
// another line.
absl::StatusOr<std::vector<Pilot>> ParsePilots(const std::string& text);

}  // namespace parallax::client
