#include "worker/materials/art/art_parts.h"

namespace parallax::art {
namespace {

using namespace noise;  // NOLINT: the vocabulary of patterns.

class Landscape final : public Art {
 public:
  explicit Landscape(Rng& rng) {
    struct Mood {
      uint32_t zenith, horizon, sun, far, near;
    };
    static constexpr std::array<Mood, 8> kMoods = {
        {{0x4f86b8, 0xc9dbe2, 0xf4ecc0, 0x8fa9b8, 0x3f5b33},
         {0x2a3f66, 0xe09a5f, 0xf7d27a, 0x8f6a78, 0x2a2a33},
         {0x1b2440, 0x4a5f86, 0xe6e6d8, 0x37456a, 0x141a26},
         {0xd98f6a, 0xf0cfa0, 0xf5e6c0, 0xc78f7a, 0x5a3a3f},
         {0x8fb5b0, 0xe0e0cc, 0xf0e8d0, 0x9ab0a0, 0x4a6a4a},
         {0x5f6f80, 0xb9bfc2, 0xdcdcd6, 0x8a949a, 0x3a4248},
         {0x3a6a8f, 0xe8c9a8, 0xf6e2b0, 0xb9987f, 0x8a5a3a},
         {0x6a4a80, 0xe0a0a0, 0xf6d0a0, 0x8a6a96, 0x2f2440}}};
    const Mood& mood = rng.Pick(kMoods);
    zenith_ = VaryColor(rng, SrgbColor(mood.zenith));
    horizon_ = VaryColor(rng, SrgbColor(mood.horizon), 0.08);
    sun_ = SrgbColor(mood.sun);
    far_ = VaryColor(rng, SrgbColor(mood.far));
    near_ = VaryColor(rng, SrgbColor(mood.near));
    horizon_v_ = Draw(rng, 0.3, 0.6);
    sun_u_ = Draw(rng, 0.15, 0.85);
    sun_v_ = horizon_v_ + Draw(rng, -0.02, 0.35);
    sun_r_ = Draw(rng, 0.03, 0.09);
    clouds_ = rng.Bernoulli(0.6) ? Draw(rng, 0.3, 0.9) : 0.0f;
    sea_ = rng.Bernoulli(0.35);
    layers_ = sea_ ? rng.UniformInt(1, 3) : rng.UniformInt(3, 6);
    for (int i = 0; i < layers_; ++i) {
      Ridge& ridge = ridges_[static_cast<size_t>(i)];
      const double t = (i + 1.0) / layers_;  // 1 = nearest.
      ridge.base = sea_ ? horizon_v_ + Float(0.02 * (1 - t)) : horizon_v_ * Float(1.05 - 0.95 * t);
      ridge.swing = Draw(rng, 0.03, 0.14) * Float(1.1 - 0.5 * t);
      ridge.frequency = Draw(rng, 1.2, 3.5);
      ridge.trees = t > 0.6 && !sea_ && rng.Bernoulli(0.5) ? Draw(rng, 0.02, 0.05) : 0.0f;
      ridge.color = Mix(far_, near_, Float(std::pow(t, 1.3)));
    }
    seed_ = DrawSeed(rng);
  }

  Vec3f At(float u, float v, float w) const override {
    Vec3f color = Sky(u, v, w);
    if (sea_ && v < horizon_v_ + w) {
      const float depth = std::max(0.02f, horizon_v_ - v);
      const float ripple =
          Gradient2(u * 6.0f / depth * 0.3f, v * 60.0f, seed_ + 9) * Fade(0.03f, w);
      const float glitter =
          SmoothStep(0.16f, 0.0f, std::fabs(u - sun_u_)) * SmoothStep(0.0f, 0.35f, ripple);
      Vec3f water = Mix(horizon_, zenith_, Saturate(2.0f * depth)) * (0.75f + 0.2f * ripple);
      water = Mix(water, sun_, 0.7f * glitter);
      color = Mix(color, water, Inside(v - horizon_v_, w));
    }
    for (int i = 0; i < layers_; ++i) {
      const Ridge& ridge = ridges_[static_cast<size_t>(i)];
      if (sea_ && v < horizon_v_ - w) break;
      const auto salt = seed_ + 17u * static_cast<uint32_t>(i);
      const float x = u * ridge.frequency;
      float top = ridge.base +
                  ridge.swing * (Gradient2(x, 0.5f, salt) + 0.5f * Gradient2(2.3f * x, 3.5f, salt) +
                                 0.22f * Gradient2(6.1f * x, 7.5f, salt));
      if (ridge.trees > 0) {
        // A row of firs: saw teeth of uneven height.
        const float t = u / (0.55f * ridge.trees);
        const int k = noise::FloorInt(t);
        const float tooth = 1.0f - 2.0f * std::fabs(t - static_cast<float>(k) - 0.5f);
        top +=
            Fade(ridge.trees, w) * ridge.trees * tooth * (0.4f + 0.8f * UnitByte(Hash(k, salt), 0));
      }
      if (v > top + w) continue;
      const float mist = Saturate((top - v) * 3.0f);
      const float field = 0.16f * Gradient2(u * 9.0f, v * 30.0f, salt + 5) * Fade(0.04f, w);
      color = Mix(color, Mix(Mix(ridge.color, horizon_, 0.18f), ridge.color, mist) * (1.0f + field),
                  Inside(v - top, w));
    }
    return color;
  }

 private:
  struct Ridge {
    float base, swing, frequency, trees;
    Vec3f color;
  };
  Vec3f Sky(float u, float v, float w) const {
    Vec3f sky = Mix(horizon_, zenith_, Saturate((v - horizon_v_) / (1.05f - horizon_v_)));
    const float d = Length(u - sun_u_, v - sun_v_);
    sky = Mix(sky, sun_, 0.45f * std::max(0.0f, 1.0f - d / 0.4f) * std::max(0.0f, 1.0f - d / 0.4f));
    sky = Mix(sky, sun_, Inside(d - sun_r_, w));
    if (clouds_ > 0) {
      const float n = Gradient2(u * 3.0f, v * 9.0f, seed_ + 1) +
                      0.5f * Gradient2(u * 7.0f, v * 19.0f, seed_ + 2) +
                      0.25f * Gradient2(u * 15.0f, v * 40.0f, seed_ + 3) * Fade(0.03f, w);
      sky = Mix(sky, Mix(horizon_, Vec3f::Constant(0.85f), 0.5f),
                clouds_ * SmoothStep(0.05f, 0.6f, n));
    }
    return sky;
  }

  Vec3f zenith_, horizon_, sun_, far_, near_;
  float horizon_v_, sun_u_, sun_v_, sun_r_, clouds_;
  bool sea_;
  int layers_;
  std::array<Ridge, 6> ridges_;
};

class City final : public Art {
 public:
  explicit City(Rng& rng) {
    night_ = rng.Bernoulli(0.6);
    top_ = VaryColor(rng, SrgbColor(night_ ? 0x141a30 : 0x7fa8c9), 0.2, 0.1);
    low_ = VaryColor(rng, SrgbColor(night_ ? 0x5a4a6a : 0xe6d8c4), 0.2, 0.1);
    tower_ = VaryColor(rng, SrgbColor(night_ ? 0x232838 : 0x8a7f78), 0.2, 0.08);
    window_ = night_ ? SrgbColor(0xf0c878) : SrgbColor(0x3a4a5a);
    columns_ = Draw(rng, 6, 11);
    lit_ = Draw(rng, 0.25, 0.7);
    moon_u_ = Draw(rng, 0.1, 0.9);
    seed_ = DrawSeed(rng);
  }
  Vec3f At(float u, float v, float w) const override {
    Vec3f color = Mix(low_, top_, Saturate(1.2f * v));
    color =
        Mix(color, Vec3f(0.82f, 0.8f, 0.72f), Inside(Length(u - moon_u_, v - 0.85f) - 0.045f, w));
    for (int layer = 0; layer < 3; ++layer) {
      const auto salt = seed_ + 31u * static_cast<uint32_t>(layer);
      const float x = u * columns_ * (1.0f + 0.25f * static_cast<float>(2 - layer)) +
                      0.37f * static_cast<float>(layer);
      const int i = noise::FloorInt(x);
      const float f = x - static_cast<float>(i);
      const uint32_t id = Hash(i, salt);
      const float top =
          (0.30f + 0.42f * UnitByte(id, 0)) * (1.0f - 0.22f * static_cast<float>(layer));
      const float side = 0.5f - 0.06f * UnitByte(id, 1) - std::fabs(f - 0.5f);
      const float inside = Inside(v - top, w) * Inside(-side / columns_, w);
      if (inside <= 0) continue;
      Vec3f wall = Mix(low_, tower_, 0.35f + 0.325f * static_cast<float>(layer)) *
                   (0.8f + 0.4f * UnitByte(id, 2));
      const float wx = f * 7.0f, wy = v * 46.0f;
      const uint32_t pane = Hash(noise::FloorInt(wx) + i * 16, noise::FloorInt(wy), salt + 7);
      const float hole = Inside(std::fabs(Fract(wx) - 0.5f) - 0.3f, 7 * columns_ * w) *
                         Inside(std::fabs(Fract(wy) - 0.5f) - 0.28f, 46 * w);
      const float shown =
          noise::Lerp(0.3f * lit_, hole * (noise::Unit(pane) < lit_ ? 1.0f : 0.0f), Fade(0.04f, w));
      wall = Mix(wall, window_, 0.8f * shown);
      color = Mix(color, wall, inside);
    }
    return color;
  }

 private:
  bool night_;
  Vec3f top_, low_, tower_, window_;
  float columns_, lit_, moon_u_;
};

// Ellipses on each other: hair, neck, shoulders, face, features.
class Figure final : public Art {
 public:
  explicit Figure(Rng& rng) {
    static constexpr std::array<uint32_t, 6> kSkins = {0xe0b898, 0xc98f6a, 0x8f5a3c,
                                                       0x5f3a28, 0xd9a98a, 0xb9cfc4};
    const Palette palette = DrawPalette(rng);
    ground_ = palette[3];
    second_ = palette[4];
    const Vec3f skin = VaryColor(rng, SrgbColor(rng.Pick(kSkins)), 0.1, 0.04);
    const Vec3f hair = VaryColor(rng, palette[0], 0.3, 0.05);
    const float lean = Draw(rng, -0.06, 0.06), face = Draw(rng, 0.13, 0.18);
    const float cu = 0.5f + lean, cv = Draw(rng, 0.56, 0.66);
    const auto add = [&](float u, float v, float a, float b, const Vec3f& color) {
      ellipses_[static_cast<size_t>(count_++)] = {u, v, a, b, color};
    };
    const float volume = Draw(rng, 1.15, 1.6);
    add(cu, cv + 0.03f, face * volume, face * 1.35f * Draw(rng, 1.05, 1.3), hair);
    add(0.5f, -0.05f, Draw(rng, 0.34, 0.44), 0.38f, palette[1]);
    add(cu - 0.3f * lean, cv - face * 1.3f, 0.45f * face, 0.8f * face, skin * 0.8f);
    add(cu, cv, face, 1.3f * face, skin);
    add(cu, cv + 1.05f * face, 0.95f * face, 0.5f * face, hair);
    for (int side = -1; side <= 1; side += 2) {
      const float s = static_cast<float>(side);
      add(cu + s * 0.42f * face, cv + 0.12f * face, 0.2f * face, 0.1f * face,
          Vec3f::Constant(0.75f));
      add(cu + s * 0.42f * face, cv + 0.12f * face, 0.08f * face, 0.09f * face, palette[0] * 0.6f);
      add(cu + s * 0.42f * face, cv + 0.34f * face, 0.25f * face, 0.05f * face, hair);
      add(cu + s * 0.55f * face, cv - 0.35f * face, 0.22f * face, 0.16f * face,
          Mix(skin, Vec3f(0.7f, 0.25f, 0.2f), 0.25f));
    }
    add(cu + 0.06f * face, cv - 0.2f * face, 0.1f * face, 0.3f * face, skin * 0.82f);
    add(cu, cv - 0.66f * face, 0.3f * face, 0.09f * face, Vec3f(0.42f, 0.1f, 0.09f));
    seed_ = DrawSeed(rng);
  }
  Vec3f At(float u, float v, float w) const override {
    const float brush = Gradient2(u * 14.0f + 2.0f * v, v * 7.0f, seed_) * Fade(0.07f, w);
    Vec3f color = Mix(ground_, second_, Saturate(0.5f + 0.7f * brush + 0.4f * (v - 0.5f)));
    const float wobble = 0.008f * Gradient2(u * 11.0f, v * 11.0f, seed_ + 1) * Fade(0.09f, w);
    for (int i = 0; i < count_; ++i) {
      const Ellipse& e = ellipses_[static_cast<size_t>(i)];
      const float dx = (u - e.u) / e.a, dy = (v - e.v) / e.b;
      const float r2 = dx * dx + dy * dy;
      if (r2 > 4.0f) continue;
      const float d = (std::sqrt(r2) - 1.0f) * std::min(e.a, e.b) + wobble;
      // Lit from the left above.
      const float shade =
          1.0f + 0.22f * Saturate(0.5f * (dy - dx)) - 0.25f * Saturate(0.5f * (dx - dy));
      color = Mix(color, e.color * (shade + 0.1f * brush), Inside(d, w));
    }
    return color;
  }

 private:
  struct Ellipse {
    float u, v, a, b;
    Vec3f color;
  };
  Vec3f ground_, second_;
  std::array<Ellipse, 16> ellipses_;
  int count_ = 0;
};

class Botanical final : public Art {
 public:
  explicit Botanical(Rng& rng) {
    static constexpr std::array<uint32_t, 5> kGreens = {0x4a6b3f, 0x6f8f5a, 0x3a5a4a, 0x8a8f4a,
                                                        0x2f4a38};
    static constexpr std::array<uint32_t, 6> kBlooms = {0xc9503f, 0xd98fa0, 0xe0b03f,
                                                        0x7a5aa0, 0xe6e0d4, 0x5a7fb0};
    paper_ = PickColor(rng, {0xe8e2d2, 0xdcd8c6, 0xc9d0c4, 0xd9c4b4, 0x2a3a36}, 0.06, 0.03);
    leaf_ = VaryColor(rng, SrgbColor(rng.Pick(kGreens)));
    bloom_ = VaryColor(rng, SrgbColor(rng.Pick(kBlooms)));
    heart_ = SrgbColor(0xd9b04a);
    stems_ = rng.UniformInt(1, 4);
    for (int i = 0; i < stems_; ++i) {
      Stem& stem = stem_[static_cast<size_t>(i)];
      stem.foot = 0.5f + 0.06f * Float(i - 0.5 * (stems_ - 1));
      stem.lean = stems_ == 1
                      ? Draw(rng, -0.1, 0.1)
                      : Float((i - 0.5 * (stems_ - 1)) / stems_ * 0.9) + Draw(rng, -0.06, 0.06);
      stem.top = Draw(rng, 0.62, 0.85);
      stem.gap = Draw(rng, 0.07, 0.13);
      stem.length = Draw(rng, 0.07, 0.15);
      stem.petals = rng.UniformInt(0, 8);
      stem.bloom = Draw(rng, 0.05, 0.1);
    }
    vase_ = rng.Bernoulli(0.5);
    pot_ = VaryColor(rng, DrawPalette(rng)[1]);
  }
  Vec3f At(float u, float v, float w) const override {
    Vec3f color = paper_;
    for (int i = 0; i < stems_; ++i) {
      const Stem& stem = stem_[static_cast<size_t>(i)];
      const float rise = Saturate(v / stem.top);
      const float x = u - stem.foot - stem.lean * rise * rise;
      if (v < stem.top) {
        color = Mix(color, leaf_ * 0.7f, Inside(std::fabs(x) - 0.006f, w));
        // Leaves in pairs, each rises from its node.
        const float reach = std::fabs(x);
        if (v > 0.12f && reach < 1.2f * stem.length) {
          const float t = (v - 0.45f * reach) / stem.gap;
          const float row = (Fract(t) - 0.5f) * stem.gap;
          const float along = reach / stem.length * 2.0f - 1.0f;
          const float half = 0.32f * stem.gap * std::max(0.0f, 1.0f - along * along);
          const float d = std::max(std::fabs(row) - half, reach - stem.length);
          const float vein = 0.8f + 0.25f * Saturate(std::fabs(row) / std::max(half, 1e-3f)) +
                             0.15f * (x > 0 ? 1.0f : 0.0f);
          color = Mix(color, leaf_ * vein, Inside(d, w));
        }
      }
      if (stem.petals >= 3) {
        const float dx = u - stem.foot - stem.lean, dy = v - stem.top;
        const float r = Length(dx, dy);
        if (r < 1.6f * stem.bloom) {
          const float turn = std::atan2(dy, dx) * (1.0f / 6.2831853f);
          const float lobe = CosTurn(turn * static_cast<float>(stem.petals));
          const float d = r - stem.bloom * (0.78f + 0.3f * lobe);
          color = Mix(color, bloom_ * (0.75f + 0.3f * r / stem.bloom), Inside(d, w));
          color = Mix(color, heart_, Inside(r - 0.28f * stem.bloom, w));
        }
      }
    }
    if (vase_) {
      const float y = v / 0.34f;
      const float half = 0.075f + 0.05f * CosTurn(0.62f * y - 0.22f);
      color = Mix(color, pot_ * (1.05f - 2.2f * std::fabs(u - 0.46f)),
                  Inside(std::max(std::fabs(u - 0.5f) - half, std::max(v - 0.34f, 0.06f - v)), w));
    }
    return color;
  }

 private:
  struct Stem {
    float foot, lean, top, gap, length, bloom;
    int petals;
  };
  Vec3f paper_, leaf_, bloom_, heart_, pot_;
  std::array<Stem, 4> stem_;
  int stems_;
  bool vase_;
};

}  // namespace

std::unique_ptr<const Art> DrawScene(Rng& rng, ArtStyle style) {
  switch (style) {
    case ArtStyle::kLandscape:
      return std::make_unique<Landscape>(rng);
    case ArtStyle::kCity:
      return std::make_unique<City>(rng);
    case ArtStyle::kFigure:
      return std::make_unique<Figure>(rng);
    case ArtStyle::kBotanical:
      return std::make_unique<Botanical>(rng);
    default:
      return nullptr;
  }
}

}  // namespace parallax::art
