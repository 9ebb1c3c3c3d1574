#include <algorithm>
#include <cmath>

#include "worker/assets/furniture/chair_kinds.h"

namespace parallax {
namespace {

using namespace kernel;  // NOLINT: the modelling vocabulary of this folder.

// Height of the seat's tube.
float TubeHeight(const ChairParams& p) { return p.seat_height_m - 0.03f; }

// The tube goes from the back's top over the seat to the floor and back, and the same way up.
void AddBentTube(AssetBuilder& b, const ChairParams& p) {
  const float w = 0.5f * p.width_m, d = 0.5f * p.depth_m, h = TubeHeight(p), r = 0.0125f;
  const Path3 half{{w, -d - p.lean_m, p.back_height_m},
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
}

void AddPads(AssetBuilder& b, const ChairParams& p, const Noise& noise) {
  const float w = 0.5f * p.width_m, d = 0.5f * p.depth_m, h = TubeHeight(p);
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
}

void AddTubeArms(AssetBuilder& b, const ChairParams& p) {
  const float w = 0.5f * p.width_m, d = 0.5f * p.depth_m, h = TubeHeight(p), az = h + 0.21f;
  const Path3 arm{{w, -d - p.lean_m * (az - h) / (p.back_height_m - h), az},
                  {w + 0.004f, d - 0.03f, az},
                  {w, d - 0.02f, h + 0.002f}};
  b.AddMirroredX(Tube(Filleted(arm, 0.06f, 6), 0.011f, 0, 14), MetalSlot("frame"));
  b.AddMirroredX(
      Board({w - 0.02f, -d + 0.06f, az + 0.006f}, {w + 0.024f, d - 0.07f, az + 0.028f}, 0.008f),
      Slot("armrest", {"wood", "plastic"}));
}

}  // namespace

void AddCantileverChair(AssetBuilder& b, const ChairParams& p, const Noise& noise) {
  AddBentTube(b, p);
  AddPads(b, p, noise);
  if (p.arms) AddTubeArms(b, p);
}

}  // namespace parallax
