#include "worker/materials/noise.h"

#include <array>

namespace parallax::noise {

PARALLAX_LANE_CLONES Float8 Gradient3(const Vec3x8& position, uint32_t seed) {
  const Float8 x = position.x + 0.371f, y = position.y + 0.293f, z = position.z + 0.437f;
  const Float8 x0 = Floor(x), y0 = Floor(y), z0 = Floor(z);
  const Float8 tx = x - x0, ty = y - y0, tz = z - z0;
  const Float8 sx = QuinticStep(tx), sy = QuinticStep(ty), sz = QuinticStep(tz);
  const Bits8 hx = (Bits8)ToInt(x0) * kPrimeX, hy = (Bits8)ToInt(y0) * kPrimeY,
              hz = (Bits8)ToInt(z0) * kPrimeZ;
  const auto corner = [&](int k) {
    const bool high_x = (k & 1) != 0, high_y = (k & 2) != 0, high_z = (k & 4) != 0;
    const Bits8 h = LatticeHash((high_x ? hx + kPrimeX : hx) ^ (high_y ? hy + kPrimeY : hy) ^
                                (high_z ? hz + kPrimeZ : hz) ^ seed);
    const Float8 gx = PartOf(h, 0), gy = PartOf(h, 1), gz = PartOf(h, 2);
    return (high_x ? sx : 1.0f - sx) * (high_y ? sy : 1.0f - sy) * (high_z ? sz : 1.0f - sz) *
           (gx * (high_x ? tx - 1.0f : tx) + gy * (high_y ? ty - 1.0f : ty) +
            gz * (high_z ? tz - 1.0f : tz));
  };
  // In the order in which Sum adds the corners of one point.
  const Float8 near = (corner(0) + corner(4)) + (corner(1) + corner(5));
  const Float8 far = (corner(2) + corner(6)) + (corner(3) + corner(7));
  return (near + far) * kGradient3Scale;
}

PARALLAX_LANE_CLONES Float8 Gradient2(Float8 x, Float8 y, uint32_t seed) {
  const Float8 x0 = Floor(x), y0 = Floor(y);
  const Float8 tx = x - x0, ty = y - y0;
  const Float8 sx = QuinticStep(tx), sy = QuinticStep(ty);
  const Bits8 hx = (Bits8)ToInt(x0) * kPrimeX, hy = (Bits8)ToInt(y0) * kPrimeY;
  const auto corner = [&](int k) {
    const bool high_x = (k & 1) != 0, high_y = (k & 2) != 0;
    const Bits8 h = Mix((high_x ? hx + kPrimeX : hx) ^ (high_y ? hy + kPrimeY : hy) ^ seed);
    const Float8 gx = ToFloat((Int8)(h & 0xffff)) - 32767.5f;
    const Float8 gy = ToFloat((Int8)(h >> 16)) - 32767.5f;
    return (high_x ? sx : 1.0f - sx) * (high_y ? sy : 1.0f - sy) *
           (gx * (high_x ? tx - 1.0f : tx) + gy * (high_y ? ty - 1.0f : ty));
  };
  return ((corner(0) + corner(1)) + (corner(2) + corner(3))) * (1.0f / 32767.5f * 1.70f);
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
  Vec3x8 offset = Vec3x8::Zero();

  void Meet(const Vec3x8& to, Float8 d2, Bits8 h) {
    const Mask8 nearer = d2 < best;
    second = nearer ? best : Min(second, d2);
    best = Min(d2, best);
    id = nearer ? h : id;
    offset = Select(nearer, to, offset);
  }
  // Whether a point of at least that squared distance may be one of the two of any lane.
  bool MayMeet(Float8 d2) const { return Any(d2 < second); }
  Cell8 Cell() const { return {Sqrt(best), Sqrt(second), Mix(id + 0x9e3779b9u), offset}; }
};

// One axis of a lattice cell and of those beside it: below, itself, above.
struct Axis8 {
  Bits8 hash[3];
  // To the query from where each cell's points begin, or from a part `middle` of their range on.
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
  int x, y, z;  // Of an axis' three.
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

PARALLAX_LANE_CLONES Cell8 Cells3(const Vec3x8& p, uint32_t seed, float jitter) {
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
  return nearest.Cell();
}

PARALLAX_LANE_CLONES Cell8 Cells2(Float8 px, Float8 py, uint32_t seed, float jitter) {
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
  return nearest.Cell();
}

}  // namespace parallax::noise
