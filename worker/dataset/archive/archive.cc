#include "worker/dataset/archive/archive.h"

#include <fcntl.h>
#include <fmt/core.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <set>
#include <sstream>
#include <utility>
#include <vector>

#include "common/base/hash.h"
#include "common/base/system/file.h"
#include "common/base/system/log.h"
#include "common/base/version.h"
#include "common/config/config.h"
#include "common/config/stages.h"
#include "common/store/store.h"
#include "worker/dataset/archive/archive_index.h"
#include "worker/dataset/archive/dataset_card.h"
#include "worker/dataset/archive/study_change.h"
#include "worker/dataset/frame/frame_reader.h"
#include "worker/dataset/frame/sensor_stage.h"
#include "worker/scene/upgrade.h"

namespace parallax {
namespace {

namespace fs = std::filesystem;

absl::Status RemoveAll(const std::string& path) {
  std::error_code error;
  fs::remove_all(path, error);
  return error ? ErrnoError(error.value(), "remove " + path) : absl::OkStatus();
}

absl::Status Rename(const std::string& from, const std::string& to) {
  if (std::rename(from.c_str(), to.c_str()) == 0) return absl::OkStatus();
  return ErrnoError(errno, "rename " + from + " to " + to);
}

std::string SceneFile(uint32_t scene) { return fmt::format("scenes/{:06}.pb", scene); }

std::string VersionLine() { return "# Parallax " + DescribeVersions(); }

std::string LockText(const v1::StudySpec& study) {
  return VersionLine() + "\n" + StudyToYaml(study);
}

// Returns the study that the folder was made for; nothing if it is new. Errors: kFailedPrecondition
// for another study's folder, or another version's.
absl::StatusOr<std::optional<v1::StudySpec>> StudyOf(const std::string& path,
                                                     const v1::StudySpec& study) {
  const absl::StatusOr<std::string> present = ReadFile(path);
  if (absl::IsNotFound(present.status())) return std::nullopt;
  RETURN_IF_ERROR(present.status());
  const std::string version = present->substr(0, present->find('\n'));
  if (version != VersionLine()) {
    return FailedPrecondition(
        "{} comes from another version of Parallax (there \"{}\", now \"{}\"), whose frames "
        "differ: choose another folder",
        path, version, VersionLine());
  }
  ASSIGN_OR_RETURN(v1::StudySpec locked, ParseStudy(*present, path));
  const auto another = [&path](const std::string& there, const std::string& now) {
    return FailedPrecondition(
        "{} belongs to another study (there \"{}\", now \"{}\"): choose another folder", path,
        there, now);
  };
  if (locked.name() != study.name()) {
    return another("study: " + locked.name(), "study: " + study.name());
  }
  if (locked.seed() != study.seed()) {
    return another(fmt::format("seed: {}", locked.seed()), fmt::format("seed: {}", study.seed()));
  }
  return locked;
}

class Archive final : public ArchiveWriter {
 public:
  Archive(std::string out, const v1::StudySpec& study) : out_(std::move(out)), study_(study) {}

  absl::Status Prepare() {
    RETURN_IF_ERROR(MakeFolders(out_));
    const std::string lock = LockText(study_);
    ASSIGN_OR_RETURN(const std::optional<v1::StudySpec> before,
                     StudyOf(out_ + "/study.lock.yaml", study_));
    if (before) {
      ASSIGN_OR_RETURN(set_aside_, PutAside(out_, PartsDropped(*before, study_)));
    }
    const std::string& source = study_.source_yaml();
    RETURN_IF_ERROR(
        WriteFileAtomically(out_ + "/study.yaml", source.empty() ? StudyToYaml(study_) : source));
    RETURN_IF_ERROR(WriteFileAtomically(out_ + "/study.lock.yaml", lock));
    for (const v1::VariantSpec& variant : study_.variants()) {
      RETURN_IF_ERROR(MakeFolders(out_ + "/" + variant.name() + "/scenes"));
      RETURN_IF_ERROR(MakeFolders(out_ + "/" + variant.name() + "/frames"));
      RETURN_IF_ERROR(ReadIndex(variant));
    }
    return absl::OkStatus();
  }

  bool HasScene(const std::string& variant, uint32_t scene) const override {
    if (scenes_.contains({variant, scene})) return true;
    const std::string path = out_ + "/" + variant + "/" + SceneFile(scene);
    const absl::StatusOr<std::string> bytes = ReadFile(path);
    if (!bytes.ok() || !ParseScene(*bytes, path).ok()) return false;
    scenes_.emplace(variant, scene);
    return true;
  }

  absl::Status AddScene(const std::string& variant, uint32_t scene,
                        const v1::Scene& recipe) override {
    RETURN_IF_ERROR(FindVariant(variant).status());
    return WriteFileAtomically(out_ + "/" + variant + "/" + SceneFile(scene),
                               recipe.SerializeAsString());
  }

  absl::Status AddFrame(const v1::PublishedFrame& frame, const std::string& store_dir) override {
    ASSIGN_OR_RETURN(const v1::VariantSpec* variant, FindVariant(frame.variant()));
    RETURN_IF_ERROR(CheckStorePath(frame.frame().path()));
    for (const v1::FileEntry& file : frame.frame().files()) {
      RETURN_IF_ERROR(CheckStorePath(file.name()));
      if (file.name().find('/') != std::string::npos) {
        return InvalidArgument("frame file {}: allowed is a plain name", file.name());
      }
    }
    const FrameId key = {frame.scene(), frame.frame().rig()};
    const std::string dir = out_ + "/" + frame.variant() + "/" + FramePath(key);
    const std::string source = store_dir + "/" + frame.frame().path();
    std::map<FrameId, IndexLine>& index = index_[frame.variant()];
    Content content{frame, {}, false};
    if (SensorIsOn(variant->config().sensor())) {
      const absl::Status exposed =
          Expose(variant->config().sensor(), dir, source, index.find(key), content);
      if (!exposed.ok()) return WithContext(exposed, frame.variant() + "/" + FramePath(key));
    }
    ASSIGN_OR_RETURN(IndexLine line, MakeIndexLine(content.frame, variant->config().filters()));

    std::error_code error;
    const bool present = fs::exists(dir, error);
    const auto known = index.find(line.key);
    const bool indexed = known != index.end() && known->second.files == line.files;
    if (indexed) {  // Curation judged these very files; the coordinator knows nothing of it.
      if (const std::optional<double> share = AmbiguousShareOf(known->second)) {
        RETURN_IF_ERROR(SetAmbiguousShare(share, variant->config().filters(), line));
      }
    }
    if (present && !content.made_anew && IsEqual(dir, source, content, indexed)) {
      ++totals_.frames_present;
    } else {
      RETURN_IF_ERROR(Materialise(dir, source, content, present));
      ++(present ? totals_.frames_replaced : totals_.frames_added);
    }
    index.insert_or_assign(line.key, std::move(line));
    return absl::OkStatus();
  }

  absl::Status Finish() override {
    for (const v1::VariantSpec& variant : study_.variants()) {
      const std::string dir = out_ + "/" + variant.name();
      std::vector<IndexLine> lines;
      for (const auto& [key, line] : index_[variant.name()]) lines.push_back(line);
      RETURN_IF_ERROR(WriteDatasetCard(dir, study_, variant, lines));
    }
    return absl::OkStatus();
  }

  const Totals& totals() const override { return totals_; }
  const std::vector<std::string>& set_aside() const override { return set_aside_; }

  std::map<std::string, int64_t> Frames() const override {
    std::map<std::string, int64_t> counts;
    for (const v1::VariantSpec& variant : study_.variants()) counts[variant.name()] = 0;
    for (const auto& [variant, index] : index_)
      counts[variant] = static_cast<int64_t>(index.size());
    return counts;
  }

 private:
  // The contents of an archived frame: files of a sensor are in memory, the others in the store.
  struct Content {
    v1::PublishedFrame frame;
    std::map<std::string, std::string> made;  // Bytes by name.
    bool made_anew = false;
  };
  using Known = std::map<FrameId, IndexLine>::const_iterator;

  // Replaces the rendered pictures by a sensor's. Existing ones in `dir` that match the index are
  // reused.
  absl::Status Expose(const v1::SensorConfig& sensor, const std::string& dir,
                      const std::string& source, Known known, Content& content) {
    v1::FrameResult& frame = *content.frame.mutable_frame();
    const std::string key = SensorKey(sensor, frame.files());
    content.made = MadeBefore(dir, key, known, index_[content.frame.variant()].end());
    if (content.made.empty()) {
      ASSIGN_OR_RETURN(content.made, MakeSensorFiles(sensor, key, [&](const std::string& name) {
                         return source + "/" + name;
                       }));
      content.made_anew = true;
    }
    for (v1::FileEntry& file : *frame.mutable_files()) {
      const auto made = content.made.find(file.name());
      if (made == content.made.end()) continue;
      file.set_size(static_cast<int64_t>(made->second.size()));
      file.set_sha256(Sha256Hex(made->second));
    }
    return absl::OkStatus();
  }

  // Returns nothing if none exist with this key, or if they do not match the index.
  static std::map<std::string, std::string> MadeBefore(const std::string& dir,
                                                       const std::string& key, Known known,
                                                       Known none) {
    std::map<std::string, std::string> made;
    if (known == none) return {};
    const auto json = ReadFrameJson(dir);
    if (!json.ok() || SensorKeyOf(*json) != key) return {};
    for (const char* name : {"left.png", "right.png", "frame.json"}) {
      const absl::StatusOr<std::string> bytes = ReadFile(dir + "/" + name);
      const auto hash = known->second.files.find(name);
      if (!bytes.ok() || hash == known->second.files.end() || Sha256Hex(*bytes) != hash->second) {
        return {};
      }
      made.emplace(name, *bytes);
    }
    return made;
  }

  absl::StatusOr<const v1::VariantSpec*> FindVariant(const std::string& name) const {
    for (const v1::VariantSpec& variant : study_.variants()) {
      if (variant.name() == name) return &variant;
    }
    return InvalidArgument("study {} has no variant \"{}\"", study_.name(), name);
  }

  // Judges each frame by the current filters. Drops lines whose frame is gone, and lines that an
  // interrupted disk broke.
  absl::Status ReadIndex(const v1::VariantSpec& variant) {
    const std::string dir = out_ + "/" + variant.name();
    const absl::StatusOr<std::string> text = ReadFile(dir + "/index.jsonl");
    if (absl::IsNotFound(text.status())) return absl::OkStatus();
    RETURN_IF_ERROR(text.status());
    std::istringstream in(*text);
    for (std::string row; std::getline(in, row);) {
      absl::StatusOr<IndexLine> line = ParseIndexLine(row);
      std::error_code error;
      if (!line.ok()) {
        LogWarning("dropped a line of the index", {{"file", dir + "/index.jsonl"}});
      } else if (fs::exists(dir + "/" + FramePath(line->key) + "/frame.json", error)) {
        const FrameId key = line->key;
        const absl::Status judged = JudgeAnew(variant.config().filters(), *line);
        if (!judged.ok()) return WithContext(judged, dir + "/index.jsonl");
        index_[variant.name()].insert_or_assign(key, *std::move(line));
      }
    }
    return absl::OkStatus();
  }

  // Whether `dir` holds exactly the manifest's files: the store's own inodes, or files of the right
  // hash. The index replaces the hash where no link to the store's file can be: a link to a former
  // file of the store may have rotted with it.
  static bool IsEqual(const std::string& dir, const std::string& source, const Content& content,
                      bool indexed) {
    const v1::FrameResult& frame = content.frame.frame();
    std::error_code error;
    const auto begin = fs::directory_iterator(dir, error);
    if (error || std::distance(begin, fs::directory_iterator()) != frame.files_size()) return false;
    for (const v1::FileEntry& file : frame.files()) {
      struct stat here {
      }, there{};
      const std::string path = dir + "/" + file.name();
      if (::lstat(path.c_str(), &here) != 0 || !S_ISREG(here.st_mode)) return false;
      if (here.st_size != file.size()) return false;
      if (content.made.contains(file.name())) continue;  // MadeBefore has compared its hash.
      const bool may_link =
          ::lstat((source + "/" + file.name()).c_str(), &there) == 0 && here.st_dev == there.st_dev;
      if (may_link ? here.st_ino == there.st_ino : indexed) continue;
      const absl::StatusOr<std::string> hash = Sha256HexOfFile(path);
      if (!hash.ok() || *hash != file.sha256()) return false;
    }
    return true;
  }

  absl::Status Materialise(const std::string& dir, const std::string& source,
                           const Content& content, bool replace) {
    const std::string parent = fs::path(dir).parent_path();
    const std::string name = fs::path(dir).filename();
    const std::string temporary = parent + "/.new-" + name, old = parent + "/.old-" + name;
    RETURN_IF_ERROR(MakeFolders(parent));
    RETURN_IF_ERROR(RemoveAll(temporary));  // An interrupted run may have left it.
    RETURN_IF_ERROR(RemoveAll(old));
    RETURN_IF_ERROR(MakeFolders(temporary));
    for (const v1::FileEntry& file : content.frame.frame().files()) {
      const std::string to = temporary + "/" + file.name();
      const auto made = content.made.find(file.name());
      const absl::Status status = made != content.made.end()
                                      ? WriteFile(to, made->second, /*sync=*/true)
                                      : BringFile(source + "/" + file.name(), to, file, replace);
      if (!status.ok()) {
        (void)RemoveAll(temporary).ok();  // The first error is what counts.
        return status;
      }
    }
    RETURN_IF_ERROR(SyncPath(temporary));
    if (replace) RETURN_IF_ERROR(Rename(dir, old));
    RETURN_IF_ERROR(Rename(temporary, dir));
    RETURN_IF_ERROR(SyncPath(parent));
    return replace ? RemoveAll(old) : absl::OkStatus();
  }

  // Links a file of the store, whose content is checked first if `check`, or copies it.
  absl::Status BringFile(const std::string& from, const std::string& to, const v1::FileEntry& file,
                         bool check) {
    struct stat info {};
    if (::lstat(from.c_str(), &info) != 0) return ErrnoError(errno, "store file " + from);
    if (!S_ISREG(info.st_mode) || info.st_size != file.size()) {
      return DataLoss("store file {}: {} bytes, its manifest says {}", from, info.st_size,
                      file.size());
    }
    const auto differs = [&from] {
      return DataLoss("store file {}: its content is not what its manifest says", from);
    };
    if (check) {
      ASSIGN_OR_RETURN(const std::string hash, Sha256HexOfFile(from));
      if (hash != file.sha256()) return differs();
    }
    if (::link(from.c_str(), to.c_str()) == 0) {
      ++totals_.files_linked;
      return absl::OkStatus();
    }
    if (errno != EXDEV && errno != EPERM && errno != EMLINK && errno != EOPNOTSUPP) {
      return ErrnoError(errno, "link " + to);
    }
    ASSIGN_OR_RETURN(const std::string bytes, ReadFile(from));
    if (Sha256Hex(bytes) != file.sha256()) return differs();
    ++totals_.files_copied;
    return WriteFile(to, bytes, /*sync=*/true);
  }

  const std::string out_;
  const v1::StudySpec study_;
  std::map<std::string, std::map<FrameId, IndexLine>> index_;  // By variant.
  mutable std::set<std::pair<std::string, uint32_t>> scenes_;  // Recipes that HasScene has read.
  std::vector<std::string> set_aside_;
  Totals totals_;
};

}  // namespace

absl::StatusOr<std::unique_ptr<ArchiveWriter>> ArchiveWriter::Open(const std::string& out_dir,
                                                                   const v1::StudySpec& study) {
  std::string out = fs::absolute(out_dir).lexically_normal();
  while (out.size() > 1 && out.back() == '/') out.pop_back();
  auto archive = std::make_unique<Archive>(out, study);
  RETURN_IF_ERROR(archive->Prepare());
  return archive;
}

}  // namespace parallax
