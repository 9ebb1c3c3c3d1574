#include "worker/assets/kernel/shape_noise.h"

#include <cmath>

namespace parallax::kernel {
namespace {

uint32_t Hash(uint64_t seed, int x, int y, int z) {
  uint64_t h = seed ^ (static_cast<uint64_t>(static_cast<uint32_t>(x)) * 0x9E3779B97F4A7C15ull);
  h ^= static_cast<uint64_t>(static_cast<uint32_t>(y)) * 0xC2B2AE3D27D4EB4Full;
  h ^= static_cast<uint64_t>(static_cast<uint32_t>(z)) * 0x165667B19E3779F9ull;
  h ^= h >> 29;
  h *= 0xBF58476D1CE4E5B9ull;
  h ^= h >> 32;
  h *= 0x94D049BB133111EBull;
  return static_cast<uint32_t>(h >> 33);
}

// Dot product with one of the twelve edge directions of a cube.
float Gradient(uint32_t hash, float x, float y, float z) {
  const uint32_t h = hash % 12;
  const float a = h < 8 ? x : y;
  const float b = h < 4 ? y : z;
  return ((hash >> 8) & 1 ? -a : a) + ((hash >> 9) & 1 ? -b : b);
}

float Fade(float t) { return t * t * t * (t * (t * 6 - 15) + 10); }
float Mix(float t, float a, float b) { return a + t * (b - a); }

}  // namespace

float Noise::At(const Vec3f& p) const {
  const Vec3f floor(std::floor(p.x()), std::floor(p.y()), std::floor(p.z()));
  const int x = static_cast<int>(floor.x()), y = static_cast<int>(floor.y()),
            z = static_cast<int>(floor.z());
  const Vec3f f = p - floor;
  const float u = Fade(f.x()), v = Fade(f.y()), w = Fade(f.z());
  const auto corner = [&](int dx, int dy, int dz) {
    return Gradient(Hash(seed_, x + dx, y + dy, z + dz), f.x() - dx, f.y() - dy, f.z() - dz);
  };
  return Mix(
      w, Mix(v, Mix(u, corner(0, 0, 0), corner(1, 0, 0)), Mix(u, corner(0, 1, 0), corner(1, 1, 0))),
      Mix(v, Mix(u, corner(0, 0, 1), corner(1, 0, 1)), Mix(u, corner(0, 1, 1), corner(1, 1, 1))));
}

Vec3f Noise::Vector(const Vec3f& p) const {
  return {At(p), At(p + Vec3f(37.2f, 11.7f, 5.1f)), At(p + Vec3f(-13.4f, 71.9f, 23.8f))};
}

float Noise::Fractal(const Vec3f& p, int octaves) const {
  float sum = 0, amplitude = 1;
  Vec3f q = p;
  for (int i = 0; i < octaves; ++i) {
    sum += amplitude * At(q);
    amplitude *= 0.5f;
    q = 2.0f * q + Vec3f(17.1f, 3.7f, 9.2f);
  }
  return sum;
}

float Noise::Ridges(const Vec3f& p) const {
  const float n = 1.0f - std::min(1.0f, 1.6f * std::abs(At(p)));
  return n * n;
}

}  // namespace parallax::kernel
