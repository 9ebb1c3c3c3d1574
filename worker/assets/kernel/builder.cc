#include "worker/assets/kernel/builder.h"

#include <algorithm>

namespace parallax::kernel {
namespace {

uint16_t SlotIndex(Mesh& mesh, const MaterialSlot& slot) {
  for (size_t i = 0; i < mesh.slots.size(); ++i) {
    if (mesh.slots[i].name == slot.name) return static_cast<uint16_t>(i);
  }
  mesh.slots.push_back(slot);
  return static_cast<uint16_t>(mesh.slots.size() - 1);
}

}  // namespace

void AssetBuilder::Add(const Shape& shape, std::initializer_list<MaterialSlot> slots) {
  std::vector<uint16_t> indices;
  for (const MaterialSlot& slot : slots) indices.push_back(SlotIndex(asset_.mesh, slot));
  // Within the few metres that solid textures repeat over, no two parts show the same piece.
  const float x = static_cast<float>(offsets_.Uniform(-20, 20));
  const float y = static_cast<float>(offsets_.Uniform(-20, 20));
  const float z = static_cast<float>(offsets_.Uniform(-20, 20));
  AppendShape(asset_.mesh, shape, indices, {x, y, z});
}

void AssetBuilder::AddMirroredX(const Shape& shape, const MaterialSlot& slot) {
  Add(shape, slot);
  Add(shape.MirroredX(), slot);
}

void AssetBuilder::AddFourfold(const Shape& shape, const MaterialSlot& slot) {
  AddMirroredX(shape, slot);
  AddMirroredX(shape.MirroredY(), slot);
}

void AssetBuilder::Support(const Vec2f& lo, const Vec2f& hi, float z_m, float clearance_m) {
  asset_.supports.push_back({Box2f(lo, hi), z_m, clearance_m});
}

Asset AssetBuilder::Finish(Anchor anchor) {
  const Box3f box = asset_.mesh.Bounds();
  Vec3f shift = -box.center();
  shift.z() = anchor == Anchor::kCeiling ? -box.max().z() : -box.min().z();
  if (anchor == Anchor::kWall) shift.y() = -box.min().y();
  if (anchor == Anchor::kGround) shift.head<2>().setZero();
  for (Vec3f& p : asset_.mesh.positions) p += shift;
  for (SupportSurface& s : asset_.supports) {
    s.area.translate(shift.head<2>());
    s.z_m += shift.z();
  }
  return std::move(asset_);
}

}  // namespace parallax::kernel
