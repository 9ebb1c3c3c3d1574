#include "worker/assets/chairs.h"

#include <algorithm>
#include <cmath>

namespace parallax {
namespace {

using namespace kernel;  // NOLINT: the modelling vocabulary of this folder.

constexpr float kSeatBoard = 0.022f;

// The frame that all four-legged wooden chairs share.
struct ChairFrame {
  explicit ChairFrame(const ChairParams& p)
      : front_x(0.5f * (p.width_m - p.leg_m)),
        back_x(0.88f * front_x),
        front_y(0.5f * (p.depth_m - p.leg_m)),
        back_y(-front_y),
        seat_top(p.seat_height_m),
        post_y(SmoothThrough({{0.0f, back_y - 0.035f},
                              {0.6f * p.seat_height_m, back_y - 0.004f},
                              {p.seat_height_m, back_y},
                              {p.back_height_m, back_y - p.lean_m}})) {}
  float front_x, back_x, front_y, back_y, seat_top;
  std::function<float(float)> post_y;
  // Angle of the back posts from upright at a height.
  float Lean(float z) const { return std::atan((post_y(z - 0.02f) - post_y(z + 0.02f)) / 0.04f); }
};

// A seat outline that is narrower behind: x shrinks linearly with y.
Shape Trapezoid(Shape shape, float front_y, float back_y, float back_factor) {
  return shape.Bent([=](const Vec3f& p) {
    const float t = std::clamp((p.y() - back_y) / (front_y - back_y), 0.0f, 1.0f);
    return Vec3f(p.x() * Lerp(back_factor, 1.0f, t), p.y(), p.z());
  });
}

void AddSeat(AssetBuilder& b, const ChairParams& p, const ChairFrame& f, const Noise& noise) {
  const Vec3f size(p.width_m + 0.012f, p.depth_m + 0.004f, kSeatBoard);
  if (p.cushion) {
    CushionOptions soft;
    soft.edge_radius_m = 0.018f;
    soft.bulge_top_m = 0.018f;
    soft.bulge_side_m = 0.004f;
    soft.wrinkle_m = 0.0015f;
    soft.piping_m = p.seed % 3 == 0 ? 0.0035f : 0.0f;
    soft.target_edge_m = 0.025f;
    const Shape pad = Cushion({size.x(), size.y(), 0.045f}, soft, noise);
    b.Add(Trapezoid(pad, f.front_y, f.back_y, 0.9f).Moved(0, 0.008f, f.seat_top - 0.0225f),
          FabricSlot("seat"));
    return;
  }
  BoxOptions box;
  box.bevel_m = 0.007f;
  box.bevel_steps = 2;
  box.pieces = {14, 14, 1};
  Shape board = RoundedBox(size, box);
  // Hollowed for sitting, mostly towards the back.
  board = board.Bent([&](const Vec3f& q) {
    const float u = 2 * q.x() / size.x(), v = 2 * q.y() / size.y();
    const float bowl = std::max(0.0f, 1 - u * u) * std::max(0.0f, 1 - (v + 0.15f) * (v + 0.15f));
    return Vec3f(q.x(), q.y(), q.z() - 0.009f * bowl * (q.z() > 0 ? 1.0f : 0.0f));
  });
  b.Add(
      Trapezoid(board, f.front_y, f.back_y, 0.9f).Moved(0, 0.008f, f.seat_top - 0.5f * kSeatBoard),
      WoodSlot("frame"));
}

void AddBase(AssetBuilder& b, const ChairParams& p, const ChairFrame& f) {
  const MaterialSlot wood = WoodSlot("frame");
  const float under = f.seat_top - (p.cushion ? 0.04f : kSeatBoard);
  const float t = p.leg_m;
  const bool turned = p.legs == LegStyle::kTurned || p.legs == LegStyle::kRound;
  if (turned) {
    // The joint with the aprons stays square above the turning.
    const float block = 0.075f;
    b.AddMirroredX(Board({f.front_x - 0.5f * t, f.front_y - 0.5f * t, under - block},
                         {f.front_x + 0.5f * t, f.front_y + 0.5f * t, under}, 0.003f),
                   wood);
    b.AddMirroredX(FurnitureLeg(p.legs, {f.front_x, f.front_y, 0},
                                {f.front_x, f.front_y, under - block + 0.004f}, t, p.leg_variant),
                   wood);
  } else {
    b.AddMirroredX(
        FurnitureLeg(p.legs, {f.front_x, f.front_y, 0}, {f.front_x, f.front_y, under}, t, 0), wood);
  }
  // Back legs run on as posts.
  Path3 post;
  for (int i = 0; i <= 18; ++i) {
    const float z = p.back_height_m * static_cast<float>(i) / 18.0f;
    post.emplace_back(f.back_x, f.post_y(z), z);
  }
  SweepOptions options;
  options.up = Vec3f::UnitY();
  options.keep_up = true;
  options.end_round_m = 0.006f;
  const float seat_t = f.seat_top / p.back_height_m;
  const auto taper = SmoothThrough({{0.0f, 0.62f}, {seat_t, 1.0f}, {1.0f, 0.66f}});
  options.scale = [=](float s) { return Vec2f(0.5f + 0.5f * taper(s), taper(s)); };
  b.AddMirroredX(Sweep(post, RectSection(0.85f * t, t, turned ? 0.012f : 0.005f, 3), options),
                 wood);

  // Aprons.
  const float low = under - 0.06f, half = 0.009f;
  b.Add(Board({-f.front_x, f.front_y - half, low}, {f.front_x, f.front_y + half, under}), wood);
  b.Add(Board({-f.back_x, f.back_y - half, low}, {f.back_x, f.back_y + half, under}), wood);
  b.AddMirroredX(
      Bar({f.back_x, f.back_y, 0.5f * (low + under)}, {f.front_x, f.front_y, 0.5f * (low + under)},
          {2 * half, under - low}, {2 * half, under - low}, 0.002f),
      wood);
  if (!p.stretchers) return;
  const float z = 0.14f + 0.03f * static_cast<float>(p.leg_variant % 3);
  const float yb = f.post_y(z);
  const auto rung = [&](const Vec3f& a, const Vec3f& c) {
    return turned ? Rod(a, c, 0.26f * t, 0.26f * t)
                  : Bar(a, c, {0.42f * t, 0.6f * t}, {0.42f * t, 0.6f * t});
  };
  b.AddMirroredX(rung({f.back_x, yb, z}, {f.front_x, f.front_y, z}), wood);
  if (p.leg_variant % 2 == 0) {
    const float x = 0.5f * (f.back_x + f.front_x), y = 0.5f * (yb + f.front_y);
    b.Add(rung({-x, y, z}, {x, y, z}), wood);
  } else {
    b.Add(rung({-f.front_x, f.front_y, z + 0.06f}, {f.front_x, f.front_y, z + 0.06f}), wood);
    b.Add(rung({-f.back_x, f.post_y(z + 0.06f), z + 0.06f},
               {f.back_x, f.post_y(z + 0.06f), z + 0.06f}),
          wood);
  }
}

void AddArms(AssetBuilder& b, const ChairParams& p, const ChairFrame& f) {
  const MaterialSlot wood = WoodSlot("frame");
  const float z = f.seat_top + 0.205f;
  const float front = f.front_y - 0.05f;
  b.AddMirroredX(Rod({f.front_x + 0.004f, f.front_y - 0.02f, f.seat_top - 0.05f},
                     {f.front_x + 0.02f, front, z}, 0.42f * p.leg_m, 0.34f * p.leg_m),
                 wood);
  const Path3 path = Spline(Path3{{f.back_x, f.post_y(z + 0.02f), z + 0.02f},
                                  {f.front_x + 0.012f, f.post_y(z) + 0.13f, z + 0.024f},
                                  {f.front_x + 0.03f, 0.4f * front, z + 0.008f},
                                  {f.front_x + 0.022f, front, z + 0.006f},
                                  {f.front_x + 0.012f, front + 0.055f, z - 0.006f}},
                            6);
  SweepOptions options;
  options.keep_up = true;
  options.end_round_m = 0.01f;
  options.scale = [](float t) { return Vec2f(0.6f + 0.6f * Smooth01(t * 1.2f), 1.0f); };
  b.AddMirroredX(Sweep(path, RectSection(0.042f, 0.024f, 0.009f, 3), options), wood);
}

void AddBack(AssetBuilder& b, const ChairParams& p, const ChairFrame& f, const Noise& noise) {
  const MaterialSlot wood = WoodSlot("frame");
  const float top = p.back_height_m, low = f.seat_top + 0.1f;
  const float inner = f.back_x;
  const auto rail = [&](float z, float height, float bow, float thickness) {
    b.Add(BowedRail(inner, bow, thickness, height, z, f.post_y(z), f.Lean(z)), wood);
  };
  const auto bowed_y = [&](float x, float z) {
    const float s = x / inner;
    return f.post_y(z) - p.bow_m * (1 - s * s);
  };
  switch (p.style) {
    case ChairStyle::kLadder: {
      const int n = std::clamp(p.back_parts, 3, 5);
      for (int i = 0; i < n; ++i) {
        const float t = static_cast<float>(i) / static_cast<float>(n - 1);
        const float z = Lerp(low + 0.02f, top - 0.045f, t);
        rail(z, Lerp(0.045f, 0.07f, t), p.bow_m, 0.014f);
      }
      break;
    }
    case ChairStyle::kUpholstered: {
      rail(top - 0.02f, 0.04f, 0.0f, 0.022f);
      rail(low - 0.02f, 0.035f, 0.0f, 0.02f);
      CushionOptions soft;
      soft.edge_radius_m = 0.016f;
      soft.bulge_top_m = 0.016f;
      soft.bulge_side_m = 0.0f;
      soft.wrinkle_m = 0.0012f;
      soft.target_edge_m = 0.025f;
      if (p.back_parts > 5) {
        soft.tufts_x = 3;
        soft.tufts_y = 3;
        soft.tuft_depth_m = 0.012f;
      }
      const float height = top - low - 0.03f, mid = 0.5f * (top - 0.035f + low);
      const Shape pad = Cushion({2 * inner - 0.4f * p.leg_m, height, 0.04f}, soft, noise);
      b.Add(pad.TurnedX(-0.5f * kPi + f.Lean(mid)).Moved(0, f.post_y(mid) + 0.004f, mid),
            FabricSlot("seat"));
      break;
    }
    case ChairStyle::kCrossed: {
      rail(top - 0.035f, 0.07f, p.bow_m, 0.02f);
      rail(low, 0.035f, p.bow_m, 0.018f);
      for (const float side : {-1.0f, 1.0f}) {
        Path3 path;
        for (int i = 0; i <= 12; ++i) {
          const float t = static_cast<float>(i) / 12.0f;
          const float x = side * Lerp(-0.92f, 0.92f, t) * inner,
                      z = Lerp(low + 0.01f, top - 0.06f, t);
          path.emplace_back(x, bowed_y(x, z) + 0.004f * side, z);
        }
        SweepOptions options;
        options.up = Vec3f::UnitY();
        options.keep_up = true;
        b.Add(Sweep(path, RectSection(0.026f, 0.014f, 0.003f, 2), options), wood);
      }
      break;
    }
    default: {
      const bool slats = p.style == ChairStyle::kSlat;
      rail(top - 0.035f, 0.075f, p.bow_m, 0.022f);
      rail(low, 0.035f, p.bow_m, 0.018f);
      const int n = slats ? std::min(p.back_parts, 5) : p.back_parts + 2;
      for (int i = 0; i < n; ++i) {
        const float x =
            0.9f * inner * ((2.0f * static_cast<float>(i) + 1) / static_cast<float>(n) - 1);
        const float width = slats ? 1.05f * inner / static_cast<float>(n) : 0.0f;
        if (slats) {
          b.Add(Bar({x, bowed_y(x, low), low}, {x, bowed_y(x, top - 0.04f), top - 0.04f},
                    {width, 0.01f}, {1.1f * width, 0.01f}, 0.003f, Vec3f::UnitY()),
                wood);
        } else {
          b.Add(Rod({x, bowed_y(x, low), low}, {x, bowed_y(x, top - 0.05f), top - 0.05f}, 0.0075f,
                    0.0065f),
                wood);
        }
      }
      break;
    }
  }
}

// A hollowed plank on splayed turned legs, sticks in the plank, a bent bow over them.
void BuildWindsor(AssetBuilder& b, const ChairParams& p) {
  const MaterialSlot wood = WoodSlot("frame");
  const float w = 0.5f * p.width_m, d = 0.5f * p.depth_m, h = p.seat_height_m, thick = 0.042f;
  Path2 outline = SuperellipseSection(2 * w, 2 * d, 3.2f, 44);
  BoxOptions box;
  box.bevel_m = 0.014f;
  box.bevel_steps = 2;
  box.pieces = {18, 18, 1};
  Shape seat = RoundedBox({2.0f, 2.0f, thick}, box).Bent([&](const Vec3f& q) {
    // Square to superellipse, keeping the rounded edge.
    const float u = std::clamp(q.x(), -1.0f, 1.0f), v = std::clamp(q.y(), -1.0f, 1.0f);
    const float x = u * std::sqrt(1 - 0.32f * v * v), y = v * std::sqrt(1 - 0.32f * u * u);
    const float narrow = 1 - 0.07f * (1 - y) * 0.5f;
    const float saddle =
        std::max(0.0f, 1 - 1.15f * x * x) * std::max(0.0f, 1 - (y + 0.2f) * (y + 0.2f) * 0.95f);
    const float ridge = std::exp(-30.0f * x * x) * Smooth01((y - 0.1f) * 1.4f);
    const float z = q.z() > 0 ? q.z() - 0.016f * saddle * (1 - 0.5f * ridge) : q.z();
    return Vec3f(x * w * narrow, y * d, z);
  });
  TextureAlongLongest(seat);
  b.Add(seat.Moved(0, 0, h - 0.5f * thick), wood);

  const float under = h - thick + 0.012f;
  const Vec3f front_top(0.66f * w, 0.6f * d, under), front_foot(0.95f * w, 0.98f * d, 0);
  const Vec3f back_top(0.58f * w, -0.58f * d, under), back_foot(0.9f * w, -1.12f * d, 0);
  b.AddMirroredX(FurnitureLeg(LegStyle::kTurned, front_foot, front_top, 0.04f, p.leg_variant),
                 wood);
  b.AddMirroredX(FurnitureLeg(LegStyle::kTurned, back_foot, back_top, 0.04f, p.leg_variant), wood);
  const auto on = [](const Vec3f& foot, const Vec3f& top, float z) {
    return Vec3f(foot + (top - foot) * (z / top.z()));
  };
  const Vec3f f = on(front_foot, front_top, 0.2f), r = on(back_foot, back_top, 0.2f);
  const auto swelling = [](const Vec3f& a, const Vec3f& c) {
    SweepOptions options;
    options.scale = [](float t) {
      return Vec2f::Constant(0.62f + 0.38f * std::sin(kPi * t)).eval();
    };
    Path3 path;
    for (int i = 0; i <= 10; ++i) path.push_back(a + (c - a) * (0.1f * static_cast<float>(i)));
    return Sweep(path, EllipseSection(0.026f, 0.026f, 14), options);
  };
  b.AddMirroredX(swelling(f, r), wood);
  const Vec3f mid = 0.5f * (f + r);
  b.Add(swelling({-mid.x(), mid.y(), mid.z()}, mid), wood);

  // The bow: up from the seat's back corners, over, and down; leaning back.
  const float top = p.back_height_m, rise = top - h;
  const auto bow_point = [&](float a) {  // a in [0, pi] from right to left.
    const float s = std::sin(a), c = std::cos(a);
    const float z = h - 0.02f + (rise + 0.02f) * std::pow(std::max(s, 0.0f), 0.62f);
    const float x = 0.82f * w * std::copysign(std::pow(std::abs(c), 0.72f), c);
    const float t = (z - h) / rise;
    return Vec3f(x, -0.62f * d - 0.22f * d * s - p.lean_m * 1.3f * t, z);
  };
  Path3 bow;
  for (int i = 0; i <= 40; ++i) bow.push_back(bow_point(kPi * static_cast<float>(i) / 40.0f));
  b.Add(Sweep(bow, RectSection(0.022f, 0.026f, 0.009f, 3)), wood);
  const int n = p.back_parts + 3;
  for (int i = 0; i < n; ++i) {
    const float a = Lerp(0.2f, 0.8f, (static_cast<float>(i) + 0.5f) / static_cast<float>(n)) * kPi;
    const Vec3f to = bow_point(a);
    const float x = 0.62f * to.x();
    const Vec3f from(x, -0.86f * d * std::sqrt(std::max(0.1f, 1 - (x / w) * (x / w) * 0.9f)),
                     h - 0.015f);
    b.Add(Rod(from, to, 0.0085f, 0.006f), wood);
  }
}

// A moulded shell on dowels or wire.
void BuildShell(AssetBuilder& b, const ChairParams& p, const Noise&) {
  const float h = p.seat_height_m, w = 0.5f * p.width_m;
  const float rise = p.back_height_m - h;
  const Path2 profile = Spline(Path2{{0.235f, -0.028f},
                                     {0.2f, -0.002f},
                                     {0.06f, -0.004f},
                                     {-0.08f, -0.012f},
                                     {-0.165f, 0.02f},
                                     {-0.205f, 0.11f},
                                     {-0.228f, 0.55f * rise},
                                     {-0.255f, rise}},
                               6);
  std::vector<float> arc(profile.size(), 0);
  for (size_t i = 1; i < profile.size(); ++i)
    arc[i] = arc[i - 1] + (profile[i] - profile[i - 1]).norm();
  const auto at = [&](float v) {
    const float s = v * arc.back();
    size_t i = 1;
    while (i + 1 < arc.size() && arc[i] < s) ++i;
    const float t = (s - arc[i - 1]) / (arc[i] - arc[i - 1]);
    return Vec2f(profile[i - 1] + t * (profile[i] - profile[i - 1]));
  };
  SheetOptions sheet;
  sheet.pieces_u = 28;
  sheet.pieces_v = 44;
  sheet.thickness_m = 0.007f;
  sheet.size_m = {p.width_m, arc.back()};
  const bool arms = p.arms;
  const Shape shell = Sheet(
      [&](float u, float v) {
        // A disc-like parameter square keeps the corners round.
        const float a = 2 * u - 1, c = 2 * v - 1;
        const float x = a * std::sqrt(1 - 0.42f * c * c * c * c);
        const float y = 0.5f + 0.5f * c * std::sqrt(1 - 0.16f * a * a);
        const Vec2f mid = at(y);
        const float back = Smooth01((y - 0.42f) / 0.25f);
        const float curl = x * x * (0.6f + 0.4f * x * x);
        const float hips = std::exp(-18.0f * (y - 0.5f) * (y - 0.5f));
        const float narrow = 1 - 0.1f * back - 0.06f * (1 - y);
        const float lift = curl * (0.028f + (arms ? 0.17f : 0.075f) * hips) * (1 - 0.4f * back);
        const float wrap = curl * (0.055f * back + (arms ? 0.1f : 0.03f) * hips * back);
        return Vec3f(-x * w * narrow, mid.x() + wrap, h + mid.y() + lift);
      },
      sheet);
  // Seen from above the parameter runs clockwise, so the sheet's top is the sitting side.
  b.Add(shell, Slot("shell", {"plastic", "wood", "leather", "paint"}));
  const bool dowels = p.leg_variant % 2 == 0;
  const MaterialSlot legs = dowels ? Slot("legs", {"wood"}) : MetalSlot("legs");
  const float foot = 0.21f, top = 0.12f, under = h - 0.032f;
  for (const float sx : {-1.0f, 1.0f}) {
    for (const float sy : {-1.0f, 1.0f}) {
      const Vec3f from(sx * foot * 1.05f, sy * foot - 0.02f, 0),
          to(sx * top, sy * top - 0.01f, under);
      b.Add(dowels ? Rod(from, to, 0.01f, 0.016f, 0.003f) : Rod(from, to, 0.009f, 0.009f, 0.003f),
            legs);
      b.Add(Cylinder(0.02f, 0.026f, 0.003f).Moved(to.x(), to.y(), under - 0.006f),
            MetalSlot("brace"));
    }
  }
  const auto wire = [&](const Vec3f& a, const Vec3f& c) {
    b.Add(Rod(a, c, 0.0045f, 0.0045f), MetalSlot("brace"));
  };
  const float low = 0.62f;
  const auto leg_at = [&](float sx, float sy, float t) {
    return Vec3f(Vec3f(sx * foot * 1.05f, sy * foot - 0.02f, 0) * (1 - t) +
                 Vec3f(sx * top, sy * top - 0.01f, under) * t);
  };
  for (const float s : {-1.0f, 1.0f}) {
    wire(leg_at(s, -1, low), leg_at(s, 1, 0.97f));
    wire(leg_at(s, 1, low), leg_at(s, -1, 0.97f));
    wire(leg_at(-1, s, low), leg_at(1, s, 0.97f));
    wire(leg_at(1, s, low), leg_at(-1, s, 0.97f));
  }
}

// One bent tube and two pads.
void BuildCantilever(AssetBuilder& b, const ChairParams& p, const Noise& noise) {
  const float w = 0.5f * p.width_m, d = 0.5f * p.depth_m, h = p.seat_height_m - 0.03f, r = 0.0125f;
  Path3 half{{w, -d - p.lean_m, p.back_height_m},
             {w, -d, h},
             {w, d, h},
             {w, d + 0.01f, r},
             {w, -d - 0.02f, r},
             {0, -d - 0.02f, r}};
  Path3 path = half;
  for (size_t i = half.size() - 1; i-- > 0;)
    path.emplace_back(-half[i].x(), half[i].y(), half[i].z());
  b.Add(Tube(Filleted(path, 0.07f, 7), r, 0.004f, 16), MetalSlot("frame"));
  for (const float y : {-0.6f * d, 0.55f * d})
    b.Add(Tube({{-w, y, h}, {w, y, h}}, 0.009f, 0, 12), MetalSlot("frame"));
  CushionOptions soft;
  soft.edge_radius_m = 0.016f;
  soft.bulge_top_m = 0.014f;
  soft.wrinkle_m = 0.0012f;
  soft.target_edge_m = 0.025f;
  const MaterialSlot seat = Slot("seat", {"leather", "fabric"});
  b.Add(Cushion({2 * w + 0.01f, 2 * d - 0.03f, 0.04f}, soft, noise).Moved(0, 0.01f, h + 0.025f),
        seat);
  const float lean = std::atan2(p.lean_m, p.back_height_m - h);
  const float height = 0.62f * (p.back_height_m - h);
  const Shape pad =
      Cushion({2 * w - 0.004f, height, 0.034f}, soft, noise).Bent([&](const Vec3f& q) {
        return Vec3f(q.x(), q.y(), q.z() + 0.25f * q.x() * q.x());
      });
  const float z = p.back_height_m - 0.5f * height - 0.01f;
  const float y = -d - p.lean_m * (z - h) / (p.back_height_m - h);
  b.Add(pad.TurnedX(-0.5f * kPi + lean).Moved(0, y, z), seat);
  if (!p.arms) return;
  const float az = h + 0.21f;
  const Path3 arm{{w, -d - p.lean_m * (az - h) / (p.back_height_m - h), az},
                  {w + 0.004f, d - 0.03f, az},
                  {w, d - 0.02f, h + 0.002f}};
  b.AddMirroredX(Tube(Filleted(arm, 0.06f, 6), 0.011f, 0, 14), MetalSlot("frame"));
  b.AddMirroredX(
      Board({w - 0.02f, -d + 0.06f, az + 0.006f}, {w + 0.024f, d - 0.07f, az + 0.028f}, 0.008f),
      Slot("armrest", {"wood", "plastic"}));
}

}  // namespace

Asset MakeChair(const ChairParams& p) {
  AssetBuilder b(p.seed);
  const Noise noise(p.seed);
  switch (p.style) {
    case ChairStyle::kWindsor:
      BuildWindsor(b, p);
      break;
    case ChairStyle::kShell:
      BuildShell(b, p, noise);
      break;
    case ChairStyle::kCantilever:
      BuildCantilever(b, p, noise);
      break;
    default: {
      const ChairFrame frame(p);
      AddBase(b, p, frame);
      AddSeat(b, p, frame, noise);
      AddBack(b, p, frame, noise);
      if (p.arms) AddArms(b, p, frame);
    }
  }
  return b.Finish();
}

Asset SampleChair(Rng& rng) {
  ChairParams p;
  p.style = DrawEnum<ChairStyle>(rng, static_cast<int>(ChairStyle::kCount));
  p.width_m = Draw(rng, 0.42, 0.5);
  p.depth_m = Draw(rng, 0.4, 0.47);
  p.seat_height_m = Draw(rng, 0.43, 0.475);
  p.back_height_m = Draw(rng, 0.82, 1.04);
  p.lean_m = Draw(rng, 0.05, 0.1);
  p.leg_m = Draw(rng, 0.03, 0.042);
  p.bow_m = Draw(rng, 0.015, 0.045);
  p.legs = DrawEnum<LegStyle>(rng, static_cast<int>(LegStyle::kCount));
  p.leg_variant = rng.UniformInt(0, 11);
  p.back_parts = rng.UniformInt(3, 6);
  p.arms = rng.Bernoulli(0.28);
  p.cushion = rng.Bernoulli(0.45) || p.style == ChairStyle::kUpholstered;
  p.stretchers = rng.Bernoulli(0.6);
  if (p.style == ChairStyle::kShell || p.style == ChairStyle::kCantilever)
    p.back_height_m = Draw(rng, 0.78, 0.86);
  p.seed = rng.Seed();
  return MakeChair(p);
}

void RegisterChairs(std::vector<AssetClass>& classes) {
  classes.push_back({"Chair", "seating", Placement::kFloor, true, 0.4f, SampleChair});
  classes.push_back({"OfficeChair", "seating", Placement::kFloor, true, 0.4f, SampleOfficeChair});
  classes.push_back({"BarChair", "seating", Placement::kFloor, true, 0.3f, SampleBarChair});
}

}  // namespace parallax
