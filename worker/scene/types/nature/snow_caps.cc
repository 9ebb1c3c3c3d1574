#include "worker/scene/types/nature/snow_caps.h"

#include <algorithm>
#include <array>
#include <limits>
#include <string>
#include <unordered_map>
#include <vector>

#include "worker/assets/nature/limb.h"
#include "worker/materials/noise.h"

namespace parallax {
namespace {

// Limits of a normal's z: no snow lies below the first, all of it above the second.
constexpr float kNoSnow = 0.3f, kAllSnow = 0.75f;
// Snow falls off some twigs.
constexpr float kSnowySheets = 0.72f;
constexpr int kSmoothings = 3;
constexpr float kFilm = 0.05f;     // Share of the depth that is too thin to be seen as snow.
constexpr float kOnSheets = 0.3f;  // Share of the depth.

uint16_t SlotFor(const char* name, bool sheet, Mesh& mesh) {
  mesh.slots.push_back({name, {"Snow"}, false, sheet});
  return static_cast<uint16_t>(mesh.slots.size() - 1);
}

// Lumpy, a few of them a hand's breadth.
float Lumps(const Vec3f& p) {
  return 0.8f + 0.5f * noise::Gradient3(p / 0.11f, 77) + 0.5f * noise::Gradient3(p / 0.45f, 78);
}

bool IsWood(const MaterialSlot& slot) {
  return std::any_of(slot.families.begin(), slot.families.end(), [](const std::string& family) {
    return family.ends_with("Bark") || family.ends_with("Wood");
  });
}

// Depth of the snow on each vertex of a mesh's solid parts.
class Cover {
 public:
  Cover(const Mesh& mesh, float depth_m)
      : mesh_(mesh),
        depth_m_(depth_m),
        lies_(mesh.positions.size()),
        most_(mesh.positions.size(), std::numeric_limits<float>::max()) {
    for (size_t v = 0; v < lies_.size(); ++v) {
      lies_[v] = noise::SmoothStep(kNoSnow, kAllSnow, mesh.normals[v].z());
    }
    // Snow bridges what is rough: no rock looks through a cap in spots.
    for (int pass = 0; pass < kSmoothings; ++pass) Smooth();
    for (const Triangle& t : mesh.triangles) {
      if (IsWood(mesh.slots[t.slot])) LimitOnWood(t);
    }
  }

  float At(uint32_t v) const {
    return std::min(depth_m_ * lies_[v] * Lumps(mesh_.positions[v]), most_[v]);
  }

 private:
  // Replaces each vertex's share by the mean of its own and that of its triangles.
  void Smooth() {
    std::vector<float> sum(lies_.size(), 0.0f), count(lies_.size(), 0.0f);
    for (const Triangle& t : mesh_.triangles) {
      const float mean = (lies_[t.a] + lies_[t.b] + lies_[t.c]) / 3;
      for (const uint32_t v : {t.a, t.b, t.c}) {
        sum[v] += mean;
        count[v] += 1;
      }
    }
    for (size_t v = 0; v < lies_.size(); ++v) {
      if (count[v] > 0) lies_[v] = 0.5f * (lies_[v] + sum[v] / count[v]);
    }
  }

  // No more snow lies on a twig than it is wide.
  void LimitOnWood(const Triangle& t) {
    const Vec3f &a = mesh_.positions[t.a], &b = mesh_.positions[t.b], &c = mesh_.positions[t.c];
    const float width_m = std::min({(b - a).norm(), (c - b).norm(), (a - c).norm()});
    for (const uint32_t v : {t.a, t.b, t.c}) most_[v] = std::min(most_[v], width_m);
  }

  const Mesh& mesh_;
  const float depth_m_;
  std::vector<float> lies_;  // Share of the depth, in [0, 1].
  std::vector<float> most_;  // Metres.
};

// Copies of a mesh's vertices, moved up.
class Cap {
 public:
  Cap(Mesh& mesh, uint16_t slot)
      : mesh_(mesh),
        slot_(slot),
        first_(mesh.positions.size()),
        first_triangle_(mesh.triangles.size()) {}

  void Add(const Triangle& t, const std::array<float, 3>& depths, bool flip) {
    Triangle made{VertexFor(t.a, depths[0]), VertexFor(t.b, depths[1]), VertexFor(t.c, depths[2]),
                  slot_};
    if (flip) std::swap(made.b, made.c);
    mesh_.triangles.push_back(made);
  }
  void Finish() { SetNormals(mesh_, first_, first_triangle_); }

 private:
  uint32_t VertexFor(uint32_t from, float depth_m) {
    const auto [found, added] =
        made_.try_emplace(from, static_cast<uint32_t>(mesh_.positions.size()));
    if (added) {
      const Vec3f at = mesh_.positions[from] + Vec3f(0, 0, depth_m);
      mesh_.positions.push_back(at);
      mesh_.normals.push_back(Vec3f::UnitZ());
      mesh_.texture.push_back(at);
      const Vec2f uv = mesh_.uv[from];
      mesh_.uv.push_back(uv);
    }
    return found->second;
  }

  Mesh& mesh_;
  const uint16_t slot_;
  const size_t first_, first_triangle_;
  std::unordered_map<uint32_t, uint32_t> made_;
};

}  // namespace

void AddSnowCaps(float depth_m, Mesh& mesh) {
  if (depth_m <= 0) return;
  const size_t triangles = mesh.triangles.size();
  const Cover cover(mesh, depth_m);
  std::vector<char> is_sheet(mesh.slots.size());
  for (size_t i = 0; i < mesh.slots.size(); ++i) is_sheet[i] = mesh.slots[i].sheet;
  for (const bool sheets : {false, true}) {
    if (std::find(is_sheet.begin(), is_sheet.end(), static_cast<char>(sheets)) == is_sheet.end())
      continue;
    Cap cap(mesh, SlotFor(sheets ? "snow sheets" : "snow", sheets, mesh));
    for (size_t i = 0; i < triangles; ++i) {
      const Triangle t = mesh.triangles[i];
      if ((is_sheet[t.slot] != 0) != sheets) continue;
      const Vec3f normal = (mesh.positions[t.b] - mesh.positions[t.a])
                               .cross(mesh.positions[t.c] - mesh.positions[t.a])
                               .stableNormalized();
      if (sheets) {
        // A sheet is one whole; both of its sides may lie up.
        if (std::abs(normal.z()) < kNoSnow || mesh.uv[t.a].y() > kSnowySheets) continue;
        const float depth = kOnSheets * depth_m;
        cap.Add(t, {depth, depth, depth}, normal.z() < 0);
        continue;
      }
      const std::array<float, 3> depths = {cover.At(t.a), cover.At(t.b), cover.At(t.c)};
      if (normal.z() > 0 && std::max({depths[0], depths[1], depths[2]}) > kFilm * depth_m)
        cap.Add(t, depths, false);
    }
    cap.Finish();
  }
}

}  // namespace parallax
