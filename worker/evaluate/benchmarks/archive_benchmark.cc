// Our own datasets: the generated held-out set, with errors by class of object and of material.
#include <fmt/core.h>

#include <filesystem>

#include "common/base/status.h"
#include "common/image/io.h"
#include "worker/dataset/archive/dataset_reader.h"
#include "worker/dataset/frame/frame_reader.h"
#include "worker/evaluate/benchmarks/benchmark_layout.h"
#include "worker/evaluate/benchmarks/frame_truth.h"
#include "worker/evaluate/benchmarks/kinds.h"
#include "worker/evaluate/disparity_files.h"

namespace parallax {
namespace {

namespace fs = std::filesystem;

// Bits of masks_left.png.
constexpr int kSky = 1, kExterior = 2, kTransparent = 4, kMirror = 8;

// The class of each entry of a table of frame.json.
absl::StatusOr<std::map<uint16_t, std::string>> ClassNames(const nlohmann::ordered_json& json,
                                                           const char* table) {
  std::map<uint16_t, std::string> names;
  try {
    for (const auto& [index, entry] : json.at(table).items()) {
      names[static_cast<uint16_t>(std::stoi(index))] = entry.at("class").get<std::string>();
    }
  } catch (const std::exception& error) {
    return DataLoss("frame.json: {}: {}", table, error.what());
  }
  return names;
}

ImageU8 WithBit(const ImageU8& masks, int bit) {
  ImageU8 region(masks.width(), masks.height());
  for (size_t i = 0; i < masks.pixels(); ++i) region.values()[i] = (masks.values()[i] & bit) != 0;
  return region;
}

// Sky and what lies outside of rooms is left out, as the paper leaves it out of training.
absl::Status ApplyMasks(const std::string& path, PairTruth& truth) {
  if (!IsFile(path)) return absl::OkStatus();
  ASSIGN_OR_RETURN(const ImageU8 masks, ReadPngU8(path));
  if (masks.width() != truth.disparity_px.width() ||
      masks.height() != truth.disparity_px.height()) {
    return DataLoss("{}: not of the size of the image", path);
  }
  for (size_t i = 0; i < masks.pixels(); ++i) {
    if ((masks.values()[i] & (kSky | kExterior)) != 0) truth.disparity_px.values()[i] = 0;
  }
  truth.regions["transparent"] = WithBit(masks, kTransparent);
  truth.regions["mirror"] = WithBit(masks, kMirror);
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<PairTruth> ReadFrameTruth(const std::string& dir) {
  ASSIGN_OR_RETURN(FrameOnDisk frame, ReadFrame(dir));
  PairTruth truth;
  truth.disparity_px = KnownTruth(std::move(frame.left_disparity_px));
  RETURN_IF_ERROR(ApplyMasks(dir + "/masks_left.png", truth));
  if (!frame.left_occlusion.empty()) {
    for (uint8_t& value : frame.left_occlusion.values()) value = value == 0 ? 1 : 0;
    truth.regions["nocc"] = std::move(frame.left_occlusion);
  }
  if (!frame.left_objects.empty()) {
    LabelMap& classes = truth.groups["class"];
    classes.labels = std::move(frame.left_objects);
    ASSIGN_OR_RETURN(classes.names, ClassNames(frame.json, "objects"));
  }
  if (!frame.left_materials.empty()) {
    LabelMap& materials = truth.groups["material"];
    materials.labels = std::move(frame.left_materials);
    ASSIGN_OR_RETURN(materials.names, ClassNames(frame.json, "materials"));
  }
  return truth;
}

namespace {

std::string FrameName(const DatasetFrame& frame) {
  return fmt::format("{}_{:06}_{:03}", frame.variant, frame.scene, frame.rig);
}

absl::StatusOr<Benchmark> OpenArchive(const std::string& dir) {
  ASSIGN_OR_RETURN(const Dataset dataset, ReadDataset(dir));
  RETURN_IF_ERROR(RequireIndices(dataset));
  Benchmark benchmark;
  benchmark.headline = {.measure = BadAt(2), .region = "nocc"};
  benchmark.figures = {{.measure = BadAt(2)},
                       {.measure = BadAt(1), .region = "nocc"},
                       {.measure = kEpeMeasure},
                       {.measure = BadAt(2), .region = "transparent", .pooled = true},
                       {.measure = BadAt(2), .region = "mirror", .pooled = true}};
  benchmark.mimics =
      "mean over images of the pixels with a surface; sky and the exterior of rooms are left out";
  std::vector<std::string> files;
  for (const DatasetVariant& variant : dataset.variants) {
    for (const DatasetFrame& frame : variant.frames) {
      if (!frame.passed) continue;
      BenchmarkPair pair;
      pair.name = FrameName(frame);
      // Scenes of one number are the same rooms in variants that share a seed.
      pair.group = fmt::format("scene_{:06}", frame.scene);
      pair.left = frame.dir + "/left.png";
      pair.right = frame.dir + "/right.png";
      pair.read_truth = [path = frame.dir] { return ReadFrameTruth(path); };
      files.insert(files.end(), {pair.left, pair.right, frame.dir + "/disparity_left.exr"});
      benchmark.pairs.push_back(std::move(pair));
    }
  }
  RETURN_IF_ERROR(RequireFiles(files));
  // Datasets may be written without maps of occlusion.
  if (!files.empty() && !IsFile(fs::path(files[0]).parent_path() / "occlusion_left.png")) {
    benchmark.headline.region = "all";
  }
  return benchmark;
}

}  // namespace

void AddArchive(std::vector<BenchmarkKind>& kinds) {
  kinds.push_back({.name = "archive",
                   .description = "A dataset of Parallax, frames that pass its filters: bad-2, not "
                                  "occluded; errors by class and material",
                   .layout = "PATH: what `parallax run` or `fetch` wrote, or one of its variants",
                   .open = OpenArchive,
                   .takes_path = true});
}

}  // namespace parallax
