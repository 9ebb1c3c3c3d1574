// Dual numbers in vector lanes: a value and its derivatives along two directions. A formula written
// with them yields exact derivatives for little more than the cost of its value.
// Source: Wengert, "A simple automatic derivative evaluation program", CACM 1964.
#pragma once

#include <type_traits>

#include "common/math/lanes.h"

namespace parallax {

// Eight values with their derivatives along two directions.
struct Dual8 {
  Float8 value, dx, dy;

  Dual8() = default;
  // Makes a constant, whose derivatives are 0.
  Dual8(Float8 v) : value(v), dx(Splat(0)), dy(Splat(0)) {}
  Dual8(Float8 v, Float8 x, Float8 y) : value(v), dx(x), dy(y) {}
};

// Applies the chain rule: returns f(x), where f(x.value) is `value` and f'(x.value) is `slope`.
inline Dual8 Chain(const Dual8& x, Float8 value, Float8 slope) {
  return {value, slope * x.dx, slope * x.dy};
}

inline Dual8 operator-(const Dual8& a) { return {-a.value, -a.dx, -a.dy}; }
inline Dual8 operator+(const Dual8& a, const Dual8& b) {
  return {a.value + b.value, a.dx + b.dx, a.dy + b.dy};
}
inline Dual8 operator-(const Dual8& a, const Dual8& b) {
  return {a.value - b.value, a.dx - b.dx, a.dy - b.dy};
}
inline Dual8 operator*(const Dual8& a, const Dual8& b) {
  return {a.value * b.value, a.value * b.dx + b.value * a.dx, a.value * b.dy + b.value * a.dy};
}
// Operators with one constant operand.
inline Dual8 operator+(const Dual8& a, Float8 b) { return {a.value + b, a.dx, a.dy}; }
inline Dual8 operator+(Float8 a, const Dual8& b) { return b + a; }
inline Dual8 operator-(const Dual8& a, Float8 b) { return {a.value - b, a.dx, a.dy}; }
inline Dual8 operator-(Float8 a, const Dual8& b) { return {a - b.value, -b.dx, -b.dy}; }
inline Dual8 operator*(const Dual8& a, Float8 b) { return {a.value * b, a.dx * b, a.dy * b}; }
inline Dual8 operator*(Float8 a, const Dual8& b) { return b * a; }
// Multiplies by the reciprocal, so the result may differ in the last bit from the same formula of
// plain numbers.
inline Dual8 operator/(const Dual8& a, Float8 b) { return a * (1.0f / b); }
inline Dual8 operator+(const Dual8& a, float b) { return a + Splat(b); }
inline Dual8 operator+(float a, const Dual8& b) { return b + Splat(a); }
inline Dual8 operator-(const Dual8& a, float b) { return a - Splat(b); }
inline Dual8 operator-(float a, const Dual8& b) { return Splat(a) - b; }
inline Dual8 operator*(const Dual8& a, float b) { return a * Splat(b); }
inline Dual8 operator*(float a, const Dual8& b) { return b * Splat(a); }
inline Dual8 operator/(const Dual8& a, float b) { return a * (1.0f / b); }
template <typename T>
Dual8& operator+=(Dual8& a, const T& b) {
  return a = a + b;
}
template <typename T>
Dual8& operator*=(Dual8& a, const T& b) {
  return a = a * b;
}

inline Float8 ValueOf(Float8 x) { return x; }
inline Float8 ValueOf(const Dual8& x) { return x.value; }

inline Float8 Select(Mask8 mask, Float8 a, Float8 b) { return mask ? a : b; }
inline Dual8 Select(Mask8 mask, const Dual8& a, const Dual8& b) {
  return {mask ? a.value : b.value, mask ? a.dx : b.dx, mask ? a.dy : b.dy};
}
inline Dual8 Min(const Dual8& a, const Dual8& b) { return Select(a.value < b.value, a, b); }
inline Dual8 Max(const Dual8& a, const Dual8& b) { return Select(a.value > b.value, a, b); }
inline Dual8 Abs(const Dual8& x) { return Select(x.value < 0, -x, x); }
inline Dual8 Sqrt(const Dual8& x) {
  const Float8 root = Sqrt(x.value);
  return Chain(x, root, 0.5f / Max(root, 1e-9f));
}

// Three duals, as a vector.
struct DualVec8 {
  Dual8 x, y, z;
};

inline DualVec8 operator+(const DualVec8& a, const DualVec8& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
inline DualVec8 operator*(const DualVec8& a, float s) { return {a.x * s, a.y * s, a.z * s}; }
inline DualVec8 operator*(const Vec3f& a, const Dual8& s) {
  return {a.x() * s, a.y() * s, a.z() * s};
}
inline DualVec8 operator/(const DualVec8& a, float s) { return a * (1.0f / s); }

// The type of a vector's components.
template <typename Vec>
using RealOf = std::remove_cvref_t<decltype(Vec::x)>;

// Returns a vector of three numbers of one type: plain or dual.
inline Vec3x8 VecOf(Float8 x, Float8 y, Float8 z) { return {x, y, z}; }
inline DualVec8 VecOf(const Dual8& x, const Dual8& y, const Dual8& z) { return {x, y, z}; }
template <typename Real>
using Vec3Of8 = decltype(VecOf(Real(), Real(), Real()));

}  // namespace parallax
