#include "worker/jobs/files/frame_folder.h"

#include <fmt/core.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <numbers>
#include <optional>
#include <set>

#include "common/base/hash.h"
#include "common/base/system/file.h"
#include "common/config/verdicts.h"
#include "worker/dataset/archive/archive_index.h"
#include "worker/dataset/frame/frame_reader.h"
#include "worker/dataset/frame/sensor_stage.h"
#include "worker/jobs/files/behind_truth.h"
#include "worker/jobs/files/store_files.h"

namespace parallax {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;
using Files = std::map<std::string, LocalFile>;

constexpr char kFacts[] = "frame.json";
constexpr char kRight[] = "right.png";

// A file of a frame: where it is, or what a sensor made in its place.
struct Piece {
  LocalFile file;
  std::optional<std::string> made;
};
using Pieces = std::map<std::string, Piece>;

struct Frame {
  uint32_t scene = 0, rig = 0;
  std::string path;  // In the store.
};

// In order of scenes and rigs, whatever the order of the set.
std::vector<Frame> FramesOf(const v1::FrameSet& set) {
  std::vector<Frame> frames;
  for (const v1::FrameFolder& folder : set.folders()) {
    for (const uint32_t rig : folder.rigs()) {
      frames.push_back({folder.scene(), rig, fmt::format("{}/{:03}", folder.folder(), rig)});
    }
  }
  std::sort(frames.begin(), frames.end(), [](const Frame& a, const Frame& b) {
    return std::pair(a.scene, a.rig) < std::pair(b.scene, b.rig);
  });
  return frames;
}

absl::Status Linked(const std::string& from, const std::string& to, bool from_store) {
  if (::link(from.c_str(), to.c_str()) == 0) return absl::OkStatus();
  if (from_store) {
    if (::symlink(from.c_str(), to.c_str()) == 0) return absl::OkStatus();
    return ErrnoError(errno, "link " + to);
  }
  std::error_code error;
  fs::copy_file(from, to, error);
  return error ? ErrnoError(error.value(), "copy " + to) : absl::OkStatus();
}

// Returns a `share` of 0 to `count` - 1, at least one if it is above 0. Multiples of the golden
// ratio, taken to 0 to 1, lie about evenly however many are taken; so do the numbers whose
// multiples are the least, and a larger share only adds to them.
std::set<size_t> SpreadOver(size_t count, double share) {
  if (share <= 0) return {};
  std::vector<std::pair<double, size_t>> ranked;
  for (size_t i = 0; i < count; ++i) {
    const double multiple = static_cast<double>(i) * std::numbers::phi;
    ranked.emplace_back(multiple - std::floor(multiple), i);
  }
  std::sort(ranked.begin(), ranked.end());
  const auto wanted = std::lround(share * static_cast<double>(count));
  ranked.resize(std::clamp<size_t>(static_cast<size_t>(wanted), 1, count));
  std::set<size_t> chosen;
  for (const auto& [multiple, i] : ranked) chosen.insert(i);
  return chosen;
}

// One call of BringFrames.
class Bringer {
 public:
  Bringer(const v1::FrameSet& set, const Store& store, const FrameCache& cache,
          const std::string& dir, const FrameFolderOptions& options)
      : set_(set),
        store_(store),
        cache_(cache),
        dir_(dir),
        options_(options),
        filters_(set.filters()) {
    // A limit of 1 judges nothing.
    if (options.ambiguous_shares == nullptr) filters_.set_max_ambiguous_share(1);
  }

  absl::StatusOr<FrameFolderFacts> Bring() {
    ASSIGN_OR_RETURN(std::vector<v1::PublishedFrame> passing, Passing());
    const auto wanted = static_cast<size_t>(
        std::max(1.0, std::ceil(options_.share * static_cast<double>(passing.size()) - 1e-9)));
    if (passing.size() > wanted) passing.resize(wanted);
    if (passing.empty()) {
      return Refuse(fmt::format("no pair is left of {}: filters turn all down", facts_.left_out));
    }
    if (options_.mismatched > 0 && passing.size() < 2) {
      return Refuse("one pair can't be mismatched");
    }
    const std::set<size_t> mismatched = SpreadOver(passing.size(), options_.mismatched);
    std::string index;
    for (size_t i = 0; i < passing.size(); ++i) {
      if (options_.cancel.cancelled()) return Cancelled("while frames were brought");
      // Half the list away is a pair of another scene, unless there is only one scene.
      const size_t other = (i + std::max<size_t>(1, passing.size() / 2)) % passing.size();
      RETURN_IF_ERROR(Place(passing[i], mismatched.contains(i) ? &passing[other] : nullptr));
      ASSIGN_OR_RETURN(const IndexLine line, MakeIndexLine(passing[i], filters_));
      index += line.text + "\n";
      Count(passing[i]);
      options_.progress(static_cast<double>(i + 1) / static_cast<double>(passing.size()));
    }
    RETURN_IF_ERROR(WriteFile(dir_ + "/index.jsonl", index));
    facts_.pairs = static_cast<int64_t>(passing.size());
    facts_.mismatched = static_cast<int64_t>(mismatched.size());
    facts_.sha256 = HexOf(hash_.Finish());
    const Json card = {
        {"variant", set_.variant()}, {"pairs", facts_.pairs}, {"pairs_wanted", facts_.pairs}};
    RETURN_IF_ERROR(WriteFile(dir_ + "/dataset.json", card.dump(2) + "\n"));
    return facts_;
  }

 private:
  absl::Status Refuse(const std::string& what) const {
    return FailedPrecondition("variant {}: {}", set_.variant(), what);
  }

  absl::StatusOr<Files> FilesOf(const std::string& path,
                                const std::vector<std::string>& names) const {
    const absl::StatusOr<std::string> local = store_.LocalPath(path);
    if (local.ok()) return FilesOfFrame(*local, names);
    return cache_.Fetch(store_, path, names);
  }

  // The files `names` of a frame, with the pictures of the variant's sensor if it has one.
  absl::StatusOr<Pieces> PiecesOf(const std::string& path,
                                  const std::vector<std::string>& names) const {
    const bool exposes = SensorIsOn(set_.sensor());
    std::vector<std::string> read = names;
    if (exposes) {
      const std::vector<std::string> more = FilesForSensor(set_.sensor());
      read.insert(read.end(), more.begin(), more.end());
    }
    // A picture alone is the same with either truth.
    const bool behind = set_.truth() == "behind" && names.size() > 1;
    if (behind) {
      const std::vector<std::string> more = FilesForBehindTruth();
      read.insert(read.end(), more.begin(), more.end());
    }
    ASSIGN_OR_RETURN(const Files files, FilesOf(path, read));
    Pieces pieces;
    for (const std::string& name : names) {
      const auto file = files.find(name);
      if (file != files.end()) pieces[name] = {file->second, std::nullopt};
    }
    if (exposes) {
      const absl::Status made = PutExposed(files, pieces);
      if (!made.ok()) return WithContext(made, path);
    }
    if (behind) {
      auto made = MakeBehindTruth([&files](const std::string& name) {
        const auto file = files.find(name);
        return file == files.end() ? std::string() : file->second.path;
      });
      if (!made.ok()) return WithContext(made.status(), path);
      Put(*std::move(made), pieces);
    }
    return pieces;
  }

  // Puts files that were made in place of the frame's own.
  static void Put(std::map<std::string, std::string> made, Pieces& pieces) {
    for (auto& [name, bytes] : made) {
      const auto piece = pieces.find(name);
      if (piece == pieces.end()) continue;
      piece->second.file.size = static_cast<int64_t>(bytes.size());
      piece->second.file.sha256 = Sha256Hex(bytes);
      piece->second.made = std::move(bytes);
    }
  }

  absl::Status PutExposed(const Files& files, Pieces& pieces) const {
    google::protobuf::RepeatedPtrField<v1::FileEntry> entries;
    for (const auto& [name, file] : files) {
      v1::FileEntry& entry = *entries.Add();
      entry.set_name(name);
      entry.set_sha256(file.sha256);
    }
    const auto path_of = [&files](const std::string& name) {
      const auto file = files.find(name);
      return file == files.end() ? name : file->second.path;
    };
    ASSIGN_OR_RETURN(auto made,
                     MakeSensorFiles(set_.sensor(), SensorKey(set_.sensor(), entries), path_of));
    Put(std::move(made), pieces);
    return absl::OkStatus();
  }

  // Frames that pass the filters, with their statistics and the paths where the store has them.
  absl::StatusOr<std::vector<v1::PublishedFrame>> Passing() {
    std::vector<v1::PublishedFrame> passing;
    for (const Frame& frame : FramesOf(set_)) {
      if (options_.cancel.cancelled()) return Cancelled("while frames were judged");
      ASSIGN_OR_RETURN(Files files, FilesOf(frame.path, {kFacts}));
      ASSIGN_OR_RETURN(const std::string text, ReadFile(files[kFacts].path));
      const Json json = Json::parse(text, nullptr, /*allow_exceptions=*/false);
      if (!json.is_object() || !json.contains("statistics")) {
        return DataLoss("{}/frame.json: no statistics", frame.path);
      }
      v1::PublishedFrame published;
      published.set_variant(set_.variant());
      published.set_scene(frame.scene);
      published.mutable_frame()->set_rig(frame.rig);
      published.mutable_frame()->set_path(frame.path);
      for (const auto& [name, value] : json["statistics"].items()) {
        if (value.is_number()) (*published.mutable_frame()->mutable_statistics())[name] = value;
      }
      AddAmbiguousShare(published);
      ASSIGN_OR_RETURN(const bool passes, Passes(published));
      if (passes) passing.push_back(std::move(published));
      if (!passes) ++facts_.left_out;
    }
    return passing;
  }

  void AddAmbiguousShare(v1::PublishedFrame& frame) const {
    if (options_.ambiguous_shares == nullptr) return;
    const auto share = options_.ambiguous_shares->find({frame.scene(), frame.frame().rig()});
    if (share == options_.ambiguous_shares->end()) return;  // Other filters turn it down.
    (*frame.mutable_frame()->mutable_statistics())[kAmbiguousShare] = share->second;
  }

  absl::StatusOr<bool> Passes(const v1::PublishedFrame& frame) const {
    ASSIGN_OR_RETURN(const IndexLine line, MakeIndexLine(frame, filters_));
    const Json json = Json::parse(line.text);
    return json["passed"].get<bool>();
  }

  // Links the frame's files and fills in their hashes. `right_of`: whose right image it gets.
  absl::Status Place(v1::PublishedFrame& frame, const v1::PublishedFrame* right_of) {
    ASSIGN_OR_RETURN(Pieces pieces, PiecesOf(frame.frame().path(), options_.files));
    if (right_of != nullptr) {
      ASSIGN_OR_RETURN(Pieces other, PiecesOf(right_of->frame().path(), {kRight}));
      pieces[kRight] = other[kRight];
    }
    const bool from_store = store_.LocalPath(frame.frame().path()).ok();
    const std::string folder = dir_ + "/" + FramePath({frame.scene(), frame.frame().rig()});
    RETURN_IF_ERROR(MakeFolders(folder));
    for (const auto& [name, piece] : pieces) {
      const std::string to = folder + "/" + name;
      const LocalFile& file = piece.file;
      RETURN_IF_ERROR(piece.made ? WriteFile(to, *piece.made) : Linked(file.path, to, from_store));
      v1::FileEntry& entry = *frame.mutable_frame()->add_files();
      entry.set_name(name);
      entry.set_size(file.size);
      entry.set_sha256(file.sha256);
    }
    return absl::OkStatus();
  }

  void Count(const v1::PublishedFrame& frame) {
    hash_.Update(FramePath({frame.scene(), frame.frame().rig()})).Update("\n");
    for (const v1::FileEntry& file : frame.frame().files()) {
      hash_.Update(file.name()).Update(" ").Update(file.sha256()).Update("\n");
    }
  }

  const v1::FrameSet& set_;
  const Store& store_;
  const FrameCache& cache_;
  const std::string& dir_;
  const FrameFolderOptions& options_;
  v1::FilterConfig filters_;
  FrameFolderFacts facts_;
  Sha256 hash_;
};

}  // namespace

std::vector<std::string> FilesForTraining() {
  return {"left.png",
          "right.png",
          "disparity_left.exr",
          "disparity_right.exr",
          "occlusion_left.png",
          "occlusion_right.png",
          "masks_left.png",
          "masks_right.png",
          kFacts};
}

std::vector<std::string> FilesForEvaluation() {
  std::vector<std::string> files = FilesForTraining();
  files.insert(files.end(), {"objects_left.png", "materials_left.png"});
  return files;
}

absl::StatusOr<FrameFolderFacts> BringFrames(const v1::FrameSet& set, const Store& store,
                                             const FrameCache& cache, const std::string& dir,
                                             const FrameFolderOptions& options) {
  return Bringer(set, store, cache, dir, options).Bring();
}

}  // namespace parallax
