#include "worker/assets/building/doors.h"

#include <algorithm>
#include <cmath>

namespace parallax {
namespace {

using namespace kernel;  // NOLINT: the modelling vocabulary of this folder.

MaterialSlot DoorLeafSlot() { return Slot("leaf", {"wood", "paint"}); }

// A rectangle of the leaf's plane that the frame leaves open.
struct Opening {
  float x0, x1, z0, z1;
};

// A bead along the four sides of an opening, on both faces of the leaf.
void AddBeads(AssetBuilder& b, const Opening& o, float t) {
  const float s = 0.011f;
  Shape beads;
  for (const float y : {0.22f * t, 0.78f * t}) {
    for (const float z : {o.z0 + 0.4f * s, o.z1 - 0.4f * s}) {
      beads.Add(Tube({Vec3f(o.x0 - 0.002f, y, z), Vec3f(o.x1 + 0.002f, y, z)}, 0.5f * s, 0, 8));
    }
    for (const float x : {o.x0 + 0.4f * s, o.x1 - 0.4f * s}) {
      beads.Add(Tube({Vec3f(x, y, o.z0 - 0.002f), Vec3f(x, y, o.z1 + 0.002f)}, 0.5f * s, 0, 8));
    }
  }
  b.Add(beads, DoorLeafSlot());
}

void AddPanel(AssetBuilder& b, const Opening& o, const DoorParams& p) {
  const float t = p.thickness_m, tongue = 0.006f;
  b.Add(Board({o.x0 - tongue, 0.34f * t, o.z0 - tongue}, {o.x1 + tongue, 0.66f * t, o.z1 + tongue},
              0.001f),
        DoorLeafSlot());
  const float in = std::min(0.045f, 0.2f * std::min(o.x1 - o.x0, o.z1 - o.z0));
  if (p.raised) {
    // The field rises towards both faces over a broad bevel.
    const BoxOptions options{.bevel_m = 0.19f * t};
    const Vec3f size(o.x1 - o.x0 - 2 * in, 0.8f * t, o.z1 - o.z0 - 2 * in);
    b.Add(RoundedBox(size, options).Moved(0.5f * (o.x0 + o.x1), 0.5f * t, 0.5f * (o.z0 + o.z1)),
          DoorLeafSlot());
  }
  AddBeads(b, o, t);
}

void AddGlass(AssetBuilder& b, const Opening& o, const DoorParams& p, const DoorParams::Row& row) {
  const float t = p.thickness_m, bar = 0.011f;
  b.Add(Board({o.x0 - 0.005f, 0.44f * t, o.z0 - 0.005f}, {o.x1 + 0.005f, 0.56f * t, o.z1 + 0.005f},
              0.0006f),
        Slot("glass", {"ClearGlass", "FrostedGlass", "TintedGlass"}));
  AddBeads(b, o, t);
  for (int i = 1; i < row.lites_x; ++i) {
    const float x = Lerp(o.x0, o.x1, static_cast<float>(i) / static_cast<float>(row.lites_x));
    b.Add(Board({x - bar, 0.12f * t, o.z0 - 0.003f}, {x + bar, 0.88f * t, o.z1 + 0.003f}, 0.004f),
          DoorLeafSlot());
  }
  for (int i = 1; i < row.lites_y; ++i) {
    const float z = Lerp(o.z0, o.z1, static_cast<float>(i) / static_cast<float>(row.lites_y));
    b.Add(Board({o.x0 - 0.003f, 0.13f * t, z - bar}, {o.x1 + 0.003f, 0.87f * t, z + bar}, 0.004f),
          DoorLeafSlot());
  }
}

void AddLouver(AssetBuilder& b, const Opening& o, const DoorParams& p) {
  const float t = p.thickness_m, pitch = 0.034f;
  const int slats = std::max(2, static_cast<int>((o.z1 - o.z0) / pitch));
  for (int i = 0; i < slats; ++i) {
    const float z = Lerp(o.z0, o.z1, (static_cast<float>(i) + 0.5f) / static_cast<float>(slats));
    b.Add(RoundedBox({o.x1 - o.x0 + 0.008f, 1.1f * t, 0.007f}, {.bevel_m = 0.0025f})
              .TurnedX(-0.62f)
              .Moved(0.5f * (o.x0 + o.x1), 0.5f * t, z),
          DoorLeafSlot());
  }
}

// On the face at y = 0 looking along +y; the lever runs along +x.
Shape HandleOn(DoorHandle style) {
  Shape out;
  if (style == DoorHandle::kPull) {
    out = Board({-0.02f, -0.001f, -0.12f}, {0.02f, 0.003f, 0.12f}, 0.001f);
    out.Add(
        Tube(Filleted(Path3{{0, 0, -0.08f}, {0, 0.05f, -0.08f}, {0, 0.05f, 0.08f}, {0, 0, 0.08f}},
                      0.02f, 5),
             0.008f, 0, 14));
    return out;
  }
  if (style == DoorHandle::kKnob) {
    return Lathe(Spline(Path2{{0.032f, -0.001f},
                              {0.031f, 0.005f},
                              {0.014f, 0.01f},
                              {0.012f, 0.028f},
                              {0.026f, 0.042f},
                              {0.028f, 0.055f},
                              {0.017f, 0.066f},
                              {0.0005f, 0.068f}},
                        4))
        .TurnedX(-0.5f * kPi);
  }
  out = Cylinder(0.026f, 0.009f, 0.002f, 30).TurnedX(-0.5f * kPi).Moved(0, -0.001f, 0);
  out.Add(Tube(Filleted(Path3{{0, 0, 0}, {0, 0.05f, 0}, {0.12f, 0.052f, -0.002f}}, 0.018f, 5),
               0.0095f, 0.006f, 16));
  // The keyhole's own rose below.
  out.Add(Cylinder(0.02f, 0.006f, 0.0015f, 26).TurnedX(-0.5f * kPi).Moved(0, -0.001f, -0.075f));
  return out;
}

void AddFittings(AssetBuilder& b, const DoorParams& p) {
  const MaterialSlot metal = Slot("fittings", {"metal"});
  const float side = p.hinged_right ? -1.0f : 1.0f,
              x = side * (0.5f * p.width_m - 0.5f * p.stile_m), z = 1.0f;
  Shape handle = HandleOn(p.handle);
  if (side > 0) handle = handle.MirroredX();
  b.Add(handle.Moved(x, p.thickness_m, z), metal);
  b.Add(handle.MirroredY().Moved(x, 0, z), metal);
  // Latch plate on the edge, hinges on the other.
  const float edge = side * 0.5f * p.width_m;
  b.Add(Board({edge - 0.001f, 0.2f * p.thickness_m, z - 0.08f},
              {edge + 0.0012f, 0.8f * p.thickness_m, z + 0.06f}, 0.0004f),
        metal);
  for (const float t : {0.1f, 0.5f, 0.9f}) {
    b.Add(Cylinder(0.007f, 0.09f, 0.002f, 14)
              .Moved(-edge - side * 0.003f, p.thickness_m + 0.002f, t * p.height_m - 0.045f),
          metal);
  }
}

}  // namespace

Asset MakeDoor(const DoorParams& p) {
  AssetBuilder b(p.seed);
  const float w = 0.5f * p.width_m, t = p.thickness_m, bevel = 0.0025f;
  const MaterialSlot leaf = DoorLeafSlot();
  for (const float s : {-1.0f, 1.0f})
    b.Add(Board({s * (w - p.stile_m), 0, 0}, {s * w, t, p.height_m}, bevel), leaf);
  float shares = 0;
  for (const DoorParams::Row& row : p.rows) shares += row.share;
  const float open = p.height_m - p.bottom_rail_m - p.rail_m * static_cast<float>(p.rows.size());
  const float inner = w - p.stile_m, set = 0.0005f;
  // Rails a hair thinner than the stiles: faces never share a plane.
  b.Add(Board({-inner - 0.003f, set, 0.0005f}, {inner + 0.003f, t - set, p.bottom_rail_m}, bevel),
        leaf);
  float z = p.bottom_rail_m;
  for (const DoorParams::Row& row : p.rows) {
    const float high = z + open * row.share / shares;
    const bool last = &row == &p.rows.back();
    b.Add(Board({-inner - 0.003f, set, high},
                {inner + 0.003f, t - set, last ? p.height_m - 0.0005f : high + p.rail_m}, bevel),
          leaf);
    const float mullion = 0.8f * p.stile_m;
    const float each = (2 * inner - mullion * static_cast<float>(row.columns - 1)) /
                       static_cast<float>(row.columns);
    for (int c = 0; c < row.columns; ++c) {
      const float x = -inner + static_cast<float>(c) * (each + mullion);
      if (c > 0)
        b.Add(Board({x - mullion, 2 * set, z - 0.003f}, {x, t - 2 * set, high + 0.003f}, bevel),
              leaf);
      const Opening opening{x, x + each, z, high};
      switch (row.fill) {
        case DoorFill::kPanel:
          AddPanel(b, opening, p);
          break;
        case DoorFill::kGlass:
          AddGlass(b, opening, p, row);
          break;
        case DoorFill::kLouver:
          AddLouver(b, opening, p);
          break;
      }
    }
    z = high + p.rail_m;
  }
  AddFittings(b, p);
  return b.Finish(Anchor::kWall);
}

namespace {

DoorParams DrawDoor(Rng& rng) {
  DoorParams p;
  p.width_m = Draw(rng, 0.72, 0.95);
  p.height_m = Draw(rng, 1.96, 2.12);
  p.thickness_m = Draw(rng, 0.036, 0.048);
  p.stile_m = Draw(rng, 0.09, 0.125);
  p.rail_m = Draw(rng, 0.08, 0.13);
  p.bottom_rail_m = Draw(rng, 0.15, 0.24);
  p.raised = rng.Bernoulli(0.6);
  p.hinged_right = rng.Bernoulli(0.5);
  p.handle = DrawEnum<DoorHandle>(rng, static_cast<int>(DoorHandle::kCount));
  p.seed = rng.Seed();
  return p;
}

Asset SamplePanelDoor(Rng& rng) {
  DoorParams p = DrawDoor(rng);
  switch (rng.UniformInt(0, 5)) {
    case 0:  // Six panels.
      p.rows = {{.share = 1.25f, .columns = 2},
                {.share = 1.25f, .columns = 2},
                {.share = 0.45f, .columns = 2}};
      break;
    case 1:  // Four.
      p.rows = {{.share = 0.8f, .columns = 2}, {.share = 1.3f, .columns = 2}};
      break;
    case 2:  // Two, the upper one tall.
      p.rows = {{.share = 0.7f}, {.share = 1.3f}};
      break;
    case 3:  // Five across.
      p.rows = {{}, {}, {}, {}, {}};
      break;
    case 4:  // A broad one between two pairs.
      p.rows = {{.share = 1, .columns = 2}, {.share = 0.4f}, {.share = 1.2f, .columns = 2}};
      break;
    default:  // One.
      p.rows = {{}};
      break;
  }
  return MakeDoor(p);
}

Asset SampleGlassPanelDoor(Rng& rng) {
  DoorParams p = DrawDoor(rng);
  const DoorParams::Row low{.share = 0.7f, .columns = rng.UniformInt(1, 2)};
  const DoorParams::Row high{.share = Draw(rng, 1.0, 1.6),
                             .columns = 1,
                             .fill = DoorFill::kGlass,
                             .lites_x = rng.UniformInt(1, 3),
                             .lites_y = rng.UniformInt(1, 4)};
  p.rows = {low, high};
  return MakeDoor(p);
}

Asset SampleLiteDoor(Rng& rng) {
  DoorParams p = DrawDoor(rng);
  const int kind = rng.UniformInt(0, 2);
  if (kind == 0) {  // French: a grid of lites.
    p.rows = {{.fill = DoorFill::kGlass,
               .lites_x = rng.UniformInt(2, 3),
               .lites_y = rng.UniformInt(4, 5)}};
  } else if (kind == 1) {  // One pane.
    p.rows = {{.fill = DoorFill::kGlass}};
  } else {  // A row of horizontal panes.
    const int rows = rng.UniformInt(3, 5);
    p.rows.assign(static_cast<size_t>(rows), {.fill = DoorFill::kGlass});
    p.rail_m = Draw(rng, 0.05, 0.09);
  }
  return MakeDoor(p);
}

Asset SampleLouverDoor(Rng& rng) {
  DoorParams p = DrawDoor(rng);
  p.width_m = Draw(rng, 0.5, 0.8);
  p.stile_m = Draw(rng, 0.055, 0.09);
  const int kind = rng.UniformInt(0, 2);
  const DoorParams::Row louver{.fill = DoorFill::kLouver}, panel{.share = 0.7f};
  p.rows = kind == 0   ? std::vector<DoorParams::Row>{louver}
           : kind == 1 ? std::vector<DoorParams::Row>{louver, louver}
                       : std::vector<DoorParams::Row>{panel, louver};
  return MakeDoor(p);
}

}  // namespace

void RegisterDoors(std::vector<AssetClass>& classes) {
  classes.push_back({"GlassPanelDoor", "doors", Placement::kOpening, true, 0, SampleGlassPanelDoor,
                     SizeRange({0.45f, 0.05f, 1.9f}, {1.0f, 0.22f, 2.2f})});
  classes.push_back({"LiteDoor", "doors", Placement::kOpening, true, 0, SampleLiteDoor,
                     SizeRange({0.45f, 0.05f, 1.9f}, {1.0f, 0.22f, 2.2f})});
  classes.push_back({"LouverDoor", "doors", Placement::kOpening, true, 0, SampleLouverDoor,
                     SizeRange({0.45f, 0.05f, 1.9f}, {1.0f, 0.22f, 2.2f})});
  classes.push_back({"PanelDoor", "doors", Placement::kOpening, true, 0, SamplePanelDoor,
                     SizeRange({0.45f, 0.05f, 1.9f}, {1.0f, 0.22f, 2.2f})});
}

}  // namespace parallax
