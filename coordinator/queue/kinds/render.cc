// Kind `render`: stereo pairs of one solved scene, by default all of them.
//
// Results: "frame" by frame key, one for each rig, so that jobs of other ranges of rigs share them.
#include <fmt/core.h>

#include <algorithm>

#include "common/base/status.h"
#include "common/config/frame_files.h"
#include "common/config/frame_notes.h"
#include "coordinator/queue/commands/report_check.h"
#include "coordinator/queue/database/compress.h"
#include "coordinator/queue/database/sqlite.h"
#include "coordinator/queue/job_kind.h"
#include "coordinator/queue/kinds/result_figures.h"
#include "coordinator/study/rigs.h"
#include "parallax/v1/jobs.pb.h"

namespace parallax {
namespace {

struct CheckedFrame {
  uint32_t rig = 0;
  std::string path;
  std::vector<std::string> files;  // Their names, sorted.
  std::string frame_z;
};
struct CheckedRender final : CheckedResult {
  std::vector<CheckedFrame> frames;  // By ascending rig.
};

std::string Joined(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name.substr(0, 40);
  return text.empty() ? "none" : text.substr(0, 400);
}

std::string WhyBadFrame(const v1::FrameResult& frame) {
  const std::string where = fmt::format("frame of rig {}", frame.rig());
  if (!IsConfinedPath(frame.path()))
    return where + ": path '" + frame.path() + "' leaves the store";
  for (const v1::FileEntry& file : frame.files()) {
    if (!IsConfinedPath(file.name())) {
      return where + ": file name '" + file.name() + "' leaves its folder";
    }
    if (file.size() < 0) return where + ": " + file.name() + " has a negative size";
    if (!IsSha256Hex(file.sha256())) {
      return where + ": " + file.name() + " has no SHA-256 of 64 lower-case hex digits";
    }
  }
  std::string why = WhyBadFigures("statistics", frame.statistics());
  if (why.empty()) why = WhyBadFigures("seconds of stages", frame.stage_s(), 0, kLongestS);
  if (!why.empty()) return where + ": " + why;
  return "";
}

class RenderKind final : public JobKind {
 public:
  RenderKind()
      : JobKind("render", {.stages = {"frame"},
                           .doing = "rendering",
                           .of_scene = true,
                           .has_output = true,
                           .can_split = true,
                           .keeps_group_warm = true,
                           .resumes = true}) {}

  // ---- Messages
  absl::StatusOr<std::string> Spec(const LeasedJob& lease, ResultReader& results) const override {
    v1::RenderJob spec;
    ASSIGN_OR_RETURN(const std::vector<uint32_t> rigs, ParseRigs(lease.job.rigs));
    spec.mutable_rigs()->Add(rigs.begin(), rigs.end());
    *spec.mutable_render() = lease.config->render();
    spec.set_picture_dir(lease.config->materials().picture_dir());
    for (const std::string& folder : lease.kept_folders) spec.add_earlier_folders(folder);
    *spec.mutable_include() = lease.config->assets().include();
    spec.set_texture_dir(lease.config->materials().texture_dir());
    spec.set_hdri_dir(lease.config->lighting().hdri_dir());
    ASSIGN_OR_RETURN(const std::string scene_z, results.ResultBytes(lease.job.group_key));
    RETURN_IF_ERROR(UnpackMessage(scene_z, *spec.mutable_scene()));
    return spec.SerializeAsString();
  }

  std::shared_ptr<const CheckedResult> CheckResult(std::string_view bytes) const override {
    auto out = std::make_shared<CheckedRender>();
    v1::RenderResult result;
    if (!result.ParseFromArray(bytes.data(), static_cast<int>(bytes.size()))) {
      out->invalid = "a result that is no RenderResult";
      return out;
    }
    for (const v1::FrameResult& frame : result.frames()) {
      out->invalid = WhyBadFrame(frame);
      if (!out->invalid.empty()) return out;
      out->paths.push_back(frame.path());
      std::vector<std::string> files;
      for (const v1::FileEntry& file : frame.files()) files.push_back(file.name());
      std::sort(files.begin(), files.end());
      out->frames.push_back({frame.rig(), frame.path(), std::move(files), PackMessage(frame)});
    }
    std::sort(out->frames.begin(), out->frames.end(),
              [](const CheckedFrame& a, const CheckedFrame& b) { return a.rig < b.rig; });
    return out;
  }

  std::vector<OutputFile> FilesOf(std::string_view bytes) const override {
    v1::RenderResult result;
    if (!result.ParseFromArray(bytes.data(), static_cast<int>(bytes.size()))) return {};
    std::vector<OutputFile> files;
    for (const v1::FrameResult& frame : result.frames()) {
      for (const v1::FileEntry& file : frame.files()) {
        files.push_back({frame.path() + "/" + file.name(), file.size(), file.sha256()});
      }
    }
    return files;
  }

  std::vector<StageSeconds> StagesOf(std::string_view bytes) const override {
    v1::RenderResult result;
    if (!result.ParseFromArray(bytes.data(), static_cast<int>(bytes.size()))) return {};
    std::vector<StageSeconds> stages = {{"build", result.build_s()}};
    for (const v1::FrameResult& frame : result.frames()) {
      for (const auto& [stage, seconds] : frame.stage_s()) stages.push_back({stage, seconds});
    }
    return stages;
  }

  // ---- Hooks
  absl::StatusOr<JobKeys> Keys(WorkDesk& desk, const JobFacts& job) const override {
    ASSIGN_OR_RETURN(const VariantFacts variant, desk.VariantOf(job.variant));
    ASSIGN_OR_RETURN(const Sha256Digest scene_hash, SceneHashOf(desk, job));
    return JobKeys{RenderKey(desk.versions(), *variant.digests, scene_hash, job.rigs), scene_hash};
  }

  // A frame fits every job of its scene that has its rig, however the rigs were divided then.
  absl::StatusOr<Sha256Digest> KeepKey(WorkDesk& desk, const JobFacts& job) const override {
    ASSIGN_OR_RETURN(const VariantFacts variant, desk.VariantOf(job.variant));
    ASSIGN_OR_RETURN(const Sha256Digest scene_hash, SceneHashOf(desk, job));
    return RenderKey(desk.versions(), *variant.digests, scene_hash, "");
  }

  absl::StatusOr<KnownWork> Look(WorkDesk& desk, const JobFacts& job) const override {
    KnownWork known;
    ASSIGN_OR_RETURN(const std::vector<FrameLink> frames, LinksOf(desk, job));
    for (const FrameLink& frame : frames) {
      ASSIGN_OR_RETURN(const bool has, desk.HasResult(frame.key));
      if (!has) return known;
    }
    known.state = KnownWork::State::kDone;
    return known;
  }

  // Frames that exist are published at once; if all do, the job stands for the record.
  absl::Status Trim(WorkDesk& desk, JobFacts& job) const override {
    ASSIGN_OR_RETURN(const std::vector<FrameLink> frames, LinksOf(desk, job));
    std::vector<FrameLink> reused;
    std::vector<uint32_t> left;
    for (const FrameLink& frame : frames) {
      ASSIGN_OR_RETURN(const bool has, desk.HasResult(frame.key));
      if (has) {
        reused.push_back({frame.rig, frame.key, /*reused=*/true});
      } else {
        left.push_back(frame.rig);
      }
    }
    // A retry keeps its predecessor's rigs, so that the two are known for the same work.
    if (reused.empty() || left.empty() || job.generation > 1) return absl::OkStatus();
    RETURN_IF_ERROR(desk.Publish(job, reused));
    job.rigs = RigsText(left);
    job.rig_count = static_cast<uint32_t>(left.size());
    return absl::OkStatus();
  }

  // Exactly the rigs that were asked for, and of each exactly the files of the maps asked for.
  absl::StatusOr<std::string> WhyNot(WorkDesk& desk, const JobFacts& job,
                                     const CheckedResult& result) const override {
    const std::vector<CheckedFrame>& frames = static_cast<const CheckedRender&>(result).frames;
    std::vector<uint32_t> rigs;
    for (const CheckedFrame& frame : frames) rigs.push_back(frame.rig);
    const auto wanted_rigs = ParseRigs(job.rigs);
    if (!wanted_rigs.ok() || rigs != *wanted_rigs) {
      return "frames of rigs '" + RigsText(rigs) + "', wanted exactly '" + job.rigs + "'";
    }
    ASSIGN_OR_RETURN(const VariantFacts variant, desk.VariantOf(job.variant));
    const v1::RenderConfig& render = variant.config->render();
    for (const CheckedFrame& frame : frames) {
      if (AreFrameFiles(frame.files, render)) continue;
      return fmt::format("frame of rig {}: files {}, wanted exactly {}", frame.rig,
                         Joined(frame.files), Joined(FrameFileNames(render)));
    }
    return std::string();
  }

  std::vector<OutputFile> StoredFiles(std::string_view stage,
                                      std::string_view bytes) const override {
    v1::FrameResult frame;
    if (stage != "frame" || !UnpackMessage(bytes, frame).ok()) return {};
    std::vector<OutputFile> files;
    for (const v1::FileEntry& file : frame.files()) {
      files.push_back({frame.path() + "/" + file.name(), file.size(), file.sha256()});
    }
    return files;
  }

  absl::StatusOr<Ending> Store(WorkDesk& desk, const JobFacts& job,
                               const CheckedResult& result) const override {
    const auto& render = static_cast<const CheckedRender&>(result);
    ASSIGN_OR_RETURN(std::vector<FrameLink> links, LinksOf(desk, job));
    for (size_t i = 0; i < links.size(); ++i) {
      const CheckedFrame& frame = render.frames[i];
      ASSIGN_OR_RETURN(const bool is_first,
                       desk.PutResult(job, "frame", links[i].key, {frame.frame_z, false, ""}));
      if (is_first) continue;
      links[i].reused = true;
      RETURN_IF_ERROR(desk.Discard(frame.path));
    }
    RETURN_IF_ERROR(desk.Publish(job, links));
    // A worker keeps notes of finished frames where more than one is to be made; nobody needs them
    // any more.
    if (job.rig_count > 1) RETURN_IF_ERROR(desk.Discard(NotesOf(render.frames.front().path)));
    return Ending();
  }

  absl::Status OnSuccess(WorkDesk& desk, const JobFacts& job, const Ending&,
                         bool by_own_attempt) const override {
    if (by_own_attempt) return absl::OkStatus();  // Published by Store.
    ASSIGN_OR_RETURN(std::vector<FrameLink> links, LinksOf(desk, job));
    for (FrameLink& link : links) link.reused = true;
    return desk.Publish(job, links);
  }

  // ---- Audit
  absl::Status Audit(SqliteConnection& db, std::vector<std::string>& violations) const override {
    SqliteQuery frames(db,
                       "SELECT r.work_key, r.bytes, r.fence, j.work_key FROM results AS r"
                       " LEFT JOIN all_jobs AS j ON j.id = r.job_id WHERE r.stage = 'frame'");
    ASSIGN_OR_RETURN(
        const auto litter,
        db.Integer("SELECT (SELECT count(*) FROM litter) + count(*) FROM kept_folders"));
    while (frames.Next()) {
      v1::FrameResult frame;
      const bool unpacked = UnpackMessage(frames.Blob(1), frame).ok();
      // If its job was forgotten, the attempt is known by the fence alone.
      const std::string prefix = frames.IsNull(3)
                                     ? frame.path().substr(0, StorePrefixOf(Sha256Digest{}).size())
                                     : StorePrefixOf(frames.Digest(3));
      const std::string folder =
          fmt::format("{}/.attempt-{}/", prefix, static_cast<uint64_t>(frames.Int(2)));
      if (!unpacked || frame.path().compare(0, folder.size(), folder) != 0) {
        violations.push_back("a frame lies in the winner's folder: not " + HexOf(frames.Digest(0)));
      }
      if (litter.value_or(0) == 0) continue;
      for (const std::string& path : {frame.path(), folder.substr(0, folder.size() - 1)}) {
        ASSIGN_OR_RETURN(const auto found,
                         db.Integer("SELECT 1 FROM litter WHERE path = ?1"
                                    " UNION ALL SELECT 1 FROM kept_folders WHERE path = ?1",
                                    path));
        if (found) violations.push_back("a published frame is not litter: not " + path);
      }
    }
    return frames.status();
  }

 private:
  // Once a job is in the table, its group is its scene.
  static absl::StatusOr<Sha256Digest> SceneHashOf(WorkDesk& desk, const JobFacts& job) {
    if (job.group_key != Sha256Digest{}) return job.group_key;
    ASSIGN_OR_RETURN(const SceneFacts scene, desk.SceneOf(job.variant, job.ordinal));
    if (scene.scene_hash) return *scene.scene_hash;
    return Internal("scene {} is not solved", job.ordinal);
  }

  // The notes' folder of a frame's attempt: "ab/ab12.../.attempt-7/finished".
  static std::string NotesOf(const std::string& frame_path) {
    const size_t attempt = frame_path.find("/.attempt-");
    return frame_path.substr(0, frame_path.find('/', attempt + 1)) + "/" + kFrameNotes;
  }

  static absl::StatusOr<std::vector<FrameLink>> LinksOf(WorkDesk& desk, const JobFacts& job) {
    ASSIGN_OR_RETURN(const VariantFacts variant, desk.VariantOf(job.variant));
    ASSIGN_OR_RETURN(const Sha256Digest scene_hash, SceneHashOf(desk, job));
    ASSIGN_OR_RETURN(const std::vector<uint32_t> rigs, ParseRigs(job.rigs));
    std::vector<FrameLink> links;
    links.reserve(rigs.size());
    for (const uint32_t rig : rigs) {
      links.push_back({rig, FrameKey(desk.versions(), *variant.digests, scene_hash, rig)});
    }
    return links;
  }
};

}  // namespace

std::unique_ptr<JobKind> MakeRenderKind() { return std::make_unique<RenderKind>(); }

}  // namespace parallax
