// Family `picture`: what is printed or painted over uv in [0, 1]^2: paintings, posters, book
// covers, labels, pages, screens.
#include <array>
#include <string>

#include "worker/materials/art.h"
#include "worker/materials/families.h"
#include "worker/materials/stroke_font.h"

namespace parallax {
namespace {

using noise::Fade;
using noise::Fract;
using noise::Gradient2;
using noise::Hash;
using noise::Saturate;
using noise::UnitByte;

enum class Ground { kCanvas, kPaper, kCoated };

// Common to all pictures: the ground they are on, and their fading to one colour from far away.
class Printed : public PointMaterial {
 public:
  SurfaceSample EvaluatePoint(const SurfacePoint& point) const override {
    const float w = point.footprint_uv > 0 ? point.footprint_uv : point.footprint_m * 2.0f;
    const float u = Saturate(point.uv.x()), v = Saturate(point.uv.y());
    const float shown = Fade(0.9f, w);
    Vec3f color = mean_;
    if (shown > 0) color = Mix(mean_, Ink(u, v, w), shown);
    const float grain = Grain(point);
    const float age = noise::Fbm3(point.texture_m, 0.12f, 3, point.footprint_m, seed_);
    SurfaceSample out;
    out.base_color = Albedo(color * (1.0f + 0.07f * grain + 0.03f * age));
    out.roughness = Saturate(roughness_ * (1.0f + 0.12f * grain + 0.1f * age));
    out.specular = ground_ == Ground::kCanvas ? 0.4f : 0.5f;
    return out;
  }
  float HeightOfPoint(const SurfacePoint& point) const override {
    return (ground_ == Ground::kCanvas ? 7e-5f : 8e-6f) * Grain(point);
  }

 protected:
  Printed(Rng& rng, Ground ground) : ground_(ground) {
    roughness_ = ground == Ground::kCanvas  ? Draw(rng, 0.45, 0.75)
                 : ground == Ground::kPaper ? Draw(rng, 0.6, 0.85)
                                            : Draw(rng, 0.15, 0.45);
    seed_ = DrawSeed(rng);
  }
  virtual Vec3f Ink(float u, float v, float w) const = 0;
  // The last thing a constructor does.
  void MeasureMean() {
    constexpr int kSide = 20;
    mean_.setZero();
    for (int i = 0; i < kSide * kSide; ++i) {
      mean_ += Ink((Float(i % kSide) + 0.5f) / kSide, (Float(i / kSide) + 0.5f) / kSide, 0.02f);
    }
    mean_ /= kSide * kSide;
  }
  const Vec3f& mean() const { return mean_; }
  uint32_t seed() const { return seed_; }

 private:
  float Grain(const SurfacePoint& point) const {
    const PlanePoint plane = OnPlane(point);
    const float w = point.footprint_m;
    if (ground_ != Ground::kCanvas) {
      return Fade(2e-3f, w) * Gradient2(plane.u * 500.0f, plane.v * 500.0f, seed_ + 1);
    }
    // Canvas under paint: threads, and strokes of a brush that turn slowly.
    const float fade = Fade(1.6e-3f, w);
    const float thread =
        fade > 0
            ? fade * 0.5f * (noise::CosTurn(plane.u * 700.0f) + noise::CosTurn(plane.v * 700.0f))
            : 0.0f;
    const float stroke =
        Fade(3e-3f, w) * Gradient2(plane.u * 60.0f + 20.0f * plane.v, plane.v * 330.0f, seed_ + 2);
    return 0.4f * thread + stroke;
  }

  Ground ground_;
  float roughness_;
  uint32_t seed_;
  Vec3f mean_ = Vec3f::Zero();
};

std::string DrawWord(Rng& rng, int syllables) {
  static constexpr std::array<const char*, 24> kOnsets = {
      "B", "C", "D", "F",  "G",  "K",  "L",  "M",  "N",  "P",  "R", "S",
      "T", "V", "Z", "BR", "CL", "GR", "ST", "TR", "SH", "PL", "H", "J"};
  static constexpr std::array<const char*, 8> kVowels = {"A", "E", "I", "O", "U", "IA", "EO", "A"};
  static constexpr std::array<const char*, 10> kEnds = {"",  "",  "",  "",  "N",
                                                        "R", "S", "L", "X", "NT"};
  std::string word;
  for (int i = 0; i < syllables; ++i) {
    word += rng.Pick(kOnsets);
    word += rng.Pick(kVowels);
    if (i + 1 == syllables) word += rng.Pick(kEnds);
  }
  return word;
}

// One line of lettering in a box of the picture.
struct Lettering {
  std::string text;
  float u = 0, v = 0, width = 1,
        height = 0.1f;  // Lower left corner and size of the box that the text fills.
  float stroke = 0.5f;  // Half the pen's width in cell units.
  Vec3f color = Vec3f::Constant(0.05f);

  Vec3f Over(const Vec3f& under, float at_u, float at_v, float w) const {
    const float margin = 0.02f + w;
    if (at_u < u - margin || at_u > u + width + margin || at_v < v - margin ||
        at_v > v + height + margin)
      return under;
    const float unit_u = width / TextWidth(text), unit_v = height / kGlyphHeight;
    const float unit = std::sqrt(unit_u * unit_v);
    const float d = TextDistance(text, (at_u - u) / unit_u, (at_v - v) / unit_v);
    const float soft = std::max(0.12f, 1.2f * w / unit);
    // A pen finer than the footprint greys its surroundings by its share.
    const float thin = std::min(1.0f, 2.0f * stroke / soft + 0.3f);
    return Mix(under, color,
               thin * (1.0f - noise::SmoothStep(stroke - 0.5f * soft, stroke + 0.5f * soft, d)));
  }
};

// A block of small print: lines of words of random lengths that nobody reads.
struct SmallPrint {
  float u0 = 0, v0 = 0, u1 = 1, v1 = 1;
  float line = 0.03f;  // From line to line.
  Vec3f color = Vec3f::Constant(0.08f);
  uint32_t seed = 0;

  Vec3f Over(const Vec3f& under, float u, float v, float w) const {
    if (u < u0 || u > u1 || v < v0 || v > v1) return under;
    const float row = (v1 - v) / line;
    const int j = noise::FloorInt(row);
    const uint32_t id = Hash(j, seed);
    const float end = UnitByte(id, 0) < 0.22f ? 0.3f + 0.6f * UnitByte(id, 1) : 1.0f;
    if ((u - u0) > end * (u1 - u0)) return under;
    // Letters are bumps of noise along the line; words are their gaps.
    const float x = (u - u0) / line;
    const float letter = Gradient2(x * 5.5f, static_cast<float>(j) * 3.7f, seed + 1);
    const float word = Gradient2(x * 0.9f, static_cast<float>(j) * 5.3f, seed + 2);
    const float body = std::fabs(row - static_cast<float>(j) - 0.5f);
    const float ink = noise::SmoothStep(-0.12f, 0.12f, letter) *
                      noise::SmoothStep(-0.42f, -0.32f, word) *
                      (1.0f - noise::SmoothStep(0.2f, 0.28f, body));
    const float fade = Fade(0.5f * line, w);
    return Mix(under, color, 0.24f + fade * (ink - 0.24f));
  }
};

// ---- Paintings

class Painting final : public Printed {
 public:
  Painting(Rng& rng, std::vector<ArtStyle> styles)
      : Printed(rng, rng.Bernoulli(0.7) ? Ground::kCanvas : Ground::kPaper),
        art_(DrawArt(rng, rng.Pick(styles))) {
    mount_ = rng.Bernoulli(0.3) ? Draw(rng, 0.05, 0.14) : 0.0f;
    mount_color_ = VaryColor(rng, SrgbColor(0xe6e2d8), 0.05, 0.02);
    MeasureMean();
  }

 private:
  Vec3f Ink(float u, float v, float w) const override {
    if (mount_ <= 0) return art_->At(u, v, w);
    const float inner = 1.0f - 2.0f * mount_;
    const float d = std::min(std::min(u, 1 - u), std::min(v, 1 - v)) - mount_;
    const Vec3f art =
        art_->At(Saturate((u - mount_) / inner), Saturate((v - mount_) / inner), w / inner);
    return Mix(mount_color_, art, Edge(d, 0.002f, w));
  }

  std::unique_ptr<const Art> art_;
  float mount_;
  Vec3f mount_color_;
};

// ---- Prints with lettering

// Posters and book covers: a ground, a picture in a window, a title, small print.
class Cover final : public Printed {
 public:
  Cover(Rng& rng, bool book) : Printed(rng, rng.Bernoulli(0.6) ? Ground::kCoated : Ground::kPaper) {
    std::array<Vec3f, 5> palette = DrawPalette(rng);
    const bool dark = rng.Bernoulli(0.5);
    ground_ = dark ? palette[static_cast<size_t>(rng.UniformInt(0, 1))]
                   : palette[static_cast<size_t>(rng.UniformInt(2, 4))];
    const Vec3f ink = Luminance(ground_) < 0.2f ? palette[4] : palette[0];
    const size_t first = static_cast<size_t>(rng.UniformInt(1, 3));
    const Vec3f accent = palette[(palette[first] - ground_).norm() > 0.08f ? first : first % 3 + 1];
    layout_ = rng.UniformInt(0, 3);
    art_ = DrawAnyArt(rng);
    switch (layout_) {
      case 0:
        window_ = {0, 0, 1, Draw(rng, 0.5, 0.66)};
        break;  // Below the title.
      case 1:
        window_ = {0.12f, 0.24f, 0.88f, Draw(rng, 0.6, 0.7)};
        break;  // Framed.
      case 2:
        window_ = {0, Draw(rng, 0.26, 0.4), 1, 1};
        break;  // Above.
      default:
        window_ = {0, 0, 0, 0};
        break;  // Type over all of it.
    }
    frame_ = rng.Bernoulli(0.35) ? Draw(rng, 0.02, 0.05) : 0.0f;
    band_color_ = accent;
    const bool title_low = layout_ == 2;
    const int lines = layout_ == 3 ? rng.UniformInt(2, 4) : rng.UniformInt(1, 2);
    const float low = layout_ == 3 ? 0.42f
                      : title_low  ? 0.10f
                                   : 0.74f,
                high = title_low ? window_[1] - 0.05f : 0.93f;
    const float step = (high - low) / Float(lines);
    for (int i = 0; i < lines; ++i) {
      Lettering line;
      line.text = DrawWord(rng, rng.UniformInt(1, 3));
      line.height = step * Draw(rng, 0.62, 0.78);
      line.width =
          std::min(0.8f, line.height * 0.62f * Float(static_cast<double>(line.text.size())) *
                             Draw(rng, 0.8, 1.3));
      line.u = rng.Bernoulli(0.5) ? 0.1f : 0.5f - 0.5f * line.width;
      line.v = high - step * Float(i + 1) + 0.1f * step;
      line.stroke = Draw(rng, 0.3, 0.75);
      line.color = rng.Bernoulli(0.7) ? ink : accent;
      letters_.push_back(line);
    }
    Lettering author;
    author.text = DrawWord(rng, 2) + " ";
    author.text += DrawWord(rng, 2);
    author.height = Draw(rng, 0.025, 0.04);
    author.width = 0.5f;
    author.u = 0.25f;
    author.v = book ? 0.05f : 0.16f;
    author.color = layout_ == 0 ? Vec3f::Constant(0.78f) : ink;
    letters_.push_back(author);
    print_ = {0.1f,
              book ? 0.12f : 0.03f,
              rng.Bernoulli(0.5) ? 0.9f : 0.5f,
              book ? 0.2f : 0.13f,
              Draw(rng, 0.014, 0.024),
              ink,
              DrawSeed(rng)};
    small_print_ = layout_ == 1 || layout_ == 3 || !book;
    MeasureMean();
  }

 private:
  Vec3f Ink(float u, float v, float w) const override {
    Vec3f color = ground_;
    if (layout_ == 3) {
      // Two inks: the picture's light and dark under the type.
      color = Mix(color, band_color_,
                  0.75f * noise::SmoothStep(0.1f, 0.4f, Luminance(art_->At(u, v, w))));
    } else {
      const float d = std::min(std::min(u - window_[0], window_[2] - u),
                               std::min(v - window_[1], window_[3] - v));
      const float inside = Edge(d, 0.002f, w);
      if (inside > 0) {
        const float su = window_[2] - window_[0], sv = window_[3] - window_[1];
        color = Mix(color,
                    art_->At(Saturate((u - window_[0]) / su), Saturate((v - window_[1]) / sv),
                             w / std::min(su, sv)),
                    inside);
      }
    }
    if (frame_ > 0) {
      const float d = std::min(std::min(u, 1 - u), std::min(v, 1 - v));
      color = Mix(color, band_color_, LineShare(std::fabs(d - frame_), 0.006f, 0.002f, w));
    }
    if (small_print_) color = print_.Over(color, u, v, w);
    for (const Lettering& line : letters_) color = line.Over(color, u, v, w);
    return color;
  }

  std::unique_ptr<const Art> art_;
  Vec3f ground_, band_color_;
  int layout_;
  bool small_print_;
  std::array<float, 4> window_;
  float frame_;
  std::vector<Lettering> letters_;
  SmallPrint print_;
};

// Packages: bands, a badge with the brand, a pattern, contents, a bar code.
class ProductLabel final : public Printed {
 public:
  explicit ProductLabel(Rng& rng) : Printed(rng, Ground::kCoated) {
    palette_ = DrawPalette(rng);
    const bool vivid = rng.Bernoulli(0.6);
    ground_ = palette_[4];
    if (vivid) {
      const double hue = rng.Uniform(), saturation = rng.Uniform(0.45, 0.8);
      ground_ = VaryColor(rng, HsvColor(hue, saturation, rng.Uniform(0.45, 0.85)));
    }
    badge_ = Luminance(ground_) > 0.3f ? palette_[0] : palette_[4];
    badge_kind_ = rng.UniformInt(0, 2);
    badge_v_ = Draw(rng, 0.58, 0.72);
    pattern_ = rng.UniformInt(0, 4);
    pattern_scale_ = Draw(rng, 8, 22);
    band_low_ = Draw(rng, 0.08, 0.2);
    band_high_ = band_low_ + Draw(rng, 0.06, 0.16);
    fruit_ = VaryColor(rng, HsvColor(rng.Uniform(0, 0.4), 0.7, 0.8));
    fruits_ = rng.UniformInt(0, 5);
    brand_.text = DrawWord(rng, rng.UniformInt(2, 3));
    brand_.height = Draw(rng, 0.09, 0.14);
    brand_.width = std::min(0.68f, 0.11f * Float(static_cast<double>(brand_.text.size())));
    brand_.u = 0.5f - 0.5f * brand_.width;
    brand_.v = badge_v_ - 0.5f * brand_.height;
    brand_.stroke = Draw(rng, 0.5, 0.85);
    brand_.color = Luminance(badge_) > 0.3f ? Vec3f(palette_[1] * 0.8f) : palette_[4];
    kind_.text = DrawWord(rng, 1) + " ";
    kind_.text += DrawWord(rng, 2);
    kind_.height = 0.045f;
    kind_.width = 0.5f;
    kind_.u = 0.25f;
    kind_.v = badge_v_ - 0.24f;
    kind_.stroke = 0.45f;
    kind_.color = Luminance(ground_) > 0.25f ? palette_[0] : palette_[4];
    print_ = {0.06f, 0.02f, 0.6f, band_low_ - 0.01f, 0.017f, kind_.color, DrawSeed(rng)};
    MeasureMean();
  }

 private:
  Vec3f Ink(float u, float v, float w) const override {
    Vec3f color = Pattern(u, v, w);
    color =
        Mix(color, palette_[1], 1.0f - Edge(std::max(band_low_ - v, v - band_high_), 0.002f, w));
    color =
        Mix(color, palette_[3], LineShare(std::fabs(v - band_high_ - 0.015f), 0.005f, 0.002f, w));
    for (int i = 0; i < fruits_; ++i) {
      const float a = u - 0.2f - 0.6f * Float(i) / std::max(1.0f, Float(fruits_ - 1)),
                  b = v - band_high_ - 0.06f;
      const float r = std::sqrt(a * a + b * b);
      color = Mix(color, fruit_ * (1.1f - 3.0f * (a - b)), 1.0f - Edge(r - 0.06f, 0.002f, w));
    }
    const float x = std::fabs(u - 0.5f) / 0.42f, y = std::fabs(v - badge_v_) / 0.14f;
    const float d = badge_kind_ == 0   ? std::sqrt(x * x + y * y) - 1.0f
                    : badge_kind_ == 1 ? std::max(x, y) - 1.0f
                                       : std::max(x + 0.25f * y, y) - 1.0f;
    color = Mix(color, badge_, 1.0f - Edge(0.14f * d, 0.002f, w));
    color = Mix(color, palette_[2], LineShare(0.14f * std::fabs(d + 0.1f), 0.004f, 0.002f, w));
    color = print_.Over(color, u, v, w);
    if (u > 0.68f && u < 0.92f && v > 0.02f && v < band_low_ - 0.02f) color = BarCode(u, w);
    return brand_.Over(kind_.Over(color, u, v, w), u, v, w);
  }
  Vec3f Pattern(float u, float v, float w) const {
    const float s = pattern_scale_;
    const float fade = Fade(1.0f / s, w);
    float d = 1;
    switch (pattern_) {
      case 0:
        return ground_;
      case 1:
        d = std::fabs(Fract((u + v) * s * 0.5f) - 0.5f) - 0.25f;
        break;
      case 2: {
        const float x = Fract(u * s) - 0.5f, y = Fract(v * s) - 0.5f;
        d = std::sqrt(x * x + y * y) - 0.28f;
        break;
      }
      case 3:
        d = std::fabs(Fract(u * s * 0.6f) - 0.5f) - 0.25f;
        break;
      default:
        return Mix(ground_ * 0.7f, ground_ * 1.25f, v);
    }
    return Mix(ground_, Mix(ground_, palette_[3], 0.5f),
               0.35f + fade * (1.0f - Edge(d, 0.03f, 1.2f * w * s) - 0.35f));
  }
  Vec3f BarCode(float u, float w) const {
    const int bar = noise::FloorInt((u - 0.68f) * 200.0f);
    const float ink =
        noise::Lerp(0.45f, UnitByte(Hash(bar, seed()), 0) < 0.45f ? 1.0f : 0.0f, Fade(0.012f, w));
    return Vec3f::Constant(0.8f - 0.76f * ink);
  }

  std::array<Vec3f, 5> palette_;
  Vec3f ground_, badge_, fruit_;
  int badge_kind_, pattern_, fruits_;
  float badge_v_, pattern_scale_, band_low_, band_high_;
  Lettering brand_, kind_;
  SmallPrint print_;
};

// A page of a newspaper, book or notebook.
class PrintedPage final : public Printed {
 public:
  explicit PrintedPage(Rng& rng) : Printed(rng, Ground::kPaper) {
    paper_ = VaryColor(rng, SrgbColor(rng.Bernoulli(0.7) ? 0xe6e2d6 : 0xd0c8b6), 0.05, 0.02);
    columns_ = rng.UniformInt(1, 3);
    const float line = Draw(rng, 0.012, 0.026);
    const float width = 0.84f / Float(columns_);
    for (int i = 0; i < columns_; ++i) {
      blocks_.push_back({0.08f + width * Float(i), 0.06f, 0.08f + width * Float(i + 1) - 0.03f,
                         0.82f, line, Vec3f::Constant(0.06f), DrawSeed(rng)});
    }
    title_.text = DrawWord(rng, 2) + " ";
    title_.text += DrawWord(rng, rng.UniformInt(1, 3));
    title_.height = Draw(rng, 0.04, 0.08);
    title_.width = 0.84f;
    title_.u = 0.08f;
    title_.v = 0.86f;
    if (rng.Bernoulli(0.6)) {
      art_ = DrawAnyArt(rng);
      grey_ = rng.Bernoulli(0.5);
      art_v_ = Draw(rng, 0.2, 0.5);
    }
    MeasureMean();
  }

 private:
  Vec3f Ink(float u, float v, float w) const override {
    Vec3f color = paper_;
    for (const SmallPrint& block : blocks_) color = block.Over(color, u, v, w);
    color = title_.Over(color, u, v, w);
    if (art_) {
      const float inside =
          Edge(std::min(std::min(u - 0.08f, 0.89f - u), std::min(v - art_v_, art_v_ + 0.28f - v)),
               0.002f, w);
      if (inside > 0) {
        const Vec3f art =
            art_->At(Saturate((u - 0.08f) / 0.81f), Saturate((v - art_v_) / 0.28f), w / 0.28f);
        color = Mix(color, Desaturate(art, grey_ ? 1.0f : 0.0f), inside);
      }
    }
    return color;
  }

  Vec3f paper_;
  int columns_;
  std::vector<SmallPrint> blocks_;
  Lettering title_;
  std::unique_ptr<const Art> art_;
  bool grey_ = false;
  float art_v_ = 0;
};

// A television, monitor or phone: off, a film, or windows with text and a chart. Glossy glass over
// faint light.
class ScreenPicture final : public Printed {
 public:
  explicit ScreenPicture(Rng& rng) : Printed(rng, Ground::kCoated) {
    kind_ = rng.UniformInt(0, 3);
    art_ = DrawAnyArt(rng);
    const std::array<Vec3f, 5> palette = DrawPalette(rng);
    bar_ = palette[1];
    panel_ = rng.Bernoulli(0.5) ? Vec3f::Constant(0.75f) : Vec3f::Constant(0.04f);
    const Vec3f ink = panel_.x() > 0.3f ? Vec3f::Constant(0.06f) : Vec3f::Constant(0.6f);
    text_ = {0.24f, 0.1f, 0.62f, 0.88f, Draw(rng, 0.018, 0.03), ink, DrawSeed(rng)};
    glow_ = kind_ == 0 ? 0.0f : Draw(rng, 0.5, 1.4);
    MeasureMean();
  }
  SurfaceSample EvaluatePoint(const SurfacePoint& point) const override {
    SurfaceSample out = Printed::EvaluatePoint(point);
    if (kind_ == 0) {
      out.base_color = Vec3f::Constant(0.021f) + 0.06f * out.base_color;
    } else {
      out.emission = glow_ * out.base_color;
      out.base_color = Vec3f::Constant(0.021f) + 0.14f * out.base_color;
    }
    out.roughness = 0.08f;
    return out;
  }
  float HeightOfPoint(const SurfacePoint&) const override { return 0; }

 private:
  Vec3f Ink(float u, float v, float w) const override {
    if (kind_ <= 1) return art_->At(u, v, w);
    Vec3f color = panel_;
    color = Mix(color, bar_, Edge(v - 0.93f, 0.002f, w));
    color = Mix(color, Mix(panel_, bar_, 0.4f),
                Edge(0.2f - u, 0.002f, w) * (1 - Edge(v - 0.93f, 0.002f, w)));
    color = text_.Over(color, u, v, w);
    const float inside =
        Edge(std::min(std::min(u - 0.66f, 0.97f - u), std::min(v - 0.5f, 0.88f - v)), 0.002f, w);
    if (inside > 0)
      color = Mix(color,
                  art_->At(Saturate((u - 0.66f) / 0.31f), Saturate((v - 0.5f) / 0.38f), w / 0.31f),
                  inside);
    // Bars of a chart.
    if (u > 0.66f && u < 0.97f && v > 0.1f && v < 0.44f) {
      const float x = (u - 0.66f) / 0.31f * 8.0f;
      const float top = 0.12f + 0.3f * UnitByte(Hash(noise::FloorInt(x), seed()), 0);
      const float bar =
          Edge(0.35f - std::fabs(Fract(x) - 0.5f), 0.02f, 26.0f * w) * Edge(top - v, 0.002f, w);
      color = Mix(color, bar_, bar);
    }
    return color;
  }

  int kind_;
  std::unique_ptr<const Art> art_;
  Vec3f bar_, panel_;
  SmallPrint text_;
  float glow_;
};

}  // namespace

void AddPictureMaterials(MaterialList& list) {
  const MaterialTags print = {.diffuse = true, .any_object = false, .needs_uv = true};
  const auto painting = [&](const char* name, std::vector<ArtStyle> styles) {
    list.push_back(Entry<Painting>(name, "picture", print, styles));
  };
  painting("AbstractPainting",
           {ArtStyle::kFields, ArtStyle::kBlocks, ArtStyle::kModules, ArtStyle::kCircles,
            ArtStyle::kFluid, ArtStyle::kCells, ArtStyle::kWaves});
  painting("BotanicalPrint", {ArtStyle::kBotanical});
  painting("LandscapePainting", {ArtStyle::kLandscape, ArtStyle::kLandscape, ArtStyle::kCity});
  painting("PortraitPainting", {ArtStyle::kFigure});
  const MaterialTags gloss = {.any_object = false, .needs_uv = true};
  list.push_back(Entry<Cover>("BookCover", "picture", gloss, true));
  list.push_back(Entry<Cover>("Poster", "picture", gloss, false));
  list.push_back(Entry<PrintedPage>("PrintedPage", "picture", print));
  list.push_back(Entry<ProductLabel>("ProductLabel", "picture", gloss));
  list.push_back(Entry<ScreenPicture>("ScreenPicture", "picture", gloss));
}

}  // namespace parallax
