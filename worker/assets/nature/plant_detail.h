// Levels of detail of plants: a coarser level has fewer but larger leaves, so that a crown covers
// as much of the picture at each level.
#pragma once

#include <array>
#include <cstddef>

namespace parallax {

// Levels of detail; counts are the triangles of a tree.
enum class PlantDetail {
  kNear,   // All leaves, twigs modelled: trees 60,000 to 150,000 triangles.
  kMid,    // 15,000 to 40,000.
  kFar,    // 3,000 to 8,000.
  kShell,  // 200 to 600: folded sheets as large as boughs.
};

// Returns the level for a target edge length (see MakeAsset): near for 0 and below 1.5 cm, mid
// below 6 cm, far below 25 cm, else shell.
PlantDetail DetailOfEdge(float target_edge_m);
// Returns a target edge length that selects this level.
float EdgeOfDetail(PlantDetail detail);
// Returns the level that the calling thread's DetailScope selects.
PlantDetail CurrentDetail();

// Returns the element of `each`, ordered near, mid, far, shell, for CurrentDetail().
template <typename T>
T ByDetail(const std::array<T, 4>& each) {
  return each[static_cast<size_t>(CurrentDetail())];
}

// Returns n, where one of n leaves is to be kept, with its length enlarged by the square root of n,
// so that a crown of `leaves` leaves of `triangles_each` triangles stays within the level's budget.
int LeafStride(PlantDetail detail, size_t leaves, size_t triangles_each);

}  // namespace parallax
