// Noise for solid textures: hashes of the integer lattice, gradient noise, cells, and the fading of
// detail finer than a ray's footprint. Pure functions of position and seed without state or heap;
// thread-safe.
//
// Most functions exist three times: for eight points in vector lanes, with a cell's corners one
// after the other; for dual numbers, with derivatives; and for one point, with its corners in
// lanes. All give the same bits.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "worker/materials/kernel/dual.h"

namespace parallax::noise {

constexpr uint32_t kPrimeX = 0x8da6b343, kPrimeY = 0xd8163841, kPrimeZ = 0xcb1ab31f;

// Mixes the bits of scalars and vector lanes.   Source: "lowbias32", C. Wellons, hash prospector.
template <typename Bits>
inline Bits Mix(Bits h) {
  h ^= h >> 16;
  h *= 0x7feb352du;
  h ^= h >> 15;
  h *= 0x846ca68bu;
  h ^= h >> 16;
  return h;
}

// Hashes of integer lattice points.
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

inline Bits8 Hash(Int8 x, uint32_t seed) { return Mix((Bits8)x * kPrimeX ^ seed); }
inline Bits8 Hash(Int8 x, Int8 y, uint32_t seed) {
  return Mix((Bits8)x * kPrimeX ^ (Bits8)y * kPrimeY ^ seed);
}
inline Bits8 Hash(Int8 x, Int8 y, Int8 z, uint32_t seed) {
  return Mix((Bits8)x * kPrimeX ^ (Bits8)y * kPrimeY ^ (Bits8)z * kPrimeZ ^ seed);
}
inline Bits8 Hash(Int8 x, Bits8 seeds) { return Mix((Bits8)x * kPrimeX ^ seeds); }
// Hashes one number with another seed in each lane, for example Hash(3, cell.id).
inline Bits8 Hash(int32_t x, Bits8 seeds) {
  return Mix(static_cast<uint32_t>(x) * kPrimeX ^ seeds);
}

// Return a number in [0, 1) from a hash. UnitByte takes one byte of it, by `part` 0..3: four
// independent values with 8 bits each, for choices that need no more.
inline float Unit(uint32_t hash) { return static_cast<float>(hash >> 8) * 0x1p-24f; }
inline float UnitByte(uint32_t hash, int part) {
  return static_cast<float>((hash >> (8 * part)) & 0xff) * (1.0f / 256.0f);
}

inline Float8 Unit(Bits8 hash) { return ToFloat((Int8)(hash >> 8)) * 0x1p-24f; }
inline Float8 UnitByte(Bits8 hash, int part) {
  return ToFloat((Int8)((hash >> (8 * part)) & 0xff)) * (1.0f / 256.0f);
}

// Clamps to [0, 1].
inline float Saturate(float x) { return std::clamp(x, 0.0f, 1.0f); }
inline float Lerp(float a, float b, float t) { return a + (b - a) * t; }
inline float SmoothStep(float low, float high, float x) {
  const float t = Saturate((x - low) / (high - low));
  return t * t * (3.0f - 2.0f * t);
}
inline Float8 Saturate(Float8 x) { return Clamp(x, 0.0f, 1.0f); }
inline Float8 Lerp(Float8 a, Float8 b, Float8 t) { return a + (b - a) * t; }
inline Float8 Lerp(float a, Float8 b, Float8 t) { return a + (b - a) * t; }
inline Float8 Lerp(Float8 a, float b, Float8 t) { return a + (b - a) * t; }
inline Float8 Lerp(float a, float b, Float8 t) { return a + (b - a) * t; }
inline Float8 SmoothStep(Float8 low, Float8 high, Float8 x) {
  const Float8 t = Saturate((x - low) / (high - low));
  return t * t * (3.0f - 2.0f * t);
}
inline Float8 SmoothStep(float low, Float8 high, Float8 x) {
  return SmoothStep(Splat(low), high, x);
}
inline Float8 SmoothStep(Float8 low, float high, Float8 x) {
  return SmoothStep(low, Splat(high), x);
}
inline Float8 SmoothStep(float low, float high, Float8 x) {
  return SmoothStep(Splat(low), Splat(high), x);
}
inline Dual8 Saturate(const Dual8& x) {
  const Mask8 inside = (x.value > 0) & (x.value < 1);
  return Chain(x, Saturate(x.value), Select(inside, Splat(1), Splat(0)));
}
// Returns the smooth step with its derivatives; the edges are constants.
inline Dual8 SmoothStep(Float8 low, Float8 high, const Dual8& x) {
  const Float8 scale = 1.0f / (high - low);
  const Float8 t = Saturate((x.value - low) / (high - low));
  return Chain(x, t * t * (3.0f - 2.0f * t), 6.0f * t * (1.0f - t) * scale);
}
inline Dual8 SmoothStep(float low, Float8 high, const Dual8& x) {
  return SmoothStep(Splat(low), high, x);
}
inline Dual8 SmoothStep(float low, float high, const Dual8& x) {
  return SmoothStep(Splat(low), Splat(high), x);
}
inline Int8 FloorInt(Float8 x) { return ToInt(Floor(x)); }
inline Int8 FloorInt(const Dual8& x) { return FloorInt(x.value); }
inline Dual8 Fract(const Dual8& x) { return {x.value - Floor(x.value), x.dx, x.dy}; }
inline Float8 Fract(Float8 x) { return x - Floor(x); }
inline int32_t FloorInt(float x) { return static_cast<int32_t>(std::floor(x)); }
inline float Fract(float x) { return x - std::floor(x); }

// Return cos(2 pi x) to 1e-3, for |x| below some thousands: enough for patterns, faster than libm,
// and the same bits on every machine.
inline float CosTurn(float x) {
  const float t = std::fabs(Fract(x) * 2.0f - 1.0f);  // 1 at whole x, 0 at half.
  const float s = t * 2.0f - 1.0f;                    // sin(pi/2 s) wanted.
  const float s2 = s * s;
  return s * (1.5707963f + s2 * (-0.6459641f + s2 * (0.0796926f - s2 * 0.0046818f)));
}

inline Float8 CosTurn(Float8 x) {
  const Float8 t = Abs(Fract(x) * 2.0f - 1.0f);
  const Float8 s = t * 2.0f - 1.0f;
  const Float8 s2 = s * s;
  return s * (1.5707963f + s2 * (-0.6459641f + s2 * (0.0796926f - s2 * 0.0046818f)));
}

inline Dual8 CosTurn(const Dual8& x) {
  // Cosine falls as sine, which is cosine a quarter turn earlier.
  return Chain(x, CosTurn(x.value), -6.2831853f * CosTurn(x.value - 0.25f));
}

// Return the share of a detail's amplitude that remains under a footprint: 1 when the footprint is
// four times finer than the wavelength, 0 from the Nyquist limit on.
inline float Fade(float wavelength_m, float footprint_m) {
  if (footprint_m * 4.0f <= wavelength_m) return 1.0f;
  const float t = Saturate(wavelength_m / (2.0f * footprint_m) - 1.0f);
  return t * t * (3.0f - 2.0f * t);
}

inline Float8 Fade(Float8 wavelength_m, Float8 footprint_m) {
  const Float8 t = Saturate(wavelength_m / (2.0f * footprint_m) - 1.0f);
  return t * t * (3.0f - 2.0f * t);
}
inline Float8 Fade(float wavelength_m, Float8 footprint_m) {
  return Fade(Splat(wavelength_m), footprint_m);
}

// Return the parts of a lattice point's gradient: LatticeHash mixes the hash, and PartOf takes
// coordinate 0, 1 or 2 of it, in [-2^31, 2^31). For each, the hash is shifted until other ten bits
// are the highest; the lower bits are negligible, and a 32-bit integer converts to float directly.
inline Bits8 LatticeHash(Bits8 h) {
  h ^= h >> 15;
  h *= 0x2c1b3c6du;
  h ^= h >> 13;
  return h * 0x297a2d39u;
}
inline Float8 PartOf(Bits8 hash, int part) { return ToFloat((Int8)(hash << (10 * part))); }
constexpr float kGradient3Scale = 0x1p-31f * 1.56f;

// Returns gradient noise with features about one unit wide: mean 0, standard deviation about 0.3,
// almost always in [-1, 1]; C1 continuous. Lanes are x, y, z and (unused) w; corner k of the
// lattice cell has bits x, y, z from the lowest on.
inline float Gradient3(const Float4& position, uint32_t seed) {
  // A constant shift: planes through the origin are common, and on a lattice plane the noise would
  // be weak.
  const Float4 p = position + Float4{0.371f, 0.293f, 0.437f, 0};
  const Float4 floor = _mm_floor_ps(p);
  const Float4 t = p - floor;
  const Float4 s = t * t * t * (t * (t * 6.0f - 15.0f) + 10.0f);
  const Bits4 primes = {kPrimeX, kPrimeY, kPrimeZ, 0};
  const Bits4 low = (Bits4) __builtin_convertvector(floor, Int4) * primes;
  const Bits4 high = low + primes;
  Bits8 h = __builtin_shufflevector(low, high, 0, 4, 0, 4, 0, 4, 0, 4) ^
            __builtin_shufflevector(low, high, 1, 1, 5, 5, 1, 1, 5, 5) ^
            __builtin_shufflevector(low, high, 2, 2, 2, 2, 6, 6, 6, 6) ^ seed;
  h = LatticeHash(h);
  const Float8 gx = PartOf(h, 0), gy = PartOf(h, 1), gz = PartOf(h, 2);
  const Float4 u = t - 1.0f, r = 1.0f - s;
  const Float8 v = __builtin_shufflevector(r, s, 0, 4, 0, 4, 0, 4, 0, 4) *
                   __builtin_shufflevector(r, s, 1, 1, 5, 5, 1, 1, 5, 5) *
                   __builtin_shufflevector(r, s, 2, 2, 2, 2, 6, 6, 6, 6) *
                   (gx * __builtin_shufflevector(t, u, 0, 4, 0, 4, 0, 4, 0, 4) +
                    gy * __builtin_shufflevector(t, u, 1, 1, 5, 5, 1, 1, 5, 5) +
                    gz * __builtin_shufflevector(t, u, 2, 2, 2, 2, 6, 6, 6, 6));
  return Sum(v) * kGradient3Scale;
}
inline float Gradient3(float x, float y, float z, uint32_t seed) {
  return Gradient3(Float4{x, y, z, 0}, seed);
}
inline float Gradient3(const Vec3f& p, uint32_t seed) {
  return Gradient3(Float4{p.x(), p.y(), p.z(), 0}, seed);
}

inline Float8 QuinticStep(Float8 t) { return t * t * t * (t * (t * 6.0f - 15.0f) + 10.0f); }

Float8 Gradient3(const Vec3x8& position, uint32_t seed);
inline Float8 Gradient3(Float8 x, Float8 y, Float8 z, uint32_t seed) {
  return Gradient3(Vec3x8(x, y, z), seed);
}
Dual8 Gradient3(const DualVec8& position, uint32_t seed);
inline Dual8 Gradient3(const Dual8& x, const Dual8& y, const Dual8& z, uint32_t seed) {
  return Gradient3(DualVec8{x, y, z}, seed);
}

// Returns gradient noise in two dimensions.
inline float Gradient2(float px, float py, uint32_t seed) {
  const Float4 p = {px, py, 0, 0};
  const Float4 floor = _mm_floor_ps(p);
  const Float4 t = p - floor;
  const Float4 s = t * t * t * (t * (t * 6.0f - 15.0f) + 10.0f);
  const Bits4 primes = {kPrimeX, kPrimeY, 0, 0};
  const Bits4 low = (Bits4) __builtin_convertvector(floor, Int4) * primes;
  const Bits4 high = low + primes;
  const Bits4 h = Mix(__builtin_shufflevector(low, high, 0, 4, 0, 4) ^
                      __builtin_shufflevector(low, high, 1, 1, 5, 5) ^ seed);
  const Float4 gx = __builtin_convertvector((Int4)(h & 0xffff), Float4) - 32767.5f;
  const Float4 gy = __builtin_convertvector((Int4)(h >> 16), Float4) - 32767.5f;
  const Float4 u = t - 1.0f, r = 1.0f - s;
  const Float4 v = __builtin_shufflevector(r, s, 0, 4, 0, 4) *
                   __builtin_shufflevector(r, s, 1, 1, 5, 5) *
                   (gx * __builtin_shufflevector(t, u, 0, 4, 0, 4) +
                    gy * __builtin_shufflevector(t, u, 1, 1, 5, 5));
  return Sum(v) * (1.0f / 32767.5f * 1.70f);
}

Float8 Gradient2(Float8 x, Float8 y, uint32_t seed);
Dual8 Gradient2(const Dual8& x, const Dual8& y, uint32_t seed);

// Returns the sum of `octaves` of gradient noise, each 0.48 as long and `gain` as strong as the one
// before; octaves finer than the footprint are left out. About [-1, 1] for gain 0.5.
inline float Fbm3(const Vec3f& p_m, float wavelength_m, int octaves, float footprint_m,
                  uint32_t seed, float gain = 0.5f) {
  const Float4 p = {p_m.x(), p_m.y(), p_m.z(), 0};
  float sum = 0, strength = 1;
  for (int i = 0; i < octaves; ++i) {
    const float fade = Fade(wavelength_m, footprint_m);
    if (fade <= 0) break;
    sum += strength * fade *
           Gradient3(p * (1.0f / wavelength_m), seed + static_cast<uint32_t>(i) * 977u);
    wavelength_m *= 0.48f;
    strength *= gain;
  }
  return sum;
}

// Returns the same sum for eight points, as numbers or as duals: `Vec` is Vec3x8 or DualVec8.
template <typename Vec>
RealOf<Vec> Fbm3(const Vec& p_m, float wavelength_m, int octaves, Float8 footprint_m, uint32_t seed,
                 float gain = 0.5f) {
  RealOf<Vec> sum = Splat(0);
  float strength = 1;
  for (int i = 0; i < octaves; ++i) {
    const Float8 fade = Fade(wavelength_m, footprint_m);
    if (!Any(fade > 0)) break;
    sum += strength * fade *
           Gradient3(p_m * (1.0f / wavelength_m), seed + static_cast<uint32_t>(i) * 977u);
    wavelength_m *= 0.48f;
    strength *= gain;
  }
  return sum;
}

// The value of Fbm3, and the standard deviation `lost` of the octaves that the footprint removed. A
// threshold needs both; otherwise a stain seen from afar would vanish instead of covering its share
// of every pixel.
template <typename Real>
struct Filtered8 {
  Real value;
  Float8 lost;
};
template <typename Vec>
Filtered8<RealOf<Vec>> Fbm3Filtered(const Vec& p_m, float wavelength_m, int octaves,
                                    Float8 footprint_m, uint32_t seed, float gain = 0.5f) {
  const auto value = Fbm3(p_m, wavelength_m, octaves, footprint_m, seed, gain);
  Float8 variance = Splat(0);
  float strength = 1;
  for (int i = 0; i < octaves; ++i) {
    const Float8 fade = Fade(wavelength_m, footprint_m);
    variance += strength * strength * (1.0f - fade * fade);
    wavelength_m *= 0.48f;
    strength *= gain;
  }
  return {value, 0.3f * Sqrt(variance)};
}

// Returns the share of a footprint in which the sum is above `threshold`; `softness` is half the
// width of the edge. A smooth step over [-s, s] is the integral of a bell of standard deviation
// 0.447 s.
template <typename Real>
Real Above(const Filtered8<Real>& n, float threshold, float softness) {
  const Float8 lost = n.lost * (1.0f / 0.447f);
  const Float8 s = Sqrt(softness * softness + lost * lost);
  return SmoothStep(threshold - s, threshold + s, n.value);
}

// Cellular noise at a point. Each lattice cell has one random feature point; the nearest and the
// second nearest count.
struct Cell {
  float f1 = 0,
        f2 = 0;     // Distances, in cells; f1 <= f2. f2 - f1 is 0 on the borders between cells.
  uint32_t id = 0;  // Hash of the nearest point's cell: a random number for it.
  // From the nearest point to the query, in cells (z = 0 in the plane).
  Vec3f offset = Vec3f::Zero();
};

// The same for eight points.
template <typename Vec>
struct CellOf8 {
  RealOf<Vec> f1, f2;
  Bits8 id;
  Vec offset;
};
using Cell8 = CellOf8<Vec3x8>;
using DualCell8 = CellOf8<DualVec8>;

// Return cellular noise in two and three dimensions. `jitter` in [0, 1] moves the feature points; 0
// is a regular grid.
Cell Cells2(float x, float y, uint32_t seed, float jitter = 1.0f);
Cell8 Cells3(const Vec3x8& p, uint32_t seed, float jitter = 1.0f);
Cell8 Cells2(Float8 x, Float8 y, uint32_t seed, float jitter = 1.0f);
DualCell8 Cells3(const DualVec8& p, uint32_t seed, float jitter = 1.0f);
DualCell8 Cells2(const Dual8& x, const Dual8& y, uint32_t seed, float jitter = 1.0f);

}  // namespace parallax::noise
