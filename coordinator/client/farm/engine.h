// Starts pilots by a batch system, through the programs that its file (engine.proto) names.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "common/base/status.h"
#include "coordinator/client/farm/farm_policy.h"
#include "parallax/v1/engine.pb.h"

namespace parallax::client {

struct PilotOptions {
  std::string job_name;                       // Name by which this farm's pilots are listed.
  std::string script;                         // Starts a worker: deploy/slurm, deploy/batch.
  std::vector<std::string> submit_options;    // "--partition=short"
  std::vector<std::string> worker_arguments;  // Arguments of the worker.
  // Values for the placeholders of the engine's file, without braces; one that is not here is
  // empty, and its words are no options of the submission: "cores", "memory_mb", "wall_minutes",
  // "log".
  std::map<std::string, std::string> values;
};

// Thread-safe. Errors of all methods: kUnavailable with the program's first line of output if it
// fails; kDeadlineExceeded if it does not end within a minute.
class BatchEngine {
 public:
  // Requires an engine of LoadEngine.
  BatchEngine(v1::Engine engine, PilotOptions options);

  // Returns the user's pilots with this job name, in the order of submission.
  absl::StatusOr<std::vector<Pilot>> Pilots() const;
  // Submits pilots. Returns the array's id, or the ids of all, with spaces between them.
  absl::StatusOr<std::string> Submit(int pilots) const;
  // Cancels pilots by their ids. Errors: those of all methods.
  absl::Status Cancel(const std::vector<std::string>& ids) const;
  // Returns the command line of Submit, for people.
  std::string SubmitCommand(int pilots) const;

 private:
  std::vector<std::string> SubmitWords(int pilots) const;
  const v1::Engine engine_;
  const PilotOptions options_;
};

// Reads the output of the engine's list: the pilots with this job name, in the order of their ids.
// Errors: kInvalidArgument for a line or a state that the engine's file does not know.
absl::StatusOr<std::vector<Pilot>> ParsePilots(const v1::Engine& engine,
                                               const std::string& job_name,
                                               const std::string& text);

}  // namespace parallax::client
