// Beds and what lies on them.
#include <algorithm>
#include <cmath>

#include "worker/assets/asset_families.h"
#include "worker/assets/furniture/bed_parts.h"

namespace parallax {
namespace {

using namespace kernel;  // NOLINT: the modelling vocabulary of this folder.

// Dimensions and slot of the rails, which follow the headboard's kind.
struct RailKind {
  explicit RailKind(const BedParams& p)
      : soft(p.headboard == HeadboardStyle::kUpholstered || p.headboard == HeadboardStyle::kTufted),
        metal(p.headboard == HeadboardStyle::kMetal),
        thick(soft ? 0.05f : 0.028f),
        low(p.frame_top_m - (metal ? 0.05f : 0.18f)),
        slot(soft    ? FabricSlot("headboard")
             : metal ? MetalSlot("frame_metal")
                     : WoodSlot("frame")) {}
  bool soft, metal;
  float thick, low;  // Thickness, lower edge.
  MaterialSlot slot;
};

void AddRails(AssetBuilder& b, const BedParams& p, const BedLayout& l, const RailKind& rail) {
  const float thick = rail.thick, low = rail.low, edge = rail.soft ? 0.018f : 0.004f;
  b.AddMirroredX(
      Board({l.x, l.head - 0.01f, low}, {l.x + thick, l.foot + thick, p.frame_top_m}, edge),
      rail.slot);
  b.Add(Board({-l.x, l.foot, low}, {l.x, l.foot + thick, p.frame_top_m}, edge), rail.slot);
  b.Add(Board({-l.x, l.head - 0.02f, low}, {l.x, l.head, p.frame_top_m - 0.02f}, 0.003f),
        rail.slot);
}

// Legs at the foot, below the middle, and at the head where no headboard stands.
void AddBedLegs(AssetBuilder& b, const BedParams& p, const BedLayout& l, float low) {
  const MaterialSlot legs = Slot("legs", {"wood", "metal"});
  const float lx = l.x - 0.02f, ly = l.foot - 0.03f;
  b.AddMirroredX(FurnitureLeg(p.legs, {lx, ly, 0}, {lx, ly, low + 0.03f}, 0.06f, 0), legs);
  if (p.headboard == HeadboardStyle::kNone)
    b.AddMirroredX(
        FurnitureLeg(p.legs, {lx, l.head + 0.05f, 0}, {lx, l.head + 0.05f, low + 0.03f}, 0.06f, 0),
        legs);
  b.Add(FurnitureLeg(LegStyle::kSquare, {0, 0, 0}, {0, 0, l.slats - 0.02f}, 0.05f, 0), legs);
}

// Middle beam, ledgers along the rails, and sprung slats.
void AddSlats(AssetBuilder& b, const BedLayout& l) {
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
}

// A hoop with rods, or a panel between posts; soft beds have none.
void AddFootboard(AssetBuilder& b, const BedParams& p, const BedLayout& l, const RailKind& rail) {
  const float w = l.x + rail.thick, y = l.foot + rail.thick, top = p.frame_top_m + 0.28f;
  if (rail.metal) {
    b.Add(Tube(Filleted(Path3{{-w, y, 0}, {-w, y, top}, {w, y, top}, {w, y, 0}}, 0.1f, 8), 0.014f,
               0.003f, 16),
          rail.slot);
    for (int i = 1; i < 10; ++i) {
      const float at = 2 * w * static_cast<float>(i) / 10.0f - w;
      b.Add(Tube({{at, y, rail.low + 0.02f}, {at, y, top}}, 0.006f, 0, 10), rail.slot);
    }
    b.Add(Tube({{-w, y, rail.low + 0.02f}, {w, y, rail.low + 0.02f}}, 0.01f), rail.slot);
  } else if (!rail.soft) {
    b.AddMirroredX(Board({w - 0.05f, y - 0.006f, 0}, {w, y + 0.044f, top}, 0.005f), rail.slot);
    b.Add(Front(FrontStyle::kShaker, 2 * w - 0.1f, top - 0.24f, 0.03f, false)
              .Moved(0, y + 0.003f, 0.2f),
          rail.slot);
    b.Add(Board({-w - 0.01f, y - 0.012f, top}, {w + 0.01f, y + 0.05f, top + 0.022f}, 0.007f),
          rail.slot);
  }
}

void AddBedFrame(AssetBuilder& b, const BedParams& p, const BedLayout& l) {
  const RailKind rail(p);
  AddRails(b, p, l, rail);
  AddBedLegs(b, p, l, rail.low);
  AddSlats(b, l);
  if (p.footboard) AddFootboard(b, p, l, rail);
}

// One pillow or two against the headboard, some with a cushion in front.
void AddPillows(AssetBuilder& b, const BedParams& p, float top, Rng& rng) {
  const int pillows = p.width_m > 1.3f ? 2 : 1;
  const float pw = p.width_m > 1.3f ? 0.46f * p.width_m : 0.68f, pd = 0.46f;
  for (int i = 0; i < pillows; ++i) {
    const float x = pillows == 2 ? (i == 0 ? -0.25f : 0.25f) * p.width_m : 0.0f;
    b.Add(Pillow(pw, pd, 0.17f, {.wrinkle_m = 0.006f, .corner_pull = 0.05f}, Noise(rng))
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
}

// The cloths of a made bed. A wide duvet lies over the rails, others are tucked in beside the
// mattress above them.
struct Duvet {
  Duvet(const BedParams& p, float top, Rng& rng)
      : wide(!p.footboard && rng.Bernoulli(0.6)),
        rail(wide ? 0.13f : 0.0f),
        hang(wide ? std::min(0.3f, top - 0.12f)
                  : std::max(0.02f, 0.85f * (top - p.frame_top_m) - 0.03f)) {}
  const bool wide;
  const float rail;  // How much larger than the mattress it lies flat.
  const float hang;
};

// Hangs over both sides and the foot, and ends short of the pillows.
DrapeOptions DrapeOf(const Duvet& duvet, const BedParams& p, Rng& rng) {
  DrapeOptions d;
  d.table = {p.width_m + 0.02f + duvet.rail, p.length_m + 0.02f + duvet.rail};
  d.edge_radius_m = duvet.wide ? 0.085f : 0.05f;
  d.hang[0] = Draw(rng, 0.8, 1.15) * duvet.hang;
  d.hang[1] = Draw(rng, 0.8, 1.15) * duvet.hang;
  d.hang[2] = -0.56f - 0.5f * duvet.rail;
  d.hang[3] = Draw(rng, 0.75, 1.1) * duvet.hang;
  if (!duvet.wide) {
    for (const int side : {0, 1, 3}) d.hang[side] = duvet.hang;
  }
  d.thickness_m = 0.026f;
  d.fold_m = 0.022f;
  d.fold_size_m = 0.17f;
  d.wrinkle_m = 0.017f;
  d.wrinkle_size_m = 0.3f;
  d.target_edge_m = 0.04f;
  d.flare = duvet.wide ? 0.07f : 0.0f;
  if (!duvet.wide) d.fold_m = 0.004f;
  return d;
}

// The turned-down end of the duvet, which shows the lining.
DrapeOptions TurnedDown(const DrapeOptions& d, const Duvet& duvet, float length_m) {
  DrapeOptions f = d;
  f.hang[3] = -(length_m - 0.56f - 0.34f + 0.5f * duvet.rail);
  f.hang[2] = -0.54f - 0.5f * duvet.rail;
  f.hang[0] *= 0.96f;
  f.hang[1] *= 0.96f;
  f.thickness_m = 0.02f;
  f.edge_radius_m = d.edge_radius_m + 0.012f;
  f.table = d.table + Vec2f(0.035f, 0);
  return f;
}

// A second blanket across the foot.
DrapeOptions ThrowOver(const DrapeOptions& d, const Duvet& duvet, float length_m) {
  DrapeOptions t = d;
  t.table = d.table + Vec2f(0.035f, 0.035f);
  t.edge_radius_m = d.edge_radius_m + 0.015f;
  t.hang[2] = -(length_m - 0.75f);
  t.hang[3] = -0.22f;
  t.hang[0] = (duvet.wide ? 1.15f : 0.9f) * duvet.hang;
  t.hang[1] = (duvet.wide ? 1.1f : 0.9f) * duvet.hang;
  t.thickness_m = 0.013f;
  return t;
}

void AddBedding(AssetBuilder& b, const BedParams& p, const BedLayout& l) {
  const Noise noise(p.seed);
  const float top = l.slats + p.mattress_m;
  Rng rng(SceneSeed{p.seed}, "bedding");
  AddPillows(b, p, top, rng);
  const Duvet duvet(p, top, rng);
  const DrapeOptions drape = DrapeOf(duvet, p, rng);
  b.Add(Drape(drape, noise).Moved(0, 0, top - 0.001f), FabricSlot("duvet"));
  if (p.folded_blanket)
    b.Add(Drape(TurnedDown(drape, duvet, p.length_m), noise).Moved(0, 0, top + 0.025f),
          Slot("sheet", {"fabric"}));
  if (p.throw_blanket)
    b.Add(Drape(ThrowOver(drape, duvet, p.length_m), noise).Moved(0, 0, top + 0.027f),
          Slot("throw", {"fabric"}));
}

// The head is at -y, so the foot faces +y.
Asset MakeBed(const BedParams& p) {
  AssetBuilder b(p.seed);
  const BedLayout layout(p);
  AddBedFrame(b, p, layout);
  AddHeadboard(b, p, layout);
  if (p.mattress) {
    b.Add(MattressBody({.width_m = p.width_m,
                        .length_m = p.length_m,
                        .height_m = p.mattress_m,
                        .top = p.bedding ? MattressTop::kPlain : MattressTop::kLozenges,
                        .seed = p.seed})
              .Moved(0, 0, layout.slats),
          {Slot("mattress", {"fabric"}), Slot("mattress_side", {"fabric"})});
  }
  if (p.bedding) AddBedding(b, p, layout);
  return b.Finish();
}

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

Asset SampleBed(Rng& rng) { return MakeBed(DrawBed(rng)); }

Asset SampleBedFrame(Rng& rng) {
  BedParams p = DrawBed(rng);
  p.mattress = p.bedding = false;
  return MakeBed(p);
}

}  // namespace

void RegisterBeds(std::vector<AssetClass>& classes) {
  classes.push_back({"Bed", "beds", Placement::kFloorAgainstWall, true, 0.6f, SampleBed,
                     SizeRange({0.95f, 2, 0.4f}, {2.2f, 2.4f, 1.5f})});
  classes.push_back({"BedFrame", "beds", Placement::kFloorAgainstWall, true, 0.6f, SampleBedFrame,
                     SizeRange({0.95f, 2, 0.28f}, {2.05f, 2.35f, 1.45f})});
  classes.push_back({"Mattress", "beds", Placement::kFloor, true, 0.3f, SampleMattress,
                     SizeRange({0.88f, 1.85f, 0.14f}, {1.85f, 2.1f, 0.32f})});
  classes.push_back({"Pillow", "textiles", Placement::kOnTop, true, 0, SamplePillow,
                     SizeRange({0.36f, 0.3f, 0.06f}, {0.82f, 0.6f, 0.24f})});
  classes.push_back({"Blanket", "textiles", Placement::kOnTop, true, 0, SampleBlanket,
                     SizeRange({0.38f, 0.1f, 0.04f}, {0.75f, 0.65f, 0.3f})});
  classes.push_back({"Towel", "textiles", Placement::kOnTop, true, 0, SampleTowel,
                     SizeRange({0.22f, 0.07f, 0.02f}, {0.46f, 0.4f, 0.24f})});
}

}  // namespace parallax
