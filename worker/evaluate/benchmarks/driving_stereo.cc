// DrivingStereo: a fixed random subset of 200 test pairs at half resolution, held out by the paper.
#include <algorithm>
#include <filesystem>

#include "common/base/rng.h"
#include "worker/evaluate/benchmarks/kinds.h"
#include "worker/evaluate/benchmarks/layout.h"
#include "worker/evaluate/disparity_files.h"

namespace parallax {
namespace {

namespace fs = std::filesystem;

constexpr size_t kDrivingStereoPairs = 200;
constexpr char kTruthName[] = "disparity-map";

// `path`, which names a disparity map, with `name` in all places instead. The archives are unpacked
// in many ways, but always alike for the three kinds of files:
// test-disparity-map/disparity-map-half-size/..., sunny/disparity-map-half-size/...
std::string Counterpart(std::string path, const std::string& name) {
  for (size_t at = path.find(kTruthName); at != std::string::npos;
       at = path.find(kTruthName, at + name.size())) {
    path.replace(at, sizeof kTruthName - 1, name);
  }
  return path;
}

// Disparity maps at half resolution below `root`, relative to it, sorted; not those for training.
std::vector<std::string> FindTruth(const std::string& root) {
  std::vector<std::string> found;
  std::error_code error;
  for (const auto& entry : fs::recursive_directory_iterator(
           root, fs::directory_options::follow_directory_symlink, error)) {
    const std::string path = entry.path().lexically_relative(root);
    if (path.ends_with(".png") && path.find("disparity-map-half-size") != std::string::npos &&
        !path.starts_with("train")) {
      found.push_back(path);
    }
  }
  std::sort(found.begin(), found.end());
  return found;
}

std::string PictureOf(const std::string& path) {
  const std::string stem = path.substr(0, path.size() - 4);
  return IsFile(stem + ".png") ? stem + ".png" : stem + ".jpg";
}

// The paper's own choice is not published: this one is the same for everybody.
std::vector<std::string> FixedSubset(std::vector<std::string> paths) {
  Rng(SceneSeed{0}, "evaluate/driving_stereo").Shuffle(paths);
  if (paths.size() > kDrivingStereoPairs) paths.resize(kDrivingStereoPairs);
  std::sort(paths.begin(), paths.end());
  return paths;
}

absl::StatusOr<PairTruth> ReadDrivingTruth(const std::string& path) {
  PairTruth truth;
  ASSIGN_OR_RETURN(truth.disparity_px, ReadTruth(path));
  return truth;
}

absl::StatusOr<Benchmark> OpenDrivingStereo(const std::string& dir) {
  ASSIGN_OR_RETURN(const std::string root,
                   FindFolder(dir, {"DrivingStereo", "drivingstereo", "driving_stereo"}));
  Benchmark benchmark;
  benchmark.headline = {.measure = BadAt(3)};
  benchmark.figures = {{.measure = kD1Measure}, {.measure = kEpeMeasure}, {.measure = BadAt(1)}};
  benchmark.mimics =
      "OpenStereo at half resolution (all pixels with truth, mean over images); 200 test pairs "
      "drawn once with a fixed seed; the set has no map of occlusion";
  benchmark.pairs_published = kDrivingStereoPairs;
  std::vector<std::string> files;
  for (const std::string& truth : FixedSubset(FindTruth(root))) {
    BenchmarkPair pair;
    pair.name = fs::path(truth).stem();
    pair.left = PictureOf(root + "/" + Counterpart(truth, "left-image"));
    pair.right = PictureOf(root + "/" + Counterpart(truth, "right-image"));
    pair.read_truth = [path = root + "/" + truth] { return ReadDrivingTruth(path); };
    files.insert(files.end(), {pair.left, pair.right});
    benchmark.pairs.push_back(std::move(pair));
  }
  RETURN_IF_ERROR(RequireFiles(files));
  return benchmark;
}

}  // namespace

void AddDrivingStereo(std::vector<BenchmarkKind>& kinds) {
  kinds.push_back({.name = "drivingstereo",
                   .description = "DrivingStereo, 200 test pairs at half resolution: bad-3",
                   .layout = "DrivingStereo/test-{left-image,right-image,disparity-map}/"
                             "{left-image,right-image,disparity-map}-half-size/*",
                   .open = OpenDrivingStereo});
}

}  // namespace parallax
