#include "worker/render/microfacet.h"

namespace parallax {
namespace {

constexpr int kSteps = EnergyOfAlpha::kSteps;

struct EnergyTables {
  std::array<EnergyOfAlpha::Row, kSteps> directional;  // By alpha.
  std::array<KeptEnergy, kSteps> mean;
  std::array<float, kSteps> sheen;

  EnergyTables();
};

float Node(int i) { return Square(static_cast<float>(i) / (kSteps - 1)); }

Vec2f GridPoint(int i, int side) {
  return {(static_cast<float>(i % side) + 0.5f) / static_cast<float>(side),
          (static_cast<float>(i / side) + 0.5f) / static_cast<float>(side)};
}

KeptEnergy IntegrateGgx(float cosine, float alpha) {
  constexpr int kSide = 16;
  const Ggx ggx{std::max(alpha, 1e-3f)};
  const Vec3f o = DirectionAt(std::max(cosine, 1e-3f), 0.0f);
  KeptEnergy sum;
  for (int i = 0; i < kSide * kSide; ++i) {
    const Vec3f h = ggx.SampleVisible(o, GridPoint(i, kSide));
    const Vec3f in = 2.0f * o.dot(h) * h - o;
    if (in.z() <= 0.0f) continue;
    const float weight = ggx.G2(o, in) / ggx.G1(o);
    const float s = SchlickWeight(o.dot(h));
    sum.a += weight * (1.0f - s);
    sum.b += weight * s;
  }
  return {sum.a / (kSide * kSide), sum.b / (kSide * kSide)};
}

float IntegrateSheen(float cosine) {
  constexpr int kSide = 64;
  const Vec3f o = DirectionAt(std::max(cosine, 1e-4f), 0.0f);
  float sum = 0;
  for (int i = 0; i < kSide * kSide; ++i) {
    const Vec3f in = SampleCosineHemisphere(GridPoint(i, kSide));
    sum += SchlickWeight(std::sqrt(std::max(0.0f, 0.5f * (1.0f + o.dot(in)))));
  }
  return kPi * sum / (kSide * kSide);
}

EnergyTables::EnergyTables() {
  for (int a = 0; a < kSteps; ++a) {
    const auto row = static_cast<size_t>(a);
    for (int c = 0; c < kSteps; ++c) {
      directional[row][static_cast<size_t>(c)] = IntegrateGgx(Node(c), Node(a));
    }
  }
  for (int c = 0; c < kSteps; ++c) sheen[static_cast<size_t>(c)] = IntegrateSheen(Node(c));
  // Means are taken of the interpolated table, so that layers built on both conserve energy.
  for (size_t a = 0; a < kSteps; ++a) {
    constexpr int kCosines = 256;
    KeptEnergy sum;
    for (int i = 0; i < kCosines; ++i) {
      const float cosine = (static_cast<float>(i) + 0.5f) / kCosines;
      const float x = std::sqrt(cosine) * (kSteps - 1);
      const auto c = std::min<size_t>(static_cast<size_t>(x), kSteps - 2);
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
  size_t index;
  float fraction;
  explicit Lookup(float value) {
    const float x = std::sqrt(std::clamp(value, 0.0f, 1.0f)) * (kSteps - 1);
    index = std::min<size_t>(static_cast<size_t>(x), kSteps - 2);
    fraction = x - static_cast<float>(index);
  }
};

KeptEnergy Lerp(const KeptEnergy& x, const KeptEnergy& y, float t) {
  return {x.a + (y.a - x.a) * t, x.b + (y.b - x.b) * t};
}

}  // namespace

EnergyOfAlpha::EnergyOfAlpha(float alpha) {
  const Lookup a(alpha);
  low_ = &Tables().directional[a.index];
  high_ = low_ + 1;
  fraction_ = a.fraction;
}

KeptEnergy EnergyOfAlpha::At(float cosine) const {
  const Lookup c(cosine);
  const KeptEnergy* low = &(*low_)[c.index];
  const KeptEnergy* high = &(*high_)[c.index];
  return Lerp(Lerp(low[0], low[1], c.fraction), Lerp(high[0], high[1], c.fraction), fraction_);
}

KeptEnergy DirectionalEnergy(float cosine, float alpha) { return EnergyOfAlpha(alpha).At(cosine); }

KeptEnergy MeanEnergy(float alpha) {
  const Lookup a(alpha);
  return Lerp(Tables().mean[a.index], Tables().mean[a.index + 1], a.fraction);
}

float SheenEnergy(float cosine) {
  const Lookup c(cosine);
  const auto& sheen = Tables().sheen;
  return sheen[c.index] + (sheen[c.index + 1] - sheen[c.index]) * c.fraction;
}

}  // namespace parallax
