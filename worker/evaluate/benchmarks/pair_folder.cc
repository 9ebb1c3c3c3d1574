// Any folder of pairs in Middlebury's layout: a folder a pair, or the folder of one pair.
#include <filesystem>
#include <map>

#include "common/base/status.h"
#include "worker/evaluate/benchmarks/benchmark_layout.h"
#include "worker/evaluate/benchmarks/kinds.h"

namespace parallax {
namespace {

namespace fs = std::filesystem;

// Prefers the evaluation's names over those of the data pages.
std::string FirstOf(const std::string& at, const std::vector<std::string>& names) {
  for (const std::string& name : names) {
    if (IsFile(at + name)) return at + name;
  }
  return "";
}

absl::StatusOr<Benchmark> OpenPairFolder(const std::string& dir) {
  std::error_code error;
  if (!fs::is_directory(dir, error)) {
    return NotFound("{}: no such folder", dir);
  }
  std::string root = fs::absolute(dir).lexically_normal();
  while (root.size() > 1 && root.back() == '/') root.pop_back();
  Benchmark benchmark;
  benchmark.own = true;
  benchmark.headline = {.measure = BadAt(2)};
  benchmark.figures = {{.measure = BadAt(2), .region = "nocc"},
                       {.measure = BadAt(1)},
                       {.measure = BadAt(3)},
                       {.measure = kEpeMeasure}};
  benchmark.mimics =
      "RAFT-Stereo evaluate_stereo.py (all pixels with truth, mean over images); 'nocc' over the "
      "pairs that have a mask";
  std::vector<std::string> folders = SubFolders(root);
  if (IsFile(root + "/im0.png")) folders = {""};
  std::vector<std::string> files;
  std::map<std::string, std::string> folder_by_name;
  for (const std::string& folder : folders) {
    const std::string at = folder.empty() ? root + "/" : root + "/" + folder + "/";
    MiddleburyFiles truth = {.left = FirstOf(at, {"disp0GT.pfm", "disp0.pfm"}),
                             .right = FirstOf(at, {"disp1GT.pfm", "disp1.pfm"}),
                             .mask = FirstOf(at, {"mask0nocc.png"})};
    if (truth.left.empty()) truth.left = at + "disp0GT.pfm";
    files.insert(files.end(), {at + "im0.png", at + "im1.png", truth.left});
    for (const std::string& file :
         {at + "im0.png", at + "im1.png", truth.left, truth.right, truth.mask}) {
      if (!file.empty()) benchmark.files.push_back({file, file.substr(root.size() + 1)});
    }
    const std::string name =
        PlainName(folder.empty() ? fs::path(at).parent_path().filename().string() : folder);
    const auto [first, is_new] = folder_by_name.try_emplace(name, folder);
    if (!is_new) {
      return InvalidArgument("{}: the pairs \"{}\" and \"{}\" would both be named {}: rename one",
                             dir, first->second, folder, name);
    }
    benchmark.pairs.push_back(
        {.name = name, .left = at + "im0.png", .right = at + "im1.png", .read_truth = [truth] {
           return ReadMiddleburyTruth(truth);
         }});
  }
  RETURN_IF_ERROR(RequireFiles(files));
  std::vector<std::string> names;
  for (const BenchmarkPair& pair : benchmark.pairs) names.push_back(pair.name);
  const std::vector<std::string> groups = GroupsByName(names);
  for (size_t i = 0; i < groups.size(); ++i) benchmark.pairs[i].group = groups[i];
  return benchmark;
}

}  // namespace

void AddPairFolder(std::vector<BenchmarkKind>& kinds) {
  kinds.push_back({.name = "folder",
                   .description = "Your own pairs in Middlebury's layout: bad-2, all pixels",
                   .layout = "PATH/PAIR/{im0,im1}.png, disp0GT.pfm, [mask0nocc.png | disp1GT.pfm]",
                   .open = OpenPairFolder,
                   .takes_path = true});
}

}  // namespace parallax
