#include "worker/scene/glass_parts.h"

#include <algorithm>

#include "worker/materials/kernel/material.h"

namespace parallax {
namespace {

bool IsGlass(const MaterialSlot& slot) {
  if (slot.emissive || slot.families.empty()) return false;
  const auto members = MaterialsOfFamily(slot.families.front());
  return !members.empty() && members.front()->family == "glass";
}

}  // namespace

absl::Status OmitGlassParts(const v1::AssetConfig& config, SceneInProgress& scene) {
  if (!config.has_glass_parts() || config.glass_parts()) return absl::OkStatus();
  for (v1::SceneObject& object : *scene.recipe.mutable_objects()) {
    if (!object.part().empty()) continue;
    ASSIGN_OR_RETURN(const PooledAsset* asset, scene.pool.Get(object.asset_class(), object.seed()));
    const std::vector<MaterialSlot>& slots = asset->mesh->slots;
    if (std::all_of(slots.begin(), slots.end(), IsGlass)) continue;
    for (const MaterialSlot& slot : slots) {
      if (IsGlass(slot)) object.add_omitted_slots(slot.name);
    }
  }
  return absl::OkStatus();
}

Mesh WithoutSlots(const Mesh& mesh, const std::vector<std::string>& omitted) {
  constexpr uint32_t kUnused = 0xffffffffu;
  std::vector<uint16_t> slot_at(mesh.slots.size(), 0);
  std::vector<bool> keeps(mesh.slots.size(), false);
  Mesh out;
  for (size_t s = 0; s < mesh.slots.size(); ++s) {
    keeps[s] = std::find(omitted.begin(), omitted.end(), mesh.slots[s].name) == omitted.end();
    if (!keeps[s]) continue;
    slot_at[s] = static_cast<uint16_t>(out.slots.size());
    out.slots.push_back(mesh.slots[s]);
  }
  if (out.slots.empty()) return mesh;
  std::vector<uint32_t> vertex_at(mesh.positions.size(), kUnused);
  const auto vertex = [&](uint32_t v) {
    if (vertex_at[v] == kUnused) {
      vertex_at[v] = static_cast<uint32_t>(out.positions.size());
      out.positions.push_back(mesh.positions[v]);
      out.normals.push_back(mesh.normals[v]);
      out.texture.push_back(mesh.texture[v]);
      out.uv.push_back(mesh.uv[v]);
    }
    return vertex_at[v];
  };
  for (const Triangle& t : mesh.triangles) {
    if (!keeps[t.slot]) continue;
    const uint32_t a = vertex(t.a), b = vertex(t.b), c = vertex(t.c);
    out.triangles.push_back({a, b, c, slot_at[t.slot]});
  }
  return out;
}

}  // namespace parallax
