#include "worker/materials/kernel/noise.h"

#include <array>

namespace parallax::noise {

namespace {

// One axis of a lattice cell: where the point lies along it, and how the noise passes from one end
// to the other.
struct Span8 {
  Float8 t, step[2];
  Bits8 hash[2];

  Span8(Float8 x, uint32_t prime) {
    const Float8 floor = Floor(x);
    t = x - floor;
    step[1] = QuinticStep(t);
    step[0] = 1.0f - step[1];
    hash[0] = (Bits8)ToInt(floor) * prime;
    hash[1] = hash[0] + prime;
  }
  Float8 From(int end) const { return end != 0 ? t - 1.0f : t; }
  Float8 StepSlope() const { return 30.0f * Square(t * (t - 1.0f)); }
};

// A corner of the lattice: its gradient, and how high the plane of that gradient stands at the
// point.
struct Corner3 {
  Vec3x8 gradient;
  Float8 height;
};
[[gnu::always_inline]] inline Corner3 CornerOf(const Span8& x, const Span8& y, const Span8& z,
                                               int i, int j, int k, uint32_t seed) {
  const Bits8 h = LatticeHash(x.hash[i] ^ y.hash[j] ^ z.hash[k] ^ seed);
  const Vec3x8 g(PartOf(h, 0), PartOf(h, 1), PartOf(h, 2));
  return {g, g.x * x.From(i) + g.y * y.From(j) + g.z * z.From(k)};
}

struct Corner2 {
  Float8 gx, gy, height;
};
[[gnu::always_inline]] inline Corner2 CornerOf(const Span8& x, const Span8& y, int i, int j,
                                               uint32_t seed) {
  const Bits8 h = Mix(x.hash[i] ^ y.hash[j] ^ seed);
  const Float8 gx = ToFloat((Int8)(h & 0xffff)) - 32767.5f;
  const Float8 gy = ToFloat((Int8)(h >> 16)) - 32767.5f;
  return {gx, gy, gx * x.From(i) + gy * y.From(j)};
}

}  // namespace

// Both sum the corners as Sum does those of one point: along z, x, y.
PARALLAX_LANE_CLONES Float8 Gradient3(const Vec3x8& position, uint32_t seed) {
  const Span8 x(position.x + 0.371f, kPrimeX), y(position.y + 0.293f, kPrimeY),
      z(position.z + 0.437f, kPrimeZ);
  const auto edge = [&](int i, int j) {
    const Float8 weight = x.step[i] * y.step[j];
    return weight * z.step[0] * CornerOf(x, y, z, i, j, 0, seed).height +
           weight * z.step[1] * CornerOf(x, y, z, i, j, 1, seed).height;
  };
  return ((edge(0, 0) + edge(1, 0)) + (edge(0, 1) + edge(1, 1))) * kGradient3Scale;
}

PARALLAX_LANE_CLONES Dual8 Gradient3(const DualVec8& position, uint32_t seed) {
  const Span8 x(position.x.value + 0.371f, kPrimeX), y(position.y.value + 0.293f, kPrimeY),
      z(position.z.value + 0.437f, kPrimeZ);
  Vec3x8 slope = Vec3x8::Zero();  // With the corners' weights as they are...
  Vec3x8 rise = Vec3x8::Zero();   // ...and because they change.
  Float8 between[2][2];           // The ends along z.
  const auto edge = [&](int i, int j) {
    const Corner3 low = CornerOf(x, y, z, i, j, 0, seed), high = CornerOf(x, y, z, i, j, 1, seed);
    const Float8 weight = x.step[i] * y.step[j];
    const Float8 below = weight * z.step[0], above = weight * z.step[1];
    slope = slope + (low.gradient * below + high.gradient * above);
    rise.z += weight * (high.height - low.height);
    between[i][j] = z.step[0] * low.height + z.step[1] * high.height;
    return below * low.height + above * high.height;
  };
  const Float8 near = edge(0, 0) + edge(1, 0);
  const Float8 value = near + (edge(0, 1) + edge(1, 1));
  rise.x =
      y.step[0] * (between[1][0] - between[0][0]) + y.step[1] * (between[1][1] - between[0][1]);
  rise.y =
      x.step[0] * (between[0][1] - between[0][0]) + x.step[1] * (between[1][1] - between[1][0]);
  slope = (slope + rise * Vec3x8(x.StepSlope(), y.StepSlope(), z.StepSlope())) * kGradient3Scale;
  return {value * kGradient3Scale,
          slope.x * position.x.dx + slope.y * position.y.dx + slope.z * position.z.dx,
          slope.x * position.x.dy + slope.y * position.y.dy + slope.z * position.z.dy};
}

constexpr float kGradient2Scale = 1.0f / 32767.5f * 1.70f;

PARALLAX_LANE_CLONES Float8 Gradient2(Float8 px, Float8 py, uint32_t seed) {
  const Span8 x(px, kPrimeX), y(py, kPrimeY);
  Float8 shares[4];
  for (int n = 0; n < 4; ++n) {
    const int i = n & 1, j = n >> 1;
    shares[n] = x.step[i] * y.step[j] * CornerOf(x, y, i, j, seed).height;
  }
  return ((shares[0] + shares[1]) + (shares[2] + shares[3])) * kGradient2Scale;
}

PARALLAX_LANE_CLONES Dual8 Gradient2(const Dual8& px, const Dual8& py, uint32_t seed) {
  const Span8 x(px.value, kPrimeX), y(py.value, kPrimeY);
  Float8 heights[4], shares[4], slope_x = Splat(0), slope_y = Splat(0);
  for (int n = 0; n < 4; ++n) {
    const int i = n & 1, j = n >> 1;
    const Corner2 corner = CornerOf(x, y, i, j, seed);
    const Float8 weight = x.step[i] * y.step[j];
    heights[n] = corner.height;
    shares[n] = weight * corner.height;
    slope_x += weight * corner.gx;
    slope_y += weight * corner.gy;
  }
  const Float8 rise_x =
      y.step[0] * (heights[1] - heights[0]) + y.step[1] * (heights[3] - heights[2]);
  const Float8 rise_y =
      x.step[0] * (heights[2] - heights[0]) + x.step[1] * (heights[3] - heights[1]);
  slope_x = (slope_x + rise_x * x.StepSlope()) * kGradient2Scale;
  slope_y = (slope_y + rise_y * y.StepSlope()) * kGradient2Scale;
  return {((shares[0] + shares[1]) + (shares[2] + shares[3])) * kGradient2Scale,
          slope_x * px.dx + slope_y * py.dx, slope_x * px.dy + slope_y * py.dy};
}

Cell Cells2(float px, float py, uint32_t seed, float jitter) {
  const float fx = std::floor(px), fy = std::floor(py);
  const float x = px - fx, y = py - fy;
  const int32_t ix = static_cast<int32_t>(fx), iy = static_cast<int32_t>(fy);
  const float rest = 0.5f - 0.5f * jitter;
  const float scale = jitter / 65535.0f;
  float best = 1e9f, second = 1e9f, best_x = 0, best_y = 0;
  uint32_t id = 0;
  for (int j = -1; j <= 1; ++j) {
    for (int i = -1; i <= 1; ++i) {
      const uint32_t h = Hash(ix + i, iy + j, seed);
      const float dx = x - static_cast<float>(i) - rest - static_cast<float>(h & 0xffff) * scale;
      const float dy = y - static_cast<float>(j) - rest - static_cast<float>(h >> 16) * scale;
      const float d2 = dx * dx + dy * dy;
      if (d2 < best) {
        second = best;
        best = d2;
        best_x = dx;
        best_y = dy;
        id = h;
      } else if (d2 < second) {
        second = d2;
      }
    }
  }
  return {std::sqrt(best), std::sqrt(second), Mix(id + 0x9e3779b9u), Vec3f(best_x, best_y, 0)};
}

namespace {

// The two nearest so far of each lane.
struct Nearest8 {
  Float8 best = Splat(1e9f), second = Splat(1e9f);
  Bits8 id{};
  Vec3x8 offset = Vec3x8::Zero(), second_offset = Vec3x8::Zero();

  void Meet(const Vec3x8& to, Float8 d2, Bits8 h) {
    const Mask8 nearer = d2 < best;
    second_offset = Select(nearer, offset, Select(d2 < second, to, second_offset));
    second = nearer ? best : Min(second, d2);
    best = Min(d2, best);
    id = nearer ? h : id;
    offset = Select(nearer, to, offset);
  }
  // Whether a point of at least that squared distance may be one of the two of any lane.
  bool MayMeet(Float8 d2) const { return Any(d2 < second); }
  Bits8 Id() const { return Mix(id + 0x9e3779b9u); }
};

// One axis of a lattice cell and of those beside it: below, itself, above.
struct Axis8 {
  Bits8 hash[3];
  // Offsets from the ranges of each cell's points, or from a part `middle` of them, to the query.
  Float8 from[3];
  Float8 gap2[3];  // Squared distance to where points of the cell lie, a little less for rounding.

  Axis8(Float8 p, uint32_t prime, float jitter, float middle) {
    const Float8 floor = Floor(p), x = p - floor;
    const float rest = 0.5f - 0.5f * jitter;
    for (int k = 0; k < 3; ++k) {
      const int n = k - 1;
      hash[k] = (Bits8)ToInt(floor) * prime + static_cast<uint32_t>(n) * prime;
      from[k] = x - static_cast<float>(n) - (rest + middle * jitter);
    }
    gap2[0] = 0.999f * (x + rest) * (x + rest);
    gap2[1] = Splat(0);
    gap2[2] = 0.999f * (1.0f + rest - x) * (1.0f + rest - x);
  }
};

// The cells around one, near ones first: most of the far ones need not be looked at then.
struct Neighbour {
  int x, y, z;  // Each in [0, 2]; 1 is the cell itself.
};
constexpr std::array<Neighbour, 27> kNeighbours3 = [] {
  std::array<Neighbour, 27> cells{};
  size_t count = 0;
  for (int steps = 0; steps <= 3; ++steps) {
    for (int k = 0; k < 27; ++k) {
      const Neighbour n{k % 3, k / 3 % 3, k / 9};
      if ((n.x != 1) + (n.y != 1) + (n.z != 1) == steps) cells[count++] = n;
    }
  }
  return cells;
}();
constexpr std::array<Neighbour, 9> kNeighbours2 = [] {
  std::array<Neighbour, 9> cells{};
  size_t count = 0;
  for (const Neighbour& n : kNeighbours3) {
    if (n.z == 1) cells[count++] = n;
  }
  return cells;
}();

}  // namespace

namespace {

[[gnu::always_inline]] inline Nearest8 Nearest3(const Vec3x8& p, uint32_t seed, float jitter) {
  const Axis8 x(p.x, kPrimeX, jitter, 0.5f), y(p.y, kPrimeY, jitter, 0.5f),
      z(p.z, kPrimeZ, jitter, 0.5f);
  const float scale = jitter * 0x1p-32f;
  Nearest8 nearest;
  for (const auto [i, j, k] : kNeighbours3) {
    if (!nearest.MayMeet(x.gap2[i] + y.gap2[j] + z.gap2[k])) continue;
    const Bits8 h = LatticeHash(x.hash[i] ^ y.hash[j] ^ z.hash[k] ^ seed);
    const Vec3x8 to(x.from[i] - PartOf(h, 0) * scale, y.from[j] - PartOf(h, 1) * scale,
                    z.from[k] - PartOf(h, 2) * scale);
    nearest.Meet(to, Dot(to, to), h);
  }
  return nearest;
}

[[gnu::always_inline]] inline Nearest8 Nearest2(Float8 px, Float8 py, uint32_t seed, float jitter) {
  const Axis8 x(px, kPrimeX, jitter, 0), y(py, kPrimeY, jitter, 0);
  const float scale = jitter / 65535.0f;
  Nearest8 nearest;
  for (const auto [i, j, k] : kNeighbours2) {
    if (!nearest.MayMeet(x.gap2[i] + y.gap2[j])) continue;
    const Bits8 h = Mix(x.hash[i] ^ y.hash[j] ^ seed);
    const Float8 dx = x.from[i] - ToFloat((Int8)(h & 0xffff)) * scale;
    const Float8 dy = y.from[j] - ToFloat((Int8)(h >> 16)) * scale;
    nearest.Meet({dx, dy, Splat(0)}, dx * dx + dy * dy, h);
  }
  return nearest;
}

// Feature points stand still: only the way from them to the point changes.
[[gnu::always_inline]] inline Dual8 LengthOf(const Vec3x8& offset, Float8 length2,
                                             const DualVec8& p) {
  const Float8 length = Sqrt(length2);
  const Vec3x8 to = offset / Max(length, 1e-9f);
  return {length, to.x * p.x.dx + to.y * p.y.dx + to.z * p.z.dx,
          to.x * p.x.dy + to.y * p.y.dy + to.z * p.z.dy};
}
[[gnu::always_inline]] inline DualCell8 CellOf(const Nearest8& nearest, const DualVec8& p) {
  const Vec3x8& o = nearest.offset;
  return {LengthOf(o, nearest.best, p),
          LengthOf(nearest.second_offset, nearest.second, p),
          nearest.Id(),
          {{o.x, p.x.dx, p.x.dy}, {o.y, p.y.dx, p.y.dy}, {o.z, p.z.dx, p.z.dy}}};
}
[[gnu::always_inline]] inline Cell8 CellOf(const Nearest8& nearest) {
  return {Sqrt(nearest.best), Sqrt(nearest.second), nearest.Id(), nearest.offset};
}

}  // namespace

PARALLAX_LANE_CLONES Cell8 Cells3(const Vec3x8& p, uint32_t seed, float jitter) {
  return CellOf(Nearest3(p, seed, jitter));
}
PARALLAX_LANE_CLONES Cell8 Cells2(Float8 x, Float8 y, uint32_t seed, float jitter) {
  return CellOf(Nearest2(x, y, seed, jitter));
}
PARALLAX_LANE_CLONES DualCell8 Cells3(const DualVec8& p, uint32_t seed, float jitter) {
  return CellOf(Nearest3({p.x.value, p.y.value, p.z.value}, seed, jitter), p);
}
PARALLAX_LANE_CLONES DualCell8 Cells2(const Dual8& x, const Dual8& y, uint32_t seed, float jitter) {
  return CellOf(Nearest2(x.value, y.value, seed, jitter), DualVec8{x, y, Splat(0)});
}

}  // namespace parallax::noise
