// Any pairs at all, named in a text file.
#include <fmt/core.h>

#include <filesystem>
#include <sstream>

#include "common/base/status.h"
#include "common/base/system/file.h"
#include "common/image/io.h"
#include "worker/evaluate/benchmarks/benchmark_layout.h"
#include "worker/evaluate/benchmarks/kinds.h"
#include "worker/evaluate/disparity_files.h"
#include "worker/evaluate/visibility.h"

namespace parallax {
namespace {

namespace fs = std::filesystem;

// `mask`: 0 leaves a pixel out of everything, 255 is visible, all else occluded.
absl::StatusOr<PairTruth> ReadListedTruth(const std::string& truth_path, const std::string& mask) {
  PairTruth truth;
  ASSIGN_OR_RETURN(truth.disparity_px, ReadTruth(truth_path));
  if (mask.empty()) return truth;
  ASSIGN_OR_RETURN(const ImageU8 values, ReadPngU8(mask));
  if (values.width() != truth.disparity_px.width() ||
      values.height() != truth.disparity_px.height()) {
    return InvalidArgument("{}: not of the size of {}", mask, truth_path);
  }
  truth.regions["nocc"] = VisibleOf(values);
  for (size_t i = 0; i < values.pixels(); ++i) {
    if (values.values()[i] == kMaskUnknown) truth.disparity_px.values()[i] = 0;
  }
  return truth;
}

// "0003_left": the line's number first, so that names are unique and sort as the list does.
std::string PairName(int index, const std::string& left) {
  return PlainName(fmt::format("{:04}_{}", index, fs::path(left).stem().string()));
}

absl::StatusOr<Benchmark> OpenPairList(const std::string& path) {
  ASSIGN_OR_RETURN(const std::string text, ReadFile(path));
  const fs::path base = fs::absolute(path).parent_path();
  const auto absolute = [&](const std::string& file) {
    return (base / file).lexically_normal().string();
  };
  Benchmark benchmark;
  benchmark.headline = {.measure = BadAt(2)};
  benchmark.figures = {{.measure = BadAt(2), .region = "nocc"},
                       {.measure = BadAt(1)},
                       {.measure = BadAt(3)},
                       {.measure = kEpeMeasure}};
  benchmark.mimics = "RAFT-Stereo evaluate_stereo.py (all pixels with truth, mean over images)";
  std::vector<std::string> files;
  std::istringstream in(text);
  int number = 0;
  for (std::string row; std::getline(in, row);) {
    ++number;
    std::istringstream words(row.substr(0, row.find('#')));
    std::vector<std::string> fields;
    for (std::string word; words >> word;) fields.push_back(absolute(word));
    if (fields.empty()) continue;
    if (fields.size() < 3 || fields.size() > 4) {
      return InvalidArgument("{}:{}: {} fields, wanted `left right disparity [mask]`", path, number,
                             fields.size());
    }
    files.insert(files.end(), fields.begin(), fields.end());
    const std::string truth = fields[2], mask = fields.size() > 3 ? fields[3] : "";
    benchmark.pairs.push_back(
        {.name = PairName(static_cast<int>(benchmark.pairs.size()), fields[0]),
         .left = fields[0],
         .right = fields[1],
         .read_truth = [truth, mask] { return ReadListedTruth(truth, mask); }});
  }
  absl::Status complete = RequireFiles(files);
  if (!complete.ok()) return WithContext(complete, path);
  return benchmark;
}

}  // namespace

void AddPairList(std::vector<BenchmarkKind>& kinds) {
  kinds.push_back({.name = "list",
                   .description = "Your own pairs, one a line: bad-2, all pixels",
                   .layout = "PATH: lines `left right disparity [mask]`, relative to it; disparity "
                             ".pfm, .npy, .exr or 16-bit .png (x256); mask 255 visible, 0 left out",
                   .open = OpenPairList,
                   .takes_path = true});
}

}  // namespace parallax
