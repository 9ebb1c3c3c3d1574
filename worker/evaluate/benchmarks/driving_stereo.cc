// DrivingStereo: a fixed subset of 200 test pairs at half resolution, held out by the paper.
#include <algorithm>
#include <filesystem>

#include "common/base/hash.h"
#include "worker/evaluate/benchmarks/benchmark_layout.h"
#include "worker/evaluate/benchmarks/kinds.h"
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

// Folders to look for truth in: those of the test pairs, whose names begin so, where there are any;
// else all but those for training. Pictures by weather are a set of their own.
std::vector<std::string> FoldersOfTruth(const std::string& root) {
  const std::vector<std::string> all = SubFolders(root);
  std::vector<std::string> test, others;
  for (const std::string& folder : all) {
    if (folder.starts_with("test")) test.push_back(folder);
    if (!folder.starts_with("train")) others.push_back(folder);
  }
  return test.empty() ? others : test;
}

// Disparity maps at half resolution below `root`, relative to it.
std::vector<std::string> FindTruth(const std::string& root) {
  std::vector<std::string> found;
  std::error_code error;
  for (const std::string& folder : FoldersOfTruth(root)) {
    for (const auto& entry : fs::recursive_directory_iterator(
             root + "/" + folder, fs::directory_options::follow_directory_symlink, error)) {
      const std::string path = entry.path().lexically_relative(root);
      if (path.ends_with(".png") && path.find("disparity-map-half-size") != std::string::npos) {
        found.push_back(path);
      }
    }
  }
  return found;
}

std::string PictureOf(const std::string& path) {
  const std::string stem = path.substr(0, path.size() - 4);
  return IsFile(stem + ".png") ? stem + ".png" : stem + ".jpg";
}

// The paper's own choice is not published. This one takes the pairs whose names have the least
// hashes: it is the same for everybody, and of a part of the set it takes the pairs that it takes
// of the whole.
std::vector<std::string> FixedSubset(const std::vector<std::string>& paths) {
  std::vector<std::pair<Sha256Digest, std::string>> by_hash;
  for (const std::string& path : paths) {
    by_hash.push_back({Sha256Of(fs::path(path).filename().string()), path});
  }
  std::sort(by_hash.begin(), by_hash.end());
  if (by_hash.size() > kDrivingStereoPairs) by_hash.resize(kDrivingStereoPairs);
  std::vector<std::string> chosen;
  for (const auto& [hash, path] : by_hash) chosen.push_back(path);
  std::sort(chosen.begin(), chosen.end());
  return chosen;
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
      "chosen by the hashes of their names; the set has no map of occlusion";
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
