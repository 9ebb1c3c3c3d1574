// SimpleDesk: on legs, on drawer pedestals, with drawers under the top, on sawhorses.
#include <algorithm>
#include <cmath>

#include "worker/assets/tables.h"

namespace parallax {

using namespace kernel;  // NOLINT: the modelling vocabulary of this folder.

Asset MakeDesk(const DeskParams& p) {
  AssetBuilder b(p.seed);
  const MaterialSlot top = WoodSlot("top"), frame = WoodSlot("frame"), front = WoodSlot("fronts"),
                     metal = MetalSlot("handles");
  const float w = 0.5f * p.width_m, d = 0.5f * p.depth_m, t = 0.028f, under = p.height_m - t;
  b.Add(Board({-w, -d, under}, {w, d, p.height_m}, 0.004f), top);
  // A drawer whose box shows at its edges: front with handle in the plane y = front_y.
  const auto drawer = [&](float x, float z, float width, float height) {
    b.Add(Front(p.fronts, width, height, 0.018f, false).Moved(x, d - 0.04f, z), front);
    if (p.handles != HandleStyle::kNone) {
      b.Add(
          Handle(p.handles, std::min(0.13f, 0.5f * width)).Moved(x, d - 0.022f, z + 0.55f * height),
          metal);
    }
  };
  switch (p.style) {
    case DeskStyle::kPedestals: {
      const float cw = 0.4f;
      for (const float s : {-1.0f, 1.0f}) {
        const float x = s * (w - 0.5f * cw - 0.02f), s0 = x - 0.5f * cw, s1 = x + 0.5f * cw,
                    back = -d + 0.03f, f = d - 0.04f;
        b.Add(Board({s0, back, 0.06f}, {s0 + 0.018f, f, under}), frame);
        b.Add(Board({s1 - 0.018f, back, 0.06f}, {s1, f, under}), frame);
        b.Add(Board({s0, back, 0.06f}, {s1, f, 0.078f}), frame);
        b.Add(Board({s0, back, 0.06f}, {s1, back + 0.012f, under}), frame);
        b.Add(Board({s0 + 0.02f, back + 0.03f, 0.0f}, {s1 - 0.02f, f - 0.05f, 0.06f}), frame);
        const float room = under - 0.066f;
        const float heights[3] = {0.26f * room, 0.26f * room, 0.48f * room};
        float z = under - 0.004f;
        for (const float h : heights) {
          z -= h;
          drawer(x, z + 0.002f, cw - 0.006f, h - 0.004f);
        }
      }
      b.Add(Board({-w + 0.42f, -d + 0.03f, 0.28f}, {w - 0.42f, -d + 0.045f, under}), frame);
      break;
    }
    case DeskStyle::kSawhorse: {
      for (const float s : {-1.0f, 1.0f}) {
        const float x = s * (w - 0.22f);
        b.Add(
            Board({x - 0.025f, -d + 0.05f, under - 0.05f}, {x + 0.025f, d - 0.05f, under}, 0.004f),
            frame);
        for (const float y : {-d + 0.1f, d - 0.1f}) {
          for (const float o : {-1.0f, 1.0f}) {
            b.Add(Bar({x + o * 0.17f, y, 0}, {x + o * 0.022f, y, under - 0.01f}, {0.024f, 0.042f},
                      {0.024f, 0.042f}, 0.003f, Vec3f::UnitY()),
                  frame);
          }
          b.Add(Board({x - 0.12f, y - 0.009f, 0.22f}, {x + 0.12f, y + 0.009f, 0.26f}), frame);
        }
        for (const float o : {-1.0f, 1.0f})
          b.Add(Board({x + o * 0.127f - 0.009f, -d + 0.1f, 0.22f},
                      {x + o * 0.127f + 0.009f, d - 0.1f, 0.26f}),
                frame);
      }
      break;
    }
    default: {
      const float lx = w - 0.05f, ly = d - 0.05f,
                  apron = p.style == DeskStyle::kWriting ? 0.13f : 0.07f;
      b.AddFourfold(FurnitureLeg(p.legs == LegStyle::kTurned ? LegStyle::kTapered : p.legs,
                                 {lx, ly, 0}, {lx, ly, under}, 0.055f, 0),
                    frame);
      for (const float s : {-1.0f, 1.0f})
        b.Add(Board({s * lx - 0.01f, -ly, under - apron}, {s * lx + 0.01f, ly, under}), frame);
      b.Add(Board({-lx, -ly - 0.01f, under - apron}, {lx, -ly + 0.01f, under}), frame);
      if (p.style == DeskStyle::kWriting) {
        // A row of drawers under the top, behind which their floor closes the carcass.
        b.Add(Board({-lx, -ly, under - apron}, {lx, ly, under - apron + 0.012f}), frame);
        const int n = p.width_m > 1.25f ? 3 : 2;
        const float room = 2 * lx - 0.05f, each = room / static_cast<float>(n);
        for (int i = 0; i < n; ++i)
          drawer(-0.5f * room + each * (static_cast<float>(i) + 0.5f), under - apron + 0.002f,
                 each - 0.006f, apron - 0.006f);
      } else {
        b.Add(Board({-lx, ly - 0.01f, under - apron}, {lx, ly + 0.01f, under}), frame);
      }
    }
  }
  b.Support({-0.96f * w, -0.94f * d}, {0.96f * w, 0.94f * d}, p.height_m);
  return b.Finish();
}

Asset SampleSimpleDesk(Rng& rng) {
  DeskParams p;
  p.style = DrawEnum<DeskStyle>(rng, static_cast<int>(DeskStyle::kCount));
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
