#include "worker/assets/nature/plant_detail.h"

#include <algorithm>

#include "worker/assets/kernel/detail_scope.h"

namespace parallax {

PlantDetail DetailOfEdge(float target_edge_m) {
  if (target_edge_m < 0.015f) return PlantDetail::kNear;
  if (target_edge_m < 0.06f) return PlantDetail::kMid;
  return target_edge_m < 0.25f ? PlantDetail::kFar : PlantDetail::kShell;
}

float EdgeOfDetail(PlantDetail detail) {
  constexpr float kEdges[] = {0.0f, 0.03f, 0.12f, 0.5f};
  return kEdges[static_cast<int>(detail)];
}

PlantDetail CurrentDetail() { return DetailOfEdge(kernel::TargetEdge()); }

int LeafStride(PlantDetail detail, size_t leaves, size_t triangles_each) {
  if (detail == PlantDetail::kNear) return 1;
  constexpr size_t kMost[] = {0, 21'000, 5'000, 500};  // Triangles; wood comes on top.
  constexpr size_t kLeast[] = {1, 2, 3, 4};
  const size_t level = static_cast<size_t>(detail);
  const size_t wanted = (leaves * triangles_each + kMost[level] - 1) / kMost[level];
  return static_cast<int>(std::max(kLeast[level], wanted));
}

}  // namespace parallax
