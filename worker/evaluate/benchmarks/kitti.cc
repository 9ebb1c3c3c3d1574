// KITTI 2012 and 2015, training pairs.
#include "common/base/status.h"
#include "common/image/io.h"
#include "worker/evaluate/benchmarks/benchmark_layout.h"
#include "worker/evaluate/benchmarks/kinds.h"
#include "worker/evaluate/disparity_files.h"

namespace parallax {
namespace {

struct KittiFiles {
  std::string occ, noc;
  std::string objects;  // obj_map, or empty.
};

// 1 where the image is not 0.
template <typename ImageType>
ImageU8 SetIn(const ImageType& image) {
  ImageU8 set(image.width(), image.height());
  for (size_t i = 0; i < set.pixels(); ++i) set.values()[i] = image.values()[i] > 0 ? 1 : 0;
  return set;
}

absl::StatusOr<PairTruth> ReadKittiTruth(const KittiFiles& files) {
  PairTruth truth;
  ASSIGN_OR_RETURN(truth.disparity_px, ReadTruth(files.occ));
  ASSIGN_OR_RETURN(const ImageF noc, ReadTruth(files.noc));
  truth.regions["nocc"] = SetIn(noc);
  if (!files.objects.empty()) {
    ASSIGN_OR_RETURN(const ImageU8 objects, ReadPngU8(files.objects));
    truth.regions["foreground"] = SetIn(objects);
    truth.regions["background"] = SetIn(objects);
    for (uint8_t& value : truth.regions["background"].values()) value = 1 - value;
  }
  for (const auto& [name, region] : truth.regions) {
    if (region.width() != truth.disparity_px.width() ||
        region.height() != truth.disparity_px.height()) {
      return InvalidArgument("{}: not of the size of its map of {} pixels", files.occ, name);
    }
  }
  return truth;
}

// Names of the folders of one year, below training/.
struct Year {
  std::vector<std::string> roots;
  std::string left, right, occ, noc, objects;
};

// Every NNNNNN_10.png that has truth. Frames "_11" are the next in time and have none.
absl::StatusOr<std::vector<BenchmarkPair>> FindPairs(const std::string& root, const Year& year) {
  std::vector<BenchmarkPair> pairs;
  std::vector<std::string> files;
  const std::string objects = root + "/" + year.objects + "/";
  const bool has_objects = !year.objects.empty() && !FilesEnding(objects, "_10.png").empty();
  for (const std::string& name : FilesEnding(root + "/" + year.left, "_10.png")) {
    BenchmarkPair pair;
    pair.name = name.substr(0, name.size() - 4);
    pair.left = root + "/" + year.left + "/" + name;
    pair.right = root + "/" + year.right + "/" + name;
    const KittiFiles truth = {.occ = root + "/" + year.occ + "/" + name,
                              .noc = root + "/" + year.noc + "/" + name,
                              .objects = has_objects ? objects + name : ""};
    pair.read_truth = [truth] { return ReadKittiTruth(truth); };
    files.insert(files.end(), {pair.right, truth.occ, truth.noc});
    if (has_objects) files.push_back(truth.objects);
    pairs.push_back(std::move(pair));
  }
  RETURN_IF_ERROR(RequireFiles(files));
  return pairs;
}

Benchmark KittiJudged(int pairs_published) {
  Benchmark benchmark;
  benchmark.headline = {.measure = BadAt(3), .pooled = true};
  benchmark.figures = {{.measure = BadAt(3), .region = "nocc", .pooled = true},
                       {.measure = kD1Measure, .pooled = true},
                       {.measure = kD1Measure, .region = "nocc", .pooled = true},
                       {.measure = kEpeMeasure},
                       {.measure = BadAt(3), .region = "nocc"}};
  benchmark.mimics =
      "RAFT-Stereo evaluate_stereo.py (disp_occ, error > 3 px without the 5 % rule, all pixels of "
      "all images together, EPE per image)";
  benchmark.pairs_published = pairs_published;
  return benchmark;
}

absl::StatusOr<Benchmark> Open2012(const std::string& dir) {
  Year year = {.roots = {"KITTI/2012/training", "KITTI/KITTI_2012/training", "KITTI_2012/training",
                         "KITTI2012/training", "kitti2012/training", "kitti_2012/training",
                         "data_stereo_flow/training"},
               .left = "colored_0",
               .right = "colored_1",
               .occ = "disp_occ",
               .noc = "disp_noc"};
  ASSIGN_OR_RETURN(const std::string root, FindFolder(dir, year.roots));
  // The set has grey pictures as well; colour is what networks are evaluated on.
  if (FilesEnding(root + "/colored_0", "_10.png").empty()) {
    year.left = "image_0";
    year.right = "image_1";
  }
  Benchmark benchmark = KittiJudged(194);
  benchmark.mimics += "; the devkit's own figure is bad-3 nocc, mean over images";
  ASSIGN_OR_RETURN(benchmark.pairs, FindPairs(root, year));
  return benchmark;
}

absl::StatusOr<Benchmark> Open2015(const std::string& dir) {
  const Year year = {.roots = {"KITTI/2015/training", "KITTI/KITTI_2015/training",
                               "KITTI_2015/training", "KITTI2015/training", "kitti2015/training",
                               "kitti_2015/training", "data_scene_flow/training", "KITTI/training"},
                     .left = "image_2",
                     .right = "image_3",
                     .occ = "disp_occ_0",
                     .noc = "disp_noc_0",
                     .objects = "obj_map"};
  ASSIGN_OR_RETURN(const std::string root, FindFolder(dir, year.roots));
  Benchmark benchmark = KittiJudged(200);
  benchmark.mimics += "; the devkit's own figure is d1, pooled";
  ASSIGN_OR_RETURN(benchmark.pairs, FindPairs(root, year));
  return benchmark;
}

}  // namespace

void AddKitti(std::vector<BenchmarkKind>& kinds) {
  kinds.push_back({.name = "kitti2012",
                   .description = "KITTI 2012, 194 training pairs: bad-3, all pixels, pooled",
                   .layout = "KITTI_2012/training/{colored_0,colored_1,disp_occ,disp_noc}/"
                             "NNNNNN_10.png",
                   .open = Open2012});
  kinds.push_back({.name = "kitti2015",
                   .description = "KITTI 2015, 200 training pairs: bad-3, all pixels, pooled",
                   .layout = "KITTI_2015/training/{image_2,image_3,disp_occ_0,disp_noc_0}/"
                             "NNNNNN_10.png",
                   .open = Open2015});
}

}  // namespace parallax
