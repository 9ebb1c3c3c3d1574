// Leaves, petals, needles and blades of grass as open sheets of a few triangles, copied by the
// thousand into a mesh.
//
// A template lies in its own frame: it grows from the origin along +y, its upper side faces +z, and
// it is one unit long. Values; not thread-safe to write.
#pragma once

#include <vector>

#include "common/base/rng.h"
#include "worker/geometry/mesh.h"

namespace parallax {

// Outlines of leaves.
enum class LeafShape {
  kElliptic,  // Beech, most shrubs.
  kOvate,     // Birch: broad near the stalk, pointed.
  kLance,     // Willow.
  kOblong,    // Leaflets of an acacia: blunt.
  kLobed,     // Oak: rounded lobes.
  kPalmate,   // Maple: five pointed lobes.
  kBlade,     // Grass.
  kPetal,     // Broad towards its end.
};

// One sheet in its own frame.
struct SheetTemplate {
  std::vector<Vec3f> points, normals;
  std::vector<std::array<uint32_t, 3>> triangles;
  float area = 0;  // Square units of a sheet one unit long.

  uint32_t Add(const Vec3f& point);
  // Normals from the triangles, smooth over shared points, and the area.
  void Finish();
};

// The form of a leaf's blade.
struct LeafForm {
  LeafShape shape = LeafShape::kElliptic;
  float width = 0.5f;  // In lengths.
  float droop = 0.3f;  // Radians that the blade bends down by along its length.
  float fold = 0.2f;   // The halves' rise about the midrib; 0: no midrib, half of the triangles.
  int stations = 3;    // Between both ends; the outline's detail.
  float twist = 0;     // Radians about the length, from the stalk to the tip.
};
// 2 + 2 (stations - 1) triangles, doubled by a fold; palmate leaves have 11.
SheetTemplate MakeLeafTemplate(const LeafForm& form);

// A comb of needles on two folded rows along a twig (spruce, fir): `teeth` a side.
SheetTemplate MakeSprayTemplate(int teeth, float needle, float fold);

// A tuft of `count` thin needles that open from the origin into a cone about +y (pine, larch).
SheetTemplate MakeTuftTemplate(int count, float spread_rad, float width, Rng& rng);

// The placement of one sheet.
struct SheetPlace {
  Vec3f at = Vec3f::Zero();
  Vec3f along = Vec3f::UnitY();  // Any length > 0.
  Vec3f up = Vec3f::UnitZ();     // The side that the upper face leans to.
  float length_m = 0.1f;
};

// Collects the sheets of one slot. Each gets two random numbers in uv, constant over the sheet;
// foliage materials use the first to tell leaves apart.
class SheetGrower {
 public:
  SheetGrower(const MaterialSlot& slot, Rng rng);
  // Adds a sheet. One that would reach below z = 0 lies on the ground, at its own small height.
  void Add(const SheetTemplate& sheet, const SheetPlace& place);
  size_t count() const { return count_; }
  const Mesh& mesh() const { return mesh_; }

 private:
  Mesh mesh_;
  Rng rng_;
  size_t count_ = 0;
};

}  // namespace parallax
