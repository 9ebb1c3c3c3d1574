#include "worker/assets/furniture/table_bases.h"

#include <algorithm>
#include <cmath>

namespace parallax {
namespace {

using namespace kernel;  // NOLINT: the modelling vocabulary of this folder.

// Where legs stand: at the corners, or inside a round outline.
Vec2f LegCorner(const TableParams& p) {
  const bool round = p.top == TopStyle::kRound || p.top == TopStyle::kOval;
  const float inset = 0.035f + 0.5f * p.leg_m;
  if (round) return {0.5f * p.width_m * 0.62f, 0.5f * p.depth_m * 0.62f};
  if (p.top == TopStyle::kRounded)
    return {0.5f * p.width_m - inset - 0.04f, 0.5f * p.depth_m - inset - 0.04f};
  return {0.5f * p.width_m - inset, 0.5f * p.depth_m - inset};
}

// Dimensions that the parts of a base with four legs share: where legs stand at the top, the top's
// underside, the apron's height, how far the feet stand out.
struct LegFrame {
  explicit LegFrame(const TableParams& p)
      : c(LegCorner(p)),
        under(p.height_m - p.top_m),
        apron(std::min(0.1f, 0.2f * p.height_m)),
        splay(p.legs == LegStyle::kRound && !p.shelf ? 0.1f * p.height_m : 0.0f) {}
  const Vec2f c;
  const float under, apron, splay;
  const MaterialSlot wood = WoodSlot("frame");
};

void AddTableLegs(AssetBuilder& b, const TableParams& p, const LegFrame& f) {
  const Vec2f c = f.c;
  const float under = f.under, t = p.leg_m;
  const Vec3f top(c.x(), c.y(), under), foot(c.x() + f.splay, c.y() + f.splay, 0);
  if (p.legs != LegStyle::kTurned || !p.apron) {
    b.AddFourfold(FurnitureLeg(p.legs, foot, top, t, p.leg_variant), f.wood);
    return;
  }
  const float block = f.apron + 0.04f;
  b.AddFourfold(Board({c.x() - 0.5f * t, c.y() - 0.5f * t, under - block},
                      {c.x() + 0.5f * t, c.y() + 0.5f * t, under}, 0.004f),
                f.wood);
  b.AddFourfold(
      FurnitureLeg(p.legs, foot, {c.x(), c.y(), under - block + 0.005f}, t, p.leg_variant), f.wood);
}

void AddTableAprons(AssetBuilder& b, const LegFrame& f) {
  const Vec2f c = f.c;
  const float h = 0.011f, under = f.under, apron = f.apron;
  for (const float s : {-1.0f, 1.0f}) {
    b.Add(Board({-c.x(), s * c.y() - h, under - apron}, {c.x(), s * c.y() + h, under}), f.wood);
    b.Add(Board({s * c.x() - h, -c.y(), under - apron}, {s * c.x() + h, c.y(), under}), f.wood);
  }
}

// Each pair at a height of its own, so that their joints do not meet.
void AddRungs(AssetBuilder& b, const TableParams& p, const LegFrame& f) {
  for (const auto& [z, across] : {std::pair{0.2f, true}, std::pair{0.27f, false}}) {
    const float at = z * p.height_m, out = f.splay * (1 - at / f.under);
    const float x = f.c.x() + out, y = f.c.y() + out, r = 0.26f * p.leg_m;
    if (across) {
      for (const float s : {-1.0f, 1.0f}) b.Add(Rod({-x, s * y, at}, {x, s * y, at}, r, r), f.wood);
    } else {
      b.AddMirroredX(Rod({x, -y, at}, {x, y, at}, r, r), f.wood);
    }
  }
}

// A board between the legs that carries things.
void AddLowShelf(AssetBuilder& b, const TableParams& p, const LegFrame& f) {
  const Vec2f c = f.c;
  const float z = 0.3f * p.height_m, t = p.leg_m;
  b.Add(Board({-c.x() - 0.2f * t, -c.y() - 0.2f * t, z - 0.018f},
              {c.x() + 0.2f * t, c.y() + 0.2f * t, z}, 0.003f),
        WoodSlot("top"));
  const float inset = 0.6f * t;
  b.Support({-c.x() + inset, -c.y() + inset}, {c.x() - inset, c.y() - inset}, z,
            f.under - (p.apron ? f.apron : 0.0f) - z);
}

void AddLegs(AssetBuilder& b, const TableParams& p) {
  const LegFrame frame(p);
  AddTableLegs(b, p, frame);
  if (p.apron) AddTableAprons(b, frame);
  if (p.rungs) AddRungs(b, p, frame);
  if (p.shelf) AddLowShelf(b, p, frame);
}

// Where the trestles stand, and half the table's depth.
struct TrestleFrame {
  explicit TrestleFrame(const TableParams& p)
      : under(p.height_m - p.top_m),
        x(0.5f * p.width_m - 0.22f * std::min(1.0f, p.width_m)),
        y(0.5f * p.depth_m) {}
  const float under, x, y;
  const MaterialSlot wood = WoodSlot("frame");
};

// Foot with rounded toes, head under the top.
void AddTrestleFeet(AssetBuilder& b, const TrestleFrame& f) {
  const float x = f.x, y = f.y;
  const Path2 foot_side{{-0.82f * y, 0.0f}, {-0.6f * y, 0.0f},  {-0.5f * y, 0.012f},
                        {0.5f * y, 0.012f}, {0.6f * y, 0.0f},   {0.82f * y, 0.0f},
                        {0.82f * y, 0.03f}, {0.5f * y, 0.075f}, {-0.5f * y, 0.075f},
                        {-0.82f * y, 0.03f}};
  const Shape foot = Extrude(foot_side, 0.085f, 0.005f).Bent([&](const Vec3f& q) {
    return Vec3f(q.z() - 0.0425f + x, q.x(), q.y());
  });
  b.AddMirroredX(foot, f.wood);
  const Path2 head_side{{-0.75f * y, 0.0f}, {0.75f * y, 0.0f},   {0.75f * y, -0.025f},
                        {0.6f * y, -0.06f}, {-0.6f * y, -0.06f}, {-0.75f * y, -0.025f}};
  const Path2 head(head_side.rbegin(), head_side.rend());
  b.AddMirroredX(Extrude(head, 0.07f, 0.004f).Bent([&](const Vec3f& q) {
    return Vec3f(q.z() - 0.035f + x, q.x(), q.y() + f.under);
  }),
                 f.wood);
}

// A board whose outline is that of a baluster.
void AddBalusterBoard(AssetBuilder& b, const TrestleFrame& f) {
  const float x = f.x, y = f.y;
  const Path2 column = Spline(
      Path2{{0.22f, 0.07f}, {0.2f, 0.2f}, {0.13f, 0.38f}, {0.2f, 0.56f}, {0.24f, f.under - 0.05f}},
      5);
  Path2 outline;
  for (const Vec2f& q : column) outline.emplace_back(q.x() * y * 1.6f, q.y());
  for (size_t i = column.size(); i-- > 0;)
    outline.emplace_back(-column[i].x() * y * 1.6f, column[i].y());
  Shape board = Extrude(outline, 0.045f, 0.004f).Bent([&](const Vec3f& q) {
    return Vec3f(q.z() - 0.0225f + x, q.x(), q.y());
  });
  for (size_t i = 0; i < board.points.size(); ++i)
    board.texture[i] = {board.points[i].z(), board.points[i].x(), board.points[i].y()};
  b.AddMirroredX(board, f.wood);
}

// Two trestles joined by a stretcher.
void AddTrestle(AssetBuilder& b, const TableParams& p) {
  const TrestleFrame f(p);
  const float x = f.x, y = f.y;
  AddTrestleFeet(b, f);
  if (p.leg_variant % 2 == 0) {
    for (const float s : {-1.0f, 1.0f}) {
      b.AddMirroredX(Bar({x, 0.32f * y * s, 0.06f}, {x, 0.32f * y * s, f.under - 0.04f},
                         {0.07f, 0.075f}, {0.07f, 0.075f}, 0.005f, Vec3f::UnitY()),
                     f.wood);
    }
  } else {
    AddBalusterBoard(b, f);
  }
  const float z = 0.32f * p.height_m;
  b.Add(Board({-x, -0.02f, z}, {x, 0.02f, z + 0.09f}, 0.004f), f.wood);
}

// A turned column on three or four bowed feet, a cross under the top.
void AddTurnedPedestal(AssetBuilder& b, const TableParams& p, float spread) {
  const MaterialSlot wood = WoodSlot("frame");
  const float under = p.height_m - p.top_m;
  b.Add(TurnedLeg(under - 0.2f, 0.075f, p.leg_variant / 2).Moved(0, 0, 0.17f), wood);
  b.Add(Cylinder(0.07f, 0.1f, 0.006f).Moved(0, 0, 0.12f), wood);
  const int feet = p.leg_variant % 4 == 0 ? 3 : 4;
  for (int i = 0; i < feet; ++i) {
    const float a = 2 * kPi * static_cast<float>(i) / static_cast<float>(feet) + 0.25f * kPi;
    const Vec3f out(std::cos(a), std::sin(a), 0);
    const float reach = std::max(spread, 0.24f);
    const Path3 path =
        Spline(Path3{0.02f * out + Vec3f(0, 0, 0.19f), 0.35f * reach * out + Vec3f(0, 0, 0.165f),
                     0.75f * reach * out + Vec3f(0, 0, 0.07f), reach * out + Vec3f(0, 0, 0.022f),
                     (reach + 0.06f) * out + Vec3f(0, 0, 0.02f)},
               6);
    SweepOptions options;
    options.keep_up = true;
    options.end_round_m = 0.012f;
    options.scale = [](float t) { return Vec2f(1.0f - 0.25f * t, 1.0f - 0.5f * t); };
    b.Add(Sweep(path, RectSection(0.055f, 0.078f, 0.012f, 3), options), wood);
  }
  b.Add(Board({-0.9f * spread, -0.05f, under - 0.035f}, {0.9f * spread, 0.05f, under}, 0.006f),
        wood);
  b.Add(Board({-0.05f, -0.9f * spread, under - 0.035f}, {0.05f, 0.9f * spread, under}, 0.006f),
        wood);
}

void AddTrumpet(AssetBuilder& b, const TableParams& p, float spread) {
  const float under = p.height_m - p.top_m, r = std::max(spread, 0.2f);
  const Path2 profile = Spline(Path2{{r, 0},
                                     {r + 0.002f, 0.006f},
                                     {0.85f * r, 0.018f},
                                     {0.42f * r, 0.06f},
                                     {0.045f, 0.22f * p.height_m},
                                     {0.036f, 0.5f * p.height_m},
                                     {0.05f, 0.85f * under},
                                     {0.32f * r, under - 0.006f},
                                     {0.36f * r, under}},
                               6);
  b.Add(Lathe(profile, {.segments = 56}), Slot("frame", {"metal", "plastic", "paint"}));
}

void AddPedestal(AssetBuilder& b, const TableParams& p) {
  const float spread = 0.36f * std::min(p.width_m, p.depth_m);
  p.leg_variant % 2 == 0 ? AddTurnedPedestal(b, p, spread) : AddTrumpet(b, p, spread);
}

// Four arms with glides, bowed up or low. Returns the height at which the column begins.
float AddColumnArms(AssetBuilder& b, const TableParams& p, float reach, bool bowed) {
  const MaterialSlot metal = Slot("frame", {"metal", "paint"});
  const float r = 0.5f * p.leg_m;
  for (int i = 0; i < 4; ++i) {
    const float a = 0.5f * kPi * static_cast<float>(i) + 0.25f * kPi;
    const Vec3f out(std::cos(a), std::sin(a), 0);
    const float lift = bowed ? 0.16f : 0.05f;
    const Path3 arm = Spline(
        Path3{Vec3f(0, 0, lift) + 0.6f * r * out, Vec3f(0, 0, 0.8f * lift) + 0.45f * reach * out,
              Vec3f(0, 0, 0.024f) + 1.08f * reach * out},
        6);
    SweepOptions options;
    options.keep_up = true;
    options.end_round_m = 0.006f;
    options.scale = [](float t) { return Vec2f(1 - 0.2f * t, 1 - 0.45f * t); };
    b.Add(Sweep(arm, RectSection(0.05f, 0.036f, 0.008f, 3), options), metal);
    b.Add(Cylinder(0.014f, 0.016f, 0.003f, 16).Moved(1.04f * reach * out), metal);
  }
  return bowed ? 0.13f : 0.035f;
}

// A disk, a square plate or four arms. Returns the height at which the column begins.
float AddColumnFoot(AssetBuilder& b, const TableParams& p, float reach) {
  const MaterialSlot metal = Slot("frame", {"metal", "paint"});
  const float r = 0.5f * p.leg_m;
  switch (p.leg_variant % 4) {
    case 0:
      b.Add(Lathe(Spline(Path2{{reach, 0},
                               {reach + 0.004f, 0.006f},
                               {0.94f * reach, 0.014f},
                               {0.4f * reach, 0.024f},
                               {2.2f * r, 0.034f},
                               {1.3f * r, 0.05f}},
                         4)),
            metal);
      return 0.04f;
    case 1:
      b.Add(Extrude(RectSection(1.8f * reach, 1.8f * reach, 0.03f, 5), 0.012f, 0.003f), metal);
      return 0.012f;
    default:
      return AddColumnArms(b, p, reach, p.leg_variant % 4 == 2);
  }
}

// A ring for the feet, on two spokes.
void AddFootRing(AssetBuilder& b, const TableParams& p, float reach) {
  const MaterialSlot metal = Slot("frame", {"metal", "paint"});
  const float at = 0.24f * p.height_m;
  Path3 ring;
  for (const Vec2f& q : EllipseSection(1.5f * reach, 1.5f * reach, 40))
    ring.emplace_back(q.x(), q.y(), at);
  b.Add(Ring(ring, 0.009f, 12), metal);
  b.Add(Rod({-0.75f * reach, 0, at}, {0.75f * reach, 0, at}, 0.007f, 0.007f), metal);
}

// A steel tube on a heavy foot; a spider holds the top.
void AddColumn(AssetBuilder& b, const TableParams& p) {
  const MaterialSlot metal = Slot("frame", {"metal", "paint"});
  const float under = p.height_m - p.top_m, reach = 0.36f * std::min(p.width_m, p.depth_m);
  const float r = 0.5f * p.leg_m;
  const float z = AddColumnFoot(b, p, reach);
  b.Add(Cylinder(r, under - z, 0.001f).Moved(0, 0, z), metal);
  b.Add(Cone(1.25f * r, r, 0.04f, 0.004f).Moved(0, 0, z), metal);
  for (const float turn : {0.25f * kPi, 0.75f * kPi})
    b.Add(Board({-0.8f * reach, -0.02f, -0.012f}, {0.8f * reach, 0.02f, 0}, 0.003f)
              .TurnedZ(turn)
              .Moved(0, 0, under - (turn < 1 ? 0.0f : 0.0015f)),
          metal);
  if (p.rungs) AddFootRing(b, p, reach);
}

void AddSledge(AssetBuilder& b, const TableParams& p) {
  const MaterialSlot metal = Slot("frame", {"metal", "wood"});
  const float under = p.height_m - p.top_m, x = 0.5f * p.width_m - 0.12f * p.width_m,
              y = 0.5f * p.depth_m - 0.06f;
  const float t = p.leg_m > 0.06f ? 0.04f : 0.028f, h = 0.5f * t;
  // A closed frame of square tube each side; mitred corners.
  const Path2 outline = Filleted(
      Path2{{-y, h}, {0, h}, {y, h}, {y, under - h}, {0, under - h}, {-y, under - h}, {-y, h}},
      0.012f, 3);
  Path3 path;
  for (size_t i = 0; i + 1 < outline.size(); ++i)
    path.emplace_back(x, outline[i].x(), outline[i].y());
  // Start in the middle of a straight so that the ring closes smoothly.
  Path3 ring;
  ring.emplace_back(x, 0, h);
  for (const Vec3f& q : Filleted(
           Path3{
               {x, 0, h}, {x, y, h}, {x, y, under - h}, {x, -y, under - h}, {x, -y, h}, {x, 0, h}},
           0.02f, 4)) {
    if ((q - ring.back()).norm() > 1e-5f) ring.push_back(q);
  }
  ring.pop_back();
  b.AddMirroredX(Sweep(ring, RectSection(t, 1.5f * t, 0.004f, 2),
                       {.closed = true, .up = Vec3f::UnitX(), .keep_up = true}),
                 metal);
  b.Add(Board({-x, -0.03f, under - 0.03f}, {x, 0.03f, under}, 0.003f), metal);
}

void AddCrossed(AssetBuilder& b, const TableParams& p) {
  const MaterialSlot wood = WoodSlot("frame");
  const float under = p.height_m - p.top_m, x = 0.5f * p.width_m - 0.17f * p.width_m,
              y = 0.42f * p.depth_m, t = 0.06f;
  for (const float s : {-1.0f, 1.0f}) {
    const float shift = s * 0.002f;
    b.AddMirroredX(Bar({x + shift + s * 0.014f, -s * y, 0.025f},
                       {x + shift + s * 0.014f, s * y, under - 0.025f}, {0.03f, t}, {0.03f, t},
                       0.004f, Vec3f::UnitY()),
                   wood);
  }
  b.AddMirroredX(Board({x - 0.05f, -y - 0.03f, 0.0f}, {x + 0.05f, -y + 0.06f, 0.03f}, 0.005f),
                 wood);
  b.AddMirroredX(Board({x - 0.05f, y - 0.06f, 0.0f}, {x + 0.05f, y + 0.03f, 0.03f}, 0.005f), wood);
  b.AddMirroredX(
      Board({x - 0.045f, -y - 0.04f, under - 0.035f}, {x + 0.045f, y + 0.04f, under}, 0.004f),
      wood);
  b.Add(Board({-x, -0.025f, 0.5f * under - 0.03f}, {x, 0.025f, 0.5f * under + 0.03f}, 0.004f),
        wood);
}

void AddHairpin(AssetBuilder& b, const TableParams& p) {
  const MaterialSlot metal = MetalSlot("frame");
  const Vec2f c = LegCorner(p);
  const float under = p.height_m - p.top_m;
  for (const float sx : {-1.0f, 1.0f}) {
    for (const float sy : {-1.0f, 1.0f}) {
      const float s = 0.055f;
      const Vec3f tip(sx * (c.x() + 0.02f), sy * (c.y() + 0.02f), 0.0055f);
      const Vec3f a(sx * (c.x() - s), sy * c.y(), under - 0.002f),
          d(sx * c.x(), sy * (c.y() - s), under - 0.002f);
      const Vec3f ab = 0.012f * Vec3f(-sx, 0, 0), ad = 0.012f * Vec3f(0, -sy, 0);
      b.Add(Tube(Filleted(Path3{a, tip + ab, tip + ad, d}, 0.01f, 5), 0.0055f, 0, 12), metal);
      b.Add(Board({sx * (c.x() - s - 0.025f), sy * (c.y() - s - 0.025f), under - 0.005f},
                  {sx * (c.x() + 0.02f), sy * (c.y() + 0.02f), under}, 0.001f),
            metal);
    }
  }
}

}  // namespace

void AddTableBase(AssetBuilder& b, const TableParams& p) {
  switch (p.base) {
    case TableBase::kTrestle:
      return AddTrestle(b, p);
    case TableBase::kPedestal:
      return AddPedestal(b, p);
    case TableBase::kSledge:
      return AddSledge(b, p);
    case TableBase::kCrossed:
      return AddCrossed(b, p);
    case TableBase::kHairpin:
      return AddHairpin(b, p);
    case TableBase::kColumn:
      return AddColumn(b, p);
    default:
      return AddLegs(b, p);
  }
}

}  // namespace parallax
