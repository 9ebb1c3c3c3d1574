// TV, Monitor: a panel with a picture, on one of four stands.
#include <algorithm>
#include <cmath>

#include "worker/assets/asset_families.h"
#include "worker/assets/parts.h"

namespace parallax {
namespace {

using namespace kernel;  // NOLINT: the modelling vocabulary of this folder.

constexpr float kGlassFront = 0.012f;  // y of the bezel's front.

// A television or monitor.
struct ScreenParams {
  float diagonal_m = 1.2f;
  float aspect = 16.0f / 9;
  float bezel_m = 0.012f;
  int stand = 0;         // 0 neck and foot, 1 two feet, 2 arm on a foot, 3 slab.
  float lift_m = 0.08f;  // Lower edge above what it stands on.
  uint64_t seed = 0;
};

// Dimensions and slots that the parts of a screen share: height and width of the picture; bezel
// and chin; thickness of the panel and of the bump behind it; lower edge and middle height.
struct Screen {
  explicit Screen(const ScreenParams& params)
      : h(params.diagonal_m / std::sqrt(1 + params.aspect * params.aspect)),
        w(h * params.aspect),
        bezel(params.bezel_m),
        chin(1.6f * bezel),
        thin(std::min(0.035f, 0.01f + 0.016f * params.diagonal_m)),
        bump(0.022f + 0.012f * params.diagonal_m),
        low(params.lift_m),
        mid(low + chin + 0.5f * h) {}
  const float h, w, bezel, chin, thin, bump, low, mid;
  const MaterialSlot body = Slot("body", {"HousingPlastic", "BrushedMetal"}),
                     stand = Slot("stand", {"BrushedMetal", "HousingPlastic"});
};

// The glass, and a bezel round it that stands proud by a millimetre and a half.
void AddScreenPanel(AssetBuilder& b, const Screen& s) {
  const float w = s.w, thin = s.thin, bz = s.bezel, front = kGlassFront;
  const float x = 0.5f * w + bz, z0 = s.low, z1 = s.low + s.chin + s.h + bz;
  b.AddMirroredX(Board({0.5f * w, -0.5f * thin, z0}, {x, front, z1}, 0.0025f), s.body);
  b.Add(Board({-0.5f * w, -0.5f * thin, z0}, {0.5f * w, front, z0 + s.chin}, 0.0025f), s.body);
  b.Add(Board({-0.5f * w, -0.5f * thin, z1 - bz}, {0.5f * w, front, z1}, 0.0025f), s.body);
  Shape glass = Board({-0.5f * w - 0.0005f, -0.5f * thin + 0.001f, z0 + s.chin - 0.0005f},
                      {0.5f * w + 0.0005f, front - 0.0015f, z1 - bz + 0.0005f}, 0);
  PrintFaces(glass, Vec3f::UnitY(), -Vec3f::UnitX(), Vec3f::UnitZ(), 1);
  b.Add(glass, {s.body, PictureSlot("screen")});
}

// The back swells where the electronics are; a badge in front, vents behind.
void AddScreenHousing(AssetBuilder& b, const Screen& s) {
  const float w = s.w, h = s.h, thin = s.thin, bump = s.bump, mid = s.mid;
  b.Add(RoundedBox({0.7f * w, bump + 0.01f, 0.55f * h}, {.bevel_m = 0.012f, .bevel_steps = 2})
            .Moved(0, -0.5f * thin - 0.5f * bump + 0.006f, mid - 0.12f * h),
        s.body);
  b.Add(Board({-0.012f, kGlassFront - 0.001f, s.low + 0.4f * s.chin},
              {0.012f, kGlassFront + 0.0006f, s.low + 0.6f * s.chin}, 0.0002f),
        Slot("badge", {"metal"}));
  for (int i = 0; i < 9; ++i) {
    const float at = -0.2f * w + 0.05f * w * static_cast<float>(i);
    b.Add(Board({at, -0.5f * thin - bump + 0.002f, mid + 0.02f * h},
                {at + 0.02f * w, -0.5f * thin - bump - 0.0005f, mid + 0.035f * h}, 0.0005f),
          s.stand);
  }
}

// Two V feet.
void AddVFeet(AssetBuilder& b, const Screen& s) {
  for (const float side : {-1.0f, 1.0f}) {
    const float fx = side * 0.36f * s.w;
    for (const float y : {-1.0f, 1.0f}) {
      b.Add(Bar({fx + side * 0.02f, y * 0.13f, 0.004f}, {fx, y * 0.006f, s.low + 0.008f},
                {0.02f, 0.008f}, {0.02f, 0.012f}, 0.002f, Vec3f::UnitX()),
            s.stand);
    }
  }
}

// Foot plate, post behind, arm.
void AddScreenPost(AssetBuilder& b, const Screen& s) {
  const float mid = s.mid;
  b.Add(Extrude(RectSection(0.3f * s.w + 0.08f, 0.2f, 0.03f, 6), 0.01f, 0.003f).Moved(0, -0.04f, 0),
        s.stand);
  b.Add(Board({-0.025f, -0.13f, 0.005f}, {0.025f, -0.11f, mid}, 0.005f), s.stand);
  b.Add(Board({-0.04f, -0.12f, mid - 0.06f}, {0.04f, -0.5f * s.thin - s.bump + 0.01f, mid + 0.01f},
              0.004f),
        s.stand);
}

// Slab neck on a wide plate.
void AddSlabNeck(AssetBuilder& b, const Screen& s) {
  const float w = s.w;
  b.Add(Extrude(RectSection(0.45f * w, 0.24f, 0.012f, 4), 0.008f, 0.0025f).Moved(0, -0.01f, 0),
        s.stand);
  b.Add(Bar({0, -0.05f, 0.004f}, {0, -0.5f * s.thin - 0.01f, s.low + 0.25f * s.h},
            {0.2f * w, 0.016f}, {0.16f * w, 0.014f}, 0.004f, Vec3f::UnitY()),
        s.stand);
}

// Round neck on an oval foot.
void AddRoundNeck(AssetBuilder& b, const Screen& s) {
  const float w = s.w, h = s.h, thin = s.thin, low = s.low;
  b.Add(Extrude(EllipseSection(0.42f * w + 0.06f, 0.22f, 56), 0.012f, 0.004f).Moved(0, -0.02f, 0),
        s.stand);
  b.Add(Rod({0, -0.045f, 0.008f}, {0, -0.5f * thin - 0.012f, low + 0.12f * h}, 0.022f, 0.018f,
            0.003f),
        s.stand);
  b.Add(Board({-0.07f * w, -0.5f * thin - 0.028f, low + 0.02f * h},
              {0.07f * w, -0.5f * thin + 0.002f, low + 0.16f * h}, 0.006f),
        s.stand);
}

void AddScreenStand(AssetBuilder& b, const Screen& s, int stand) {
  switch (stand) {
    case 1:
      return AddVFeet(b, s);
    case 2:
      return AddScreenPost(b, s);
    case 3:
      return AddSlabNeck(b, s);
    default:
      return AddRoundNeck(b, s);
  }
}

Asset MakeScreen(const ScreenParams& p) {
  AssetBuilder b(p.seed);
  const Screen screen(p);
  AddScreenPanel(b, screen);
  AddScreenHousing(b, screen);
  AddScreenStand(b, screen, p.stand);
  return b.Finish();
}

}  // namespace

Asset SampleTv(Rng& rng) {
  ScreenParams p{.diagonal_m = 0.0254f * Draw(rng, 32, 65), .bezel_m = Draw(rng, 0.007, 0.02)};
  const int stands[] = {0, 1, 3};
  p.stand = stands[rng.UniformInt(0, 2)];
  p.lift_m = Draw(rng, 0.05, 0.09);
  p.seed = rng.Seed();
  return MakeScreen(p);
}

Asset SampleMonitor(Rng& rng) {
  ScreenParams p{.diagonal_m = 0.0254f * Draw(rng, 20, 32)};
  const float aspects[] = {16.0f / 9, 16.0f / 10, 21.0f / 9};
  p.aspect = aspects[rng.UniformInt(0, 2)];
  p.bezel_m = Draw(rng, 0.006, 0.018);
  const int stands[] = {0, 2, 3};
  p.stand = stands[rng.UniformInt(0, 2)];
  p.lift_m = Draw(rng, 0.09, 0.16);
  p.seed = rng.Seed();
  return MakeScreen(p);
}

}  // namespace parallax
