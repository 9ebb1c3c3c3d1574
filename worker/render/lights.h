// All light sources of a scene, chosen by what they can give to a point: lamps by power over
// squared distance, the sky by the solid angle of an enclosure's openings. For next-event
// estimation and for the density that MIS needs.
//
// Point lights are spheres that only light sees: the camera looks through them, mirrors show them.
// Spot lights are such spheres that shine into a cone.
// Mesh lights shine from the front of their faces. Inside of one of the surroundings' enclosures
// the sky is sampled through its portals; elsewhere over the whole sphere. Sampling that misses
// part of a source is no error: MIS gives that part to BSDF sampling. Constant after Build but for
// Learn; queries are thread-safe.
#pragma once

#include <array>
#include <limits>
#include <span>
#include <vector>

#include "parallax/v1/scene.pb.h"
#include "worker/render/bright_spots.h"
#include "worker/render/haze.h"
#include "worker/render/light_gains.h"
#include "worker/render/render_scene.h"
#include "worker/render/sky.h"

namespace parallax {

// A way out of a room for light from the sky.
struct Portal {
  Vec3f corner, edge_u, edge_v, normal;  // Normal points out of the room.
  float area = 0;
  Vec3f center() const { return corner + 0.5f * (edge_u + edge_v); }
};

// A portal as the sun shines through it: where the way to the sun from a point p crosses it, in
// widths and heights of the portal: from + along.p.
struct SunWindow {
  Vec3f along_u, along_v;
  float from_u = 0, from_v = 0;
};

// A room up to the outer faces of its walls, say: SkyEnclosure with what sampling adds to it.
struct Enclosure {
  Box3f box;
  std::vector<Portal> portals;
  std::vector<SunWindow> sun_windows;  // Portals that face the sun.
  LightGains gains;                    // Gains of lamps, portals and sun.
  BrightSpots spots;                   // Bright spots of its surfaces.
};

// A point that gathers light, with what choosing among lights needs to be computed once.
struct LightReceiver {
  Vec3f position = Vec3f::Zero();
  int32_t room = -1;  // That it is in, of the table's; none: outdoors.
  int32_t cell = 0;   // Cell of the room's gains.
  float total = 0;    // Sum of importances.
};

struct LightReceivers8 {
  Vec3x8 position;
  Int8 room, cell;
  Float8 total;

  // One for all.
  static LightReceivers8 All(const LightReceiver& at) {
    return {Vec3x8(at.position), Int8{} + at.room, Int8{} + at.cell, Splat(at.total)};
  }
  LightReceiver Get(int lane) const {
    return {position.Get(lane), room[lane], cell[lane], total[lane]};
  }
};

// The result of one light sample, for LightTable::Learn.
struct LightTrial {
  int32_t room = -1;  // Index of the table's room; negative: nothing to be learnt.
  int32_t cell = 0;
  int32_t light = 0;
  float gain = 0;
};

// Light that a surface was seen to scatter, for LightTable::Learn.
struct LightSeen {
  Vec3f position = Vec3f::Zero();
  Vec3f normal = Vec3f::UnitZ();
  float radiance = 0;  // Luminance.
};

// Up to eight points of surfaces, each seen from the side of `normal`, that will take a sample of
// one light each: `choice` in [0, 1) picks it.
struct LightQueries8 {
  Vec3x8 position, normal;
  Float8 choice;
  int count = 0;
};

// The lights that receivers will take a sample of.
struct LightChoices8 {
  Int8 light;         // Lamps come first, then portals or dome, then sun.
  Float8 importance;  // 0: there is none.
  Int8 face;          // Face of a mesh light; set by Aim.
};

struct LightSample {
  Vec3f direction = Vec3f::UnitZ();
  float distance = 0;              // Free path that must be unoccluded; infinity for the sky.
  Vec3f radiance = Vec3f::Zero();  // For an ideal point: intensity / distance^2, with pdf = the
                                   // chance of choosing it.
  float pdf = 0;       // Per solid angle, the choice of the light included; 0 = no light.
  bool ideal = false;  // No other strategy can find it.
};

struct LightSamples8 {
  Vec3x8 direction, radiance;
  Float8 distance, pdf;
  Mask8 ideal;

  void Set(int lane, const LightSample& sample);
  LightSample Get(int lane) const;
};

class LightTable {
 public:
  // Errors: kInvalidArgument for a light of unknown kind.  A mesh light without faces is left out.
  static absl::StatusOr<LightTable> Build(const v1::Scene& scene, const RenderScene& geometry);

  // `scratch` is kept for the next time. Lanes beyond `queries.count` are no receivers: total 0.
  void Choose(const LightQueries8& queries, std::vector<Float8>* scratch,
              LightReceivers8* receivers, LightChoices8* choices) const;
  // Finds what of the lights Sample will take for these `u`, and begins to fetch it from memory.
  void Aim(Float8 u, LightChoices8* choices) const;
  // One sample for each receiver that has a light, from its random numbers u, v in [0, 1).
  void Sample(const LightReceivers8& at, const LightChoices8& choices, Float8 u, Float8 v,
              LightSamples8* samples) const;

  // With which a receiver's light is this one.
  float Chance(const LightReceiver& at, size_t light) const;

  // The outcome of a sample of density `pdf` of which this much irradiance arrived.
  LightTrial Trial(const LightReceiver& at, int32_t light, float pdf, float irradiance) const;
  // Chooses lights by these from now on, and those learnt before. Not while samples are taken.
  void Learn(std::span<const std::vector<LightTrial>> trials);
  void Learn(std::span<const std::vector<LightSeen>> seen);
  // As if nothing had been learnt.
  void Forget();

  // Front radiance of a mesh light's face, zero for other faces; and the density with which Sample
  // would have found the point `distance` away along `direction`.
  int32_t MeshLight(uint32_t placed, uint16_t slot) const {  // Which light it is, or -1.
    const SlotLights& lights = lights_of_body_[placed];
    return slot < lights.count ? mesh_lights_[lights.first + slot] : -1;
  }
  Vec3f MeshRadiance(uint32_t placed, uint16_t slot) const;
  float MeshPdf(const LightReceiver& at, uint32_t placed, uint16_t slot, float distance,
                float cosine) const;

  // Which rays meet a point light's sphere before `distance`.
  Mask8 MeetSpheres(const Vec3x8& origin, const Vec3x8& direction, Float8 distance) const;
  // Radiance of point lights' spheres that the ray meets before `distance`, each weighted by MIS
  // against `bsdf_pdf`.
  Vec3f SphereRadiance(const LightReceiver& at, const Vec3f& origin, const Vec3f& direction,
                       float distance, float bsdf_pdf) const;
  // Sky and sun along a direction that met nothing, weighted by MIS against `bsdf_pdf` (infinity:
  // not weighted).
  Vec3f EscapeRadiance(const LightReceiver& at, const Vec3f& direction, float bsdf_pdf) const;

  const SkyModel& sky() const { return sky_; }
  const Haze& haze() const { return haze_; }
  // None outdoors.
  const BrightSpots* SpotsIn(int32_t room) const {
    return room < 0 ? nullptr : &RoomAt(room)->spots;
  }
  bool empty() const { return lamps_.empty() && !sky_.has_sky() && !sky_.has_sun(); }
  // The number of portals of all rooms.
  size_t portals() const;

 private:
  struct alignas(64) Face {  // One line of the cache: they are met at random.
    Vec3f corner, edge_u, edge_v;
    Vec3f back;       // Unit, away from where it shines.
    float below = 0;  // Area of the faces before it, m^2.
    float area = 0;
    float unused[2] = {};  // Loaded with the rest.
  };

  struct Lamp {
    Vec3f center = Vec3f::Zero();
    float radius = 0;  // Radius of the sphere, or of one around a mesh light's faces.
    Vec3f radiance = Vec3f::Zero();
    Vec3f intensity = Vec3f::Zero();  // Ideal points.
    float strength = 0;               // Luminance of the flux, as seen from any side.
    // Spot lights; the others shine to all sides.
    bool spot = false;
    Vec3f axis = Vec3f::UnitZ();
    float cos_outer = -1, cos_inner = -1;  // Dark beyond the first, full within the second.

    // Part of the full intensity that goes along unit `direction`, away from the lamp.
    float Falloff(const Vec3f& direction) const {
      if (!spot) return 1.0f;
      const float cosine = direction.dot(axis);
      if (cosine >= cos_inner) return cosine > cos_outer ? 1.0f : 0.0f;
      if (cosine <= cos_outer) return 0.0f;
      const float t = (cosine - cos_outer) / (cos_inner - cos_outer);
      return t * t * (3.0f - 2.0f * t);
    }
    // Mesh lights.
    std::vector<Face> faces;
    // For equal parts of the area, the face with which each begins and where that face ends. One
    // for all where there are no faces.
    struct Guide {
      uint32_t face = 0;
      float end = 0;
    };
    std::vector<Guide> guides = {{0, kInfinity}};
    float area = 0;  // Total area of the faces, m^2.
    float guides_per_m2 = 0;
    bool mesh = false;

    bool AddFace(const Vec3f corners[3]);
    void MakeGuides();
    // That of a place in the cumulative area.
    const Guide& GuideAt(float at) const {
      const auto part = static_cast<size_t>(static_cast<uint32_t>(at * guides_per_m2));
      return guides[std::min(part, guides.size() - 1)];
    }
    // Which stands there.
    uint32_t FaceAt(float at) const;
  };

  // None outdoors.
  const Enclosure* RoomAt(int32_t room) const {
    return room < 0 ? nullptr : &enclosures_[static_cast<size_t>(room)];
  }
  // `in`: the room; none: outdoors.
  size_t LightsIn(const Enclosure* in) const;
  // By power and distance, and what was learnt in the cells.
  Float8 Importance(const Enclosure* in, const Vec3x8& position, Int8 cells, size_t light) const;
  float Importance(const LightReceiver& at, size_t light) const;
  static absl::Status AddSphereOrSpot(const v1::Light& light, const Vec3f& power, Lamp* lamp);
  Float8 LampImportance(const Lamp& lamp, const Vec3x8& position) const;
  Float8 PortalImportance(const Portal& portal, const Vec3x8& position) const;
  Float8 SunImportance(const Enclosure* in, const Vec3x8& position) const;
  float DomeImportance() const;
  void ChooseIn(int32_t room, Mask8 members, const LightQueries8& queries,
                std::vector<Float8>* importances, LightReceivers8* receivers,
                LightChoices8* choices) const;
  Float8 SkyPdf(const LightReceivers8& at, const Vec3x8& directions) const;
  // In lanes: those of mesh lights, and those of spheres and spots.
  void SampleFaces(const LightReceivers8& at, const LightChoices8& choices, Mask8 lanes, Float8 u,
                   Float8 v, LightSamples8* samples) const;
  void SampleSpheres(const LightReceivers8& at, const LightChoices8& choices, Mask8 lanes, Float8 u,
                     Float8 v, LightSamples8* samples) const;
  LightSample SampleIdeal(const Lamp& lamp, const Vec3f& position) const;
  void SampleSky(const LightReceivers8& at, const LightChoices8& choices, Mask8 lanes, Float8 u,
                 Float8 v, LightSamples8* samples) const;
  LightSample SampleSun(const Vec2f& u) const;
  void AddEnclosure(const SkyEnclosure& from, const RenderScene& geometry);
  void AddSunWindows(Enclosure* enclosure) const;

  SkyModel sky_;
  Haze haze_;
  std::vector<Lamp> lamps_;
  Lamp no_lamp_;  // Stands in for sky and sun where all eight lights are treated alike.
  // The kind of each lamp, then that of no lamp: floats, to be gathered into lanes.
  static constexpr float kFaces = 0, kSphere = 1, kIdeal = 2, kNoLamp = 3;
  std::vector<float> kinds_;
  std::vector<size_t> spheres_;  // Indices into `lamps_`.
  std::vector<Enclosure> enclosures_;
  struct SlotLights {
    uint32_t first = 0, count = 0;  // In mesh_lights_.
  };
  std::vector<SlotLights> lights_of_body_;
  std::vector<int32_t> mesh_lights_;  // Lamp or -1 of each slot of the bodies that have lights.
};

}  // namespace parallax
