// SimpleDesk: on legs, on drawer pedestals, with drawers under the top, on sawhorses.
#include <algorithm>
#include <cmath>

#include "worker/assets/asset_families.h"
#include "worker/assets/parts.h"

namespace parallax {
namespace {

using namespace kernel;  // NOLINT: the modelling vocabulary of this folder.

// Construction of a desk.
enum class DeskStyle { kLegs, kPedestals, kWriting, kSawhorse, kCount };

// A desk; its user sits at +y.
struct DeskParams {
  DeskStyle style = DeskStyle::kLegs;
  float width_m = 1.3f;
  float depth_m = 0.65f;
  float height_m = 0.74f;
  HandleStyle handles = HandleStyle::kBar;
  FrontStyle fronts = FrontStyle::kFlat;
  LegStyle legs = LegStyle::kTapered;
  uint64_t seed = 0;
};

// Dimensions and slots that the parts of a desk share: half width and depth, the top's underside.
struct Desk {
  explicit Desk(const DeskParams& params)
      : p(params),
        w(0.5f * params.width_m),
        d(0.5f * params.depth_m),
        under(params.height_m - 0.028f) {}
  const DeskParams& p;
  const float w, d, under;
  const MaterialSlot top = WoodSlot("top"), frame = WoodSlot("frame"), front = WoodSlot("fronts"),
                     metal = MetalSlot("handles");
};

// A drawer's front with its handle, its lower edge at (x, z).
void AddDeskDrawer(AssetBuilder& b, const Desk& k, float x, float z, float width, float height) {
  b.Add(Front(k.p.fronts, width, height, 0.018f, false).Moved(x, k.d - 0.04f, z), k.front);
  if (k.p.handles == HandleStyle::kNone) return;
  b.Add(
      Handle(k.p.handles, std::min(0.13f, 0.5f * width)).Moved(x, k.d - 0.022f, z + 0.55f * height),
      k.metal);
}

// A carcass with three drawers, its middle at `x`.
void AddDeskPedestal(AssetBuilder& b, const Desk& k, float x, float cw) {
  const float s0 = x - 0.5f * cw, s1 = x + 0.5f * cw, back = -k.d + 0.03f, f = k.d - 0.04f;
  b.Add(Board({s0, back, 0.06f}, {s0 + 0.018f, f, k.under}), k.frame);
  b.Add(Board({s1 - 0.018f, back, 0.06f}, {s1, f, k.under}), k.frame);
  b.Add(Board({s0, back, 0.06f}, {s1, f, 0.078f}), k.frame);
  b.Add(Board({s0, back, 0.06f}, {s1, back + 0.012f, k.under}), k.frame);
  b.Add(Board({s0 + 0.02f, back + 0.03f, 0.0f}, {s1 - 0.02f, f - 0.05f, 0.06f}), k.frame);
  const float room = k.under - 0.066f;
  const float heights[3] = {0.26f * room, 0.26f * room, 0.48f * room};
  float z = k.under - 0.004f;
  for (const float h : heights) {
    z -= h;
    AddDeskDrawer(b, k, x, z + 0.002f, cw - 0.006f, h - 0.004f);
  }
}

void AddDeskPedestals(AssetBuilder& b, const Desk& k) {
  const float cw = 0.4f;
  for (const float s : {-1.0f, 1.0f}) AddDeskPedestal(b, k, s * (k.w - 0.5f * cw - 0.02f), cw);
  b.Add(Board({-k.w + 0.42f, -k.d + 0.03f, 0.28f}, {k.w - 0.42f, -k.d + 0.045f, k.under}), k.frame);
}

// Two trestles of four legs each.
void AddSawhorses(AssetBuilder& b, const Desk& k) {
  const float d = k.d, under = k.under;
  for (const float s : {-1.0f, 1.0f}) {
    const float x = s * (k.w - 0.22f);
    b.Add(Board({x - 0.025f, -d + 0.05f, under - 0.05f}, {x + 0.025f, d - 0.05f, under}, 0.004f),
          k.frame);
    for (const float y : {-d + 0.1f, d - 0.1f}) {
      for (const float o : {-1.0f, 1.0f}) {
        b.Add(Bar({x + o * 0.17f, y, 0}, {x + o * 0.022f, y, under - 0.01f}, {0.024f, 0.042f},
                  {0.024f, 0.042f}, 0.003f, Vec3f::UnitY()),
              k.frame);
      }
      b.Add(Board({x - 0.12f, y - 0.009f, 0.22f}, {x + 0.12f, y + 0.009f, 0.26f}), k.frame);
    }
    for (const float o : {-1.0f, 1.0f})
      b.Add(Board({x + o * 0.127f - 0.009f, -d + 0.1f, 0.22f},
                  {x + o * 0.127f + 0.009f, d - 0.1f, 0.26f}),
            k.frame);
  }
}

// A row of drawers under the top, behind which their floor closes the carcass.
void AddDrawerRow(AssetBuilder& b, const Desk& k, float lx, float ly, float apron) {
  b.Add(Board({-lx, -ly, k.under - apron}, {lx, ly, k.under - apron + 0.012f}), k.frame);
  const int n = k.p.width_m > 1.25f ? 3 : 2;
  const float room = 2 * lx - 0.05f, each = room / static_cast<float>(n);
  for (int i = 0; i < n; ++i)
    AddDeskDrawer(b, k, -0.5f * room + each * (static_cast<float>(i) + 0.5f),
                  k.under - apron + 0.002f, each - 0.006f, apron - 0.006f);
}

// Four legs and aprons; a writing desk has drawers in front.
void AddDeskLegs(AssetBuilder& b, const Desk& k) {
  const bool writing = k.p.style == DeskStyle::kWriting;
  const float lx = k.w - 0.05f, ly = k.d - 0.05f, apron = writing ? 0.13f : 0.07f, under = k.under;
  b.AddFourfold(FurnitureLeg(k.p.legs == LegStyle::kTurned ? LegStyle::kTapered : k.p.legs,
                             {lx, ly, 0}, {lx, ly, under}, 0.055f, 0),
                k.frame);
  for (const float s : {-1.0f, 1.0f})
    b.Add(Board({s * lx - 0.01f, -ly, under - apron}, {s * lx + 0.01f, ly, under}), k.frame);
  b.Add(Board({-lx, -ly - 0.01f, under - apron}, {lx, -ly + 0.01f, under}), k.frame);
  if (writing) {
    AddDrawerRow(b, k, lx, ly, apron);
  } else {
    b.Add(Board({-lx, ly - 0.01f, under - apron}, {lx, ly + 0.01f, under}), k.frame);
  }
}

Asset MakeDesk(const DeskParams& p) {
  AssetBuilder b(p.seed);
  const Desk desk(p);
  const float w = desk.w, d = desk.d;
  b.Add(Board({-w, -d, desk.under}, {w, d, p.height_m}, 0.004f), desk.top);
  switch (p.style) {
    case DeskStyle::kPedestals:
      AddDeskPedestals(b, desk);
      break;
    case DeskStyle::kSawhorse:
      AddSawhorses(b, desk);
      break;
    default:
      AddDeskLegs(b, desk);
  }
  b.Support({-0.96f * w, -0.94f * d}, {0.96f * w, 0.94f * d}, p.height_m);
  return b.Finish();
}

}  // namespace

Asset SampleSimpleDesk(Rng& rng) {
  DeskParams p{.style = DrawEnum<DeskStyle>(rng, static_cast<int>(DeskStyle::kCount))};
  p.width_m = p.style == DeskStyle::kPedestals ? Draw(rng, 1.4, 1.7) : Draw(rng, 1.0, 1.6);
  p.depth_m = Draw(rng, 0.55, 0.78);
  p.height_m = Draw(rng, 0.72, 0.77);
  p.handles = DrawEnum<HandleStyle>(rng, static_cast<int>(HandleStyle::kCount));
  p.fronts = DrawEnum<FrontStyle>(rng, static_cast<int>(FrontStyle::kCount));
  p.legs = DrawEnum<LegStyle>(rng, static_cast<int>(LegStyle::kCount));
  p.seed = rng.Seed();
  return MakeDesk(p);
}

}  // namespace parallax
