// Seats for one person without thick upholstery: dining chairs, office chairs, bar stools.
#include <algorithm>
#include <cmath>

#include "worker/assets/asset_families.h"
#include "worker/assets/furniture/chair_kinds.h"

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

void AddChairSeat(AssetBuilder& b, const ChairParams& p, const ChairFrame& f, const Noise& noise) {
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
  Shape board = RoundedBox(size, {.bevel_m = 0.007f, .bevel_steps = 2, .pieces = {14, 14, 1}});
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

// Whether the legs are round, which asks for round rungs.
bool RoundLegs(const ChairParams& p) {
  return p.legs == LegStyle::kTurned || p.legs == LegStyle::kRound;
}

float UndersideOf(const ChairParams& p, const ChairFrame& f) {
  return f.seat_top - (p.cushion ? 0.04f : kSeatBoard);
}

void AddFrontLegs(AssetBuilder& b, const ChairParams& p, const ChairFrame& f) {
  const MaterialSlot wood = WoodSlot("frame");
  const float under = UndersideOf(p, f), t = p.leg_m;
  if (!RoundLegs(p)) {
    b.AddMirroredX(
        FurnitureLeg(p.legs, {f.front_x, f.front_y, 0}, {f.front_x, f.front_y, under}, t, 0), wood);
    return;
  }
  // The joint with the aprons stays square above the turning.
  const float block = 0.075f;
  b.AddMirroredX(Board({f.front_x - 0.5f * t, f.front_y - 0.5f * t, under - block},
                       {f.front_x + 0.5f * t, f.front_y + 0.5f * t, under}, 0.003f),
                 wood);
  b.AddMirroredX(FurnitureLeg(p.legs, {f.front_x, f.front_y, 0},
                              {f.front_x, f.front_y, under - block + 0.004f}, t, p.leg_variant),
                 wood);
}

// Back legs run on as posts.
void AddBackPosts(AssetBuilder& b, const ChairParams& p, const ChairFrame& f) {
  Path3 post;
  for (int i = 0; i <= 18; ++i) {
    const float z = p.back_height_m * static_cast<float>(i) / 18.0f;
    post.emplace_back(f.back_x, f.post_y(z), z);
  }
  SweepOptions options{.end_round_m = 0.006f, .up = Vec3f::UnitY(), .keep_up = true};
  const float seat_t = f.seat_top / p.back_height_m;
  const auto taper = SmoothThrough({{0.0f, 0.62f}, {seat_t, 1.0f}, {1.0f, 0.66f}});
  options.scale = [=](float s) { return Vec2f(0.5f + 0.5f * taper(s), taper(s)); };
  const Path2 section = RectSection(0.85f * p.leg_m, p.leg_m, RoundLegs(p) ? 0.012f : 0.005f, 3);
  b.AddMirroredX(Sweep(post, section, options), WoodSlot("frame"));
}

void AddAprons(AssetBuilder& b, const ChairParams& p, const ChairFrame& f) {
  const MaterialSlot wood = WoodSlot("frame");
  const float under = UndersideOf(p, f), low = under - 0.06f, half = 0.009f;
  b.Add(Board({-f.front_x, f.front_y - half, low}, {f.front_x, f.front_y + half, under}), wood);
  b.Add(Board({-f.back_x, f.back_y - half, low}, {f.back_x, f.back_y + half, under}), wood);
  b.AddMirroredX(
      Bar({f.back_x, f.back_y, 0.5f * (low + under)}, {f.front_x, f.front_y, 0.5f * (low + under)},
          {2 * half, under - low}, {2 * half, under - low}, 0.002f),
      wood);
}

// Rungs between the legs: at the sides, and one across the middle or two across the ends.
void AddStretchers(AssetBuilder& b, const ChairParams& p, const ChairFrame& f) {
  const MaterialSlot wood = WoodSlot("frame");
  const float z = 0.14f + 0.03f * static_cast<float>(p.leg_variant % 3), t = p.leg_m;
  const float yb = f.post_y(z);
  const auto rung = [&](const Vec3f& a, const Vec3f& c) {
    return RoundLegs(p) ? Rod(a, c, 0.26f * t, 0.26f * t)
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

void AddChairArms(AssetBuilder& b, const ChairParams& p, const ChairFrame& f) {
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

// The back between the posts: from `low` to `top`, `half` wide at each side.
struct ChairBack {
  ChairBack(const ChairParams& params, const ChairFrame& frame)
      : p(params),
        f(frame),
        low(frame.seat_top + 0.1f),
        top(params.back_height_m),
        half(frame.back_x) {}

  // A rail from post to post; `z` is the height of its middle.
  void AddRail(AssetBuilder& b, float z, float height, float bow, float thickness) const {
    b.Add(BowedRail(half, bow, thickness, height, z, f.post_y(z), f.Lean(z)), wood);
  }
  // Where the bow of the back is at (x, z).
  float BowedY(float x, float z) const {
    const float s = x / half;
    return f.post_y(z) - p.bow_m * (1 - s * s);
  }

  const ChairParams& p;
  const ChairFrame& f;
  const float low, top, half;
  const MaterialSlot wood = WoodSlot("frame");
};

void AddLadderBack(AssetBuilder& b, const ChairBack& back) {
  const int n = std::clamp(back.p.back_parts, 3, 5);
  for (int i = 0; i < n; ++i) {
    const float t = static_cast<float>(i) / static_cast<float>(n - 1);
    const float z = Lerp(back.low + 0.02f, back.top - 0.045f, t);
    back.AddRail(b, z, Lerp(0.045f, 0.07f, t), back.p.bow_m, 0.014f);
  }
}

void AddUpholsteredBack(AssetBuilder& b, const ChairBack& back, const Noise& noise) {
  const float top = back.top, low = back.low;
  back.AddRail(b, top - 0.02f, 0.04f, 0.0f, 0.022f);
  back.AddRail(b, low - 0.02f, 0.035f, 0.0f, 0.02f);
  CushionOptions soft;
  soft.edge_radius_m = 0.016f;
  soft.bulge_top_m = 0.016f;
  soft.bulge_side_m = 0.0f;
  soft.wrinkle_m = 0.0012f;
  soft.target_edge_m = 0.025f;
  if (back.p.back_parts > 5) {
    soft.tufts_x = 3;
    soft.tufts_y = 3;
    soft.tuft_depth_m = 0.012f;
  }
  const float height = top - low - 0.03f, mid = 0.5f * (top - 0.035f + low);
  const Shape pad = Cushion({2 * back.half - 0.4f * back.p.leg_m, height, 0.04f}, soft, noise);
  b.Add(pad.TurnedX(-0.5f * kPi + back.f.Lean(mid)).Moved(0, back.f.post_y(mid) + 0.004f, mid),
        FabricSlot("seat"));
}

void AddCrossedBack(AssetBuilder& b, const ChairBack& back) {
  const float top = back.top, low = back.low;
  back.AddRail(b, top - 0.035f, 0.07f, back.p.bow_m, 0.02f);
  back.AddRail(b, low, 0.035f, back.p.bow_m, 0.018f);
  for (const float side : {-1.0f, 1.0f}) {
    Path3 path;
    for (int i = 0; i <= 12; ++i) {
      const float t = static_cast<float>(i) / 12.0f;
      const float x = side * Lerp(-0.92f, 0.92f, t) * back.half,
                  z = Lerp(low + 0.01f, top - 0.06f, t);
      path.emplace_back(x, back.BowedY(x, z) + 0.004f * side, z);
    }
    b.Add(Sweep(path, RectSection(0.026f, 0.014f, 0.003f, 2),
                {.up = Vec3f::UnitY(), .keep_up = true}),
          back.wood);
  }
}

// Slats or spindles between two rails.
void AddUprightBack(AssetBuilder& b, const ChairBack& back, bool slats) {
  const float top = back.top, low = back.low;
  back.AddRail(b, top - 0.035f, 0.075f, back.p.bow_m, 0.022f);
  back.AddRail(b, low, 0.035f, back.p.bow_m, 0.018f);
  const int n = slats ? std::min(back.p.back_parts, 5) : back.p.back_parts + 2;
  const auto at = [&](float x, float z) { return Vec3f(x, back.BowedY(x, z), z); };
  for (int i = 0; i < n; ++i) {
    const float x =
        0.9f * back.half * ((2.0f * static_cast<float>(i) + 1) / static_cast<float>(n) - 1);
    if (slats) {
      const float width = 1.05f * back.half / static_cast<float>(n);
      b.Add(Bar(at(x, low), at(x, top - 0.04f), {width, 0.01f}, {1.1f * width, 0.01f}, 0.003f,
                Vec3f::UnitY()),
            back.wood);
    } else {
      b.Add(Rod(at(x, low), at(x, top - 0.05f), 0.0075f, 0.0065f), back.wood);
    }
  }
}

void AddChairBack(AssetBuilder& b, const ChairBack& back, const Noise& noise) {
  switch (back.p.style) {
    case ChairStyle::kLadder:
      return AddLadderBack(b, back);
    case ChairStyle::kUpholstered:
      return AddUpholsteredBack(b, back, noise);
    case ChairStyle::kCrossed:
      return AddCrossedBack(b, back);
    default:
      return AddUprightBack(b, back, back.p.style == ChairStyle::kSlat);
  }
}

Asset MakeChair(const ChairParams& p) {
  AssetBuilder b(p.seed);
  const Noise noise(p.seed);
  switch (p.style) {
    case ChairStyle::kWindsor:
      AddWindsorChair(b, p);
      break;
    case ChairStyle::kShell:
      AddShellChair(b, p);
      break;
    case ChairStyle::kCantilever:
      AddCantileverChair(b, p, noise);
      break;
    default: {
      const ChairFrame frame(p);
      AddFrontLegs(b, p, frame);
      AddBackPosts(b, p, frame);
      AddAprons(b, p, frame);
      if (p.stretchers) AddStretchers(b, p, frame);
      AddChairSeat(b, p, frame, noise);
      AddChairBack(b, ChairBack(p, frame), noise);
      if (p.arms) AddChairArms(b, p, frame);
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

}  // namespace

void RegisterChairs(std::vector<AssetClass>& classes) {
  classes.push_back({"Chair", "seating", Placement::kFloor, true, 0.4f, SampleChair,
                     SizeRange({0.38f, 0.38f, 0.72f}, {0.66f, 0.7f, 1.15f})});
  classes.push_back({"OfficeChair", "seating", Placement::kFloor, true, 0.4f, SampleOfficeChair,
                     SizeRange({0.55f, 0.55f, 0.85f}, {0.8f, 0.85f, 1.4f})});
  classes.push_back({"BarChair", "seating", Placement::kFloor, true, 0.3f, SampleBarChair,
                     SizeRange({0.3f, 0.3f, 0.58f}, {0.55f, 0.55f, 1.1f})});
}

}  // namespace parallax
