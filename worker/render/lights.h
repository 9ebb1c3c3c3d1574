// All light sources of a scene, chosen in proportion to an estimate of their contribution to a
// point: lamps by power over squared distance, the sky by the solid angle of an enclosure's
// openings. Used for next-event estimation and for the densities that MIS needs.
//
// Point lights are spheres that only light sees: the camera looks through them, mirrors show them.
// Spot lights are such spheres that shine into a cone. Mesh lights shine from the front of their
// faces. Inside one of the surroundings' enclosures the sky is sampled through its portals;
// elsewhere over the whole sphere. Sampling may miss part of a source: MIS gives that part to BSDF
// sampling.
//
// Constant after Build except for Learn; queries are thread-safe.
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
  std::vector<Portal> portals;
  std::vector<SunWindow> sun_windows;  // Portals that face the sun.
  LightGains gains;                    // Gains of lamps, portals and sun.
  BrightSpots spots;                   // Bright spots of its surfaces.
};

// A point that gathers light, with data that is computed once for choosing among lights.
struct LightReceiver {
  Vec3f position = Vec3f::Zero();
  int32_t room = -1;  // Index of its room in the table; negative: outdoors.
  int32_t cell = 0;   // Cell of the room's gains.
  float total = 0;    // Sum of importances.
};

// Eight receivers.
struct LightReceivers8 {
  Vec3x8 position;
  Int8 room, cell;
  Float8 total;

  // The same receiver in all lanes.
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

// Light that a surface scattered towards a path, for LightTable::Learn.
struct LightSeen {
  Vec3f position = Vec3f::Zero();
  Vec3f normal = Vec3f::UnitZ();
  float radiance = 0;  // Luminance.
};

// Up to eight surface points, each seen from the side of `normal`, that will take one light sample
// each. `choice` in [0, 1) picks the light.
struct LightQueries8 {
  Vec3x8 position, normal;
  Float8 choice;
  int count = 0;
};

// The light chosen for each receiver.
struct LightChoices8 {
  Int8 light;         // Index: lamps, then portals or dome, then sun.
  Float8 importance;  // 0: there is none.
  Int8 face;          // Face of a mesh light; set by Aim.
};

// One light sample at a receiver, for next-event estimation.
struct LightSample {
  Vec3f direction = Vec3f::UnitZ();
  float distance = 0;              // Free path that must be unoccluded; infinity for the sky.
  Vec3f radiance = Vec3f::Zero();  // For an ideal point: intensity / distance^2, with pdf = the
                                   // chance of choosing it.
  float pdf = 0;       // Per solid angle, the choice of the light included; 0 = no light.
  bool ideal = false;  // No other strategy can find it.
};

// Eight light samples.
struct LightSamples8 {
  Vec3x8 direction, radiance;
  Float8 distance, pdf;
  Mask8 ideal;

  void Set(int lane, const LightSample& sample);
  LightSample Get(int lane) const;
};

// The table of a scene's lights.
class LightTable {
 public:
  // Errors: kInvalidArgument for a light of unknown kind. Mesh lights without faces are left out.
  static absl::StatusOr<LightTable> Build(const v1::Scene& scene, const RenderScene& geometry);

  // Chooses one light for each query. `scratch` is reused memory. Lanes from `queries.count` on get
  // a total of 0.
  void Choose(const LightQueries8& queries, std::vector<Float8>* scratch,
              LightReceivers8* receivers, LightChoices8* choices) const;
  // Chooses the face that Sample will take for these `u`, and prefetches it.
  void Aim(Float8 u, LightChoices8* choices) const;
  // One sample for each receiver that has a light, from its random numbers u, v in [0, 1).
  void Sample(const LightReceivers8& at, const LightChoices8& choices, Float8 u, Float8 v,
              LightSamples8* samples) const;

  // Probability of choosing this light at the receiver.
  float Chance(const LightReceiver& at, size_t light) const;

  // The trial of a sample with density `pdf` of which this much irradiance arrived.
  LightTrial Trial(const LightReceiver& at, int32_t light, float pdf, float irradiance) const;
  // Uses these trials, and earlier ones, for future choices. Must not run while samples are taken.
  void Learn(std::span<const std::vector<LightTrial>> trials);
  // Uses this scattered light, and earlier, to find the bright spots. Likewise.
  void Learn(std::span<const std::vector<LightSeen>> seen);
  // Discards all that was learnt.
  void Forget();

  // A mesh light's face: its index, its radiance (zero for other faces), and the density with which
  // Sample would have found its point at `distance`.
  int32_t MeshLight(uint32_t placed, uint16_t slot) const {  // The light's index, or -1.
    const SlotLights& lights = lights_of_body_[placed];
    return slot < lights.count ? mesh_lights_[lights.first + slot] : -1;
  }
  Vec3f MeshRadiance(uint32_t placed, uint16_t slot) const;
  float MeshPdf(const LightReceiver& at, uint32_t placed, uint16_t slot, float distance,
                float cosine) const;

  // Lanes whose rays meet a point light's sphere before `distance`.
  Mask8 MeetSpheres(const Vec3x8& origin, const Vec3x8& direction, Float8 distance) const;
  // Radiance of the point lights' spheres that the ray meets before `distance`, each weighted by
  // MIS against `bsdf_pdf`.
  Vec3f SphereRadiance(const LightReceiver& at, const Vec3f& origin, const Vec3f& direction,
                       float distance, float bsdf_pdf) const;
  // Radiance of sky and sun along a ray that met nothing, weighted by MIS against `bsdf_pdf`
  // (infinity: unweighted).
  Vec3f EscapeRadiance(const LightReceiver& at, const Vec3f& direction, float bsdf_pdf) const;

  const SkyModel& sky() const { return sky_; }
  const Haze& haze() const { return haze_; }
  // Null outdoors.
  const BrightSpots* SpotsIn(int32_t room) const {
    return room < 0 ? nullptr : &RoomAt(room)->spots;
  }
  bool empty() const { return lamps_.empty() && !sky_.has_sky() && !sky_.has_sun(); }
  // The number of portals of all rooms.
  size_t portals() const;

 private:
  struct alignas(64) Face {  // One cache line: faces are read at random.
    Vec3f corner, edge_u, edge_v;
    Vec3f back;       // Unit, opposite to the side that shines.
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
    // Only spot lights have a cone; the others shine to all sides.
    bool spot = false;
    Vec3f axis = Vec3f::UnitZ();
    float cos_outer = -1, cos_inner = -1;  // Dark beyond the first, full within the second.

    // Share of the full intensity along unit `direction`, away from the lamp.
    float Falloff(const Vec3f& direction) const {
      if (!spot) return 1.0f;
      const float cosine = direction.dot(axis);
      if (cosine >= cos_inner) return cosine > cos_outer ? 1.0f : 0.0f;
      if (cosine <= cos_outer) return 0.0f;
      const float t = (cosine - cos_outer) / (cos_inner - cos_outer);
      return t * t * (3.0f - 2.0f * t);
    }
    // Mesh lights only:
    std::vector<Face> faces;
    // An index into the faces' cumulative area: for each of its equal parts, the first face and the
    // end of that face. One entry where there are no faces.
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
    // The entry for a position in the cumulative area.
    const Guide& GuideAt(float at) const {
      const auto part = static_cast<size_t>(static_cast<uint32_t>(at * guides_per_m2));
      return guides[std::min(part, guides.size() - 1)];
    }
    // The face at a position in the cumulative area.
    uint32_t FaceAt(float at) const;
  };

  // Null outdoors.
  const Enclosure* RoomAt(int32_t room) const {
    return room < 0 ? nullptr : &enclosures_[static_cast<size_t>(room)];
  }
  // `in`: the room; null: outdoors.
  size_t LightsIn(const Enclosure* in) const;
  // Importance by power and distance, times the gains learnt in the cells.
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
  // Sampling in lanes: mesh lights, then spheres and spots.
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
  Lamp no_lamp_;  // Placeholder for sky and sun where all eight lanes are treated alike.
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
