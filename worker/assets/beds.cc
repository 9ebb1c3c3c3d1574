#include "worker/assets/beds.h"

#include <algorithm>
#include <cmath>

namespace parallax {
namespace {

using namespace kernel;  // NOLINT: the modelling vocabulary of this folder.

// How far the top is drawn down at a point: 0 where it swells most. Metres.
float TopRelief(MattressTop top, const Vec2f& q) {
  switch (top) {
    case MattressTop::kLozenges: {
      const float pitch = 0.17f;
      const float a = std::sin(kPi * (q.x() + q.y()) / pitch),
                  c = std::sin(kPi * (q.x() - q.y()) / pitch);
      return 0.016f * (std::pow(std::abs(a * c), 0.4f) - 1.0f);
    }
    case MattressTop::kTufts: {
      const float pitch = 0.24f;  // Distance between buttons.
      const Vec2f cell = q / pitch;
      const Vec2f off = (cell - Vec2f(std::round(cell.x()), std::round(cell.y()))) * pitch;
      return -0.03f * std::exp(-off.squaredNorm() / (0.045f * 0.045f));
    }
    case MattressTop::kChannels:
      return 0.014f * (std::pow(std::abs(std::sin(kPi * q.y() / 0.16f)), 0.4f) - 1.0f);
    default:
      return 0;
  }
}

// Buttons in the tufts' pits.
Shape TuftButtons(const MattressParams& p) {
  const float pitch = 0.24f;
  Shape buttons;
  const int nx = static_cast<int>((0.5f * p.width_m - 0.1f) / pitch),
            ny = static_cast<int>((0.5f * p.length_m - 0.1f) / pitch);
  for (int i = -nx; i <= nx; ++i) {
    for (int j = -ny; j <= ny; ++j) {
      buttons.Add(Ball(0.011f, 10)
                      .Moved(pitch * static_cast<float>(i), pitch * static_cast<float>(j),
                             p.height_m - 0.024f));
    }
  }
  return buttons;
}

// Webbing loops on the long sides.
Shape CarryStraps(const MattressParams& p) {
  Shape straps;
  const float z = 0.5f * p.height_m, half = 0.09f;
  for (int k = 0; k < p.straps; ++k) {
    const float y =
        p.length_m * ((static_cast<float>(k) + 0.5f) / static_cast<float>(p.straps) - 0.5f);
    for (const float s : {-1.0f, 1.0f}) {
      const float x = 0.5f * p.width_m;
      SweepOptions options;
      options.up = Vec3f::UnitZ();
      options.keep_up = true;
      straps.Add(Sweep(Spline(Path3{{s * (x - 0.002f), y - half, z},
                                    {s * (x + 0.006f), y - 0.6f * half, z},
                                    {s * (x + 0.009f), y, z - 0.004f},
                                    {s * (x + 0.006f), y + 0.6f * half, z},
                                    {s * (x - 0.002f), y + half, z}},
                              4),
                       RectSection(0.004f, 0.03f, 0.0015f, 2), options));
    }
  }
  return straps;
}

// Mattress with rounded edges, two cords and a worked top; its sides are group 1. Underside at
// z = 0.
Shape MattressBody(const MattressParams& p) {
  const Noise noise(p.seed);
  BoxOptions box;
  box.bevel_m = 0.045f;
  box.bevel_steps = 3;
  const bool worked = p.top != MattressTop::kPlain;
  box.pieces = {worked ? static_cast<int>(p.width_m / 0.03f) : 24,
                worked ? static_cast<int>(p.length_m / 0.03f) : 28, 2};
  const float hx = 0.5f * p.width_m, hy = 0.5f * p.length_m, hz = 0.5f * p.height_m;
  Shape shape = RoundedBox({p.width_m, p.length_m, p.height_m}, box).Bent([&](const Vec3f& q) {
    Vec3f r = q;
    const float inside =
        Smooth01((hx - std::abs(q.x())) / 0.12f) * Smooth01((hy - std::abs(q.y())) / 0.12f);
    if (q.z() > 0.2f * hz) {
      r.z() += inside * TopRelief(p.top, q.head<2>());
      r.z() += 0.006f * inside + 0.004f * noise.At(q * 2.0f);
    }
    return r;
  });
  for (size_t i = 0; i < shape.points.size(); ++i) shape.texture[i] = shape.points[i];
  for (Face& face : shape.faces) {
    float high = 0;
    for (int c = 0; c < face.corners; ++c)
      high = std::max(high, std::abs(shape.points[static_cast<size_t>(face.v[c])].z()));
    face.group = high < hz - 0.03f ? 1 : 0;
  }
  for (const float s : {-1.0f, 1.0f}) {
    Path3 cord;
    const float drop = 0.013f;
    for (const Vec2f& q : RectSection(p.width_m - 2 * drop, p.length_m - 2 * drop, 0.045f, 5))
      cord.emplace_back(q.x(), q.y(), s * (hz - drop));
    shape.Add(Ring(cord, 0.006f));
  }
  return shape.Moved(0, 0, hz);
}

struct BedLayout {
  explicit BedLayout(const BedParams& p)
      : x(0.5f * p.width_m + 0.012f),
        head(-0.5f * p.length_m - 0.015f),
        foot(0.5f * p.length_m + 0.015f),
        slats(p.frame_top_m - 0.09f) {}
  float x, head, foot, slats;  // Inside of the side rails; y of head and foot; top of the slats.
};

void AddHeadboard(AssetBuilder& b, const BedParams& p, const BedLayout& l, const Noise& noise) {
  const MaterialSlot wood = WoodSlot("frame"), cloth = FabricSlot("headboard");
  const float w = l.x + 0.03f, t = 0.05f, y = l.head - t, low = 0.18f, top = p.headboard_m;
  const auto posts = [&](float height, float size) {
    b.AddMirroredX(Board({w - size, y, 0}, {w, y + size, height}, 0.005f), wood);
  };
  switch (p.headboard) {
    case HeadboardStyle::kPanel: {
      posts(top, 0.06f);
      b.Add(Board({-w - 0.015f, y - 0.01f, top}, {w + 0.015f, y + 0.07f, top + 0.028f}, 0.008f),
            wood);
      const int panels = 3;
      const float each = (2 * w - 0.12f) / panels;
      for (int i = 0; i < panels; ++i) {
        b.Add(Front(FrontStyle::kRaised, each - 0.001f, top - low, 0.03f, true)
                  .Moved(-w + 0.06f + each * (static_cast<float>(i) + 0.5f), y + 0.015f, low),
              wood);
      }
      break;
    }
    case HeadboardStyle::kSlats: {
      posts(top, 0.055f);
      b.Add(Board({-w + 0.055f, y + 0.012f, top - 0.09f}, {w - 0.055f, y + 0.042f, top - 0.01f},
                  0.004f),
            wood);
      b.Add(Board({-w + 0.055f, y + 0.012f, low}, {w - 0.055f, y + 0.042f, low + 0.09f}, 0.004f),
            wood);
      const int n = static_cast<int>(2 * w / 0.12f);
      for (int i = 0; i < n; ++i) {
        const float at =
            (2 * w - 0.11f) * ((static_cast<float>(i) + 0.5f) / static_cast<float>(n) - 0.5f);
        b.Add(Board({at - 0.024f, y + 0.02f, low + 0.08f}, {at + 0.024f, y + 0.034f, top - 0.08f},
                    0.003f),
              wood);
      }
      break;
    }
    case HeadboardStyle::kArched: {
      posts(top - 0.15f, 0.06f);
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
            wood);
      b.AddMirroredX(Lathe(Spline(Path2{{0.022f, 0},
                                        {0.03f, 0.012f},
                                        {0.018f, 0.03f},
                                        {0.034f, 0.06f},
                                        {0.026f, 0.088f},
                                        {0.004f, 0.1f}},
                                  4))
                         .Moved(w - 0.03f, y + 0.03f, top - 0.151f),
                     wood);
      break;
    }
    case HeadboardStyle::kMetal: {
      const MaterialSlot metal = MetalSlot("frame_metal");
      const float r = 0.016f;
      const Path3 hoop = Filleted(
          Path3{{-w, y + 0.03f, 0}, {-w, y + 0.03f, top}, {w, y + 0.03f, top}, {w, y + 0.03f, 0}},
          0.14f, 8);
      b.Add(Tube(hoop, r, 0.003f, 16), metal);
      b.Add(Tube({{-w, y + 0.03f, 0.42f}, {w, y + 0.03f, 0.42f}}, 0.011f), metal);
      b.Add(Tube({{-w, y + 0.03f, top - 0.14f}, {w, y + 0.03f, top - 0.14f}}, 0.011f), metal);
      const int n = static_cast<int>(2 * w / 0.13f);
      for (int i = 1; i < n; ++i) {
        const float at = 2 * w * static_cast<float>(i) / static_cast<float>(n) - w;
        b.Add(Tube({{at, y + 0.03f, 0.42f}, {at, y + 0.03f, i % 2 ? top : top - 0.14f}}, 0.006f, 0,
                   10),
              metal);
        if (i % 2) b.Add(Ball(0.014f, 14).Moved(at, y + 0.03f, 0.5f * (top + 0.28f)), metal);
      }
      break;
    }
    case HeadboardStyle::kUpholstered:
    case HeadboardStyle::kTufted: {
      CushionOptions o;
      o.edge_radius_m = 0.03f;
      o.bulge_top_m = 0.012f;
      o.bulge_side_m = 0.0f;
      o.wrinkle_m = 0.0012f;
      o.target_edge_m = 0.03f;
      const bool tufted = p.headboard == HeadboardStyle::kTufted;
      const float height = top - low;
      if (tufted) {
        o.tufts_x = std::max(4, static_cast<int>(2 * w / 0.17f));
        o.tufts_y = std::max(3, static_cast<int>(height / 0.17f));
        o.tuft_depth_m = 0.03f;
        b.Add(Cushion({2 * w, height, 0.09f}, o, noise)
                  .TurnedX(-0.5f * kPi)
                  .Moved(0, y + 0.02f, low + 0.5f * height),
              cloth);
        for (int i = 0; i < o.tufts_x; ++i) {
          for (int j = 0; j < o.tufts_y; ++j) {
            b.Add(Ellipsoid({0.01f, 0.006f, 0.01f}, 8)
                      .Moved(2 * w *
                                 ((static_cast<float>(i) + 0.5f) / static_cast<float>(o.tufts_x) -
                                  0.5f),
                             y + 0.054f,
                             low + height * (static_cast<float>(j) + 0.5f) /
                                       static_cast<float>(o.tufts_y)),
                  cloth);
          }
        }
      } else {
        const int panels = std::max(2, static_cast<int>(std::lround(w / 0.3f)));
        const float each = 2 * w / static_cast<float>(panels);
        for (int i = 0; i < panels; ++i) {
          b.Add(
              Cushion({each - 0.002f, height, 0.085f}, o, Noise(p.seed + static_cast<uint64_t>(i)))
                  .TurnedX(-0.5f * kPi)
                  .Moved(-w + each * (static_cast<float>(i) + 0.5f), y + 0.015f,
                         low + 0.5f * height),
              cloth);
        }
      }
      b.AddMirroredX(Board({w - 0.1f, y - 0.025f, 0}, {w - 0.04f, y + 0.03f, low + 0.05f}, 0.004f),
                     wood);
      break;
    }
    default:
      break;
  }
}

void AddFrame(AssetBuilder& b, const BedParams& p, const BedLayout& l, const Noise& noise) {
  const bool soft =
      p.headboard == HeadboardStyle::kUpholstered || p.headboard == HeadboardStyle::kTufted;
  const bool metal = p.headboard == HeadboardStyle::kMetal;
  const MaterialSlot rail_slot =
      soft ? FabricSlot("headboard") : (metal ? MetalSlot("frame_metal") : WoodSlot("frame"));
  const float thick = soft ? 0.05f : 0.028f, low = p.frame_top_m - (metal ? 0.05f : 0.18f),
              edge = soft ? 0.018f : 0.004f;
  b.AddMirroredX(
      Board({l.x, l.head - 0.01f, low}, {l.x + thick, l.foot + thick, p.frame_top_m}, edge),
      rail_slot);
  b.Add(Board({-l.x, l.foot, low}, {l.x, l.foot + thick, p.frame_top_m}, edge), rail_slot);
  b.Add(Board({-l.x, l.head - 0.02f, low}, {l.x, l.head, p.frame_top_m - 0.02f}, 0.003f),
        rail_slot);
  const MaterialSlot legs = Slot("legs", {"wood", "metal"});
  const float lx = l.x - 0.02f, ly = l.foot - 0.03f;
  b.AddMirroredX(FurnitureLeg(p.legs, {lx, ly, 0}, {lx, ly, low + 0.03f}, 0.06f, 0), legs);
  if (p.headboard == HeadboardStyle::kNone)
    b.AddMirroredX(
        FurnitureLeg(p.legs, {lx, l.head + 0.05f, 0}, {lx, l.head + 0.05f, low + 0.03f}, 0.06f, 0),
        legs);
  b.Add(FurnitureLeg(LegStyle::kSquare, {0, 0, 0}, {0, 0, l.slats - 0.02f}, 0.05f, 0), legs);
  // Middle beam and sprung slats.
  const MaterialSlot slats = WoodSlot("slats");
  b.Add(Board({-0.02f, l.head, l.slats - 0.06f}, {0.02f, l.foot, l.slats - 0.018f}, 0.002f), slats);
  b.AddMirroredX(
      Board({l.x - 0.025f, l.head, l.slats - 0.05f}, {l.x, l.foot, l.slats - 0.018f}, 0.002f),
      slats);
  const int n = 13;
  for (int i = 0; i < n; ++i) {
    const float y = Lerp(l.head + 0.08f, l.foot - 0.08f, static_cast<float>(i) / (n - 1));
    b.Add(Board({-l.x + 0.004f, y - 0.035f, l.slats - 0.018f}, {l.x - 0.004f, y + 0.035f, l.slats},
                0.003f),
          slats);
  }
  if (p.footboard) {
    const float w = l.x + thick, y = l.foot + thick, top = p.frame_top_m + 0.28f;
    if (metal) {
      b.Add(Tube(Filleted(Path3{{-w, y, 0}, {-w, y, top}, {w, y, top}, {w, y, 0}}, 0.1f, 8), 0.014f,
                 0.003f, 16),
            rail_slot);
      for (int i = 1; i < 10; ++i) {
        const float at = 2 * w * static_cast<float>(i) / 10.0f - w;
        b.Add(Tube({{at, y, low + 0.02f}, {at, y, top}}, 0.006f, 0, 10), rail_slot);
      }
      b.Add(Tube({{-w, y, low + 0.02f}, {w, y, low + 0.02f}}, 0.01f), rail_slot);
    } else if (!soft) {
      b.AddMirroredX(Board({w - 0.05f, y - 0.006f, 0}, {w, y + 0.044f, top}, 0.005f), rail_slot);
      b.Add(Front(FrontStyle::kShaker, 2 * w - 0.1f, top - 0.24f, 0.03f, false)
                .Moved(0, y + 0.003f, 0.2f),
            rail_slot);
      b.Add(Board({-w - 0.01f, y - 0.012f, top}, {w + 0.01f, y + 0.05f, top + 0.022f}, 0.007f),
            rail_slot);
    }
  }
  AddHeadboard(b, p, l, noise);
}

void AddBedding(AssetBuilder& b, const BedParams& p, const BedLayout& l, const Noise& noise) {
  const float top = l.slats + p.mattress_m;
  Rng rng(SceneSeed{p.seed}, "bedding");
  const int pillows = p.width_m > 1.3f ? 2 : 1;
  const float pw = p.width_m > 1.3f ? 0.46f * p.width_m : 0.68f, pd = 0.46f;
  for (int i = 0; i < pillows; ++i) {
    const float x = pillows == 2 ? (i == 0 ? -0.25f : 0.25f) * p.width_m : 0.0f;
    PillowOptions o;
    o.wrinkle_m = 0.006f;
    o.corner_pull = 0.05f;
    b.Add(Pillow(pw, pd, 0.17f, o, Noise(rng))
              .TurnedX(-0.18f)
              .TurnedZ(Draw(rng, -0.06, 0.06))
              .Moved(x + Draw(rng, -0.02, 0.02), -0.5f * p.length_m + 0.27f, top + 0.072f),
          Slot("pillows", {"fabric"}));
    if (p.folded_blanket && rng.Bernoulli(0.6)) {
      const float size = Draw(rng, 0.38, 0.44);
      b.Add(Pillow(size, size, 0.14f, {}, Noise(rng))
                .TurnedX(-0.95f)
                .TurnedZ(Draw(rng, -0.15, 0.15))
                .Moved(x + Draw(rng, -0.05, 0.05), -0.5f * p.length_m + 0.57f, top + 0.2f),
            Slot("accent", {"fabric"}));
    }
  }
  // The duvet hangs over both sides and the foot, and ends short of the pillows.
  DrapeOptions d;
  // Over the rails when it is wide, else tucked in beside the mattress above them.
  const bool wide = !p.footboard && rng.Bernoulli(0.6);
  const float rail = wide ? 0.13f : 0.0f;
  d.table = {p.width_m + 0.02f + rail, p.length_m + 0.02f + rail};
  d.edge_radius_m = wide ? 0.085f : 0.05f;
  const float hang =
      wide ? std::min(0.3f, top - 0.12f) : std::max(0.02f, 0.85f * (top - p.frame_top_m) - 0.03f);
  d.hang[0] = Draw(rng, 0.8, 1.15) * hang;
  d.hang[1] = Draw(rng, 0.8, 1.15) * hang;
  d.hang[2] = -0.56f - 0.5f * rail;
  d.hang[3] = Draw(rng, 0.75, 1.1) * hang;
  if (!wide) {
    for (const int side : {0, 1, 3}) d.hang[side] = hang;
  }
  d.thickness_m = 0.026f;
  d.fold_m = 0.022f;
  d.fold_size_m = 0.17f;
  d.wrinkle_m = 0.017f;
  d.wrinkle_size_m = 0.3f;
  d.target_edge_m = 0.04f;
  d.flare = wide ? 0.07f : 0.0f;
  if (!wide) d.fold_m = 0.004f;
  b.Add(Drape(d, noise).Moved(0, 0, top - 0.001f), FabricSlot("duvet"));
  if (p.folded_blanket) {
    // The turned-down end shows the lining.
    DrapeOptions f = d;
    f.hang[3] = -(p.length_m - 0.56f - 0.34f + 0.5f * rail);
    f.hang[2] = -0.54f - 0.5f * rail;
    f.hang[0] *= 0.96f;
    f.hang[1] *= 0.96f;
    f.thickness_m = 0.02f;
    f.edge_radius_m = d.edge_radius_m + 0.012f;
    f.table = d.table + Vec2f(0.035f, 0);
    b.Add(Drape(f, noise).Moved(0, 0, top + 0.025f), Slot("sheet", {"fabric"}));
  }
  if (p.throw_blanket) {
    DrapeOptions t = d;
    t.table = d.table + Vec2f(0.035f, 0.035f);
    t.edge_radius_m = d.edge_radius_m + 0.015f;
    t.hang[2] = -(p.length_m - 0.75f);
    t.hang[3] = -0.22f;
    t.hang[0] = (wide ? 1.15f : 0.9f) * hang;
    t.hang[1] = (wide ? 1.1f : 0.9f) * hang;
    t.thickness_m = 0.013f;
    b.Add(Drape(t, noise).Moved(0, 0, top + 0.027f), Slot("throw", {"fabric"}));
  }
}

}  // namespace

Asset MakeBed(const BedParams& p) {
  AssetBuilder b(p.seed);
  const Noise noise(p.seed);
  const BedLayout layout(p);
  AddFrame(b, p, layout, noise);
  if (p.mattress) {
    MattressParams m;
    m.width_m = p.width_m;
    m.length_m = p.length_m;
    m.height_m = p.mattress_m;
    m.top = p.bedding ? MattressTop::kPlain : MattressTop::kLozenges;
    m.seed = p.seed;
    b.Add(MattressBody(m).Moved(0, 0, layout.slats),
          {Slot("mattress", {"fabric"}), Slot("mattress_side", {"fabric"})});
  }
  if (p.bedding) AddBedding(b, p, layout, noise);
  return b.Finish();
}

namespace {

BedParams DrawBed(Rng& rng) {
  BedParams p;
  const float widths[] = {0.9f, 1.2f, 1.4f, 1.6f, 1.8f};
  p.width_m = widths[rng.UniformInt(0, 4)];
  p.length_m = Draw(rng, 1.95, 2.1);
  p.mattress_m = Draw(rng, 0.18, 0.28);
  p.frame_top_m = Draw(rng, 0.28, 0.38);
  p.headboard_m = Draw(rng, 0.9, 1.3);
  p.headboard = DrawEnum<HeadboardStyle>(rng, static_cast<int>(HeadboardStyle::kCount));
  p.footboard = rng.Bernoulli(0.35);
  p.legs = DrawEnum<LegStyle>(rng, static_cast<int>(LegStyle::kCount));
  p.folded_blanket = rng.Bernoulli(0.6);
  p.throw_blanket = rng.Bernoulli(0.4);
  p.seed = rng.Seed();
  return p;
}

}  // namespace

Asset SampleBed(Rng& rng) { return MakeBed(DrawBed(rng)); }

Asset SampleBedFrame(Rng& rng) {
  BedParams p = DrawBed(rng);
  p.mattress = p.bedding = false;
  return MakeBed(p);
}

Asset MakeMattress(const MattressParams& p) {
  AssetBuilder b(p.seed);
  b.Add(MattressBody(p), {Slot("mattress", {"fabric"}), Slot("mattress_side", {"fabric"})});
  if (p.top == MattressTop::kTufts) b.Add(TuftButtons(p), Slot("buttons", {"leather", "fabric"}));
  if (p.straps > 0) b.Add(CarryStraps(p), Slot("straps", {"fabric"}));
  return b.Finish();
}

Asset SampleMattress(Rng& rng) {
  MattressParams p;
  const float widths[] = {0.9f, 1.2f, 1.4f, 1.6f, 1.8f};
  p.width_m = widths[rng.UniformInt(0, 4)];
  p.length_m = Draw(rng, 1.9, 2.05);
  p.height_m = Draw(rng, 0.16, 0.28);
  p.top = DrawEnum<MattressTop>(rng, static_cast<int>(MattressTop::kCount));
  p.straps = rng.UniformInt(0, 3);
  p.seed = rng.Seed();
  return MakeMattress(p);
}

void RegisterBeds(std::vector<AssetClass>& classes) {
  classes.push_back({"Bed", "beds", Placement::kFloorAgainstWall, true, 0.6f, SampleBed});
  classes.push_back({"BedFrame", "beds", Placement::kFloorAgainstWall, true, 0.6f, SampleBedFrame});
  classes.push_back({"Mattress", "beds", Placement::kFloor, true, 0.3f, SampleMattress});
  classes.push_back({"Pillow", "textiles", Placement::kOnTop, true, 0, SamplePillow});
  classes.push_back({"Blanket", "textiles", Placement::kOnTop, true, 0, SampleBlanket});
  classes.push_back({"Towel", "textiles", Placement::kOnTop, true, 0, SampleTowel});
}

}  // namespace parallax
