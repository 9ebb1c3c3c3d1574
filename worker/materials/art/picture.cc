// Family `picture`: what is printed or painted over uv in [0, 1]^2: paintings and screens;
// prints.cc has what has lettering.
#include <array>

#include "worker/materials/art/printed.h"

namespace parallax {
namespace {

using namespace noise;  // NOLINT: the vocabulary of patterns.

class Painting final : public Printed {
 public:
  Painting(Rng& rng, std::vector<ArtStyle> styles)
      : Printed(rng, rng.Bernoulli(0.7) ? PictureGround::kCanvas : PictureGround::kPaper),
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

// A television, monitor or phone: off, a film, or windows with text and a chart. Glossy glass over
// faint light.
class ScreenPicture final : public Printed {
 public:
  explicit ScreenPicture(Rng& rng) : Printed(rng, PictureGround::kCoated) {
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
  list.push_back(Entry<ScreenPicture>("ScreenPicture", "picture", gloss));
}

}  // namespace parallax
