#include "worker/assets/kernel/detail_scope.h"

#include <algorithm>
#include <cmath>

namespace parallax::kernel {
namespace {

thread_local float target_edge = 0;

}  // namespace

DetailScope::DetailScope(float target_edge_m) : before_(target_edge) {
  if (target_edge_m > 0) target_edge = target_edge_m;
}

DetailScope::~DetailScope() { target_edge = before_; }

float TargetEdge() { return target_edge; }

int DetailedPieces(int usual, float length_m, int least) {
  if (target_edge <= 0 || usual <= least) return usual;
  const int wanted = static_cast<int>(std::ceil(std::min(length_m / target_edge, 1e4f)));
  return std::clamp(wanted, least, 4 * usual);
}

int DetailedSegments(int usual, float radius_m) {
  if (target_edge <= 0 || usual <= 8) return usual;
  const int wanted = DetailedPieces(usual, 6.2831853f * radius_m, 8);
  return (wanted + 3) / 4 * 4;
}

float DetailedEdge(float usual_m) {
  return target_edge > 0 ? std::max(target_edge, 0.25f * usual_m) : usual_m;
}

}  // namespace parallax::kernel
