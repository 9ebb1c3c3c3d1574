// Headboards of beds: panels, slats, an arch, a hoop of tube, upholstery.
#include <algorithm>
#include <cmath>

#include "worker/assets/furniture/bed_parts.h"

namespace parallax {
namespace {

using namespace kernel;  // NOLINT: the modelling vocabulary of this folder.

constexpr float kBoardFoot = 0.18f;  // Height of a headboard's lower edge.

// Dimensions and slots that the parts of a headboard share.
struct Headboard {
  Headboard(const BedParams& params, const BedLayout& layout)
      : p(params), w(layout.x + 0.03f), y(layout.head - 0.05f), top(params.headboard_m) {}
  const BedParams& p;
  const float w, y, top;  // Half its width, its back, its upper edge.
  const MaterialSlot wood = WoodSlot("frame"), cloth = FabricSlot("headboard");
};

void AddPosts(AssetBuilder& b, const Headboard& h, float height, float size) {
  b.AddMirroredX(Board({h.w - size, h.y, 0}, {h.w, h.y + size, height}, 0.005f), h.wood);
}

void AddPanels(AssetBuilder& b, const Headboard& h) {
  const float w = h.w, y = h.y, top = h.top, low = kBoardFoot;
  AddPosts(b, h, top, 0.06f);
  b.Add(Board({-w - 0.015f, y - 0.01f, top}, {w + 0.015f, y + 0.07f, top + 0.028f}, 0.008f),
        h.wood);
  const int panels = 3;
  const float each = (2 * w - 0.12f) / panels;
  for (int i = 0; i < panels; ++i) {
    b.Add(Front(FrontStyle::kRaised, each - 0.001f, top - low, 0.03f, true)
              .Moved(-w + 0.06f + each * (static_cast<float>(i) + 0.5f), y + 0.015f, low),
          h.wood);
  }
}

void AddUprightSlats(AssetBuilder& b, const Headboard& h) {
  const float w = h.w, y = h.y, top = h.top, low = kBoardFoot;
  AddPosts(b, h, top, 0.055f);
  b.Add(
      Board({-w + 0.055f, y + 0.012f, top - 0.09f}, {w - 0.055f, y + 0.042f, top - 0.01f}, 0.004f),
      h.wood);
  b.Add(Board({-w + 0.055f, y + 0.012f, low}, {w - 0.055f, y + 0.042f, low + 0.09f}, 0.004f),
        h.wood);
  const int n = static_cast<int>(2 * w / 0.12f);
  for (int i = 0; i < n; ++i) {
    const float at =
        (2 * w - 0.11f) * ((static_cast<float>(i) + 0.5f) / static_cast<float>(n) - 0.5f);
    b.Add(Board({at - 0.024f, y + 0.02f, low + 0.08f}, {at + 0.024f, y + 0.034f, top - 0.08f},
                0.003f),
          h.wood);
  }
}

// A board with an arched upper edge between posts with finials.
void AddArch(AssetBuilder& b, const Headboard& h) {
  const float w = h.w, y = h.y, top = h.top, low = kBoardFoot;
  AddPosts(b, h, top - 0.15f, 0.06f);
  Path2 outline{{-w + 0.05f, low}, {w - 0.05f, low}, {w - 0.05f, top - 0.2f}};
  for (int i = 0; i <= 24; ++i) {
    const float s = 1 - 2 * static_cast<float>(i) / 24.0f;
    outline.emplace_back(
        (w - 0.05f) * s,
        top - 0.18f + 0.18f * std::cos(0.5f * kPi * s) * (1 + 0.12f * std::cos(3 * kPi * s)));
  }
  outline.emplace_back(-w + 0.05f, top - 0.2f);
  b.Add(Extrude(outline, 0.028f, 0.006f).Bent([&](const Vec3f& q) {
    return Vec3f(-q.x(), y + 0.012f + q.z(), q.y());
  }),
        h.wood);
  b.AddMirroredX(Lathe(Spline(Path2{{0.022f, 0},
                                    {0.03f, 0.012f},
                                    {0.018f, 0.03f},
                                    {0.034f, 0.06f},
                                    {0.026f, 0.088f},
                                    {0.004f, 0.1f}},
                              4))
                     .Moved(w - 0.03f, y + 0.03f, top - 0.151f),
                 h.wood);
}

// A hoop of tube with rods in it, every second up to the top and with a ball.
void AddHoop(AssetBuilder& b, const Headboard& h) {
  const MaterialSlot metal = MetalSlot("frame_metal");
  const float w = h.w, y = h.y, top = h.top, r = 0.016f;
  const Path3 hoop = Filleted(
      Path3{{-w, y + 0.03f, 0}, {-w, y + 0.03f, top}, {w, y + 0.03f, top}, {w, y + 0.03f, 0}},
      0.14f, 8);
  b.Add(Tube(hoop, r, 0.003f, 16), metal);
  b.Add(Tube({{-w, y + 0.03f, 0.42f}, {w, y + 0.03f, 0.42f}}, 0.011f), metal);
  b.Add(Tube({{-w, y + 0.03f, top - 0.14f}, {w, y + 0.03f, top - 0.14f}}, 0.011f), metal);
  const int n = static_cast<int>(2 * w / 0.13f);
  for (int i = 1; i < n; ++i) {
    const float at = 2 * w * static_cast<float>(i) / static_cast<float>(n) - w;
    b.Add(Tube({{at, y + 0.03f, 0.42f}, {at, y + 0.03f, i % 2 ? top : top - 0.14f}}, 0.006f, 0, 10),
          metal);
    if (i % 2) b.Add(Ball(0.014f, 14).Moved(at, y + 0.03f, 0.5f * (top + 0.28f)), metal);
  }
}

CushionOptions HeadboardUpholstery() {
  CushionOptions o;
  o.edge_radius_m = 0.03f;
  o.bulge_top_m = 0.012f;
  o.bulge_side_m = 0.0f;
  o.wrinkle_m = 0.0012f;
  o.target_edge_m = 0.03f;
  return o;
}

// One deep-buttoned cushion.
void AddTuftedCushion(AssetBuilder& b, const Headboard& h) {
  const float w = h.w, y = h.y, low = kBoardFoot, height = h.top - low;
  CushionOptions o = HeadboardUpholstery();
  o.tufts_x = std::max(4, static_cast<int>(2 * w / 0.17f));
  o.tufts_y = std::max(3, static_cast<int>(height / 0.17f));
  o.tuft_depth_m = 0.03f;
  b.Add(Cushion({2 * w, height, 0.09f}, o, Noise(h.p.seed))
            .TurnedX(-0.5f * kPi)
            .Moved(0, y + 0.02f, low + 0.5f * height),
        h.cloth);
  for (int i = 0; i < o.tufts_x; ++i) {
    for (int j = 0; j < o.tufts_y; ++j) {
      const float x =
          2 * w * ((static_cast<float>(i) + 0.5f) / static_cast<float>(o.tufts_x) - 0.5f);
      const float z = low + height * (static_cast<float>(j) + 0.5f) / static_cast<float>(o.tufts_y);
      b.Add(Ellipsoid({0.01f, 0.006f, 0.01f}, 8).Moved(x, y + 0.054f, z), h.cloth);
    }
  }
}

// Cushions side by side.
void AddPaddedPanels(AssetBuilder& b, const Headboard& h) {
  const float w = h.w, low = kBoardFoot, height = h.top - low;
  const int panels = std::max(2, static_cast<int>(std::lround(w / 0.3f)));
  const float each = 2 * w / static_cast<float>(panels);
  for (int i = 0; i < panels; ++i) {
    b.Add(Cushion({each - 0.002f, height, 0.085f}, HeadboardUpholstery(),
                  Noise(h.p.seed + static_cast<uint64_t>(i)))
              .TurnedX(-0.5f * kPi)
              .Moved(-w + each * (static_cast<float>(i) + 0.5f), h.y + 0.015f, low + 0.5f * height),
          h.cloth);
  }
}

void AddUpholstery(AssetBuilder& b, const Headboard& h) {
  const float w = h.w, y = h.y;
  h.p.headboard == HeadboardStyle::kTufted ? AddTuftedCushion(b, h) : AddPaddedPanels(b, h);
  b.AddMirroredX(
      Board({w - 0.1f, y - 0.025f, 0}, {w - 0.04f, y + 0.03f, kBoardFoot + 0.05f}, 0.004f), h.wood);
}

}  // namespace

void AddHeadboard(AssetBuilder& b, const BedParams& p, const BedLayout& layout) {
  const Headboard board(p, layout);
  switch (p.headboard) {
    case HeadboardStyle::kPanel:
      return AddPanels(b, board);
    case HeadboardStyle::kSlats:
      return AddUprightSlats(b, board);
    case HeadboardStyle::kArched:
      return AddArch(b, board);
    case HeadboardStyle::kMetal:
      return AddHoop(b, board);
    case HeadboardStyle::kUpholstered:
    case HeadboardStyle::kTufted:
      return AddUpholstery(b, board);
    default:
      return;
  }
}

}  // namespace parallax
