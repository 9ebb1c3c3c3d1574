#include "worker/render/renderer.h"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <map>
#include <optional>

#include "common/base/clock.h"
#include "common/base/memory_budget.h"
#include "common/math/proto.h"
#include "worker/render/cache_fill.h"
#include "worker/render/camera_rays.h"
#include "worker/render/denoiser.h"
#include "worker/render/exposure.h"
#include "worker/render/film.h"
#include "worker/render/ground_truth.h"
#include "worker/render/infrared.h"
#include "worker/render/lights.h"
#include "worker/render/overexposed.h"
#include "worker/render/pixel_tracer.h"
#include "worker/render/profiles.h"
#include "worker/render/raw_pair.h"
#include "worker/render/render_scene.h"

namespace parallax {
namespace {

constexpr int kTile = 16;
constexpr int kFew = 16;  // Samples of a pixel; with as many, none need others of their own.
constexpr int kBytesPerPixel = 400;  // Both eyes' films and maps, the denoiser's buffers.

double SecondsSince(SteadyTime start) {
  return std::chrono::duration<double>(Clock::System().Steady() - start).count();
}

absl::Status CancelledError() {
  return MakeError(absl::StatusCode::kCancelled, "render: cancelled");
}

// Pictures beside the pair.
struct Extras {
  bool raw = false;  // Of rigs that have raw cameras.
  bool infrared = false;
};

using PixelTracers = tbb::enumerable_thread_specific<PixelTracer>;  // One a thread.

class SceneRenderer final : public Renderer {
 public:
  SceneRenderer(uint64_t scene_seed, const v1::Scene& scene, RenderProfile profile, Extras extras,
                std::unique_ptr<RenderScene> geometry, LightTable lights,
                std::unique_ptr<Denoiser> denoiser)
      : scene_seed_(scene_seed),
        rigs_(scene.rigs().begin(), scene.rigs().end()),
        profile_(profile),
        extras_(extras),
        geometry_(std::move(geometry)),
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
      return MakeError(absl::StatusCode::kResourceExhausted,
                       "render: rig " + std::to_string(rig.index()) + " does not fit in memory");
    }
  }

 private:
  struct Meter {
    const ProgressFn& progress;
    double pixels;
    std::atomic<int64_t> done{0};
    std::atomic<uint64_t> rays{0};
    // Tracing is nearly all of the work; the rest is the last twentieth.
    void Add(int64_t count) {
      const int64_t now = done.fetch_add(count) + count;
      if (progress) progress(0.95 * static_cast<double>(now) / pixels);
    }
  };

  // Dense scenes: everything stands as the rig's keyframe says. Meshes, their acceleration
  // structures and materials are those of the scene.
  absl::Status Enter(const v1::Rig& rig) {
    if (keyframes_.empty()) return absl::OkStatus();
    const auto found = keyframes_.find(rig.index());
    if (found == keyframes_.end()) {
      return MakeError(absl::StatusCode::kInvalidArgument,
                       "rig " + std::to_string(rig.index()) + " has no keyframe");
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

  absl::StatusOr<StereoFrame> Render(const v1::Rig& rig, const CancelToken& cancel,
                                     const ProgressFn& progress) {
    ASSIGN_OR_RETURN(const StereoCamera stereo, StereoCamera::FromRig(rig));
    RETURN_IF_ERROR(CheckMemory("render: images of rig " + std::to_string(rig.index()),
                                int64_t{kBytesPerPixel} * rig.width_px() * rig.height_px()));
    const bool with_raw = extras_.raw && rig.has_raw_left();
    StereoFrame frame;
    View* views[2] = {&frame.left, &frame.right};

    const SteadyTime truth_start = Clock::System().Steady();
    for (int eye = 0; eye < 2; ++eye) {
      RETURN_IF_ERROR(
          TraceGroundTruth(*geometry_, stereo.eyes[eye], stereo.baseline_m, cancel, views[eye]));
    }
    MarkOcclusion(&frame.left, &frame.right);
    for (int eye = 0; eye < 2; ++eye) MarkVeiled(lights_.haze(), stereo.eyes[eye], views[eye]);
    frame.truth_s = SecondsSince(truth_start);

    const SteadyTime fill_start = Clock::System().Steady();
    RETURN_IF_ERROR(FillCache(cancel));
    frame.cache_s = SecondsSince(fill_start);

    const SteadyTime trace_start = Clock::System().Steady();
    const float clamp =
        profile_.clamp > 0 ? profile_.clamp * PilotLuminance(rig.index(), stereo) : 0;
    std::vector<Film> films;
    Meter meter{progress, (with_raw ? 4.0 : 2.0) * rig.width_px() * rig.height_px()};
    for (int eye = 0; eye < 2; ++eye) {
      films.emplace_back(stereo.eyes[eye]);
      const Truth truth{&views[eye]->disparity_px, stereo.eyes[eye].fx_px * stereo.baseline_m};
      TraceEye(stereo.eyes[eye], StreamOf(rig, eye, 0), truth, clamp, cancel, &meter,
               &films.back());
      if (cancel.cancelled()) return CancelledError();
      TraceGuides(stereo.eyes[eye], StreamOf(rig, eye, 4), cancel, &meter, &films.back());
      if (cancel.cancelled()) return CancelledError();
    }
    // From what was traced, not from what the denoiser made of it: the same on every machine.
    frame.exposure = AutomaticExposure(films[0].color, films[1].color);
    for (int eye = 0; eye < 2; ++eye) {
      TraceEdges(stereo.eyes[eye], StreamOf(rig, eye, 3), clamp, frame.exposure, cancel, &meter,
                 &films[static_cast<size_t>(eye)]);
      if (cancel.cancelled()) return CancelledError();
    }
    for (int eye = 0; eye < 2; ++eye) {
      MarkMixed(films[static_cast<size_t>(eye)].ambiguous, &views[eye]->masks);
    }
    frame.rays = meter.rays;
    frame.trace_s = SecondsSince(trace_start);

    const SteadyTime denoise_start = Clock::System().Steady();
    for (int eye = 0; eye < 2; ++eye) {
      Film& film = films[static_cast<size_t>(eye)];
      if (denoiser_) {
        RETURN_IF_ERROR(Denoise(frame.exposure, cancel, &film));
      }
      views[eye]->color = ToSrgb(film.color, frame.exposure);
      views[eye]->radiance = std::move(film.color);
    }
    frame.denoise_s = SecondsSince(denoise_start);
    if (extras_.infrared) {
      const SteadyTime start = Clock::System().Steady();
      const SampleStream streams[2] = {StreamOf(rig, 0, 5), StreamOf(rig, 1, 5)};
      RETURN_IF_ERROR(RenderInfrared(*geometry_, stereo, rig, streams, cancel, &frame));
      frame.trace_s += SecondsSince(start);
    }
    if (with_raw) RETURN_IF_ERROR(RenderRaw(rig, clamp, cancel, &meter, &frame));
    if (progress) progress(1.0);
    return frame;
  }

  // The pair before rectification, exposed as the rectified one.
  absl::Status RenderRaw(const v1::Rig& rig, float clamp, const CancelToken& cancel, Meter* meter,
                         StereoFrame* frame) const {
    constexpr int kFirstStream = 2;  // Of eyes: the noise of no two pictures is the same.
    const SteadyTime start = Clock::System().Steady();
    ASSIGN_OR_RETURN(const StereoCamera raw, StereoCamera::RawFromRig(rig));
    RETURN_IF_ERROR(
        CheckMemory("render: raw images of rig " + std::to_string(rig.index()),
                    int64_t{kBytesPerPixel} * raw.eyes[0].width_px * raw.eyes[0].height_px));
    RETURN_IF_ERROR(
        TraceCorrespondence(*geometry_, raw, cancel, &frame->raw_left, &frame->raw_right));
    RawView* views[2] = {&frame->raw_left, &frame->raw_right};
    for (int eye = 0; eye < 2; ++eye) {
      const PinholeCamera& camera = raw.eyes[eye];
      const auto stream = [&](uint32_t pass) { return StreamOf(rig, kFirstStream + eye, pass); };
      Film film(camera);
      TraceEye(camera, stream(0), {nullptr, 0}, clamp, cancel, meter, &film);
      if (cancel.cancelled()) return CancelledError();
      TraceGuides(camera, stream(4), cancel, meter, &film);
      TraceEdges(camera, stream(3), clamp, frame->exposure, cancel, meter, &film);
      if (cancel.cancelled()) return CancelledError();
      if (denoiser_) RETURN_IF_ERROR(Denoise(frame->exposure, cancel, &film));
      BlackenUnseen(*camera.lens, &film.color);
      views[eye]->color = ToSrgb(film.color, frame->exposure);
      views[eye]->radiance = std::move(film.color);
    }
    frame->rays = meter->rays;
    frame->trace_s += SecondsSince(start);
    return absl::OkStatus();
  }

  static void MarkMixed(const ImageU8& ambiguous, ImageU8* masks) {
    for (size_t i = 0; i < ambiguous.values().size(); ++i) {
      if (ambiguous.values()[i]) masks->values()[i] |= kMaskMixed;
    }
  }

  int SamplesOf(const PinholeCamera& camera) const {
    return profile_.SamplesPerPixel(camera.width_px, camera.height_px);
  }

  SampleStream StreamOf(const v1::Rig& rig, int eye, uint32_t pass) const {
    return {scene_seed_, rig.index(), static_cast<uint32_t>(eye), pass};
  }

  // All but what is brighter than the display shows.
  absl::Status Denoise(float exposure, const CancelToken& cancel, Film* film) const {
    const ImageF3 excess = TakeExcess(Overexposed(film->color, exposure), exposure, &film->color);
    RETURN_IF_ERROR(denoiser_->Execute(cancel, film->albedo, film->normal, &film->color));
    for (size_t i = 0; i < excess.values().size(); ++i) {
      film->color.values()[i] += excess.values()[i];
    }
    return absl::OkStatus();
  }

  PathOptions Options(float clamp) const {
    PathOptions options;
    options.max_bounces = profile_.max_bounces;
    options.clamp_luminance = clamp;
    options.cache = cache_ && !cache_->empty() ? &*cache_ : nullptr;
    options.cache_footprint = profile_.cache_footprint;
    return options;
  }

  // From all rigs of the recipe, whichever of them are rendered here: pictures do not depend on how
  // a scene's rigs are shared out among jobs.
  absl::Status FillCache(const CancelToken& cancel) {
    // What stands anew for every rig shares no light.
    if (cache_ || profile_.cache_paths == 0 || !keyframes_.empty()) return absl::OkStatus();
    std::vector<StereoCamera> cameras;
    for (const v1::Rig& rig : rigs_) {
      ASSIGN_OR_RETURN(cameras.emplace_back(), StereoCamera::FromRig(rig));
    }
    CacheFill fill;
    fill.paths = profile_.cache_paths;
    ASSIGN_OR_RETURN(cache_, FillRadianceCache(*geometry_, &lights_, Options(0), scene_seed_,
                                               cameras, fill, cancel));
    return absl::OkStatus();
  }

  // Mean luminance of a coarse, cheap picture of both eyes: what "too bright" is measured by.
  // Bright lamps seen directly are cut so that they don't raise it.
  float PilotLuminance(uint32_t rig, const StereoCamera& stereo) const {
    constexpr int kColumns = 64;
    constexpr int kRows = 36;
    std::vector<float> rows(2 * kRows);
    tbb::parallel_for(0, 2 * kRows, [&](int index) {
      const int eye = index / kRows;
      const PinholeCamera& camera = stereo.eyes[eye];
      const uint32_t stream = SampleStream{scene_seed_, rig, static_cast<uint32_t>(eye), 1}.Hash();
      const CameraRays rays(camera);
      std::vector<Path> paths;
      for (int column = 0; column < kColumns; ++column) {
        const int row = index % kRows;
        Sampler sampler(stream, static_cast<uint32_t>(column), static_cast<uint32_t>(row), 0);
        const Vec2f jitter = sampler.Pair();
        const Vec2f at((static_cast<float>(column) + jitter.x()) / kColumns,
                       (static_cast<float>(row) + jitter.y()) / kRows);
        Path& path = paths.emplace_back(sampler);
        path.ray = rays.Through(at.x() * static_cast<float>(camera.width_px),
                                at.y() * static_cast<float>(camera.height_px));
      }
      PathTracer(*geometry_, lights_, Options(0)).Trace(paths);
      float sum = 0;
      for (const Path& path : paths) {
        sum += std::sqrt(std::max(Luminance(path.result.radiance), 0.0f));
      }
      rows[static_cast<size_t>(index)] = sum;
    });
    float sum = 0;
    for (const float row : rows) sum += row;
    // Square of the mean root: between the geometric and the arithmetic mean, calm under noise.
    return std::max(Square(sum / (2 * kRows * kColumns)), 1e-3f);
  }

  // The exact disparities that samples are compared with.
  struct Truth {
    const ImageF* disparity_px;
    double focal_times_baseline;
  };

  void TraceEye(const PinholeCamera& camera, const SampleStream& stream, const Truth& truth,
                float clamp, const CancelToken& cancel, Meter* meter, Film* film) const {
    const int samples = SamplesOf(camera);
    const PixelSampling sampling{stream.Hash(), samples, SampleTogether(camera, samples),
                                 truth.disparity_px, truth.focal_times_baseline};
    PixelTracers tracers(
        [&] { return PixelTracer(*geometry_, lights_, Options(clamp), camera, sampling); });
    const int columns = (camera.width_px + kTile - 1) / kTile;
    const int rows = (camera.height_px + kTile - 1) / kTile;
    tbb::parallel_for(0, columns * rows, [&](int tile) {
      const int x0 = tile % columns * kTile;
      const int y0 = tile / columns * kTile;
      std::vector<PixelAt> pixels;
      for (int y = y0; y < std::min(y0 + kTile, camera.height_px); ++y) {
        for (int x = x0; x < std::min(x0 + kTile, camera.width_px); ++x) pixels.push_back({x, y});
      }
      meter->rays += tracers.local().Trace(pixels, cancel, film);
      if (!cancel.cancelled()) meter->Add(static_cast<int64_t>(pixels.size()));
    });
  }

  // Few are spread over neighbouring pixels together; with many a pixel stands for itself.
  static bool SampleTogether(const PinholeCamera& camera, int samples) {
    constexpr int kMost = 64;
    constexpr int kWidest = 1 << 13;  // Beyond, they could not be numbered.
    return samples <= kMost && std::max(camera.width_px, camera.height_px) <= kWidest;
  }

  // More samples of what guides the denoiser, without light, where a pixel's few differ.
  void TraceGuides(const PinholeCamera& camera, const SampleStream& stream,
                   const CancelToken& cancel, Meter* meter, Film* film) const {
    constexpr int kMore = 8;
    if (!denoiser_ || SamplesOf(camera) >= kFew) return;
    PathOptions options = Options(0);
    options.cache = nullptr;
    options.only_guides = true;
    TraceAnew(camera, {stream.Hash(), kMore}, options, film->MixedPixels(), cancel, meter, film);
  }

  // Edges of what is brighter than the display shows, with more samples anew.
  void TraceEdges(const PinholeCamera& camera, const SampleStream& stream, float clamp,
                  float exposure, const CancelToken& cancel, Meter* meter, Film* film) const {
    constexpr int kTimes = 4;
    const int samples = SamplesOf(camera);
    if (profile_.clamp <= 0.0f || samples >= kFew) return;
    TraceAnew(camera, {stream.Hash(), kTimes * samples}, Options(clamp),
              EdgesOf(Overexposed(film->color, exposure)), cancel, meter, film);
  }

  // Some pixels, each for itself.
  void TraceAnew(const PinholeCamera& camera, const PixelSampling& sampling,
                 const PathOptions& options, const std::vector<PixelAt>& pixels,
                 const CancelToken& cancel, Meter* meter, Film* film) const {
    constexpr size_t kAtOnce = kTile * kTile;
    PixelTracers tracers(
        [&] { return PixelTracer(*geometry_, lights_, options, camera, sampling); });
    tbb::parallel_for(size_t{0}, (pixels.size() + kAtOnce - 1) / kAtOnce, [&](size_t part) {
      const std::span all(pixels);
      const auto some = all.subspan(part * kAtOnce, std::min(kAtOnce, all.size() - part * kAtOnce));
      meter->rays += tracers.local().Trace(some, cancel, film);
    });
  }

  const uint64_t scene_seed_;
  const std::vector<v1::Rig> rigs_;
  const RenderProfile profile_;
  const Extras extras_;
  const std::unique_ptr<RenderScene> geometry_;
  LightTable lights_;  // Constant but for keyframes.
  const std::unique_ptr<Denoiser> denoiser_;
  std::map<uint32_t, v1::Keyframe> keyframes_;  // By rig index; none unless the scene has them.
  v1::Scene lit_recipe_;                // Of keyframes: the recipe with one's lights and sky.
  std::optional<RadianceCache> cache_;  // Filled by the first rig that is rendered.
};

absl::Status CheckKeyframes(const v1::Scene& scene) {
  if (scene.keyframes().empty()) return absl::OkStatus();
  bool whole = scene.keyframes_size() == scene.rigs_size();
  for (const v1::Keyframe& keyframe : scene.keyframes()) {
    whole = whole && keyframe.world_from_object_size() == 8 * scene.objects_size();
  }
  if (whole) return absl::OkStatus();
  return MakeError(absl::StatusCode::kInvalidArgument,
                   "scene: keyframes that do not fit its rigs or objects");
}

}  // namespace

absl::StatusOr<std::unique_ptr<Renderer>> Renderer::Create(const v1::Scene& scene,
                                                           SceneGeometry geometry,
                                                           const v1::RenderConfig& config) {
  try {
    ASSIGN_OR_RETURN(const RenderProfile profile, ResolveProfile(config));
    const auto wants = [&config](const char* map) {
      return std::find(config.maps().begin(), config.maps().end(), map) != config.maps().end();
    };
    const Extras extras{wants("raw"), wants("infrared")};
    RETURN_IF_ERROR(CheckKeyframes(scene));
    ASSIGN_OR_RETURN(std::unique_ptr<RenderScene> built,
                     RenderScene::Build(std::move(geometry), 0, scene.keyframes_size() > 0));
    ASSIGN_OR_RETURN(LightTable lights, LightTable::Build(scene, *built));
    std::unique_ptr<Denoiser> denoiser;
    if (profile.denoise != DenoiseQuality::kOff) {
      ASSIGN_OR_RETURN(denoiser, Denoiser::Create(profile.denoise));
    }
    return std::unique_ptr<Renderer>(new SceneRenderer(scene.scene_seed(), scene, profile, extras,
                                                       std::move(built), std::move(lights),
                                                       std::move(denoiser)));
  } catch (const std::bad_alloc&) {
    return MakeError(absl::StatusCode::kResourceExhausted, "render: scene does not fit in memory");
  }
}

}  // namespace parallax
