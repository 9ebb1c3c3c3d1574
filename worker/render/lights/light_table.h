// All light sources of a scene: lamps, the openings through which rooms receive skylight, sky and
// sun, haze. How they are chosen and sampled: light_sampler.h. What is learnt about them:
// light_learning.h.
//
// Point lights are spheres that only light sees: the camera looks through them, mirrors show them.
// Spot lights are such spheres that shine into a cone. Mesh lights shine from the front of their
// faces.
#pragma once

#include <span>
#include <vector>

#include "parallax/v1/scene.pb.h"
#include "worker/render/lights/bright_spots.h"
#include "worker/render/lights/haze.h"
#include "worker/render/lights/lamp.h"
#include "worker/render/lights/light_gains.h"
#include "worker/render/lights/sky.h"
#include "worker/render/scene/render_scene.h"

namespace parallax {

// An opening through which a room receives skylight.
struct Portal {
  Vec3f corner, edge_u, edge_v, normal;  // Normal points out of the room.
  float area = 0;
  Vec3f center() const { return corner + 0.5f * (edge_u + edge_v); }
};

// A portal as the sun shines through it. The line from point p to the sun crosses the portal at
// from + dot(along, p), in widths and heights of the portal.
struct SunWindow {
  Vec3f along_u, along_v;
  float from_u = 0, from_v = 0;
};

// A room up to the outer faces of its walls: a SkyEnclosure with the data for sampling.
struct Enclosure {
  Box3f box;
  std::vector<HalfSpace> within;
  std::vector<Portal> portals;
  std::vector<SunWindow> sun_windows;  // Portals that face the sun.
  LightGains gains;                    // Gains of lamps, portals and sun.
  BrightSpots spots;                   // Bright spots of its surfaces.

  // Return which points it holds.
  Mask8 Holds(const Vec3x8& points) const;
  bool Holds(const Vec3f& point) const { return Holds(Vec3x8(point))[0] != 0; }
};

// The table of a scene's lights. A light's index at a point counts lamps first, then the portals of
// the point's enclosure (outdoors: the dome, as one light), then the sun. Thread-safe except for
// the mutable enclosures.
class LightTable {
 public:
  // Mesh lights without faces are left out. Errors: kInvalidArgument for a light of unknown kind or
  // a spot without a cone; those of OpenEnvironment.
  static absl::StatusOr<LightTable> Build(const v1::Scene& scene, const RenderScene& geometry);

  const std::vector<Lamp>& lamps() const { return lamps_; }
  // The lamp with this index; for portals, sky and sun one without faces, so that all eight lanes
  // can be treated alike.
  const Lamp& LampAt(size_t light) const {
    return light < lamps_.size() ? lamps_[light] : no_lamp_;
  }
  // Indices of the lamps that are spheres.
  std::span<const size_t> spheres() const { return spheres_; }

  // The kinds of lamps, as floats so that they can be gathered into lanes: for each lamp its kind,
  // then one entry kNoLamp.
  static constexpr float kFaces = 0, kSphere = 1, kIdeal = 2, kNoLamp = 3;
  std::span<const float> kinds() const { return kinds_; }

  // The enclosure with this index; null for a negative one: outdoors.
  const Enclosure* EnclosureAt(int32_t room) const {
    return room < 0 ? nullptr : &enclosures_[static_cast<size_t>(room)];
  }
  const std::vector<Enclosure>& enclosures() const { return enclosures_; }
  // For learning, which must not run while lights are sampled.
  std::vector<Enclosure>& mutable_enclosures() { return enclosures_; }
  // The number of portals of all enclosures.
  size_t portals() const;
  // The number of lights that shine into an enclosure; null: outdoors.
  size_t LightsIn(const Enclosure* in) const {
    return lamps_.size() + (in ? in->portals.size() : 1) + 1;
  }

  // The index of the mesh light that this slot of a placed mesh is, or -1.
  int32_t MeshLight(uint32_t placed, uint16_t slot) const {
    const SlotLights& lights = lights_of_body_[placed];
    return slot < lights.count ? mesh_lights_[lights.first + slot] : -1;
  }
  // The radiance of a slot's faces; zero for those that don't shine.
  Vec3f MeshRadiance(uint32_t placed, uint16_t slot) const;

  const SkyModel& sky() const { return sky_; }
  const Haze& haze() const { return haze_; }
  bool empty() const { return lamps_.empty() && !sky_.has_sky() && !sky_.has_sun(); }

 private:
  struct SlotLights {
    uint32_t first = 0, count = 0;  // In mesh_lights_.
  };

  absl::Status AddLight(const v1::Light& light, const RenderScene& geometry);
  void AddMeshLight(const v1::Light& light, const Vec3f& power_w, const RenderScene& geometry);
  // Adds to the lamp the faces of one placed mesh that the light shines from.
  void AddFaces(const v1::Light& light, const RenderScene& geometry, uint32_t placed, Lamp* lamp,
                Box3f* box);
  void AddEnclosure(const SkyEnclosure& from, const RenderScene& geometry);
  void AddSunWindows(Enclosure* enclosure) const;

  SkyModel sky_;
  Haze haze_;
  std::vector<Lamp> lamps_;
  Lamp no_lamp_;
  std::vector<float> kinds_;
  std::vector<size_t> spheres_;  // Indices into `lamps_`.
  std::vector<Enclosure> enclosures_;
  std::vector<SlotLights> lights_of_body_;
  std::vector<int32_t> mesh_lights_;  // Lamp or -1 of each slot of the bodies that have lights.
};

}  // namespace parallax
