// Middlebury 2014: the evaluation's training pairs (MiddEval3) at three resolutions, and the sets
// of the 2014 data page, from which the paper takes a held-out benchmark.
#include <algorithm>
#include <array>

#include "worker/evaluate/benchmarks/benchmark_layout.h"
#include "worker/evaluate/benchmarks/kinds.h"

namespace parallax {
namespace {

constexpr int kEvaluationPairs = 15;
constexpr int kSets = 23;  // With truth, on the 2014 page.

// The scenes of the 2014 page that are not in the evaluation.
constexpr std::array<const char*, 13> kHeldOut = {
    "Backpack", "Bicycle1", "Cable",   "Classroom1", "Couch",  "Flowers", "Mask",
    "Shopvac",  "Sticks",   "Storage", "Sword1",     "Sword2", "Umbrella"};

Benchmark Middlebury2014Judged(int pairs_published) {
  Benchmark benchmark;
  benchmark.headline = {.measure = BadAt(2), .region = "nocc"};
  benchmark.figures = {{.measure = BadAt(2)},
                       {.measure = kEpeMeasure},
                       {.measure = kEpeMeasure, .region = "nocc"},
                       {.measure = BadAt(1), .region = "nocc"}};
  benchmark.mimics =
      "Selective-IGEV evaluate_stereo.py (mask0nocc == 255, mean over images); "
      "'all' is what RAFT-Stereo's prints";
  benchmark.pairs_published = pairs_published;
  return benchmark;
}

absl::StatusOr<Benchmark> OpenEvaluation(const std::string& dir, const std::string& resolution) {
  const std::string folder = "MiddEval3/training" + resolution;
  ASSIGN_OR_RETURN(const std::string root,
                   FindFolder(dir, {"Middlebury/" + folder, "middlebury/" + folder, folder,
                                    "training" + resolution}));
  Benchmark benchmark = Middlebury2014Judged(kEvaluationPairs);
  std::vector<std::string> files;
  for (const std::string& scene : SubFolders(root)) {
    const std::string at = root + "/" + scene + "/";
    const MiddleburyFiles truth = {.left = at + "disp0GT.pfm", .mask = at + "mask0nocc.png"};
    files.insert(files.end(), {at + "im0.png", at + "im1.png", truth.left, truth.mask});
    benchmark.pairs.push_back(
        {.name = scene, .left = at + "im0.png", .right = at + "im1.png", .read_truth = [truth] {
           return ReadMiddleburyTruth(truth);
         }});
  }
  RETURN_IF_ERROR(RequireFiles(files));
  return benchmark;
}

// "Backpack" of "Backpack-perfect".
std::string SceneOf(const std::string& folder) { return folder.substr(0, folder.rfind('-')); }

bool IsHeldOut(const std::string& folder) {
  return std::find(kHeldOut.begin(), kHeldOut.end(), SceneOf(folder)) != kHeldOut.end();
}

// All sets of the 2014 page, or those that are not in the evaluation; each as "-perfect".
absl::StatusOr<Benchmark> OpenSets(const std::string& dir, bool held_out) {
  ASSIGN_OR_RETURN(const std::string root,
                   FindFolder(dir, {"Middlebury/2014", "middlebury/2014", "Middlebury/scenes2014",
                                    "scenes2014", "2014"}));
  Benchmark benchmark = Middlebury2014Judged(held_out ? static_cast<int>(kHeldOut.size()) : kSets);
  std::vector<std::string> files;
  for (const std::string& scene : SubFolders(root)) {
    if (!scene.ends_with("-perfect") || (held_out && !IsHeldOut(scene))) continue;
    const std::string at = root + "/" + scene + "/";
    const MiddleburyFiles truth = {.left = at + "disp0.pfm", .right = at + "disp1.pfm"};
    files.insert(files.end(), {at + "im0.png", at + "im1.png", truth.left, truth.right});
    benchmark.pairs.push_back({.name = SceneOf(scene),
                               .left = at + "im0.png",
                               .right = at + "im1.png",
                               .read_truth = [truth] { return ReadMiddleburyTruth(truth); }});
  }
  RETURN_IF_ERROR(RequireFiles(files));
  benchmark.mimics =
      "Selective-IGEV evaluate_stereo.py; the set ships no masks: visible is what Middlebury's "
      "computemask calls so (disp0 and disp1 agree to 1 px)";
  return benchmark;
}

}  // namespace

void AddMiddlebury2014(std::vector<BenchmarkKind>& kinds) {
  for (const std::string resolution : {"F", "H", "Q"}) {
    kinds.push_back(
        {.name = "middlebury2014-" + resolution,
         .description = "Middlebury 2014 evaluation, training pairs, resolution " + resolution +
                        ": bad-2, not occluded",
         .layout = "Middlebury/MiddEval3/training" + resolution +
                   "/SCENE/{im0,im1}.png, disp0GT.pfm, mask0nocc.png",
         .open = [resolution](const std::string& dir) { return OpenEvaluation(dir, resolution); }});
  }
}

void AddMiddlebury2014Sets(std::vector<BenchmarkKind>& kinds) {
  const char* layout = "Middlebury/2014/SCENE-perfect/{im0,im1}.png, disp0.pfm, disp1.pfm";
  kinds.push_back(
      {.name = "middlebury2014-heldout",
       .description = "Middlebury 2014, the 13 pairs that are not in the evaluation, full size: "
                      "bad-2, not occluded",
       .layout = layout,
       .open = [](const std::string& dir) { return OpenSets(dir, /*held_out=*/true); }});
  kinds.push_back(
      {.name = "middlebury2014-sets",
       .description = "Middlebury 2014, all 23 pairs with truth, full size: bad-2, not occluded",
       .layout = layout,
       .open = [](const std::string& dir) { return OpenSets(dir, /*held_out=*/false); }});
}

}  // namespace parallax
