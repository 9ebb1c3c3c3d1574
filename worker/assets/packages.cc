#include "worker/assets/packages.h"

#include <algorithm>
#include <cmath>

#include "worker/assets/vessel_parts.h"

namespace parallax {
namespace {

using namespace kernel;  // NOLINT: the modelling vocabulary of this folder.

const MaterialSlot& Tinplate() {
  static const MaterialSlot& slot = *new MaterialSlot(Slot("metal", {"metal"}));
  return slot;
}

// A ring to pull on a lid whose top is at z, and its rivet.
Shape RingPull(float z, float lift_rad) {
  Path3 ring;
  for (int k = 0; k < 20; ++k) {
    const float a = 2 * kPi * static_cast<float>(k) / 20.0f;
    ring.emplace_back(0.008f * std::cos(a), 0.0105f * std::sin(a) + 0.0105f, 0);
  }
  Shape out = Ring(ring, 0.0013f, 8).TurnedX(lift_rad).Moved(0, -0.0065f, z + 0.0012f);
  out.Add(Cylinder(0.003f, 0.0026f, 0.0006f, 12).Moved(0, -0.0065f, z - 0.0012f));
  return out;
}

// Aluminium, necked in at both ends.
Path2 DrinkProfile(float r, float h, float p0, float p1) {
  return {{0, 0.006f},
          {0.5f * r, 0.005f},
          {0.7f * r, 0.001f},
          {0.74f * r, 0},
          {0.78f * r, 0.001f},
          {0.96f * r, 0.008f},
          {r, p0},
          {r, p1},
          {0.97f * r, h - 0.011f},
          {0.82f * r, h - 0.003f},
          {0.83f * r, h - 0.001f},
          {0.81f * r, h},
          {0.78f * r, h - 0.001f},
          {0.77f * r, h - 0.006f},
          {0, h - 0.0062f}};
}

// Tinplate: seamed rims, beads round the body.
Path2 TinProfile(float r, float h, float p0, float p1, int beads, bool open) {
  Path2 profile{{0, 0.003f},           {r - 0.002f, 0.003f}, {r - 0.001f, 0}, {r + 0.001f, 0.0005f},
                {r + 0.0012f, 0.003f}, {r, 0.0045f},         {r, p0}};
  for (int k = 1; k <= 6 * beads; ++k) {
    const float s = static_cast<float>(k) / static_cast<float>(6 * beads);
    const float wave = 0.5f - 0.5f * std::cos(2 * kPi * s * static_cast<float>(beads));
    profile.emplace_back(r - 0.0007f * wave, Lerp(p0, p1, s));
  }
  if (beads == 0) profile.emplace_back(r, p1);
  for (const Vec2f& q : Path2{{r, h - 0.0045f},
                              {r + 0.0012f, h - 0.003f},
                              {r + 0.001f, h - 0.0005f},
                              {r - 0.001f, h},
                              {r - 0.002f, h - 0.003f}})
    profile.push_back(q);
  if (open) {
    profile.emplace_back(r - 0.002f, 0.7f * h);
    profile.emplace_back(0, 0.7f * h);
  } else {
    profile.emplace_back(0.8f * r, h - 0.0032f);
    profile.emplace_back(0.76f * r, h - 0.002f);
    profile.emplace_back(0, h - 0.0021f);
  }
  return profile;
}

// The lid of an opened tin, held by the last bit of its seam at the back.
Shape BentLid(float r, float h) {
  const Shape lid = Lathe(Path2{{0, 0},
                                {0.74f * r, 0},
                                {0.8f * r, -0.001f},
                                {0.95f * r, 0},
                                {0.96f * r, 0.0006f},
                                {0.8f * r, -0.0002f},
                                {0.74f * r, 0.0008f},
                                {0, 0.0008f}});
  return lid
      .Bent([&](const Vec3f& q) {
        const float s = (q.y() + r) / (2 * r);
        return Vec3f(q.x(), q.y(), q.z() + 0.12f * r * std::sin(kPi * s));
      })
      .Moved(0, 0.97f * r, 0)
      .TurnedX(1.1f)
      .Moved(0, -0.97f * r, h - 0.0015f);
}

void AddFishTin(AssetBuilder& b, const CanParams& p) {
  const float w = 2 * p.radius_m, d = 0.62f * w, h = p.height_m;
  Shape body = Extrude(RectSection(w, d, 0.3f * d, 8), h - 0.002f, 0.002f).Moved(0, 0, 0.001f);
  PrintFaces(body, Vec3f::UnitZ(), Vec3f::UnitX(), Vec3f::UnitY(), 1);
  b.Add(body, {Tinplate(), PictureSlot("label")});
  for (const float z : {0.0015f, h - 0.0015f}) {
    Path3 seam;
    for (const Vec2f& q : RectSection(w, d, 0.3f * d, 8)) seam.emplace_back(q.x(), q.y(), z);
    b.Add(Ring(seam, 0.0015f, 8), Tinplate());
  }
  b.Add(RingPull(h + 0.0003f, p.opened ? 0.9f : 0.12f).TurnedZ(-0.5f * kPi).Moved(0.34f * w, 0, 0),
        Tinplate());
}

void AddSprayCan(AssetBuilder& b, const CanParams& p) {
  const float r = p.radius_m, h = p.height_m, p0 = 0.006f, p1 = 0.72f * h;
  const Path2 profile{{0, 0.008f},
                      {0.8f * r, 0.003f},
                      {r - 0.001f, 0},
                      {r + 0.0012f, 0.002f},
                      {r, p0},
                      {r, p1},
                      {r + 0.001f, p1 + 0.001f},
                      {0.99f * r, p1 + 0.003f},
                      {0.62f * r, p1 + 0.016f},
                      {0.6f * r, p1 + 0.02f},
                      {0, p1 + 0.02f}};
  LatheOptions options;
  options.segments = 56;
  options.print_from_z = p0;
  options.print_to_z = p1;
  options.print_repeats = LabelCopies(r, p1 - p0);
  b.Add(Lathe(profile, options), {Tinplate(), PictureSlot("label")});
  const MaterialSlot plastic = PlasticSlot("cap");
  if (p.opened) {
    // The nozzle.
    b.Add(Cylinder(0.0045f, 0.02f, 0.001f).Moved(0, 0, p1 + 0.016f), Tinplate());
    b.Add(Lathe(Filleted(Path2{{0, 0}, {0.008f, 0}, {0.0075f, 0.014f}, {0, 0.016f}}, 0.002f, 3))
              .Moved(0, 0, p1 + 0.026f),
          plastic);
    b.Add(Rod({0, 0.004f, p1 + 0.034f}, {0, 0.0095f, p1 + 0.034f}, 0.002f, 0.0015f), plastic);
  } else {
    b.Add(Lathe(Filleted(Path2{{0, 0}, {0.9f * r, 0}, {0.86f * r, h - p1 - 0.004f}, {0, h - p1}},
                         0.006f, 5))
              .Moved(0, 0, p1 + 0.0045f),
          plastic);
  }
}

// A picture over the large faces of a box, parts of it over the narrow ones.
void PrintCarton(Shape& carton, float width, float depth) {
  PrintFaces(carton, Vec3f::UnitY(), -Vec3f::UnitX(), Vec3f::UnitZ(), 1);
  PrintFaces(carton, -Vec3f::UnitY(), Vec3f::UnitX(), Vec3f::UnitZ(), 2);
  PrintFaces(carton, Vec3f::UnitX(), Vec3f::UnitY(), Vec3f::UnitZ(), 3);
  PrintFaces(carton, -Vec3f::UnitX(), -Vec3f::UnitY(), Vec3f::UnitZ(), 4);
  const float share = std::min(1.0f, depth / width);
  for (Face& f : carton.faces) {
    if (f.group < 3) continue;
    for (Vec2f& q : f.uv) q.x() *= share;
  }
}

void AddCarton(AssetBuilder& b, const Shape& carton) {
  const MaterialSlot front = PictureSlot("front");
  b.Add(carton, {Slot("card", {"paper"}), front, front, front, front});
}

// Card bulges a little and is never quite flat. Centred on the origin.
Shape CardBox(const Vec3f& size, const Noise& noise) {
  BoxOptions box;
  box.bevel_m = 0.0012f;
  box.pieces = {8, 4, 10};
  return RoundedBox(size, box).Bent([&](const Vec3f& q) {
    const Vec3f u = 2 * q.cwiseQuotient(size);
    const float dome = std::max(0.0f, 1 - u.x() * u.x()) * std::max(0.0f, 1 - u.z() * u.z());
    return Vec3f(q.x(), q.y() + u.y() * 0.003f * dome + 0.0012f * noise.At(q * 14) * dome, q.z());
  });
}

// A flap hinged at the upper back edge of a box whose top is at z.
void AddFlap(AssetBuilder& b, const FoodBoxParams& p, float z) {
  SheetOptions sheet;
  sheet.pieces_u = 6;
  sheet.pieces_v = 4;
  sheet.thickness_m = 0.0008f;
  sheet.round_rim = false;
  sheet.size_m = {p.width_m, 0.9f * p.depth_m};
  b.Add(Sheet(
            [&](float u, float v) {
              const float reach = 0.9f * p.depth_m * v;
              return Vec3f((u - 0.5f) * (p.width_m - 0.002f),
                           -0.5f * p.depth_m + reach * std::cos(p.flap_rad),
                           z - 0.0005f + reach * std::sin(p.flap_rad) - 0.004f * v * v);
            },
            sheet),
        Slot("card", {"paper"}));
}

// A milk carton: the walls run together to a ridge with a crimped fin; a screw cap on the slope.
void AddGableCarton(AssetBuilder& b, const FoodBoxParams& p, const Noise& noise) {
  const float w = p.width_m, h = p.height_m, roof = 0.42f * w;
  BoxOptions box;
  box.bevel_m = 0.0015f;
  box.pieces = {6, 8, 12};
  Shape carton = RoundedBox({w, w, h + roof}, box).Moved(0, 0, 0.5f * (h + roof));
  carton = carton.Bent([&](const Vec3f& q) {
    const float t = std::clamp((q.z() - h) / roof, 0.0f, 1.0f);
    const float dome = 0.002f * Smooth01(3 * q.z() / h) * (1 - t);
    // The side walls fold inwards between the slopes.
    const float tuck = 0.28f * w * t * (1 - std::abs(2 * q.y() / w));
    const float x = q.x() - std::copysign(std::min(std::abs(q.x()), tuck), q.x());
    return Vec3f(x + 0.0008f * noise.At(q * 12),
                 q.y() * (1 - 0.96f * t) + dome * (q.y() > 0 ? 1.0f : -1.0f) * (1 - t), q.z());
  });
  PrintCarton(carton, w, w);
  AddCarton(b, carton);
  b.Add(Board({-0.497f * w, -0.0016f, h + roof - 0.006f}, {0.497f * w, 0.0016f, h + roof + 0.016f},
              0.0006f),
        Slot("card", {"paper"}));
  const float lean = std::atan2(0.48f * w, roof);
  LatheOptions knurl;
  knurl.segments = 72;
  knurl.modulate = [](float a, float) { return 1 + 0.012f * std::cos(24 * a); };
  b.Add(
      Lathe(Filleted(Path2{{0, 0}, {0.016f, 0}, {0.0155f, 0.012f}, {0, 0.012f}}, 0.0012f, 2), knurl)
          .TurnedX(-lean)
          .Moved(0, 0.25f * w, h + 0.5f * roof),
      PlasticSlot("cap"));
}

// An open tray of card with a film over what lies in it.
void AddTray(AssetBuilder& b, const FoodBoxParams& p, Rng& rng) {
  const float w = 0.5f * p.width_m, d = 0.5f * p.height_m, h = p.depth_m, t = 0.0016f;
  const MaterialSlot card = Slot("card", {"paper", "plastic"});
  const Path2 outer = RectSection(2 * w, 2 * d, 0.012f, 4);
  b.Add(Extrude(outer, t, 0.0005f), card);
  Path3 wall;
  for (const Vec2f& q : outer) wall.emplace_back(0.985f * q.x(), 0.985f * q.y(), 0.5f * h);
  SweepOptions closed;
  closed.closed = true;
  closed.keep_up = true;
  closed.up = Vec3f::UnitZ();
  b.Add(Sweep(wall, RectSection(t, h - 0.001f, 0.0004f, 1), closed), card);
  Path3 rim;
  for (const Vec2f& q : outer) rim.emplace_back(q.x(), q.y(), h - 0.001f);
  b.Add(Sweep(rim, RectSection(0.012f, 0.0016f, 0.0006f, 1), closed), card);
  // Biscuits, sausages, tomatoes: rows of one thing.
  const int rows = rng.UniformInt(2, 4), columns = rng.UniformInt(3, 5);
  const Vec2f pitch(1.86f * w / static_cast<float>(columns), 1.86f * d / static_cast<float>(rows));
  const float r = 0.49f * std::min(pitch.x(), pitch.y()), high = std::min(0.9f * h, 1.6f * r);
  const bool round = rng.Bernoulli(0.5);
  for (int i = 0; i < columns; ++i) {
    for (int j = 0; j < rows; ++j) {
      const float x = pitch.x() * (static_cast<float>(i) - 0.5f * static_cast<float>(columns - 1)),
                  y = pitch.y() * (static_cast<float>(j) - 0.5f * static_cast<float>(rows - 1));
      const Shape each = round ? Ellipsoid({r, r, 0.5f * high}, 20).Moved(0, 0, 0.5f * high)
                               : Cylinder(r, 0.5f * high, 0.15f * r, 24);
      b.Add(each.TurnedZ(Draw(rng, 0, 6)).Moved(x, y, t - 0.0004f),
            Slot("food", {"food", "paper"}));
    }
  }
}

// Front and back of a bag on one grid of (u across, v up), joined at the sides; picture on both.
Shape BagShape(const std::function<Vec3f(float u, float v, bool back)>& at, int nu, int nv) {
  Shape bag;
  std::vector<uint32_t> front, back;
  for (int side = 0; side < 2; ++side) {
    for (int j = 0; j <= nv; ++j) {
      for (int i = 0; i <= nu; ++i) {
        const bool rim = i == 0 || i == nu;
        std::vector<uint32_t>& ids = side ? back : front;
        if (side && rim) {
          ids.push_back(front[static_cast<size_t>(j * (nu + 1) + i)]);
          continue;
        }
        const float u = 2 * static_cast<float>(i) / static_cast<float>(nu) - 1,
                    v = static_cast<float>(j) / static_cast<float>(nv);
        Vec3f p = at(u, v, side == 1);
        if (rim) p.y() = 0.5f * (p.y() + at(u, v, true).y());
        ids.push_back(bag.AddPoint(p, {p.x(), p.z(), p.y()}));
      }
    }
  }
  const auto id = [&](int i, int j) { return static_cast<size_t>(j * (nu + 1) + i); };
  const auto uv = [&](int a, int c) {
    return Vec2f(static_cast<float>(a) / static_cast<float>(nu),
                 static_cast<float>(c) / static_cast<float>(nv));
  };
  for (int j = 0; j < nv; ++j) {
    for (int i = 0; i < nu; ++i) {
      bag.AddQuad(front[id(i, j)], front[id(i + 1, j)], front[id(i + 1, j + 1)],
                  front[id(i, j + 1)], 1);
      bag.faces.back().uv = {uv(i, j), uv(i + 1, j), uv(i + 1, j + 1), uv(i, j + 1)};
      bag.AddQuad(back[id(i, j)], back[id(i, j + 1)], back[id(i + 1, j + 1)], back[id(i + 1, j)],
                  1);
      bag.faces.back().uv = {uv(nu - i, j), uv(nu - i, j + 1), uv(nu - i - 1, j + 1),
                             uv(nu - i - 1, j)};
    }
  }
  for (int i = 0; i < nu; ++i) {
    bag.AddQuad(front[id(i + 1, 0)], front[id(i, 0)], back[id(i, 0)], back[id(i + 1, 0)]);
    bag.AddQuad(front[id(i, nv)], front[id(i + 1, nv)], back[id(i + 1, nv)], back[id(i, nv)]);
  }
  bag.crease_rad = 1.0f;
  return bag;
}

}  // namespace

Asset MakeCan(const CanParams& p) {
  AssetBuilder b(p.seed);
  const float r = p.radius_m, h = p.height_m;
  if (p.style == CanStyle::kFishTin) {
    AddFishTin(b, p);
    return b.Finish();
  }
  if (p.style == CanStyle::kSpray) {
    AddSprayCan(b, p);
    return b.Finish();
  }
  const bool drink = p.style == CanStyle::kDrink || p.style == CanStyle::kSlimDrink;
  LatheOptions options;
  options.segments = 56;
  options.print_from_z = drink ? 0.012f : 0.006f;
  options.print_to_z = drink ? h - 0.016f : h - 0.006f;
  options.print_repeats = LabelCopies(r, options.print_to_z - options.print_from_z);
  const int beads = p.style == CanStyle::kFlatTin ? 0 : 9;
  const Path2 profile =
      drink ? DrinkProfile(r, h, options.print_from_z, options.print_to_z)
            : TinProfile(r, h, options.print_from_z, options.print_to_z, beads, p.opened);
  b.Add(Lathe(profile, options), {Tinplate(), PictureSlot("label")});
  if (drink) {
    b.Add(RingPull(h - 0.006f, p.opened ? 1.1f : 0.05f), Tinplate());
  } else if (p.opened) {
    b.Add(BentLid(r, h), Tinplate());
  } else {
    b.Add(RingPull(h - 0.0018f, 0.06f), Tinplate());
  }
  return b.Finish();
}

Asset SampleCan(Rng& rng) {
  CanParams p;
  p.style = DrawEnum<CanStyle>(rng, static_cast<int>(CanStyle::kCount));
  switch (p.style) {
    case CanStyle::kDrink:
      p.height_m = Draw(rng, 0.098, 0.165);
      break;
    case CanStyle::kSlimDrink:
      p.radius_m = Draw(rng, 0.0265, 0.03);
      p.height_m = Draw(rng, 0.125, 0.158);
      break;
    case CanStyle::kTin:
      p.radius_m = Draw(rng, 0.034, 0.052);
      p.height_m = p.radius_m * Draw(rng, 1.7, 2.9);
      break;
    case CanStyle::kFlatTin:
      p.radius_m = Draw(rng, 0.037, 0.055);
      p.height_m = Draw(rng, 0.034, 0.056);
      break;
    case CanStyle::kFishTin:
      p.radius_m = Draw(rng, 0.05, 0.058);
      p.height_m = Draw(rng, 0.022, 0.032);
      break;
    default:
      p.radius_m = Draw(rng, 0.024, 0.034);
      p.height_m = Draw(rng, 0.15, 0.22);
  }
  p.opened = rng.Bernoulli(0.3);
  p.seed = rng.Seed();
  return MakeCan(p);
}

Asset MakeFoodBox(const FoodBoxParams& p) {
  AssetBuilder b(p.seed);
  Rng rng(SceneSeed{p.seed}, "food box");
  const Noise noise(rng);
  switch (p.style) {
    case FoodBoxStyle::kGable:
      AddGableCarton(b, p, noise);
      break;
    case FoodBoxStyle::kTray:
      AddTray(b, p, rng);
      break;
    case FoodBoxStyle::kSlab: {
      // Lies on its back: chocolates, pizza, frozen fish.
      Shape slab = CardBox({p.width_m, p.depth_m, p.height_m}, noise);
      PrintCarton(slab, p.width_m, p.depth_m);
      slab = slab.TurnedX(0.5f * kPi);
      AddCarton(b, slab);
      break;
    }
    default: {
      Shape carton = CardBox({p.width_m, p.depth_m, p.height_m}, noise);
      PrintCarton(carton, p.width_m, p.depth_m);
      AddCarton(b, carton);
      const float top = 0.5f * p.height_m;
      if (p.style == FoodBoxStyle::kBrick) {
        // A juice pack: ears folded down at the sides, a straw or a cap.
        b.Add(Board({-0.5f * p.width_m + 0.002f, -0.001f, top - 0.001f},
                    {0.5f * p.width_m - 0.002f, 0.001f, top + 0.0022f}, 0.0006f),
              Slot("card", {"paper"}));
        if (p.flap_rad > 0.6f) {
          const Vec3f in(0.25f * p.width_m, 0.2f * p.depth_m, top - 0.004f);
          b.Add(
              Tube(Filleted(Path3{in, in + Vec3f(0.002f, 0, 0.045f), in + Vec3f(-0.03f, 0, 0.08f)},
                            0.01f, 4),
                   0.0026f, 0, 12),
              PlasticSlot("straw"));
        } else {
          b.Add(Cylinder(0.012f, 0.012f, 0.0015f).Moved(0.22f * p.width_m, 0, top - 0.001f),
                PlasticSlot("straw"));
        }
      } else if (p.flap_rad > 0) {
        AddFlap(b, p, top);
      }
    }
  }
  return b.Finish();
}

Asset SampleFoodBox(Rng& rng) {
  FoodBoxParams p;
  p.style = DrawEnum<FoodBoxStyle>(rng, static_cast<int>(FoodBoxStyle::kCount));
  switch (p.style) {
    case FoodBoxStyle::kGable:
      p.width_m = p.depth_m = Draw(rng, 0.068, 0.096);
      p.height_m = p.width_m * Draw(rng, 1.5, 2.2);
      break;
    case FoodBoxStyle::kTray:
      p.width_m = Draw(rng, 0.14, 0.22);
      p.height_m = p.width_m * Draw(rng, 0.6, 0.85);
      p.depth_m = Draw(rng, 0.03, 0.06);
      break;
    case FoodBoxStyle::kSlab:
      p.width_m = Draw(rng, 0.16, 0.3);
      p.height_m = p.width_m * Draw(rng, 0.55, 1.0);
      p.depth_m = Draw(rng, 0.025, 0.05);
      break;
    case FoodBoxStyle::kBrick:
      p.width_m = Draw(rng, 0.06, 0.1);
      p.depth_m = p.width_m * Draw(rng, 0.6, 0.75);
      p.height_m = p.width_m * Draw(rng, 1.4, 2.3);
      break;
    default:
      p.width_m = Draw(rng, 0.12, 0.21);
      p.depth_m = p.width_m * Draw(rng, 0.25, 0.5);
      p.height_m = p.width_m * Draw(rng, 1.1, 1.6);
  }
  p.flap_rad = rng.Bernoulli(0.5) ? Draw(rng, 0.5, 1.3) : 0.0f;
  p.seed = rng.Seed();
  return MakeFoodBox(p);
}

Asset MakeFoodBag(const FoodBagParams& p) {
  AssetBuilder b(p.seed);
  Rng rng(SceneSeed{p.seed}, "food bag");
  const Noise noise(rng);
  const float w = p.width_m, h = p.height_m, t = p.belly_m;
  const bool stands = p.style != FoodBagStyle::kPillow;
  const float top = p.style == FoodBagStyle::kRolled ? 0.82f : 1.0f;
  const Shape bag = BagShape(
      [&](float u, float v, bool back) {
        // How thick the bag is at this height: closed by seams at both ends, or standing on a flat
        // bottom.
        const float s = std::clamp((v - 0.045f) / 0.91f, 0.0f, 1.0f);
        float belly = std::pow(std::max(0.0f, std::sin(kPi * s)), 0.55f);
        float across = std::sqrt(std::max(0.0f, 1 - u * u));
        if (stands) belly = std::pow(std::max(0.0f, std::cos(0.5f * kPi * v)), 0.6f);
        if (p.style == FoodBagStyle::kBlock || p.style == FoodBagStyle::kRolled) {
          belly = std::max(0.02f, 1 - std::pow(v / top, 6.0f));
          across = std::pow(std::max(0.0f, 1 - std::pow(std::abs(u), 9.0f)), 0.5f);
        }
        const float narrow = stands ? 1 - 0.05f * belly : 1 - 0.16f * belly;
        const float crimp = v > 0.95f || (!stands && v < 0.05f) ? 0.0012f * std::sin(60 * u) : 0;
        const float puff = 0.5f * t * belly * across;
        const float crease =
            0.006f * belly * noise.Ridges({u * w * 9, v * 9, back ? 3.0f : 8.0f}) * across +
            0.004f * (1 - belly) * noise.At({u * w * 30, v * 5, 1});
        float y = (back ? -1.0f : 1.0f) * std::max(0.0006f, puff - crease) + crimp;
        float z = h * v;
        if (p.style == FoodBagStyle::kRolled && v > top) {
          // The empty end is rolled down to the front; front and back turn with it.
          const float a = 5.5f * (v - top) / (1 - top), r = 0.011f + 0.0022f * a, off = y;
          y = r * (1 - std::cos(a)) + off * std::cos(a);
          z = h * top + r * std::sin(a) - off * std::sin(a);
        }
        return Vec3f(-0.5f * w * u * narrow, y, z);
      },
      36, p.style == FoodBagStyle::kRolled ? 72 : 44);
  b.Add(bag, {Slot("foil", {"plastic", "metal", "paper"}), PictureSlot("front")});
  if (p.spout) {
    b.Add(Cylinder(0.008f, 0.02f, 0.001f).Moved(0, 0, h - 0.008f), PlasticSlot("spout"));
    b.Add(Cylinder(0.0125f, 0.016f, 0.002f).Moved(0, 0, h + 0.006f), PlasticSlot("cap"));
  }
  if (p.style == FoodBagStyle::kRolled) {
    // A clip over the roll.
    b.Add(Bar({-0.36f * w, 0.03f, h * top + 0.006f}, {0.36f * w, 0.03f, h * top + 0.006f},
              {0.008f, 0.012f}, {0.008f, 0.012f}, 0.003f),
          PlasticSlot("clip"));
  }
  return b.Finish();
}

Asset SampleFoodBag(Rng& rng) {
  FoodBagParams p;
  p.style = DrawEnum<FoodBagStyle>(rng, static_cast<int>(FoodBagStyle::kCount));
  p.width_m = Draw(rng, 0.13, 0.22);
  p.height_m = p.width_m * Draw(rng, 1.2, 1.6);
  p.belly_m = p.width_m * Draw(rng, 0.3, 0.42);
  if (p.style == FoodBagStyle::kBlock || p.style == FoodBagStyle::kRolled) {
    p.width_m = Draw(rng, 0.09, 0.15);
    p.height_m = p.width_m * Draw(rng, 1.7, 2.3);
    p.belly_m = p.width_m * Draw(rng, 0.55, 0.75);
  }
  p.spout = p.style == FoodBagStyle::kPouch && rng.Bernoulli(0.5);
  p.seed = rng.Seed();
  return MakeFoodBag(p);
}

}  // namespace parallax
