#include "worker/scene/types/nature/ground/snow_caps.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "worker/assets/nature/limb.h"
#include "worker/materials/kernel/noise.h"

namespace parallax {
namespace {

// Limits of a normal's z: no snow lies below the first, all of it above the second.
constexpr float kNoSnow = 0.3f, kAllSnow = 0.75f;
// Snow falls off some twigs.
constexpr float kSnowySheets = 0.72f;
constexpr int kSmoothings = 3;
constexpr float kEdge = 0.12f;     // Snow ends where less than this share of it lies.
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

  // How far inside the snow's edge a vertex is: below 0 outside, at most 1.
  float Inside(uint32_t v) const { return (lies_[v] - kEdge) / (1 - kEdge); }
  // Depth in metres, at a vertex inside; round towards the edge.
  float At(uint32_t v) const {
    return std::min(depth_m_ * std::sqrt(Inside(v)) * Lumps(mesh_.positions[v]), most_[v]);
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

// Copies of a mesh's faces, moved up.
class Cap {
 public:
  Cap(Mesh& mesh, uint16_t slot)
      : mesh_(mesh),
        slot_(slot),
        first_(mesh.positions.size()),
        first_triangle_(mesh.triangles.size()) {}

  // Adds the whole of a triangle; `flip` turns it over.
  void AddWhole(const Triangle& t, float depth_m, bool flip) {
    Triangle made{Raised(t.a, depth_m), Raised(t.b, depth_m), Raised(t.c, depth_m), slot_};
    if (flip) std::swap(made.b, made.c);
    mesh_.triangles.push_back(made);
  }
  // Adds the part of a triangle that lies inside the snow's edge.
  void AddInside(const Triangle& t, const Cover& cover) {
    const std::array<uint32_t, 3> corners = {t.a, t.b, t.c};
    std::vector<uint32_t> part;
    for (size_t k = 0; k < 3; ++k) {
      const uint32_t one = corners[k], next = corners[(k + 1) % 3];
      const float inside = cover.Inside(one), inside_next = cover.Inside(next);
      if (inside > 0) part.push_back(Raised(one, cover.At(one)));
      if ((inside > 0) == (inside_next > 0)) continue;
      part.push_back(OnEdge(one, next, inside / (inside - inside_next)));
    }
    for (size_t k = 2; k < part.size(); ++k) {
      mesh_.triangles.push_back({part[0], part[k - 1], part[k], slot_});
    }
  }
  void Finish() { SetNormals(mesh_, first_, first_triangle_); }

 private:
  uint32_t Raised(uint32_t from, float depth_m) {
    const auto [found, added] = made_.try_emplace({from, from}, Next());
    if (added) Put(mesh_.positions[from] + Vec3f(0, 0, depth_m), mesh_.uv[from]);
    return found->second;
  }
  // Where the snow's edge crosses an edge of the mesh, at a share of the way.
  uint32_t OnEdge(uint32_t from, uint32_t to, float share) {
    const auto [found, added] = made_.try_emplace(std::minmax(from, to), Next());
    if (added) {
      const Vec3f &a = mesh_.positions[from], &b = mesh_.positions[to];
      const Vec2f &uv_a = mesh_.uv[from], &uv_b = mesh_.uv[to];
      Put(a + share * (b - a), uv_a + share * (uv_b - uv_a));
    }
    return found->second;
  }
  uint32_t Next() const { return static_cast<uint32_t>(mesh_.positions.size()); }
  // By value: both may be parts of the mesh that grows.
  void Put(Vec3f at, Vec2f uv) {
    mesh_.positions.push_back(at);
    mesh_.normals.push_back(Vec3f::UnitZ());
    mesh_.texture.push_back(at);
    mesh_.uv.push_back(uv);
  }

  Mesh& mesh_;
  const uint16_t slot_;
  const size_t first_, first_triangle_;
  std::map<std::pair<uint32_t, uint32_t>, uint32_t> made_;  // By the mesh's vertex, or two of them.
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
        cap.AddWhole(t, kOnSheets * depth_m, normal.z() < 0);
      } else if (normal.z() > 0) {
        cap.AddInside(t, cover);
      }
    }
    cap.Finish();
  }
}

}  // namespace parallax
