#include "worker/dataset/verify/verify.h"

#include <fmt/core.h>
#include <sys/stat.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "common/base/hash.h"
#include "common/base/system/file.h"
#include "common/config/config.h"
#include "parallax/v1/scene.pb.h"
#include "worker/dataset/archive/dataset_reader.h"
#include "worker/dataset/frame/frame_json.h"
#include "worker/dataset/frame/frame_reader.h"
#include "worker/dataset/verify/verify_camera.h"
#include "worker/dataset/verify/verify_files.h"
#include "worker/dataset/verify/verify_flow.h"
#include "worker/dataset/verify/verify_frame.h"
#include "worker/dataset/verify/verify_light.h"

namespace parallax {
namespace {

namespace fs = std::filesystem;

void Collect(std::vector<Finding> found, const VerifyOptions& options, VerifyResult& result) {
  for (Finding& finding : found) {
    ++result.findings_total;
    if (static_cast<int>(result.findings.size()) < options.max_findings) {
      result.findings.push_back(std::move(finding));
    }
  }
}

// Whether the frame has the recipe's seed and its rig's camera. One whose numbers can't be read is
// reported by CheckGeometry.
bool IsOfRecipe(const nlohmann::ordered_json& frame, const v1::Scene& scene, const v1::Rig& rig) {
  constexpr double kTolerance = 1e-6;  // Pixels or metres.
  const auto differs = [](const nlohmann::ordered_json& seen, double wanted) {
    return std::abs(seen.get<double>() - wanted) > kTolerance;
  };
  try {
    const auto pose = MatrixOf(rig.world_from_left());
    for (size_t i = 0; i < 16; ++i) {
      if (differs(frame.at("world_from_left").at(i / 4).at(i % 4), pose[i / 4][i % 4])) {
        return false;
      }
    }
    return !differs(frame.at("intrinsics").at("fx"), rig.fx_px()) &&
           !differs(frame.at("baseline_m"), rig.baseline_m()) &&
           SeedOf(frame.at("seeds").at("scene")) == scene.scene_seed();
  } catch (const nlohmann::ordered_json::exception&) {
    return true;
  }
}

// Checks the recipes: each exists, can be read, and has a rig for every frame; with `geometry` also
// that the frame is of that rig.
std::vector<Finding> CheckRecipes(const DatasetVariant& variant, bool geometry) {
  std::vector<Finding> findings;
  std::set<uint32_t> scenes;
  for (const DatasetFrame& frame : variant.frames) scenes.insert(frame.scene);
  for (const uint32_t number : scenes) {
    const std::string path = fmt::format("{}/scenes/{:06}.pb", variant.dir, number);
    const absl::StatusOr<std::string> bytes = ReadFile(path);
    v1::Scene scene;
    if (!bytes.ok()) {
      findings.push_back({"recipe", path, "missing"});
      continue;
    }
    if (!scene.ParseFromString(*bytes) || scene.rigs().empty()) {
      findings.push_back({"recipe", path, "not a scene recipe"});
      continue;
    }
    std::map<uint32_t, const v1::Rig*> rigs;
    for (const v1::Rig& rig : scene.rigs()) rigs[rig.index()] = &rig;
    for (const DatasetFrame& frame : variant.frames) {
      if (frame.scene != number) continue;
      if (!rigs.contains(frame.rig)) {
        findings.push_back({"recipe", path, fmt::format("has no rig {}", frame.rig)});
      } else if (geometry) {
        const auto json = ReadFrameJson(frame.dir);
        if (!json.ok() || IsOfRecipe(*json, scene, *rigs.at(frame.rig))) continue;
        findings.push_back(
            {"recipe", path,
             fmt::format("seed, fx, baseline or pose of rig {} are not those of its frame.json",
                         frame.rig)});
      }
    }
  }
  return findings;
}

// Finds the frames' camera in the lock file above the variant's folder. Other checks report a file
// that is missing or can't be read.
std::vector<Finding> CheckStudyCameras(const DatasetVariant& variant) {
  const fs::path lock = fs::path(variant.dir).parent_path() / "study.lock.yaml";
  const absl::StatusOr<v1::StudySpec> study = LoadStudy(lock);
  if (!study.ok()) return {};
  for (const v1::VariantSpec& spec : study->variants()) {
    if (spec.name() == variant.name) return CheckCameras(variant, spec.config());
  }
  return {};
}

absl::Status VerifyVariant(const DatasetVariant& variant, const VerifyOptions& options,
                           VerifyResult& result) {
  std::vector<Finding> of_folder;
  for (const std::string& fault : variant.faults) {
    const size_t colon = fault.rfind(": ");
    of_folder.push_back({"index", fault.substr(0, colon), fault.substr(colon + 2)});
  }
  Collect(std::move(of_folder), options, result);
  Collect(CheckRecipes(variant, options.geometry), options, result);
  if (options.geometry) Collect(CheckStudyCameras(variant), options, result);
  // Works in blocks, so that findings stay in order and memory small.
  constexpr size_t kBlock = 32;
  for (size_t begin = 0; begin < variant.frames.size(); begin += kBlock) {
    if (options.cancel.cancelled()) return Cancelled("verify");
    const size_t end = std::min(begin + kBlock, variant.frames.size());
    std::vector<std::vector<Finding>> found(end - begin);
    std::vector<int64_t> bytes(end - begin);
    tbb::parallel_for(begin, end, [&](size_t i) {
      CheckFiles(variant.frames[i], options.hashes, found[i - begin], bytes[i - begin]);
      if (options.geometry) {
        CheckGeometry(variant.frames[i], found[i - begin]);
        CheckLight(variant.frames[i], found[i - begin]);
        CheckFlow(variant.frames[i], found[i - begin]);
      }
    });
    for (size_t i = begin; i < end; ++i) {
      ++result.frames;
      result.files += static_cast<int64_t>(variant.frames[i].files.size());
      result.bytes += bytes[i - begin];
      Collect(std::move(found[i - begin]), options, result);
    }
  }
  return absl::OkStatus();
}

// Checks a folder of `parallax export`: every file of SHA256SUMS, and no other.
absl::StatusOr<VerifyResult> VerifyExport(const std::string& dir, const VerifyOptions& options) {
  VerifyResult result;
  result.kind = "export";
  ASSIGN_OR_RETURN(const std::string sums, ReadFile(dir + "/SHA256SUMS"));
  std::istringstream in(sums);
  std::set<std::string> known = {"SHA256SUMS"};
  std::vector<std::pair<std::string, std::string>> files;
  for (std::string row; std::getline(in, row);) {
    if (row.size() < 67 || row.compare(64, 2, "  ") != 0) {
      return DataLoss("{}/SHA256SUMS: not a list of hashes", dir);
    }
    files.emplace_back(row.substr(66), row.substr(0, 64));
    known.insert(files.back().first);
  }
  std::vector<std::vector<Finding>> found(files.size());
  std::vector<int64_t> bytes(files.size());
  tbb::parallel_for(size_t{0}, files.size(), [&](size_t i) {
    const std::string path = dir + "/" + files[i].first;
    struct stat info {};
    if (::stat(path.c_str(), &info) != 0) {
      found[i].push_back({"missing", path, "in SHA256SUMS, but not on disk"});
      return;
    }
    bytes[i] = info.st_size;
    if (!options.hashes) return;
    const absl::StatusOr<std::string> hash = Sha256HexOfFile(path);
    if (!hash.ok() || *hash != files[i].second) {
      found[i].push_back({"hash", path, "is not what SHA256SUMS says"});
    }
  });
  for (size_t i = 0; i < files.size(); ++i) {
    ++result.files;
    result.bytes += bytes[i];
    Collect(std::move(found[i]), options, result);
  }
  std::vector<Finding> strays;
  std::error_code error;
  for (const auto& entry : fs::recursive_directory_iterator(dir, error)) {
    const std::string path = entry.path().lexically_relative(dir);
    if (!entry.is_directory(error) && !known.contains(path)) {
      strays.push_back({"stray", dir + "/" + path, "not in SHA256SUMS"});
    }
  }
  std::sort(strays.begin(), strays.end(),
            [](const Finding& a, const Finding& b) { return a.path < b.path; });
  Collect(std::move(strays), options, result);
  return result;
}

}  // namespace

absl::StatusOr<VerifyResult> VerifyDataset(const std::string& dir, const VerifyOptions& options) {
  std::error_code error;
  if (fs::exists(dir + "/SHA256SUMS", error)) return VerifyExport(dir, options);
  ASSIGN_OR_RETURN(const Dataset dataset, ReadDataset(dir));
  VerifyResult result;
  result.kind = "archive";
  result.variants = static_cast<int64_t>(dataset.variants.size());
  for (const DatasetVariant& variant : dataset.variants) {
    RETURN_IF_ERROR(VerifyVariant(variant, options, result));
  }
  return result;
}

}  // namespace parallax
