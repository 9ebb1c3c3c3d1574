#include "worker/train/data/training_data.h"

#include <sys/stat.h>

#include <cmath>
#include <cstdlib>
#include <numeric>

#include "common/base/hash.h"
#include "common/base/rng.h"
#include "common/image/io.h"
#include "worker/dataset/archive/dataset_reader.h"

namespace parallax {
namespace {

constexpr uint8_t kSkyOrExterior = 1 | 2;  // Bits of masks_*.png.
constexpr const char* kNeeded[] = {"left.png", "right.png", "disparity_left.exr"};

bool Exists(const std::string& path) {
  struct stat info {};
  return ::stat(path.c_str(), &info) == 0;
}

// "DIR=0.5": a folder whose own name has a "=" is written with its weight.
absl::StatusOr<std::pair<std::string, double>> SplitWeight(const std::string& spec) {
  const size_t equals = spec.rfind('=');
  if (equals == std::string::npos) return std::pair(spec, 1.0);
  const std::string text = spec.substr(equals + 1);
  char* end = nullptr;
  const double weight = std::strtod(text.c_str(), &end);
  if (text.empty() || *end != 0 || !(weight > 0) || !std::isfinite(weight)) {
    return InvalidArgument("{}: the weight is \"{}\", but must be a positive number", spec, text);
  }
  return std::pair(spec.substr(0, equals), weight);
}

// The first needed file that the frame lacks; empty when it is whole.
std::string MissingFile(const DatasetFrame& frame) {
  for (const char* name : kNeeded) {
    if (!Exists(frame.dir + "/" + name)) return frame.dir + "/" + name;
  }
  return "";
}

// Reads `path` into `image`; a file that is not there leaves it empty.
template <typename ImageType>
absl::Status ReadIfThere(const std::string& path,
                         absl::StatusOr<ImageType> (*read)(const std::string&), ImageType& image) {
  if (!Exists(path)) return absl::OkStatus();
  ASSIGN_OR_RETURN(image, read(path));
  return absl::OkStatus();
}

template <typename A, typename B>
bool SameSize(const A& a, const B& b) {
  return a.width() == b.width() && a.height() == b.height();
}

absl::StatusOr<TrainingEye> ReadEye(const std::string& dir, const std::string& eye) {
  TrainingEye result;
  ImageU8 occlusion, masks;
  ASSIGN_OR_RETURN(result.image, ReadPngRgb8(dir + "/" + eye + ".png"));
  RETURN_IF_ERROR(ReadIfThere(dir + "/disparity_" + eye + ".exr", &ReadExrY, result.disparity_px));
  RETURN_IF_ERROR(ReadIfThere(dir + "/occlusion_" + eye + ".png", &ReadPngU8, occlusion));
  RETURN_IF_ERROR(ReadIfThere(dir + "/masks_" + eye + ".png", &ReadPngU8, masks));
  if (result.disparity_px.empty()) return result;
  const auto fits = [&](const auto& map) { return map.empty() || SameSize(map, result.image); };
  if (!fits(result.disparity_px) || !fits(occlusion) || !fits(masks)) {
    return DataLoss("{}: the {} maps differ in size from the image", dir, eye);
  }
  result.trust = ImageU8(result.image.width(), result.image.height(), kVisible);
  for (size_t i = 0; i < result.image.pixels(); ++i) {
    const float disparity = result.disparity_px.values()[i];
    if (!std::isfinite(disparity)) {
      return DataLoss("{}/disparity_{}.exr: a value is not finite", dir, eye);
    }
    uint8_t& trust = result.trust.values()[i];
    if (!occlusion.empty() && occlusion.values()[i] != 0) trust = kOccluded;
    if (!masks.empty() && (masks.values()[i] & kSkyOrExterior) != 0) trust = kNoTruth;
    if (disparity <= 0) trust = kNoTruth;
  }
  return result;
}

}  // namespace

absl::StatusOr<TrainingSource> ReadTrainingSource(const std::string& spec,
                                                  const SourceOptions& options) {
  TrainingSource source;
  ASSIGN_OR_RETURN(const auto split, SplitWeight(spec));
  source.path = split.first;
  source.weight = split.second;
  ASSIGN_OR_RETURN(Dataset dataset, ReadDataset(source.path));
  source.heldout_left_out = !options.heldout && LeaveOutHeldout(dataset);
  if (!options.allow_missing) RETURN_IF_ERROR(RequireIndices(dataset));
  Sha256 hash;
  for (const DatasetVariant& variant : dataset.variants) {
    for (const DatasetFrame& frame : variant.frames) {
      if (!frame.passed && !options.unfiltered) {
        ++source.left_out;
        continue;
      }
      const std::string missing = MissingFile(frame);
      if (!missing.empty() && options.allow_missing) continue;
      if (!missing.empty()) {
        return FailedPrecondition(
            "{} is missing (fetch the dataset again, write that map, or --allow-missing)", missing);
      }
      source.frames.push_back({variant.name + frame.dir.substr(variant.dir.size() + 7), frame.dir});
      hash.Update(source.frames.back().name).Update("\n");
      for (const auto& [name, digest] : frame.files) {
        hash.Update(name).Update(" ").Update(digest).Update("\n");
      }
    }
  }
  if (source.frames.empty()) {
    return FailedPrecondition("{}: no pair to train on ({} turned down by filters{})", source.path,
                              source.left_out,
                              source.heldout_left_out ? "; held-out left out" : "");
  }
  source.data_hash = HexOf(hash.Finish());
  return source;
}

absl::StatusOr<TrainingPair> ReadTrainingPair(const std::string& dir) {
  TrainingPair pair;
  ASSIGN_OR_RETURN(pair.left, ReadEye(dir, "left"));
  ASSIGN_OR_RETURN(pair.right, ReadEye(dir, "right"));
  if (pair.left.disparity_px.empty()) {
    return NotFound("{}/disparity_left.exr is missing", dir);
  }
  if (!SameSize(pair.left.image, pair.right.image)) {
    return DataLoss("{}: the two images differ in size", dir);
  }
  return pair;
}

FrameOrder::FrameOrder(uint64_t seed, std::vector<int> sizes, std::vector<double> weights)
    : seed_(seed) {
  const double sum = std::accumulate(weights.begin(), weights.end(), 0.0);
  for (size_t i = 0; i < sizes.size(); ++i) sources_.push_back({sizes[i], weights[i] / sum});
}

FrameChoice FrameOrder::Next() {
  // The source that is furthest behind its share.
  ++taken_;
  size_t chosen = 0;
  double furthest = -1e300;
  for (size_t i = 0; i < sources_.size(); ++i) {
    const double behind =
        sources_[i].share * static_cast<double>(taken_) - static_cast<double>(sources_[i].taken);
    if (behind > furthest + 1e-9) furthest = behind, chosen = i;
  }
  Source& source = sources_[chosen];
  const int64_t place = source.taken % source.size;
  if (place == 0) {
    Rng rng = Rng(SceneSeed{seed_}, "order").Child("source", chosen);
    rng = rng.Child("round", static_cast<uint64_t>(source.taken / source.size));
    source.round.resize(static_cast<size_t>(source.size));
    std::iota(source.round.begin(), source.round.end(), 0);
    rng.Shuffle(source.round);
  }
  ++source.taken;
  return {static_cast<int>(chosen), source.round[static_cast<size_t>(place)]};
}

}  // namespace parallax
