#include "worker/render/renderer.h"

#include <fmt/core.h>
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
#include "worker/render/flow.h"
#include "worker/render/ground_truth.h"
#include "worker/render/infrared.h"
#include "worker/render/light_table.h"
#include "worker/render/moving_scene.h"
#include "worker/render/overexposed.h"
#include "worker/render/pairing.h"
#include "worker/render/pixel_tracer.h"
#include "worker/render/profiles.h"
#include "worker/render/raw_pair.h"
#include "worker/render/render_scene.h"

namespace parallax {
namespace {

constexpr int kTile = 16;
constexpr int kFew = 16;             // Fewer samples than this need extra ones.
constexpr int kBytesPerPixel = 400;  // Both eyes' films and maps, the denoiser's buffers.
constexpr int kFlowBytesPerPixel = 52;

double SecondsSince(SteadyTime start) {
  return std::chrono::duration<double>(Clock::System().Steady() - start).count();
}

bool HasMap(const v1::RenderConfig& config, const char* map) {
  return std::find(config.maps().begin(), config.maps().end(), map) != config.maps().end();
}

using PixelTracers = tbb::enumerable_thread_specific<PixelTracer>;  // One a thread.

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
  struct Meter {
    const ProgressFn& progress;
    double pixels;
    std::atomic<int64_t> done{0};
    std::atomic<uint64_t> rays{0};
    // Tracing takes nearly all of the time; the rest counts as the last twentieth.
    void Add(int64_t count) {
      const int64_t now = done.fetch_add(count) + count;
      if (progress) progress(0.95 * static_cast<double>(now) / pixels);
    }
  };

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

  static ImageF DisparityOf(const ImageF& depth_m, double focal_times_baseline) {
    ImageF disparity(depth_m.width(), depth_m.height());
    for (size_t i = 0; i < depth_m.values().size(); ++i) {
      const float depth = depth_m.values()[i];
      if (depth > 0) disparity.values()[i] = static_cast<float>(focal_times_baseline / depth);
    }
    return disparity;
  }

  absl::Status TraceTruth(const v1::Rig& rig, const StereoCamera& stereo, const KeptLeft* kept,
                          const CancelToken& cancel, StereoFrame* frame) {
    View* views[2] = {&frame->left, &frame->right};
    for (int eye = 0; eye < 2; ++eye) {
      const PinholeCamera& camera = stereo.eyes[eye];
      if (eye == 0 && kept) {
        frame->left = kept->view;
        frame->left.disparity_px =
            DisparityOf(kept->view.depth_m, camera.fx_px * stereo.baseline_m);
        continue;
      }
      RETURN_IF_ERROR(TraceGroundTruth(*geometry_, camera, stereo.baseline_m, cancel, views[eye]));
      MarkVeiled(lights_.haze(), camera, views[eye]);
    }
    MarkOcclusion(&frame->left, &frame->right);
    if (!with_flow_) return absl::OkStatus();
    return TraceFlow(book_, rig, kept ? &kept->view : nullptr, *geometry_, moving_, cancel, frame);
  }

  absl::StatusOr<StereoFrame> Render(const v1::Rig& rig, const CancelToken& cancel,
                                     const ProgressFn& progress) {
    ASSIGN_OR_RETURN(const StereoCamera stereo, StereoCamera::FromRig(rig));
    const Pairing pairing = book_.PairingOf(rig);
    const std::string eye_key = LeftEyeKey(rig, pairing);
    const KeptLeft* kept =
        pairing.shared() && kept_left_ && kept_left_->eye == eye_key ? &*kept_left_ : nullptr;
    RETURN_IF_ERROR(CheckMemory(fmt::format("render: images of rig {}", rig.index()),
                                int64_t{kBytesPerPixel + (with_flow_ ? kFlowBytesPerPixel : 0)} *
                                    rig.width_px() * rig.height_px()));
    const bool with_raw = with_raw_ && rig.has_raw_left();
    StereoFrame frame;
    View* views[2] = {&frame.left, &frame.right};

    const SteadyTime truth_start = Clock::System().Steady();
    RETURN_IF_ERROR(TraceTruth(rig, stereo, kept, cancel, &frame));
    frame.truth_s = SecondsSince(truth_start);

    const SteadyTime fill_start = Clock::System().Steady();
    RETURN_IF_ERROR(FillCache(cancel));
    frame.cache_s = SecondsSince(fill_start);

    const SteadyTime trace_start = Clock::System().Steady();
    ASSIGN_OR_RETURN(const float clamp, ClampOf(pairing, kept));
    std::optional<Film> films[2];
    const int first_eye = kept ? 1 : 0;
    Meter meter{progress, ((with_raw ? 4.0 : 2.0) - first_eye) * rig.width_px() * rig.height_px()};
    const auto stream = [&](int eye, uint32_t pass) {
      return StreamOf(eye == 0 ? pairing.leader : rig, eye, pass);
    };
    for (int eye = first_eye; eye < 2; ++eye) {
      const PinholeCamera& camera = stereo.eyes[eye];
      films[eye].emplace(camera);
      const Truth truth = TruthOf(*views[eye], camera, eye == 0 ? pairing.baselines : kOnePartner,
                                  eye == 0 ? pairing.leader.baseline_m() : stereo.baseline_m);
      TraceEye(camera, stream(eye, 0), truth, clamp, cancel, &meter, &*films[eye]);
      if (cancel.cancelled()) return Cancelled("render: cancelled");
      TraceGuides(camera, stream(eye, 4), cancel, &meter, &*films[eye]);
      if (cancel.cancelled()) return Cancelled("render: cancelled");
    }
    // Uses the traced radiance rather than the denoised one: it is the same on every machine. A
    // left eye that several rigs share is exposed by itself, so that it has one picture.
    frame.exposure =
        kept ? kept->exposure
             : AutomaticExposure(films[0]->color, films[pairing.shared() ? 0 : 1]->color);
    for (int eye = first_eye; eye < 2; ++eye) {
      TraceEdges(stereo.eyes[eye], stream(eye, 3), clamp, frame.exposure, cancel, &meter,
                 &*films[eye]);
      if (cancel.cancelled()) return Cancelled("render: cancelled");
    }
    const ImageU8 unmixed = pairing.shared() && !kept ? frame.left.masks : ImageU8();
    MarkMixed(kept ? kept->ambiguous : films[0]->ambiguous, pairing.partner, &frame.left.masks);
    MarkMixed(films[1]->ambiguous, 0, &frame.right.masks);
    frame.rays = meter.rays;
    frame.trace_s = SecondsSince(trace_start);

    const SteadyTime denoise_start = Clock::System().Steady();
    for (int eye = first_eye; eye < 2; ++eye) {
      Film& film = *films[eye];
      if (denoiser_) {
        RETURN_IF_ERROR(Denoise(frame.exposure, cancel, &film));
      }
      views[eye]->color = ToSrgb(film.color, frame.exposure);
      views[eye]->radiance = std::move(film.color);
    }
    frame.denoise_s = SecondsSince(denoise_start);
    if (pairing.shared() && !kept) {
      kept_left_ = {eye_key, frame.left, std::move(films[0]->ambiguous), frame.exposure, clamp};
      kept_left_->view.masks = unmixed;
    }
    if (with_infrared_) {
      const SteadyTime start = Clock::System().Steady();
      const SampleStream streams[2] = {StreamOf(rig, 0, 5), StreamOf(rig, 1, 5)};
      RETURN_IF_ERROR(RenderInfrared(*geometry_, stereo, rig, streams, cancel, &frame));
      frame.trace_s += SecondsSince(start);
    }
    if (with_raw) RETURN_IF_ERROR(RenderRaw(rig, clamp, cancel, &meter, &frame));
    if (progress) progress(1.0);
    return frame;
  }

  // Renders the pair before rectification, with the exposure of the rectified pair.
  absl::Status RenderRaw(const v1::Rig& rig, float clamp, const CancelToken& cancel, Meter* meter,
                         StereoFrame* frame) const {
    constexpr int kFirstStream = 2;  // The eyes' streams: no two pictures share their noise.
    const SteadyTime start = Clock::System().Steady();
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
      TraceEye(camera, stream(0), {}, clamp, cancel, meter, &film);
      if (cancel.cancelled()) return Cancelled("render: cancelled");
      TraceGuides(camera, stream(4), cancel, meter, &film);
      TraceEdges(camera, stream(3), clamp, frame->exposure, cancel, meter, &film);
      if (cancel.cancelled()) return Cancelled("render: cancelled");
      if (denoiser_) RETURN_IF_ERROR(Denoise(frame->exposure, cancel, &film));
      BlackenUnseen(*camera.lens, &film.color);
      views[eye]->color = ToSrgb(film.color, frame->exposure);
      views[eye]->radiance = std::move(film.color);
    }
    frame->rays = meter->rays;
    frame->trace_s += SecondsSince(start);
    return absl::OkStatus();
  }

  static void MarkMixed(const ImageU8& ambiguous, size_t partner, ImageU8* masks) {
    for (size_t i = 0; i < ambiguous.values().size(); ++i) {
      if (ambiguous.values()[i] >> partner & 1) masks->values()[i] |= kMaskMixed;
    }
  }

  absl::StatusOr<float> ClampOf(const Pairing& pairing, const KeptLeft* kept) const {
    if (profile_.clamp <= 0) return 0.0f;
    if (kept) return kept->clamp;
    ASSIGN_OR_RETURN(const StereoCamera leader, StereoCamera::FromRig(pairing.leader));
    return profile_.clamp * PilotLuminance(pairing.leader.index(), leader);
  }

  int SamplesOf(const PinholeCamera& camera) const {
    return profile_.SamplesPerPixel(camera.width_px, camera.height_px);
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

  PathOptions Options(float clamp) const {
    PathOptions options;
    options.max_bounces = profile_.max_bounces;
    options.clamp_luminance = clamp;
    options.cache = cache_ && !cache_->empty() ? &*cache_ : nullptr;
    options.cache_footprint = profile_.cache_footprint;
    return options;
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
    auto filled =
        FillRadianceCache(*geometry_, &lights_, Options(0), scene_seed_, cameras, fill, cancel);
    if (moving_.moves()) RETURN_IF_ERROR(geometry_->ShowMovers(true));
    ASSIGN_OR_RETURN(cache_, std::move(filled));
    return absl::OkStatus();
  }

  // Mean luminance of a coarse, cheap picture of both eyes, the reference for clamping. Bright
  // lamps seen directly are clamped so that they do not raise it.
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
    // Square of the mean square root: between geometric and arithmetic mean, and robust to noise.
    return std::max(Square(sum / (2 * kRows * kColumns)), 1e-3f);
  }

  // The exact disparities with which samples are compared.
  struct Truth {
    ImageF disparity_px;  // Empty: none.
    double focal_times_baseline = 0;
    std::vector<double> baselines;  // PixelSampling's.
  };

  static Truth TruthOf(const View& view, const PinholeCamera& camera,
                       const std::vector<double>& baselines, double baseline_m) {
    const double focal_times_baseline = camera.fx_px * baseline_m;
    return {DisparityOf(view.depth_m, focal_times_baseline), focal_times_baseline, baselines};
  }

  void TraceEye(const PinholeCamera& camera, const SampleStream& stream, const Truth& truth,
                float clamp, const CancelToken& cancel, Meter* meter, Film* film) const {
    const int samples = SamplesOf(camera);
    const PixelSampling sampling{stream.Hash(),
                                 samples,
                                 SampleTogether(camera, samples),
                                 truth.disparity_px.empty() ? nullptr : &truth.disparity_px,
                                 truth.focal_times_baseline,
                                 truth.baselines};
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

  // Few samples are spread over neighbouring pixels together; many are spread within each pixel.
  static bool SampleTogether(const PinholeCamera& camera, int samples) {
    constexpr int kMost = 64;
    constexpr int kWidest = 1 << 13;  // Beyond, they could not be numbered.
    return samples <= kMost && std::max(camera.width_px, camera.height_px) <= kWidest;
  }

  // Adds samples of the denoiser's guides, without light, where a pixel's few samples differ.
  void TraceGuides(const PinholeCamera& camera, const SampleStream& stream,
                   const CancelToken& cancel, Meter* meter, Film* film) const {
    constexpr int kMore = 8;
    if (!denoiser_ || SamplesOf(camera) >= kFew) return;
    PathOptions options = Options(0);
    options.cache = nullptr;
    options.only_guides = true;
    TraceAnew(camera, {stream.Hash(), kMore}, options, film->MixedPixels(), cancel, meter, film);
  }

  // Renders the edges of overexposed regions again, with more samples.
  void TraceEdges(const PinholeCamera& camera, const SampleStream& stream, float clamp,
                  float exposure, const CancelToken& cancel, Meter* meter, Film* film) const {
    constexpr int kTimes = 4;
    const int samples = SamplesOf(camera);
    if (profile_.clamp <= 0.0f || samples >= kFew) return;
    TraceAnew(camera, {stream.Hash(), kTimes * samples}, Options(clamp),
              EdgesOf(Overexposed(film->color, exposure)), cancel, meter, film);
  }

  // Renders single pixels independently.
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
  static inline const std::vector<double> kOnePartner = {1.0};

  const RigBook book_;
  const RenderProfile profile_;
  const bool with_raw_;   // Also renders the raw cameras of rigs that have them.
  const bool with_flow_;  // Also traces flow to the neighbours of a sequence.
  const bool with_infrared_;
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
