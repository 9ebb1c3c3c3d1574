#include "worker/assets/building/staircases.h"

#include <algorithm>
#include <cmath>
#include <functional>

namespace parallax {
namespace {

using namespace kernel;  // NOLINT: the modelling vocabulary of this folder.

MaterialSlot TreadSlot() { return Slot("treads", {"wood", "stone", "metal"}); }
MaterialSlot FrameSlot() { return Slot("frame", {"paint", "metal", "wood"}); }
MaterialSlot RailSlot() { return Slot("rail", {"wood", "metal"}); }
MaterialSlot PostSlot() { return Slot("posts", {"metal", "wood", "paint"}); }

// A flight as a strip of the plan: the point at step s (a real number from 0 at the foot) and side
// in [-1, 1], left to right of who climbs. z is 0 at s = 0 and rises by one rise a step.
using Flight = std::function<Vec3f(float s, float side)>;

// An upright prism over a piece of the strip, its top at z; the corners follow the strip in
// `pieces` chords.
Shape StripPiece(const Flight& flight, float s0, float s1, float side0, float side1, float z0,
                 float z1, int pieces, float bevel) {
  Path2 outline;
  for (int i = 0; i <= pieces; ++i)
    outline.push_back(
        flight(Lerp(s0, s1, static_cast<float>(i) / static_cast<float>(pieces)), side1).head<2>());
  for (int i = pieces; i >= 0; --i)
    outline.push_back(
        flight(Lerp(s0, s1, static_cast<float>(i) / static_cast<float>(pieces)), side0).head<2>());
  float area = 0;
  for (size_t i = 0; i < outline.size(); ++i) {
    const Vec2f &a = outline[i], &b = outline[(i + 1) % outline.size()];
    area += a.x() * b.y() - a.y() * b.x();
  }
  if (area < 0) std::reverse(outline.begin(), outline.end());
  return Extrude(outline, z1 - z0, bevel).Moved(0, 0, z0).Retextured();
}

// The strip's line at one side, lifted.
Path3 Along(const Flight& flight, float s0, float s1, float side, float lift, float step) {
  Path3 path;
  const int n = std::max(1, static_cast<int>(std::ceil((s1 - s0) / step)));
  for (int i = 0; i <= n; ++i)
    path.push_back(flight(Lerp(s0, s1, static_cast<float>(i) / static_cast<float>(n)), side) +
                   Vec3f(0, 0, lift));
  return path;
}

Shape Ribbon(const Path3& path, float thickness, float height, float bevel) {
  return Sweep(path, RectSection(thickness, height, bevel, 1),
               {.up = Vec3f::UnitZ(), .keep_up = true});
}

struct FlightBuilder {
  AssetBuilder& b;
  const StairParams& p;
  Flight flight;
  bool bends = false;  // Chords are short then.
  float base_z = 0;    // Height of the floor below.

  float Step() const { return bends ? 0.25f : 100.0f; }

  void Steps(int count) {
    for (int i = 0; i < count; ++i) {
      const float s = static_cast<float>(i), top = flight(s + 1, 0).z();
      const float nose = p.body == StairBody::kSolid ? 0.0f : 0.1f;
      const int pieces = bends ? 3 : 1;
      if (p.body == StairBody::kSolid) {
        // Masonry: a block from two steps below (or the floor) with a slab of the tread's stone on
        // it.
        const float under = std::max(base_z, top - 2.2f * p.rise_m);
        b.Add(StripPiece(flight, s, s + 1, -1, 1, under, top - p.tread_m, pieces, 0.0f),
              FrameSlot());
        b.Add(StripPiece(flight, s - 0.06f, s + 1, -1.02f, 1.02f, top - p.tread_m - 0.0005f, top,
                         pieces, 0.004f),
              TreadSlot());
        continue;
      }
      b.Add(StripPiece(flight, s - nose, s + 1.02f, -0.985f, 0.985f, top - p.tread_m, top, pieces,
                       0.005f),
            TreadSlot());
      if (p.body == StairBody::kClosed) {
        b.Add(StripPiece(flight, s, s + 0.07f, -0.97f, 0.97f, top - p.rise_m - 0.001f,
                         top - p.tread_m + 0.001f, pieces, 0.001f),
              FrameSlot());
      }
    }
  }
  void Stringers(float s0, float s1) {
    if (p.body == StairBody::kSolid) return;
    if (p.body == StairBody::kClosed) {
      for (const float side : {-1.0f, 1.0f})
        b.Add(Ribbon(Along(flight, s0, s1, side, 0.01f, Step()), 0.04f, 0.3f, 0.004f), FrameSlot());
    } else {
      for (const float side : {-0.72f, 0.72f})
        b.Add(Ribbon(Along(flight, s0, s1, side, -0.06f, Step()), 0.06f, 0.14f, 0.004f),
              FrameSlot());
    }
  }
  // Adds a rail from s0 to s1 along one side: hand rail, its filling, a newel at both ends.
  void Rail(float s0, float s1, float side) {
    const float height = p.rail_height_m + p.rise_m;
    b.Add(Sweep(Along(flight, s0, s1, side, height, Step()), EllipseSection(0.05f, 0.042f, 16),
                RailOptions()),
          RailSlot());
    for (const float s : {s0, s1}) {
      const Vec3f foot = flight(s, side);
      const float low = std::max(base_z, foot.z() - 0.02f);
      b.Add(Bar({foot.x(), foot.y(), low}, {foot.x(), foot.y(), foot.z() + height + 0.06f},
                {0.055f, 0.055f}, {0.055f, 0.055f}, 0.005f, Vec3f::UnitY()),
            PostSlot());
      b.Add(Ball(0.034f, 18).Moved(foot.x(), foot.y(), foot.z() + height + 0.08f), PostSlot());
    }
    if (p.rail == StairRail::kBalusters) {
      const int count = static_cast<int>((s1 - s0) * 2);
      for (int i = 0; i < count; ++i) {
        const float s = s0 + (static_cast<float>(i) + 0.5f) * (s1 - s0) / static_cast<float>(count);
        const Vec3f foot = flight(s, 0.985f * side);
        b.Add(Rod({foot.x(), foot.y(), foot.z() + (p.body == StairBody::kClosed ? 0.1f : 0.0f)},
                  {foot.x(), foot.y(), foot.z() + height - 0.012f}, 0.009f, 0.009f),
              PostSlot());
      }
    } else if (p.rail == StairRail::kCables) {
      for (const float t : {0.25f, 0.42f, 0.59f, 0.76f}) {
        b.Add(Sweep(Along(flight, s0, s1, side, t * height, Step()),
                    EllipseSection(0.012f, 0.012f, 8), {}),
              PostSlot());
      }
      const int count = std::max(1, static_cast<int>((s1 - s0) / 3));
      for (int i = 1; i < count; ++i) {
        const Vec3f foot =
            flight(Lerp(s0, s1, static_cast<float>(i) / static_cast<float>(count)), side);
        b.Add(Rod(foot, foot + Vec3f(0, 0, height), 0.014f, 0.014f), PostSlot());
      }
    } else {
      b.Add(Ribbon(Along(flight, s0 + 0.1f, s1 - 0.1f, side, 0.55f * height, Step()), 0.012f,
                   0.78f * height, 0.002f),
            GlassSlot("panes"));
    }
  }

  // The one flight of a staircase, with the rails that the parameters ask for.
  Asset Whole() {
    const float n = static_cast<float>(p.steps);
    Steps(p.steps);
    Stringers(0.35f, n);
    if (p.rail_left) Rail(0.15f, n - 0.2f, -1);
    if (p.rail_right) Rail(0.15f, n - 0.2f, 1);
    return b.Finish();
  }

 private:
  static SweepOptions RailOptions() {
    return {.end_round_m = 0.015f, .up = Vec3f::UnitZ(), .keep_up = true};
  }
};

// Straight away from the front, from y = `start`, its middle at x.
Flight StraightFlight(const StairParams& p, float x, float start, float direction, float z) {
  return [=](float s, float side) {
    return Vec3f(x - direction * side * -0.5f * p.width_m, start - direction * s * p.run_m,
                 z + s * p.rise_m);
  };
}

// Around the z axis from angle 0, anticlockwise seen from above: who climbs has the axis on the
// left.
Flight TurningFlight(float radius, float half_width, float turn_per_step, float rise) {
  return [=](float s, float side) {
    const float r = radius + side * half_width, a = s * turn_per_step;
    return Vec3f(r * std::cos(a), r * std::sin(a), s * rise);
  };
}

Asset MakeStraightStaircase(const StairParams& p) {
  AssetBuilder b(p.seed);
  return FlightBuilder{b, p, StraightFlight(p, 0, 0, 1, 0)}.Whole();
}

Asset MakeCurvedStaircase(const StairParams& p) {
  AssetBuilder b(p.seed);
  const float n = static_cast<float>(p.steps);
  const float radius = std::max(p.run_m * n / p.turn_rad, 0.5f * p.width_m + 0.4f);
  return FlightBuilder{b, p, TurningFlight(radius, 0.5f * p.width_m, p.turn_rad / n, p.rise_m),
                       true}
      .Whole();
}

// A landing at height `z`: floor on a frame on legs, or masonry down to the ground. It is 2 `w`
// wide and reaches from y = `far` on by `depth`.
void AddLanding(AssetBuilder& b, const StairParams& p, float w, float far, float z) {
  const float depth = p.width_m;
  b.Add(Board({-w, far - depth, z - p.tread_m}, {w, far + 0.03f, z}, 0.004f), TreadSlot());
  if (p.body == StairBody::kSolid) {
    b.Add(Board({-w + 0.004f, far - depth + 0.004f, z - 0.3f},
                {w - 0.004f, far, z - p.tread_m + 0.001f}, 0.001f),
          FrameSlot());
  }
  b.Add(Board({-w + 0.01f, far - depth + 0.01f, z - 0.16f},
              {w - 0.01f, far - depth + 0.06f, z - p.tread_m + 0.002f}, 0.002f),
        FrameSlot());
  b.Add(Board({-w + 0.01f, far - 0.05f, z - 0.16f},
              {w - 0.01f, far - 0.001f, z - p.tread_m + 0.0015f}, 0.002f),
        FrameSlot());
  for (const float sx : {-1.0f, 1.0f}) {
    b.Add(Board({sx * (w - 0.012f), far - depth + 0.012f, z - 0.15f},
                {sx * (w - 0.06f), far - 0.002f, z - p.tread_m + 0.001f}, 0.002f),
          FrameSlot());
    for (const float y : {far - depth + 0.06f, far - 0.06f}) {
      b.Add(Bar({sx * (w - 0.05f), y, 0}, {sx * (w - 0.05f), y, z - 0.12f}, {0.07f, 0.07f},
                {0.07f, 0.07f}, 0.004f, Vec3f::UnitY()),
            FrameSlot());
    }
  }
}

}  // namespace

Asset MakeSpiralStaircase(const StairParams& p) {
  AssetBuilder b(p.seed);
  const float n = static_cast<float>(p.steps), pole = 0.055f;
  // Treads are wedges that reach into the pole.
  StairParams own = p;
  own.body = StairBody::kOpen;
  const float inner = 0.6f * pole, outer = pole + p.width_m;
  FlightBuilder f{
      b, own,
      TurningFlight(0.5f * (inner + outer), 0.5f * (outer - inner), p.turn_rad / n, p.rise_m),
      true};
  f.Steps(p.steps);
  b.Add(Cylinder(pole, p.rise_m * n + p.rail_height_m + 0.15f, 0.01f, 28), FrameSlot());
  b.Add(Cylinder(2.2f * pole, 0.02f, 0.004f, 32), FrameSlot());
  b.Add(Ball(1.25f * pole, 24).Moved(0, 0, p.rise_m * n + p.rail_height_m + 0.19f), FrameSlot());
  for (int i = 0; i < p.steps; ++i) {
    // A collar below each tread.
    b.Add(Cylinder(1.3f * pole, 0.5f * p.rise_m, 0.004f, 24)
              .Moved(0, 0, p.rise_m * static_cast<float>(i + 1) - p.tread_m - 0.5f * p.rise_m),
          FrameSlot());
  }
  f.Rail(0.3f, n - 0.1f, 1);
  return b.Finish();
}

Asset MakeUShapedStaircase(const StairParams& p) {
  AssetBuilder b(p.seed);
  const int first = p.steps / 2, second = p.steps - first - 1;
  const float gap = 0.12f, x = 0.5f * (p.width_m + gap), n1 = static_cast<float>(first),
              n2 = static_cast<float>(second);
  const float landing_z = p.rise_m * (n1 + 1), far = -n1 * p.run_m;
  FlightBuilder up{b, p, StraightFlight(p, x, 0, 1, 0)};
  up.Steps(first);
  up.Stringers(0.35f, n1 + 0.4f);
  const float w = p.width_m + 0.5f * gap, depth = p.width_m;
  AddLanding(b, p, w, far, landing_z);
  FlightBuilder back{b, p, StraightFlight(p, -x, far, -1, landing_z)};
  back.base_z = landing_z - 0.15f;
  back.Steps(second);
  back.Stringers(-0.2f, n2);
  // Hand rails outside, inside, and around the landing.
  if (p.rail_right) up.Rail(0.15f, n1 - 0.1f, 1);
  up.Rail(0.15f, n1 - 0.1f, -1);
  back.Rail(0.2f, n2 - 0.2f, -1);
  if (p.rail_right) back.Rail(0.2f, n2 - 0.2f, 1);
  StairParams level = p;
  level.rise_m = 0;
  level.run_m = 0.27f;
  level.rail_height_m = p.rail_height_m + 0.1f;
  FlightBuilder edge{b, level, [=](float s, float) {
                       return Vec3f(w - 0.03f - s * 0.27f, far - depth + 0.03f, landing_z);
                     }};
  edge.Rail(0, (2 * w - 0.06f) / 0.27f, 1);
  return b.Finish();
}

namespace {

StairParams DrawStair(Rng& rng) {
  StairParams p;
  p.body = DrawEnum<StairBody>(rng, static_cast<int>(StairBody::kCount));
  p.rail = DrawEnum<StairRail>(rng, static_cast<int>(StairRail::kCount));
  p.steps = rng.UniformInt(11, 16);
  p.rise_m = Draw(rng, 0.165, 0.195);
  p.run_m = Draw(rng, 0.25, 0.3);
  p.width_m = Draw(rng, 0.75, 1.15);
  p.tread_m = p.body == StairBody::kOpen ? Draw(rng, 0.035, 0.06) : Draw(rng, 0.025, 0.04);
  p.rail_height_m = Draw(rng, 0.82, 0.95);
  p.rail_left = rng.Bernoulli(0.8);
  p.rail_right = !p.rail_left || rng.Bernoulli(0.7);
  p.seed = rng.Seed();
  return p;
}

Asset SampleStraightStaircase(Rng& rng) { return MakeStraightStaircase(DrawStair(rng)); }

Asset SampleCurvedStaircase(Rng& rng) {
  StairParams p = DrawStair(rng);
  p.turn_rad = Draw(rng, 1.0, 2.6);
  return MakeCurvedStaircase(p);
}

Asset SampleSpiralStaircase(Rng& rng) {
  StairParams p = DrawStair(rng);
  p.width_m = Draw(rng, 0.6, 0.9);
  p.turn_rad = static_cast<float>(p.steps) * Draw(rng, 0.4, 0.52);
  p.tread_m = Draw(rng, 0.02, 0.05);
  if (p.rail == StairRail::kGlass) p.rail = StairRail::kBalusters;
  return MakeSpiralStaircase(p);
}

Asset SampleUShapedStaircase(Rng& rng) { return MakeUShapedStaircase(DrawStair(rng)); }

}  // namespace

void RegisterStairs(std::vector<AssetClass>& classes) {
  // A room of one storey has no place for them: they float, or a plan names them.
  classes.push_back({"CurvedStaircase", "stairs", Placement::kFloor, true, 0.8f,
                     SampleCurvedStaircase, SizeRange({1.0f, 1.5f, 2.4f}, {4.5f, 5.5f, 4.4f})});
  classes.push_back({"SpiralStaircase", "stairs", Placement::kFloor, true, 0.8f,
                     SampleSpiralStaircase, SizeRange({1.2f, 1.2f, 2.4f}, {2.2f, 2.2f, 4.5f})});
  classes.push_back({"StraightStaircase", "stairs", Placement::kFloor, true, 0.8f,
                     SampleStraightStaircase, SizeRange({0.7f, 2.6f, 1.8f}, {1.4f, 5.2f, 4.4f})});
  classes.push_back({"UShapedStaircase", "stairs", Placement::kFloor, true, 0.8f,
                     SampleUShapedStaircase, SizeRange({1.5f, 1.9f, 2.4f}, {2.8f, 3.8f, 4.4f})});
}

}  // namespace parallax
