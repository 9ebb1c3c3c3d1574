// Samples of the lights of a scene for next-event estimation, and the densities that MIS needs.
//
// A light is chosen in proportion to an estimate of its contribution to a point: lamps by power
// over squared distance, the sky by the solid angle of an enclosure's openings, times the gains
// learnt there. Inside an enclosure the sky is sampled through its portals; elsewhere over the
// whole sphere. Sampling may miss part of a source: MIS gives that part to BSDF sampling.
#pragma once

#include <vector>

#include "common/math/lanes.h"
#include "worker/render/lights/light_table.h"

namespace parallax {

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
  Float8 importance;  // 0: none.
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

// Chooses and samples the lights of a table, which must outlive it. Thread-safe; cheap to copy.
class LightSampler {
 public:
  // With `sky` false, lamps and the sun alone are sampled.
  explicit LightSampler(const LightTable& lights, bool sky = true) : table_(&lights), sky_(sky) {}

  // Chooses one light for each query. `scratch` is reused memory. Lanes from `queries.count` on get
  // a total of 0.
  void Choose(const LightQueries8& queries, std::vector<Float8>* scratch,
              LightReceivers8* receivers, LightChoices8* choices) const;
  // Chooses the face that Sample will take for these `u`, and prefetches it.
  void Aim(Float8 u, LightChoices8* choices) const;
  // One sample for each receiver that has a light, from its random numbers u, v in [0, 1).
  void Sample(const LightReceivers8& at, const LightChoices8& choices, Float8 u, Float8 v,
              LightSamples8* samples) const;

  // The probability of choosing this light at the receiver.
  float Chance(const LightReceiver& at, size_t light) const;
  // The density, per solid angle, with which Sample finds a point of a mesh light's face at
  // `distance`, whose front is seen at `cosine`; 0 for faces that don't shine.
  float MeshPdf(const LightReceiver& at, uint32_t placed, uint16_t slot, float distance,
                float cosine) const;

  // Lanes whose rays meet a point light's sphere before `distance`.
  Mask8 MeetSpheres(const Vec3x8& origin, const Vec3x8& direction, Float8 distance) const;
  // Radiance of the point lights' spheres that the ray meets before `distance`, each weighted by
  // MIS against `bsdf_pdf` (infinity: unweighted).
  Vec3f SphereRadiance(const LightReceiver& at, const Vec3f& origin, const Vec3f& direction,
                       float distance, float bsdf_pdf) const;
  // Radiance of sky and sun along a ray that met nothing, weighted by MIS against `bsdf_pdf`
  // (infinity: unweighted).
  Vec3f EscapeRadiance(const LightReceiver& at, const Vec3f& direction, float bsdf_pdf) const;

 private:
  // The importance of a light: by power and distance, times the gains learnt in the cells. `in`:
  // the enclosure; null: outdoors.
  Float8 Importance(const Enclosure* in, const Vec3x8& position, Int8 cells, size_t light) const;
  float Importance(const LightReceiver& at, size_t light) const;
  Float8 PortalImportance(const Portal& portal, const Vec3x8& position) const;
  Float8 SunImportance(const Enclosure* in, const Vec3x8& position) const;
  float DomeImportance() const;
  // Chooses for the `members` of an enclosure; negative: outdoors.
  void ChooseIn(int32_t room, Mask8 members, const LightQueries8& queries,
                std::vector<Float8>* importances, LightReceivers8* receivers,
                LightChoices8* choices) const;

  // Sampling of the lanes whose light is of one kind.
  void SampleFaces(const LightReceivers8& at, const LightChoices8& choices, Mask8 lanes, Float8 u,
                   Float8 v, LightSamples8* samples) const;
  void SampleSpheres(const LightReceivers8& at, const LightChoices8& choices, Mask8 lanes, Float8 u,
                     Float8 v, LightSamples8* samples) const;
  void SampleSky(const LightReceivers8& at, const LightChoices8& choices, Mask8 lanes, Float8 u,
                 Float8 v, LightSamples8* samples) const;
  LightSample SampleSun(const Vec2f& u) const;

  // The density of sky directions, all ways to sample them included.
  Float8 SkyPdf(const LightReceivers8& at, const Vec3x8& directions) const;

  const LightTable* table_;
  bool sky_;
};

}  // namespace parallax
