// A river or a sea in a landscape: its line, the bed and banks that it shapes, and its surface with
// waves.
//
// A river's middle and a sea's shore are curved lines: sums of some waves along a straight axis.
// `u` runs along the axis, `v` across it. Constant; thread-safe. The same spec gives the same bits
// on every machine, because sines are noise::CosTurn, not the library's.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>
#include <vector>

#include "common/base/status.h"
#include "common/math/types.h"
#include "worker/materials/kernel/dual.h"

namespace parallax {

inline constexpr float kEarthRadius_m = 6.371e6f;

// Kinds of water.
enum class WaterKind { kRiver, kSea };
std::string_view WaterKindName(WaterKind kind);
// Returns the kind of that name. Errors: kInvalidArgument for an unknown name, listing the kinds.
absl::StatusOr<WaterKind> ParseWaterKind(std::string_view name);

// The fields of v1::Water, which documents them.
struct WaterSpec {
  WaterKind kind = WaterKind::kRiver;
  float direction_rad = 0, level_m = 0, fall = 0, bend_m = 200, swing_m = 20;
  float width_m = 12, depth_m = 1.2f, slope = 0.3f, bank_m = 1, plain_m = 30;
  uint32_t seed = 0;
  float wind_mps = 3, wind_rad = 0;
};

// Returns the geometric mean of width and length, in metres, of the patch of water that a pixel
// shows. Such a patch is `across_m` wide and, because it is seen at a grazing angle, the longer the
// farther away it is. `square_m` is the width of a patch that is as long as wide, which lies as far
// away as the eye is high. Waves shorter than twice the mean are not resolved.
float SeenWidth(float across_m, float square_m);

// One river or sea.
class Water {
 public:
  explicit Water(const WaterSpec& spec);

  const WaterSpec& spec() const { return spec_; }

  // Returns the world z of the still surface, over water and beside it. Includes the Earth's
  // curvature, as the ground's height does.
  float Level(const Vec2f& p) const;
  // Returns the approximate distance to the line where still water ends, metres; negative over
  // water.
  float FromShore(const Vec2f& p) const;
  // Returns the place at distance `from_shore_m` from the shore, at `along_m` along the axis.
  // `side` is 1 or -1 and chooses between a river's shores.
  Vec2f Beside(float along_m, float from_shore_m, float side) const;
  // Returns the distance from the shore beyond which water does not shape the land, which may then
  // lie below the water's level.
  float reach_m() const;

  // The land's height with bed, banks and beach, without the Earth's curvature, and the share of
  // the ground's detail that remains, because beds and beaches are smooth.
  struct Form {
    float height_m = 0, detail = 1;
  };
  Form Shaped(const Vec2f& p, float height_m) const;

  // Returns the height of the waves above Level, metres; only waves longer than twice the
  // footprint.
  float Waves(const Vec2f& p, float footprint_m) const;
  // Returns the approximate maximum of Waves.
  float most_wave_m() const { return most_wave_m_; }

  // Returns the height that waves shorter than the mesh's edges add to the surface, metres, with
  // its slopes along both tangents, for normals. `x` and `y` are a world position, `edge_m` is the
  // length of the mesh's edges there.
  Dual8 Ripples(const Dual8& x, const Dual8& y, Float8 edge_m, Float8 footprint_m) const;
  // Returns the mean square slope of the waves that neither the mesh nor the footprint shows.
  float LostSlope(const Vec2f& p, float footprint_m) const;

  // Returns the share of the surface that foam covers, before its pattern: 0 none, 1 closed.
  float Foam(const Vec2f& p, float depth_m) const;
  // Returns a position in the frame of drifting objects: along and across a river; for a sea, the
  // position itself.
  Vec2f Adrift(const Vec2f& p) const;

 private:
  // A wave of the curved line v = At(u).
  struct Bend {
    float turns_per_m = 0, phase = 0, height_m = 0;
  };
  struct OnLine {
    float v = 0, slope = 0, bow = 0;  // And its first and second derivative.
  };
  // A position in the water's own frame.
  struct Local {
    float u = 0, v = 0;  // Along the axis and across it.
    float from_shore_m = 0;
    float off = 0;      // River: from its middle, signed; sea: out from the shore.
    float half_m = 0;   // River: half of its width here.
    float outer = 0;    // River: how much this side is the outer one of a bend, [-1, 1].
    float riffle = 0;   // River: [0, 1], shallow and quick.
    float stretch = 1;  // Length of the line over that of its axis.
  };
  struct Wave {
    Vec2f turns_per_m;
    float phase = 0, height_m = 0, length_m = 1;
  };

  OnLine LineAt(float u) const;
  Local LocalOf(const Vec2f& p) const;
  float Wandering(float u, float wavelength_m, int which) const;
  float DetailShare(const Local& at) const;
  float RiverBed(const Local& at) const;
  float SeaBed(const Local& at) const;
  // Returns the depth of still water above its own bed's form, metres.
  float DepthAt(const Local& at) const;
  // Returns the share of a wave's height that remains in shallow water.
  float Kept(float length_m, float depth_m) const;
  struct Surf {
    float height_m = 0, crest = 0, strength = 0;
  };
  Surf SurfAt(const Local& at) const;
  float Swash(const Local& at) const;
  void MakeSeaWaves();
  void MakeRiverWaves();
  // Returns the height of the waves here, relative to Wave::height_m.
  float Liveliness(const Local& at) const;

  WaterSpec spec_;
  Vec2f ahead_, left_;  // Along the axis and to its left; a sea lies right of its shore.
  std::vector<Bend> bends_;
  std::array<float, 12> phases_;
  std::vector<Wave> waves_;  // In order of length, the longest first.
  float lost_slope_ = 0;     // Mean square slope of waves shorter than all of `waves_`.
  float most_wave_m_ = 0;
};

}  // namespace parallax
