#include "worker/dataset/export/export.h"

#include <fmt/core.h>
#include <sys/stat.h>
#include <tbb/parallel_for.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <fstream>
#include <mutex>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>

#include "common/base/edit_distance.h"
#include "common/base/hash.h"
#include "common/base/system/file.h"
#include "common/base/version.h"
#include "common/config/check/field_rules.h"
#include "common/config/config.h"
#include "common/config/frame_files.h"
#include "common/config/training_plan.h"
#include "worker/dataset/archive/dataset_reader.h"
#include "worker/dataset/export/export_card.h"
#include "worker/dataset/export/export_layouts.h"
#include "worker/dataset/export/export_plan.h"
#include "worker/dataset/export/shards.h"
#include "worker/dataset/frame/frame_reader.h"

namespace parallax {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

// Returns why the file does not end as a PNG does, with its chunk IEND: "is cut off", "has 3 bytes
// behind its end"; "" if it does. Layouts that link pictures do not decode them.
std::string WhyNotWholePng(const std::string& path, int64_t size) {
  constexpr std::string_view kEnd("\0\0\0\0IEND\xAE\x42\x60\x82", 12);
  std::ifstream file(path, std::ios::binary);
  std::string end(static_cast<size_t>(std::min<int64_t>(size, 1 << 16)), 0);
  file.seekg(-static_cast<std::streamoff>(end.size()), std::ios::end);
  if (!file.read(end.data(), static_cast<std::streamsize>(end.size()))) return "can't be read";
  const size_t at = end.rfind(kEnd);
  if (at == std::string::npos) return "is cut off";
  const size_t behind = end.size() - at - kEnd.size();
  return behind == 0 ? "" : fmt::format("has {} bytes behind its end", behind);
}

// A variant of the study that is gone as a whole is a hole, too. Folders without a readable lock
// file, as those of single variants, can't tell.
absl::Status CheckVariants(const Dataset& dataset) {
  const absl::StatusOr<v1::StudySpec> study = LoadStudy(dataset.dir + "/study.lock.yaml");
  if (!study.ok()) return absl::OkStatus();
  for (const v1::VariantSpec& wanted : study->variants()) {
    const bool found =
        std::any_of(dataset.variants.begin(), dataset.variants.end(),
                    [&](const DatasetVariant& v) { return v.name == wanted.name(); });
    if (found || wanted.name() == kHeldoutName) continue;
    return FailedPrecondition(
        "the dataset has holes: the study's variant {} is not in {} (finish the run, fetch it "
        "again, or --allow-incomplete)",
        wanted.name(), dataset.dir);
  }
  return absl::OkStatus();
}

// Every file that the layouts read must be there: half a dataset must not pass for a whole one.
absl::Status CheckWhole(const DatasetVariant& variant, const ExportOptions& options) {
  if (!variant.faults.empty()) {
    return FailedPrecondition("the dataset has holes: {}", variant.faults.front());
  }
  const auto frames = static_cast<int64_t>(variant.frames.size());
  if (frames < variant.pairs_wanted && !options.allow_incomplete) {
    return FailedPrecondition(
        "the dataset has holes: {} has {} of {} pairs (finish the run, or --allow-incomplete)",
        variant.dir, frames, variant.pairs_wanted);
  }
  for (const DatasetFrame& frame : variant.frames) {
    for (const char* name : kInfraredFiles) {
      if (!options.infrared || frame.files.contains(name)) continue;
      return FailedPrecondition("{} has no infrared pictures (render.maps: [..., infrared])",
                                frame.dir);
    }
    v1::RenderConfig needed;
    needed.add_maps("disparity");
    needed.add_maps("occlusion");
    std::vector<std::string> names = FrameFileNames(needed);
    if (options.infrared) names.insert(names.end(), kInfraredFiles, std::end(kInfraredFiles));
    for (const std::string& name : names) {
      const std::string path = frame.dir + "/" + name;
      struct stat info {};
      if (::stat(path.c_str(), &info) != 0) {
        return FailedPrecondition("the dataset has holes: {} is missing{}", path,
                                  frame.files.contains(name) ? "" : " (the map was not written)");
      }
      if (info.st_size == 0) return FailedPrecondition("the dataset has holes: {} is empty", path);
      if (!path.ends_with(".png")) continue;
      if (const std::string why = WhyNotWholePng(path, info.st_size); !why.empty()) {
        return FailedPrecondition("the dataset has holes: {} {}", path, why);
      }
    }
  }
  return absl::OkStatus();
}

class Exporter {
 public:
  Exporter(std::string staging, std::string licence, const ExportOptions& options,
           ExportResult& result)
      : staging_(std::move(staging)),
        licence_(std::move(licence)),
        options_(options),
        result_(result),
        train_shards_(staging_, "train", options.shard_pairs),
        test_shards_(staging_, "test", options.shard_pairs) {}

  absl::Status Run(const ExportPlan& plan) {
    const std::unique_ptr<ExportLayout> layout = MakeExportLayout(options_);
    lines_.resize(plan.frames.size());
    std::string train, test;
    for (const auto& [first, end] : plan.scenes) {
      for (size_t begin = first; begin < end; begin += kBlock) {
        if (options_.cancel.cancelled()) return Cancelled("export");
        const size_t size = std::min(kBlock, end - begin);
        std::vector<absl::StatusOr<FrameFiles>> made(size, FrameFiles());
        tbb::parallel_for(size_t{0}, size, [&](size_t i) {
          const ExportFrame& frame = plan.frames[begin + i];
          made[i] = CatchJson(frame.source->dir, [&] { return layout->Convert(frame); });
        });
        for (size_t i = 0; i < size; ++i) {
          const ExportFrame& frame = plan.frames[begin + i];
          if (!made[i].ok()) return WithContext(made[i].status(), frame.source->dir);
          RETURN_IF_ERROR(Take(frame, *std::move(made[i]), layout->Shards()));
          (frame.test ? test : train) += lines_[begin + i] + "\n";
        }
      }
      ASSIGN_OR_RETURN(const std::vector<ExportFile> more,
                       layout->FinishScene({plan.frames.begin() + static_cast<ptrdiff_t>(first),
                                            plan.frames.begin() + static_cast<ptrdiff_t>(end)}));
      for (const ExportFile& file : more) RETURN_IF_ERROR(Write(file.path, file.bytes));
    }
    ASSIGN_OR_RETURN(const std::vector<ExportFile> last, layout->Finish(plan.frames));
    for (const ExportFile& file : last) RETURN_IF_ERROR(Write(file.path, file.bytes));
    RETURN_IF_ERROR(FinishShards());
    RETURN_IF_ERROR(Write("train.txt", train));
    RETURN_IF_ERROR(Write("test.txt", test));
    RETURN_IF_ERROR(WriteCards(plan));
    std::sort(sums_.begin(), sums_.end(),
              [](const auto& a, const auto& b) { return a.first < b.first; });
    std::string text;
    for (const auto& [path, hash] : sums_) text += hash + "  " + path + "\n";
    return WriteFile(staging_ + "/SHA256SUMS", text, /*sync=*/true);
  }

 private:
  static constexpr size_t kBlock = 32;  // Frames whose files are in memory at once.

  absl::Status Take(const ExportFrame& frame, FrameFiles made, bool shards) {
    lines_[static_cast<size_t>(frame.number)] = made.list_line;
    result_.pixels_out_of_range += made.pixels_out_of_range;
    for (size_t i = 0; i < made.disparity_counts.size(); ++i) {
      result_.disparity.counts[i] += made.disparity_counts[i];
    }
    if (shards) return (frame.test ? test_shards_ : train_shards_).Add(made.files);
    for (const ExportFile& file : made.files) {
      RETURN_IF_ERROR(file.link_to.empty() ? Write(file.path, file.bytes) : Link(file, frame));
    }
    return absl::OkStatus();
  }

  absl::Status MakeParent(const std::string& path) {
    const std::string parent = fs::path(path).parent_path();
    if (!made_.insert(parent).second) return absl::OkStatus();
    std::error_code error;
    fs::create_directories(parent, error);
    return error ? ErrnoError(error.value(), "make folder " + parent) : absl::OkStatus();
  }

  absl::Status Write(const std::string& path, const std::string& bytes) {
    RETURN_IF_ERROR(MakeParent(staging_ + "/" + path));
    RETURN_IF_ERROR(WriteFile(staging_ + "/" + path, bytes));
    sums_.emplace_back(path, Sha256Hex(bytes));
    ++result_.files_written;
    result_.bytes_written += static_cast<int64_t>(bytes.size());
    return absl::OkStatus();
  }

  absl::Status Link(const ExportFile& file, const ExportFrame& frame) {
    const std::string to = staging_ + "/" + file.path;
    RETURN_IF_ERROR(MakeParent(to));
    if (::link(file.link_to.c_str(), to.c_str()) == 0) {
      const auto known = frame.source->files.find(fs::path(file.link_to).filename());
      if (known != frame.source->files.end()) {
        sums_.emplace_back(file.path, known->second);
      } else {
        ASSIGN_OR_RETURN(std::string hash, Sha256HexOfFile(to));
        sums_.emplace_back(file.path, std::move(hash));
      }
      ++result_.files_linked;
      return absl::OkStatus();
    }
    if (errno != EXDEV && errno != EPERM && errno != EMLINK && errno != EOPNOTSUPP) {
      return ErrnoError(errno, "link " + to);
    }
    ASSIGN_OR_RETURN(const std::string bytes,
                     ReadUnchanged(frame, fs::path(file.link_to).filename()));
    return Write(file.path, bytes);
  }

  absl::Status FinishShards() {
    for (ShardWriter* shards : {&train_shards_, &test_shards_}) {
      RETURN_IF_ERROR(shards->Finish());
      for (const Shard& shard : shards->shards()) {
        sums_.emplace_back(shard.file, shard.sha256);
        ++result_.files_written;
        result_.bytes_written += shard.bytes;
        const char* split = shards == &test_shards_ ? "TEST" : "TRAIN";
        shards_.push_back({{"file", shard.file}, {"pairs", shard.pairs}, {"split", split}});
      }
    }
    return absl::OkStatus();
  }

  absl::Status WriteCards(const ExportPlan& plan) {
    const std::string list = Describe(plan);
    const ExportCard card = MakeExportCard(options_.layout, result_, list, licence_,
                                           train_shards_.shards(), test_shards_.shards());
    RETURN_IF_ERROR(Write("export.json", list));
    RETURN_IF_ERROR(Write("LICENSE", licence_));
    RETURN_IF_ERROR(Write("croissant.json", card.croissant));
    return Write("README.md", card.markdown);
  }

  std::string Describe(const ExportPlan& plan) const {
    Json json;
    json["format"] = "parallax-export-1";
    json["layout"] = options_.layout;
    json["program"] = kProgramVersion;
    json["filtered"] = !options_.unfiltered;
    if (options_.infrared) json["pictures"] = "infrared";
    json["pairs"] = result_.pairs;
    json["pairs_test"] = result_.pairs_test;
    json["pairs_filtered_out"] = result_.pairs_filtered_out;
    json["pixels_out_of_range"] = result_.pixels_out_of_range;
    json["disparity_histogram"] = {{"bin_px", result_.disparity.bin_width},
                                   {"counts", result_.disparity.counts}};
    Json limits = Json::object();
    for (const int limit : kDisparityLimitsPx) {
      limits[std::to_string(limit)] = result_.disparity.FractionBelow(limit);
    }
    json["disparity_fraction_below_px"] = limits;
    if (!shards_.empty()) json["shards"] = shards_;
    Json frames = Json::array();
    for (const ExportFrame& frame : plan.frames) {
      frames.push_back({{"variant", frame.source->variant},
                        {"scene", frame.source->scene},
                        {"rig", frame.source->rig},
                        {"split", frame.test ? "TEST" : "TRAIN"},
                        {"files", lines_[static_cast<size_t>(frame.number)]}});
    }
    json["frames"] = frames;
    return json.dump(1) + "\n";
  }

  const std::string staging_;
  const std::string licence_;  // Text of LICENSE.
  const ExportOptions& options_;
  ExportResult& result_;
  std::set<std::string> made_;  // Folders.
  std::vector<std::string> lines_;
  std::vector<std::pair<std::string, std::string>> sums_;
  ShardWriter train_shards_, test_shards_;
  Json shards_ = Json::array();
};

// The finished export is renamed to `out`, so an empty folder there must give way.
absl::Status CheckReplaceable(const std::string& out) {
  std::error_code error;
  if (!fs::exists(fs::symlink_status(out, error))) return absl::OkStatus();
  if (::rmdir(out.c_str()) != 0) {
    if (errno != ENOTDIR && errno != EBUSY) return ErrnoError(errno, "replace " + out);
    return FailedPrecondition("{} is a link or a mount point: name a folder in it", out);
  }
  fs::create_directory(out, error);
  return error ? ErrnoError(error.value(), "make folder " + out) : absl::OkStatus();
}

// Adds what the layout's readers want of the plan, where it lacks that.
void NoteWants(const ExportPlan& plan, const std::string& layout, ExportResult& result) {
  if (layout == "crestereo" && result.pairs < 4) {
    result.notes.push_back("readers of this layout want at least four pairs, one in each folder");
  }
  constexpr int kValidFrames = 40;  // sample_len of dynamic_stereo's train.py.
  const bool valid = std::any_of(
      plan.frames.begin(), plan.frames.end(),
      [](const ExportFrame& frame) { return frame.test && frame.length >= kValidFrames; });
  if (layout == "dynamic-replica" && !valid) {
    result.notes.push_back(
        fmt::format("no sequence for tests has {} frames, which dynamic_stereo's train.py wants of "
                    "the one that it validates on (rigs.count / rigs.path.paths, or rigs.count / "
                    "nature.walk.walks)",
                    kValidFrames));
  }
}

// Writes the export's files into `staging`. Layouts catch what a damaged frame.json throws, and
// name its frame; whatever else is thrown ends here.
absl::Status Fill(const std::string& staging, const std::string& dataset, std::string licence,
                  const ExportOptions& options, const ExportPlan& plan, ExportResult& result) {
  try {
    return Exporter(staging, std::move(licence), options, result).Run(plan);
  } catch (const Json::exception& error) {
    return DataLoss("{}: a frame.json: {}", dataset, error.what());
  }
}

}  // namespace

absl::StatusOr<ExportResult> ExportDataset(const std::string& dir, const std::string& out_dir,
                                           const ExportOptions& options) {
  if (MakeExportLayout(options) == nullptr) {
    std::string names;
    for (const std::string& name : ExportLayouts()) names += (names.empty() ? "" : ", ") + name;
    return InvalidArgument("no layout \"{}\"{} (there are {})", options.layout,
                           NearestHint(options.layout, ExportLayouts()), names);
  }
  ASSIGN_OR_RETURN(Dataset dataset, ReadDataset(dir));
  const std::string from = dataset.dir;
  if (options.variants.empty() && !options.allow_incomplete) {
    RETURN_IF_ERROR(CheckVariants(dataset));
  }
  ExportResult result;
  if (options.variants.empty() && LeaveOutHeldout(dataset)) {
    result.notes.push_back(
        fmt::format("the pairs of {} are left out, because trainings may not see them; --variant "
                    "{} exports them",
                    kHeldoutName, kHeldoutName));
  }
  ASSIGN_OR_RETURN(const std::vector<DatasetVariant> variants,
                   ChooseVariants(std::move(dataset), options.variants));
  for (const DatasetVariant& variant : variants) RETURN_IF_ERROR(CheckWhole(variant, options));

  std::string out = fs::absolute(out_dir).lexically_normal();
  while (out.size() > 1 && out.back() == '/') out.pop_back();
  std::error_code error;
  if (fs::exists(out, error) && !(fs::is_directory(out, error) && fs::is_empty(out, error))) {
    return FailedPrecondition("{} holds something already: choose another folder", out);
  }
  if (out == from || out.compare(0, from.size() + 1, from + "/") == 0) {
    return FailedPrecondition("{} lies in the dataset itself: choose another folder", out);
  }
  RETURN_IF_ERROR(CheckReplaceable(out));
  const bool sequences = MakeExportLayout(options)->Sequences();
  ASSIGN_OR_RETURN(const ExportPlan plan, MakeExportPlan(variants, options, sequences, result));
  absl::StatusOr<std::string> licence = LicenceOf(variants);
  RETURN_IF_ERROR(licence.status());
  if (plan.frames.empty()) {
    return NotFound("{}: no pair is left ({} fail a filter; --unfiltered takes them)", dir,
                    result.pairs_filtered_out);
  }
  for (const char* word : {"left", "right", "disparity"}) {
    if (options.layout == "flyingthings" && out.find(word) != std::string::npos) {
      result.notes.push_back("the path has \"" + std::string(word) +
                             "\" in it, which some readers of this layout replace: move it");
    }
  }
  NoteWants(plan, options.layout, result);

  const std::string staging =
      fs::path(out).parent_path().string() + "/." + fs::path(out).filename().string() + ".partial";
  fs::remove_all(staging, error);
  fs::create_directories(staging, error);
  if (error) return ErrnoError(error.value(), "make folder " + staging);
  absl::Status status = Fill(staging, dir, *std::move(licence), options, plan, result);
  if (status.ok()) {
    fs::remove(out, error);  // Empty, as was checked.
    if (::rename(staging.c_str(), out.c_str()) != 0) {
      status = ErrnoError(errno, "rename " + staging + " to " + out);
    }
  }
  if (!status.ok()) {
    fs::remove_all(staging, error);
    return status;
  }
  for (const int limit : kDisparityLimitsPx) {
    result.below_limit[limit] = result.disparity.FractionBelow(limit);
  }
  if (result.pixels_out_of_range > 0) {
    result.notes.push_back(
        fmt::format("{} pixels have a larger disparity than the layout's 16 bits hold: they are "
                    "marked as unknown",
                    result.pixels_out_of_range));
  }
  return result;
}

}  // namespace parallax
