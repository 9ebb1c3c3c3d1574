#include "worker/jobs/offered_tags.h"

#include "common/base/ability_tags.h"
#include "common/base/hash.h"
#include "common/base/system/installation.h"
#include "common/base/system/log.h"
#include "worker/evaluate/benchmark.h"

namespace parallax {

std::vector<std::string> AbilityTagsOf(const JobOptions& options) {
  std::vector<std::string> tags;
  for (const std::string& name : options.trainers.Names()) {
    const absl::Status program = CheckOwnProgram(options.trainers.Find(name)->contract);
    if (program.ok()) {
      tags.push_back(TrainerTag(name));
    } else {
      LogWarning("takes no jobs of a trainer", {{"trainer", name}, {"error", program}});
    }
  }
  for (const std::string& name : InstalledBenchmarks(options.benchmarks_dir)) {
    tags.push_back(BenchmarkTag(name));
  }
  const absl::StatusOr<std::string> network = FindNetwork();
  if (!network.ok()) return tags;
  const absl::StatusOr<std::string> hash = Sha256HexOfFile(*network);
  if (hash.ok()) tags.push_back(NetworkTag(*hash));
  return tags;
}

}  // namespace parallax
