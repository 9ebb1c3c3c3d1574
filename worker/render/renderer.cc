#include "worker/render/renderer.h"

#include <fmt/core.h>

#include <algorithm>
#include <map>
#include <optional>

#include "common/base/seconds.h"
#include "common/base/system/clock.h"
#include "common/base/system/memory_budget.h"
#include "common/math/proto.h"
#include "worker/render/film/denoiser.h"
#include "worker/render/film/exposure.h"
#include "worker/render/film/film_tracer.h"
#include "worker/render/film/overexposed.h"
#include "worker/render/film/pairing.h"
#include "worker/render/lights/light_table.h"
#include "worker/render/paths/cache_fill.h"
#include "worker/render/paths/profiles.h"
#include "worker/render/scene/moving_scene.h"
#include "worker/render/scene/render_scene.h"
#include "worker/render/truth/ground_truth.h"
#include "worker/render/truth/infrared.h"
#include "worker/render/truth/optical_flow.h"
#include "worker/render/truth/raw_pair.h"

namespace parallax {
namespace {

constexpr int kBytesPerPixel = 400;  // Both eyes' films and maps, the denoiser's buffers.
constexpr int kFlowBytesPerPixel = 52;

bool HasMap(const v1::RenderConfig& config, const char* map) {
  return std::find(config.maps().begin(), config.maps().end(), map) != config.maps().end();
}

class SceneRenderer final : public Renderer {
 public:
  SceneRenderer(uint64_t scene_seed, const v1::Scene& scene, RenderProfile profile,
                const v1::RenderConfig& config, std::unique_ptr<RenderScene> geometry,
                LightTable lights, std::unique_ptr<Denoiser> denoiser)
      : scene_seed_(scene_seed),
        book_(scene),
        profile_(profile),
        with_raw_(HasMap(config, "raw")),
        with_flow_(HasMap(config, "flow")),
        with_infrared_(HasMap(config, "infrared")),
        with_exact_occlusion_(HasMap(config, "exact_occlusion")),
        geometry_(std::move(geometry)),
        moving_(scene, geometry_.get()),
        lights_(std::move(lights)),
        denoiser_(std::move(denoiser)) {
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
    if (keyframes_.empty()) return moving_.MoveTo(rig.time_s());
    const auto found = keyframes_.find(rig.index());
    if (found == keyframes_.end()) {
      return InvalidArgument("rig {} has no keyframe", rig.index());
    }
    const v1::Keyframe& keyframe = found->second;
    const int count = keyframe.world_from_object_size() / 8;
    std::vector<Eigen::Affine3f> places;
    for (int i = 0; i < count; ++i) places.push_back(KeyframePose(keyframe, i).Affine());
    RETURN_IF_ERROR(geometry_->Move(places));
    *lit_recipe_.mutable_lights() = keyframe.lights();
    *lit_recipe_.mutable_sky() = keyframe.sky();
    ASSIGN_OR_RETURN(lights_, LightTable::Build(lit_recipe_, *geometry_));
    return absl::OkStatus();
  }

  // A pair that is being rendered.
  struct Shot {
    const v1::Rig& rig;
    const StereoCamera stereo;
    const Pairing pairing;
    const std::string eye_key;
    const KeptLeft* kept;  // The left eye, if it has been rendered for another rig; else null.
    TraceMeter meter;
    StereoFrame frame;
    float clamp = 0;
    std::optional<Film> films[2];

    int first_eye() const { return kept ? 1 : 0; }
    View& view(int eye) { return eye == 0 ? frame.left : frame.right; }
  };

  absl::StatusOr<StereoFrame> Render(const v1::Rig& rig, const CancelToken& cancel,
                                     const ProgressFn& progress) {
    ASSIGN_OR_RETURN(const StereoCamera stereo, StereoCamera::FromRig(rig));
    RETURN_IF_ERROR(CheckMemory(fmt::format("render: images of rig {}", rig.index()),
                                int64_t{kBytesPerPixel + (with_flow_ ? kFlowBytesPerPixel : 0)} *
                                    rig.width_px() * rig.height_px()));
    const Pairing pairing = book_.PairingOf(rig);
    const std::string eye_key = LeftEyeKey(rig, pairing);
    const KeptLeft* kept =
        pairing.shared() && kept_left_ && kept_left_->eye == eye_key ? &*kept_left_ : nullptr;
    const bool with_raw = with_raw_ && rig.has_raw_left();
    const double films = (with_raw ? 4.0 : 2.0) - (kept ? 1 : 0);
    Shot shot{rig,     stereo, pairing,
              eye_key, kept,   TraceMeter(progress, films * rig.width_px() * rig.height_px()),
              {},      0,      {}};
    StereoFrame& frame = shot.frame;
    RETURN_IF_ERROR(Timed(&frame.truth_s, [&] { return TraceTruth(shot, cancel); }));
    RETURN_IF_ERROR(Timed(&frame.cache_s, [&] { return FillCache(cancel); }));
    RETURN_IF_ERROR(Timed(&frame.trace_s, [&] { return TraceFilms(shot, cancel); }));
    const ImageU8 unmixed = MarkMixed(shot);
    RETURN_IF_ERROR(Timed(&frame.denoise_s, [&] { return Develop(shot, cancel); }));
    if (pairing.shared() && !kept) {
      kept_left_ = {eye_key, frame.left, std::move(shot.films[0]->ambiguous), frame.exposure,
                    shot.clamp};
      kept_left_->view.masks = unmixed;
    }
    if (with_infrared_) {
      // A left eye that several rigs share has one picture.
      const SampleStream streams[2] = {StreamOf(pairing.leader, 0, 5), StreamOf(rig, 1, 5)};
      RETURN_IF_ERROR(Timed(&frame.trace_s, [&] {
        return RenderInfrared(*geometry_, stereo, rig, streams, pairing.shared(), cancel, &frame);
      }));
    }
    if (with_raw) {
      RETURN_IF_ERROR(Timed(&frame.trace_s, [&] { return RenderRaw(shot, cancel); }));
    }
    if (progress) progress(1.0);
    return std::move(frame);
  }

  // Runs one stage of a pair and adds its seconds.
  template <typename Stage>
  static absl::Status Timed(double* seconds, const Stage& stage) {
    const SteadyTime start = Clock::System().Steady();
    RETURN_IF_ERROR(stage());
    *seconds += SecondsSince(start);
    return absl::OkStatus();
  }

  absl::Status TraceTruth(Shot& shot, const CancelToken& cancel) {
    for (int eye = 0; eye < 2; ++eye) {
      const PinholeCamera& camera = shot.stereo.eyes[eye];
      View& view = shot.view(eye);
      if (eye == 0 && shot.kept) {
        view = shot.kept->view;
        view.disparity_px = DisparityOf(view.depth_m, camera.fx_px * shot.stereo.baseline_m);
        continue;
      }
      RETURN_IF_ERROR(TraceGroundTruth(*geometry_, camera, shot.stereo.baseline_m, cancel, &view));
      MarkVeiled(lights_.haze(), camera, &view);
    }
    MarkOcclusion(&shot.frame.left, &shot.frame.right);
    if (with_exact_occlusion_) {
      RETURN_IF_ERROR(TraceOcclusion(*geometry_, shot.stereo, cancel, &shot.frame));
    }
    if (!with_flow_) return absl::OkStatus();
    return TraceFlow(book_, shot.rig, shot.kept ? &shot.kept->view : nullptr, *geometry_, moving_,
                     cancel, &shot.frame);
  }

  // Traces the films of both eyes, or of the right one alone, and chooses the exposure.
  absl::Status TraceFilms(Shot& shot, const CancelToken& cancel) const {
    ASSIGN_OR_RETURN(shot.clamp, ClampOf(shot.pairing, shot.kept));
    const FilmTracer tracer = Tracer();
    const auto stream = [&](int eye, uint32_t pass) {
      return StreamOf(eye == 0 ? shot.pairing.leader : shot.rig, eye, pass);
    };
    for (int eye = shot.first_eye(); eye < 2; ++eye) {
      const PinholeCamera& camera = shot.stereo.eyes[eye];
      Film& film = shot.films[eye].emplace(camera);
      tracer.TraceEye(camera, stream(eye, 0), TruthOf(shot, eye), shot.clamp, cancel, &shot.meter,
                      &film);
      if (cancel.cancelled()) return Cancelled("render: cancelled");
      tracer.TraceGuides(camera, stream(eye, 4), cancel, &shot.meter, &film);
      if (cancel.cancelled()) return Cancelled("render: cancelled");
    }
    shot.frame.exposure = shot.kept ? shot.kept->exposure : ExposureOf(shot);
    for (int eye = shot.first_eye(); eye < 2; ++eye) {
      tracer.TraceEdges(shot.stereo.eyes[eye], stream(eye, 3), shot.clamp, shot.frame.exposure,
                        cancel, &shot.meter, &*shot.films[eye]);
      if (cancel.cancelled()) return Cancelled("render: cancelled");
    }
    shot.frame.rays = shot.meter.rays();
    return absl::OkStatus();
  }

  // Uses the traced radiance rather than the denoised one: it is the same on every machine. A left
  // eye that several rigs share is exposed by itself, so that it has one picture.
  static float ExposureOf(const Shot& shot) {
    const Film& left = *shot.films[0];
    const Film& right = *shot.films[shot.pairing.shared() ? 0 : 1];
    return AutomaticExposure(left.color, right.color, Lightness(left.albedo, left.normal));
  }

  static EyeTruth TruthOf(Shot& shot, int eye) {
    const double baseline_m = eye == 0 ? shot.pairing.leader.baseline_m() : shot.stereo.baseline_m;
    const double focal_times_baseline = shot.stereo.eyes[eye].fx_px * baseline_m;
    return {DisparityOf(shot.view(eye).depth_m, focal_times_baseline), focal_times_baseline,
            eye == 0 ? shot.pairing.baselines : std::vector<double>{1.0}};
  }

  // Marks pixels whose samples disagree about the disparity. Returns the left eye's masks before,
  // if other rigs will share it: pixels may be mixed for one partner and not for another.
  static ImageU8 MarkMixed(Shot& shot) {
    const auto mark = [](const ImageU8& ambiguous, size_t partner, ImageU8& masks) {
      for (size_t i = 0; i < ambiguous.values().size(); ++i) {
        if (ambiguous.values()[i] >> partner & 1) masks.values()[i] |= kMaskMixed;
      }
    };
    ImageU8 unmixed;
    if (shot.pairing.shared() && !shot.kept) unmixed = shot.frame.left.masks;
    mark(shot.kept ? shot.kept->ambiguous : shot.films[0]->ambiguous, shot.pairing.partner,
         shot.frame.left.masks);
    mark(shot.films[1]->ambiguous, 0, shot.frame.right.masks);
    return unmixed;
  }

  // Makes pictures from the films.
  absl::Status Develop(Shot& shot, const CancelToken& cancel) const {
    for (int eye = shot.first_eye(); eye < 2; ++eye) {
      Film& film = *shot.films[eye];
      if (denoiser_) RETURN_IF_ERROR(Denoise(shot.frame.exposure, cancel, &film));
      shot.view(eye).color = ToSrgb(film.color, shot.frame.exposure);
      shot.view(eye).radiance = std::move(film.color);
    }
    return absl::OkStatus();
  }

  // Renders the pair before rectification, with the exposure of the rectified pair.
  absl::Status RenderRaw(Shot& shot, const CancelToken& cancel) const {
    constexpr int kFirstStream = 2;  // The eyes' streams: no two pictures share their noise.
    const v1::Rig& rig = shot.rig;
    StereoFrame* frame = &shot.frame;
    const FilmTracer tracer = Tracer();
    ASSIGN_OR_RETURN(const StereoCamera raw, StereoCamera::RawFromRig(rig));
    RETURN_IF_ERROR(
        CheckMemory(fmt::format("render: raw images of rig {}", rig.index()),
                    int64_t{kBytesPerPixel} * raw.eyes[0].width_px * raw.eyes[0].height_px));
    RETURN_IF_ERROR(
        TraceCorrespondence(*geometry_, raw, cancel, &frame->raw_left, &frame->raw_right));
    RawView* views[2] = {&frame->raw_left, &frame->raw_right};
    for (int eye = 0; eye < 2; ++eye) {
      const PinholeCamera& camera = raw.eyes[eye];
      const auto stream = [&](uint32_t pass) { return StreamOf(rig, kFirstStream + eye, pass); };
      Film film(camera);
      tracer.TraceEye(camera, stream(0), {}, shot.clamp, cancel, &shot.meter, &film);
      if (cancel.cancelled()) return Cancelled("render: cancelled");
      tracer.TraceGuides(camera, stream(4), cancel, &shot.meter, &film);
      tracer.TraceEdges(camera, stream(3), shot.clamp, frame->exposure, cancel, &shot.meter, &film);
      if (cancel.cancelled()) return Cancelled("render: cancelled");
      if (denoiser_) RETURN_IF_ERROR(Denoise(frame->exposure, cancel, &film));
      BlackenUnseen(*camera.lens, &film.color);
      views[eye]->color = ToSrgb(film.color, frame->exposure);
      views[eye]->radiance = std::move(film.color);
    }
    frame->rays = shot.meter.rays();
    return absl::OkStatus();
  }

  FilmTracer Tracer() const { return {*geometry_, lights_, profile_, cache_ ? &*cache_ : nullptr}; }

  absl::StatusOr<float> ClampOf(const Pairing& pairing, const KeptLeft* kept) const {
    if (profile_.clamp <= 0) return 0.0f;
    if (kept) return kept->clamp;
    ASSIGN_OR_RETURN(const StereoCamera leader, StereoCamera::FromRig(pairing.leader));
    const SampleStream streams[2] = {StreamOf(pairing.leader, 0, 1),
                                     StreamOf(pairing.leader, 1, 1)};
    return profile_.clamp * Tracer().PilotLuminance(streams, leader);
  }

  SampleStream StreamOf(const v1::Rig& rig, int eye, uint32_t pass) const {
    return {scene_seed_, rig.index(), static_cast<uint32_t>(eye), pass};
  }

  // Denoises everything but the light above the display's range.
  absl::Status Denoise(float exposure, const CancelToken& cancel, Film* film) const {
    const ImageF3 excess = TakeExcess(Overexposed(film->color, exposure), exposure, &film->color);
    RETURN_IF_ERROR(denoiser_->Execute(cancel, film->albedo, film->normal, &film->color));
    for (size_t i = 0; i < excess.values().size(); ++i) {
      film->color.values()[i] += excess.values()[i];
    }
    return absl::OkStatus();
  }

  // Fills from all rigs of the recipe, whichever are rendered here, so that pictures do not depend
  // on how a scene's rigs are split among jobs.
  absl::Status FillCache(const CancelToken& cancel) {
    // Keyframes place objects and lights anew for every rig: rigs can't share a cache.
    if (cache_ || profile_.cache_paths == 0 || !keyframes_.empty()) return absl::OkStatus();
    std::vector<StereoCamera> cameras;
    for (const v1::Rig& rig : book_.rigs()) {
      ASSIGN_OR_RETURN(cameras.emplace_back(), StereoCamera::FromRig(rig));
    }
    CacheFill fill;
    fill.paths = profile_.cache_paths;
    // Movers are not there: the cache holds for all times, and they are lit by traced paths.
    if (moving_.moves()) RETURN_IF_ERROR(geometry_->ShowMovers(false));
    auto filled = FillRadianceCache(*geometry_, &lights_, Tracer().Options(0), scene_seed_, cameras,
                                    fill, cancel);
    if (moving_.moves()) RETURN_IF_ERROR(geometry_->ShowMovers(true));
    ASSIGN_OR_RETURN(cache_, std::move(filled));
    return absl::OkStatus();
  }

  const uint64_t scene_seed_;
  const RigBook book_;
  const RenderProfile profile_;
  const bool with_raw_;   // Also renders the raw cameras of rigs that have them.
  const bool with_flow_;  // Also traces flow to the neighbours of a sequence.
  const bool with_infrared_;
  const bool with_exact_occlusion_;
  const std::unique_ptr<RenderScene> geometry_;
  MovingScene moving_;
  LightTable lights_;  // Constant except for keyframes.
  const std::unique_ptr<Denoiser> denoiser_;
  std::map<uint32_t, v1::Keyframe> keyframes_;  // By rig index; none unless the scene has them.
  v1::Scene lit_recipe_;                // Used by keyframes: the recipe, lit by one of them.
  std::optional<RadianceCache> cache_;  // Filled by the first rig that is rendered.
  std::optional<KeptLeft> kept_left_;   // The last that may be asked for again.
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

}  // namespace

absl::StatusOr<std::unique_ptr<Renderer>> Renderer::Create(const v1::Scene& scene,
                                                           SceneGeometry geometry,
                                                           const v1::RenderConfig& config) {
  try {
    ASSIGN_OR_RETURN(const RenderProfile profile, ResolveProfile(config));
    RETURN_IF_ERROR(CheckKeyframes(scene));
    std::vector<bool> movers = MoversOf(scene, geometry);
    ASSIGN_OR_RETURN(std::unique_ptr<RenderScene> built,
                     RenderScene::Build(std::move(geometry), 0, std::move(movers)));
    ASSIGN_OR_RETURN(LightTable lights, LightTable::Build(scene, *built));
    std::unique_ptr<Denoiser> denoiser;
    if (profile.denoise != DenoiseQuality::kOff) {
      ASSIGN_OR_RETURN(denoiser, Denoiser::Create(profile.denoise));
    }
    return std::unique_ptr<Renderer>(new SceneRenderer(scene.scene_seed(), scene, profile, config,
                                                       std::move(built), std::move(lights),
                                                       std::move(denoiser)));
  } catch (const std::bad_alloc&) {
    return ResourceExhausted("render: scene does not fit in memory");
  }
}

}  // namespace parallax
