#include "coordinator/client/preview/study_preview.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <new>
#include <utility>

#include "common/base/edit_distance.h"
#include "common/base/hash.h"
#include "common/base/names.h"
#include "common/base/system/sought_files.h"
#include "common/config/config.h"
#include "common/config/content_folders.h"
#include "coordinator/client/content/study_options.h"
#include "coordinator/client/views/text.h"
#include "coordinator/study/keys.h"
#include "parallax/v1/jobs.pb.h"
#include "worker/dataset/frame/sensor_stage.h"
#include "worker/render/renderer.h"
#include "worker/scene/build_geometry.h"
#include "worker/scene/own_content.h"
#include "worker/scene/scene_pictures.h"
#include "worker/scene/solve_scene.h"

namespace parallax::client {
// Types of members, which must not be of an unnamed namespace.
namespace preview_internal {

// A layout or a scene, or why its seed has none.
template <typename Message>
struct Solved {
  std::shared_ptr<const Message> made;
  std::string rejected;
};

// Results by key: of the last preview, and of the one that is being made.
template <typename Value>
class ByKey {
 public:
  const Value* Find(const std::string& key) {
    if (const auto found = now_.find(key); found != now_.end()) return &found->second;
    const auto found = last_.find(key);
    return found == last_.end() ? nullptr : &now_.emplace(key, found->second).first->second;
  }
  void Add(const std::string& key, Value value) { now_.insert_or_assign(key, std::move(value)); }
  // Forgets what the last preview did not ask for. One that was cancelled has not asked for all.
  void Begin() {
    now_.merge(last_);
    last_ = std::exchange(now_, {});
  }
  void Forget() { last_.clear(); }

 private:
  std::map<std::string, Value> now_, last_;
};

// A variant on its way to its pair.
struct PreviewEntry {
  const v1::VariantSpec* variant = nullptr;
  ConfigDigests digests;
  SceneSeed seed;
  std::string layout_key, scene_key;
  Solved<v1::Scene> solved;
};

}  // namespace preview_internal

namespace {

using preview_internal::ByKey;
using preview_internal::PreviewEntry;
using preview_internal::Solved;

constexpr uint32_t kMostSeeds = 5;  // A variant tries so many seeds that are rejected.
// Paths that learn a scene's light for a pair of this size; a dataset has 500,000 and more pixels.
constexpr int64_t kMostPaths = 60'000;

absl::StatusOr<v1::StudySpec> LoadAsStudy(const PreviewOptions& options) {
  ASSIGN_OR_RETURN(const bool is_study, IsStudy(options.file));
  if (is_study) {
    StudyOptions study;
    study.study = options.file;
    study.seed = options.seed;
    study.takes_endless = study.takes_search = true;
    return ResolveStudy(study);
  }
  v1::StudySpec study;
  v1::VariantSpec& variant = *study.add_variants();
  ASSIGN_OR_RETURN(*variant.mutable_config(), LoadSceneConfig(options.file));
  variant.set_name(std::filesystem::path(options.file).stem());
  study.set_name(variant.name());
  study.set_seed(options.seed.value_or(1));
  return study;
}

// Reads the file and tells `watcher` on which files the result, or the error, depends.
absl::StatusOr<v1::StudySpec> LoadWatched(const PreviewOptions& options,
                                          const PreviewWatcher& watcher) {
  const SoughtFiles sought;
  absl::StatusOr<v1::StudySpec> study = LoadAsStudy(options);
  std::vector<std::string> paths(sought.paths().begin(), sought.paths().end());
  if (study.ok()) {
    for (v1::VariantSpec& variant : *study->mutable_variants()) {
      for (const std::string* folder : ContentFoldersOf(*variant.mutable_config())) {
        paths.push_back(FromRoot(*folder));
      }
    }
  }
  if (watcher.files) watcher.files(paths);
  return study;
}

// Removes the variants that are not shown from the study, and returns their names. Errors:
// kInvalidArgument for an unknown name.
absl::StatusOr<std::vector<std::string>> ChooseVariants(const PreviewOptions& options,
                                                        v1::StudySpec& study) {
  std::vector<std::string> known;
  for (const v1::VariantSpec& variant : study.variants()) known.push_back(variant.name());
  for (const std::string& name : options.variants) {
    if (std::find(known.begin(), known.end(), name) != known.end()) continue;
    return InvalidArgument("--variants: {} has no variant {}{}; it has {}", options.file,
                           Quoted(name), NearestHint(name, known), fmt::join(known, ", "));
  }
  std::vector<std::string> left_out;
  google::protobuf::RepeatedPtrField<v1::VariantSpec> shown;
  for (v1::VariantSpec& variant : *study.mutable_variants()) {
    const auto& chosen = options.variants;
    const bool show = chosen.empty()
                          ? shown.size() < kMostPreviewed && !variant.heldout()
                          : std::find(chosen.begin(), chosen.end(), variant.name()) != chosen.end();
    if (show) {
      *shown.Add() = std::move(variant);
    } else {
      left_out.push_back(variant.name());
    }
  }
  study.mutable_variants()->Swap(&shown);
  return left_out;
}

// Does `work` for 0 to `count` - 1 on all cores. Returns the first error by number.
absl::Status ForAll(size_t count, const std::function<absl::Status(size_t)>& work) {
  std::vector<absl::Status> done(count);
  tbb::parallel_for(size_t{0}, count, [&](size_t i) { done[i] = work(i); });
  for (const absl::Status& status : done) RETURN_IF_ERROR(status);
  return absl::OkStatus();
}

// The pictures of profile `preview` without maps that nobody sees.
v1::RenderConfig SmallRender(const v1::Rig& rig) {
  v1::RenderConfig render = DefaultSceneConfig().render();
  render.set_profile("preview");
  render.clear_maps();
  if (rig.has_raw_left()) render.add_maps("raw");
  return render;
}

// The recipe with its first rig alone, which is `small`.
v1::Scene WithRig(const v1::Scene& scene, const v1::Rig& small) {
  v1::Scene one = scene;
  one.mutable_rigs()->Clear();
  *one.add_rigs() = small;
  if (one.keyframes_size() > 1) {
    one.mutable_keyframes()->DeleteSubrange(1, one.keyframes_size() - 1);
  }
  return one;
}

absl::StatusOr<StereoFrame> RenderSmall(const v1::SceneConfig& config, const v1::Scene& scene,
                                        const v1::Rig& small, const CancelToken& cancel) {
  v1::RenderJob job;
  *job.mutable_scene() = scene;
  *job.mutable_include() = config.assets().include();
  job.set_texture_dir(config.materials().texture_dir());
  job.set_hdri_dir(config.lighting().hdri_dir());
  try {
    RETURN_IF_ERROR(LocatePictures(config.materials().picture_dir(), *job.mutable_scene()));
    RETURN_IF_ERROR(LocateOwnContent(job));
    // All rigs decide what grows in a landscape; only one is rendered.
    ASSIGN_OR_RETURN(SceneGeometry geometry, BuildSceneGeometry(job.scene()));
    if (cancel.cancelled()) return Cancelled("preview");
    ASSIGN_OR_RETURN(const auto renderer,
                     Renderer::Create(WithRig(job.scene(), small), std::move(geometry),
                                      SmallRender(small), kMostPaths));
    return renderer->RenderRig(small, cancel, {});
  } catch (const std::bad_alloc&) {
    return ResourceExhausted("not enough memory to render the scene");
  }
}

}  // namespace

struct StudyPreview::Kept {
  ByKey<Solved<v1::Layout>> layouts;
  ByKey<Solved<v1::Scene>> scenes;
  ByKey<std::shared_ptr<const StereoFrame>> frames;
};

// One preview while it is made.
class StudyPreview::Maker {
 public:
  Maker(const v1::StudySpec& study, const PreviewWatcher& watcher, Kept& kept)
      : study_(study), watcher_(watcher), kept_(kept) {}

  absl::StatusOr<std::vector<PreviewRow>> Make() {
    for (const v1::VariantSpec& variant : study_.variants()) {
      entries_.push_back({.variant = &variant, .digests = DigestsOf(variant.config())});
    }
    RETURN_IF_ERROR(SolveEntries());
    std::vector<PreviewRow> rows;
    for (size_t i = 0; i < entries_.size(); ++i) {
      const PreviewEntry& entry = entries_[i];
      const std::string& name = entry.variant->name();
      rows.push_back({.name = name});
      if (!entry.solved.made) {
        rows.back().note = fmt::format("no scene among the first {} seeds: {}", kMostSeeds,
                                       FirstLine(entry.solved.rejected));
        continue;
      }
      Tell(fmt::format("rendering {} ({} of {})", name, i + 1, entries_.size()));
      absl::StatusOr<PreviewRow> row = RowOf(entry);
      if (!row.ok()) return WithContext(row.status(), "variant " + name);
      rows.back() = *std::move(row);
    }
    return rows;
  }

 private:
  void Tell(const std::string& stage) const {
    if (watcher_.stage) watcher_.stage(stage);
  }

  // ---- Scenes
  // Gives each variant its first scene: seeds without one are followed by the next, as in a run.
  absl::Status SolveEntries() {
    std::vector<PreviewEntry*> open;
    for (PreviewEntry& entry : entries_) open.push_back(&entry);
    for (uint32_t ordinal = 0; ordinal < kMostSeeds && !open.empty(); ++ordinal) {
      for (PreviewEntry* entry : open) {
        const uint64_t seed = entry->variant->seed() ? entry->variant->seed() : study_.seed();
        entry->seed = SceneSeedOf(seed, ordinal);
        entry->layout_key = HexOf(LayoutKey({}, entry->digests, entry->seed));
        entry->scene_key = HexOf(SceneKey({}, entry->digests, entry->seed));
      }
      RETURN_IF_ERROR(SolveOpen(open));
      std::erase_if(open, [&](PreviewEntry* entry) {
        entry->solved = *kept_.scenes.Find(entry->scene_key);
        return entry->solved.made != nullptr;
      });
    }
    return absl::OkStatus();
  }

  // One entry for each key that has no result yet.
  template <typename Value>
  static std::vector<PreviewEntry*> Missing(const std::vector<PreviewEntry*>& entries,
                                            const std::string PreviewEntry::*key,
                                            ByKey<Value>& results) {
    std::map<std::string, PreviewEntry*> missing;
    for (PreviewEntry* entry : entries) {
      if (!results.Find(entry->*key)) missing.emplace(entry->*key, entry);
    }
    std::vector<PreviewEntry*> first;
    for (PreviewEntry* entry : entries) {
      const auto found = missing.find(entry->*key);
      if (found != missing.end() && found->second == entry) first.push_back(entry);
    }
    return first;
  }

  // Variants that share a layout share its solve: first those that make one, then the others.
  absl::Status SolveOpen(const std::vector<PreviewEntry*>& open) {
    RETURN_IF_ERROR(SolveTogether(Missing(open, &PreviewEntry::layout_key, kept_.layouts)));
    return SolveTogether(Missing(open, &PreviewEntry::scene_key, kept_.scenes));
  }

  absl::Status SolveTogether(const std::vector<PreviewEntry*>& entries) {
    if (entries.empty()) return absl::OkStatus();
    Tell("solving " + Plural(static_cast<int64_t>(entries.size()), "scene"));
    std::vector<v1::SolveResult> results(entries.size());
    std::vector<const Solved<v1::Layout>*> layouts;
    for (const PreviewEntry* entry : entries) {
      layouts.push_back(kept_.layouts.Find(entry->layout_key));
    }
    RETURN_IF_ERROR(ForAll(entries.size(), [&](size_t i) -> absl::Status {
      v1::SolveJob job;
      job.set_scene_seed(entries[i]->seed.value);
      *job.mutable_config() = entries[i]->variant->config();
      if (layouts[i] && !layouts[i]->made) {
        results[i].mutable_rejected()->set_reason(layouts[i]->rejected);
        return absl::OkStatus();
      }
      if (layouts[i]) *job.mutable_layout() = *layouts[i]->made;
      absl::StatusOr<v1::SolveResult> result = Solve(job, watcher_.cancel);
      if (!result.ok()) {
        return WithContext(result.status(), "variant " + entries[i]->variant->name());
      }
      results[i] = *std::move(result);
      return absl::OkStatus();
    }));
    for (size_t i = 0; i < entries.size(); ++i) Keep(*entries[i], std::move(results[i]));
    return absl::OkStatus();
  }

  void Keep(const PreviewEntry& entry, v1::SolveResult result) {
    const std::string& rejected = result.rejected().reason();
    if (!kept_.layouts.Find(entry.layout_key)) {
      Solved<v1::Layout> layout{nullptr, rejected};
      if (result.has_layout()) {
        layout.made = std::make_shared<v1::Layout>(std::move(*result.mutable_layout()));
      }
      kept_.layouts.Add(entry.layout_key, std::move(layout));
    }
    Solved<v1::Scene> scene{nullptr, rejected};
    if (result.has_scene()) {
      scene.made = std::make_shared<v1::Scene>(std::move(*result.mutable_scene()));
    }
    kept_.scenes.Add(entry.scene_key, std::move(scene));
  }

  // ---- Pictures
  absl::StatusOr<std::shared_ptr<const StereoFrame>> FrameOf(const PreviewEntry& entry,
                                                             const std::string& key,
                                                             const v1::Rig& small) {
    if (const auto* kept = kept_.frames.Find(key)) return *kept;
    ASSIGN_OR_RETURN(StereoFrame frame, RenderSmall(entry.variant->config(), *entry.solved.made,
                                                    small, watcher_.cancel));
    auto shared = std::make_shared<const StereoFrame>(std::move(frame));
    kept_.frames.Add(key, shared);
    return shared;
  }

  absl::StatusOr<PreviewRow> RowOf(const PreviewEntry& entry) {
    const v1::SceneConfig& config = entry.variant->config();
    auto pair = std::make_shared<PreviewPair>();
    pair->rig = entry.solved.made->rigs(0);
    const v1::Rig small = SmallRig(pair->rig, kPreviewWidth_px, kPreviewHeight_px);
    const std::string key = Sha256Hex(DeterministicBytes(*entry.solved.made));
    ASSIGN_OR_RETURN(const auto frame, FrameOf(entry, key, small));
    const double scale = static_cast<double>(small.width_px()) / pair->rig.width_px();
    pair->left = frame->left.color;
    pair->right = frame->right.color;
    if (SensorIsOn(config.sensor())) {
      v1::Scene all = *entry.solved.made;  // A rig moves as its neighbours say.
      *all.mutable_rigs(0) = small;
      ASSIGN_OR_RETURN(SensorPictures taken,
                       TakeSensor(config.sensor(), all, small, *frame, scale));
      pair->left = std::move(taken.left);
      pair->right = std::move(taken.right);
    }
    pair->disparity_px = frame->left.disparity_px;
    for (float& value : pair->disparity_px.values()) value /= static_cast<float>(scale);
    pair->disparities = FiguresOf(pair->disparity_px);
    if (pair->rig.has_raw_left()) {
      pair->raw_left = frame->raw_left.color;
      pair->raw_right = frame->raw_right.color;
      pair->rows = RowsOf(pair->rig, small, frame->raw_left);
    }
    PreviewRow row{entry.variant->name(), pair, ""};
    if (!SensorIsOn(config.sensor())) {
      const auto [same, first] = rendered_.emplace(key, row.name);
      if (!first) row.note = "the same pair as " + same->second;
    }
    return row;
  }

  const v1::StudySpec& study_;
  const PreviewWatcher& watcher_;
  Kept& kept_;
  std::vector<PreviewEntry> entries_;
  std::map<std::string, std::string> rendered_;  // The first variant of each frame.
};

StudyPreview::StudyPreview() : kept_(std::make_unique<Kept>()) {}
StudyPreview::~StudyPreview() = default;

absl::StatusOr<Preview> StudyPreview::Make(const PreviewOptions& options,
                                           const PreviewWatcher& watcher) {
  ASSIGN_OR_RETURN(v1::StudySpec study, LoadWatched(options, watcher));
  study.clear_evaluate();  // Benchmarks are not looked at.
  Preview preview{.name = study.name(), .seed = study.seed()};
  ASSIGN_OR_RETURN(preview.left_out, ChooseVariants(options, study));
  RETURN_IF_ERROR(HashContent(study, FolderReaders::kOfRun));
  kept_->layouts.Begin();
  kept_->scenes.Begin();
  kept_->frames.Begin();
  ASSIGN_OR_RETURN(preview.rows, Maker(study, watcher, *kept_).Make());
  kept_->layouts.Forget();
  kept_->scenes.Forget();
  kept_->frames.Forget();
  return preview;
}

}  // namespace parallax::client
