#include <algorithm>
#include <cmath>

#include "worker/assets/asset_families.h"
#include "worker/assets/parts.h"

namespace parallax {
namespace {

using namespace kernel;  // NOLINT: the modelling vocabulary of this folder.

// Cell edges between `from` and `to`: equal but for a drawn unevenness.
std::vector<float> Divide(float from, float to, int count, float unevenness, Rng& rng) {
  std::vector<float> weight;
  float sum = 0;
  for (int i = 0; i < count; ++i) {
    weight.push_back(1 + Draw(rng, -unevenness, unevenness));
    sum += weight.back();
  }
  std::vector<float> out{from};
  for (int i = 0; i < count; ++i) out.push_back(out.back() + (to - from) * weight[i] / sum);
  return out;
}

// An upright carcass of boards with columns and rows of cells.
struct ShelfParams {
  float width_m = 0.8f;
  float depth_m = 0.3f;
  float height_m = 1.8f;
  float board_m = 0.02f;
  int columns = 1;
  int rows = 5;
  float plinth_m = 0.06f;  // Height of the recessed base; 0 with legs.
  float leg_m = 0.0f;      // Height of legs instead of a plinth.
  LegStyle legs = LegStyle::kTapered;
  bool back = true;
  bool cornice = false;      // A moulding on top and a face frame.
  float unevenness = 0.15f;  // How much the rows' heights differ.
  int drawers_low = 0;       // The lowest rows closed by drawers...
  int doors_low = 0;         // ...or by doors.
  FrontStyle fronts = FrontStyle::kFlat;
  HandleStyle handles = HandleStyle::kKnob;
  uint64_t seed = 0;
};

// Dimensions and slots that the parts of a shelf share: half width and depth, board, the sides'
// lower edge, the lowest board's, the top.
struct Shelf {
  explicit Shelf(const ShelfParams& params)
      : p(params),
        w(0.5f * params.width_m),
        d(0.5f * params.depth_m),
        t(params.board_m),
        low(params.leg_m > 0 ? params.leg_m : 0.0f),
        floor(params.leg_m > 0 ? params.leg_m : params.plinth_m),
        top(params.height_m) {}
  const ShelfParams& p;
  const float w, d, t, low, floor, top;
  const MaterialSlot wood = WoodSlot("carcass"), fronts = WoodSlot("fronts"),
                     metal = MetalSlot("handles");
};

// Sides run past the boards; the top lies between them, or over them under a cornice.
void AddCarcass(AssetBuilder& b, const Shelf& s) {
  const float w = s.w, d = s.d, t = s.t, floor = s.floor, top = s.top;
  const float cover = s.p.cornice ? 0.0f : 0.0006f;
  b.AddMirroredX(Board({w - t, -d, s.low}, {w, d, top - cover}, 0.002f), s.wood);
  b.Add(Board({-w + t, -d + 0.006f, top - t}, {w - t, d - 0.001f, top}, 0.002f), s.wood);
  b.Add(Board({-w + t, -d + 0.006f, floor}, {w - t, d - 0.001f, floor + t}, 0.002f), s.wood);
  if (s.p.plinth_m > 0 && s.p.leg_m <= 0)
    b.Add(Board({-w + t, d - 0.03f, 0}, {w - t, d - 0.015f, floor}, 0.001f), s.wood);
  if (s.p.back)
    b.Add(Board({-w + 0.003f, -d, s.low + 0.01f}, {w - 0.003f, -d + 0.006f, top - 0.003f}, 0.0005f),
          Slot("back", {"wood", "paint"}));
}

void AddShelfLegs(AssetBuilder& b, const Shelf& s) {
  const float w = s.w, d = s.d, leg_m = s.p.leg_m;
  const float splay =
      s.p.legs == LegStyle::kRound || s.p.legs == LegStyle::kTapered ? 0.1f * leg_m : 0.0f;
  b.AddFourfold(FurnitureLeg(s.p.legs, {w - 0.06f + splay, d - 0.06f + splay, 0},
                             {w - 0.06f, d - 0.06f, leg_m + 0.004f}, 0.042f, 1),
                WoodSlot("legs"));
}

// Upright boards between columns, whose middles are `xs`.
void AddDividers(AssetBuilder& b, const Shelf& s, const std::vector<float>& xs) {
  for (int c = 1; c < s.p.columns; ++c) {
    b.Add(Board({xs[c] - 0.5f * s.t, -s.d + 0.006f, s.floor + s.t},
                {xs[c] + 0.5f * s.t, s.d - 0.003f, s.top - s.t}, 0.0015f),
          s.wood);
  }
}

// A compartment: its inside between boards.
struct ShelfCell {
  float x0, x1, z0, z1;
  int column;
};
constexpr float kFrontGap = 0.002f;  // Round drawers and doors.

void AddDrawer(AssetBuilder& b, const Shelf& s, const ShelfCell& cell) {
  const float width = cell.x1 - cell.x0 - 2 * kFrontGap, height = cell.z1 - cell.z0 - 2 * kFrontGap,
              mid = 0.5f * (cell.x0 + cell.x1);
  b.Add(
      Front(s.p.fronts, width, height, 0.017f, false).Moved(mid, s.d - 0.022f, cell.z0 + kFrontGap),
      s.fronts);
  if (s.p.handles == HandleStyle::kNone) return;
  b.Add(Handle(s.p.handles, std::min(0.13f, 0.4f * width))
            .Moved(mid, s.d - 0.005f, cell.z0 + 0.55f * height),
        s.metal);
}

// One leaf, or two before a wide compartment.
void AddDoors(AssetBuilder& b, const Shelf& s, const ShelfCell& cell) {
  const float width = cell.x1 - cell.x0 - 2 * kFrontGap, height = cell.z1 - cell.z0 - 2 * kFrontGap;
  const int leaves = width > 0.62f ? 2 : 1;
  for (int k = 0; k < leaves; ++k) {
    const float leaf = width / static_cast<float>(leaves) - (leaves > 1 ? 0.001f : 0.0f);
    const float mid =
        cell.x0 + kFrontGap + (static_cast<float>(k) + 0.5f) * width / static_cast<float>(leaves);
    b.Add(
        Front(s.p.fronts, leaf, height, 0.017f, true).Moved(mid, s.d - 0.022f, cell.z0 + kFrontGap),
        s.fronts);
    if (s.p.handles == HandleStyle::kNone) continue;
    const float side = leaves > 1 ? (k == 0 ? 1.0f : -1.0f) : (cell.column % 2 == 0 ? 1.0f : -1.0f);
    const bool bar = s.p.handles == HandleStyle::kBar || s.p.handles == HandleStyle::kBow;
    Shape handle = Handle(bar ? s.p.handles : HandleStyle::kKnob, 0.11f);
    if (bar) handle = handle.TurnedY(0.5f * kPi);
    b.Add(handle.Moved(mid + side * (0.5f * leaf - 0.035f), s.d - 0.005f, cell.z0 + 0.6f * height),
          s.metal);
  }
}

// Boards, and what stands before the compartments of a column; open ones can carry things.
void AddShelfColumn(AssetBuilder& b, const Shelf& s, int column, const std::vector<float>& xs,
                    const std::vector<float>& zs) {
  const float d = s.d, t = s.t;
  const float x0 = xs[column] + 0.5f * t, x1 = xs[column + 1] - 0.5f * t;
  for (int r = 0; r < s.p.rows; ++r) {
    const ShelfCell cell{x0, x1, zs[r] + 0.5f * t, zs[r + 1] - 0.5f * t, column};
    if (r > 0)
      b.Add(Board({x0, -d + 0.006f, zs[r] - 0.5f * t}, {x1, d - 0.005f, zs[r] + 0.5f * t}, 0.0015f),
            s.wood);
    if (r < s.p.drawers_low) {
      AddDrawer(b, s, cell);
    } else if (r < s.p.doors_low) {
      AddDoors(b, s, cell);
    } else {
      b.Support({x0 + 0.01f, -d + 0.012f}, {x1 - 0.01f, d - 0.012f}, cell.z0, cell.z1 - cell.z0);
    }
  }
}

// A stepped moulding round front and sides, mitred by hand: a loft over the four corners with
// outward directions.
Shape Cornice(const Shelf& s) {
  const Path2 section{{0, 0},           {0.006f, 0},      {0.008f, 0.008f}, {0.02f, 0.018f},
                      {0.026f, 0.034f}, {0.034f, 0.036f}, {0.034f, 0.048f}, {0, 0.048f}};
  const Path3 path{{-s.w, -s.d, 0}, {-s.w, s.d, 0}, {s.w, s.d, 0}, {s.w, -s.d, 0}};
  const Vec2f out[4] = {{-1, 0}, {-1, 1}, {1, 1}, {1, 0}};
  Shape moulding;
  for (int k = 0; k < 4; ++k) {
    for (const Vec2f& q : section) {
      const Vec3f at = path[k] + Vec3f(out[k].x() * (q.x() + 0.0005f),
                                       out[k].y() * (q.x() + 0.0005f), s.top - 0.048f + q.y());
      moulding.AddPoint(at, {at.x() + at.y(), q.x(), q.y()});
    }
  }
  const uint32_t m = static_cast<uint32_t>(section.size());
  for (uint32_t k = 0; k < 3; ++k) {
    for (uint32_t i = 0; i < m; ++i) {
      const uint32_t n = (i + 1) % m;
      moulding.AddQuad(k * m + i, (k + 1) * m + i, (k + 1) * m + n, k * m + n);
    }
  }
  for (const auto& [i, j, k] : Triangulate(section)) {
    moulding.AddTriangle(i, j, k);
    moulding.AddTriangle(3 * m + i, 3 * m + k, 3 * m + j);
  }
  if (moulding.Volume() < 0) {
    for (Face& f : moulding.faces) std::reverse(f.v.begin(), f.v.begin() + f.corners);
  }
  return moulding.Creased(0.5f);
}

Asset MakeShelf(const ShelfParams& p) {
  AssetBuilder b(p.seed);
  Rng rng(SceneSeed{p.seed}, "shelf");
  const Shelf shelf(p);
  const float w = shelf.w, d = shelf.d, t = shelf.t;
  AddCarcass(b, shelf);
  if (p.leg_m > 0) AddShelfLegs(b, shelf);
  const std::vector<float> xs = Divide(-w + 0.5f * t, w - 0.5f * t, p.columns, 0.0f, rng);
  AddDividers(b, shelf, xs);
  const std::vector<float> zs =
      Divide(shelf.floor + 0.5f * t, shelf.top - 0.5f * t, p.rows, p.unevenness, rng);
  for (int c = 0; c < p.columns; ++c) AddShelfColumn(b, shelf, c, xs, zs);
  if (p.cornice) b.Add(Cornice(shelf), shelf.wood);
  b.Support({-w + 0.02f, -d + 0.015f}, {w - 0.02f, d - 0.02f}, shelf.top);
  return b.Finish();
}

constexpr float kTriangleBoard = 0.022f;

// Boards in a corner or between A-frames: a shelf that narrows upwards.
struct TriangleShelfParams {
  float width_m = 0.6f;
  float depth_m = 0.4f;
  float height_m = 1.6f;
  int rows = 4;
  bool ladder = true;  // A-frame ladders; false: a corner shelf with triangular boards.
  uint64_t seed = 0;
};

// Two A-frames; boards between them get shallower upwards.
void AddLadderShelf(AssetBuilder& b, const TriangleShelfParams& p) {
  const MaterialSlot wood = WoodSlot("frame"), shelf = WoodSlot("shelves");
  const float w = 0.5f * p.width_m, h = p.height_m, t = kTriangleBoard;
  const float d0 = 0.5f * p.depth_m, d1 = 0.1f;
  const auto half_depth = [&](float z) { return Lerp(d0, d1, z / h); };
  for (const float s : {-1.0f, 1.0f}) {
    b.AddMirroredX(Bar({w - 0.014f, s * d0, 0}, {w - 0.014f, s * d1, h}, {0.026f, 0.042f},
                       {0.026f, 0.042f}, 0.004f, Vec3f::UnitY()),
                   wood);
  }
  for (int i = 0; i < p.rows; ++i) {
    const float z = 0.12f + (h - 0.16f) * static_cast<float>(i) / static_cast<float>(p.rows - 1);
    const float d = half_depth(z);
    b.AddMirroredX(Board({w - 0.024f, -d, z - 0.045f}, {w - 0.006f, d, z - t}, 0.003f), wood);
    b.Add(Board({-w + 0.028f, -d + 0.004f, z - t}, {w - 0.028f, d - 0.004f, z}, 0.003f), shelf);
    b.Add(Board({-w + 0.014f, -d - 0.004f, z - t}, {w - 0.014f, -d + 0.008f, z + 0.02f}, 0.003f),
          wood);
    const float next =
        0.12f + (h - 0.16f) * static_cast<float>(i + 1) / static_cast<float>(p.rows - 1);
    const float inner = i + 1 < p.rows ? half_depth(next) : d;
    b.Support({-w + 0.04f, -std::min(d, inner) + 0.03f}, {w - 0.04f, std::min(d, inner) - 0.012f},
              z, i + 1 < p.rows ? next - t - z - 0.03f : 10.0f);
  }
}

// A board with its right angle at the origin: a quarter round, or a triangle with cut corners.
Path2 CornerOutline(float a, bool round) {
  Path2 outline{{0, 0}, {a, 0}};
  if (round) {
    const Path2 arc = Arc({0, 0}, a, a, 0, 0.5f * kPi, 20);
    outline.insert(outline.end(), arc.begin() + 1, arc.end());
  } else {
    outline.emplace_back(a, 0.12f * a);
    outline.emplace_back(0.12f * a, a);
    outline.emplace_back(0, a);
  }
  return outline;
}

// The right angle at the back, boards between three posts.
void AddCornerShelf(AssetBuilder& b, const TriangleShelfParams& p) {
  const MaterialSlot wood = WoodSlot("frame"), shelf = WoodSlot("shelves");
  const float a = p.width_m, h = p.height_m, t = kTriangleBoard;
  const Path2 outline = CornerOutline(a, p.seed % 2 == 0);
  // The diagonal faces +y.
  const auto place = [&](const Shape& s, float z) { return s.TurnedZ(0.25f * kPi).Moved(0, 0, z); };
  for (int i = 0; i < p.rows; ++i) {
    const float z = 0.05f + (h - 0.07f) * static_cast<float>(i) / static_cast<float>(p.rows - 1);
    b.Add(place(Extrude(outline, t, 0.003f), z), shelf);
    const float next =
        0.05f + (h - 0.07f) * static_cast<float>(i + 1) / static_cast<float>(p.rows - 1);
    const float y0 = 0.36f * a, half = 0.2f * a;
    b.Support({-half, y0}, {half, y0 + 0.28f * a}, z + t, i + 1 < p.rows ? next - z - t : 10.0f);
  }
  for (const Vec2f& c :
       {Vec2f(0.018f, 0.018f), Vec2f(a - 0.03f, 0.018f), Vec2f(0.018f, a - 0.03f)}) {
    b.Add(place(Board({c.x() - 0.016f, c.y() - 0.016f, 0}, {c.x() + 0.016f, c.y() + 0.016f, h},
                      0.004f),
                0),
          wood);
  }
  for (const float z : {0.02f, h - 0.03f}) {
    b.Add(place(Board({0.02f, 0.002f, z}, {a - 0.03f, 0.014f, z + 0.03f}, 0.002f), 0), wood);
    b.Add(place(Board({0.002f, 0.02f, z}, {0.014f, a - 0.03f, z + 0.03f}, 0.002f), 0), wood);
  }
}

Asset MakeTriangleShelf(const TriangleShelfParams& p) {
  AssetBuilder b(p.seed);
  p.ladder ? AddLadderShelf(b, p) : AddCornerShelf(b, p);
  return b.Finish();
}

}  // namespace

Asset SampleSimpleBookcase(Rng& rng) {
  ShelfParams p;
  p.width_m = Draw(rng, 0.6, 1.0);
  p.depth_m = Draw(rng, 0.26, 0.36);
  p.height_m = Draw(rng, 0.9, 2.0);
  p.board_m = Draw(rng, 0.018, 0.026);
  p.rows = std::max(2, static_cast<int>(p.height_m / Draw(rng, 0.3, 0.4)));
  p.plinth_m = Draw(rng, 0.04, 0.09);
  if (rng.Bernoulli(0.25)) p.leg_m = Draw(rng, 0.1, 0.18);
  p.cornice = p.leg_m == 0 && rng.Bernoulli(0.35);
  p.doors_low = rng.Bernoulli(0.2) ? 1 : 0;
  p.fronts = DrawEnum<FrontStyle>(rng, static_cast<int>(FrontStyle::kCount));
  p.handles = rng.Bernoulli(0.6) ? HandleStyle::kKnob : HandleStyle::kBow;
  p.seed = rng.Seed();
  return MakeShelf(p);
}

Asset SampleLargeShelf(Rng& rng) {
  ShelfParams p{.columns = rng.UniformInt(2, 4)};
  p.width_m = static_cast<float>(p.columns) * Draw(rng, 0.45, 0.68);
  p.depth_m = Draw(rng, 0.3, 0.4);
  p.height_m = Draw(rng, 1.8, 2.3);
  p.board_m = Draw(rng, 0.02, 0.034);
  p.rows = rng.UniformInt(5, 7);
  p.cornice = rng.Bernoulli(0.4);
  if (rng.Bernoulli(0.5))
    p.doors_low = 1;
  else
    p.drawers_low = rng.UniformInt(0, 2);
  if (p.doors_low + p.drawers_low > 0) p.unevenness = 0.1f;
  p.fronts = DrawEnum<FrontStyle>(rng, static_cast<int>(FrontStyle::kCount));
  p.handles = DrawEnum<HandleStyle>(rng, static_cast<int>(HandleStyle::kCount));
  p.seed = rng.Seed();
  return MakeShelf(p);
}

Asset SampleCellShelf(Rng& rng) {
  ShelfParams p{.columns = rng.UniformInt(2, 5), .rows = rng.UniformInt(2, 5)};
  const float cell = Draw(rng, 0.32, 0.4);
  p.board_m = Draw(rng, 0.02, 0.04);
  p.width_m = cell * static_cast<float>(p.columns) + p.board_m;
  const bool legs = rng.Bernoulli(0.35);
  p.leg_m = legs ? Draw(rng, 0.1, 0.2) : 0.0f;
  p.plinth_m = 0;
  p.height_m = cell * static_cast<float>(p.rows) + p.board_m + p.leg_m;
  p.depth_m = Draw(rng, 0.32, 0.4);
  p.unevenness = 0;
  p.back = rng.Bernoulli(0.4);
  p.drawers_low = rng.Bernoulli(0.3) ? 1 : 0;
  p.handles = HandleStyle::kKnob;
  p.seed = rng.Seed();
  return MakeShelf(p);
}

Asset SampleTVStand(Rng& rng) {
  ShelfParams p;
  p.columns = rng.UniformInt(2, 4);
  p.width_m = Draw(rng, 1.2, 1.9);
  p.depth_m = Draw(rng, 0.36, 0.46);
  p.leg_m = rng.Bernoulli(0.6) ? Draw(rng, 0.1, 0.2) : 0.0f;
  p.height_m = Draw(rng, 0.36, 0.46) + p.leg_m;
  p.legs = DrawEnum<LegStyle>(rng, 3);
  p.board_m = Draw(rng, 0.02, 0.032);
  p.plinth_m = Draw(rng, 0.03, 0.06);
  p.rows = 2;
  p.unevenness = 0.2f;
  if (rng.Bernoulli(0.5))
    p.drawers_low = 1;
  else
    p.doors_low = rng.UniformInt(0, 1);
  p.fronts = DrawEnum<FrontStyle>(rng, static_cast<int>(FrontStyle::kCount));
  p.handles = DrawEnum<HandleStyle>(rng, static_cast<int>(HandleStyle::kCount));
  p.seed = rng.Seed();
  return MakeShelf(p);
}

Asset SampleTriangleShelf(Rng& rng) {
  TriangleShelfParams p{.ladder = rng.Bernoulli(0.5)};
  p.width_m = p.ladder ? Draw(rng, 0.5, 0.8) : Draw(rng, 0.32, 0.45);
  p.depth_m = Draw(rng, 0.36, 0.5);
  p.height_m = Draw(rng, 1.3, 1.9);
  p.rows = rng.UniformInt(4, 5);
  p.seed = rng.Seed();
  return MakeTriangleShelf(p);
}

}  // namespace parallax
