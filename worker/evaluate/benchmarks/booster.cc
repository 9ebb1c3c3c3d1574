// Booster, balanced training pairs at quarter resolution.
#include <fmt/core.h>

#include "common/base/status.h"
#include "common/image/io.h"
#include "worker/evaluate/benchmarks/benchmark_layout.h"
#include "worker/evaluate/benchmarks/kinds.h"
#include "worker/evaluate/disparity_files.h"

namespace parallax {
namespace {

constexpr int kBoosterPairs = 228;
constexpr int kShrink = 4;
constexpr int kMaterialClasses = 4;  // 3: transparent or mirror.

struct BoosterFiles {
  std::string truth, visible, materials;
};

absl::StatusOr<PairTruth> ReadBoosterTruth(const BoosterFiles& files) {
  PairTruth truth;
  ASSIGN_OR_RETURN(const ImageF full, ReadTruth(files.truth, {}, kShrink * kLargestTruthPx));
  ASSIGN_OR_RETURN(const ImageU8 visible, ReadPngU8(files.visible));
  ASSIGN_OR_RETURN(const ImageU8 materials, ReadPngU8(files.materials));
  for (const auto* map : {&visible, &materials}) {
    if (map->width() != full.width() || map->height() != full.height()) {
      return InvalidArgument("{}: not of the size of its masks", files.truth);
    }
  }
  truth.disparity_px = SubsampleDisparity(full, kShrink);
  truth.regions["nocc"] = Subsample(visible, kShrink);
  const ImageU8 classes = Subsample(materials, kShrink);
  for (uint8_t& value : truth.regions["nocc"].values()) value = value == 255 ? 1 : 0;
  for (int c = 0; c < kMaterialClasses; ++c) {
    ImageU8 region(classes.width(), classes.height());
    for (size_t i = 0; i < region.pixels(); ++i) region.values()[i] = classes.values()[i] == c;
    truth.regions[fmt::format("class{}", c)] = std::move(region);
  }
  return truth;
}

absl::StatusOr<Benchmark> OpenBooster(const std::string& dir) {
  ASSIGN_OR_RETURN(const std::string root,
                   FindFolder(dir, {"Booster/train/balanced", "booster/train/balanced",
                                    "Booster/booster_gt/train/balanced",
                                    "booster_gt/train/balanced", "train/balanced"}));
  Benchmark benchmark;
  benchmark.headline = {.measure = BadAt(2)};
  benchmark.figures = {{.measure = BadAt(2), .region = "nocc"},
                       {.measure = BadAt(2), .region = "class3"},
                       {.measure = BadAt(4)},
                       {.measure = kEpeMeasure}};
  benchmark.mimics =
      "Booster's benchmark at Q: pictures reduced to a quarter, truth every 4th pixel and divided "
      "by "
      "4, all pixels, mean over images; 'class3' is transparent or mirror";
  benchmark.pairs_published = kBoosterPairs;
  std::vector<std::string> files;
  for (const std::string& scene : SubFolders(root)) {
    const std::string at = root + "/" + scene + "/";
    const BoosterFiles truth = {.truth = at + "disp_00.npy",
                                .visible = at + "mask_00.png",
                                .materials = at + "mask_cat.png"};
    files.insert(files.end(), {truth.truth, truth.visible, truth.materials});
    for (const std::string& image : FilesEnding(at + "camera_00", ".png")) {
      BenchmarkPair pair;
      pair.name = scene + "_" + image.substr(0, image.size() - 4);
      pair.left = at + "camera_00/" + image;
      pair.right = at + "camera_02/" + image;
      pair.shrink = kShrink;
      pair.read_truth = [truth] { return ReadBoosterTruth(truth); };
      files.push_back(pair.right);
      benchmark.pairs.push_back(std::move(pair));
    }
  }
  RETURN_IF_ERROR(RequireFiles(files));
  return benchmark;
}

}  // namespace

void AddBooster(std::vector<BenchmarkKind>& kinds) {
  kinds.push_back({.name = "booster-Q",
                   .description = "Booster, 228 balanced training pairs at a quarter of the "
                                  "resolution: bad-2, all pixels",
                   .layout = "Booster/train/balanced/SCENE/{camera_00,camera_02}/im*.png, "
                             "disp_00.npy, mask_00.png, mask_cat.png",
                   .open = OpenBooster});
}

}  // namespace parallax
