// Noise for solid textures: hashes of the integer lattice, gradient noise, cells, and the fading of
// detail that is finer than a ray's footprint. Pure functions of position and seed; no state, no
// heap; thread-safe.
//
// The corners of a lattice cell are hashed in vector lanes: one 3D gradient noise costs about 10
// ns.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "common/math/lanes.h"

namespace parallax::noise {

using Float4 = float __attribute__((vector_size(16)));
using Int4 = int32_t __attribute__((vector_size(16)));
using Bits4 = uint32_t __attribute__((vector_size(16)));

constexpr uint32_t kPrimeX = 0x8da6b343, kPrimeY = 0xd8163841, kPrimeZ = 0xcb1ab31f;

// Scalars and vector lanes alike.   Source: "lowbias32", C. Wellons, hash prospector.
template <typename Bits>
inline Bits Mix(Bits h) {
  h ^= h >> 16;
  h *= 0x7feb352du;
  h ^= h >> 15;
  h *= 0x846ca68bu;
  h ^= h >> 16;
  return h;
}

inline uint32_t Hash(int32_t x, uint32_t seed) {
  return Mix(static_cast<uint32_t>(x) * kPrimeX ^ seed);
}
inline uint32_t Hash(int32_t x, int32_t y, uint32_t seed) {
  return Mix(static_cast<uint32_t>(x) * kPrimeX ^ static_cast<uint32_t>(y) * kPrimeY ^ seed);
}
inline uint32_t Hash(int32_t x, int32_t y, int32_t z, uint32_t seed) {
  return Mix(static_cast<uint32_t>(x) * kPrimeX ^ static_cast<uint32_t>(y) * kPrimeY ^
             static_cast<uint32_t>(z) * kPrimeZ ^ seed);
}

// [0, 1) from a hash; `part` 0..3 gives four independent coarse values (8 bits) for choices that
// need no more.
inline float Unit(uint32_t hash) { return static_cast<float>(hash >> 8) * 0x1p-24f; }
inline float UnitByte(uint32_t hash, int part) {
  return static_cast<float>((hash >> (8 * part)) & 0xff) * (1.0f / 256.0f);
}

inline float Saturate(float x) { return std::clamp(x, 0.0f, 1.0f); }
inline float Lerp(float a, float b, float t) { return a + (b - a) * t; }
inline float SmoothStep(float low, float high, float x) {
  const float t = Saturate((x - low) / (high - low));
  return t * t * (3.0f - 2.0f * t);
}
inline int32_t FloorInt(float x) { return static_cast<int32_t>(std::floor(x)); }
inline float Fract(float x) { return x - std::floor(x); }

// cos(2 pi x) to 1e-3, for any x of moderate size: patterns need no more, and libm is slower.
inline float CosTurn(float x) {
  const float t = std::fabs(Fract(x) * 2.0f - 1.0f);  // 1 at whole x, 0 at half.
  const float s = t * 2.0f - 1.0f;                    // sin(pi/2 s) wanted.
  const float s2 = s * s;
  return s * (1.5707963f + s2 * (-0.6459641f + s2 * (0.0796926f - s2 * 0.0046818f)));
}

// How much of a detail of this wavelength a footprint leaves: 1 when it is four times finer, 0 from
// Nyquist on.
inline float Fade(float wavelength_m, float footprint_m) {
  if (footprint_m * 4.0f <= wavelength_m) return 1.0f;
  const float t = Saturate(wavelength_m / (2.0f * footprint_m) - 1.0f);
  return t * t * (3.0f - 2.0f * t);
}

// Gradient noise, one feature a unit; mean 0, standard deviation about 0.3, almost all in [-1, 1];
// C1 continuous.
inline float Gradient3(float px, float py, float pz, uint32_t seed) {
  // A constant shift: planes through the origin are common, and on a lattice plane the noise would
  // be weak.
  px += 0.371f;
  py += 0.293f;
  pz += 0.437f;
  const float fx = std::floor(px), fy = std::floor(py), fz = std::floor(pz);
  const float x = px - fx, y = py - fy, z = pz - fz;
  constexpr uint32_t X = kPrimeX, Y = kPrimeY, Z = kPrimeZ;
  const Bits8 step_x = {0, X, 0, X, 0, X, 0, X};
  const Bits8 step_y = {0, 0, Y, Y, 0, 0, Y, Y};
  const Bits8 step_z = {0, 0, 0, 0, Z, Z, Z, Z};
  const uint32_t hx = static_cast<uint32_t>(static_cast<int32_t>(fx)) * X;
  const uint32_t hy = static_cast<uint32_t>(static_cast<int32_t>(fy)) * Y;
  const uint32_t hz = static_cast<uint32_t>(static_cast<int32_t>(fz)) * Z;
  Bits8 h = (hx + step_x) ^ (hy + step_y) ^ (hz + step_z) ^ seed;
  h ^= h >> 15;
  h *= 0x2c1b3c6du;
  h ^= h >> 13;
  h *= 0x297a2d39u;
  h ^= h >> 16;
  const Float8 gx = __builtin_convertvector((Int8)(h & 0x3ff), Float8) - 511.5f;
  const Float8 gy = __builtin_convertvector((Int8)((h >> 10) & 0x3ff), Float8) - 511.5f;
  const Float8 gz = __builtin_convertvector((Int8)((h >> 20) & 0x3ff), Float8) - 511.5f;
  const Float8 bx = {0, 1, 0, 1, 0, 1, 0, 1};
  const Float8 by = {0, 0, 1, 1, 0, 0, 1, 1};
  const Float8 bz = {0, 0, 0, 0, 1, 1, 1, 1};
  const float sx = x * x * x * (x * (x * 6.0f - 15.0f) + 10.0f);
  const float sy = y * y * y * (y * (y * 6.0f - 15.0f) + 10.0f);
  const float sz = z * z * z * (z * (z * 6.0f - 15.0f) + 10.0f);
  const Float8 weight = ((1.0f - bx) + (2.0f * bx - 1.0f) * sx) *
                        ((1.0f - by) + (2.0f * by - 1.0f) * sy) *
                        ((1.0f - bz) + (2.0f * bz - 1.0f) * sz);
  const Float8 v = weight * (gx * (x - bx) + gy * (y - by) + gz * (z - bz));
  return (((v[0] + v[4]) + (v[1] + v[5])) + ((v[2] + v[6]) + (v[3] + v[7]))) *
         (1.0f / 511.5f * 1.56f);
}
inline float Gradient3(const Vec3f& p, uint32_t seed) {
  return Gradient3(p.x(), p.y(), p.z(), seed);
}

// The same in the plane.
inline float Gradient2(float px, float py, uint32_t seed) {
  const float fx = std::floor(px), fy = std::floor(py);
  const float x = px - fx, y = py - fy;
  const Bits4 step_x = {0, kPrimeX, 0, kPrimeX};
  const Bits4 step_y = {0, 0, kPrimeY, kPrimeY};
  const uint32_t hx = static_cast<uint32_t>(static_cast<int32_t>(fx)) * kPrimeX;
  const uint32_t hy = static_cast<uint32_t>(static_cast<int32_t>(fy)) * kPrimeY;
  const Bits4 h = Mix((hx + step_x) ^ (hy + step_y) ^ seed);
  const Float4 gx = __builtin_convertvector((Int4)(h & 0xffff), Float4) - 32767.5f;
  const Float4 gy = __builtin_convertvector((Int4)(h >> 16), Float4) - 32767.5f;
  const Float4 bx = {0, 1, 0, 1};
  const Float4 by = {0, 0, 1, 1};
  const float sx = x * x * x * (x * (x * 6.0f - 15.0f) + 10.0f);
  const float sy = y * y * y * (y * (y * 6.0f - 15.0f) + 10.0f);
  const Float4 v = ((1.0f - bx) + (2.0f * bx - 1.0f) * sx) *
                   ((1.0f - by) + (2.0f * by - 1.0f) * sy) * (gx * (x - bx) + gy * (y - by));
  return ((v[0] + v[2]) + (v[1] + v[3])) * (1.0f / 32767.5f * 1.70f);
}

// Sum of `octaves` of gradient noise, each 0.48 as long and `gain` as strong as the one before;
// octaves finer than the footprint are left out. About [-1, 1] for gain 0.5.
inline float Fbm3(const Vec3f& p_m, float wavelength_m, int octaves, float footprint_m,
                  uint32_t seed, float gain = 0.5f) {
  float sum = 0, strength = 1;
  for (int i = 0; i < octaves; ++i) {
    const float fade = Fade(wavelength_m, footprint_m);
    if (fade <= 0) break;
    sum += strength * fade * Gradient3(p_m / wavelength_m, seed + static_cast<uint32_t>(i) * 977u);
    wavelength_m *= 0.48f;
    strength *= gain;
  }
  return sum;
}

// The same sum, and the standard deviation of what the footprint took away: whoever cuts the sum at
// a threshold needs both, or a stain that is seen from afar would vanish instead of becoming its
// share of every pixel.
struct Filtered {
  float value = 0, lost = 0;
};
inline Filtered Fbm3Filtered(const Vec3f& p_m, float wavelength_m, int octaves, float footprint_m,
                             uint32_t seed, float gain = 0.5f) {
  Filtered out;
  float strength = 1, variance = 0;
  for (int i = 0; i < octaves; ++i) {
    const float fade = Fade(wavelength_m, footprint_m);
    if (fade > 0) {
      out.value +=
          strength * fade * Gradient3(p_m / wavelength_m, seed + static_cast<uint32_t>(i) * 977u);
    }
    variance += strength * strength * (1.0f - fade * fade);
    wavelength_m *= 0.48f;
    strength *= gain;
  }
  out.lost = 0.3f * std::sqrt(variance);
  return out;
}

// The share of a footprint where the sum lies above `threshold`; `softness` is half the width of
// the edge. A smooth step over [-s, s] is the integral of a bell of standard deviation 0.447 s.
inline float Above(const Filtered& n, float threshold, float softness) {
  const float lost = n.lost * (1.0f / 0.447f);
  const float s = std::sqrt(softness * softness + lost * lost);
  return SmoothStep(threshold - s, threshold + s, n.value);
}

// The nearest and second nearest of one feature point a lattice cell.
struct Cell {
  float f1 = 0,
        f2 = 0;     // Distances, in cells; f1 <= f2. f2 - f1 is 0 on the borders between cells.
  uint32_t id = 0;  // Hash of the nearest point's cell: its own random number.
  Vec3f offset =
      Vec3f::Zero();  // From the nearest point to the query, in cells (z = 0 in the plane).
};

// `jitter` in [0, 1]: 0 = a regular grid.
Cell Cells3(const Vec3f& p, uint32_t seed, float jitter = 1.0f);
Cell Cells2(float x, float y, uint32_t seed, float jitter = 1.0f);

}  // namespace parallax::noise
