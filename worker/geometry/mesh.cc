#include "worker/geometry/mesh.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace parallax {
namespace {

uint16_t SlotIndex(Mesh& mesh, const MaterialSlot& slot) {
  const auto found = std::find_if(mesh.slots.begin(), mesh.slots.end(),
                                  [&](const MaterialSlot& s) { return s.name == slot.name; });
  if (found != mesh.slots.end()) return static_cast<uint16_t>(found - mesh.slots.begin());
  mesh.slots.push_back(slot);
  return static_cast<uint16_t>(mesh.slots.size() - 1);
}

// Whether two triangles of sheets have the same three corners, in any order: which one rays meet
// would be random.
bool HasCoincidentSheets(const Mesh& mesh) {
  using Corner = std::array<float, 3>;
  std::vector<std::array<Corner, 3>> sheets;
  for (const Triangle& t : mesh.triangles) {
    if (!mesh.slots[t.slot].sheet) continue;
    std::array<Corner, 3> corners;
    const uint32_t vertices[3] = {t.a, t.b, t.c};
    for (size_t k = 0; k < 3; ++k) {
      const Vec3f p = mesh.positions[vertices[k]] + Vec3f::Zero();  // -0 becomes 0.
      corners[k] = {p.x(), p.y(), p.z()};
    }
    std::sort(corners.begin(), corners.end());
    sheets.push_back(corners);
  }
  std::sort(sheets.begin(), sheets.end());
  return std::adjacent_find(sheets.begin(), sheets.end()) != sheets.end();
}

}  // namespace

Box3f Mesh::Bounds() const {
  Box3f box;
  for (const Vec3f& p : positions) box.extend(p);
  return box;
}

absl::Status ValidateMesh(const Mesh& mesh) {
  const size_t count = mesh.positions.size();
  if (count == 0 || mesh.triangles.empty()) return InvalidArgument("mesh is empty");
  if (mesh.normals.size() != count || mesh.texture.size() != count || mesh.uv.size() != count) {
    return InvalidArgument("mesh arrays differ in length");
  }
  for (size_t i = 0; i < count; ++i) {
    if (!mesh.positions[i].allFinite() || !mesh.texture[i].allFinite() || !mesh.uv[i].allFinite()) {
      return InvalidArgument("vertex {} is not finite", i);
    }
    if (!(std::abs(mesh.normals[i].norm() - 1.0f) < 1e-3f)) {
      return InvalidArgument("normal {} is not unit length", i);
    }
  }
  for (const Triangle& t : mesh.triangles) {
    if (std::max({t.a, t.b, t.c}) >= count) {
      return InvalidArgument("triangle index out of range");
    }
    if (t.slot >= mesh.slots.size()) return InvalidArgument("slot index out of range");
  }
  if (HasCoincidentSheets(mesh)) {
    return InvalidArgument("two triangles of sheets have the same corners");
  }
  return absl::OkStatus();
}

void Append(Mesh& mesh, const Mesh& part, const Eigen::Affine3f& mesh_from_part) {
  const uint32_t base = static_cast<uint32_t>(mesh.positions.size());
  const Mat3f normal_matrix = mesh_from_part.linear().inverse().transpose();
  const bool flipped = mesh_from_part.linear().determinant() < 0;
  for (const Vec3f& p : part.positions) mesh.positions.push_back(mesh_from_part * p);
  for (const Vec3f& n : part.normals) mesh.normals.push_back((normal_matrix * n).normalized());
  mesh.texture.insert(mesh.texture.end(), part.texture.begin(), part.texture.end());
  mesh.uv.insert(mesh.uv.end(), part.uv.begin(), part.uv.end());
  std::vector<uint16_t> slot_of;
  for (const MaterialSlot& slot : part.slots) slot_of.push_back(SlotIndex(mesh, slot));
  for (Triangle t : part.triangles) {
    if (flipped) std::swap(t.b, t.c);
    mesh.triangles.push_back({t.a + base, t.b + base, t.c + base, slot_of[t.slot]});
  }
}

}  // namespace parallax
