// Samplers: programs of the operator's that propose trials of searches. A search names one; only
// the files that the operator put into the folder of samplers say what is run.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/base/status.h"
#include "common/base/system/child_process.h"
#include "common/base/system/clock.h"
#include "common/base/system/temporary_folder.h"

namespace parallax {

struct Sampler {
  std::string name;
  std::vector<std::string> command;  // {ask} and {answer} stand for paths of files.
  std::string directory;             // Where the command runs.
  double timeout_s = 60;
};

// Reads all files "<name>.yaml" of a folder: {sampler: NAME, command: [WORDS], timeout_s: 60};
// empty for an empty path. Commands run in the folder. Errors: those of the disk; kInvalidArgument
// that names file, line, field and what is expected.
absl::StatusOr<std::map<std::string, Sampler>> LoadSamplers(const std::string& dir);

// One question to a sampler that runs. Not thread-safe; the thread that calls Start must live as
// long as the run.
class SamplerRun {
 public:
  // Starts the command. Errors: the system's.
  static absl::StatusOr<std::unique_ptr<SamplerRun>> Start(const Sampler& sampler,
                                                           const std::string& ask, Clock& clock);
  // Returns nothing while it runs; then its answer. Never blocks. Errors of the answer:
  // kDeadlineExceeded for a sampler that takes too long, which is ended; kUnavailable for one that
  // fails, with the last line that it wrote; kDataLoss for no answer, or one of more than 1 MiB.
  std::optional<absl::StatusOr<std::string>> Poll();

 private:
  SamplerRun(const Sampler& sampler, TemporaryFolder folder, Clock& clock);

  const Sampler sampler_;
  const TemporaryFolder folder_;
  Clock& clock_;
  const SteadyTime begun_;
  std::unique_ptr<ChildProcess> child_;
};

}  // namespace parallax
