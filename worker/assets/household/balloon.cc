// Balloon: rubber ones on ribbons, or letters of foil.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <string_view>

#include "worker/assets/asset_families.h"
#include "worker/assets/parts.h"

namespace parallax {
namespace {

using namespace kernel;  // NOLINT: the modelling vocabulary of this folder.

// Strokes of a glyph in a 4 x 6 grid: what a foil letter balloon is made of. Points "xy" pairs,
// strokes split by space; a stroke that ends where it starts is a ring.
struct Glyph {
  char letter;
  std::string_view strokes;
};
constexpr Glyph kGlyphs[] = {{'0', "03 05 26 45 43 41 20 01 03"},
                             {'1', "05 26 20"},
                             {'2', "05 26 45 44 00 40"},
                             {'3', "05 26 45 44 23|23 42 41 20 01"},
                             {'4', "30 36 02 42"},
                             {'5', "46 06 03 33 42 41 20 01"},
                             {'7', "06 46 10"},
                             {'8', "23 04 05 26 45 44 23|23 42 41 20 01 02 23"},
                             {'C', "45 26 05 01 20 41"},
                             {'E', "46 06 00 40|03 33"},
                             {'H', "06 00|46 40|03 43"},
                             {'L', "06 00 40"},
                             {'M', "00 06 23 46 40"},
                             {'O', "03 05 26 45 43 41 20 01 03"},
                             {'S', "45 26 05 04 42 41 20 01"},
                             {'U', "06 02 20 42 46"},
                             {'V', "06 20 46"},
                             {'X', "06 40|46 00"},
                             {'Z', "06 46 00 40"}};

// A ribbon that curls as it hangs.
Shape CurlingRibbon(const Vec3f& from, float length, const Noise& noise) {
  Path3 path;
  for (int k = 0; k <= 40; ++k) {
    const float t = static_cast<float>(k) / 40.0f;
    const float sway = 0.12f * length * t;
    path.push_back(from + Vec3f(sway * noise.At({3 * t, 0.3f, 0}) + 0.012f * std::sin(19 * t) * t,
                                sway * noise.At({3 * t, 7.3f, 0}) + 0.012f * std::cos(19 * t) * t,
                                -length * t));
  }
  return Sweep(path, RectSection(0.006f, 0.0009f, 0.0003f, 1),
               {.twist_rad = [](float t) { return 9 * t; }});
}

// Half of a balloon of radius `r`, its neck down.
Path2 BalloonProfile(float r) {
  return Spline(Path2{{0.012f, -1.42f * r},
                      {0.02f, -1.4f * r},
                      {0.09f * r, -1.34f * r},
                      {0.12f * r, -1.27f * r},
                      {0.5f * r, -0.86f * r},
                      {0.88f * r, -0.3f * r},
                      {r, 0.2f * r},
                      {0.84f * r, 0.72f * r},
                      {0.45f * r, 1.02f * r},
                      {0.01f * r, 1.1f * r}},
                5);
}

// A bunch that a weight on the floor holds.
void AddRubberBalloons(AssetBuilder& b, int count, Rng& rng) {
  for (int i = 0; i < count; ++i) {
    const MaterialSlot rubber = Slot(fmt::format("rubber_{}", i + 1), {"plastic"});
    const float r = Draw(rng, 0.11, 0.15);
    const float a = 2.1f * static_cast<float>(i), lean = count > 1 ? 0.35f : 0.05f;
    const Vec3f knot(0.02f * std::cos(a), 0.02f * std::sin(a),
                     0.55f + 0.12f * static_cast<float>(i % 2));
    const Vec3f up = Vec3f(lean * std::cos(a), lean * std::sin(a), 1).normalized();
    b.Add(
        AlongZ(Lathe(BalloonProfile(r), {.segments = 48}).Moved(0, 0, 1.42f * r), knot, knot + up),
        rubber);
    b.Add(Ball(0.007f, 12).Moved(knot), rubber);
    b.Add(CurlingRibbon(knot, knot.z() - 0.004f, Noise(rng)),
          Slot("ribbon", {"fabric", "plastic"}));
  }
  b.Add(Lathe(Spline(
            Path2{{0.035f, 0}, {0.045f, 0.004f}, {0.04f, 0.02f}, {0.02f, 0.03f}, {0.001f, 0.032f}},
            4)),
        Slot("weight", {"metal", "plastic"}));
}

// Sizes of foil letters of that height, and the noise of their creases.
struct FoilFont {
  float height, unit, radius;
  const Noise& noise;
};

// A tube along a stroke; it puckers towards its seam, the outline.
Shape FoilStroke(Path3 stroke, const FoilFont& font) {
  const float h = font.height, r = font.radius;
  const bool ring = (stroke.front() - stroke.back()).norm() < 1e-6f;
  if (ring) stroke.pop_back();
  Path3 path = ring ? Spline(stroke, 7, true) : Filleted(stroke, 0.9f * font.unit, 6);
  path = Resampled(path, 0.25f * font.unit);
  SweepOptions options;
  options.keep_up = true;
  options.up = Vec3f::UnitY();
  options.closed = ring;
  options.end_round_m = ring ? 0.0f : 0.95f * r;
  if (ring && (path.front() - path.back()).norm() < 1e-5f) path.pop_back();
  return Sweep(path, EllipseSection(2 * r, 2 * r, 36), options).Bent([&](const Vec3f& q) {
    const float side = std::exp(-std::pow(q.y() / (0.45f * r), 2.0f));
    const float pucker =
        0.05f * r * side * std::sin(95 * (q.x() + q.z()) / h * 2 + 4 * font.noise.At(q * 9));
    return Vec3f(q.x() + pucker, q.y() * (0.86f + 0.03f * font.noise.At(q * 14)), q.z() + pucker);
  });
}

// Adds the strokes of a glyph whose left edge is at `x`.
void AddGlyph(AssetBuilder& b, std::string_view strokes, float x, const FoilFont& font) {
  Path3 stroke;
  const auto finish = [&] {
    if (stroke.size() < 2) return;
    b.Add(FoilStroke(stroke, font), Slot("foil", {"metal", "plastic"}));
    stroke.clear();
  };
  for (size_t k = 0; k < strokes.size();) {
    const char c = strokes[k];
    if (c == '|') {
      finish();
      ++k;
    } else if (c == ' ') {
      ++k;
    } else {
      stroke.emplace_back(x + font.unit * static_cast<float>(c - '0') * 0.95f, 0.0f,
                          font.unit * static_cast<float>(strokes[k + 1] - '0'));
      k += 2;
    }
  }
  finish();
}

// A few balloons.
struct BalloonParams {
  bool letters = false;  // Foil letters or numbers, else rubber ones on ribbons.
  int count = 2;
  float height_m = 0.45f;  // Height of a letter.
  uint64_t seed = 0;
};

void AddFoilLetters(AssetBuilder& b, const BalloonParams& p, const Noise& noise, Rng& rng) {
  const float h = p.height_m;
  const FoilFont font{h, h / 6, Draw(rng, 0.085, 0.105) * h, noise};
  float x = 0;
  for (int i = 0; i < p.count; ++i) {
    const Glyph& glyph = kGlyphs[rng.UniformInt(0, static_cast<int>(std::size(kGlyphs)) - 1)];
    AddGlyph(b, glyph.strokes, x, font);
    x -= 4 * font.unit * 0.95f + 3.1f * font.radius;
  }
}

Asset MakeBalloon(const BalloonParams& p) {
  AssetBuilder b(p.seed);
  Rng rng(SceneSeed{p.seed}, "balloon");
  const Noise noise(rng);
  if (!p.letters) {
    AddRubberBalloons(b, p.count, rng);
    return b.Finish();
  }
  AddFoilLetters(b, p, noise, rng);
  // Letters read from the front, which looks along -y: x runs to the reader's left.
  Asset asset = b.Finish();
  for (Vec3f& q : asset.mesh.positions) q.head<2>() = -q.head<2>();
  for (Vec3f& n : asset.mesh.normals) n.head<2>() = -n.head<2>();
  return asset;
}

}  // namespace

Asset SampleBalloon(Rng& rng) {
  BalloonParams p{.letters = rng.Bernoulli(0.5)};
  p.count = rng.UniformInt(1, p.letters ? 3 : 4);
  p.height_m = Draw(rng, 0.35, 0.6);
  p.seed = rng.Seed();
  return MakeBalloon(p);
}

}  // namespace parallax
