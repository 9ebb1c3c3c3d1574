#include "worker/layout/plan/openings.h"

#include <algorithm>
#include <cmath>

#include "common/base/rng.h"
#include "worker/assets/building/doors.h"
#include "worker/assets/building/windows.h"
#include "worker/layout/plan/part_builder.h"
#include "worker/layout/plan/wall_frame.h"

namespace parallax {
namespace {

using Grain = PartBuilder::Grain;

struct Span {
  float left, right, bottom, top;
};

Span SpanOf(const WallFrame& frame, const v1::Opening& opening) {
  const double middle = frame.LocalOf(opening.center_m());
  return {static_cast<float>(middle - opening.width_m() / 2),
          static_cast<float>(middle + opening.width_m() / 2), static_cast<float>(opening.sill_m()),
          static_cast<float>(opening.sill_m() + opening.height_m())};
}

// Two uprights and a head around the opening at one face of the wall; y from `from` to `to`.
void AddCasing(PartBuilder& builder, uint16_t slot, const Span& s, float width, float from,
               float to, bool with_bottom) {
  const float reveal = 0.008f, bevel = 0.004f;
  const float bottom = with_bottom ? s.bottom - width + reveal : s.bottom;
  builder.Box(slot, {s.left - width + reveal, from, bottom}, {s.left + reveal, to, s.top - reveal},
              bevel, Grain::kZ);
  builder.Box(slot, {s.right - reveal, from, bottom},
              {s.right + width - reveal, to, s.top - reveal}, bevel, Grain::kZ);
  builder.Box(slot, {s.left - width + reveal, from, s.top - reveal},
              {s.right + width - reveal, to, s.top + width - reveal}, bevel, Grain::kX);
}

void AddLever(PartBuilder& builder, uint16_t slot, const Vec3f& at, float side, float towards) {
  const Vec3f out(0, side, 0);
  builder.Cylinder(slot, at, at + 0.008f * out, 0.026f, 28);
  builder.Cylinder(slot, at + 0.004f * out, at + 0.052f * out, 0.009f, 16);
  const Vec3f pivot = at + 0.048f * out;
  builder.Cylinder(slot, pivot - Vec3f(0.01f * towards, 0, 0), pivot + Vec3f(0.12f * towards, 0, 0),
                   0.009f, 16);
  const Vec3f lock = at - Vec3f(0, 0, 0.075f);
  builder.Cylinder(slot, lock, lock + 0.007f * out, 0.02f, 24);
}

// The leaf in its own frame: x from the hinge, y through (0 = face into the room, -thickness), z
// up.
void AddLeaf(PartBuilder& builder, Rng& rng, float width, float height) {
  const uint16_t leaf = builder.Slot("leaf", {"paint", "wood"});
  const float thick = 0.042f, stile = Draw(rng, 0.09, 0.13), rail = Draw(rng, 0.1, 0.15);
  const float kick = rail + Draw(rng, 0.03, 0.12);
  const int rows = rng.UniformInt(1, 4);
  const int columns = rows == 1 ? 1 : rng.UniformInt(1, 2);
  const bool raised = rng.Bernoulli(0.7);
  const float bevel = 0.003f;
  // Stiles run through; rails and panels stand between them.
  for (const float x : {0.0f, width - stile}) {
    builder.Box(leaf, {x, -thick, 0}, {x + stile, 0, height}, bevel, Grain::kZ);
  }
  const float inner = width - 2 * stile;
  const float mid = columns == 2 ? stile * 0.9f : 0.0f;
  const float panel_width = (inner - mid) / static_cast<float>(columns);
  // A low lock rail splits most doors unevenly.
  std::vector<float> heights(static_cast<size_t>(rows), 1.0f);
  if (rows >= 2) heights.back() = Draw(rng, 0.5, 1.0);
  float total = 0;
  for (const float h : heights) total += h;
  const float free_height = height - kick - rail * static_cast<float>(rows);
  builder.Box(leaf, {stile, -thick, 0}, {width - stile, 0, kick}, bevel, Grain::kX);
  float z = kick;
  for (int row = 0; row < rows; ++row) {
    const float panel_height = free_height * heights[static_cast<size_t>(row)] / total;
    for (int column = 0; column < columns; ++column) {
      const float x = stile + static_cast<float>(column) * (panel_width + mid);
      // Panels sit in a groove: they reach a little into stiles and rails.
      const float tuck = 0.006f;
      builder.Box(leaf, {x - tuck, -thick + 0.012f, z - tuck},
                  {x + panel_width + tuck, -0.012f, z + panel_height + tuck}, 0, Grain::kZ);
      if (raised) {
        const float edge = 0.035f;
        builder.Box(leaf, {x + edge, -thick + 0.004f, z + edge},
                    {x + panel_width - edge, -0.004f, z + panel_height - edge}, 0.007f, Grain::kZ);
      }
    }
    if (mid > 0) {
      builder.Box(leaf, {stile + panel_width, -thick, z},
                  {stile + panel_width + mid, 0, z + panel_height}, bevel, Grain::kZ);
    }
    z += panel_height;
    builder.Box(leaf, {stile, -thick, z}, {width - stile, 0, row + 1 == rows ? height : z + rail},
                bevel, Grain::kX);
    z += rail;
  }
  const uint16_t handle = builder.Slot("handle", {"metal"});
  const Vec3f knob(width - 0.06f, 0, 1.02f);
  AddLever(builder, handle, knob, 1.0f, -1.0f);
  AddLever(builder, handle, knob - Vec3f(0, thick, 0), -1.0f, -1.0f);
  for (const float hinge : {0.22f, height - 0.22f}) {
    builder.Cylinder(handle, {-0.004f, -thick - 0.006f, hinge - 0.05f},
                     {-0.004f, -thick - 0.006f, hinge + 0.05f}, 0.007f, 12);
  }
}

enum class LeafStyle { kPlain, kGlassPanel, kLites, kLouver };

LeafStyle StyleOf(const v1::Opening& opening) {
  const double u = Rng(SceneSeed{opening.seed()}, "leaf style").Uniform();
  // Nobody looks through a door into the street, or into a bathroom.
  if (opening.leads_to() == 0 || u < 0.55) return LeafStyle::kPlain;
  return u < 0.72 ? LeafStyle::kGlassPanel : u < 0.86 ? LeafStyle::kLites : LeafStyle::kLouver;
}

// A leaf of the catalogue in the frame of AddLeaf.
Mesh MakeCatalogueLeaf(LeafStyle style, Rng rng, float width, float height) {
  DoorParams p;
  p.width_m = width;
  p.height_m = height;
  p.thickness_m = 0.042f;
  p.stile_m = Draw(rng, 0.09, 0.12);
  p.rail_m = Draw(rng, 0.08, 0.12);
  p.bottom_rail_m = Draw(rng, 0.15, 0.24);
  p.handle = DoorHandle::kLever;
  p.seed = rng.Seed();
  const int columns = rng.UniformInt(1, 2), lites_x = rng.UniformInt(1, 3);
  const int lites_y = rng.UniformInt(1, 4);
  const float share = Draw(rng, 1.0, 1.6);
  switch (style) {
    case LeafStyle::kGlassPanel:
      p.rows = {{.share = 0.7f, .columns = columns},
                {.share = share, .fill = DoorFill::kGlass, .lites_x = lites_x, .lites_y = lites_y}};
      break;
    case LeafStyle::kLites:
      p.rows = {{.fill = DoorFill::kGlass, .lites_x = lites_x, .lites_y = lites_y + 1}};
      break;
    default:
      p.rows = {{.share = 0.7f}, {.fill = DoorFill::kLouver}};
  }
  Mesh leaf = MakeDoor(p).mesh;
  for (Vec3f& v : leaf.positions) v += Vec3f(0.5f * width, -p.thickness_m, 0);
  return leaf;
}

}  // namespace

std::string LeafClassOf(const v1::Opening& opening) {
  switch (StyleOf(opening)) {
    case LeafStyle::kGlassPanel:
      return "GlassPanelDoor";
    case LeafStyle::kLites:
      return "LiteDoor";
    case LeafStyle::kLouver:
      return "LouverDoor";
    default:
      return "PanelDoor";
  }
}

Mesh MakeDoor(const v1::Room& room, const v1::Opening& opening) {
  Rng rng(SceneSeed{opening.seed()}, "door");
  const WallFrame frame = FrameOfWall(room, opening.wall());
  const Span s = SpanOf(frame, opening);
  const float wall = static_cast<float>(opening.depth_m() > 0 ? opening.depth_m() : frame.depth_m);
  PartBuilder builder;
  builder.SetFrame(frame.WorldFromWall());
  const uint16_t wood = builder.Slot("frame", {"paint", "wood"});
  const float lining = 0.028f, proud = Draw(rng, 0.012, 0.02), casing = Draw(rng, 0.055, 0.095);
  // The lining hides the cut; it reaches into the masonry so that no face lies on another.
  builder.Box(wood, {s.left - 0.004f, -wall - 0.004f, s.bottom}, {s.left + lining, 0.004f, s.top},
              0.002f, Grain::kZ);
  builder.Box(wood, {s.right - lining, -wall - 0.004f, s.bottom}, {s.right + 0.004f, 0.004f, s.top},
              0.002f, Grain::kZ);
  builder.Box(wood, {s.left - 0.004f, -wall - 0.004f, s.top - lining},
              {s.right + 0.004f, 0.004f, s.top + 0.004f}, 0.002f, Grain::kX);
  const Span clear{s.left + lining, s.right - lining, s.bottom, s.top - lining};
  AddCasing(builder, wood, clear, casing + lining, 0.001f - 0.004f, proud, false);
  AddCasing(builder, wood, clear, casing + lining, -wall - proud, -wall + 0.003f, false);

  if (opening.leads_to() > 0) {  // A strip covers the joint of the two floors.
    builder.Box(builder.Slot("threshold", {"metal", "wood"}),
                {s.left + 0.002f, -0.5f * wall - 0.032f, s.bottom - 0.01f},
                {s.right - 0.002f, -0.5f * wall + 0.032f, s.bottom + 0.0035f}, 0.002f, Grain::kX);
  }
  if (opening.kind() == v1::Opening::KIND_PASSAGE) return builder.Take();

  const bool left_hinged = rng.Bernoulli(0.5);
  // Doors between rooms stand open more often than those of the house.
  float angle = rng.Bernoulli(opening.leads_to() > 0 ? 0.5 : 0.25)
                    ? Draw(rng, 0.2, opening.leads_to() > 0 ? 1.4 : 1.2)
                    : 0.0f;
  if (opening.open_rad() > 0) angle = static_cast<float>(opening.open_rad());
  const float gap = 0.003f;
  const float width = clear.right - clear.left - 2 * gap,
              height = clear.top - clear.bottom - 0.008f;
  // The leaf's inner face stands back in the lining; the hinge is at its outer edge, so that it
  // opens outwards.
  const float back = 0.5f * wall;
  const float thick = 0.042f;
  Eigen::Affine3f hinge = Eigen::Affine3f::Identity();
  hinge.translation() = Vec3f(left_hinged ? clear.left + gap : clear.right - gap, -back - thick,
                              clear.bottom + 0.005f);
  Eigen::Affine3f leaf = Eigen::Affine3f::Identity();
  leaf.translation() = Vec3f(0, thick, 0);
  Mesh mesh = builder.Take();
  Mesh leaf_mesh;
  const LeafStyle style = StyleOf(opening);
  if (style == LeafStyle::kPlain) {
    PartBuilder leaf_builder;
    AddLeaf(leaf_builder, rng, width, height);
    leaf_mesh = leaf_builder.Take();
  } else {
    leaf_mesh = MakeCatalogueLeaf(style, rng.Child("catalogue"), width, height);
  }
  if (!left_hinged) leaf = Eigen::Scaling(-1.0f, 1.0f, 1.0f) * leaf;
  const float turn = left_hinged ? -angle : angle;
  Append(mesh, leaf_mesh,
         frame.WorldFromWall() * hinge * Eigen::AngleAxisf(turn, Vec3f::UnitZ()) * leaf);
  return mesh;
}

namespace {

// A window of the catalogue, its frame in the masonry and its casing on the wall, behind curtains
// or a blind.
Mesh MakeDressedWindow(const v1::Room& room, const v1::Opening& opening) {
  Rng rng(SceneSeed{opening.seed()}, "dressed window");
  WindowParams p;
  p.width_m = static_cast<float>(opening.width_m());
  p.height_m = static_cast<float>(opening.height_m());
  p.frame_m = Draw(rng, 0.045, 0.065);
  p.sashes = std::clamp(static_cast<int>(std::lround(p.width_m / Draw(rng, 0.6, 0.9))), 1, 4);
  p.lites_x = rng.UniformInt(1, 2);
  p.lites_y = rng.UniformInt(1, 3);
  p.sill = opening.sill_m() > 0.3;
  p.casing = true;
  // Rods need wall above the opening.
  const bool rod = opening.sill_m() + opening.height_m() + 0.2 < room.height_m() - room.cornice_m();
  const bool curtains = rod && rng.Bernoulli(0.65);
  p.dressing = curtains ? WindowDressing::kCurtains : WindowDressing::kBlind;
  p.drawn = curtains ? Draw(rng, 0.0, 0.35) : Draw(rng, 0.1, 0.6);
  p.seed = rng.Seed();
  Mesh window = MakeWindow(p).mesh;
  if (!room.window_glass()) {
    std::erase_if(window.triangles,
                  [&](const Triangle& t) { return window.slots[t.slot].name == "glass"; });
  }
  // The catalogue's windows start at their lowest point; curtains hang below the sill. The highest
  // is known: the rod's knobs, else the casing.
  const float highest = p.height_m + (curtains ? 0.126f : 0.09f);
  const float lift = highest - window.Bounds().max().z();
  const WallFrame frame = FrameOfWall(room, opening.wall());
  Eigen::Affine3f place = Eigen::Affine3f::Identity();
  constexpr float kCasingPlane_m = 0.09f;  // Which lies on the wall's face.
  place.translation() = Vec3f(static_cast<float>(frame.LocalOf(opening.center_m())),
                              -kCasingPlane_m, static_cast<float>(opening.sill_m()) + lift);
  Mesh mesh;
  Append(mesh, window, frame.WorldFromWall() * place);
  // The lining of the cut between the frame and the outer face.
  PartBuilder builder;
  builder.SetFrame(frame.WorldFromWall());
  const Span s = SpanOf(frame, opening);
  const uint16_t ledge = builder.Slot("ledge", {"stone", "metal"});
  const float wall = static_cast<float>(frame.depth_m);
  builder.Box(ledge, {s.left - 0.003f, -wall - 0.03f, s.bottom - 0.02f},
              {s.right + 0.003f, -kCasingPlane_m + 0.004f, s.bottom + 0.003f}, 0.002f, Grain::kX);
  Append(mesh, builder.Take());
  return mesh;
}

}  // namespace

bool IsDressed(const v1::Opening& opening) {
  return opening.kind() == v1::Opening::KIND_WINDOW && opening.width_m() >= 0.6 &&
         Rng(SceneSeed{opening.seed()}, "window dressing").Bernoulli(0.5);
}

Mesh MakeWindow(const v1::Room& room, const v1::Opening& opening) {
  // Thin walls have no room for the catalogue's frames.
  if (IsDressed(opening) && FrameOfWall(room, opening.wall()).depth_m > 0.12) {
    return MakeDressedWindow(room, opening);
  }
  Rng rng(SceneSeed{opening.seed()}, "window");
  const WallFrame frame = FrameOfWall(room, opening.wall());
  const Span s = SpanOf(frame, opening);
  const float wall = static_cast<float>(frame.depth_m);
  PartBuilder builder;
  builder.SetFrame(frame.WorldFromWall());
  const uint16_t slot = builder.Slot("frame", {"paint", "wood", "plastic"});
  const float bar = Draw(rng, 0.045, 0.075), deep = Draw(rng, 0.055, 0.075);
  const float outer = std::min(-wall + Draw(rng, 0.03, 0.06), -deep - 0.01f), inner = outer + deep,
              bevel = 0.005f;
  const float tuck = 0.004f;
  builder.Box(slot, {s.left - tuck, outer, s.bottom - tuck}, {s.left + bar, inner, s.top + tuck},
              bevel, Grain::kZ);
  builder.Box(slot, {s.right - bar, outer, s.bottom - tuck}, {s.right + tuck, inner, s.top + tuck},
              bevel, Grain::kZ);
  builder.Box(slot, {s.left + bar - 0.002f, outer, s.bottom - tuck},
              {s.right - bar + 0.002f, inner, s.bottom + bar}, bevel, Grain::kX);
  builder.Box(slot, {s.left + bar - 0.002f, outer, s.top - bar},
              {s.right - bar + 0.002f, inner, s.top + tuck}, bevel, Grain::kX);

  const float width = s.right - s.left, height = s.top - s.bottom;
  const int columns = std::clamp(static_cast<int>(std::lround(width / Draw(rng, 0.5, 1.1))), 1, 5);
  const int rows = rng.Bernoulli(0.45) ? std::clamp(static_cast<int>(height / 0.5f), 1, 3) : 1;
  const bool transom = rows == 1 && height > 1.1f && rng.Bernoulli(0.4);
  const float post = bar * 0.9f, slim = rows > 1 ? 0.026f : post;
  std::vector<float> uprights, bars;
  for (int i = 1; i < columns; ++i) {
    uprights.push_back(s.left + width * static_cast<float>(i) / static_cast<float>(columns));
  }
  for (int i = 1; i < rows; ++i) {
    bars.push_back(s.bottom + height * static_cast<float>(i) / static_cast<float>(rows));
  }
  if (transom) bars.push_back(s.top - 0.28f * height);
  for (const float x : uprights) {
    builder.Box(slot, {x - post / 2, outer + 0.004f, s.bottom + bar - 0.002f},
                {x + post / 2, inner - 0.004f, s.top - bar + 0.002f}, bevel, Grain::kZ);
  }
  for (const float z : bars) {
    builder.Box(slot, {s.left + bar - 0.002f, outer + 0.01f, z - slim / 2},
                {s.right - bar + 0.002f, inner - 0.01f, z + slim / 2}, bevel, Grain::kX);
  }

  // The sill board inside, with a nose over the wall.
  const float nose = Draw(rng, 0.02, 0.08), ear = Draw(rng, 0.02, 0.06);
  const uint16_t sill = builder.Slot("sill", {"stone", "wood", "paint"});
  if (s.bottom > 0.15f) {
    builder.Box(sill, {s.left - ear, -0.006f, s.bottom - 0.026f},
                {s.right + ear, nose, s.bottom + 0.004f}, 0.004f, Grain::kX);
    builder.Box(sill, {s.left - 0.003f, inner - 0.01f, s.bottom - 0.02f},
                {s.right + 0.003f, 0.0f, s.bottom + 0.003f}, 0, Grain::kX);
  }
  const uint16_t handle = builder.Slot("handle", {"metal"});
  const float x = uprights.empty() ? s.right - bar / 2 : uprights[uprights.size() / 2];
  const Vec3f at(x, inner - 0.005f, s.bottom + 0.45f * height);
  builder.Cylinder(handle, at, at + Vec3f(0, 0.035f, 0), 0.011f, 16);
  builder.Box(handle, at + Vec3f(-0.009f, 0.028f, -0.11f), at + Vec3f(0.009f, 0.042f, 0.015f),
              0.004f, Grain::kZ);
  if (room.window_glass()) {
    const uint16_t glass = builder.Slot("glass", {"glass"});
    const float middle = 0.5f * (outer + inner);
    builder.Box(glass, {s.left + bar - 0.004f, middle - 0.003f, s.bottom + bar - 0.004f},
                {s.right - bar + 0.004f, middle + 0.003f, s.top - bar + 0.004f}, 0, Grain::kX);
  }
  return builder.Take();
}

}  // namespace parallax
