// The passes that make a pair: each fills some maps of a frame from the scene. The renderer runs
// those whose maps render.maps asks for (FrameMap::pass), in the order of Passes().
//
// A new pass: its file here, with a constant Pass; its line in passes.cc; its rows in the table of
// maps. What no other pass reads it puts into StereoFrame::more by file name.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "common/base/cancel.h"
#include "common/base/status.h"
#include "worker/render/camera/camera.h"
#include "worker/render/camera/stereo_frame.h"
#include "worker/render/film/denoiser.h"
#include "worker/render/film/film.h"
#include "worker/render/film/film_tracer.h"
#include "worker/render/film/pairing.h"
#include "worker/render/lights/light_table.h"
#include "worker/render/paths/profiles.h"
#include "worker/render/paths/radiance_cache.h"
#include "worker/render/scene/moving_scene.h"
#include "worker/render/scene/render_scene.h"

namespace parallax {

// Returns whether a volume learns the light of a scene: land with plants or stones in large numbers
// under the open sky, which no roof encloses and no keyframe lights anew, for a profile that learns
// light and whose pictures are rasterised.
inline bool IsOpenLand(const v1::Scene& scene, const RenderProfile& profile,
                       const RenderScene& geometry, const LightTable& lights) {
  return profile.cache_paths > 0 && FilmTracer::NeedsRasteriser(profile) &&
         scene.keyframes().empty() && !geometry.geometry().instances.empty() &&
         lights.enclosures().empty();
}

// State that the passes of all pairs of a scene share. One pair at a time.
struct PassScene {
  PassScene(const v1::Scene& scene, const RenderProfile& scene_profile,
            std::unique_ptr<RenderScene> scene_geometry, LightTable scene_lights,
            std::optional<Rasteriser> scene_rasteriser, std::unique_ptr<Denoiser> scene_denoiser)
      : seed(scene.scene_seed()),
        book(scene),
        profile(scene_profile),
        has_keyframes(!scene.keyframes().empty()),
        geometry(std::move(scene_geometry)),
        moving(scene, geometry.get()),
        lights(std::move(scene_lights)),
        rasteriser(std::move(scene_rasteriser)),
        denoiser(std::move(scene_denoiser)),
        open_land(IsOpenLand(scene, profile, *geometry, lights)) {}

  FilmTracer Tracer() const {
    return {*geometry, lights, profile,
            StoredLight{cache ? &*cache : nullptr, volume ? &*volume : nullptr},
            rasteriser ? &*rasteriser : nullptr};
  }
  // Returns the stream of random numbers of a picture: `part` tells the uses of one eye apart.
  SampleStream StreamOf(const v1::Rig& rig, int eye, uint32_t part) const {
    return {seed, rig.index(), static_cast<uint32_t>(eye), part};
  }
  // Denoises a film, but for the light above the display's range. Does nothing without a denoiser.
  // Errors: as Denoiser::Execute.
  absl::Status Denoise(float exposure, const CancelToken& cancel, Film* film) const;

  const uint64_t seed;
  const RigBook book;
  const RenderProfile profile;
  const bool has_keyframes;  // Every rig has objects and lights placed anew.
  const std::unique_ptr<RenderScene> geometry;
  MovingScene moving;
  LightTable lights;                           // Constant except for keyframes.
  const std::optional<Rasteriser> rasteriser;  // Where the profile needs it.
  const std::unique_ptr<Denoiser> denoiser;
  const bool open_land;  // Light is learnt by a volume.
  // Filled by the first pair that is rendered: the volume in open land, else the cache.
  std::optional<RadianceCache> cache;
  std::optional<IrradianceVolume> volume;
  std::optional<KeptLeft> kept_left;  // The last left eye that other rigs share.
};

// A pair that is being rendered.
struct Shot {
  const v1::Rig& rig;
  const StereoCamera stereo;
  const Pairing pairing;
  const std::string eye_key;
  const KeptLeft* kept;  // The left eye, if it has been rendered for another rig; else null.
  TraceMeter meter;
  StereoFrame frame;
  float clamp = 0;  // Luminance at which paths' contributions are cut.

  View& view(int eye) { return eye == 0 ? frame.left : frame.right; }
};

struct Pass {
  std::string_view name;         // As FrameMap::pass.
  double StereoFrame::*seconds;  // Where its time is added; null: it adds that itself.
  int bytes_per_pixel;           // Memory for both eyes.
  // Returns the number of pixels that it traces, for the pair's progress; null: none.
  int64_t (*pixels)(const v1::Rig& rig);
  // Returns whether a rig has what the pass needs; null: every rig has.
  bool (*applies)(const v1::Rig& rig);
  // Fills its maps of shot.frame. Errors: kCancelled; kResourceExhausted; those of what it calls.
  absl::Status (*run)(PassScene& scene, Shot& shot, const CancelToken& cancel);
};

// Returns all passes in the order in which they run: a pass may read what those before it made.
std::span<const Pass* const> Passes();

}  // namespace parallax
