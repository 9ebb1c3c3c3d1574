// Levels of detail of plants: a coarser level has fewer but larger leaves, so that a crown covers
// as much of the picture at each level.
#pragma once

#include <array>
#include <cstddef>

namespace parallax {

// Levels with their triangle counts for trees.
enum class PlantDetail {
  kNear,   // All leaves, twigs modelled: trees 60,000 to 150,000 triangles.
  kMid,    // 15,000 to 40,000.
  kFar,    // 3,000 to 8,000.
  kShell,  // 200 to 600: folded sheets as large as boughs.
};

// The level for a target edge (MakeAsset, worker/assets/detail.h): near for 0 and below 1.5 cm, mid
// below 6 cm, far below 25 cm.
PlantDetail DetailOfEdge(float target_edge_m);
// A target edge that selects the level in MakeAsset.
float EdgeOfDetail(PlantDetail detail);
// The level of the thread's scope.
PlantDetail CurrentDetail();

// The element of `each` for the level of the thread's scope: near, mid, far, shell.
template <typename T>
T ByDetail(const std::array<T, 4>& each) {
  return each[static_cast<size_t>(CurrentDetail())];
}

// One of this many leaves is kept, enlarged by its square root, so that a crown of `leaves` with
// `triangles_each` triangles stays within the level's budget.
int LeafStride(PlantDetail detail, size_t leaves, size_t triangles_each);

}  // namespace parallax
