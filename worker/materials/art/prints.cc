// Family `picture`: what has lettering: book covers, posters, labels, pages.
#include <array>

#include "worker/materials/art/printed.h"

namespace parallax {
namespace {

using namespace noise;  // NOLINT: the vocabulary of patterns.

// Posters and book covers: a ground, a picture in a window, a title, small print.
class Cover final : public Printed {
 public:
  Cover(Rng& rng, bool book)
      : Printed(rng, rng.Bernoulli(0.6) ? PictureGround::kCoated : PictureGround::kPaper) {
    const Inks inks = DrawColors(rng);
    layout_ = rng.UniformInt(0, 3);
    art_ = DrawAnyArt(rng);
    window_ = DrawWindow(rng);
    frame_ = rng.Bernoulli(0.35) ? Draw(rng, 0.02, 0.05) : 0.0f;
    band_color_ = inks.accent;
    AddTitle(rng, inks);
    AddAuthor(rng, inks.text, book);
    print_ = {0.1f,
              book ? 0.12f : 0.03f,
              rng.Bernoulli(0.5) ? 0.9f : 0.5f,
              book ? 0.2f : 0.13f,
              Draw(rng, 0.014, 0.024),
              inks.text,
              DrawSeed(rng)};
    small_print_ = layout_ == kFramed || layout_ == kTypeOver || !book;
    MeasureMean();
  }

 private:
  enum Layout { kBelowTitle, kFramed, kAboveTitle, kTypeOver };
  struct Inks {
    Vec3f text, accent;
  };

  // Draws the ground, and the inks on it.
  Inks DrawColors(Rng& rng) {
    const std::array<Vec3f, 5> palette = DrawPalette(rng);
    const bool dark = rng.Bernoulli(0.5);
    ground_ = dark ? palette[static_cast<size_t>(rng.UniformInt(0, 1))]
                   : palette[static_cast<size_t>(rng.UniformInt(2, 4))];
    const Vec3f text = Luminance(ground_) < 0.2f ? palette[4] : palette[0];
    const size_t first = static_cast<size_t>(rng.UniformInt(1, 3));
    const bool contrasts = (palette[first] - ground_).norm() > 0.08f;
    return {text, palette[contrasts ? first : first % 3 + 1]};
  }

  // The picture's place; none where type covers it.
  std::array<float, 4> DrawWindow(Rng& rng) const {
    switch (layout_) {
      case kBelowTitle:
        return {0, 0, 1, Draw(rng, 0.5, 0.66)};
      case kFramed:
        return {0.12f, 0.24f, 0.88f, Draw(rng, 0.6, 0.7)};
      case kAboveTitle:
        return {0, Draw(rng, 0.26, 0.4), 1, 1};
      default:
        return {0, 0, 0, 0};
    }
  }

  void AddTitle(Rng& rng, const Inks& inks) {
    const bool title_low = layout_ == kAboveTitle;
    const int lines = layout_ == kTypeOver ? rng.UniformInt(2, 4) : rng.UniformInt(1, 2);
    const float low = layout_ == kTypeOver ? 0.42f
                      : title_low          ? 0.10f
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
      line.color = rng.Bernoulli(0.7) ? inks.text : inks.accent;
      letters_.push_back(line);
    }
  }

  void AddAuthor(Rng& rng, const Vec3f& ink, bool book) {
    Lettering author;
    author.text = DrawWord(rng, 2) + " ";
    author.text += DrawWord(rng, 2);
    author.height = Draw(rng, 0.025, 0.04);
    author.width = 0.5f;
    author.u = 0.25f;
    author.v = book ? 0.05f : 0.16f;
    author.color = layout_ == kBelowTitle ? Vec3f::Constant(0.78f) : ink;
    letters_.push_back(author);
  }

  Vec3f Ink(float u, float v, float w) const override {
    Vec3f color = ground_;
    if (layout_ == kTypeOver) {
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
  explicit ProductLabel(Rng& rng) : Printed(rng, PictureGround::kCoated) {
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
    DrawBrand(rng);
    DrawKind(rng);
    print_ = {0.06f, 0.02f, 0.6f, band_low_ - 0.01f, 0.017f, kind_.color, DrawSeed(rng)};
    MeasureMean();
  }

 private:
  void DrawBrand(Rng& rng) {
    brand_.text = DrawWord(rng, rng.UniformInt(2, 3));
    brand_.height = Draw(rng, 0.09, 0.14);
    brand_.width = std::min(0.68f, 0.11f * Float(static_cast<double>(brand_.text.size())));
    brand_.u = 0.5f - 0.5f * brand_.width;
    brand_.v = badge_v_ - 0.5f * brand_.height;
    brand_.stroke = Draw(rng, 0.5, 0.85);
    brand_.color = Luminance(badge_) > 0.3f ? Vec3f(palette_[1] * 0.8f) : palette_[4];
  }
  void DrawKind(Rng& rng) {
    kind_.text = DrawWord(rng, 1) + " ";
    kind_.text += DrawWord(rng, 2);
    kind_.height = 0.045f;
    kind_.width = 0.5f;
    kind_.u = 0.25f;
    kind_.v = badge_v_ - 0.24f;
    kind_.stroke = 0.45f;
    kind_.color = Luminance(ground_) > 0.25f ? palette_[0] : palette_[4];
  }

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
  explicit PrintedPage(Rng& rng) : Printed(rng, PictureGround::kPaper) {
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

}  // namespace

void AddPrintMaterials(MaterialList& list) {
  const MaterialTags print = {.diffuse = true, .any_object = false, .needs_uv = true};
  const MaterialTags gloss = {.any_object = false, .needs_uv = true};
  list.push_back(Entry<Cover>("BookCover", "picture", gloss, true));
  list.push_back(Entry<Cover>("Poster", "picture", gloss, false));
  list.push_back(Entry<PrintedPage>("PrintedPage", "picture", print));
  list.push_back(Entry<ProductLabel>("ProductLabel", "picture", gloss));
}

}  // namespace parallax
