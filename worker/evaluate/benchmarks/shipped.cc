// The real pair that a package ships: Middlebury 2014's Motorcycle at quarter size, from
// scikit-image.
#include "common/base/status.h"
#include "common/base/system/installation.h"
#include "worker/evaluate/benchmarks/benchmark_layout.h"
#include "worker/evaluate/benchmarks/kinds.h"
#include "worker/evaluate/disparity_files.h"

namespace parallax {
namespace {

absl::StatusOr<std::string> FindShipped(const std::string& dir) {
  if (!dir.empty()) {
    const absl::StatusOr<std::string> given = FindFolder(dir, {"shipped"});
    if (given.ok()) return *given;
  }
  const Installation& parallax = ThisInstallation();
  const std::string installed =
      parallax.data.empty() ? kShippedBenchmarksDir : parallax.data + "/benchmarks";
  const absl::StatusOr<std::string> found = FindFolder(installed, {"shipped"});
  if (found.ok()) return *found;
  return NotFound("{}/shipped: missing; {}{}", installed, HowToAddRealPair(parallax),
                  dir.empty() ? "" : ", or have it as " + dir + "/shipped");
}

absl::StatusOr<PairTruth> ReadShippedTruth(const std::string& path) {
  PairTruth truth;
  ASSIGN_OR_RETURN(truth.disparity_px, ReadTruth(path));
  return truth;
}

absl::StatusOr<Benchmark> OpenShipped(const std::string& dir) {
  ASSIGN_OR_RETURN(const std::string root, FindShipped(dir));
  const std::string at = root + "/motorcycle_";
  RETURN_IF_ERROR(RequireFiles({at + "left.png", at + "right.png", at + "disp.npy"}));
  Benchmark benchmark;
  benchmark.headline = {.measure = BadAt(2)};
  benchmark.figures = {{.measure = BadAt(1)}, {.measure = BadAt(3)}, {.measure = kEpeMeasure}};
  benchmark.mimics = "RAFT-Stereo evaluate_stereo.py (all pixels with truth); no mask is shipped";
  benchmark.pairs_published = 1;
  benchmark.pairs.push_back(
      {.name = "Motorcycle",
       .left = at + "left.png",
       .right = at + "right.png",
       .read_truth = [path = at + "disp.npy"] { return ReadShippedTruth(path); }});
  return benchmark;
}

}  // namespace

void AddShipped(std::vector<BenchmarkKind>& kinds) {
  kinds.push_back({.name = "shipped",
                   .description = "Motorcycle (Middlebury 2014, 741x500) as scikit-image ships it: "
                                  "bad-2, all pixels",
                   .layout = "shipped/motorcycle_{left.png,right.png,disp.npy}",
                   .open = OpenShipped});
}

}  // namespace parallax
