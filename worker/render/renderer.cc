#include "worker/render/renderer.h"

#include <fmt/core.h>

#include <algorithm>
#include <map>

#include "common/base/seconds.h"
#include "common/base/system/memory_budget.h"
#include "common/config/frame_maps.h"
#include "common/math/proto.h"
#include "worker/render/passes/pass.h"

namespace parallax {
namespace {

// Returns whether a pass makes pictures, ground truth or a map that the config asks for: those two
// are always made, because passes and statistics read them.
bool IsWanted(const Pass& pass, const v1::RenderConfig& config) {
  if (pass.name == "truth" || pass.name == "film") return true;
  const auto maps = FrameMaps();
  return std::any_of(maps.begin(), maps.end(), [&](const FrameMap& row) {
    return row.pass == pass.name && row.IsIn(config);
  });
}

class SceneRenderer final : public Renderer {
 public:
  SceneRenderer(const v1::Scene& scene, const v1::RenderConfig& config,
                const RenderProfile& profile, std::unique_ptr<RenderScene> geometry,
                LightTable lights, std::optional<Rasteriser> rasteriser,
                std::unique_ptr<Denoiser> denoiser)
      : scene_(scene, profile, std::move(geometry), std::move(lights), std::move(rasteriser),
               std::move(denoiser)) {
    for (const Pass* pass : Passes()) {
      if (IsWanted(*pass, config)) passes_.push_back(pass);
    }
    for (int i = 0; i < scene.keyframes_size(); ++i) {
      keyframes_.emplace(scene.rigs(i).index(), scene.keyframes(i));
    }
    if (!keyframes_.empty()) {
      lit_recipe_ = scene;
      lit_recipe_.clear_keyframes();
    }
  }

  absl::StatusOr<StereoFrame> RenderRig(const v1::Rig& rig, const CancelToken& cancel,
                                        const ProgressFn& progress) override {
    try {
      RETURN_IF_ERROR(Enter(rig));
      return Render(rig, cancel, progress);
    } catch (const std::bad_alloc&) {
      return ResourceExhausted("render: rig {} does not fit in memory", rig.index());
    }
  }

 private:
  // In dense scenes, moves everything to the rig's keyframe. Meshes, their acceleration structures
  // and materials are those of the scene.
  absl::Status Enter(const v1::Rig& rig) {
    if (keyframes_.empty()) return scene_.moving.MoveTo(rig.time_s());
    const auto found = keyframes_.find(rig.index());
    if (found == keyframes_.end()) {
      return InvalidArgument("rig {} has no keyframe", rig.index());
    }
    const v1::Keyframe& keyframe = found->second;
    const int count = keyframe.world_from_object_size() / 8;
    std::vector<Eigen::Affine3f> places;
    for (int i = 0; i < count; ++i) places.push_back(KeyframePose(keyframe, i).Affine());
    RETURN_IF_ERROR(scene_.geometry->Move(places));
    *lit_recipe_.mutable_lights() = keyframe.lights();
    *lit_recipe_.mutable_sky() = keyframe.sky();
    ASSIGN_OR_RETURN(scene_.lights, LightTable::Build(lit_recipe_, *scene_.geometry));
    return absl::OkStatus();
  }

  absl::StatusOr<StereoFrame> Render(const v1::Rig& rig, const CancelToken& cancel,
                                     const ProgressFn& progress) {
    ASSIGN_OR_RETURN(const StereoCamera stereo, StereoCamera::FromRig(rig));
    std::vector<const Pass*> passes;
    int64_t bytes_per_pixel = 0, traced = 0;
    for (const Pass* pass : passes_) {
      if (pass->applies && !pass->applies(rig)) continue;
      passes.push_back(pass);
      bytes_per_pixel += pass->bytes_per_pixel;
      if (pass->pixels) traced += pass->pixels(rig);
    }
    RETURN_IF_ERROR(CheckMemory(fmt::format("render: images of rig {}", rig.index()),
                                bytes_per_pixel * rig.width_px() * rig.height_px()));
    const Pairing pairing = scene_.book.PairingOf(rig);
    const std::string eye_key = LeftEyeKey(rig, pairing);
    const auto& left = scene_.kept_left;
    const KeptLeft* kept = pairing.shared() && left && left->eye == eye_key ? &*left : nullptr;
    if (kept) traced -= int64_t{rig.width_px()} * rig.height_px();
    Shot shot{rig,     stereo, pairing,
              eye_key, kept,   TraceMeter(progress, static_cast<double>(traced)),
              {},      0};
    for (const Pass* pass : passes) {
      const SteadyTime start = Clock::System().Steady();
      RETURN_IF_ERROR(pass->run(scene_, shot, cancel));
      if (pass->seconds) {
        shot.frame.*pass->seconds += SecondsSince(start);
      }
    }
    if (progress) progress(1.0);
    return std::move(shot.frame);
  }

  PassScene scene_;
  std::vector<const Pass*> passes_;             // The passes that the config asks for.
  std::map<uint32_t, v1::Keyframe> keyframes_;  // By rig index; none unless the scene has them.
  v1::Scene lit_recipe_;  // Used by keyframes: the recipe, lit by one of them.
};

absl::Status CheckKeyframes(const v1::Scene& scene) {
  if (scene.keyframes().empty()) return absl::OkStatus();
  bool whole = scene.keyframes_size() == scene.rigs_size();
  for (const v1::Keyframe& keyframe : scene.keyframes()) {
    whole = whole && keyframe.world_from_object_size() == 8 * scene.objects_size();
  }
  if (whole) return absl::OkStatus();
  return InvalidArgument("scene: keyframes that do not fit its rigs or objects");
}

// A film has a bit for each right eye of its left one.
absl::Status CheckPartners(const v1::Scene& scene) {
  int partners = 0;
  for (const v1::Rig& rig : scene.rigs()) {
    partners = rig.shares_left() ? partners + 1 : 1;
    if (partners <= kMostPartners) continue;
    return InvalidArgument("scene: rig {} makes {} right eyes of one left eye, allowed are {}",
                           rig.index(), partners, kMostPartners);
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<std::unique_ptr<Renderer>> Renderer::Create(const v1::Scene& scene,
                                                           SceneGeometry geometry,
                                                           const v1::RenderConfig& config,
                                                           int64_t most_paths) {
  try {
    ASSIGN_OR_RETURN(RenderProfile profile, ResolveProfile(config));
    profile.cache_paths = std::min(profile.cache_paths, most_paths);
    RETURN_IF_ERROR(CheckKeyframes(scene));
    RETURN_IF_ERROR(CheckPartners(scene));
    std::vector<bool> movers = MoversOf(scene, geometry);
    ASSIGN_OR_RETURN(std::unique_ptr<RenderScene> built,
                     RenderScene::Build(std::move(geometry), 0, std::move(movers)));
    ASSIGN_OR_RETURN(LightTable lights, LightTable::Build(scene, *built));
    std::optional<Rasteriser> rasteriser;
    if (FilmTracer::NeedsRasteriser(profile)) {
      ASSIGN_OR_RETURN(rasteriser, Rasteriser::Create(*built));
    }
    // Pictures of open land have all samples of the rasteriser, and gain nothing from the larger
    // network.
    if (profile.denoise == DenoiseQuality::kBalanced &&
        IsOpenLand(scene, profile, *built, lights)) {
      profile.denoise = DenoiseQuality::kFast;
    }
    std::unique_ptr<Denoiser> denoiser;
    if (profile.denoise != DenoiseQuality::kOff) {
      ASSIGN_OR_RETURN(denoiser, Denoiser::Create(profile.denoise));
    }
    return std::unique_ptr<Renderer>(new SceneRenderer(scene, config, profile, std::move(built),
                                                       std::move(lights), std::move(rasteriser),
                                                       std::move(denoiser)));
  } catch (const std::bad_alloc&) {
    return ResourceExhausted("render: scene does not fit in memory");
  }
}

}  // namespace parallax
