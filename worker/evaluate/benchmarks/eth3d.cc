// ETH3D low-resolution two-view, training pairs.
#include "worker/evaluate/benchmarks/benchmark_layout.h"
#include "worker/evaluate/benchmarks/kinds.h"

namespace parallax {
namespace {

constexpr int kEth3dPairs = 27;

absl::StatusOr<Benchmark> OpenEth3d(const std::string& dir) {
  ASSIGN_OR_RETURN(
      const std::string images,
      FindFolder(dir, {"ETH3D/two_view_training", "eth3d/two_view_training", "two_view_training"}));
  // The truth comes as an archive of its own; some unpack both into one folder.
  const std::string apart = images + "_gt";
  Benchmark benchmark;
  benchmark.headline = {.measure = BadAt(1)};
  benchmark.figures = {{.measure = BadAt(1), .region = "nocc"},
                       {.measure = kEpeMeasure},
                       {.measure = kEpeMeasure, .region = "nocc"},
                       {.measure = BadAt(2)}};
  benchmark.mimics =
      "RAFT-Stereo evaluate_stereo.py (all pixels with truth, mean over images); 'nocc' is the "
      "benchmark's own table";
  benchmark.pairs_published = kEth3dPairs;
  std::vector<std::string> files;
  for (const std::string& scene : SubFolders(images)) {
    const std::string at = images + "/" + scene + "/";
    const std::string gt = IsFile(at + "disp0GT.pfm") ? at : apart + "/" + scene + "/";
    const MiddleburyFiles truth = {.left = gt + "disp0GT.pfm", .mask = gt + "mask0nocc.png"};
    files.insert(files.end(), {at + "im0.png", at + "im1.png", truth.left, truth.mask});
    benchmark.pairs.push_back(
        {.name = scene, .left = at + "im0.png", .right = at + "im1.png", .read_truth = [truth] {
           return ReadMiddleburyTruth(truth);
         }});
  }
  RETURN_IF_ERROR(RequireFiles(files));
  return benchmark;
}

}  // namespace

void AddEth3d(std::vector<BenchmarkKind>& kinds) {
  kinds.push_back({.name = "eth3d",
                   .description = "ETH3D two-view, 27 training pairs: bad-1, all pixels",
                   .layout = "ETH3D/two_view_training/SCENE/{im0,im1}.png, "
                             "two_view_training_gt/SCENE/{disp0GT.pfm,mask0nocc.png}",
                   .open = OpenEth3d});
}

}  // namespace parallax
