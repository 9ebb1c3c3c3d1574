#include "worker/materials/art/art_parts.h"

namespace parallax::art {
namespace {

using namespace noise;  // NOLINT: the vocabulary of patterns.

class Fields final : public Art {
 public:
  explicit Fields(Rng& rng) : palette_(DrawPalette(rng)) {
    rng.Shuffle(palette_);
    count_ = rng.UniformInt(2, 4);
    float at = 0.05f;
    for (int i = 0; i < count_; ++i) {
      const float height = (0.92f - at) / static_cast<float>(count_ - i) * Draw(rng, 0.75, 1.1);
      low_[static_cast<size_t>(i)] = at;
      high_[static_cast<size_t>(i)] = std::min(0.95f, at + height - 0.03f);
      at = std::min(0.93f, at + height);
    }
    seed_ = DrawSeed(rng);
  }
  Vec3f At(float u, float v, float w) const override {
    const float rough = 0.014f * Gradient2(u * 17.0f, v * 17.0f, seed_) +
                        0.008f * Gradient2(u * 60.0f, v * 60.0f, seed_ + 1) * Fade(0.016f, w);
    const float wash = 0.14f * Gradient2(u * 3.0f, v * 4.0f, seed_ + 2) +
                       0.09f * Gradient2(u * 24.0f, v * 9.0f, seed_ + 3) * Fade(0.04f, w);
    Vec3f color = palette_[0];
    for (int i = 0; i < count_; ++i) {
      const auto k = static_cast<size_t>(i);
      const float d =
          std::max(std::fabs(u - 0.5f) - 0.42f, std::max(low_[k] - v, v - high_[k])) + rough;
      color = Mix(color, palette_[k + 1], 1.0f - Edge(d, 0.025f, 1.2f * w));
    }
    return color * (1.0f + wash);
  }

 private:
  Palette palette_;
  int count_;
  std::array<float, 4> low_, high_;
};

class Blocks final : public Art {
 public:
  explicit Blocks(Rng& rng) : palette_(DrawPalette(rng)) {
    bar_ = Draw(rng, 0.006, 0.016);
    ink_ = rng.Bernoulli(0.7) ? Vec3f::Constant(0.025f) : Vec3f::Constant(0.8f);
    Split(rng, {0, 0, 1, 1, Vec3f::Zero()}, 0);
  }
  Vec3f At(float u, float v, float w) const override {
    for (int i = 0; i < count_; ++i) {
      const Block& b = blocks_[static_cast<size_t>(i)];
      if (u < b.u0 || u > b.u1 || v < b.v0 || v > b.v1) continue;
      const float edge = std::min(std::min(u - b.u0, b.u1 - u), std::min(v - b.v0, b.v1 - v));
      return Mix(b.color, ink_, LineShare(edge, bar_, 0.002f, 1.2f * w));
    }
    return ink_;
  }

 private:
  struct Block {
    float u0, v0, u1, v1;
    Vec3f color;
  };
  void Split(Rng& rng, Block block, int depth) {
    const float width = block.u1 - block.u0, height = block.v1 - block.v0;
    const bool stop =
        depth >= 4 || (depth >= 2 && rng.Bernoulli(0.3)) || std::max(width, height) < 0.2f;
    if (stop) {
      block.color = rng.Bernoulli(0.5) ? Vec3f(Mix(palette_[4], Vec3f::Constant(0.8f), 0.7f))
                                       : rng.Pick(palette_);
      blocks_[static_cast<size_t>(count_++)] = block;
      return;
    }
    const float t = Draw(rng, 0.25, 0.75);
    Block first = block, second = block;
    if (width * Draw(rng, 0.7, 1.4) > height) {
      first.u1 = second.u0 = block.u0 + t * width;
    } else {
      first.v1 = second.v0 = block.v0 + t * height;
    }
    Split(rng, first, depth + 1);
    Split(rng, second, depth + 1);
  }

  Palette palette_;
  float bar_;
  Vec3f ink_;
  std::array<Block, 16> blocks_;
  int count_ = 0;
};

class Modules final : public Art {
 public:
  explicit Modules(Rng& rng) : palette_(DrawPalette(rng)) {
    columns_ = Float(rng.UniformInt(3, 7));
    rows_ = Float(rng.UniformInt(3, 8));
    seed_ = DrawSeed(rng);
  }
  Vec3f At(float u, float v, float w) const override {
    const float a = u * columns_, b = v * rows_;
    const int i = noise::FloorInt(a), j = noise::FloorInt(b);
    float x = a - static_cast<float>(i), y = b - static_cast<float>(j);
    const uint32_t id = Hash(i, j, seed_);
    const Vec3f& ground = PickFrom(palette_, id);
    const Vec3f& figure = PickFrom(palette_, id + 1 + (id >> 8) % 4);
    if (id & 0x10000) x = 1 - x;
    if (id & 0x20000) y = 1 - y;
    const float cw = w * std::max(columns_, rows_);
    float d;
    switch ((id >> 20) % 7) {
      case 0:
        d = Length(x, y) - 1.0f;
        break;
      case 1:
        d = Length(x - 0.5f, y - 0.5f) - 0.4f;
        break;
      case 2:
        d = (x + y - 1.0f) * 0.7071f;
        break;
      case 3:
        d = std::fabs(Length(x, y) - 0.7f) - 0.3f;
        break;
      case 4:
        d = std::max(Length(x - 0.5f, y) - 0.5f, -y);
        break;
      case 5:
        d = std::fabs(Fract(y * 3.0f) - 0.5f) / 3.0f - 0.08f;
        break;
      default:
        d = std::fabs(x - 0.5f) + std::fabs(y - 0.5f) - 0.42f;
        break;
    }
    return Mix(ground, figure, Inside(d, cw));
  }

 private:
  Palette palette_;
  float columns_, rows_;
};

class Circles final : public Art {
 public:
  explicit Circles(Rng& rng) : palette_(DrawPalette(rng)) {
    ground_ = Mix(palette_[4], Vec3f::Constant(0.78f), Draw(rng, 0.0, 0.7));
    count_ = rng.UniformInt(7, static_cast<int>(shapes_.size()));
    for (int i = 0; i < count_; ++i) {
      Shape& s = shapes_[static_cast<size_t>(i)];
      s.kind = rng.UniformInt(0, 3);
      s.u = Draw(rng, 0.05, 0.95);
      s.v = Draw(rng, 0.05, 0.95);
      s.r = Draw(rng, 0.03, 0.24) * (i < 3 ? 1.4f : 1.0f);
      const double angle = rng.Uniform(0, 6.2831853);
      s.c = Float(std::cos(angle));
      s.s = Float(std::sin(angle));
      s.color = rng.Pick(palette_);
    }
  }
  Vec3f At(float u, float v, float w) const override {
    Vec3f color = ground_;
    for (int i = 0; i < count_; ++i) {
      const Shape& s = shapes_[static_cast<size_t>(i)];
      const float dx = u - s.u, dy = v - s.v;
      const float x = s.c * dx + s.s * dy, y = s.c * dy - s.s * dx;
      float d;
      switch (s.kind) {
        case 0:
          d = Length(dx, dy) - s.r;
          break;
        case 1:
          d = std::fabs(Length(dx, dy) - s.r) - 0.12f * s.r;
          break;
        case 2:
          d = std::max(std::fabs(x) - 1.9f * s.r, std::fabs(y) - 0.035f);
          break;
        default:
          d = std::max(std::fabs(x) * 0.87f + 0.5f * y, -y) - 0.5f * s.r;
          break;
      }
      color = Mix(color, s.color, 0.93f * Inside(d, w));
    }
    return color;
  }

 private:
  struct Shape {
    int kind;
    float u, v, r, c, s;
    Vec3f color;
  };
  Palette palette_;
  Vec3f ground_;
  std::array<Shape, 18> shapes_;
  int count_;
};

// Blends along the palette by a number in [0, 1].
Vec3f Ramp(const Palette& palette, float t) {
  const float x = Saturate(t) * 3.999f;
  const auto k = static_cast<size_t>(x);
  return Mix(palette[k], palette[k + 1], SmoothStep(0.25f, 0.75f, x - static_cast<float>(k)));
}

class Fluid final : public Art {
 public:
  explicit Fluid(Rng& rng) : palette_(DrawPalette(rng)) {
    rng.Shuffle(palette_);
    scale_ = Draw(rng, 1.2, 3.0);
    bands_ = Draw(rng, 0.6, 1.8);
    seed_ = DrawSeed(rng);
  }
  Vec3f At(float u, float v, float w) const override {
    const float x = u * scale_, y = v * scale_;
    const float a = Gradient2(x, y, seed_), b = Gradient2(x, y, seed_ + 1);
    const float c = Gradient2(x + 1.6f * a, y + 1.6f * b, seed_ + 2),
                d = Gradient2(2 * x + 1.6f * b, 2 * y, seed_ + 3);
    const float n = Gradient2(x + 1.8f * c, y + 1.8f * d, seed_ + 4) + 0.4f * d;
    const float fine =
        0.12f * Gradient2(9.0f * x + 4 * n, 9.0f * y, seed_ + 5) * Fade(0.1f / scale_, w);
    return Ramp(palette_, 0.5f + 0.45f * CosTurn(bands_ * n + fine));
  }

 private:
  Palette palette_;
  float scale_, bands_;
};

class CellArt final : public Art {
 public:
  explicit CellArt(Rng& rng) : palette_(DrawPalette(rng)) {
    scale_ = Draw(rng, 4, 10);
    lead_ = rng.Bernoulli(0.7) ? Draw(rng, 0.03, 0.07) : 0.0f;
    seed_ = DrawSeed(rng);
  }
  Vec3f At(float u, float v, float w) const override {
    const noise::Cell cell = noise::Cells2(u * scale_, v * scale_, seed_);
    const Vec3f color = PickFrom(palette_, cell.id) * (0.8f + 0.4f * UnitByte(cell.id, 2)) *
                        (1.05f - 0.25f * cell.f1);
    return Mix(
        color, Vec3f::Constant(0.03f),
        lead_ > 0 ? LineShare(0.5f * (cell.f2 - cell.f1), lead_, 0.02f, 1.2f * w * scale_) : 0.0f);
  }

 private:
  Palette palette_;
  float scale_, lead_;
};

class Waves final : public Art {
 public:
  explicit Waves(Rng& rng) : palette_(DrawPalette(rng)) {
    stripes_ = Draw(rng, 7, 22);
    swing_ = Draw(rng, 0.05, 0.2);
    scale_ = Draw(rng, 1.0, 3.0);
    two_ = rng.Bernoulli(0.4);
    seed_ = DrawSeed(rng);
  }
  Vec3f At(float u, float v, float w) const override {
    const float bend = Gradient2(u * scale_, v * scale_, seed_) +
                       0.3f * Gradient2(u * 3 * scale_, v * 3 * scale_, seed_ + 1);
    const float t = (v + swing_ * bend) * stripes_;
    const int k = noise::FloorInt(t);
    const auto color = [&](int i) {
      return two_ ? palette_[(i & 1) ? 0 : 4] : PickFrom(palette_, Hash(i, seed_ + 2));
    };
    const float f = t - static_cast<float>(k), soft = std::min(0.5f, 0.03f + 1.5f * w * stripes_);
    Vec3f out = color(k);
    out = Mix(out, color(k + 1), 0.5f * SmoothStep(1.0f - soft, 1.0f, f));
    return Mix(out, color(k - 1), 0.5f * (1.0f - SmoothStep(0.0f, soft, f)));
  }

 private:
  Palette palette_;
  float stripes_, swing_, scale_;
  bool two_;
};

}  // namespace

std::unique_ptr<const Art> DrawAbstract(Rng& rng, ArtStyle style) {
  switch (style) {
    case ArtStyle::kFields:
      return std::make_unique<Fields>(rng);
    case ArtStyle::kBlocks:
      return std::make_unique<Blocks>(rng);
    case ArtStyle::kModules:
      return std::make_unique<Modules>(rng);
    case ArtStyle::kCircles:
      return std::make_unique<Circles>(rng);
    case ArtStyle::kFluid:
      return std::make_unique<Fluid>(rng);
    case ArtStyle::kCells:
      return std::make_unique<CellArt>(rng);
    case ArtStyle::kWaves:
      return std::make_unique<Waves>(rng);
    default:
      return nullptr;
  }
}

}  // namespace parallax::art
