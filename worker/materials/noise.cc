#include "worker/materials/noise.h"

#include <cstring>

namespace parallax::noise {
namespace {

struct Neighbours {
  alignas(32) int32_t x[32], y[32], z[32];
};

// The 27 cells around a cell; the last lanes repeat its centre (they can only tie, and the first
// one wins).
constexpr Neighbours MakeNeighbours() {
  Neighbours n{};
  for (int i = 0; i < 27; ++i) {
    n.x[i] = i % 3 - 1;
    n.y[i] = i / 3 % 3 - 1;
    n.z[i] = i / 9 - 1;
  }
  return n;
}
constexpr Neighbours kNeighbours = MakeNeighbours();

template <typename Lanes, typename Value>
Lanes Load(const Value* values) {
  Lanes lanes;
  std::memcpy(&lanes, values, sizeof(lanes));
  return lanes;
}
template <typename Lanes, typename Value>
void Store(Value* values, const Lanes& lanes) {
  std::memcpy(values, &lanes, sizeof(lanes));
}

}  // namespace

Cell Cells3(const Vec3f& p, uint32_t seed, float jitter) {
  const float fx = std::floor(p.x()), fy = std::floor(p.y()), fz = std::floor(p.z());
  const float x = p.x() - fx, y = p.y() - fy, z = p.z() - fz;
  const int32_t ix = static_cast<int32_t>(fx), iy = static_cast<int32_t>(fy),
                iz = static_cast<int32_t>(fz);
  const float rest = 0.5f - 0.5f * jitter;
  const float scale = jitter / 1023.0f;
  alignas(32) float d2[32], ox[32], oy[32], oz[32];
  alignas(32) uint32_t ids[32];
  for (int lane = 0; lane < 32; lane += 8) {
    const Int8 nx = Load<Int8>(kNeighbours.x + lane);
    const Int8 ny = Load<Int8>(kNeighbours.y + lane);
    const Int8 nz = Load<Int8>(kNeighbours.z + lane);
    const Bits8 h = Mix((Bits8)(nx + ix) * kPrimeX ^ (Bits8)(ny + iy) * kPrimeY ^
                        (Bits8)(nz + iz) * kPrimeZ ^ seed);
    const Float8 dx = x - __builtin_convertvector(nx, Float8) - rest -
                      __builtin_convertvector((Int8)(h & 0x3ff), Float8) * scale;
    const Float8 dy = y - __builtin_convertvector(ny, Float8) - rest -
                      __builtin_convertvector((Int8)((h >> 10) & 0x3ff), Float8) * scale;
    const Float8 dz = z - __builtin_convertvector(nz, Float8) - rest -
                      __builtin_convertvector((Int8)((h >> 20) & 0x3ff), Float8) * scale;
    Store(d2 + lane, Float8(dx * dx + dy * dy + dz * dz));
    Store(ox + lane, dx);
    Store(oy + lane, dy);
    Store(oz + lane, dz);
    Store(ids + lane, h);
  }
  float best = d2[0], second = 1e9f;
  int nearest = 0;
  for (int i = 1; i < 27; ++i) {
    if (d2[i] < best) {
      second = best;
      best = d2[i];
      nearest = i;
    } else if (d2[i] < second) {
      second = d2[i];
    }
  }
  // The position bits made the point; mix again, so that what is drawn from the id is independent
  // of the place.
  return {std::sqrt(best), std::sqrt(second), Mix(ids[nearest] + 0x9e3779b9u),
          Vec3f(ox[nearest], oy[nearest], oz[nearest])};
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

}  // namespace parallax::noise
