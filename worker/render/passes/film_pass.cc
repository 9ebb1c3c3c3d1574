// Pass `film`: the pictures. Fills the radiance cache, traces the eyes' films, chooses the
// exposure, marks mixed pixels and denoises.
#include <optional>

#include "common/base/seconds.h"
#include "worker/render/film/exposure.h"
#include "worker/render/passes/pass.h"
#include "worker/render/paths/cache_fill.h"
#include "worker/render/paths/volume_fill.h"

namespace parallax {
namespace {

// One run of the pass.
class FilmPass {
 public:
  FilmPass(PassScene& scene, Shot& shot, const CancelToken& cancel)
      : scene_(scene), shot_(shot), cancel_(cancel) {}

  absl::Status Run() {
    StereoFrame& frame = shot_.frame;
    RETURN_IF_ERROR(Timed(&frame.cache_s, &FilmPass::LearnLight));
    RETURN_IF_ERROR(Timed(&frame.trace_s, &FilmPass::TraceFilms));
    const ImageU8 unmixed = MarkMixed();
    RETURN_IF_ERROR(Timed(&frame.denoise_s, &FilmPass::Develop));
    if (!shot_.pairing.shared() || shot_.kept) return absl::OkStatus();
    scene_.kept_left = {shot_.eye_key, frame.left, std::move(films_[0]->ambiguous), frame.exposure,
                        shot_.clamp};
    scene_.kept_left->view.masks = unmixed;
    return absl::OkStatus();
  }

 private:
  // Runs one stage and adds its seconds.
  absl::Status Timed(double* seconds, absl::Status (FilmPass::*stage)()) {
    const SteadyTime start = Clock::System().Steady();
    RETURN_IF_ERROR((this->*stage)());
    *seconds += SecondsSince(start);
    return absl::OkStatus();
  }

  int first_eye() const { return shot_.kept ? 1 : 0; }

  // Fills from all rigs of the recipe, whichever are rendered here, so that pictures do not depend
  // on how a scene's rigs are split among jobs.
  absl::Status LearnLight() {
    // Keyframes place objects and lights anew for every rig: rigs can't share a cache.
    if (scene_.cache || scene_.volume || scene_.profile.cache_paths == 0 || scene_.has_keyframes) {
      return absl::OkStatus();
    }
    std::vector<StereoCamera> cameras;
    for (const v1::Rig& rig : scene_.book.rigs()) {
      ASSIGN_OR_RETURN(cameras.emplace_back(), StereoCamera::FromRig(rig));
    }
    // Movers are not there: the cache holds for all times, and they are lit by traced paths.
    const bool moves = scene_.moving.moves();
    if (moves) RETURN_IF_ERROR(scene_.geometry->ShowMovers(false));
    const absl::Status filled = scene_.open_land ? FillVolume(cameras) : FillCache(cameras);
    if (moves) RETURN_IF_ERROR(scene_.geometry->ShowMovers(true));
    return filled;
  }

  absl::Status FillCache(const std::vector<StereoCamera>& cameras) {
    CacheFill fill;
    fill.paths = scene_.profile.cache_paths;
    ASSIGN_OR_RETURN(scene_.cache,
                     FillRadianceCache(*scene_.geometry, &scene_.lights, scene_.Tracer().Options(0),
                                       scene_.seed, cameras, fill, cancel_));
    return absl::OkStatus();
  }

  absl::Status FillVolume(const std::vector<StereoCamera>& cameras) {
    VolumeFill fill;
    fill.looks = scene_.profile.cache_paths;
    PathOptions options = scene_.Tracer().Options(0);
    options.direct = DirectLight::kSunByLightSampling;
    ASSIGN_OR_RETURN(scene_.volume, FillIrradianceVolume(*scene_.geometry, scene_.lights, options,
                                                         scene_.seed, cameras, fill, cancel_));
    return absl::OkStatus();
  }

  // Traces the films of both eyes, or of the right one alone, and chooses the exposure.
  absl::Status TraceFilms() {
    ASSIGN_OR_RETURN(shot_.clamp, Clamp());
    const FilmTracer tracer = scene_.Tracer();
    const auto stream = [&](int eye, uint32_t part) {
      return scene_.StreamOf(eye == 0 ? shot_.pairing.leader : shot_.rig, eye, part);
    };
    for (int eye = first_eye(); eye < 2; ++eye) {
      const PinholeCamera& camera = shot_.stereo.eyes[eye];
      Film& film = films_[eye].emplace(camera);
      const auto drawn = tracer.Draw(camera, stream(eye, 0), cancel_);
      const VisibilityBuffer* const visible = drawn ? &*drawn : nullptr;
      tracer.TraceEye(camera, stream(eye, 0), visible, TruthOf(eye), shot_.clamp, cancel_,
                      &shot_.meter, &film);
      if (cancel_.cancelled()) return Cancelled("render: cancelled");
      tracer.TraceGuides(camera, stream(eye, visible ? 0 : 4), visible, cancel_, &shot_.meter,
                         &film);
      if (cancel_.cancelled()) return Cancelled("render: cancelled");
    }
    shot_.frame.exposure = shot_.kept ? shot_.kept->exposure : Exposure();
    for (int eye = first_eye(); eye < 2; ++eye) {
      tracer.TraceEdges(shot_.stereo.eyes[eye], stream(eye, 3), shot_.clamp, shot_.frame.exposure,
                        cancel_, &shot_.meter, &*films_[eye]);
      if (cancel_.cancelled()) return Cancelled("render: cancelled");
    }
    shot_.frame.rays = shot_.meter.rays();
    return absl::OkStatus();
  }

  absl::StatusOr<float> Clamp() const {
    if (scene_.profile.clamp <= 0) return 0.0f;
    if (shot_.kept) return shot_.kept->clamp;
    const v1::Rig& rig = shot_.pairing.leader;
    ASSIGN_OR_RETURN(const StereoCamera leader, StereoCamera::FromRig(rig));
    const SampleStream streams[2] = {scene_.StreamOf(rig, 0, 1), scene_.StreamOf(rig, 1, 1)};
    return scene_.profile.clamp * scene_.Tracer().PilotLuminance(streams, leader);
  }

  // Uses the traced radiance rather than the denoised one: it is the same on every machine. A left
  // eye that several rigs share is exposed by itself, so that it has one picture.
  float Exposure() const {
    const Film& left = *films_[0];
    const Film& right = *films_[shot_.pairing.shared() ? 0 : 1];
    return AutomaticExposure(left.color, right.color, Lightness(left.albedo, left.normal));
  }

  EyeTruth TruthOf(int eye) const {
    const Pairing& pairing = shot_.pairing;
    const double baseline_m = eye == 0 ? pairing.leader.baseline_m() : shot_.stereo.baseline_m;
    const double focal_times_baseline = shot_.stereo.eyes[eye].fx_px * baseline_m;
    return {DisparityOf(shot_.view(eye).depth_m, focal_times_baseline), focal_times_baseline,
            eye == 0 ? pairing.baselines : std::vector<double>{1.0}};
  }

  // Marks pixels whose samples disagree about the disparity. Returns the left eye's masks before,
  // if other rigs will share it: pixels may be mixed for one partner and not for another.
  ImageU8 MarkMixed() {
    const auto mark = [](const ImageU8& ambiguous, size_t partner, ImageU8& masks) {
      for (size_t i = 0; i < ambiguous.values().size(); ++i) {
        if (ambiguous.values()[i] >> partner & 1) masks.values()[i] |= kMaskMixed;
      }
    };
    ImageU8 unmixed;
    if (shot_.pairing.shared() && !shot_.kept) unmixed = shot_.frame.left.masks;
    mark(shot_.kept ? shot_.kept->ambiguous : films_[0]->ambiguous, shot_.pairing.partner,
         shot_.frame.left.masks);
    mark(films_[1]->ambiguous, 0, shot_.frame.right.masks);
    return unmixed;
  }

  // Makes pictures from the films.
  absl::Status Develop() {
    for (int eye = first_eye(); eye < 2; ++eye) {
      Film& film = *films_[eye];
      RETURN_IF_ERROR(scene_.Denoise(shot_.frame.exposure, cancel_, &film));
      shot_.view(eye).color = ToSrgb(film.color, shot_.frame.exposure);
      shot_.view(eye).radiance = std::move(film.color);
    }
    return absl::OkStatus();
  }

  PassScene& scene_;
  Shot& shot_;
  const CancelToken& cancel_;
  std::optional<Film> films_[2];
};

int64_t PixelsOfPair(const v1::Rig& rig) { return int64_t{2} * rig.width_px() * rig.height_px(); }

absl::Status RunFilm(PassScene& scene, Shot& shot, const CancelToken& cancel) {
  return FilmPass(scene, shot, cancel).Run();
}

}  // namespace

// The bytes are those of both eyes' films and maps, the denoiser's buffers, and one eye's
// visibility buffer.
extern const Pass kFilmPass{"film", nullptr, 464, &PixelsOfPair, nullptr, &RunFilm};

}  // namespace parallax
