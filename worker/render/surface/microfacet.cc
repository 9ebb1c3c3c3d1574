#include "worker/render/surface/microfacet.h"

#include <array>

namespace parallax {
namespace {

constexpr int kSteps = EnergyOfAlpha8::kSteps;

struct KeptEnergy {
  float a = 0, b = 0;
};

struct EnergyTables {
  KeptEnergy directional[kSteps][kSteps];  // By alpha, then cosine.
  KeptEnergy mean[kSteps];
  float sheen[kSteps];

  EnergyTables();
};

float Node(int i) { return Square(static_cast<float>(i) / (kSteps - 1)); }

// Calls `add` with the points of a grid over the unit square, eight at a time.
template <typename Add>
void ForGrid(int side, const Add& add) {
  const auto step = 1.0f / static_cast<float>(side);
  for (int i = 0; i < side * side; i += kLanes) {
    Float8 u, v;
    for (int lane = 0; lane < kLanes; ++lane) {
      u[lane] = (static_cast<float>((i + lane) % side) + 0.5f) * step;
      v[lane] = (static_cast<float>((i + lane) / side) + 0.5f) * step;
    }
    add(u, v);
  }
}

KeptEnergy IntegrateGgx(float cosine, float alpha) {
  constexpr int kSide = 16;
  const Ggx8 ggx{Splat(std::max(alpha, 1e-3f))};
  const Vec3x8 o = Vec3x8(DirectionAt(std::max(cosine, 1e-3f), 0.0f));
  Float8 a = Splat(0), b = Splat(0);
  ForGrid(kSide, [&](Float8 u, Float8 v) {
    const Vec3x8 h = ggx.SampleVisible(o, Turn8(2.0f * kPi * u), v);
    const Vec3x8 in = h * (2.0f * Dot(o, h)) - o;
    const Float8 weight = in.z > 0.0f ? ggx.G2(o, in) / ggx.G1(o) : Splat(0);
    const Float8 s = SchlickWeight(Dot(o, h));
    a += weight * (1.0f - s);
    b += weight * s;
  });
  return {Sum(a) / (kSide * kSide), Sum(b) / (kSide * kSide)};
}

float IntegrateSheen(float cosine) {
  constexpr int kSide = 64;
  const Vec3x8 o = Vec3x8(DirectionAt(std::max(cosine, 1e-4f), 0.0f));
  Float8 sum = Splat(0);
  ForGrid(kSide, [&](Float8 u, Float8 v) {
    const Turn8 turn(2.0f * kPi * u);
    const Float8 sine = Sqrt(v);
    const Vec3x8 in{sine * turn.cosine, sine * turn.sine, Sqrt(1.0f - v)};
    sum += SchlickWeight(Sqrt(Max(0.5f * (1.0f + Dot(o, in)), 0.0f)));
  });
  return kPi * Sum(sum) / (kSide * kSide);
}

EnergyTables::EnergyTables() {
  for (int a = 0; a < kSteps; ++a) {
    for (int c = 0; c < kSteps; ++c) directional[a][c] = IntegrateGgx(Node(c), Node(a));
  }
  for (int c = 0; c < kSteps; ++c) sheen[c] = IntegrateSheen(Node(c));
  // The means are those of the interpolated table, so that layers built on both conserve energy.
  for (int a = 0; a < kSteps; ++a) {
    constexpr int kCosines = 256;
    KeptEnergy sum;
    for (int i = 0; i < kCosines; ++i) {
      const float cosine = (static_cast<float>(i) + 0.5f) / kCosines;
      const float x = std::sqrt(cosine) * (kSteps - 1);
      const int c = std::min(static_cast<int>(x), kSteps - 2);
      const float f = x - static_cast<float>(c);
      sum.a += 2 * cosine * (directional[a][c].a * (1 - f) + directional[a][c + 1].a * f);
      sum.b += 2 * cosine * (directional[a][c].b * (1 - f) + directional[a][c + 1].b * f);
    }
    mean[a] = {sum.a / kCosines, sum.b / kCosines};
  }
}

const EnergyTables& Tables() {
  static const EnergyTables* const tables = new EnergyTables;
  return *tables;
}

struct Lookup {
  Int8 index;
  Float8 fraction;
  explicit Lookup(Float8 value) {
    const Float8 x = Sqrt(Clamp(value, 0.0f, 1.0f)) * static_cast<float>(kSteps - 1);
    const Int8 whole = __builtin_convertvector(x, Int8);
    index = whole < kSteps - 2 ? whole : whole * 0 + (kSteps - 2);
    fraction = x - __builtin_convertvector(index, Float8);
  }
};

KeptEnergy8 Lerp(const KeptEnergy8& x, const KeptEnergy8& y, Float8 t) {
  return {x.a + (y.a - x.a) * t, x.b + (y.b - x.b) * t};
}

// Interpolates between table[index] and the next entry.
KeptEnergy8 Between(const KeptEnergy* table, Int8 index, Float8 t) {
  Float8 pair[4];
  GatherFours(&table->a, index, 2, pair);
  return Lerp({pair[0], pair[1]}, {pair[2], pair[3]}, t);
}

}  // namespace

EnergyOfAlpha8::EnergyOfAlpha8(Float8 alpha) {
  const Lookup a(alpha);
  row_ = a.index;
  fraction_ = a.fraction;
}

KeptEnergy8 EnergyOfAlpha8::At(Float8 cosine) const {
  const Lookup c(cosine);
  const Int8 index = row_ * kSteps + c.index;
  const KeptEnergy* table = Tables().directional[0];
  return Lerp(Between(table, index, c.fraction), Between(table + kSteps, index, c.fraction),
              fraction_);
}

KeptEnergy8 EnergyOfAlpha8::Mean() const {
  const KeptEnergy* table = Tables().mean;
  return Between(table, row_, fraction_);
}

Float8 SheenEnergy(Float8 cosine) {
  const Lookup c(cosine);
  const Float8 low = Gather(Tables().sheen, c.index);
  return low + (Gather(Tables().sheen + 1, c.index) - low) * c.fraction;
}

}  // namespace parallax
