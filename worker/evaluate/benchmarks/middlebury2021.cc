// Middlebury 2021 (taken with a mobile device). It ships no masks of what is occluded.
#include "worker/evaluate/benchmarks/benchmark_layout.h"
#include "worker/evaluate/benchmarks/kinds.h"

namespace parallax {
namespace {

constexpr int kMiddlebury2021Pairs = 24;

absl::StatusOr<Benchmark> OpenMiddlebury2021(const std::string& dir) {
  ASSIGN_OR_RETURN(
      const std::string root,
      FindFolder(dir, {"Middlebury/2021/data", "Middlebury/2021/all/data", "middlebury/2021/data",
                       "middlebury2021/data", "2021/data", "2021/all/data", "scenes2021/data"}));
  Benchmark benchmark;
  benchmark.headline = {.measure = BadAt(2)};
  benchmark.figures = {
      {.measure = BadAt(2), .region = "nocc"}, {.measure = kEpeMeasure}, {.measure = BadAt(1)}};
  benchmark.mimics =
      "StereoAnywhere's test (all pixels with truth, mean over images); 'nocc' by disp0 and disp1";
  benchmark.pairs_published = kMiddlebury2021Pairs;
  std::vector<std::string> files;
  for (const std::string& scene : SubFolders(root)) {
    const std::string at = root + "/" + scene + "/";
    const MiddleburyFiles truth = {.left = at + "disp0.pfm", .right = at + "disp1.pfm"};
    files.insert(files.end(), {at + "im0.png", at + "im1.png", truth.left, truth.right});
    benchmark.pairs.push_back(
        {.name = scene, .left = at + "im0.png", .right = at + "im1.png", .read_truth = [truth] {
           return ReadMiddleburyTruth(truth);
         }});
  }
  RETURN_IF_ERROR(RequireFiles(files));
  return benchmark;
}

}  // namespace

void AddMiddlebury2021(std::vector<BenchmarkKind>& kinds) {
  kinds.push_back({.name = "middlebury2021",
                   .description = "Middlebury 2021 (mobile), 24 pairs: bad-2, all pixels",
                   .layout = "Middlebury/2021/data/SCENE/{im0,im1}.png, disp0.pfm, disp1.pfm",
                   .open = OpenMiddlebury2021});
}

}  // namespace parallax
