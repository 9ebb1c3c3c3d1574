// Levels of detail of plants: what one level loses in number it gains in size, so that a crown
// covers as much of the picture at each.
#pragma once

#include <array>
#include <cstddef>

namespace parallax {

enum class PlantDetail {
  kNear,   // All leaves, twigs modelled: trees 60,000 to 150,000 triangles.
  kMid,    // 15,000 to 40,000.
  kFar,    // 3,000 to 8,000.
  kShell,  // 200 to 600: folded sheets as large as boughs.
};

// The level that a target edge (MakeAsset, worker/assets/detail.h) stands for: near for 0 and below
// 1.5 cm, mid below 6 cm, far below 25 cm.
PlantDetail DetailOfEdge(float target_edge_m);
// An edge of that level: what to ask MakeAsset for.
float EdgeOfDetail(PlantDetail detail);
// The level that the thread's scope asks for.
PlantDetail CurrentDetail();

// The number for the level that the thread's scope asks for: near, mid, far, shell.
template <typename T>
T ByDetail(const std::array<T, 4>& each) {
  return each[static_cast<size_t>(CurrentDetail())];
}

// One of so many leaves is kept, larger by the root of it, so that a crown of `leaves` with so many
// triangles each stays within what its level may have.
int LeafStride(PlantDetail detail, size_t leaves, size_t triangles_each);

}  // namespace parallax
